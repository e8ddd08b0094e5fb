//! Writes small binary glTF files.

use std::path::Path;

use probelight_scene::{Scene, SceneError, load_gltf, parse_gltf};
use serde_json::{Value, json};

pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A document and its binary chunk. All data go to buffer 0.
pub(crate) struct Glb {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

impl Glb {
    /// One node with one triangle in the plane z = 0, front to +z, area 1, indexed, without normals.
    pub(crate) fn triangle() -> Self {
        let mut glb = Self {
            json: json!({
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "accessors": [], "bufferViews": [],
            }),
            binary: Vec::new(),
        };
        glb.push_floats("VEC3", &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        glb.push_accessor(U16, "SCALAR", 3, &[0, 0, 1, 0, 2, 0]);
        glb
    }

    /// Appends bytes as a buffer view; returns its index.
    pub(crate) fn push_view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend(bytes);
        self.push("bufferViews", view)
    }

    /// Appends elements as an accessor; returns its index.
    pub(crate) fn push_accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.push_view(bytes);
        let mut accessor =
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        if kind == "VEC3" {
            accessor["min"] = json!([0, 0, 0]);
            accessor["max"] = json!([1, 1, 1]);
        }
        self.push("accessors", accessor)
    }

    /// Gives the triangle a material with a PNG image of these bytes.
    pub(crate) fn add_image(&mut self, bytes: &[u8]) {
        let view = self.push_view(bytes);
        self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": 0}));
        self.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
        self.primitive()["material"] = json!(0);
    }

    /// Appends floating-point elements as an accessor; returns its index.
    pub(crate) fn push_floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let components = match kind {
            "SCALAR" => 1,
            "MAT4" => 16,
            vector => vector[3..].parse::<usize>().unwrap(),
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.push_accessor(F32, kind, numbers.len() / components, &bytes)
    }

    /// Appends to a top-level array, which is made if there is none; returns the index.
    pub(crate) fn push(&mut self, array: &str, value: Value) -> usize {
        if self.json[array].is_null() {
            self.json[array] = json!([]);
        }
        let values = self.json[array].as_array_mut().unwrap();
        values.push(value);
        values.len() - 1
    }

    /// The first primitive.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// The bytes of the `.glb` file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        let mut text = serde_json::to_vec(&json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + binary.len();
        let mut bytes = b"glTF".to_vec();
        bytes.extend(2u32.to_le_bytes());
        bytes.extend((length as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    pub(crate) fn load(&self) -> Result<Scene, SceneError> {
        load_bytes(&self.bytes())
    }
}

/// Reads bytes as if they were a file named `scene.glb`.
pub(crate) fn load_bytes(bytes: &[u8]) -> Result<Scene, SceneError> {
    parse_gltf(bytes, Path::new("scene.glb"))
}

/// Loads a scene of the repository.
pub(crate) fn load_asset(name: &str) -> Scene {
    load_gltf(&asset(name)).unwrap()
}

/// Where a scene of the repository lies.
pub(crate) fn asset(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes").join(name)
}

/// How often a warning that contains `text` was counted.
pub(crate) fn warned(scene: &Scene, text: &str) -> usize {
    scene.warnings.iter().filter(|warning| warning.message.contains(text)).map(|warning| warning.count).sum()
}
