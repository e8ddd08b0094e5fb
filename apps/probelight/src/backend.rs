//! Where light is computed and pictures are drawn: on the GPU or on the CPU.

use clap::{Args, ValueEnum};
use probelight_runtime::gpu::{GpuDevice, GpuError};

use crate::console::Console;

/// Flags of commands that can use a GPU.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct BackendFlags {
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    backend: BackendChoice,
    /// Part of the name of the GPU to use [default: the fastest kind there is]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum BackendChoice {
    /// A GPU if there is one, else the CPU
    #[default]
    Auto,
    /// A GPU, even one that is a driver in software
    Gpu,
    /// The CPU
    Cpu,
}

/// What computes.
#[derive(Debug)]
pub(crate) enum Backend {
    Cpu,
    Gpu(Box<GpuDevice>),
}

impl Backend {
    /// "GPU" with its name, or "CPU".
    pub(crate) fn describe(&self) -> String {
        match self {
            Self::Cpu => "CPU".into(),
            Self::Gpu(gpu) => format!("GPU ({})", gpu.info.name),
        }
    }
}

impl BackendFlags {
    /// Opens what was asked for. If the choice is left to the program and it takes the CPU, it says why.
    pub(crate) fn open(&self, console: &Console) -> anyhow::Result<Backend> {
        self.open_for(false, console)
    }

    /// As [`open`](Self::open); for something that only a GPU can do, a driver in software is taken too.
    pub(crate) fn open_for(&self, needs_gpu: bool, console: &Console) -> anyhow::Result<Backend> {
        // Who names an adapter wants that one.
        let choice = match self.backend {
            BackendChoice::Auto if needs_gpu || self.adapter.is_some() => BackendChoice::Gpu,
            choice => choice,
        };
        match choice {
            BackendChoice::Cpu => Ok(Backend::Cpu),
            BackendChoice::Gpu => Ok(Backend::Gpu(Box::new(GpuDevice::open(self.adapter.as_deref())?))),
            BackendChoice::Auto => Ok(automatic(GpuDevice::open(None), console)),
        }
    }
}

/// A GPU that is one, else the CPU.
fn automatic(opened: Result<GpuDevice, GpuError>, console: &Console) -> Backend {
    match opened {
        Ok(gpu) if !gpu.is_software() => Backend::Gpu(Box::new(gpu)),
        Ok(gpu) => {
            console.note(format!(
                "using the CPU: the only GPU, {:?}, is a driver in software (--backend gpu uses it)",
                gpu.info.name
            ));
            Backend::Cpu
        }
        Err(error) => {
            console.note(format!("using the CPU: {error}"));
            Backend::Cpu
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_gpu_the_cpu_computes() {
        let console = Console::new(true);
        assert!(matches!(automatic(Err(GpuError::NoAdapter), &console), Backend::Cpu));
        let cpu = BackendFlags { backend: BackendChoice::Cpu, adapter: None };
        assert!(matches!(cpu.open_for(true, &console), Ok(Backend::Cpu)), "who wants the CPU gets it");
    }

    #[test]
    fn who_names_a_gpu_hears_if_it_is_missing() {
        let flags = BackendFlags { backend: BackendChoice::Auto, adapter: Some("no such GPU".into()) };
        let error = flags.open(&Console::new(true)).unwrap_err().to_string();
        assert!(error.contains("GPU"), "{error}");
    }
}
