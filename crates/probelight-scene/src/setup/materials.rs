//! Colours of materials that a setup changes.

use probelight_math::glam::Vec3;

use super::fields::Field;
use crate::Scene;

/// Other colours for the materials of one name. What is absent stays as the scene has it; textures stay in any case.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialColors {
    /// The materials' name in the scene.
    pub name: String,
    /// Linear base colour factor.
    pub base_color: Option<Vec3>,
    /// Radiance of the front face, W·m⁻²·sr⁻¹.
    pub emission: Option<Vec3>,
}

impl MaterialColors {
    /// Indices of the scene's materials that have these colours.
    pub fn materials<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = usize> + 'a {
        let named = scene.materials.iter().enumerate().filter(|(_, material)| material.name == self.name);
        named.map(|(index, _)| index)
    }

    /// Gives a scene these colours.
    pub fn apply(&self, scene: &mut Scene) {
        for material in scene.materials.iter_mut().filter(|material| material.name == self.name) {
            if let Some(color) = self.base_color {
                material.base_color = color.extend(material.base_color.w);
            }
            material.emission = self.emission.unwrap_or(material.emission);
        }
    }
}

/// Reads the colours of a setup.
pub(super) fn materials(field: &Field<'_>) -> Result<Vec<MaterialColors>, String> {
    field.array()?.iter().map(material).collect()
}

fn material(field: &Field<'_>) -> Result<MaterialColors, String> {
    let members = field.object()?;
    members.allow_only(&["name", "base_color", "emission"])?;
    let color = |name| members.optional(name).map(|field| field.color()).transpose();
    Ok(MaterialColors {
        name: members.required("name")?.text()?.into(),
        base_color: color("base_color")?,
        emission: color("emission")?,
    })
}
