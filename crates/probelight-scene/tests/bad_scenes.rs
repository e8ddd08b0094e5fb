//! Broken glTF files: each gives one error that says what is wrong, and costs little memory.
#![cfg(feature = "gltf")]
#![allow(missing_docs, reason = "a test binary has no documentation")]

#[expect(dead_code, reason = "other tests use the rest")]
mod glb;

use glb::{F32, Glb, U8, U16, U32, load_bytes};
use serde_json::json;

struct BadScene {
    name: &'static str,
    spoil: fn(&mut Glb),
    /// Part of the message.
    message: &'static str,
}

const BAD_SCENES: &[BadScene] = &[
    BadScene { name: "no meshes", spoil: |glb| glb.json["nodes"] = json!([{}]), message: "no triangles" },
    BadScene {
        name: "only triangles without area",
        spoil: |glb| glb.binary[..36].fill(0),
        message: "no triangles",
    },
    BadScene {
        name: "scaled to nothing",
        spoil: |glb| glb.json["nodes"][0]["scale"] = json!([0, 0, 0]),
        message: "no triangles",
    },
    BadScene {
        name: "NaN position",
        spoil: |glb| glb.binary[0..4].copy_from_slice(&f32::NAN.to_le_bytes()),
        message: "meshes[0].primitives[0]: position 0 is not finite",
    },
    BadScene {
        name: "infinite position",
        spoil: |glb| glb.binary[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes()),
        message: "position 1 is not finite",
    },
    BadScene {
        name: "triangle whose area overflows",
        spoil: |glb| glb.json["nodes"][0]["scale"] = json!([3e37, 3e37, 3e37]),
        message: "more than a number can hold",
    },
    BadScene {
        name: "transform beyond the range of numbers",
        spoil: |glb| {
            let scale = [1e30, 1e30, 1e30];
            glb.json["nodes"] = json!([{"scale": scale, "children": [1]}, {"scale": scale, "mesh": 0}]);
        },
        message: "the transform of nodes[1] is not finite",
    },
    BadScene {
        name: "index out of range",
        spoil: |glb| glb.binary[40] = 3,
        message: "index 3 is out of range: there are 3 vertices",
    },
    BadScene {
        name: "a thousand million vertices",
        spoil: |glb| glb.json["accessors"][0]["count"] = json!(1_000_000_000),
        message: "accessors[0]: its 1000000000 elements of 12 bytes do not fit",
    },
    BadScene {
        name: "a count whose size in bytes overflows",
        spoil: |glb| glb.json["accessors"][0]["count"] = json!(u64::MAX),
        message: "do not fit",
    },
    BadScene {
        name: "a thousand million indices",
        spoil: |glb| glb.json["accessors"][1]["count"] = json!(1_000_000_000),
        message: "claims 333333333 triangles; at most",
    },
    BadScene {
        name: "a thousand million zeros by a sparse accessor",
        spoil: |glb| {
            glb.json["accessors"][0] = json!({
                "componentType": F32, "type": "VEC3", "count": 1_000_000_000,
                "min": [0, 0, 0], "max": [0, 0, 0],
                "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": U16},
                           "values": {"bufferView": 0}}
            });
        },
        message: "has no data for them",
    },
    BadScene {
        name: "sparse index out of range",
        spoil: |glb| {
            glb.json["accessors"][0]["sparse"] = json!({
                "count": 3, "indices": {"bufferView": 2, "componentType": U8},
                "values": {"bufferView": 0}
            });
            glb.push_view(&[0, 1, 3]);
        },
        message: "a sparse index lies beyond its 3 elements",
    },
    BadScene {
        name: "sparse indices that do not increase",
        spoil: |glb| {
            glb.json["accessors"][0]["sparse"] = json!({
                "count": 2, "indices": {"bufferView": 2, "componentType": U8},
                "values": {"bufferView": 0}
            });
            glb.push_view(&[1, 1]);
        },
        message: "do not increase",
    },
    BadScene {
        name: "buffer view beyond its buffer",
        spoil: |glb| glb.json["bufferViews"][0]["byteOffset"] = json!(1000),
        message: "bufferViews[0] reaches beyond its buffer",
    },
    BadScene {
        name: "buffer view whose end overflows",
        spoil: |glb| glb.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
        message: "bufferViews[0] reaches beyond its buffer",
    },
    BadScene {
        name: "accessor offset beyond its view",
        spoil: |glb| glb.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
        message: "do not fit",
    },
    BadScene {
        name: "overlapping elements",
        spoil: |glb| glb.json["bufferViews"][0]["byteStride"] = json!(4),
        message: "overlap",
    },
    BadScene {
        name: "accessor that does not exist",
        spoil: |glb| glb.primitive()["attributes"]["POSITION"] = json!(7),
        message: "meshes[0].primitives[0] uses accessor 7, of 2",
    },
    BadScene {
        name: "mesh that does not exist",
        spoil: |glb| glb.json["nodes"][0]["mesh"] = json!(5),
        message: "nodes[0].mesh",
    },
    BadScene {
        name: "positions of the wrong type",
        spoil: |glb| glb.json["accessors"][0]["type"] = json!("VEC2"),
        message: "Vec3 elements expected, Vec2 found",
    },
    BadScene {
        name: "floating-point indices",
        spoil: |glb| {
            let indices = glb.push_accessor(F32, "SCALAR", 3, &[0; 12]);
            glb.primitive()["indices"] = json!(indices);
        },
        message: "indices must be unsigned integers",
    },
    BadScene {
        name: "fewer normals than positions",
        spoil: |glb| {
            let normals = glb.push_floats("VEC3", &[0.0, 0.0, 1.0]);
            glb.primitive()["attributes"]["NORMAL"] = json!(normals);
        },
        message: "1 elements for 3 positions",
    },
    BadScene {
        name: "claims more bytes than its chunk holds",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 4_000_000_000u32}]),
        message: "buffers[0] holds 44 of the 4000000000 bytes",
    },
    BadScene {
        name: "missing external buffer",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 42, "uri": "nowhere.bin"}]),
        message: "nowhere.bin",
    },
    BadScene {
        name: "a folder for a buffer",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 42, "uri": "."}]),
        message: "not a regular file",
    },
    BadScene {
        name: "buffer on the web",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 42, "uri": "https://example.org/a.bin"}]),
        message: "not a relative path",
    },
    BadScene {
        name: "URI that is not text",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 42, "uri": "%FF%FE.bin"}]),
        message: "not a valid path",
    },
    BadScene {
        name: "data URI with garbage",
        spoil: |glb| {
            let uri = "data:application/octet-stream;base64,!!!";
            glb.json["buffers"] = json!([{"byteLength": 42, "uri": uri}]);
        },
        message: "not valid base64",
    },
    BadScene {
        name: "data URI that is not base64",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 2, "uri": "data:,ab"}]),
        message: "not base64",
    },
    BadScene {
        name: "second buffer without data",
        spoil: |glb| glb.json["buffers"] = json!([{"byteLength": 42}, {"byteLength": 1}]),
        message: "buffers[1] has no uri",
    },
    BadScene {
        name: "required extension",
        spoil: |glb| glb.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        message: "packed with KHR_draco_mesh_compression, which cannot be read; unpack it with `gltf-transform copy",
    },
    BadScene {
        name: "glTF 1.0",
        spoil: |glb| glb.json["asset"]["version"] = json!("1.0"),
        message: "glTF 1.0",
    },
    BadScene {
        name: "node that is its own child",
        spoil: |glb| glb.json["nodes"][0]["children"] = json!([0]),
        message: "nodes[0] has two parents or is its own ancestor",
    },
    BadScene {
        name: "nodes in a circle",
        spoil: |glb| glb.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]),
        message: "its own ancestor",
    },
    BadScene {
        name: "image that does not decode",
        spoil: |glb| glb.add_image(b"this is not an image"),
        message: "images[0]: cannot be decoded as PNG, JPEG or WebP",
    },
    BadScene {
        name: "small image that claims to be enormous",
        spoil: |glb| glb.add_image(&png_header(8000, 8000)),
        message: "claims 8000 × 8000 texels",
    },
    BadScene {
        name: "image with more texels than can be used",
        spoil: |glb| glb.add_image(&png_header(100_000, 4)),
        message: "100000 × 4 texels; at most",
    },
    BadScene {
        name: "image from nowhere",
        spoil: |glb| {
            glb.add_image(b"");
            glb.json["images"] = json!([{}]);
        },
        message: "images[0] has neither a uri nor a bufferView",
    },
    BadScene {
        name: "emission beyond the range of numbers",
        spoil: |glb| {
            let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 1e38}});
            glb.json["materials"] = json!([{}, {"emissiveFactor": [9, 0, 0], "extensions": strength}]);
        },
        message: "materials[1]: it has a factor that is not finite",
    },
    BadScene {
        name: "camera without its numbers",
        spoil: |glb| {
            let lens = json!({"xmag": 1, "ymag": 1, "zfar": 1, "znear": 0});
            glb.json["cameras"] = json!([{"type": "perspective", "orthographic": lens}]);
            glb.json["nodes"][0]["camera"] = json!(0);
        },
        message: "cameras[0] lacks the numbers for its type",
    },
    BadScene {
        name: "spot light without its cone",
        spoil: |glb| {
            glb.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot"}]}});
        },
        message: "spot",
    },
    BadScene {
        name: "light that does not exist",
        spoil: |glb| {
            glb.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 3}});
        },
        message: "light",
    },
    BadScene {
        name: "too many instances",
        spoil: |glb| {
            let vertices = glb.push_floats("VEC3", &vec![0.5; 3 * 300_000]);
            glb.json["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": vertices}}]);
            glb.json["nodes"] = json!(vec![json!({"mesh": 0}); 300]);
            glb.json["scenes"][0]["nodes"] = (0..300).collect();
        },
        message: "claims 30000000 triangles",
    },
    BadScene {
        name: "index type that does not exist",
        spoil: |glb| glb.json["accessors"][1]["componentType"] = json!(5124),
        message: "componentType",
    },
    BadScene {
        name: "JSON of the wrong shape",
        spoil: |glb| glb.json["nodes"] = json!({"mesh": 0}),
        message: "its JSON cannot be read",
    },
    BadScene {
        name: "32-bit index out of range",
        spoil: |glb| {
            let indices = glb.push_accessor(U32, "SCALAR", 3, &[0xff; 12]);
            glb.primitive()["indices"] = json!(indices);
        },
        message: "index 4294967295 is out of range",
    },
];

/// A material whose base colour is this image, used by the triangle.
/// A PNG file that ends after its (correct) header chunk and the start of its data.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut encoded = Vec::new();
    let small = image::RgbaImage::new(1, 1);
    image::DynamicImage::from(small)
        .write_to(&mut std::io::Cursor::new(&mut encoded), image::ImageFormat::Png)
        .unwrap();
    encoded[16..20].copy_from_slice(&width.to_be_bytes());
    encoded[20..24].copy_from_slice(&height.to_be_bytes());
    let checksum = crc32(&encoded[12..29]);
    encoded[29..33].copy_from_slice(&checksum.to_be_bytes());
    encoded
}

/// The checksum of PNG chunks (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

#[test]
fn each_broken_scene_is_refused_for_its_own_reason() {
    assert!(Glb::triangle().load().is_ok());
    let mut failures = Vec::new();
    for bad in BAD_SCENES {
        let mut glb = Glb::triangle();
        (bad.spoil)(&mut glb);
        match glb.load() {
            Ok(_) => failures.push(format!("{}: was accepted", bad.name)),
            Err(error) if error.to_string().contains(bad.message) => {
                assert!(error.to_string().contains("scene.glb"), "{error}");
            }
            Err(error) => failures.push(format!("{}: {error}", bad.name)),
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn files_that_are_no_scene_are_refused() {
    let whole = Glb::triangle().bytes();
    let with_version = |version: u32| {
        let mut bytes = whole.clone();
        bytes[4..8].copy_from_slice(&version.to_le_bytes());
        bytes
    };
    let with_length = |at: usize, length: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
        bytes
    };
    for (bytes, message) in [
        (b"".to_vec(), "JSON"),
        (b"glTF".to_vec(), "truncated"),
        (b"hello, world".to_vec(), "JSON"),
        (b"{}".to_vec(), "asset"),
        (vec![b'['; 1 << 20], "JSON"),
        (whole[..whole.len() / 2].to_vec(), "truncated"),
        (with_version(1), "version 1"),
        (with_length(8, u32::MAX), "truncated"),
        (with_length(8, 0), "buffers[0] has no uri"),
        (with_length(12, u32::MAX), "truncated"),
    ] {
        let error = load_bytes(&bytes).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let error = probelight_scene::load_gltf(std::path::Path::new("/no/such/scene.glb")).unwrap_err();
    assert!(error.to_string().contains("cannot read /no/such/scene.glb"), "{error}");
}
