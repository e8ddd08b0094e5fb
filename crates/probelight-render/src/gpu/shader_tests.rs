//! What can be tested of the shaders without a GPU.

use probelight_runtime::gpu::shaders::{GRID, LIGHTS, OBJECT_SPHERES, PLACEMENTS, SHADOW_MAPS};

use super::frame_record::FrameRecord;
use super::markers::{MarkerRecord, SLICES, STACKS};
use super::materials::MaterialRecord;
use super::presenter::{Coloring, DisplayRecord};
use super::reflection::{Partners, parse, record, write_for_direct3d_and_metal};
use super::shaders;
use super::view::{GpuView, Shading};
use crate::tone_map::{MIDDLE_GREY_IN, MIX, UNMIX};

/// All shaders, by the name of their file.
fn sources() -> Vec<(&'static str, String)> {
    vec![
        ("surface", shaders::surface()),
        ("objects", shaders::objects()),
        ("sky", shaders::sky()),
        ("markers", shaders::markers()),
        ("tone_map", shaders::tone_map()),
    ]
}

#[test]
fn all_shaders_are_valid_and_can_be_written_for_direct3d_and_metal() {
    for (name, source) in sources() {
        let module = parse(&source).unwrap_or_else(|error| panic!("{name}: {error}"));
        write_for_direct3d_and_metal(&module).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

fn partners() -> Partners {
    let mut constants = vec![
        ("SHADING_DIFFUSE", vec![f64::from(Shading::Diffuse as u32)]),
        ("SHADING_PHYSICAL", vec![f64::from(Shading::Physical as u32)]),
        ("COLORING_NATURAL", vec![f64::from(Coloring::Natural as u32)]),
        ("COLORING_STOPS", vec![f64::from(Coloring::Stops as u32)]),
        ("COLORING_DIFFERENCE", vec![f64::from(Coloring::Difference as u32)]),
        ("MIDDLE_GREY", vec![f64::from(MIDDLE_GREY_IN)]),
        ("PI", vec![f64::from(std::f32::consts::PI)]),
        ("SLICES", vec![f64::from(SLICES)]),
        ("STACKS", vec![f64::from(STACKS)]),
        ("MIX", MIX.to_cols_array().map(f64::from).to_vec()),
        ("UNMIX", UNMIX.to_cols_array().map(f64::from).to_vec()),
    ];
    let constant = |view: GpuView| &*format!("VIEW_{}", view.name().replace('-', "_").to_uppercase()).leak();
    constants.extend(GpuView::ALL.map(|view| (constant(view), vec![f64::from(view as u32)])));
    Partners {
        records: vec![
            record!(FrameRecord as "Frame" {
                clip_from_world, eye, view, right, shading, up, emissive_scale, forward, marker_radius, zenith,
                horizon, ground,
            }),
            record!(MaterialRecord as "Material" {
                base_color, emission, metallic, roughness, normal_scale, alpha_cutoff, second_uv_sets,
            }),
            record!(MarkerRecord as "Marker" { position, signal, normal, degree }),
            record!(DisplayRecord as "Display" {
                exposure, has_curve, encodes_srgb, coloring, divider, fade, marks, unused,
            }),
        ],
        constants,
        shader_only: &[
            // The corners of a quad's two triangles.
            "QUAD_CORNERS",
            // Of false colours.
            "STOPS",
            "LARGEST_DIFFERENCE",
            // Of the reflection model, which the CPU's renderer does not have.
            "DIELECTRIC",
            "LEAST_ROUGHNESS",
            "FLAT_SLOPE",
            "SAME_DIRECTION",
            "UNCERTAIN_LIGHT",
            "MOST_BRIGHTENING",
        ],
        compared_elsewhere: &[LIGHTS, SHADOW_MAPS, PLACEMENTS, GRID, OBJECT_SPHERES],
    }
}

#[test]
fn every_struct_in_a_buffer_and_every_constant_has_a_partner() {
    assert_eq!(partners().compare(&sources()), Vec::<String>::new());
}

#[test]
fn a_wrong_partner_is_noticed() {
    let mut partners = partners();
    partners.records[3].1 = partners.records[2].1.clone();
    partners.constants[0].1 = vec![7.0];
    partners.compared_elsewhere = &[SHADOW_MAPS, PLACEMENTS, GRID, OBJECT_SPHERES];
    let wrong = partners.compare(&sources()).join("\n");
    for name in ["struct Display", "const SHADING_DIFFUSE", "struct Lights", "const MAX_LIGHTS"] {
        assert!(wrong.contains(name), "{name} is not in {wrong}");
    }
}
