//! Images and texture coordinates of glTF files.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use std::io::Cursor;

use glb::{Glb, warned};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::Scene;
use serde_json::{Value, json};

fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn red_then_blue() -> DynamicImage {
    ImageBuffer::from_fn(2, 1, |x, _| if x == 0 { Rgb([255u8, 0, 0]) } else { Rgb([0, 0, 255]) }).into()
}

/// The triangle with an image as base colour; `slot` is its textureInfo.
fn textured(image: &[u8], slot: Value) -> Glb {
    let mut glb = Glb::triangle();
    let uvs = glb.push_floats("VEC2", &[0.25, 0.5, 0.75, 0.5, 0.25, 0.5]);
    let view = glb.push_view(image);
    glb.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    glb.primitive()["material"] = json!(0);
    glb.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    glb.json["textures"] = json!([{"source": 0}]);
    glb.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": slot}}]);
    glb
}

fn albedo_at_corners(scene: &Scene) -> [Vec3; 2] {
    [Vec2::ZERO, Vec2::X].map(|barycentric| scene.albedo(0, barycentric))
}

#[test]
fn images_of_any_depth_become_rgba8() {
    let grey16: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_pixel(1, 1, Luma([0x8080]));
    let grey8: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_pixel(1, 1, Luma([0x80]));
    let rgb16: ImageBuffer<Rgb<u16>, _> = ImageBuffer::from_pixel(1, 1, Rgb([0x8080; 3]));
    for image in [png(grey16), png(grey8), png(rgb16)] {
        let scene = textured(&image, json!({"index": 0})).load().unwrap();
        assert_eq!(*scene.textures[0].rgba8, [0x80, 0x80, 0x80, 0xff]);
    }
}

#[test]
fn images_are_told_by_content_and_decoded_once() {
    let mut glb = textured(&png(red_then_blue()), json!({"index": 0}));
    glb.json["images"][0].as_object_mut().unwrap().remove("mimeType");
    glb.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    let scene = glb.load().unwrap();
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(albedo_at_corners(&scene), [Vec3::X, Vec3::Z]);
}

#[test]
fn webp_images_are_decoded_and_taken_first() {
    let mut webp = Cursor::new(Vec::new());
    red_then_blue().write_to(&mut webp, ImageFormat::WebP).unwrap();
    let grey: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_pixel(1, 1, Luma([0x80]));
    let mut glb = textured(&png(grey), json!({"index": 0}));
    let view = glb.push_view(webp.get_ref());
    let image = glb.push("images", json!({"bufferView": view, "mimeType": "image/webp"}));
    assert_ne!(albedo_at_corners(&glb.load().unwrap()), [Vec3::X, Vec3::Z]);
    for source in [json!({}), json!({"source": 0})] {
        glb.json["textures"] = json!([source]);
        glb.json["textures"][0]["extensions"] = json!({"EXT_texture_webp": {"source": image}});
        let scene = glb.load().unwrap();
        assert_eq!((albedo_at_corners(&scene), warned(&scene, "left out")), ([Vec3::X, Vec3::Z], 0));
    }
}

#[test]
fn materials_too_white_to_be_real_are_counted() {
    let too_white = |level: u8, factor: f32| {
        let grey: ImageBuffer<Luma<u8>, _> = ImageBuffer::from_pixel(3, 2, Luma([level]));
        let mut glb = textured(&png(grey), json!({"index": 0}));
        let model = &mut glb.json["materials"][0]["pbrMetallicRoughness"];
        model["baseColorFactor"] = json!([0.5, factor, 0.5, 1]);
        glb.push("materials", json!({"name": "white, but nothing is made of it"}));
        warned(&glb.load().unwrap(), "reflect more than 95 %")
    };
    // 249 of 255 is 0.947 in linear light, 250 is 0.956.
    assert_eq!([too_white(250, 1.0), too_white(249, 1.0), too_white(255, 0.9)], [1, 0, 0]);
}

#[test]
fn texture_transforms_are_baked_into_the_coordinates() {
    let transformed = |transform: Value| {
        let slot = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
        let mut glb = textured(&png(red_then_blue()), slot);
        glb.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
        glb.json["extensionsRequired"] = json!(["KHR_texture_transform"]);
        glb.load().unwrap()
    };
    let shifted = transformed(json!({"offset": [0.5, 0]}));
    assert_eq!(albedo_at_corners(&shifted), [Vec3::Z, Vec3::X]);
    let all =
        transformed(json!({"offset": [1, 2], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 4]}));
    // (0.25, 0.5) scaled is (0.5, 2); a counter-clockwise quarter turn with v down gives (2, -0.5).
    assert!(all.uv0[0].abs_diff_eq(Vec2::new(3.0, 1.5), 1e-5), "{}", all.uv0[0]);
}

#[test]
fn texture_transforms_that_disagree_are_counted() {
    let mut glb = textured(&png(red_then_blue()), json!({"index": 0}));
    let transform = json!({"KHR_texture_transform": {"offset": [0.5, 0]}});
    glb.json["materials"][0]["normalTexture"] = json!({"index": 0, "extensions": transform});
    let scene = glb.load().unwrap();
    assert_eq!(warned(&scene, "texture transforms"), 1);
    assert_eq!(scene.uv0[0], Vec2::new(0.25, 0.5));
}

#[test]
fn unusual_textures_are_left_out_or_repeated_and_counted() {
    let mut glb = textured(&png(red_then_blue()), json!({"index": 0, "texCoord": 2}));
    assert_eq!(warned(&glb.load().unwrap(), "third or later"), 1);
    glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    glb.json["samplers"] = json!([{"wrapS": 33071}]);
    glb.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    assert_eq!(warned(&glb.load().unwrap(), "clamp or mirror"), 1);
    glb.json["textures"] = json!([{}]);
    let scene = glb.load().unwrap();
    assert_eq!(warned(&scene, "without a PNG, JPEG or WebP"), 1);
    assert_eq!(albedo_at_corners(&scene), [Vec3::ONE; 2]);
}
