//! Sites: places that gather light, whatever their light is stored for.
//!
//! Gathering, the choice of signals, transport and compression know sites only. That a site is a lightmap texel
//! or a vertex of the grid matters to the steps before ([`crate::ground::receivers`], [`crate::ground::grid`]) and to
//! the file.

use probelight_math::glam::Vec3;
use probelight_scene::Bounds;
use probelight_trace::Tracer;

use crate::ground::sample_point::{Reception, SamplePoint};

/// A place that gathers light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Site {
    /// Seeds its random numbers, and orders it among others of its level; no two sites have the same.
    pub(crate) seed: u32,
    /// Coarsest level of detail that it belongs to.
    pub(crate) level: u32,
    /// World position, metres.
    pub(crate) position: Vec3,
    /// Unit, towards the side that it gathers from; zero if that is all around.
    pub(crate) normal: Vec3,
    /// The nearest probe it sees; `None` where none does.
    pub(crate) outlook: Option<Outlook>,
}

/// From where a site's surroundings are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Outlook {
    /// The nearest probe that the site sees.
    pub(crate) probe: u32,
    /// Its position, metres.
    pub(crate) position: Vec3,
    /// Its air space (see [`crate::ground::outlooks`]).
    pub(crate) air_space: u32,
    /// Its room, a part of that.
    pub(crate) room: u32,
}

/// A site, the points that its rays start from, and what it keeps of the light.
pub(crate) struct Place<'a> {
    pub(crate) site: &'a Site,
    pub(crate) points: Vec<SamplePoint>,
    pub(crate) reception: Reception,
}

impl Site {
    /// Where rays from the site start: moved off the surface.
    pub(crate) fn ray_origin(&self, tracer: &Tracer) -> Vec3 {
        tracer.off_surface(self.position, self.normal)
    }

    /// The air space it lies in; `None` where no probe sees it.
    pub(crate) fn air_space(&self) -> Option<u32> {
        self.outlook.map(|outlook| outlook.air_space)
    }

    /// The room that it lies in; `None` where no probe sees it.
    pub(crate) fn room(&self) -> Option<u32> {
        self.outlook.map(|outlook| outlook.room)
    }
}

/// Box around a group of sites, metres.
pub(crate) fn bounds_of(sites: &[Site], group: &[u32]) -> Bounds {
    Bounds::of(group.iter().map(|s| sites[*s as usize].position))
}
