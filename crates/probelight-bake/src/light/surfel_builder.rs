//! Halves receivers into surfels and gives each its light samples.

use std::collections::BTreeMap;

use probelight_asset::{LightSample, NONE, Surfel, SurfelGroup};
use probelight_math::color::srgb8_from_linear;
use probelight_math::glam::{Vec2, Vec3};
use probelight_scene::Bounds;

use crate::air::limits::{FULL_EXPOSURE, HIDDEN_EXPOSURE};
use crate::ground::Groundwork;
use crate::ground::atlas::barycentric_of;
use crate::ground::receivers::Receiver;
use crate::ground::sample_point::SurfacePoint;
use crate::ground::site::Site;
use crate::ground::texel_points::keep_exposed;
use crate::light::surfels::SurfelTree;
use crate::partition::{KdRule, by_air_space};

/// A surfel's width that a unit difference of normals counts as: faces at right angles part.
const WIDTHS_PER_NORMAL: f32 = 1.5;

impl SurfelTree {
    /// Surfels of the settings' size, with at most so many light samples each.
    pub(crate) fn build(ground: &Groundwork) -> Self {
        let builder = Builder::new(ground);
        let mut tree = Self {
            surfel_of_texel: vec![NONE; ground.atlas.width as usize * ground.atlas.height as usize],
            first_lit_points: vec![0],
            ..Self::default()
        };
        let mut group_sizes = Vec::new();
        for group in by_air_space(&ground.sites, ground.texels()) {
            for side in by_side(&ground.sites, group) {
                builder.add_patch(side, &mut tree, &mut group_sizes);
            }
        }
        for [texel, source] in &ground.receivers.dilation {
            tree.surfel_of_texel[*texel as usize] = tree.surfel_of_texel[*source as usize];
        }
        tree.measure_areas(ground);
        tree.light_samples.shrink_to_fit();
        tree.number_groups(group_sizes);
        tree
    }

    /// Finds the surfels' areas: of all of their surface, hidden or not, which rays of lights may meet.
    fn measure_areas(&mut self, ground: &Groundwork) {
        let atlas = &ground.atlas;
        let faces = (0u32..).zip(&atlas.faces).filter(|(face, _)| atlas.face_charts[*face as usize] != NONE);
        for (number, face) in faces {
            let triangle = atlas.face_triangles[number as usize] as usize;
            let point =
                ground.tracer.scene().area(triangle) / face.area() / AREA_POINTS_PER_EDGE.pow(2) as f32;
            for (position, _) in face.points(AREA_POINTS_PER_EDGE) {
                let surfel = self.surfel_of_texel(atlas.texel_at(position));
                if let Some(surfel) = self.surfels.get_mut(surfel as usize) {
                    surfel.area += point;
                }
            }
        }
        // Slivers fit between the points.
        let least = (ground.settings.texels_per_meter * AREA_POINTS_PER_EDGE as f32).powi(-2);
        for surfel in &mut self.surfels {
            surfel.area = surfel.area.max(least);
        }
    }

    /// One surfel for each relight ray that hits a surface, as the paper has it; and the surfel of each ray.
    pub(crate) fn of_relight_hits(ground: &Groundwork) -> (Self, Vec<u32>) {
        let scene = ground.tracer.scene();
        let mut tree = Self { first_lit_points: vec![0], ..Self::default() };
        let of_ray = ground
            .relight_hits
            .iter()
            .map(|hit| {
                let Some(hit) = hit else { return NONE };
                let first_sample = tree.light_samples.len() as u32;
                let base_color = scene.base_color_texel(hit.triangle as usize, hit.barycentric).truncate();
                tree.lit_points.push(SurfacePoint {
                    triangle: hit.triangle,
                    barycentric: hit.barycentric,
                    is_back_face: hit.is_back_face,
                    exposure: FULL_EXPOSURE,
                });
                tree.first_lit_points.push(tree.lit_points.len() as u32);
                tree.light_samples.push(LightSample::new(
                    hit.triangle,
                    hit.is_back_face,
                    hit.barycentric,
                    srgb8_from_linear(base_color),
                ));
                tree.surfels.push(Surfel { first_sample, sample_count: 1, area: 0.0 });
                first_sample
            })
            .collect();
        (tree, of_ray)
    }

    /// Replaces the builder's numbers of groups by the asset's, now that the surfels are counted.
    fn number_groups(&mut self, group_sizes: Vec<u32>) {
        let surfels = self.surfels.len() as u32;
        for group in &mut self.groups {
            group.children = group.children.map(|child| Patch::decode(child).number(surfels));
        }
        self.sizes.extend(group_sizes);
        self.parents = vec![NONE; self.patches()];
        self.surfel_counts = vec![1; self.surfels.len()];
        for group in &self.groups {
            let [a, b] = group.children.map(|child| self.surfel_counts[child as usize]);
            self.surfel_counts.push(a + b);
        }
        for (g, group) in (surfels..).zip(&self.groups) {
            for child in group.children {
                self.parents[child as usize] = g;
            }
        }
    }
}

/// Light samples keep this distance from the borders of their texel: what the rounding of their place may be, texels.
const TEXEL_MARGIN: f32 = 0.05;

/// Points of a surfel at which random lights are evaluated, at most.
const LIT_POINTS: usize = 4;

/// Points along the edge of a texel that measure areas.
const AREA_POINTS_PER_EDGE: u32 = 8;

/// A surfel or group while the number of surfels is not known yet.
#[derive(Clone, Copy)]
enum Patch {
    Surfel(u32),
    Group(u32),
}

impl Patch {
    const GROUP_BIT: u32 = 1 << 31;

    fn encode(self) -> u32 {
        match self {
            Self::Surfel(s) => s,
            Self::Group(g) => g | Self::GROUP_BIT,
        }
    }

    fn decode(code: u32) -> Self {
        if code & Self::GROUP_BIT == 0 { Self::Surfel(code) } else { Self::Group(code & !Self::GROUP_BIT) }
    }

    fn number(self, surfels: u32) -> u32 {
        match self {
            Self::Surfel(s) => s,
            Self::Group(g) => surfels + g,
        }
    }
}

/// A point of a receiver's texel.
#[derive(Clone, Copy)]
struct TexelPoint {
    receiver: u32,
    point: SurfacePoint,
    /// World position, metres.
    position: Vec3,
}

/// Parts a group by the side its receivers face: floors from ceilings, and from walls.
pub(crate) fn by_side(sites: &[Site], group: Vec<u32>) -> Vec<Vec<u32>> {
    let mut sides: BTreeMap<[i32; 3], Vec<u32>> = BTreeMap::new();
    for r in group {
        let side = sites[r as usize].normal.to_array().map(|n| n.round() as i32);
        sides.entry(side).or_default().push(r);
    }
    sides.into_values().collect()
}

/// Halves receivers into patches.
struct Builder<'a> {
    ground: &'a Groundwork,
    /// Tells how large a patch is.
    shape: KdRule,
    /// Tells how a larger one is halved: what sees other things is apart sooner.
    rule: KdRule,
    size: f32,
}

impl<'a> Builder<'a> {
    /// For surfels of the settings' size.
    fn new(ground: &'a Groundwork) -> Self {
        let size = ground.settings.surfel_size;
        let rule = |by_outlook| KdRule { meters_per_normal: WIDTHS_PER_NORMAL * size, by_outlook };
        Self { ground, shape: rule(false), rule: rule(true), size }
    }

    fn receiver(&self, number: u32) -> &Receiver {
        &self.ground.receivers.receivers[number as usize]
    }

    /// Adds the patch of a group of receivers, smaller patches first.
    fn add_patch(&self, group: Vec<u32>, tree: &mut SurfelTree, group_sizes: &mut Vec<u32>) -> Patch {
        let size = self.area(&group);
        let (first, second) = if self.shape.extent(&self.ground.sites, &group) > self.size {
            self.rule.split(&self.ground.sites, group)
        } else {
            match self.split_by_kind(group) {
                Ok(halves) => halves,
                Err(group) => return self.add_surfel(&group, tree),
            }
        };
        let first_weight = self.area(&first) as f32 / size as f32;
        let children = [first, second].map(|half| self.add_patch(half, tree, group_sizes).encode());
        tree.groups.push(SurfelGroup { children, first_weight });
        group_sizes.push(size);
        Patch::Group(tree.groups.len() as u32 - 1)
    }

    /// Parts what is like the first receiver of a group from the rest; gives the group back if all are. A surfel is of
    /// one chart, and either exposed or hidden: the gap behind a shelf must not shine like the wall beside it.
    fn split_by_kind(&self, group: Vec<u32>) -> Result<(Vec<u32>, Vec<u32>), Vec<u32>> {
        let kind = |r: &u32| (self.receiver(*r).chart, self.is_hidden(*r));
        let first = kind(&group[0]);
        if group.iter().all(|r| kind(r) == first) {
            return Err(group);
        }
        Ok(group.into_iter().partition(|r| kind(r) == first))
    }

    fn is_hidden(&self, receiver: u32) -> bool {
        self.area(&[receiver]) < HIDDEN_EXPOSURE * self.ground.points.of(receiver).len() as u32
    }

    fn add_surfel(&self, group: &[u32], tree: &mut SurfelTree) -> Patch {
        let surfel = tree.surfels.len() as u32;
        let first_sample = tree.light_samples.len() as u32;
        let tracer = &self.ground.tracer;
        let of_texel = |receiver: &u32| {
            let (receiver, points) = (*receiver, self.ground.points.of(*receiver));
            let point =
                move |p: &SurfacePoint| TexelPoint { receiver, point: *p, position: p.position(tracer) };
            points.iter().map(point)
        };
        let points: Vec<TexelPoint> = group.iter().flat_map(of_texel).collect();
        let points = keep_exposed(points, |p| p.point.exposure);
        let most = self.ground.settings.samples_per_surfel as usize;
        let texels = points.chunk_by(|a, b| a.receiver == b.receiver);
        if group.len() <= most {
            // More samples than texels would learn nothing new of the lightmap's light, and these tell which surfel each
            // texel belongs to.
            tree.light_samples.extend(texels.map(|texel| self.light_sample(texel)));
        } else {
            for_each_part(points.clone(), most, &mut |part| tree.light_samples.push(self.light_sample(part)));
        }
        for_each_part(points, LIT_POINTS, &mut |part| {
            tree.lit_points.extend(middle_of(part).map(|p| p.point));
        });
        tree.first_lit_points.push(tree.lit_points.len() as u32);
        let sample_count = tree.light_samples.len() as u32 - first_sample;
        tree.surfels.push(Surfel { first_sample, sample_count, area: 0.0 });
        tree.sizes.push(self.area(group));
        for receiver in group {
            tree.surfel_of_texel[self.receiver(*receiver).texel as usize] = surfel;
        }
        Patch::Surfel(surfel)
    }

    /// Exposed area of a group of receivers: their points are equally dense everywhere.
    fn area(&self, group: &[u32]) -> u32 {
        group.iter().flat_map(|r| self.ground.points.of(*r)).map(|point| u32::from(point.exposure)).sum()
    }

    /// The sample of a part: at its middle point, with the mean of the textures.
    fn light_sample(&self, part: &[TexelPoint]) -> LightSample {
        let count = part.len() as f32;
        let scene = self.ground.tracer.scene();
        let base_color = |p: &TexelPoint| {
            scene.base_color_texel(p.point.triangle as usize, p.point.barycentric).truncate()
        };
        let mean = part.iter().map(base_color).sum::<Vec3>() / count;
        let color = srgb8_from_linear(mean);
        let sample = |p: &TexelPoint| {
            let SurfacePoint { triangle, is_back_face, .. } = p.point;
            let weights = self.within_texel(&p.point, self.receiver(p.receiver).texel);
            LightSample::new(triangle, is_back_face, weights, color)
        };
        let is_in_its_texel = |p: &&TexelPoint| {
            let (atlas, sample) = (&self.ground.atlas, sample(p));
            let face = &atlas.faces[atlas.face_of(sample.triangle(), sample.is_back_face()) as usize];
            atlas.texel_at(face.position(sample.barycentric())) == self.receiver(p.receiver).texel
        };
        // What is left of a chart in a texel may be narrower than the rounding of places.
        let inside: Vec<TexelPoint> = part.iter().filter(is_in_its_texel).copied().collect();
        let found = middle_of(&inside).or_else(|| middle_of(part));
        sample(&found.unwrap_or(part[0]))
    }

    /// Barycentric weights of a point, moved into its texel: points are pulled off the edges of large triangles by more
    /// than what of a texel at a chart's border is covered.
    fn within_texel(&self, point: &SurfacePoint, texel: u32) -> Vec2 {
        let atlas = &self.ground.atlas;
        let face = &atlas.faces[atlas.face_of(point.triangle, point.is_back_face) as usize];
        let corner = Vec2::new((texel % atlas.width) as f32, (texel / atlas.width) as f32);
        let position = face.position(point.barycentric);
        let inside = position.clamp(corner + TEXEL_MARGIN, corner + 1.0 - TEXEL_MARGIN);
        if inside == position {
            return point.barycentric;
        }
        let weights = barycentric_of(inside, face.corners).max(Vec2::ZERO);
        weights / weights.element_sum().max(1.0)
    }
}

/// Divides a surfel's points into parts of equal exposed area, at most so many: the mean over them is what the surfel shows
/// to others.
fn for_each_part(mut points: Vec<TexelPoint>, most: usize, found: &mut impl FnMut(&[TexelPoint])) {
    if most <= 1 || points.len() == 1 {
        return found(&points);
    }
    let size = Bounds::of(points.iter().map(|p| p.position)).size();
    let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
    let at = |p: &TexelPoint| p.position[axis];
    points.sort_by(|a, b| at(a).total_cmp(&at(b)).then(a.receiver.cmp(&b.receiver)));
    let upper = points.split_off(points_within(&points, (most / 2) as f32 / most as f32));
    if !points.is_empty() {
        for_each_part(points, most / 2, found);
    }
    for_each_part(upper, most - most / 2, found);
}

/// The point nearest to the middle of some.
fn middle_of(points: &[TexelPoint]) -> Option<TexelPoint> {
    let middle = points.iter().map(|p| p.position).sum::<Vec3>() / points.len().max(1) as f32;
    let distance = |p: &TexelPoint| p.position.distance_squared(middle);
    points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied()
}

/// How many of the first points have at most that share of the exposure of all.
fn points_within(points: &[TexelPoint], share: f32) -> usize {
    let exposure = |p: &TexelPoint| u32::from(p.point.exposure);
    let wanted = share * points.iter().map(exposure).sum::<u32>() as f32;
    let mut sum = 0;
    let is_within = |p: &&TexelPoint| {
        sum += exposure(p);
        sum as f32 <= wanted
    };
    points.iter().take_while(is_within).count()
}
