//! The borders between clusters, as they follow from where the receivers' texels lie.

use bytemuck::{Pod, Zeroable};

use crate::{BakedParts, BakedScene, NONE};

/// How a receiver beside a border blends with the cluster across.
///
/// Each cluster approximates its own transport, so irradiance would jump where two meet. What the cluster across
/// would say of the receiver is continued from its own receivers next to it, `neighbor` and then `beyond`:
/// `neighbor + (neighbor − beyond)`, with a limit to the slope. The receiver's irradiance is the mean of that for
/// each of its records and of what its own cluster says, counted twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct BorderBlend {
    /// The receiver (index into `receiver_texels`).
    pub receiver: u32,
    /// The next receiver in the lightmap's row or column, across the border.
    pub neighbor: u32,
    /// The one behind it, of the same cluster; `neighbor` itself if there is none.
    pub beyond: u32,
}

impl BorderBlend {
    /// The records of each receiver, of records sorted by receiver.
    pub fn by_receiver(records: &[Self]) -> impl Iterator<Item = &[Self]> {
        records.chunk_by(|a, b| a.receiver == b.receiver)
    }
}

/// Steps to the four neighbours of a texel.
const STEPS: [(i32, i32); 4] = [(-1, 0), (1, 0), (0, -1), (0, 1)];

impl BakedScene {
    /// The records of all borders between clusters of one air space, sorted by receiver; none if the bake is
    /// [not to blend](crate::BakeSettings::blend_borders). Charts never adjoin, so neighbouring texels belong to one.
    pub fn border_blends(&self) -> Vec<BorderBlend> {
        border_blends(self)
    }
}

fn border_blends(baked: &BakedParts) -> Vec<BorderBlend> {
    if !baked.settings.blend_borders {
        return Vec::new();
    }
    let neighbors = Neighbors::of(baked);
    let record = |receiver: u32, step: (i32, i32)| {
        let (here, neighbor) = (neighbors.cluster(receiver), neighbors.next(receiver, step)?);
        let across = neighbors.cluster(neighbor);
        let air_space = |cluster: u32| baked.clusters[cluster as usize].air_space;
        if across == here || air_space(across) != air_space(here) {
            return None;
        }
        // Where the other cluster is but one texel wide, it has no slope to continue.
        let beyond = neighbors.next(neighbor, step).filter(|beyond| neighbors.cluster(*beyond) == across);
        Some(BorderBlend { receiver, neighbor, beyond: beyond.unwrap_or(neighbor) })
    };
    let record = &record;
    (0..baked.receiver_texels.len() as u32)
        .flat_map(|receiver| STEPS.into_iter().filter_map(move |step| record(receiver, step)))
        .collect()
}

/// Which receivers lie beside which.
struct Neighbors<'a> {
    baked: &'a BakedParts,
    receiver_of_texel: Vec<u32>,
    cluster_of_receiver: Vec<u32>,
}

impl<'a> Neighbors<'a> {
    fn of(baked: &'a BakedParts) -> Self {
        let receiver_of_texel = baked.receivers_of_chart_texels();
        Self { baked, receiver_of_texel, cluster_of_receiver: baked.clusters_of_receivers() }
    }

    fn cluster(&self, receiver: u32) -> u32 {
        self.cluster_of_receiver[receiver as usize]
    }

    /// The receiver one step further.
    fn next(&self, receiver: u32, (dx, dy): (i32, i32)) -> Option<u32> {
        let (texel, width) = (self.baked.receiver_texels[receiver as usize], self.baked.lightmap.width);
        let x = (texel % width).checked_add_signed(dx).filter(|x| *x < width)?;
        let y = (texel / width).checked_add_signed(dy)?;
        let next = *self.receiver_of_texel.get(y as usize * width as usize + x as usize)?;
        (next != NONE).then_some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cluster;

    const WIDTH: u32 = 8;

    /// Two rows of eight receivers; clusters meet between the third and fourth of a row. The file has them
    /// backwards.
    fn rows(change: impl Fn(&mut BakedParts)) -> Vec<BorderBlend> {
        let cluster = |receiver_count| Cluster { receiver_count, ..Cluster::default() };
        let mut baked = BakedParts { clusters: vec![cluster(10), cluster(6)], ..BakedParts::default() };
        baked.settings.blend_borders = true;
        (baked.lightmap.width, baked.lightmap.height) = (WIDTH, 2);
        let (left, right): (Vec<u32>, Vec<u32>) = (0..2 * WIDTH).rev().partition(|texel| texel % WIDTH < 3);
        baked.receiver_texels = [right, left].concat();
        change(&mut baked);
        border_blends(&baked)
    }

    /// Where the file has the receiver of a texel.
    fn place(x: u32, y: u32) -> u32 {
        if x < 3 { 10 + 3 * (1 - y) + 2 - x } else { 5 * (1 - y) + WIDTH - 1 - x }
    }

    #[test]
    fn both_sides_of_a_border_are_found_in_the_order_of_the_file() {
        let record = |y, [receiver, neighbor, beyond]: [u32; 3]| BorderBlend {
            receiver: place(receiver, y),
            neighbor: place(neighbor, y),
            beyond: place(beyond, y),
        };
        let expected =
            [record(1, [3, 2, 1]), record(0, [3, 2, 1]), record(1, [2, 3, 4]), record(0, [2, 3, 4])];
        assert_eq!(rows(|_| {}), expected);
    }

    #[test]
    fn air_spaces_are_kept_apart_and_bakes_that_do_not_blend_have_no_records() {
        assert!(rows(|baked| baked.clusters[1].air_space = 1).is_empty());
        assert!(rows(|baked| baked.settings.blend_borders = false).is_empty());
    }

    #[test]
    fn a_slope_ends_where_the_other_cluster_does() {
        // The texels right of the border alone are a cluster of their own.
        let cut = rows(|baked| {
            let narrow = [3, WIDTH + 3];
            baked.receiver_texels.retain(|texel| !narrow.contains(texel));
            baked.receiver_texels.extend(narrow);
            let cluster = |receiver_count| Cluster { receiver_count, ..Cluster::default() };
            baked.clusters = vec![cluster(8), cluster(6), cluster(2)];
        });
        assert_eq!(cut.len(), 8);
        assert_eq!(cut.iter().filter(|record| record.neighbor == record.beyond).count(), 4);
    }
}
