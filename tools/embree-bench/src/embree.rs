//! The few calls of Embree 3 and 4 that the benchmark needs, from a library opened at run time.

use std::ffi::{OsStr, c_char, c_uint, c_void};
use std::ptr::{null, null_mut};

use anyhow::{Context, Result, ensure};
use libloading::{Library, Symbol};
use probelight_scene::Scene;
use probelight_trace::Ray;

const GEOMETRY_TYPE_TRIANGLE: c_uint = 0;
const BUFFER_TYPE_INDEX: c_uint = 0;
const BUFFER_TYPE_VERTEX: c_uint = 1;
const FORMAT_UINT3: c_uint = 0x5003;
const FORMAT_FLOAT3: c_uint = 0x9003;
const BUILD_QUALITY_HIGH: c_uint = 2;
const DEVICE_PROPERTY_VERSION: c_uint = 0;
const INVALID: u32 = u32::MAX;

/// `RTCRay` followed by `RTCHit`, with room for the fields that newer versions append.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    barycentric: [f32; 2],
    triangle: u32,
    geometry: u32,
    instance: [u32; 5],
}

impl RayHit {
    /// A query for `ray`.
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            far: ray.max_distance,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            barycentric: [0.0; 2],
            triangle: INVALID,
            geometry: INVALID,
            instance: [INVALID; 5],
        }
    }

    /// Triangle and distance of the nearest hit that [`Embree::intersect`] found.
    pub fn hit(&self) -> Option<(u32, f32)> {
        (self.geometry != INVALID).then_some((self.triangle, self.far))
    }
}

/// `RTCIntersectContext` of Embree 3.
#[repr(C)]
struct Context3 {
    flags: u32,
    filter: *const c_void,
    instance: [u32; 4],
}

type Query3 = unsafe extern "C" fn(*mut c_void, *mut Context3, *mut RayHit);
type Query4 = unsafe extern "C" fn(*mut c_void, *mut RayHit, *const c_void);

/// The two queries, which take their arguments differently in versions 3 and 4.
enum Queries {
    Version3 { intersect: Query3, occluded: Query3 },
    Version4 { intersect: Query4, occluded: Query4 },
}

/// A scene committed to Embree. Its objects live until the process ends.
pub struct Embree {
    /// Version as major · 10000 + minor · 100 + patch.
    pub version: isize,
    scene: *mut c_void,
    queries: Queries,
    // Dropped last: the function pointers above point into it.
    _library: Library,
}

impl Embree {
    /// Opens the library `name` and builds `scene` at high quality (with spatial splits).
    ///
    /// # Errors
    /// Says so if the library is missing or not an Embree 3 or 4.
    pub fn new(name: &OsStr, scene: &Scene) -> Result<Self> {
        // SAFETY: Embree's initialisers have no preconditions.
        let library = unsafe { Library::new(name) }
            .with_context(|| format!("cannot open {}", name.to_string_lossy()))?;
        // SAFETY: the signatures below are those of embree3/rtcore_*.h and embree4/rtcore_*.h, which differ
        // in the two queries only; buffers are written within the sizes they were made with.
        unsafe {
            let new_device: Symbol<unsafe extern "C" fn(*const c_char) -> *mut c_void> =
                library.get(b"rtcNewDevice")?;
            let device = new_device(c"threads=1".as_ptr());
            ensure!(!device.is_null(), "Embree has no device for this processor");
            let property: Symbol<unsafe extern "C" fn(*mut c_void, c_uint) -> isize> =
                library.get(b"rtcGetDeviceProperty")?;
            let version = property(device, DEVICE_PROPERTY_VERSION);
            let queries = match version / 10_000 {
                3 => Queries::Version3 {
                    intersect: *library.get(b"rtcIntersect1")?,
                    occluded: *library.get(b"rtcOccluded1")?,
                },
                4 => Queries::Version4 {
                    intersect: *library.get(b"rtcIntersect1")?,
                    occluded: *library.get(b"rtcOccluded1")?,
                },
                other => anyhow::bail!("Embree {other} is neither 3 nor 4"),
            };
            let scene = build(&library, device, scene)?;
            Ok(Self { version, scene, queries, _library: library })
        }
    }

    /// Finds the nearest hit.
    #[inline]
    pub fn intersect(&self, ray: &mut RayHit) {
        // SAFETY: the scene is committed; `RayHit` has the layout and alignment Embree asks for.
        unsafe {
            match self.queries {
                Queries::Version3 { intersect, .. } => intersect(self.scene, &mut context3(), ray),
                Queries::Version4 { intersect, .. } => intersect(self.scene, ray, null()),
            }
        }
    }

    /// Whether anything lies on the ray.
    #[inline]
    pub fn is_occluded(&self, ray: &mut RayHit) -> bool {
        // SAFETY: as in `intersect`; the ray is the first member of `RayHit`.
        unsafe {
            match self.queries {
                Queries::Version3 { occluded, .. } => occluded(self.scene, &mut context3(), ray),
                Queries::Version4 { occluded, .. } => occluded(self.scene, ray, null()),
            }
        }
        ray.far == f32::NEG_INFINITY
    }
}

#[inline]
fn context3() -> Context3 {
    Context3 { flags: 0, filter: null_mut(), instance: [INVALID; 4] }
}

/// Builds one triangle mesh.
///
/// # Safety
/// `library` is Embree and `device` one of its devices.
unsafe fn build(library: &Library, device: *mut c_void, scene: &Scene) -> Result<*mut c_void> {
    type NewBuffer = unsafe extern "C" fn(*mut c_void, c_uint, c_uint, c_uint, usize, usize) -> *mut c_void;
    // SAFETY: the caller's promise; each buffer holds exactly the elements that are copied into it.
    unsafe {
        let new_scene: Symbol<unsafe extern "C" fn(*mut c_void) -> *mut c_void> =
            library.get(b"rtcNewScene")?;
        let set_quality: Symbol<unsafe extern "C" fn(*mut c_void, c_uint)> =
            library.get(b"rtcSetSceneBuildQuality")?;
        let new_geometry: Symbol<unsafe extern "C" fn(*mut c_void, c_uint) -> *mut c_void> =
            library.get(b"rtcNewGeometry")?;
        let new_buffer: Symbol<NewBuffer> = library.get(b"rtcSetNewGeometryBuffer")?;
        let commit_geometry: Symbol<unsafe extern "C" fn(*mut c_void)> = library.get(b"rtcCommitGeometry")?;
        let attach: Symbol<unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_uint> =
            library.get(b"rtcAttachGeometry")?;
        let commit: Symbol<unsafe extern "C" fn(*mut c_void)> = library.get(b"rtcCommitScene")?;

        let embree_scene = new_scene(device);
        set_quality(embree_scene, BUILD_QUALITY_HIGH);
        let geometry = new_geometry(device, GEOMETRY_TYPE_TRIANGLE);
        let positions: Vec<[f32; 3]> = scene.positions.iter().map(|p| p.to_array()).collect();
        let vertices = new_buffer(geometry, BUFFER_TYPE_VERTEX, 0, FORMAT_FLOAT3, 12, positions.len());
        let indices = new_buffer(geometry, BUFFER_TYPE_INDEX, 0, FORMAT_UINT3, 12, scene.triangles.len());
        ensure!(!vertices.is_null() && !indices.is_null(), "Embree could not make its buffers");
        vertices.cast::<[f32; 3]>().copy_from_nonoverlapping(positions.as_ptr(), positions.len());
        indices.cast::<[u32; 3]>().copy_from_nonoverlapping(scene.triangles.as_ptr(), scene.triangles.len());
        commit_geometry(geometry);
        attach(embree_scene, geometry);
        commit(embree_scene);
        Ok(embree_scene)
    }
}
