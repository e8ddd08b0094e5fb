//! Camera, sky and view as shaders read them.

use bytemuck::{Pod, Zeroable};
use probelight_math::glam::{Mat4, Vec3, Vec4};
use probelight_scene::{Camera, Lighting, Sky};

use super::view::ViewOptions;

/// Nothing nearer to the eye than this share of the scene's diagonal is drawn.
const NEAR_PER_DIAGONAL: f32 = 1e-4;

/// `Frame` in `frame.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FrameRecord {
    pub(super) clip_from_world: [[f32; 4]; 4], //   0
    pub(super) eye: [f32; 3],                  //                   64
    pub(super) view: u32,                      //                       76
    pub(super) right: [f32; 3],                //                 80
    pub(super) shading: u32,                   //                    92
    pub(super) up: [f32; 3],                   //                    96
    pub(super) emissive_scale: f32,            //            108
    pub(super) forward: [f32; 3],              //              112
    pub(super) marker_radius: f32,             //             124
    pub(super) zenith: [f32; 4],               //               128
    pub(super) horizon: [f32; 4],              //              144
    pub(super) ground: [f32; 4],               //               160
}

impl FrameRecord {
    /// What `camera` sees of a scene whose box has a diagonal of `diagonal` metres.
    pub(super) fn new(
        camera: &Camera,
        diagonal: f32,
        lighting: &Lighting,
        options: ViewOptions,
        marker_radius: f32,
    ) -> Self {
        let forward = (camera.target - camera.position).normalize_or(-Vec3::Z);
        let right = forward.cross(camera.up).normalize_or(Vec3::X);
        let up = right.cross(forward);
        let half_height = (camera.vertical_fov * 0.5).tan();
        let half_width = half_height * camera.width as f32 / camera.height as f32;
        let row = |v: Vec3| v.extend(-v.dot(camera.position));
        let near = Vec4::W * (NEAR_PER_DIAGONAL * diagonal);
        let rows = [row(right / half_width), row(up / half_height), near, row(forward)];
        let clip_from_world = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        let [zenith, horizon, ground] = sky_colors(&lighting.sky).map(|c| c.extend(0.0).to_array());
        Self {
            clip_from_world: clip_from_world.to_cols_array_2d(),
            eye: camera.position.to_array(),
            view: options.view as u32,
            right: (right * half_width).to_array(),
            shading: options.shading as u32,
            up: (up * half_height).to_array(),
            emissive_scale: lighting.emissive_scale,
            forward: forward.to_array(),
            marker_radius,
            zenith,
            horizon,
            ground,
        }
    }
}

/// Radiance straight up, at the horizon and straight down.
fn sky_colors(sky: &Sky) -> [Vec3; 3] {
    match sky {
        Sky::Uniform(radiance) => [*radiance; 3],
        Sky::Gradient { zenith, horizon, ground } => [*zenith, *horizon, *ground],
    }
}

#[cfg(test)]
mod tests {
    use probelight_math::glam::Vec2;

    use super::*;

    #[test]
    fn pixels_and_their_rays_meet() {
        let camera = Camera {
            name: "test".into(),
            position: Vec3::new(1.0, 2.0, 3.0),
            target: Vec3::new(-4.0, 1.0, 0.5),
            up: Vec3::Y,
            vertical_fov: 1.1,
            width: 320,
            height: 200,
        };
        let record = FrameRecord::new(&camera, 10.0, &Lighting::default(), ViewOptions::default(), 0.0);
        let projection = Mat4::from_cols_array_2d(&record.clip_from_world);
        let mut last_depth = f32::INFINITY;
        for (pixel, distance) in
            [(Vec2::new(0.0, 0.0), 1.0), (Vec2::new(80.0, 150.0), 2.0), (Vec2::new(320.0, 60.0), 9.0)]
        {
            let point = camera.position + distance * camera.ray_direction(pixel);
            let ndc = projection.project_point3(point);
            let back = Vec2::new(160.0 * (1.0 + ndc.x), 100.0 * (1.0 - ndc.y));
            assert!(back.abs_diff_eq(pixel, 1e-3), "{back} for {pixel}");
            assert!(ndc.z > 0.0 && ndc.z < last_depth, "depth falls with distance");
            last_depth = ndc.z;
        }
    }
}
