//! The flags of `bake` that decide what is baked, and how finely.

use clap::{Args, ValueEnum};
use probelight_asset::{GridBasis, GridBasisKind, GridLobe, Method, Metric, Storage};
use probelight_bake::{BakeOptions, Quality};

/// What is baked, and how finely.
#[derive(Args)]
#[command(next_help_heading = "Settings")]
pub(crate) struct SettingFlags {
    /// How much time and space the bake may take; flags given besides win over what this sets
    #[arg(long, value_enum, default_value_t)]
    quality: QualityFlag,
    /// Relative error of the compressed light transport against the uncompressed that every cluster of
    /// receivers keeps, at any size of the file, as a share: 0.03 is 3 % [default: by --quality, as far as
    /// --max-rank and reasonable bytes allow]
    #[arg(long, value_name = "X")]
    error: Option<f32>,
    /// Wanted number of receivers: lightmap texels with light of their own
    /// [default: from the scene's scale, with an upper limit by --quality]
    #[arg(long, value_name = "N", conflicts_with = "texel_density")]
    receivers: Option<u32>,
    /// Lightmap texels per metre, instead of --receivers
    #[arg(long, value_name = "T")]
    texel_density: Option<f32>,
    /// Gather rays per receiver: less noise in the light, longer bake [default: by --quality; up to four
    /// times that where receivers are few; with --method paper twice that]
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// Most singular values kept per cluster, 1 to 256; limits what --error may take [default: by --quality;
    /// as many as --error takes if that is given]
    #[arg(long, value_name = "K")]
    max_rank: Option<u32>,
    /// What the receivers take their light from
    #[arg(long, value_enum, default_value_t)]
    method: MethodFlag,
    /// What the compression keeps first [default: radiance; band with --method paper]
    #[arg(long, value_enum)]
    metric: Option<MetricFlag>,
    /// How matrices are stored [default: packed; f16 with --method paper]
    #[arg(long, value_enum)]
    storage: Option<StorageFlag>,
    /// Width of the surfels, metres: smaller ones keep small bright places sharp, at more bytes and time each
    /// frame [default: from the scene's scale, at least 2.5 texels]
    #[arg(long, value_name = "M")]
    surfel_size: Option<f32>,
    /// Points of each surfel at which bounced light is evaluated, at most: one for each of its texels, as
    /// far as there are no more [default: 16]
    #[arg(long, value_name = "N")]
    samples_per_surfel: Option<u32>,
    /// Distance beyond which light is taken from probes instead of surfels, metres; handed over smoothly
    /// [default: 8 surfel widths]
    #[arg(long, value_name = "M")]
    near_radius: Option<f32>,
    /// Probes per cubic metre of open space [default: adapted to the scene, at least 0.02]
    #[arg(long, value_name = "D")]
    probe_density: Option<f32>,
    /// Relight rays per probe: finer light at each frame's cost [default: 512; up to 2048 where there are few
    /// probes]
    #[arg(long, value_name = "N")]
    relight_rays: Option<u32>,
    /// Highest spherical-harmonics band of the probes, 0 to 11 [default: 7; 10 with 2048 relight rays]
    #[arg(long, value_name = "L")]
    sh_degree: Option<u32>,
    /// Most probes a cluster draws on; up to twice as many where rays end unseen by them [default: 6; 10
    /// with --method paper]
    #[arg(long, value_name = "P")]
    probes_per_cluster: Option<u32>,
    /// Most receivers of a cluster [default: 512; 256 with --method paper]
    #[arg(long, value_name = "R")]
    receivers_per_cluster: Option<u32>,
    /// Bytes that the matrices U and ΣVᵀ may take per receiver, on average; fewer where --error takes fewer
    /// [default: by --quality from 400 000 receivers on; of fewer, more]
    #[arg(long, value_name = "N", conflicts_with = "byte_price")]
    bytes: Option<f32>,
    /// What a further byte per receiver must save, as a share of the energy of --error, instead of --bytes, from which it
    /// follows otherwise (`info` prints it). Give it and the rays, so that parts of a world that are baked one by one are alike
    #[arg(long, value_name = "X")]
    byte_price: Option<f32>,
    /// Leave the jumps where clusters meet as they are [default: they blend; not with --method paper]
    #[arg(long)]
    hard_borders: bool,
    /// Vertices of the grid that keeps light in free space for moving objects; 0 for none [default: one
    /// for 40 receivers, at least 6000]
    #[arg(long, value_name = "N", conflicts_with = "grid_spacing")]
    grid: Option<u32>,
    /// Distances that there are between vertices of the grid, each twice the last, the smallest in rooms
    /// and near emitters; with 1 the grid is even, and --grid counts what lies in solids, too [default: 3]
    #[arg(long, value_name = "L", conflicts_with = "grid_spacing")]
    grid_levels: Option<u32>,
    /// Distance between neighbouring vertices of an even grid, metres, instead of --grid
    #[arg(long, value_name = "M")]
    grid_spacing: Option<f32>,
    /// What a vertex of the grid keeps of the light around it
    #[arg(long, value_enum, default_value_t)]
    grid_basis: GridBasisFlag,
    /// How each direction of a basis of axes weighs light
    #[arg(long, value_enum, default_value_t)]
    grid_lobe: GridLobeFlag,
    /// Lay the lightmap out by the scene's second texture coordinates where they are valid
    #[arg(long)]
    use_uv1: bool,
    /// Seed of all random numbers [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
}

impl From<SettingFlags> for BakeOptions {
    fn from(flags: SettingFlags) -> Self {
        Self {
            quality: Some(flags.quality.into()),
            method: Some(flags.method.into()),
            metric: flags.metric.map(Metric::from),
            storage: flags.storage.map(Storage::from),
            receivers: flags.receivers,
            texels_per_meter: flags.texel_density,
            probe_density: flags.probe_density,
            surfel_size: flags.surfel_size,
            samples_per_surfel: flags.samples_per_surfel,
            near_radius: flags.near_radius,
            gather_rays: flags.rays,
            relight_rays: flags.relight_rays,
            sh_degree: flags.sh_degree,
            max_rank: flags.max_rank,
            max_cluster_error: flags.error,
            probes_per_cluster: flags.probes_per_cluster,
            receivers_per_cluster: flags.receivers_per_cluster,
            blend_borders: flags.hard_borders.then_some(false),
            bytes_per_receiver: flags.bytes,
            byte_price: flags.byte_price,
            grid_vertices: flags.grid,
            grid_levels: flags.grid_levels,
            grid_spacing: flags.grid_spacing,
            grid_basis: Some(GridBasis { kind: flags.grid_basis.into(), lobe: flags.grid_lobe.into() }),
            use_uv1: flags.use_uv1,
            seed: flags.seed,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum QualityFlag {
    /// At most 50 000 receivers, 64 rays each, error 0.064: to look at a scene while it is being made
    Preview,
    /// At most 400 000 receivers, 256 rays each, error 0.016, 44 bytes each
    #[default]
    Medium,
    /// At most 800 000 receivers, 512 rays each, error 0.012, 60 bytes each: to keep
    High,
    /// At most 1 600 000 receivers, 1024 rays each, error 0.008, 80 bytes each: for the last bake of
    /// all
    Production,
}

impl From<QualityFlag> for Quality {
    fn from(flag: QualityFlag) -> Self {
        match flag {
            QualityFlag::Preview => Self::Preview,
            QualityFlag::Medium => Self::Medium,
            QualityFlag::High => Self::High,
            QualityFlag::Production => Self::Production,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum MethodFlag {
    /// Probes alone, as published: blurs light that changes fast and near
    Paper,
    /// Surfels, emitters and the sky as signals of their own, with probes for what is far away
    #[default]
    Hybrid,
}

impl From<MethodFlag> for Method {
    fn from(flag: MethodFlag) -> Self {
        match flag {
            MethodFlag::Paper => Self::Paper,
            MethodFlag::Hybrid => Self::Hybrid,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum MetricFlag {
    /// All signals alike: nothing is assumed of the light, and the file is largest
    Plain,
    /// High bands of the probes count less
    Band,
    /// What random but plausible lamps, suns, skies and emitters bring; other light keeps a share
    Radiance,
}

impl From<MetricFlag> for Metric {
    fn from(flag: MetricFlag) -> Self {
        match flag {
            MetricFlag::Plain => Self::Plain,
            MetricFlag::Band => Self::Band,
            MetricFlag::Radiance => Self::Radiance,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum StorageFlag {
    /// Half floats
    F16,
    /// Eight bits, and four where they do
    Packed,
}

impl From<StorageFlag> for Storage {
    fn from(flag: StorageFlag) -> Self {
        match flag {
            StorageFlag::F16 => Self::F16,
            StorageFlag::Packed => Self::Packed,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum GridBasisFlag {
    /// Irradiance in spherical harmonics of bands 0 to 2: nine numbers
    #[default]
    Sh2,
    /// Light from the six directions of the axes, as published
    Axes6,
    /// From the axes and the corners of a cube
    Axes14,
    /// From the axes, the corners and the edges of a cube
    Axes26,
}

impl From<GridBasisFlag> for GridBasisKind {
    fn from(flag: GridBasisFlag) -> Self {
        match flag {
            GridBasisFlag::Sh2 => Self::Sh2,
            GridBasisFlag::Axes6 => Self::Axes6,
            GridBasisFlag::Axes14 => Self::Axes14,
            GridBasisFlag::Axes26 => Self::Axes26,
        }
    }
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum GridLobeFlag {
    /// By the angle to it, as published
    Angle,
    /// By the cosine, as a surface does
    #[default]
    Cosine,
}

impl From<GridLobeFlag> for GridLobe {
    fn from(flag: GridLobeFlag) -> Self {
        match flag {
            GridLobeFlag::Angle => Self::Angle,
            GridLobeFlag::Cosine => Self::Cosine,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits in groups of three, as the help has them from 10 000 on.
    fn grouped(number: u32) -> String {
        match number {
            0..10_000 => number.to_string(),
            10_000..1_000_000 => format!("{} 000", number / 1000),
            _ => format!("{} {} 000", number / 1_000_000, number / 1000 % 1000),
        }
    }

    #[test]
    fn the_help_of_each_quality_says_what_it_sets() {
        for flag in QualityFlag::value_variants() {
            let preset = Quality::from(*flag).preset();
            let help = flag.to_possible_value().unwrap().get_help().unwrap().to_string();
            let receivers = format!("At most {} receivers,", grouped(preset.max_receivers));
            let rays = format!(" {} rays each,", preset.gather_rays);
            let error = format!(" error {}", preset.max_cluster_error);
            assert!([receivers, rays, error].iter().all(|part| help.contains(part)), "{help}: {preset:?}");
        }
    }
}
