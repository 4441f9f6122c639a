//! A device of Embree: threads, and a count of its memory.

use std::ffi::{CString, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

use super::api::{Api, Handle};
use crate::failure::Failure;

/// `RTC_DEVICE_PROPERTY_VERSION`
const VERSION: i32 = 0;
/// `RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED` and the same of sixteen.
const NATIVE: [i32; 2] = [33, 34];

/// Bytes that Embree holds and held.
#[derive(Default)]
pub(super) struct Memory {
    now: AtomicIsize,
    most: AtomicIsize,
}

impl Memory {
    /// Bytes held now, and the most at a time.
    pub(super) fn now_and_most(&self) -> (usize, usize) {
        [&self.now, &self.most].map(|count| count.load(Ordering::Relaxed).max(0) as usize).into()
    }
}

/// Embree's own calling convention for its count.
unsafe extern "C" fn monitor(memory: *mut c_void, bytes: isize, _: bool) -> bool {
    // SAFETY: the pointer is the one that `Device::new` gave; the device drops its count after the
    // device itself.
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
    /// With so many threads for builds.
    pub(super) fn new(api: &Arc<Api>, threads: usize) -> Result<Self, Failure> {
        Self::with_messages(api, threads, false)
    }

    /// The same; it may tell on the standard output what its trees are like.
    pub(super) fn with_messages(api: &Arc<Api>, threads: usize, messages: bool) -> Result<Self, Failure> {
        let verbose = if messages { 2 } else { 0 };
        let isa = api.isa.map_or_else(String::new, |isa| format!(",isa={isa}"));
        // Threads are there before they are needed, as ours are.
        let settings = CString::new(format!("threads={threads},start_threads=1,verbose={verbose}{isa}"))?;
        // SAFETY: the text ends with a zero and is copied.
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
        // SAFETY: the device is alive, and the box of its count outlives it.
        unsafe { (api.set_memory_monitor)(handle, Some(monitor), memory.cast_mut().cast()) };
        Ok(device)
    }

    /// Such as `4.4.1`.
    pub(super) fn version(&self) -> String {
        // SAFETY: the device is alive.
        let version = unsafe { (self.api.device_property)(self.handle, VERSION) };
        format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }

    /// Whether packets of eight and of sixteen rays have registers of their own size, which tells
    /// what instructions the device uses.
    pub(super) fn native_packets(&self) -> [bool; 2] {
        // SAFETY: the device is alive.
        NATIVE.map(|property| unsafe { (self.api.device_property)(self.handle, property) } != 0)
    }

    /// The error of the latest calls, if there was one.
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
        // SAFETY: the device is alive, and this is its only owner here; scenes hold references of
        // their own.
        unsafe { (self.api.release_device)(self.handle) };
    }
}
