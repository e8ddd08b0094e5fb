//! Remembering the finished part of a bake, so that an interrupted one can go on.
//!
//! The file holds a fingerprint of the input and settings, then one checksummed record per finished group
//! of receivers. A record that is cut short or damaged ends the useful part; whatever follows is baked
//! again.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use crate::BakeError;
use crate::compression::CompressedCluster;

/// First bytes of the file.
const MAGIC: &[u8; 8] = b"PLIGHTck";

/// Bytes of the magic and the fingerprint.
const HEADER_BYTES: u64 = 16;

/// What one group of receivers came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FinishedGroup {
    pub(crate) clusters: Vec<CompressedCluster>,
    pub(crate) approximated_rays: u64,
    pub(crate) uncovered_rays: u64,
}

/// Finished groups on disk, appended to while the bake runs.
pub(crate) struct Checkpoint {
    path: PathBuf,
    file: Mutex<File>,
}

impl Checkpoint {
    /// Opens the checkpoint of a bake with this fingerprint and returns what it already holds. A checkpoint
    /// of another bake is overwritten, a file that is no checkpoint is refused.
    pub(crate) fn open(
        path: &Path,
        fingerprint: u64,
    ) -> Result<(Self, HashMap<u32, FinishedGroup>), BakeError> {
        let failed = |action| {
            let path = path.to_path_buf();
            move |source| BakeError::Checkpoint { action, path, source }
        };
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed("read"))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed("read"))?;
        if !is_checkpoint(&bytes) {
            return Err(BakeError::NotACheckpoint { path: path.into() });
        }
        let (finished, useful) = read_records(&bytes, fingerprint);
        file.set_len(useful).map_err(failed("write"))?;
        file.seek(SeekFrom::Start(useful)).map_err(failed("write"))?;
        if useful == 0 {
            let mut header = MAGIC.to_vec();
            header.extend(fingerprint.to_le_bytes());
            file.write_all(&header).map_err(failed("write"))?;
        }
        Ok((Self { path: path.into(), file: Mutex::new(file) }, finished))
    }

    /// Appends a finished group.
    pub(crate) fn append(&self, group: u32, finished: &FinishedGroup) -> Result<(), BakeError> {
        let failed = |source| BakeError::Checkpoint { action: "write", path: self.path.clone(), source };
        let payload =
            postcard::to_stdvec(&(group, finished)).map_err(|e| failed(std::io::Error::other(e)))?;
        let mut record = (payload.len() as u64).to_le_bytes().to_vec();
        record.extend(xxh3_64(&payload).to_le_bytes());
        record.extend(payload);
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.write_all(&record).map_err(failed)
    }

    /// Removes the file once the bake is complete. That it may stay behind is harmless.
    pub(crate) fn remove(self) {
        drop(self.file);
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Refuses a path at which there is something else than a checkpoint.
///
/// # Errors
/// [`BakeError::NotACheckpoint`], or [`BakeError::Checkpoint`] if it cannot be read.
pub(crate) fn refuse_foreign_file(path: &Path) -> Result<(), BakeError> {
    let failed = |source| BakeError::Checkpoint { action: "read", path: path.into(), source };
    let mut start = Vec::new();
    match File::open(path) {
        Ok(file) => file.take(MAGIC.len() as u64).read_to_end(&mut start).map_err(failed)?,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(failed(error)),
    };
    if is_checkpoint(&start) { Ok(()) } else { Err(BakeError::NotACheckpoint { path: path.into() }) }
}

/// Removes what an interrupted bake has left at a path, if anything.
///
/// # Errors
/// [`BakeError::NotACheckpoint`] if there is a file of another kind, which stays; [`BakeError::Checkpoint`] if it
/// cannot be read or removed.
pub fn discard_checkpoint(path: &Path) -> Result<(), BakeError> {
    refuse_foreign_file(path)?;
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(BakeError::Checkpoint { action: "remove", path: path.into(), source: error })
        }
        _ => Ok(()),
    }
}

/// Whether a file starts as a checkpoint does, as far as it goes: it may have been cut short.
fn is_checkpoint(bytes: &[u8]) -> bool {
    let length = bytes.len().min(MAGIC.len());
    bytes[..length] == MAGIC[..length]
}

/// The intact records of a file with this fingerprint, and how many bytes they and the header take.
fn read_records(bytes: &[u8], fingerprint: u64) -> (HashMap<u32, FinishedGroup>, u64) {
    let mut finished = HashMap::new();
    let header_matches = bytes.get(..8) == Some(MAGIC) && read_u64(bytes, 8) == Some(fingerprint);
    if !header_matches {
        return (finished, 0);
    }
    let mut at = HEADER_BYTES as usize;
    while let Some((group, record, end)) = read_record(bytes, at) {
        finished.insert(group, record);
        at = end;
    }
    (finished, at as u64)
}

fn read_record(bytes: &[u8], at: usize) -> Option<(u32, FinishedGroup, usize)> {
    let length = usize::try_from(read_u64(bytes, at)?).ok()?;
    let checksum = read_u64(bytes, at + 8)?;
    let end = at.checked_add(16)?.checked_add(length)?;
    let payload = bytes.get(at + 16..end)?;
    if xxh3_64(payload) != checksum {
        return None;
    }
    let (group, record) = postcard::from_bytes(payload).ok()?;
    Some((group, record, end))
}

fn read_u64(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use probelight_asset::packed::Ranks;

    use crate::compression::quantize::PackedFactors;

    use super::*;

    fn group(seed: u32) -> FinishedGroup {
        FinishedGroup {
            clusters: vec![CompressedCluster {
                receivers: vec![seed, seed + 1],
                signals: vec![4],
                probes: vec![3],
                factors: PackedFactors {
                    receiver_ranks: Ranks { snorm8: 1, ..Ranks::default() },
                    signal_ranks: Ranks { snorm4: 1, ..Ranks::default() },
                    receiver_basis: vec![0x4041],
                    signal_basis: vec![0x7f81, 0xff],
                    row_scales: vec![2.0],
                    column_exponents: vec![0, 8, 16, 24, 255],
                    error: 0.1,
                    receiver_errors: vec![64, 3],
                },
            }],
            approximated_rays: 7,
            uncovered_rays: 1,
        }
    }

    #[test]
    fn finished_groups_come_back_and_damage_only_costs_what_follows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bake.partial");
        let (checkpoint, finished) = Checkpoint::open(&path, 42).unwrap();
        assert!(finished.is_empty());
        checkpoint.append(0, &group(10)).unwrap();
        checkpoint.append(5, &group(20)).unwrap();
        drop(checkpoint);

        let (_, finished) = Checkpoint::open(&path, 42).unwrap();
        assert_eq!(finished, HashMap::from([(0, group(10)), (5, group(20))]));

        let intact = std::fs::read(&path).unwrap();
        for cut in 0..intact.len() {
            std::fs::write(&path, &intact[..cut]).unwrap();
            let (_, finished) = Checkpoint::open(&path, 42).unwrap();
            assert!(finished.len() < 2 && finished.get(&0).is_none_or(|g| *g == group(10)));
        }
        for flipped in 0..intact.len() {
            let mut damaged = intact.clone();
            damaged[flipped] ^= 0x10;
            std::fs::write(&path, &damaged).unwrap();
            match Checkpoint::open(&path, 42) {
                Ok((_, finished)) => assert!(flipped >= MAGIC.len() && finished.len() < 2, "byte {flipped}"),
                Err(_) => assert!(flipped < MAGIC.len(), "byte {flipped}"),
            }
        }
    }

    #[test]
    fn another_bakes_checkpoint_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bake.partial");
        Checkpoint::open(&path, 1).unwrap().0.append(0, &group(1)).unwrap();
        assert!(Checkpoint::open(&path, 2).unwrap().1.is_empty());
    }

    #[test]
    fn other_files_are_refused_and_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bake.partial");
        std::fs::write(&path, "a letter to a friend").unwrap();
        let is_refused = |error| matches!(error, BakeError::NotACheckpoint { .. });
        assert!(Checkpoint::open(&path, 1).is_err_and(is_refused));
        assert!(refuse_foreign_file(&path).is_err_and(is_refused));
        assert!(discard_checkpoint(&path).is_err_and(is_refused));
        assert_eq!(std::fs::read(&path).unwrap(), b"a letter to a friend");
        // Negative control: a checkpoint goes, be it empty.
        std::fs::write(&path, "").unwrap();
        discard_checkpoint(&path).unwrap();
        assert!(!path.exists());
        discard_checkpoint(&path).unwrap();
    }
}
