use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use probelight_math::glam::{Vec2, Vec3, Vec4};
use probelight_scene::{Material, Scene, SourceInstance, SourceTriangle, load_gltf};
use proptest::prelude::*;

use super::close_seams::{groups_without_seams, pairs_across_seams};
use super::{CutScene, cut_along_walls};

const TEXEL: f32 = 0.1;

/// Quads of their own vertices, uv0 = (x, z); each a source instance of two triangles.
fn scene_of(quads: &[[Vec3; 4]]) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    for quad in quads {
        let first = scene.positions.len() as u32;
        let normal = (quad[1] - quad[0]).cross(quad[2] - quad[0]).normalize();
        for position in quad {
            scene.positions.push(*position);
            scene.normals.push(normal);
            scene.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
            scene.uv0.push(Vec2::new(position.x, position.z));
        }
        scene.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + first)));
        scene.triangle_material.extend([0, 0]);
        let instance = scene.sources.instances.len() as u32;
        scene.sources.instances.push(SourceInstance { node: instance, ..SourceInstance::default() });
        scene.sources.triangles.extend([0, 1].map(|triangle| SourceTriangle { instance, triangle }));
    }
    scene.validate().unwrap();
    scene
}

/// A 10 m floor that faces up at y = 0.
fn floor() -> [Vec3; 4] {
    [(0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0)].map(|(x, z)| Vec3::new(x, 0.0, z))
}

/// An upright quad over the line from `a` to `b` = (x, z).
fn wall(a: Vec2, b: Vec2, bottom: f32, top: f32) -> [Vec3; 4] {
    [(a, bottom), (b, bottom), (b, top), (a, top)].map(|(p, y)| Vec3::new(p.x, y, p.y))
}

fn floor_triangles(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.triangles.len()).filter(|t| {
        scene.geometric_normal(*t).y.abs() > 0.9 && scene.corners(*t).iter().all(|p| p.y.abs() < 1e-3)
    })
}

/// The largest difference between a triangle's area and that of the pieces that name it as their source, and
/// between its plane and a piece's corner: 0 if each piece names its own triangle. Metres and m².
fn source_error(scene: &Scene, cut: &Scene) -> f64 {
    let mut areas: HashMap<SourceTriangle, f64> = HashMap::new();
    let mut planes = HashMap::new();
    for (t, source) in scene.sources.triangles.iter().enumerate() {
        areas.insert(*source, f64::from(scene.area(t)));
        planes.insert(*source, (scene.geometric_normal(t), scene.corners(t)[0]));
    }
    let mut error = 0.0f64;
    for (t, source) in cut.sources.triangles.iter().enumerate() {
        let (normal, origin) = planes[source];
        *areas.get_mut(source).unwrap() -= f64::from(cut.area(t));
        let offsets = cut.corners(t).map(|corner| f64::from(normal.dot(corner - origin).abs()));
        error = offsets.into_iter().fold(error, f64::max);
    }
    areas.into_values().map(f64::abs).fold(error, f64::max)
}

/// Whether a triangle has points on both sides of x = `at`, further than `margin`.
fn straddles(corners: [Vec3; 3], at: f32, margin: f32) -> bool {
    corners.iter().any(|p| p.x < at - margin) && corners.iter().any(|p| p.x > at + margin)
}

fn seam_edges_of(cut: &CutScene, triangle: usize) -> impl Iterator<Item = [Vec3; 2]> {
    let (corners, seams) = (cut.scene.corners(triangle), cut.seams[triangle]);
    (0..3).filter(move |k| seams[*k]).map(move |k| [corners[k], corners[(k + 1) % 3]])
}

fn has_seams(cut: &CutScene) -> bool {
    cut.seams.iter().flatten().any(|is_seam| *is_seam)
}

/// How many faces are connected, across edges that are no seam, with the face beyond a seam.
fn faces_joined_without_seams(cut: &CutScene) -> usize {
    let groups = groups_without_seams(cut);
    pairs_across_seams(cut).iter().filter(|(a, b)| groups[*a as usize] == groups[*b as usize]).count()
}

/// A wall across the whole floor at x = 4.03.
fn check_full_wall(bottom: f32, top: f32) {
    let line = wall(Vec2::new(4.03, 0.0), Vec2::new(4.03, 10.0), bottom, top);
    let scene = scene_of(&[floor(), line]);
    assert!(floor_triangles(&scene).any(|t| straddles(scene.corners(t), 4.03, 1e-3)));
    let cut = cut_along_walls(&scene, TEXEL);
    cut.scene.validate().unwrap();
    assert!(floor_triangles(&cut.scene).all(|t| !straddles(cut.scene.corners(t), 4.03, 1e-3)));
    let on_floor: Vec<[Vec3; 2]> = floor_triangles(&cut.scene).flat_map(|t| seam_edges_of(&cut, t)).collect();
    assert!(on_floor.iter().flatten().all(|p| (p.x - 4.03).abs() < 1e-5));
    let length: f32 = on_floor.iter().map(|[a, b]| a.distance(*b)).sum();
    assert!((length - 20.0).abs() < 1e-3, "seams on both sides of 10 m, found {length} m");
    assert!(faces_joined_without_seams(&cut) == 0);
}

#[test]
fn wall_on_a_floor_cuts_it() {
    check_full_wall(0.0, 3.0);
}

#[test]
fn wall_through_a_floor_cuts_it() {
    check_full_wall(-0.02, 3.0);
    check_full_wall(-3.0, 3.0);
}

#[test]
fn wall_below_a_floor_cuts_it() {
    check_full_wall(-3.0, 0.0);
}

#[test]
fn edges_of_a_cut_floor_stay_matched() {
    let line = wall(Vec2::new(1.0, 2.0), Vec2::new(7.3, 8.1), 0.0, 2.0);
    let cut = cut_along_walls(&scene_of(&[floor(), line]), TEXEL);
    let on_border = |[a, b]: [Vec3; 2]| {
        let both = |f: fn(Vec3) -> f32| (f(a) == f(b)) && (f(a) == 0.0 || f(a) == 10.0);
        both(|p| p.x) || both(|p| p.z)
    };
    let edges: Vec<[u32; 2]> = floor_triangles(&cut.scene)
        .map(|t| cut.scene.triangles[t])
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    assert!(edges.len() > 6);
    for [a, b] in &edges {
        let ends = [a, b].map(|v| cut.scene.positions[*v as usize]);
        let positions = |e: &[u32; 2]| e.map(|v| cut.scene.positions[v as usize]);
        let opposite = edges.iter().filter(|e| positions(e) == [ends[1], ends[0]]).count();
        assert_eq!(opposite, usize::from(!on_border(ends)), "edge {ends:?}");
    }
}

/// Walls at each x of `at` from the floor's border to z = `end`.
fn check_free_end(at: &[f32], end: f32) {
    let walls = at.iter().map(|x| wall(Vec2::new(*x, 0.0), Vec2::new(*x, end), 0.0, 3.0));
    let mut cut =
        cut_along_walls(&scene_of(&std::iter::once(floor()).chain(walls).collect::<Vec<_>>()), TEXEL);
    assert!(has_seams(&cut));
    assert_eq!(faces_joined_without_seams(&cut), 0);
    for t in 0..cut.seams.len() {
        let p = cut.scene.corners(t);
        let under_wall = |p: Vec3| p.z < end + 1e-3 && at.iter().any(|x| (p.x - x).abs() < 1e-3);
        cut.seams[t] = [0, 1, 2].map(|k| cut.seams[t][k] && under_wall(p[k]) && under_wall(p[(k + 1) % 3]));
    }
    assert!(faces_joined_without_seams(&cut) > 0, "the check must see slits");
}

#[test]
fn no_chart_reaches_around_the_end_of_a_wall() {
    check_free_end(&[4.0, 4.06], 6.0);
    // Within one triangle, so that the cut floor has the wall's own edge.
    check_free_end(&[6.0], 3.0);
}

#[test]
fn rooms_on_both_sides_of_a_thick_wall_are_apart() {
    let sides = [4.0, 4.06].map(|x| wall(Vec2::new(x, 0.0), Vec2::new(x, 6.0), 0.0, 3.0));
    let cut = cut_along_walls(&scene_of(&[floor(), sides[0], sides[1]]), TEXEL);
    let groups = groups_without_seams(&cut);
    let groups_at = |x: f32, is_here: fn(f32, f32) -> bool| -> BTreeSet<u32> {
        let touches = |t: &usize| {
            let corners = cut.scene.corners(*t);
            let on_wall = corners.iter().filter(|p| (p.x - x).abs() < 1e-3 && p.z < 6.001).count();
            on_wall == 2 && corners.iter().all(|p| is_here(p.x, x + 1e-3) || (p.x - x).abs() < 1e-3)
        };
        floor_triangles(&cut.scene).filter(touches).map(|t| groups[t]).collect()
    };
    let left = groups_at(4.0, |p, x| p < x);
    let right = groups_at(4.06, |p, x| p > x);
    assert!(!left.is_empty() && !right.is_empty());
    assert!(left.is_disjoint(&right), "{left:?} {right:?}");
}

#[test]
fn decals_sills_and_posts_do_not_cut() {
    let decal = floor().map(|p| p * 0.3 + Vec3::new(2.0, 0.0005, 2.0));
    let sill = wall(Vec2::new(1.0, 6.0), Vec2::new(9.0, 6.5), 0.0, 0.05);
    let post = wall(Vec2::new(7.0, 3.0), Vec2::new(7.2, 3.1), 0.0, 3.0);
    let scene = scene_of(&[floor(), decal, sill, post]);
    let cut = cut_along_walls(&scene, TEXEL);
    assert_eq!(cut.scene.triangles, scene.triangles);
    assert!(!has_seams(&cut));
}

#[test]
fn walls_at_the_border_do_not_cut() {
    for name in ["furnace", "cornell_empty"] {
        let scene = bundled(name);
        let cut = cut_along_walls(&scene, TEXEL);
        assert_eq!(cut.scene.triangles, scene.triangles, "{name}");
        assert!(!has_seams(&cut), "{name}");
    }
}

fn bundled(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    load_gltf(&folder.join(format!("{name}.glb"))).unwrap()
}

#[test]
fn floor_of_the_sealed_room_is_its_own() {
    let scene = bundled("rooms");
    let (from, to) = (Vec2::new(6.06, 0.0), Vec2::new(10.0, 5.0));
    // Clearly inside the room, clearly beyond its 6 cm walls.
    let inside = |p: Vec2| p.cmpgt(from + 0.02).all() && p.cmplt(to - 0.02).all();
    let beyond = |p: Vec2| p.cmplt(from - 0.08).any() || p.cmpgt(to + 0.08).any();
    let crosses = |scene: &Scene| {
        floor_triangles(scene).filter(|t| scene.geometric_normal(*t).y > 0.0).any(|t| {
            let points = samples(scene.corners(t));
            points.iter().any(|p| inside(*p)) && points.iter().any(|p| beyond(*p))
        })
    };
    assert!(crosses(&scene));
    for texel in [0.05, 0.1, 0.2] {
        let cut = cut_along_walls(&scene, texel);
        cut.scene.validate().unwrap();
        assert!(!crosses(&cut.scene), "texels of {texel} m");
        assert!(faces_joined_without_seams(&cut) == 0);
    }
}

/// Points (x, z) all over a triangle.
fn samples([a, b, c]: [Vec3; 3]) -> Vec<Vec2> {
    let steps = 200;
    let weights = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j)));
    let point = |(i, j)| a + ((b - a) * i as f32 + (c - a) * j as f32) / steps as f32;
    weights.map(point).map(|p| Vec2::new(p.x, p.z)).collect()
}

#[test]
fn unwrapped_charts_end_at_seams() {
    let cut = cut_along_walls(&bundled("rooms"), TEXEL);
    let charts_with = |seams: Option<&[[bool; 3]]>| -> Vec<u32> {
        let positions: Vec<[f32; 3]> = cut.scene.positions.iter().map(|p| p.to_array()).collect();
        let mut mesh = uvunwrap::MeshInput::new(&positions, cut.scene.triangles.as_flattened());
        mesh.seams = seams;
        let options = uvunwrap::Options { max_chart_angle: 30.0, ..Default::default() };
        let layout = &uvunwrap::generate(&[mesh], &options).unwrap().meshes[0];
        layout.indices.chunks(3).map(|c| layout.vertices[c[0] as usize].chart.unwrap_or(u32::MAX)).collect()
    };
    let in_one_chart = |charts: &[u32]| {
        let pairs = pairs_across_seams(&cut);
        pairs.iter().filter(|(a, b)| charts[*a as usize] == charts[*b as usize]).count()
    };
    assert_eq!(in_one_chart(&charts_with(Some(&cut.seams))), 0);
    assert!(in_one_chart(&charts_with(None)) > 0);
}

#[test]
fn a_detailed_scene_grows_little() {
    let scene = bundled("atrium");
    let cut = cut_along_walls(&scene, TEXEL);
    cut.scene.validate().unwrap();
    let growth = cut.scene.triangles.len() as f64 / scene.triangles.len() as f64;
    assert!(growth > 1.0 && growth < 1.3, "{growth}");
    assert!((cut.scene.surface_area() / scene.surface_area() - 1.0).abs() < 1e-6);
}

#[test]
fn pieces_keep_their_source() {
    let scene = bundled("rooms");
    let mut cut = cut_along_walls(&scene, TEXEL).scene;
    assert!(cut.triangles.len() > scene.triangles.len());
    assert_eq!(cut.sources.instances, scene.sources.instances);
    let error = source_error(&scene, &cut);
    assert!(error < 1e-4, "{error}");
    cut.sources.triangles.rotate_left(1);
    assert!(source_error(&scene, &cut) > 0.1, "the check must see a wrong source");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn surface_is_kept_whatever_the_walls(
        walls in prop::collection::vec(([0.0f32..10.0, 0.0f32..10.0], [0.0f32..10.0, 0.0f32..10.0]), 1..12),
        bottom in -1.0f32..0.0,
    ) {
        let walls = walls.into_iter().map(|(a, b)| (Vec2::from(a), Vec2::from(b)));
        let walls = walls.filter(|(a, b)| a.distance(*b) > 0.05).map(|(a, b)| wall(a, b, bottom, 2.0));
        let scene = scene_of(&std::iter::once(floor()).chain(walls).collect::<Vec<_>>());
        let cut = cut_along_walls(&scene, TEXEL);
        cut.scene.validate().unwrap();
        prop_assert_eq!(cut.seams.len(), cut.scene.triangles.len());
        let again = cut_along_walls(&scene, TEXEL);
        prop_assert_eq!((&cut.scene.triangles, &cut.seams), (&again.scene.triangles, &again.seams));
        prop_assert_eq!(&cut.scene.positions, &again.scene.positions);
        prop_assert!((cut.scene.surface_area() - scene.surface_area()).abs() < 1e-3);
        prop_assert!(source_error(&scene, &cut.scene) < 1e-3);
        prop_assert!(floor_triangles(&cut.scene).all(|t| cut.scene.geometric_normal(t).y > 0.9));
        for (position, uv) in cut.scene.positions.iter().zip(&cut.scene.uv0) {
            prop_assert!(uv.distance(Vec2::new(position.x, position.z)) < 1e-4);
        }
        prop_assert!(faces_joined_without_seams(&cut) == 0);
    }
}
