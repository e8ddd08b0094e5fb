//! Finding a GPU and opening it, without a window.
//!
//! Devices are opened with the limits and features of WebGPU's core, on whatever hardware, so that what runs on
//! one GPU runs on all. Timestamp queries are the exception: they are asked for where they exist.

use std::cmp::Reverse;
use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};

use wgpu::{AdapterInfo, DeviceType, Features};

use crate::RuntimeError;

/// Why the GPU could not do what was asked.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The computer has no GPU that a driver shows.
    #[error(
        "no GPU was found: it needs a driver for Vulkan, Metal or Direct3D 12 \
         (on Linux, the package mesa-vulkan-drivers also has one in software)"
    )]
    NoAdapter,
    /// No GPU has the name that was asked for.
    #[error("no GPU is called {wanted:?}; there are: {}", .available.join(", "))]
    UnknownAdapter {
        /// The name asked for.
        wanted: String,
        /// Names of the GPUs there are.
        available: Vec<String>,
    },
    /// The driver refused to open the GPU.
    #[error("cannot open the GPU {adapter:?}: {reason}")]
    NotOpened {
        /// Its name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The GPU's memory does not hold what is needed.
    #[error(
        "the GPU has too little memory for {purpose}: bake with fewer texels, make smaller pictures, or use the CPU"
    )]
    OutOfMemory {
        /// What the memory was for.
        purpose: &'static str,
    },
    /// More shadow maps than a GPU must be able to hold.
    #[error("{lights} lights need {needed} shadow maps, and there can be {limit}: remove some lights")]
    TooManyLights {
        /// Number of lights.
        lights: usize,
        /// Shadow maps they need: four for a directional light, one for a spot, six for a point light.
        needed: usize,
        /// How many there can be.
        limit: usize,
    },
    /// The GPU stopped working: it was removed, reset, or a frame took longer than the system allows.
    #[error("the GPU was lost ({reason}): start again, or use the CPU")]
    Lost {
        /// What the driver said.
        reason: String,
    },
    /// An array that shaders cannot bind.
    #[error(
        "the GPU can use arrays of up to {limit} bytes, and this scene needs {bytes} for its {content}: \
         bake a scene with fewer triangles, or with fewer texels or probes, or use the CPU"
    )]
    TooLarge {
        /// What the array holds.
        content: &'static str,
        /// Its length.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// A lightmap that is no texture.
    #[error(
        "the lightmap has {width} × {height} texels, and the GPU's textures have up to {limit} along each side: \
         bake with fewer texels, or use the CPU"
    )]
    LightmapTooLarge {
        /// Width, texels.
        width: u32,
        /// Height of all pages, texels.
        height: u32,
        /// The device's limit.
        limit: u32,
    },
    /// There is no such material or colour.
    #[error(transparent)]
    Input(#[from] RuntimeError),
    /// The driver or the graphics library found a mistake in what it was asked to do.
    #[error("the GPU refused {purpose}: {reason}")]
    Refused {
        /// What was asked.
        purpose: &'static str,
        /// Why.
        reason: String,
    },
}

/// An opened GPU. Programs that have a [`wgpu::Device`] of their own do not need it.
#[derive(Clone, Debug)]
pub struct GpuDevice {
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes commands.
    pub queue: wgpu::Queue,
    /// What the driver says about the GPU.
    pub info: AdapterInfo,
    /// For window surfaces.
    pub instance: wgpu::Instance,
    /// For window surfaces.
    pub adapter: wgpu::Adapter,
    lost: Arc<OnceLock<String>>,
}

impl GpuDevice {
    /// Opens the GPU whose name contains `wanted` (in upper or lower case), or the best there is: a discrete one
    /// before an integrated one, a driver in software last.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::UnknownAdapter`] or [`GpuError::NotOpened`].
    #[cfg(feature = "blocking")]
    pub fn open(wanted: Option<&str>) -> Result<Self, GpuError> {
        pollster::block_on(Self::open_async(wanted))
    }

    /// Opens a GPU as `open` does, without waiting: for browsers, which choose the GPU and do not tell its name.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::UnknownAdapter`] or [`GpuError::NotOpened`].
    pub async fn open_async(wanted: Option<&str>) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapters = adapters_best_first(&instance).await;
        let wanted_part = wanted.unwrap_or_default().to_lowercase();
        let mut failure = None;
        let matching = adapters.iter().filter(|a| a.get_info().name.to_lowercase().contains(&wanted_part));
        for adapter in matching {
            match Self::open_adapter(&instance, adapter).await {
                Ok(gpu) => return Ok(gpu),
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        Err(match (failure, wanted) {
            (Some(failure), _) => failure,
            (None, Some(wanted)) if !adapters.is_empty() => {
                let available = adapters.iter().map(|adapter| adapter.get_info().name).collect();
                GpuError::UnknownAdapter { wanted: wanted.into(), available }
            }
            _ => GpuError::NoAdapter,
        })
    }

    async fn open_adapter(instance: &wgpu::Instance, adapter: &wgpu::Adapter) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("probelight"),
            required_features: adapter.features() & optional_features(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|error| GpuError::NotOpened { adapter: info.name.clone(), reason: error.to_string() })?;
        let lost = Arc::new(OnceLock::new());
        // Of several reasons the first counts.
        let note = Arc::clone(&lost);
        device.set_device_lost_callback(move |kind, reason| {
            // Some drivers say nothing.
            _ = note.set(if reason.is_empty() { format!("{kind:?}").to_lowercase() } else { reason });
        });
        let note = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |error| match error {
            // Nothing that a user does leads here, unless the GPU is gone.
            wgpu::Error::Validation { .. } if note.get().is_none() => panic!("{error}"),
            error => _ = note.set(error.to_string()),
        }));
        Ok(Self { device, queue, info, instance: instance.clone(), adapter: adapter.clone(), lost })
    }

    /// Whether the "GPU" is a driver that computes on the CPU.
    pub fn is_software(&self) -> bool {
        is_software(&self.info)
    }

    /// Whether the GPU still works: it was neither lost, nor out of memory in the middle of a frame.
    ///
    /// # Errors
    /// [`GpuError::Lost`] if not.
    pub fn check(&self) -> Result<(), GpuError> {
        match self.lost.get() {
            Some(reason) => Err(GpuError::Lost { reason: reason.clone() }),
            None => Ok(()),
        }
    }
}

/// Runs `make`, which makes resources on a device, and reports what the device says about it. Waits for nothing.
///
/// In browsers devices take time to say something, and there this reports nothing: errors belong to whatever listens
/// around it, [`checked_async`] or the device's own handler.
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Refused`], or an error of `make`.
pub fn checked<T>(
    device: &wgpu::Device,
    purpose: &'static str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    if cfg!(target_arch = "wasm32") {
        return make();
    }
    let answer = pin!(checked_async(device, purpose, make));
    match answer.poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(made) => made,
        // Drivers are asked by function calls; none of wgpu's native backends comes here.
        Poll::Pending => {
            Err(GpuError::Refused { purpose, reason: "the device did not answer at once".into() })
        }
    }
}

/// [`checked`], with patience.
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Refused`], or an error of `make`.
pub async fn checked_async<T>(
    device: &wgpu::Device,
    purpose: &'static str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    // Both scopes end before anything waits: others may begin meanwhile.
    let (out_of_memory, refused) = (memory.pop(), validation.pop());
    let (out_of_memory, refused) = (out_of_memory.await, refused.await);
    match (out_of_memory, refused) {
        (Some(_), _) => Err(GpuError::OutOfMemory { purpose }),
        (None, Some(error)) => Err(GpuError::Refused { purpose, reason: error.to_string() }),
        (None, None) => made,
    }
}

/// Runs `work` to its end and waits for the GPU whenever `work` does.
#[cfg(feature = "blocking")]
pub(super) fn wait_for<T>(
    device: &wgpu::Device,
    work: impl Future<Output = Result<T, GpuError>>,
) -> Result<T, GpuError> {
    let mut work = pin!(work);
    loop {
        if let Poll::Ready(result) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return result;
        }
        // Once everything submitted is done, the device has said all that `work` may be waiting for.
        let waited = device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| GpuError::Lost { reason: error.to_string() })?;
    }
}

/// Whether an adapter is a driver that computes on the CPU.
pub(super) fn is_software(info: &AdapterInfo) -> bool {
    info.device_type == DeviceType::Cpu
}

/// Takes commands for `device`.
pub(super) fn new_encoder(device: &wgpu::Device) -> wgpu::CommandEncoder {
    device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

fn optional_features() -> Features {
    Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
}

async fn adapters_best_first(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
    // The sort is stable: equals keep the driver's order.
    adapters.sort_by_key(|adapter| Reverse(rank(adapter.get_info().device_type)));
    adapters
}

fn rank(kind: DeviceType) -> u32 {
    match kind {
        DeviceType::DiscreteGpu => 4,
        DeviceType::IntegratedGpu => 3,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 1,
        DeviceType::Cpu => 0,
    }
}
