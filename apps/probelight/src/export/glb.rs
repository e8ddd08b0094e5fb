//! A baked scene as a binary glTF file: one mesh for each material, with the lightmap's coordinates as `TEXCOORD_1`.

use anyhow::Context;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use probelight_asset::{BakedScene, LitMesh};
use probelight_math::glam::Vec3;
use probelight_scene::{AlphaMode, Light, Material, Texture, TextureSlot};
use serde_json::{Map, Value, json};

/// Component types and buffer targets, as glTF numbers them.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The document while it grows.
#[derive(Default)]
struct Draft {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    nodes: Vec<Value>,
    meshes: Vec<Value>,
}

/// The file's bytes: geometry in world space, materials, textures, and `lights`.
pub(crate) fn glb(baked: &BakedScene, lights: &[Light]) -> anyhow::Result<Vec<u8>> {
    let scene = &*baked.scene;
    let mut draft = Draft::default();
    for (number, material) in scene.materials.iter().enumerate() {
        let mesh = LitMesh::of_material(baked, number);
        if !mesh.indices.is_empty() {
            draft.add_mesh(&mesh, &material.name, number);
        }
    }
    let lights: Vec<Value> = lights.iter().map(|light| draft.add_light(light)).collect();
    let images =
        scene.textures.iter().map(|texture| draft.add_image(texture)).collect::<Result<Vec<_>, _>>()?;
    let textures: Vec<Value> = (0..images.len()).map(|source| json!({ "source": source })).collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "Probelight" },
        "scene": 0,
        "scenes": [{ "nodes": (0..draft.nodes.len()).collect::<Vec<_>>() }],
        "nodes": draft.nodes,
        "meshes": draft.meshes,
        "materials": scene.materials.iter().map(material).collect::<Vec<_>>(),
        "accessors": draft.accessors,
        "bufferViews": draft.views,
        "buffers": [{ "byteLength": draft.bytes.len() }],
    });
    if !images.is_empty() {
        (document["images"], document["textures"]) = (images.into(), textures.into());
    }
    let mut extensions = Vec::new();
    if !lights.is_empty() {
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
        extensions.push("KHR_lights_punctual");
    }
    if scene.materials.iter().any(|material| material.emission.max_element() > 1.0) {
        extensions.push("KHR_materials_emissive_strength");
    }
    if !extensions.is_empty() {
        document["extensionsUsed"] = extensions.into();
    }
    container(&document, draft.bytes)
}

impl Draft {
    /// Appends bytes; returns the number of their view.
    fn add_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends vectors of `N` numbers; returns the number of their accessor.
    fn add_vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.add_view(&bytes, Some(ARRAY_BUFFER));
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": vectors.len(), "type": format!("VEC{N}"),
        });
        if N == 3 {
            // Asked for of positions, allowed for all.
            let extreme = |pick: fn(f32, f32) -> f32, first: f32| -> Vec<f32> {
                (0..N).map(|i| vectors.iter().map(|v| v[i]).fold(first, pick)).collect()
            };
            accessor["min"] = json!(extreme(f32::min, f32::INFINITY));
            accessor["max"] = json!(extreme(f32::max, f32::NEG_INFINITY));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn add_mesh(&mut self, mesh: &LitMesh, name: &str, material: usize) {
        let attributes = json!({
            "POSITION": self.add_vectors(&mesh.positions.iter().map(|v| v.to_array()).collect::<Vec<_>>()),
            "NORMAL": self.add_vectors(&mesh.normals.iter().map(|v| v.to_array()).collect::<Vec<_>>()),
            "TANGENT": self.add_vectors(&mesh.tangents.iter().map(|v| v.to_array()).collect::<Vec<_>>()),
            "TEXCOORD_0": self.add_vectors(&mesh.uvs.iter().map(|v| v.to_array()).collect::<Vec<_>>()),
            "TEXCOORD_1": self.add_vectors(&mesh.lightmap_uvs.iter().map(|v| v.to_array()).collect::<Vec<_>>()),
        });
        let bytes: Vec<u8> = mesh.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.add_view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": mesh.indices.len(), "type": "SCALAR",
        }));
        let primitive =
            json!({ "attributes": attributes, "indices": self.accessors.len() - 1, "material": material });
        self.nodes.push(json!({ "name": name, "mesh": self.meshes.len() }));
        self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
    }

    /// A node that shines; returns its light.
    fn add_light(&mut self, light: &Light) -> Value {
        let strength = |color: Vec3| {
            let strongest = color.max_element();
            let hue = if strongest > 0.0 { color / strongest } else { Vec3::ONE };
            (json!(hue.to_array()), strongest)
        };
        let (kind, (color, intensity), range, position, direction) = match light {
            Light::Point { position, intensity, range } => {
                ("point", strength(*intensity), *range, *position, None)
            }
            Light::Spot { position, direction, intensity, range, .. } => {
                ("spot", strength(*intensity), *range, *position, Some(*direction))
            }
            Light::Directional { direction, irradiance } => {
                ("directional", strength(*irradiance), None, Vec3::ZERO, Some(*direction))
            }
        };
        let number = self.nodes.iter().filter(|node| node["extensions"].is_object()).count();
        let mut node = json!({
            "name": kind,
            "translation": position.to_array(),
            "extensions": { "KHR_lights_punctual": { "light": number } },
        });
        if let Some(direction) = direction {
            let rotation = probelight_math::glam::Quat::from_rotation_arc(Vec3::NEG_Z, direction);
            node["rotation"] = json!(rotation.to_array());
        }
        self.nodes.push(node);
        let mut written = json!({ "type": kind, "color": color, "intensity": intensity });
        if let Some(range) = range {
            written["range"] = json!(range);
        }
        if let Light::Spot { inner_angle, outer_angle, .. } = light {
            // The format asks for an inner cone that is smaller, and for at most a right angle.
            let outer = outer_angle.min(std::f32::consts::FRAC_PI_2);
            let inner = inner_angle.min(0.999 * outer);
            written["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        }
        written
    }

    fn add_image(&mut self, texture: &Texture) -> anyhow::Result<Value> {
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(&texture.rgba8, texture.width, texture.height, ExtendedColorType::Rgba8)
            .with_context(|| format!("cannot encode the texture {:?}", texture.name))?;
        let view = self.add_view(&png, None);
        Ok(json!({ "name": texture.name, "bufferView": view, "mimeType": "image/png" }))
    }
}

/// A texture as materials name it. Meshes have one set of coordinates for textures: the first.
fn slot(slot: TextureSlot) -> Value {
    json!({ "index": slot.texture, "texCoord": 0 })
}

fn material(material: &Material) -> Value {
    let mut reflection = Map::new();
    reflection.insert("baseColorFactor".into(), json!(material.base_color.to_array()));
    reflection.insert("metallicFactor".into(), json!(material.metallic));
    reflection.insert("roughnessFactor".into(), json!(material.roughness));
    let mut written = Map::from_iter([
        ("name".into(), json!(material.name)),
        ("doubleSided".into(), json!(material.double_sided)),
    ]);
    for (name, texture) in [
        ("baseColorTexture", material.base_color_texture),
        ("metallicRoughnessTexture", material.metallic_roughness_texture),
    ] {
        if let Some(texture) = texture {
            reflection.insert(name.into(), slot(texture));
        }
    }
    written.insert("pbrMetallicRoughness".into(), reflection.into());
    if let Some(texture) = material.normal_texture {
        let mut normal = slot(texture);
        normal["scale"] = json!(material.normal_scale);
        written.insert("normalTexture".into(), normal);
    }
    for (name, texture) in
        [("occlusionTexture", material.occlusion_texture), ("emissiveTexture", material.emissive_texture)]
    {
        if let Some(texture) = texture {
            written.insert(name.into(), slot(texture));
        }
    }
    let strength = material.emission.max_element();
    let factor = material.emission / strength.max(1.0);
    written.insert("emissiveFactor".into(), json!(factor.to_array()));
    if strength > 1.0 {
        let extension = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength } });
        written.insert("extensions".into(), extension);
    }
    if let AlphaMode::Mask { cutoff } = material.alpha_mode {
        written.insert("alphaMode".into(), json!("MASK"));
        written.insert("alphaCutoff".into(), json!(cutoff));
    }
    written.into()
}

/// The container of document and bytes (glTF 2.0, section 4.4).
fn container(document: &Value, mut bytes: Vec<u8>) -> anyhow::Result<Vec<u8>> {
    let mut json = serde_json::to_vec(document)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + bytes.len();
    let number = |value: usize| u32::try_from(value).context("the file would be larger than 4 GB");
    let mut file = Vec::with_capacity(length);
    file.extend_from_slice(b"glTF");
    file.extend_from_slice(&2u32.to_le_bytes());
    file.extend_from_slice(&number(length)?.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
        file.extend_from_slice(&number(chunk.len())?.to_le_bytes());
        file.extend_from_slice(kind);
        file.extend_from_slice(chunk);
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use probelight_bake::BakeOptions;
    use probelight_scene::{Scene, parse_gltf};
    use probelight_trace::Silent;

    use super::*;

    fn baked(glb: &[u8]) -> BakedScene {
        let scene = Arc::new(parse_gltf(glb, Path::new("a.glb")).unwrap());
        let options = BakeOptions {
            receivers: Some(800),
            gather_rays: Some(16),
            relight_rays: Some(16),
            grid_vertices: Some(0),
            ..BakeOptions::default()
        };
        probelight_bake::bake(scene, &options, None, &Silent).unwrap()
    }

    fn area(scene: &Scene, material: usize) -> f64 {
        let triangles = 0..scene.triangles.len();
        let of_material = triangles.filter(|t| scene.triangle_material[*t] as usize == material);
        of_material.map(|t| f64::from(scene.area(t))).sum()
    }

    #[test]
    fn what_is_written_is_read_again() {
        let baked = baked(include_bytes!("../../../../assets/scenes/cornell.glb"));
        let lights = [
            Light::Point { position: Vec3::ONE, intensity: Vec3::new(3.0, 2.0, 1.0), range: Some(9.0) },
            Light::Spot {
                position: Vec3::ONE,
                direction: Vec3::new(0.6, -0.8, 0.0),
                intensity: Vec3::ONE,
                inner_angle: 0.2,
                outer_angle: 0.4,
                range: None,
            },
            Light::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(4.0) },
        ];
        let again = parse_gltf(&glb(&baked, &lights).unwrap(), Path::new("b.glb")).unwrap();
        assert!(again.warnings.is_empty(), "{:?}", again.warnings);
        let names = |scene: &Scene| scene.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
        // Files without it get glTF's default material behind their own.
        let count = baked.scene.materials.len();
        assert_eq!(names(&again)[..count], names(&baked.scene));
        for (material, (a, b)) in baked.scene.materials.iter().zip(&again.materials).enumerate() {
            assert_eq!(
                (a.base_color, a.emission, a.double_sided),
                (b.base_color, b.emission, b.double_sided)
            );
            // Backs with light of their own are there a second time.
            assert!(area(&again, material) >= 0.999 * area(&baked.scene, material));
        }
        assert_eq!(again.lights.len(), 3);
        assert_eq!(again.lights[0], lights[0]);
        let Light::Spot { direction, inner_angle, .. } = again.lights[1] else { panic!() };
        assert!(direction.abs_diff_eq(Vec3::new(0.6, -0.8, 0.0), 1e-5) && (inner_angle - 0.2).abs() < 1e-5);
        let Light::Directional { direction, .. } = again.lights[2] else { panic!() };
        assert!(direction.abs_diff_eq(Vec3::NEG_Y, 1e-5));
    }

    #[test]
    fn lightmap_coordinates_are_those_of_the_bake() {
        let baked = baked(include_bytes!("../../../../assets/scenes/cornell.glb"));
        let again = parse_gltf(&glb(&baked, &[]).unwrap(), Path::new("b.glb")).unwrap();
        let size = [baked.lightmap.width as f32, baked.lightmap.height as f32];
        let texel = |scene: &Scene, t: usize| {
            let corners = scene.triangles[t].map(|v| scene.uv1[v as usize]);
            corners.map(|uv| [uv.x * size[0], uv.y * size[1]])
        };
        let mut found = 0;
        for t in 0..again.triangles.len() {
            let corners = again.corners(t);
            // The triangle of the bake in the same place, of either side.
            let same = (0..baked.scene.triangles.len()).find_map(|original| {
                let [a, b, c] = baked.scene.corners(original);
                let matches =
                    |other: [Vec3; 3]| corners.iter().zip(other).all(|(p, q)| p.abs_diff_eq(q, 1e-6));
                let front = matches([a, b, c]).then_some((original as u32, false));
                front.or(matches([a, c, b]).then_some((original as u32, true)))
            });
            let (original, is_back) = same.expect("every triangle is one of the bake");
            let Some(face) = baked.lightmap.face(original, is_back) else { continue };
            let order = if is_back { [0, 2, 1] } else { [0, 1, 2] };
            for (corner, found) in order.into_iter().zip(texel(&again, t)) {
                assert!((face.corners[corner].x - found[0]).abs() < 0.01, "{found:?}");
                assert!((face.corners[corner].y - found[1]).abs() < 0.01, "{found:?}");
            }
            found += 1;
        }
        assert!(found > 20, "{found}");
    }
}
