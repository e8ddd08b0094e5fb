//! Finding the receivers beside the borders between clusters.

use std::collections::HashMap;

use probelight_asset::BorderBlend;

use crate::receivers::Receiver;

/// Steps to the four neighbours of a texel.
const STEPS: [(i32, i32); 4] = [(-1, 0), (1, 0), (0, -1), (0, 1)];

/// The records of all borders within charts and air spaces, sorted by receiver. `order` lists the receivers
/// (indices) as the file has them, with their clusters; records count in that order.
pub(crate) fn find_border_blends(
    receivers: &[Receiver],
    lightmap_width: u32,
    order: &[(u32, u32)],
) -> Vec<BorderBlend> {
    let place_of_texel: HashMap<u32, u32> =
        order.iter().map(|(receiver, _)| receivers[*receiver as usize].texel).zip(0..).collect();
    let cluster = |place: u32| order[place as usize].1;
    let receiver = |place: u32| &receivers[order[place as usize].0 as usize];
    let neighbor = |place: u32, (dx, dy): (i32, i32)| {
        let here = receiver(place);
        let (x, y) = (here.texel % lightmap_width, here.texel / lightmap_width);
        let x = x.checked_add_signed(dx).filter(|x| *x < lightmap_width)?;
        let place = *place_of_texel.get(&(y.checked_add_signed(dy)? * lightmap_width + x))?;
        let there = receiver(place);
        (there.chart == here.chart && there.air_space() == here.air_space()).then_some(place)
    };
    let record = |place: u32, step: (i32, i32)| {
        let next = neighbor(place, step).filter(|next| cluster(*next) != cluster(place))?;
        // Where the other cluster is but one texel wide, it has no slope to continue.
        let beyond = neighbor(next, step).filter(|beyond| cluster(*beyond) == cluster(next));
        Some(BorderBlend { receiver: place, neighbor: next, beyond: beyond.unwrap_or(next) })
    };
    let record = &record;
    (0..order.len() as u32)
        .flat_map(|place| STEPS.into_iter().filter_map(move |step| record(place, step)))
        .collect()
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Vec3;

    use super::*;
    use crate::receivers::Outlook;

    const WIDTH: u32 = 8;

    /// Two rows of eight receivers; clusters meet between the third and fourth of a row. The file has them
    /// backwards.
    fn rows(change: impl Fn(&mut Receiver)) -> Vec<BorderBlend> {
        let mut receivers: Vec<Receiver> =
            (0..2 * WIDTH).map(|texel| Receiver { texel, ..Receiver::default() }).collect();
        receivers.iter_mut().for_each(change);
        let order: Vec<(u32, u32)> =
            (0..2 * WIDTH).rev().map(|receiver| (receiver, u32::from(receiver % WIDTH >= 3))).collect();
        find_border_blends(&receivers, WIDTH, &order)
    }

    #[test]
    fn both_sides_of_a_border_are_found_in_the_order_of_the_file() {
        let place = |x: u32, y: u32| 2 * WIDTH - 1 - (y * WIDTH + x);
        let record = |y, [receiver, neighbor, beyond]: [u32; 3]| BorderBlend {
            receiver: place(receiver, y),
            neighbor: place(neighbor, y),
            beyond: place(beyond, y),
        };
        let expected =
            [record(1, [3, 2, 1]), record(1, [2, 3, 4]), record(0, [3, 2, 1]), record(0, [2, 3, 4])];
        assert_eq!(rows(|_| {}), expected);
    }

    #[test]
    fn charts_and_air_spaces_are_kept_apart() {
        assert!(rows(|receiver| receiver.chart = u32::from(receiver.texel % WIDTH >= 3)).is_empty());
        let outlook = |air_space| Some(Outlook { probe: 0, position: Vec3::ZERO, air_space });
        assert!(
            rows(|receiver| receiver.outlook = outlook(u32::from(receiver.texel % WIDTH >= 3))).is_empty()
        );
    }

    #[test]
    fn a_slope_ends_where_the_other_cluster_does() {
        let cut = rows(|receiver| receiver.chart = u32::from(receiver.texel % WIDTH >= 4));
        assert_eq!(cut.iter().filter(|record| record.neighbor == record.beyond).count(), 2);
    }
}
