//! Mathematics that Probelight's bake, runtime and reference share: spherical harmonics, direction
//! sets, sampling. No I/O, no threads.
//!
//! Conventions (see `docs/method.md`): right-handed, +Y up, metres. Real orthonormal spherical
//! harmonics with index `j = l² + l + m`. "Degree n" is the highest band `l = n`.

pub mod color;
pub mod directions;
pub mod sampling;
pub mod sh;

/// The linear-algebra crate whose vectors appear in Probelight's public types.
pub use glam;
