//! What can be tested of the shaders without a GPU.

use super::frame_record::FrameRecord;
use super::markers::{MarkerRecord, SLICES, STACKS};
use super::materials::MaterialRecord;
use super::presenter::DisplayRecord;
use super::shaders;
use super::view::{GpuView, Shading};
use super::wgsl_layout::{compare, constant, fields, parse, write_for_direct3d_and_metal};

#[test]
fn all_shaders_are_valid_and_can_be_written_for_direct3d_and_metal() {
    for source in [shaders::surface(), shaders::sky(), shaders::markers(), shaders::tone_map()] {
        write_for_direct3d_and_metal(&parse(&source).unwrap()).unwrap();
    }
}

#[test]
fn structs_are_the_same_on_both_sides() {
    let surface = parse(&shaders::surface()).unwrap();
    let frame = fields!(FrameRecord:
        clip_from_world eye view right shading up emissive_scale forward marker_radius zenith horizon ground);
    compare(&surface, "Frame", frame, size_of::<FrameRecord>()).unwrap();
    let material = fields!(MaterialRecord:
        base_color emission metallic roughness normal_scale alpha_cutoff second_uv_sets);
    compare(&surface, "Material", material, size_of::<MaterialRecord>()).unwrap();
    let markers = parse(&shaders::markers()).unwrap();
    let marker = fields!(MarkerRecord: position signal normal degree);
    compare(&markers, "Marker", marker, size_of::<MarkerRecord>()).unwrap();
    let tone_map = parse(&shaders::tone_map()).unwrap();
    let display = fields!(DisplayRecord: exposure has_curve encodes_srgb);
    compare(&tone_map, "Display", display, size_of::<DisplayRecord>()).unwrap();
    assert!(compare(&tone_map, "Display", marker, size_of::<MarkerRecord>()).is_err());
}

#[test]
fn constants_are_the_same_on_both_sides() {
    let surface = parse(&shaders::surface()).unwrap();
    let views = [
        ("VIEW_FULL", GpuView::Full),
        ("VIEW_DIRECT", GpuView::Direct),
        ("VIEW_INDIRECT", GpuView::Indirect),
        ("VIEW_IRRADIANCE", GpuView::Irradiance),
        ("VIEW_ALBEDO", GpuView::Albedo),
        ("VIEW_NORMALS", GpuView::Normals),
        ("VIEW_LIGHTMAP_TEXELS", GpuView::LightmapTexels),
        ("VIEW_CLUSTERS", GpuView::Clusters),
        ("VIEW_PROBES", GpuView::Probes),
        ("VIEW_LIGHT_SAMPLES", GpuView::LightSamples),
    ];
    assert_eq!(views.map(|(_, view)| view), GpuView::ALL);
    for (name, view) in views {
        assert_eq!(constant(&surface, name), Some(view as u32), "{name}");
    }
    assert_eq!(constant(&surface, "SHADING_DIFFUSE"), Some(Shading::Diffuse as u32));
    assert_eq!(constant(&surface, "SHADING_PHYSICAL"), Some(Shading::Physical as u32));
    let markers = parse(&shaders::markers()).unwrap();
    assert_eq!(constant(&markers, "SLICES"), Some(SLICES));
    assert_eq!(constant(&markers, "STACKS"), Some(STACKS));
}
