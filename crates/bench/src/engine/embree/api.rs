//! The part of Embree's C interface that is called, loaded at run time.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use libloading::Library;

use crate::failure::Failure;
use crate::peers;

/// Environment variable with the path of the library, instead of the one that `fetch-peers`
/// downloaded.
const VARIABLE: &str = "KINETREE_EMBREE";

/// Declares an enumeration of Embree.
macro_rules! constants {
    ($(#[$meta:meta])* $name:ident { $($constant:ident = $value:expr),+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(transparent)]
        pub(super) struct $name(pub(super) c_int);
        #[allow(dead_code)]
        impl $name {
            $(pub(super) const $constant: Self = Self($value);)+
        }
    };
}

constants!(/// `RTCBuildQuality`
    BuildQuality { LOW = 0, MEDIUM = 1, HIGH = 2, REFIT = 3 });
constants!(/// `RTCSceneFlags`
    SceneFlags { NONE = 0, DYNAMIC = 1, ROBUST = 4 });
constants!(/// `RTCGeometryType`
    GeometryType { TRIANGLE = 0 });
constants!(/// `RTCBufferType`
    BufferType { INDEX = 0, VERTEX = 1 });
constants!(/// `RTCFormat`
    Format { UINT3 = 0x5003, FLOAT3 = 0x9003 });
constants!(/// `RTCRayQueryFlags`
    RayQueryFlags { NONE = 0, COHERENT = 1 << 16 });

/// `RTC_INVALID_GEOMETRY_ID`
pub(super) const INVALID: c_uint = c_uint::MAX;

/// `RTCIntersectArguments`, and `RTCOccludedArguments`, which has the same layout.
#[repr(C)]
pub(super) struct Arguments {
    pub(super) flags: RayQueryFlags,
    pub(super) feature_mask: c_uint,
    pub(super) context: *mut c_void,
    pub(super) filter: *mut c_void,
    pub(super) callback: *mut c_void,
    pub(super) min_width: f32,
}

impl Arguments {
    /// The default arguments with these flags.
    pub(super) fn with_flags(flags: RayQueryFlags) -> Self {
        let null = std::ptr::null_mut();
        Self { flags, feature_mask: c_uint::MAX, context: null, filter: null, callback: null, min_width: 0.0 }
    }
}

/// `RTCRay`
#[repr(C, align(16))]
pub(super) struct RtcRay {
    pub(super) origin: [f32; 3],
    pub(super) t_near: f32,
    pub(super) direction: [f32; 3],
    pub(super) time: f32,
    pub(super) t_far: f32,
    pub(super) mask: c_uint,
    pub(super) id: c_uint,
    pub(super) flags: c_uint,
}

/// `RTCRayHit`. Its last members depend on how the library was compiled; there is space for both
/// variants.
#[repr(C, align(16))]
pub(super) struct RtcRayHit {
    pub(super) ray: RtcRay,
    pub(super) normal: [f32; 3],
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) primitive: c_uint,
    pub(super) geometry: c_uint,
    pub(super) instances: [c_uint; 5],
}

const _: () = assert!(size_of::<RtcRay>() == 48 && size_of::<RtcRayHit>() == 96);

/// `RTCRayHitN` for `N` rays. Occlusion reads and writes the first part, the ray.
#[repr(C, align(64))]
pub(super) struct Packet<const N: usize> {
    pub(super) origin: [[f32; N]; 3],
    pub(super) t_near: [f32; N],
    pub(super) direction: [[f32; N]; 3],
    pub(super) time: [f32; N],
    pub(super) t_far: [f32; N],
    pub(super) mask: [c_uint; N],
    pub(super) id: [c_uint; N],
    pub(super) flags: [c_uint; N],
    pub(super) normal: [[f32; N]; 3],
    pub(super) u: [f32; N],
    pub(super) v: [f32; N],
    pub(super) primitive: [c_uint; N],
    pub(super) geometry: [c_uint; N],
    pub(super) instances: [[c_uint; N]; 2],
}

pub(super) type Handle = *mut c_void;
pub(super) type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;
pub(super) type Trace1 = unsafe extern "C" fn(Handle, *mut c_void, *mut Arguments);
pub(super) type TraceN = unsafe extern "C" fn(*const c_int, Handle, *mut c_void, *mut Arguments);

/// Declares the table of functions, and how it is loaded from the library.
macro_rules! functions {
    ($($field:ident = $symbol:literal: $kind:ty),+ $(,)?) => {
        /// The functions that are called. They stay valid for ever: the library is never closed,
        /// because its threads outlive the devices that started them and would lose the code that
        /// they run.
        pub(super) struct Api {
            $(pub(super) $field: $kind,)+
            /// The value of `isa=` for every device; `None` for Embree's own choice.
            pub(super) isa: Option<&'static str>,
            _library: ManuallyDrop<Library>,
        }

        impl Api {
            fn of(library: Library, isa: Option<&'static str>) -> Result<Self, Failure> {
                Ok(Self {
                    $(
                        // SAFETY: the type is the one that Embree 4 declares for this name.
                        $field: *unsafe { library.get::<$kind>($symbol)? },
                    )+
                    isa,
                    _library: ManuallyDrop::new(library),
                })
            }
        }
    };
}

functions! {
    new_device = b"rtcNewDevice\0": unsafe extern "C" fn(*const c_char) -> Handle,
    release_device = b"rtcReleaseDevice\0": unsafe extern "C" fn(Handle),
    device_error = b"rtcGetDeviceError\0": unsafe extern "C" fn(Handle) -> c_int,
    device_property = b"rtcGetDeviceProperty\0": unsafe extern "C" fn(Handle, c_int) -> isize,
    set_memory_monitor = b"rtcSetDeviceMemoryMonitorFunction\0": unsafe extern "C" fn(Handle, Option<MemoryMonitor>, *mut c_void),
    new_scene = b"rtcNewScene\0": unsafe extern "C" fn(Handle) -> Handle,
    release_scene = b"rtcReleaseScene\0": unsafe extern "C" fn(Handle),
    set_scene_quality = b"rtcSetSceneBuildQuality\0": unsafe extern "C" fn(Handle, BuildQuality),
    set_scene_flags = b"rtcSetSceneFlags\0": unsafe extern "C" fn(Handle, SceneFlags),
    commit_scene = b"rtcCommitScene\0": unsafe extern "C" fn(Handle),
    new_geometry = b"rtcNewGeometry\0": unsafe extern "C" fn(Handle, GeometryType) -> Handle,
    release_geometry = b"rtcReleaseGeometry\0": unsafe extern "C" fn(Handle),
    set_geometry_quality = b"rtcSetGeometryBuildQuality\0": unsafe extern "C" fn(Handle, BuildQuality),
    set_shared_buffer = b"rtcSetSharedGeometryBuffer\0":
        unsafe extern "C" fn(Handle, BufferType, c_uint, Format, *const c_void, usize, usize, usize),
    update_buffer = b"rtcUpdateGeometryBuffer\0": unsafe extern "C" fn(Handle, BufferType, c_uint),
    commit_geometry = b"rtcCommitGeometry\0": unsafe extern "C" fn(Handle),
    attach_geometry = b"rtcAttachGeometryByID\0": unsafe extern "C" fn(Handle, Handle, c_uint),
    intersect1 = b"rtcIntersect1\0": Trace1,
    occluded1 = b"rtcOccluded1\0": Trace1,
    intersect8 = b"rtcIntersect8\0": TraceN,
    occluded8 = b"rtcOccluded8\0": TraceN,
    intersect16 = b"rtcIntersect16\0": TraceN,
    occluded16 = b"rtcOccluded16\0": TraceN,
}

impl Api {
    /// Loads the library that the environment names, or else the downloaded one. All devices will
    /// use the instructions `isa`.
    ///
    /// # Errors
    /// The library is missing, cannot be loaded, or is not Embree 4.
    pub(super) fn open(isa: Option<&'static str>) -> Result<Self, Failure> {
        let path = match std::env::var_os(VARIABLE) {
            Some(path) => PathBuf::from(path),
            None => peers::find("libembree4").ok_or("its library is not there")?,
        };
        Self::open_at(&path, isa).map_err(|failure| format!("{}: {failure}", path.display()).into())
    }

    fn open_at(path: &Path, isa: Option<&'static str>) -> Result<Self, Failure> {
        // SAFETY: the initialisers of Embree and of its thread library change nothing but their own
        // state. The thread library lies beside Embree, where Embree's own search path finds it.
        Self::of(unsafe { Library::new(path)? }, isa)
    }
}
