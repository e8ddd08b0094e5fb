//! Strict reading of JSON: every error names the field's path and what is allowed there.

use probelight_math::glam::Vec3;
use serde_json::{Map, Value};

/// A JSON value and how to get to it from the document's root, such as `lights[2].position`.
#[derive(Clone)]
pub(super) struct Field<'a> {
    value: &'a Value,
    path: String,
}

/// A JSON object, with its path.
pub(super) struct Object<'a> {
    members: &'a Map<String, Value>,
    path: String,
}

impl<'a> Field<'a> {
    /// The document itself.
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, path: String::new() }
    }

    /// Another value in the place of this one, for errors.
    pub(super) fn of_same_path<'b>(&self, value: &'b Value) -> Field<'b> {
        Field { value, path: self.path.clone() }
    }

    /// An error at this field.
    pub(super) fn error(&self, reason: impl std::fmt::Display) -> String {
        if self.path.is_empty() { reason.to_string() } else { format!("{}: {reason}", self.path) }
    }

    /// "`wanted` expected, found …".
    fn mismatch(&self, wanted: &str) -> String {
        let found = match self.value {
            Value::Null => "null".into(),
            Value::Bool(_) | Value::Number(_) => self.value.to_string(),
            Value::String(_) => "a string".into(),
            Value::Array(values) => format!("an array of {}", values.len()),
            Value::Object(_) => "an object".into(),
        };
        self.error(format!("{wanted} expected, found {found}"))
    }

    /// An object, of which all members will be asked for by name; see [`Object::allow_only`].
    pub(super) fn object(&self) -> Result<Object<'a>, String> {
        let members = self.value.as_object().ok_or_else(|| self.mismatch("an object"))?;
        Ok(Object { members, path: self.path.clone() })
    }

    /// The elements of an array.
    pub(super) fn array(&self) -> Result<Vec<Self>, String> {
        let values = self.value.as_array().ok_or_else(|| self.mismatch("an array"))?;
        let field = |(i, value)| Self { value, path: format!("{}[{i}]", self.path) };
        Ok(values.iter().enumerate().map(field).collect())
    }

    pub(super) fn text(&self) -> Result<&'a str, String> {
        self.value.as_str().ok_or_else(|| self.mismatch("a string"))
    }

    pub(super) fn boolean(&self) -> Result<bool, String> {
        self.value.as_bool().ok_or_else(|| self.mismatch("true or false"))
    }

    /// A number that is finite in single precision.
    pub(super) fn number(&self) -> Result<f32, String> {
        let number = self.value.as_f64().ok_or_else(|| self.mismatch("a number"))? as f32;
        if number.is_finite() { Ok(number) } else { Err(self.mismatch("a number of at most 3.4e38")) }
    }

    /// A number in `smallest..=largest`.
    pub(super) fn number_within(&self, smallest: f32, largest: f32) -> Result<f32, String> {
        let number = self.number()?;
        if (smallest..=largest).contains(&number) {
            return Ok(number);
        }
        Err(self.mismatch(&format!("a number from {smallest} to {largest}")))
    }

    /// A whole number that is not negative.
    pub(super) fn count(&self) -> Result<u32, String> {
        let count = self.value.as_u64().and_then(|count| u32::try_from(count).ok());
        count.ok_or_else(|| self.mismatch("a whole number"))
    }

    /// Three finite numbers.
    pub(super) fn vector(&self) -> Result<Vec3, String> {
        let numbers = self.value.as_array().filter(|numbers| numbers.len() == 3);
        if numbers.is_none() {
            return Err(self.mismatch("an array of three numbers"));
        }
        let components = self.array()?.iter().map(Self::number).collect::<Result<Vec<_>, _>>()?;
        Ok(Vec3::from_slice(&components))
    }

    /// Three finite numbers that are not negative: linear red, green and blue.
    pub(super) fn color(&self) -> Result<Vec3, String> {
        let color = self.vector()?;
        if color.min_element() >= 0.0 { Ok(color) } else { Err(self.error("light must not be negative")) }
    }

    /// A vector of any length but zero, normalised.
    pub(super) fn direction(&self) -> Result<Vec3, String> {
        self.vector()?.try_normalize().ok_or_else(|| self.error("the zero vector is no direction"))
    }
}

impl<'a> Object<'a> {
    /// An error at this object.
    pub(super) fn error(&self, reason: impl std::fmt::Display) -> String {
        format!("{}: {reason}", self.path)
    }

    /// Refuses members with other names than these.
    pub(super) fn allow_only(&self, names: &[&str]) -> Result<(), String> {
        let Some(unknown) = self.members.keys().find(|name| !names.contains(&name.as_str())) else {
            return Ok(());
        };
        let allowed = names.join(", ");
        Err(format!("{} is not a known field; allowed here: {allowed}", self.member_path(unknown)))
    }

    /// A member that must be there.
    pub(super) fn required(&self, name: &str) -> Result<Field<'a>, String> {
        self.optional(name).ok_or_else(|| format!("{} is missing", self.member_path(name)))
    }

    /// A member that may be absent.
    pub(super) fn optional(&self, name: &str) -> Option<Field<'a>> {
        self.members.get(name).map(|value| Field { value, path: self.member_path(name) })
    }

    /// Whether there is a member of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.members.contains_key(name)
    }

    /// These members with those of another object in their place, but for some.
    pub(super) fn with_members_of(&self, other: &Object<'_>, without: &[&str]) -> Value {
        let mut members = self.members.clone();
        members.extend(other.members.clone());
        members.retain(|name, _| !without.contains(&name.as_str()));
        Value::Object(members)
    }

    fn member_path(&self, name: &str) -> String {
        if self.path.is_empty() { name.into() } else { format!("{}.{name}", self.path) }
    }
}
