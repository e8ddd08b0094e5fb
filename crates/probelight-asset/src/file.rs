//! Baked scenes in the file system.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::error::DecodeError;
use crate::read::SectionReader;
use crate::{AssetError, BakedInfo, BakedScene, write_atomically};

impl BakedScene {
    /// Writes the file atomically: `path` is replaced when everything is on the disk, or not at all. The
    /// same scene always gives the same bytes.
    ///
    /// # Errors
    /// [`AssetError::Io`] if the disk refuses.
    pub fn write(&self, path: &Path) -> Result<(), AssetError> {
        write_atomically(path, |file| self.write_to(file)).map_err(|source| AssetError::Io {
            action: "write",
            path: path.into(),
            source,
        })
    }

    /// Reads a file that [`write`](Self::write) has written.
    ///
    /// # Errors
    /// [`AssetError::Format`] for anything but a whole, undamaged file of this format version;
    /// [`AssetError::Io`] if the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, AssetError> {
        read_with(path, Self::decode)
    }

    /// Reads and checks only the header, the section table and the settings of a file.
    ///
    /// # Errors
    /// As [`read`](Self::read), except that damage in the arrays goes unnoticed.
    pub fn read_info(path: &Path) -> Result<BakedInfo, AssetError> {
        read_with(path, BakedInfo::decode)
    }
}

fn read_with<T>(
    path: &Path,
    decode: impl FnOnce(SectionReader<'_>) -> Result<T, DecodeError>,
) -> Result<T, AssetError> {
    let read = || {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        // A pipe has no length.
        let length = metadata.is_file().then_some(metadata.len());
        decode(SectionReader::begin(&mut BufReader::new(file), length)?)
    };
    read().map_err(|error: DecodeError| error.at(path))
}
