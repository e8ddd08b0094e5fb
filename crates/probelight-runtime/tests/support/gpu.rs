//! The GPU that tests run on.

use std::sync::OnceLock;

use probelight_runtime::gpu::{GpuDevice, GpuError};

/// The GPU, opened once. Without one the test is skipped and says so, unless the environment says `CI=true`:
/// there a missing GPU is a failure. `PROBELIGHT_ADAPTER` chooses among several.
pub(crate) fn gpu_or_skip() -> Option<&'static GpuDevice> {
    static GPU: OnceLock<Result<GpuDevice, GpuError>> = OnceLock::new();
    let open = || GpuDevice::open(std::env::var("PROBELIGHT_ADAPTER").ok().as_deref());
    match GPU.get_or_init(open) {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var("CI").is_ok_and(|ci| ci == "true") => panic!("{error}"),
        Err(error) => {
            use std::io::Write;
            let _ = writeln!(std::io::stderr(), "SKIPPED: {error}");
            None
        }
    }
}
