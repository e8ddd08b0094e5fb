//! The bytes a document refers to: buffers, buffer views, external files and data URIs.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::Document;

use super::Reason;

/// Most bytes of all buffers together. Many buffers may name the same file.
const MAX_BUFFER_BYTES: u64 = 8 << 30;

/// Accepts data URIs with and without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Most bytes of one image file.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// Reads a regular file of at most `limit` bytes. Devices and pipes, which may never end, are refused.
fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let refuse = |reason: String| Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    let mut file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return refuse("it is not a regular file".into());
    }
    if metadata.len() > limit {
        return refuse(format!("it holds {} bytes; at most {limit} can be used", metadata.len()));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // Not a byte more, should the file grow meanwhile.
    file.by_ref().take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads the document itself.
pub(super) fn read_document(path: &Path) -> io::Result<Vec<u8>> {
    read_file(path, MAX_BUFFER_BYTES)
}

/// All buffers of a document, and the folder that relative URIs start from.
pub(super) struct Resources<'a> {
    buffers: Vec<Cow<'a, [u8]>>,
    folder: PathBuf,
}

impl<'a> Resources<'a> {
    /// Reads all buffers; `binary` is the binary chunk of a `.glb`.
    pub(super) fn load(document: &Document, binary: Option<&'a [u8]>, folder: &Path) -> Result<Self, Reason> {
        let mut resources = Self { buffers: Vec::new(), folder: folder.into() };
        let mut held_bytes = 0;
        for buffer in document.buffers() {
            let index = buffer.index();
            let bytes = match buffer.source() {
                gltf::buffer::Source::Bin => {
                    let chunk = binary.filter(|_| index == 0);
                    Cow::Borrowed(chunk.ok_or_else(|| {
                        format!("buffers[{index}] has no uri, and the file no binary chunk for it")
                    })?)
                }
                gltf::buffer::Source::Uri(uri) => {
                    let left = MAX_BUFFER_BYTES - held_bytes;
                    Cow::Owned(resources.read_uri(uri, left).map_err(|e| format!("buffers[{index}]: {e}"))?)
                }
            };
            held_bytes += bytes.len() as u64;
            if held_bytes > MAX_BUFFER_BYTES {
                return Err(format!("its buffers hold more than {} GiB; divide it", MAX_BUFFER_BYTES >> 30));
            }
            if bytes.len() < buffer.length() {
                let (held, claimed) = (bytes.len(), buffer.length());
                return Err(format!("buffers[{index}] holds {held} of the {claimed} bytes it claims"));
            }
            resources.buffers.push(bytes);
        }
        Ok(resources)
    }

    /// The bytes of a buffer view.
    pub(super) fn view(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8], Reason> {
        let buffer = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer.get(view.offset()..end)).ok_or_else(|| {
            format!("bufferViews[{}] reaches beyond its buffer of {} bytes", view.index(), buffer.len())
        })
    }

    /// The bytes of an image file behind a URI.
    pub(super) fn read_image(&self, uri: &str) -> Result<Vec<u8>, Reason> {
        self.read_uri(uri, MAX_IMAGE_BYTES)
    }

    /// The bytes behind a URI, at most `limit`: base64 data, or a file in the document's folder or below.
    ///
    /// Links in that folder are followed wherever they lead: whoever made them is at home there, and versioned or
    /// built folders often consist of links. A document cannot make any.
    fn read_uri(&self, uri: &str, limit: u64) -> Result<Vec<u8>, Reason> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (_, encoded) = data
                .split_once(";base64,")
                .ok_or("its data URI is not base64; only \"data:…;base64,…\" can be read")?;
            return BASE64
                .decode(encoded)
                .map_err(|error| format!("its data URI is not valid base64 ({error})"));
        }
        let path = self.folder.join(relative_path(uri)?);
        read_file(&path, limit).map_err(|error| format!("cannot read {} ({error})", path.display()))
    }
}

/// The path that a URI means, if it is relative and stays in the folder that it starts from.
fn relative_path(uri: &str) -> Result<PathBuf, Reason> {
    // A colon before the first slash ends a scheme, or the name of a drive.
    if uri.split('/').next().is_some_and(|beginning| beginning.contains(':')) {
        return Err(format!("\"{uri}\" is not a relative path; download it beside the scene"));
    }
    // Exporters on Windows leave its separators in.
    let path = PathBuf::from(decode_percent(uri)?.replace('\\', "/"));
    let mut depth = 0;
    for component in path.components() {
        depth += match component {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            // Nothing comes back from there.
            Component::RootDir | Component::Prefix(_) => i32::MIN,
        };
        if depth < 0 {
            return Err(format!("\"{uri}\" leaves the scene's folder; copy what it names into it"));
        }
    }
    Ok(path)
}

/// Replaces each `%XX` by the byte it stands for.
fn decode_percent(uri: &str) -> Result<String, Reason> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let code = tail.get(..2).filter(|_| first == b'%').and_then(|code| std::str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).map_err(|_| format!("\"{uri}\" is not a valid path"))
}
