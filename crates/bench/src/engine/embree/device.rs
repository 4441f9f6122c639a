//! A device of Embree: its threads, and a count of its memory.

use std::ffi::{CString, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

use super::api::{Api, Handle};
use crate::failure::Failure;

/// `RTC_DEVICE_PROPERTY_VERSION`
const VERSION: i32 = 0;
/// `RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED` and `RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED`.
const NATIVE: [i32; 2] = [33, 34];

/// The memory of a device, bytes.
#[derive(Default)]
pub(super) struct Memory {
    now: AtomicIsize,
    most: AtomicIsize,
}

impl Memory {
    /// The current and the largest number of bytes.
    pub(super) fn now_and_most(&self) -> (usize, usize) {
        [&self.now, &self.most].map(|count| count.load(Ordering::Relaxed).max(0) as usize).into()
    }
}

/// The callback by which Embree reports allocations.
unsafe extern "C" fn monitor(memory: *mut c_void, bytes: isize, _: bool) -> bool {
    // SAFETY: `Device::new` passed a pointer to this type; the count is dropped after the device.
    let memory = unsafe { &*memory.cast::<Memory>() };
    let now = memory.now.fetch_add(bytes, Ordering::Relaxed) + bytes;
    memory.most.fetch_max(now, Ordering::Relaxed);
    true
}

/// A device, released when dropped.
pub(super) struct Device {
    pub(super) api: Arc<Api>,
    pub(super) handle: Handle,
    pub(super) memory: Box<Memory>,
}

// SAFETY: Embree's devices may be used from any thread.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// A device with this number of build threads.
    pub(super) fn new(api: &Arc<Api>, threads: usize) -> Result<Self, Failure> {
        Self::with_messages(api, threads, false)
    }

    /// As `new`; with `messages`, Embree prints statistics of its trees on standard output.
    pub(super) fn with_messages(api: &Arc<Api>, threads: usize, messages: bool) -> Result<Self, Failure> {
        let verbose = if messages { 2 } else { 0 };
        let isa = api.isa.map_or_else(String::new, |isa| format!(",isa={isa}"));
        // Threads are started in advance, as those of kinetree are.
        let settings = CString::new(format!("threads={threads},start_threads=1,verbose={verbose}{isa}"))?;
        // SAFETY: the text is terminated by a zero byte, and Embree copies it.
        let handle = unsafe { (api.new_device)(settings.as_ptr()) };
        if handle.is_null() {
            return Err("it gives no device on this processor".into());
        }
        let device = Self { api: Arc::clone(api), handle, memory: Box::default() };
        // SAFETY: the device is alive.
        let version = unsafe { (api.device_property)(handle, VERSION) };
        if version / 10_000 != 4 {
            return Err(format!("version 4 is needed, this is {version}").into());
        }
        let memory: *const Memory = &*device.memory;
        // SAFETY: the device is alive, and the boxed count outlives it.
        unsafe { (api.set_memory_monitor)(handle, Some(monitor), memory.cast_mut().cast()) };
        Ok(device)
    }

    /// Such as `4.4.1`.
    pub(super) fn version(&self) -> String {
        // SAFETY: the device is alive.
        let version = unsafe { (self.api.device_property)(self.handle, VERSION) };
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// Whether packets of eight and of sixteen rays fill the registers of the device, which tells
    /// the instructions that it uses.
    pub(super) fn native_packets(&self) -> [bool; 2] {
        // SAFETY: the device is alive.
        NATIVE.map(|property| unsafe { (self.api.device_property)(self.handle, property) } != 0)
    }

    /// The error of the calls since the last check, if any.
    pub(super) fn check(&self) -> Result<(), Failure> {
        // SAFETY: the device is alive.
        match unsafe { (self.api.device_error)(self.handle) } {
            0 => Ok(()),
            code => Err(format!("Embree reports error {code}").into()),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the device is alive, and this is its only owner here; scenes hold references to
        // it themselves.
        unsafe { (self.api.release_device)(self.handle) };
    }
}
