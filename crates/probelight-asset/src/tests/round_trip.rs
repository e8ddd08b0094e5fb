//! What is written comes back.

use super::fixture::baked_scene;
use crate::BakedScene;
use crate::error::DecodeError;

fn encoded(baked: &BakedScene) -> Vec<u8> {
    let mut bytes = Vec::new();
    baked.encode(&mut bytes).unwrap();
    bytes
}

fn decoded(bytes: &[u8]) -> Result<BakedScene, DecodeError> {
    BakedScene::decode(bytes, bytes.len() as u64)
}

#[test]
fn every_field_survives() {
    let baked = baked_scene();
    baked.validate().unwrap();
    let read = decoded(&encoded(&baked)).unwrap();
    // `Debug` shows every field of every part, with all digits.
    assert_eq!(format!("{read:#?}"), format!("{baked:#?}"));
    assert_eq!(encoded(&read), encoded(&baked));
}

#[test]
fn files_on_disk_come_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.plight");
    let baked = baked_scene();
    baked.write(&path).unwrap();
    let read = BakedScene::read(&path).unwrap();
    assert_eq!(format!("{read:?}"), format!("{baked:?}"));
    assert_eq!(std::fs::read(&path).unwrap(), encoded(&baked));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
