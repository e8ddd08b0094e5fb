//! The receivers beside borders between clusters, and what they blend with.
//!
//! Borders are blended from light as it was gathered, whichever of two neighbouring clusters a frame computes. What was
//! gathered for the receivers beside borders is kept in *slots*, because blending takes its place among the receivers.

use bytemuck::{Pod, Zeroable};
use probelight_asset::{BorderBlend, Cluster};

use super::plan::ReceiverPlace;

/// Marks the number of a slot where others are those of receivers. There are fewer than half as many.
pub(crate) const BORDER_SLOT: u32 = 1 << 31;

/// What a receiver beside a border blends with across it; see [`BorderBlend`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BorderRecord {
    /// The next receiver across: its slot, or its number.
    pub(crate) neighbor: u32,
    /// The one behind it.
    pub(crate) beyond: u32,
    /// Their cluster.
    pub(crate) across: u32,
}

/// The receivers beside borders in ascending order, whose slots are numbered in this order, and the records of each.
pub(crate) fn border_records(clusters: &[Cluster], blends: &[BorderBlend]) -> Vec<(u32, Vec<BorderRecord>)> {
    let receivers: Vec<u32> = BorderBlend::by_receiver(blends).map(|blends| blends[0].receiver).collect();
    let source = |receiver: u32| match receivers.binary_search(&receiver) {
        Ok(slot) => BORDER_SLOT | slot as u32,
        Err(_) => receiver,
    };
    let record = |blend: &BorderBlend| BorderRecord {
        neighbor: source(blend.neighbor),
        beyond: source(blend.beyond),
        across: ReceiverPlace::at(clusters, blend.neighbor).cluster,
    };
    let of_receiver = |blends: &[BorderBlend]| (blends[0].receiver, blends.iter().map(record).collect());
    BorderBlend::by_receiver(blends).map(of_receiver).collect()
}
