//! One error for values that make no sense, wherever they come from.

use probelight_math::glam::Vec3;

/// Why a camera or a light cannot be used: what is wrong and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Unusable {
    /// A clause such as "its position is not finite", to stand after what the value belongs to.
    pub reason: String,
}

impl Unusable {
    pub(crate) fn unless(condition: bool, reason: impl FnOnce() -> String) -> Result<(), Self> {
        if condition { Ok(()) } else { Err(Self { reason: reason() }) }
    }

    /// The same, of a named part of a whole.
    pub(crate) fn of(self, part: impl std::fmt::Display) -> Self {
        Self { reason: format!("{part}: {}", self.reason) }
    }
}

/// Refuses light (linear RGB, any unit) that is negative or not finite.
pub(crate) fn check_radiometric(name: &str, value: Vec3) -> Result<(), Unusable> {
    let allowed = value.is_finite() && value.min_element() >= 0.0;
    Unusable::unless(allowed, || format!("its {name} is {value}; it must be finite and not negative"))
}

/// Refuses positions (metres) that are not finite.
pub(crate) fn check_position(name: &str, value: Vec3) -> Result<(), Unusable> {
    Unusable::unless(value.is_finite(), || format!("its {name} is {value}; it must be finite"))
}
