//! Points on a scene's surfaces, at which irradiance is to be compared.

use probelight_math::glam::Vec3;
use probelight_math::sampling::{Rng, triangle_from_square};
use probelight_scene::Scene;

use crate::points::PointsTable;

/// Streams of the random numbers: one for each way of choosing.
const BY_AREA: u64 = 1;
const BY_TRIANGLE: u64 = 2;

/// `count` points evenly over the area, then as many evenly over the triangles, with the columns `position`, `normal`,
/// `kind`, `sampling` and `triangle_area`. Double-sided surfaces are sampled on either side, others in front.
pub(crate) fn sample_points(scene: &Scene, count: u32, seed: u64) -> PointsTable {
    let areas: Vec<f64> = (0..scene.triangles.len()).map(|t| f64::from(scene.area(t))).collect();
    let same = vec![1.0; areas.len()];
    let ways = [(BY_AREA, "0", &areas), (BY_TRIANGLE, "1", &same)];
    let rows = ways.into_iter().flat_map(|(stream, sampling, weights)| {
        let mut rng = Rng::new(seed, stream);
        let chosen = stratified(weights, count, &mut rng);
        chosen.into_iter().map(move |triangle| {
            let [x, y, z] = scene.position(triangle, triangle_from_square(rng.next_vec2())).to_array();
            let is_back = scene.material(triangle).double_sided && rng.next_f32() < 0.5;
            let normal: Vec3 = scene.geometric_normal(triangle) * if is_back { -1.0 } else { 1.0 };
            let [nx, ny, nz] = normal.to_array();
            let mut row = [x, y, z, nx, ny, nz].map(|value| value.to_string()).to_vec();
            row.extend(["0".into(), sampling.into(), scene.area(triangle).to_string()]);
            row
        })
    });
    let columns = [
        "position_x",
        "position_y",
        "position_z",
        "normal_x",
        "normal_y",
        "normal_z",
        "kind",
        "sampling",
        "triangle_area",
    ];
    PointsTable::new(&columns, rows.collect())
}

/// `count` indices in proportion to their weights: one in each of `count` equal shares of the sum.
fn stratified(weights: &[f64], count: u32, rng: &mut Rng) -> Vec<usize> {
    let share = weights.iter().sum::<f64>() / f64::from(count);
    let (mut index, mut passed) = (0, 0.0);
    let mut choose = |i: u32| {
        let target = (f64::from(i) + f64::from(rng.next_f32())) * share;
        while passed + weights[index] < target && index + 1 < weights.len() {
            passed += weights[index];
            index += 1;
        }
        index
    };
    (0..count).map(&mut choose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_decide_how_many_points_each_gets() {
        let chosen = stratified(&[1.0, 0.0, 3.0, 4.0], 800, &mut Rng::new(1, 2));
        let count = |index| chosen.iter().filter(|i| **i == index).count();
        assert_eq!([0, 1, 2, 3].map(count), [100, 0, 300, 400]);
    }

    #[test]
    fn small_triangles_have_as_many_points_as_large_ones_in_the_second_half() {
        let scene = Scene {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, 0.01 * Vec3::X, 0.01 * Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 3, 4]],
            triangle_material: vec![0, 0],
            materials: vec![probelight_scene::Material::default()],
            ..Scene::default()
        };
        let csv = sample_points(&scene, 100, 0).to_csv();
        let small = |line: &&str| line.ends_with(&scene.area(1).to_string());
        let rows: Vec<&str> = csv.lines().skip(1).collect();
        assert_eq!(rows.len(), 200);
        assert_eq!(rows[..100].iter().copied().filter(|line| small(line)).count(), 0);
        assert_eq!(rows[100..].iter().copied().filter(|line| small(line)).count(), 50);
    }
}
