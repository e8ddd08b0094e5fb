//! Bevy's cube maps on the CPU: their luminance by direction, as far as the sky of a scene can hold it.

use bevy::image::Image;
use bevy::math::{Mat3, Quat, Vec2, Vec3};
use bevy::render::render_resource::TextureFormat;
use half::f16;
use probelight_math::color::linear_from_srgb;
use wgpu::wgt::TextureDataOrder;

/// A cube map is averaged to so many cells along the edge of a face.
const CELLS: usize = 32;

/// Faces of a cube.
const FACES: usize = 6;

/// Why a cube map has no sky.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Unreadable {
    #[error("the main world does not keep its texels")]
    NoTexels,
    #[error("it has no six square faces")]
    NoCube,
    #[error("texels of the format {0:?} are not read")]
    Format(TextureFormat),
}

/// The mean luminance of each cell, face by face and row by row, as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CubeMap(Vec<Vec3>);

/// The three luminances of a sky that is blended by elevation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ByElevation {
    pub(crate) zenith: Vec3,
    pub(crate) horizon: Vec3,
    pub(crate) ground: Vec3,
}

impl ByElevation {
    /// So many times as bright; dark where that is no number.
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        let scale = |part: Vec3| {
            if (part * factor).is_finite() { (part * factor).max(Vec3::ZERO) } else { Vec3::ZERO }
        };
        Self { zenith: scale(self.zenith), horizon: scale(self.horizon), ground: scale(self.ground) }
    }
}

impl CubeMap {
    /// Averages the largest level of an image.
    pub(crate) fn of(image: &Image) -> Result<Self, Unreadable> {
        let size = image.texture_descriptor.size;
        if size.width != size.height || size.width == 0 || size.depth_or_array_layers as usize != FACES {
            return Err(Unreadable::NoCube);
        }
        let bytes = image.data.as_ref().ok_or(Unreadable::NoTexels)?;
        let format = image.texture_descriptor.format;
        let decode = decoder(format).ok_or(Unreadable::Format(format))?;
        let texel_bytes = format.block_copy_size(None).ok_or(Unreadable::Format(format))? as usize;
        let edge = size.width as usize;
        let face_bytes = face_bytes(image, edge, texel_bytes);
        let mut cells = Vec::with_capacity(FACES * CELLS * CELLS);
        for face in 0..FACES {
            let face = bytes.get(face * face_bytes..).ok_or(Unreadable::NoTexels)?;
            let face = face.get(..edge * edge * texel_bytes).ok_or(Unreadable::NoTexels)?;
            let texel = |x: usize, y: usize| decode(&face[(y * edge + x) * texel_bytes..][..texel_bytes]);
            cells.extend(cells_of(edge, texel));
        }
        Ok(Self(cells))
    }

    /// The sky that is closest to the map when it is turned, by least squares over all directions.
    pub(crate) fn by_elevation(&self, rotation: Quat) -> ByElevation {
        let mut gram = Mat3::ZERO;
        // A column for each channel.
        let mut moments = Mat3::ZERO;
        for (cell, luminance) in self.0.iter().enumerate() {
            let (direction, solid_angle) = place_of(cell);
            let height = (rotation * direction).y.clamp(-1.0, 1.0);
            // Shares of zenith, horizon and ground.
            let shares = Vec3::new(height.max(0.0), 1.0 - height.abs(), (-height).max(0.0));
            gram += outer(shares, shares) * solid_angle;
            moments += outer(shares, *luminance) * solid_angle;
        }
        let channels = [moments.x_axis, moments.y_axis, moments.z_axis].map(|moment| solve(gram, moment));
        let parts = Mat3::from_cols(channels[0], channels[1], channels[2]).transpose();
        ByElevation { zenith: parts.x_axis, horizon: parts.y_axis, ground: parts.z_axis }
    }
}

/// Bytes from the largest level of a face to that of the next.
fn face_bytes(image: &Image, edge: usize, texel_bytes: usize) -> usize {
    let levels = match image.data_order {
        TextureDataOrder::LayerMajor => image.texture_descriptor.mip_level_count,
        TextureDataOrder::MipMajor => 1,
    };
    (0..levels).map(|level| (edge >> level).max(1).pow(2) * texel_bytes).sum()
}

/// The cells of a face: means of texels, or the texels themselves where these are larger.
fn cells_of(edge: usize, texel: impl Fn(usize, usize) -> Vec3) -> Vec<Vec3> {
    let range = |cell: usize| {
        let first = cell * edge / CELLS;
        first..((cell + 1) * edge / CELLS).max(first + 1)
    };
    let cell = |i: usize| {
        let (columns, rows) = (range(i % CELLS), range(i / CELLS));
        let count = (columns.len() * rows.len()) as f32;
        let texels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        texels.map(|(x, y)| texel(x, y)).sum::<Vec3>() / count
    };
    (0..CELLS * CELLS).map(cell).collect()
}

/// Bevy's direction to the middle of a cell in a map that is not turned, and its solid angle.
fn place_of(cell: usize) -> (Vec3, f32) {
    let (face, row, column) = (cell / (CELLS * CELLS), cell / CELLS % CELLS, cell % CELLS);
    let at = |index: usize| 2.0 * (index as f32 + 0.5) / CELLS as f32 - 1.0;
    let Vec2 { x: u, y: v } = Vec2::new(at(column), at(row));
    let direction = match face {
        0 => Vec3::new(1.0, -v, -u),
        1 => Vec3::new(-1.0, -v, u),
        2 => Vec3::new(u, 1.0, v),
        3 => Vec3::new(u, -1.0, -v),
        4 => Vec3::new(u, -v, 1.0),
        _ => Vec3::new(-u, -v, -1.0),
    };
    let length = direction.length();
    let area = (2.0 / CELLS as f32).powi(2);
    // Cube maps are left-handed.
    (direction * Vec3::new(1.0, 1.0, -1.0) / length, area / length.powi(3))
}

/// a · bᵀ.
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The x ≥ 0 with the least xᵀ·gram·x − 2·moment·x: of all choices of parts that are zero, the best that has no negative one.
fn solve(gram: Mat3, moment: Vec3) -> Vec3 {
    let with_zeros = |zeros: u32| {
        let (mut gram, mut moment) = (gram, moment);
        for part in (0..3).filter(|part| zeros >> part & 1 == 1) {
            for other in 0..3 {
                gram.col_mut(part)[other] = 0.0;
                gram.col_mut(other)[part] = 0.0;
            }
            gram.col_mut(part)[part] = 1.0;
            moment[part] = 0.0;
        }
        gram.inverse() * moment
    };
    let loss = |x: &Vec3| x.dot(gram * *x) - 2.0 * moment.dot(*x);
    let choices = (0..8).map(with_zeros).filter(|x| x.is_finite() && x.min_element() >= 0.0);
    choices.min_by(|a, b| loss(a).total_cmp(&loss(b))).unwrap_or_default()
}

/// How a texel of a format is read: linear red, green and blue.
fn decoder(format: TextureFormat) -> Option<fn(&[u8]) -> Vec3> {
    fn unorm(texel: &[u8]) -> Vec3 {
        Vec3::new(f32::from(texel[0]), f32::from(texel[1]), f32::from(texel[2])) / 255.0
    }
    fn half(texel: &[u8]) -> Vec3 {
        let of = |i: usize| f16::from_le_bytes([texel[2 * i], texel[2 * i + 1]]).to_f32();
        Vec3::new(of(0), of(1), of(2))
    }
    fn float(texel: &[u8]) -> Vec3 {
        let of = |i: usize| f32::from_le_bytes(std::array::from_fn(|byte| texel[4 * i + byte]));
        Vec3::new(of(0), of(1), of(2))
    }
    fn word(texel: &[u8]) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|byte| texel[byte]))
    }
    fn shared_exponent(texel: &[u8]) -> Vec3 {
        let word = word(texel);
        let mantissa = |shift: u32| (word >> shift & 0x1ff) as f32;
        // Nine bits behind the point, and a bias of 15.
        Vec3::new(mantissa(0), mantissa(9), mantissa(18)) * ((word >> 27) as f32 - 24.0).exp2()
    }
    fn small_floats(texel: &[u8]) -> Vec3 {
        let word = word(texel);
        // Halves without sign whose mantissas are cut off.
        let of = |bits: u32| f16::from_bits((bits & 0x7fff) as u16).to_f32();
        Vec3::new(of((word & 0x7ff) << 4), of((word >> 11 & 0x7ff) << 4), of((word >> 22) << 5))
    }
    let decode: fn(&[u8]) -> Vec3 = match format {
        TextureFormat::Rgba8Unorm => unorm,
        TextureFormat::Rgba8UnormSrgb => |texel| {
            let [red, green, blue] = unorm(texel).to_array().map(linear_from_srgb);
            Vec3::new(red, green, blue)
        },
        TextureFormat::Rgba16Float => half,
        TextureFormat::Rgba32Float => float,
        TextureFormat::Rgb9e5Ufloat => shared_exponent,
        TextureFormat::Rg11b10Ufloat => small_floats,
        _ => return None,
    };
    Some(decode)
}

#[cfg(test)]
pub(crate) mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::render::render_resource::{Extent3d, TextureDimension};

    use super::*;

    /// A map of half floats with a colour by (face, x, y).
    pub(crate) fn cube_map(edge: u32, color: impl Fn(u32, u32, u32) -> Vec3) -> Image {
        let size = Extent3d { width: edge, height: edge, depth_or_array_layers: 6 };
        let texels = (0..6 * edge * edge).map(|i| color(i / (edge * edge), i % edge, i / edge % edge));
        let halves = texels.flat_map(|texel| texel.extend(1.0).to_array().map(f16::from_f32));
        let bytes = halves.flat_map(f16::to_le_bytes).collect();
        let (dimension, format) = (TextureDimension::D2, TextureFormat::Rgba16Float);
        Image::new(size, dimension, bytes, format, RenderAssetUsages::default())
    }

    fn by_elevation(image: &Image, rotation: Quat) -> ByElevation {
        CubeMap::of(image).unwrap().by_elevation(rotation)
    }

    fn assert_close(found: Vec3, wanted: Vec3) {
        assert!(
            found.abs_diff_eq(wanted, 2e-3 * wanted.max_element().max(0.1)),
            "{found} instead of {wanted}"
        );
    }

    fn assert_parts(sky: ByElevation, [zenith, horizon, ground]: [Vec3; 3]) {
        assert_close(sky.zenith, zenith);
        assert_close(sky.horizon, horizon);
        assert_close(sky.ground, ground);
    }

    #[test]
    fn even_maps_stay_even_and_gradients_are_met() {
        let color = Vec3::new(0.5, 2.0, 7.0);
        for edge in [1, 8, 100] {
            let sky = by_elevation(&cube_map(edge, |_, _, _| color), Quat::from_rotation_x(0.4));
            for part in [sky.zenith, sky.horizon, sky.ground] {
                assert_close(part, color);
            }
        }
        let wanted = [Vec3::new(3.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, 0.1, 0.4)];
        let gradient = cube_map(32, |face, x, y| {
            let height = place_of((face * 1024 + y * 32 + x) as usize).0.y;
            wanted[1].lerp(wanted[if height > 0.0 { 0 } else { 2 }], height.abs())
        });
        let sky = by_elevation(&gradient, Quat::IDENTITY);
        assert_parts(sky, wanted);
        // Turned over, up is down.
        let sky = by_elevation(&gradient, Quat::from_rotation_z(std::f32::consts::PI));
        assert_parts(sky, [wanted[2], wanted[1], wanted[0]]);
    }

    #[test]
    fn half_a_sky_is_fitted_as_on_paper() {
        // Light of 1 from above. Over the sine of the elevation, the best without anything negative is 9/7 y + 3/7 (1 − y).
        let half = cube_map(64, |face, _, y| {
            Vec3::splat(if face == 2 || (face != 3 && y < 32) { 1.0 } else { 0.0 })
        });
        let sky = by_elevation(&half, Quat::IDENTITY);
        assert_close(sky.zenith, Vec3::splat(9.0 / 7.0));
        assert_close(sky.horizon, Vec3::splat(3.0 / 7.0));
        assert_eq!(sky.ground, Vec3::ZERO);
    }

    #[test]
    fn directions_are_those_of_bevys_shaders() {
        // Bevy looks a direction up with its z turned round.
        for (face, wanted) in
            [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::Z].into_iter().enumerate()
        {
            let cells = face * CELLS * CELLS..(face + 1) * CELLS * CELLS;
            let mean: Vec3 = cells.map(|cell| place_of(cell).0).sum();
            assert!(mean.normalize().abs_diff_eq(wanted, 1e-4), "{face}: {mean}");
        }
        let all: f32 = (0..FACES * CELLS * CELLS).map(|cell| place_of(cell).1).sum();
        assert!((all / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-3, "{all}");
    }

    #[test]
    fn formats_of_environment_maps_are_read() {
        let of = |format, bytes: &[u8]| decoder(format).unwrap()(bytes);
        // 1.5 · 2³, 0.5 · 2³ and 0, with a shared exponent of 2³.
        let shared: u32 = 384 | 128 << 9 | (15 + 4 - 1 + 1) << 27;
        assert_eq!(of(TextureFormat::Rgb9e5Ufloat, &shared.to_le_bytes()), Vec3::new(12.0, 4.0, 0.0));
        // 1, 2 and 0.5.
        let small: u32 = 15 << 6 | (16 << 6) << 11 | (14 << 5) << 22;
        assert_eq!(of(TextureFormat::Rg11b10Ufloat, &small.to_le_bytes()), Vec3::new(1.0, 2.0, 0.5));
        assert_eq!(of(TextureFormat::Rgba8Unorm, &[255, 0, 51, 9]), Vec3::new(1.0, 0.0, 0.2));
        assert!((of(TextureFormat::Rgba8UnormSrgb, &[188, 0, 255, 9]).x - 0.5).abs() < 5e-3);
        assert!(decoder(TextureFormat::Bc6hRgbUfloat).is_none());
    }

    #[test]
    fn smaller_levels_are_passed_over() {
        // Each face: four texels of its own colour, then one that is wrong.
        let face = |face: u8| [[face, 0, 0, 255]; 4].concat().into_iter().chain([99, 99, 99, 99]);
        let mut image = cube_map(2, |_, _, _| Vec3::ZERO);
        image.texture_descriptor.format = TextureFormat::Rgba8Unorm;
        image.texture_descriptor.mip_level_count = 2;
        image.data = Some((0..6).flat_map(face).collect());
        let faces = |image: &Image| -> Vec<f32> {
            let cells = CubeMap::of(image).unwrap().0;
            cells.chunks(CELLS * CELLS).map(|face| (255.0 * face[0].x).round()).collect()
        };
        assert_eq!(faces(&image), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        image.data_order = TextureDataOrder::MipMajor;
        image.data = Some((0..6).flat_map(|face| [[face, 0, 0, 255]; 4].concat()).chain([99; 24]).collect());
        assert_eq!(faces(&image), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        image.data = None;
        assert_eq!(CubeMap::of(&image), Err(Unreadable::NoTexels));
        image.texture_descriptor.size.depth_or_array_layers = 1;
        assert_eq!(CubeMap::of(&image), Err(Unreadable::NoCube));
    }
}
