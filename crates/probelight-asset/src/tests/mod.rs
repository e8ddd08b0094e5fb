//! Tests of the whole file.

mod corruption;
mod cross_references;
mod document;
mod fixture;
mod round_trip;
mod sections;

use crate::error::DecodeError;
use crate::{BakedParts, BakedScene};

use fixture::baked_parts;

/// The fixture, checked.
fn baked_scene() -> BakedScene {
    checked(baked_parts())
}

/// Parts that must be valid.
#[track_caller]
fn checked(parts: BakedParts) -> BakedScene {
    BakedScene::new(parts).unwrap()
}

fn encoded(baked: &BakedScene) -> Vec<u8> {
    let mut bytes = Vec::new();
    baked.write_to(&mut bytes).unwrap();
    bytes
}

/// Why `bytes` are refused.
#[track_caller]
fn refusal(bytes: &[u8]) -> String {
    match BakedScene::from_bytes(bytes) {
        Ok(_) => panic!("a damaged file was accepted"),
        Err(DecodeError::Io(error)) => panic!("the slice cannot be read: {error}"),
        Err(DecodeError::Format(reason)) => reason,
    }
}
