//! What is shown of a scene, and how. Not undone, and not saved with the setup.

use std::collections::BTreeSet;

use probelight_render::gpu::{Coloring, GpuView, Shading, ViewOptions};
use probelight_runtime::LodSettings;
use probelight_scene::Camera;

use super::action::Action;
use super::document::Item;

/// What lies left of the divider.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compare {
    /// The same picture: there is no divider.
    #[default]
    Nothing,
    /// The picture without indirect light.
    WithoutIndirect,
    /// The path-traced reference, which grows while nothing changes.
    Reference,
}

/// How bright pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureMode {
    /// By what the camera sees, smoothly.
    Automatic,
    /// Radiance times 2^EV.
    Fixed(f32),
}

/// What the colours of [`GpuView::Clusters`] stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TexelColors {
    /// A colour for each cluster.
    #[default]
    Clusters,
    /// How many singular values the last frame computed of the cluster.
    Ranks,
    /// The level of detail: which share of the cluster's receivers the last frame computed.
    Levels,
    /// In front of the view, beside it, behind it.
    Zones,
    /// Error of the compressed transport against the wanted one.
    Errors,
    /// How many probes serve the cluster.
    Probes,
}

impl TexelColors {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Clusters, Self::Ranks, Self::Levels, Self::Zones, Self::Errors, Self::Probes];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clusters => "clusters",
            Self::Ranks => "singular values",
            Self::Levels => "receivers by level",
            Self::Zones => "zones of the view",
            Self::Errors => "error of compression",
            Self::Probes => "number of probes",
        }
    }
}

/// What the colours of the lightmap's page stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PageColors {
    /// Its light.
    #[default]
    Irradiance,
    /// Triangles that are unwrapped in one piece.
    Charts,
    /// As those of [`GpuView::Clusters`].
    Texels(TexelColors),
}

impl PageColors {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::Irradiance, Self::Charts].into_iter().chain(TexelColors::ALL.map(Self::Texels))
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Irradiance => "irradiance",
            Self::Charts => "charts",
            Self::Texels(colors) => colors.name(),
        }
    }
}

/// What is drawn over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overlays {
    /// Lights, and the handles of what is selected.
    pub lights: bool,
    /// Rays and reach of the probes that serve the picked place.
    pub probes: bool,
    /// Vertices of the grid near the picked place, with the direction that most light comes from.
    pub grid: bool,
}

/// Which sources are left out, to see what the others do. The setup keeps them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Muted {
    /// The sky.
    pub sky: bool,
    /// Emissive surfaces.
    pub emission: bool,
    /// What surfaces pass on.
    pub bounces: bool,
    /// Lights.
    pub lights: BTreeSet<Item>,
}

/// What the next bake is to have otherwise than its quality has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeNumbers {
    /// Texels with light of their own.
    pub receivers: Option<u32>,
    /// Rays of each receiver.
    pub gather_rays: Option<u32>,
    /// Relative error that compression may make, percent.
    pub error_percent: Option<f32>,
    /// Width of surfels, metres.
    pub surfel_size: Option<f32>,
    /// Vertices of the grid in free space.
    pub grid_vertices: Option<u32>,
}

/// Which panels are open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panels {
    /// Lights, objects, materials.
    pub scene: bool,
    /// What is shown, detail, bake.
    pub settings: bool,
    /// Times.
    pub timing: bool,
    /// The lightmap as a picture.
    pub lightmap: bool,
    /// Keys.
    pub help: bool,
}

/// What is shown, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewState {
    /// Where one looks from. Its size follows the window.
    pub camera: Camera,
    /// What the picture shows.
    pub options: ViewOptions,
    /// What lies left of the divider.
    pub compare: Compare,
    /// Where the divider is, as a share of the width.
    pub divider: f32,
    /// How bright pictures are shown.
    pub exposure: ExposureMode,
    /// As it is, or in false colours.
    pub coloring: Coloring,
    /// Whether pixels are marked that are no number, negative, or too bright to be shown.
    pub marks: bool,
    /// What the colours of clusters stand for.
    pub texel_colors: TexelColors,
    /// What the colours of the lightmap's page stand for.
    pub page_colors: PageColors,
    /// What is drawn over the picture.
    pub overlays: Overlays,
    /// Which sources are left out.
    pub muted: Muted,
    /// Levels of detail.
    pub lod: LodSettings,
    /// Time that the light of a frame may take, milliseconds: levels follow it.
    pub hold_milliseconds: Option<f32>,
    /// Similarity (SSIM) to the picture without levels of detail: levels begin as near as it allows.
    pub hold_similarity: Option<f32>,
    /// Whether time goes on for what moves by itself.
    pub is_playing: bool,
    /// Seconds since the beginning.
    pub time: f32,
    /// Factor on the speed of the camera.
    pub speed: f32,
    /// Share of the window's pixels, along each side, that are drawn.
    pub resolution: f32,
    /// At most 60 frames a second.
    pub caps_frames: bool,
    /// Whether frames wait for the display.
    pub vsync: bool,
    /// What the next bake is to have.
    pub bake_numbers: BakeNumbers,
    /// Which panels are open.
    pub panels: Panels,
}

impl ViewState {
    /// What one sees first, from a camera.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            options: ViewOptions::default(),
            compare: Compare::default(),
            divider: 0.5,
            exposure: ExposureMode::Automatic,
            coloring: Coloring::default(),
            marks: false,
            texel_colors: TexelColors::default(),
            page_colors: PageColors::default(),
            overlays: Overlays { lights: true, probes: false, grid: false },
            muted: Muted::default(),
            lod: LodSettings::default(),
            hold_milliseconds: None,
            hold_similarity: None,
            is_playing: true,
            time: 0.0,
            speed: 1.0,
            resolution: 1.0,
            caps_frames: true,
            vsync: true,
            bake_numbers: BakeNumbers::default(),
            panels: Panels { scene: true, settings: true, timing: true, lightmap: false, help: false },
        }
    }

    /// Does what an action asks of the view. `shown_ev` is the exposure of the last picture.
    pub(super) fn act(&mut self, action: Action, shown_ev: f32) {
        let is_full = self.options.view == GpuView::Full;
        match action {
            Action::View(wanted) => {
                let Camera { width, height, .. } = self.camera;
                *self = *wanted;
                (self.camera.width, self.camera.height) = (width, height);
            }
            Action::Show(wanted) => self.options.view = wanted,
            Action::ToggleIndirect => {
                self.options.view = if is_full { GpuView::Direct } else { GpuView::Full };
            }
            Action::NextComparison => {
                self.compare = match self.compare {
                    Compare::Nothing => Compare::WithoutIndirect,
                    Compare::WithoutIndirect => Compare::Reference,
                    Compare::Reference => Compare::Nothing,
                };
            }
            Action::ToggleShading => {
                self.options.shading = match self.options.shading {
                    Shading::Diffuse => Shading::Physical,
                    Shading::Physical => Shading::Diffuse,
                };
            }
            Action::TogglePlaying => self.is_playing = !self.is_playing,
            Action::Brighten(stops) => self.exposure = ExposureMode::Fixed(shown_ev + stops),
            Action::ToggleExposure => {
                self.exposure = match self.exposure {
                    ExposureMode::Automatic => ExposureMode::Fixed(shown_ev),
                    ExposureMode::Fixed(_) => ExposureMode::Automatic,
                };
            }
            Action::ToggleHelp => self.panels.help = !self.panels.help,
            Action::TogglePanels => {
                let Panels { scene, settings, timing, .. } = &mut self.panels;
                let are_open = *scene || *settings || *timing;
                (*scene, *settings, *timing) = (!are_open, !are_open, !are_open);
            }
            // What is not the view's.
            _ => {}
        }
    }
}
