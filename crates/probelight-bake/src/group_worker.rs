//! Bakes groups of sites, one at a time and independently of each other.

use std::collections::BTreeMap;

use faer::{Mat, MatRef, Scale};
use probelight_asset::Metric;
use probelight_math::glam::Vec3;
use probelight_math::sh::{Basis, band, coefficient_count};

use crate::checkpoint::FinishedGroup;
use crate::compression::metric::SignalMetric;
use crate::compression::{Compressor, GroupMatrix};
use crate::ground::Groundwork;
use crate::ground::sample_point::Reception;
use crate::ground::site::bounds_of;
use crate::light::SceneLight;
use crate::light::ensemble::LightEnsemble;
use crate::transport::gather::{GatherHit, GatherRay};
use crate::transport::patch_choice::{PatchChoice, WITNESSES};
use crate::transport::probe_choice::choose_probes;
use crate::transport::view::View;
use crate::transport::{ScalarSignals, Transport, TransportBuilder};

/// What the groups have in common.
pub(crate) struct GroupWorker<'a> {
    pub(crate) ground: &'a Groundwork,
    light: &'a SceneLight,
    /// Of the probes.
    basis: Basis,
    /// Of the sky's own signals.
    sky_basis: Basis,
    compressor: Compressor<'a>,
}

/// Gather hits from which a group's probes are chosen.
const CHOICE_HITS: usize = 2048;

/// Support radius as a multiple of the largest distance between the group's receivers and probes; greater
/// than one, so that every chosen probe counts.
const SUPPORT_MARGIN: f32 = 1.1;

/// Error accepted for taking a whole patch's mean, as a share of the error accepted for the cluster: many such
/// errors add up.
const PATCH_ERROR_SHARE: f32 = 0.47;

/// Expected strength of the coefficients of band l relative to band 0: a prior, not a measurement of the scene
/// at hand. Radiance with edges falls off about so.
fn band_strength(l: usize) -> f32 {
    (1.0 + l as f32).powf(-1.5)
}

impl<'a> GroupWorker<'a> {
    /// For the groups of a scene.
    pub(crate) fn new(ground: &'a Groundwork, light: &'a SceneLight) -> Self {
        let Groundwork { settings, .. } = ground;
        let basis = |degree: u32| Basis::new(degree as usize);
        Self {
            ground,
            light,
            basis: basis(settings.sh_degree),
            sky_basis: basis(settings.sky_degree.unwrap_or(0)),
            compressor: Compressor { settings, split_rule: ground.cluster_rule() },
        }
    }

    /// Gathers and compresses a group.
    pub(crate) fn bake_group(&self, group: &[u32]) -> FinishedGroup {
        self.with_transport(group, |transport, matrix| FinishedGroup {
            clusters: self.compressor.compress(matrix),
            approximated_rays: transport.approximated_rays,
            uncovered_rays: transport.uncovered_rays,
        })
    }

    /// How many bytes U and ΣVᵀ of a group would take at each price of a byte.
    pub(crate) fn bytes_at(&self, group: &[u32], prices: &[f32]) -> Vec<u64> {
        self.with_transport(group, |_, matrix| {
            let bytes = |price: &f32| {
                let matrix = GroupMatrix { byte_price: *price, parts: matrix.parts.clone(), ..*matrix };
                self.compressor.compress(&matrix).iter().map(|cluster| cluster.factors.bytes() as u64).sum()
            };
            prices.iter().map(bytes).collect()
        })
    }

    /// Gathers a group's transport.
    fn with_transport<R>(&self, group: &[u32], then: impl FnOnce(&Transport, &GroupMatrix<'_>) -> R) -> R {
        let reception = self.ground.reception(group[0]);
        let views: Vec<View> =
            group.iter().map(|site| View::of(self.ground, &self.light.sources.surfels, *site)).collect();
        let has_scalars = self.ground.plan.has_scalar_signals();
        let patches = match &self.light.ensemble {
            Some(ensemble) if has_scalars => {
                self.choose_patches(ensemble, &views, self.ground.unforeseen_share_of(reception))
            }
            _ => PatchChoice::default(),
        };
        let scalars = has_scalars.then(|| self.scalar_signals(group, &patches));
        let probes = self.choose_probes(group, &views, scalars.as_ref());
        let builder = TransportBuilder {
            tracer: &self.ground.tracer,
            basis: &self.basis,
            scalars,
            support_radius: SUPPORT_MARGIN * self.farthest_distance(group, &probes),
            probes: probes.iter().map(|p| self.ground.probes.positions[*p as usize]).collect(),
            coverage: self.coverage_of(&probes),
        };
        let mut transport = Transport::default();
        for (site, view) in group.iter().zip(&views) {
            builder.add_rows(&self.ground.place(*site), view, &mut transport);
        }
        if let Some(scalars) = &builder.scalars {
            transport.signals = scalars.numbers();
            transport.drop_unused_signals();
        }
        let receivers: Vec<u32> = group.iter().flat_map(|site| self.ground.rows(*site)).collect();
        let matrix = GroupMatrix {
            receivers: &receivers,
            sites: &receivers.iter().map(|row| *self.ground.site_of_row(*row)).collect::<Vec<_>>(),
            parts: parts_of(group.len(), reception),
            rows_per_place: reception.rows(),
            error: self.ground.error_of(reception),
            byte_price: self.ground.byte_price_of(reception),
            halves: transport.halves.each_ref().map(Vec::as_slice),
            columns: transport.columns,
            signals: &transport.signals,
            probes: &probes,
            metric: &self.metric(receivers.len(), &transport, &probes),
        };
        then(&transport, &matrix)
    }

    fn choose_patches(&self, ensemble: &LightEnsemble, views: &[View], unforeseen: f32) -> PatchChoice {
        let mut seen: Vec<u32> = views.iter().flat_map(View::surfels).map(|(surfel, _)| surfel).collect();
        seen.sort_unstable();
        seen.dedup();
        // Neighbours in a group share a witness, so that what any receiver sees counts.
        let witnesses: Vec<Vec<(u32, f32)>> = views
            .chunks(views.len().div_ceil(WITNESSES))
            .map(|views| {
                let share = 1.0 / views.len() as f32;
                views
                    .iter()
                    .flat_map(View::surfels)
                    .map(|(surfel, weight)| (surfel, share * weight))
                    .collect()
            })
            .collect();
        let error = PATCH_ERROR_SHARE * self.ground.settings.max_cluster_error;
        PatchChoice::new(&self.light.sources.surfels, ensemble, &witnesses, &seen, error * error, unforeseen)
    }

    fn scalar_signals<'b>(&'b self, group: &[u32], patches: &'b PatchChoice) -> ScalarSignals<'b> {
        ScalarSignals {
            patches,
            emitters: &self.light.sources.emitters,
            sampling: self.light.sources.emitters.sampling(&bounds_of(&self.ground.sites, group)),
            sky: &self.sky_basis,
            first_emitter_signal: self.light.sources.surfels.patches() as u32,
            near_radius: self.ground.settings.near_radius,
        }
    }

    /// The probes for the rays whose light they bring: with surfels and sky signals only those that end far away.
    fn choose_probes(&self, group: &[u32], views: &[View], scalars: Option<&ScalarSignals<'_>>) -> Vec<u32> {
        let needs_probes = |ray: &&GatherRay| {
            scalars.is_none_or(|scalars| ray.hit.is_some_and(|hit| scalars.near_share(hit.distance) < 1.0))
        };
        let far: Vec<&GatherRay> = views.iter().flat_map(View::rays).filter(needs_probes).collect();
        let sample: Vec<GatherHit> = far
            .iter()
            .step_by(far.len().div_ceil(CHOICE_HITS).max(1))
            .map(|ray| ray.end(&self.ground.tracer))
            .collect();
        if sample.is_empty() {
            return Vec::new();
        }
        let most = self.ground.settings.probes_per_cluster as usize;
        choose_probes(self.ground, group, &sample, most)
    }

    fn coverage_of(&self, probes: &[u32]) -> Vec<f32> {
        let coverage = &self.light.sources.balance.coverage;
        let of_probe = |p: &u32| coverage.chunks_exact(self.basis.len()).nth(*p as usize);
        probes.iter().filter_map(of_probe).flatten().copied().collect()
    }

    fn farthest_distance(&self, group: &[u32], probes: &[u32]) -> f32 {
        let positions = || group.iter().map(|r| self.ground.sites[*r as usize].position);
        probes
            .iter()
            .map(|p| self.ground.probes.positions[*p as usize])
            .flat_map(|probe: Vec3| positions().map(move |position| position.distance(probe)))
            .fold(f32::MIN_POSITIVE, f32::max)
    }

    /// The metric of a group's decomposition.
    fn metric(&self, receivers: usize, transport: &Transport, probes: &[u32]) -> SignalMetric {
        let scalars = transport.signals.len();
        let coefficient = |c: usize| coefficient_of_column(c - scalars, probes.len());
        let ensemble = match (self.ground.settings.metric, &self.light.ensemble) {
            (Metric::Radiance, Some(ensemble)) => ensemble,
            (Metric::Plain, _) => return SignalMetric::independent(vec![1.0; transport.columns]),
            _ => {
                let strength =
                    |c: usize| if c < scalars { 1.0 } else { band_strength(band(coefficient(c).1)) };
                return SignalMetric::independent((0..transport.columns).map(strength).collect());
            }
        };
        let per_probe = coefficient_count(self.ground.settings.sh_degree as usize);
        let lit = |c: usize| match transport.signals.get(c) {
            Some(signal) => ensemble.scalar(*signal as usize),
            None => {
                let (p, j) = coefficient(c);
                ensemble.coefficient(probes[p] as usize * per_probe + j)
            }
        };
        let rows: Vec<&[f32]> = (0..transport.columns).map(lit).collect();
        let floor = rows
            .iter()
            .enumerate()
            .map(|(c, row)| {
                let mean_square = row.iter().map(|v| v * v).sum::<f32>() / row.len().max(1) as f32;
                let parts = transport
                    .signals
                    .get(c)
                    .map_or(1.0, |s| self.light.sources.surfels.surfels_in(*s) as f32);
                (mean_square / parts).sqrt()
            })
            .collect();
        let [first, second] = transport
            .halves
            .each_ref()
            .map(|rows| MatRef::from_row_major_slice(rows, receivers, transport.columns));
        let lit = Mat::from_fn(transport.columns, ensemble.count, |c, i| rows[c][i]);
        SignalMetric::radiance(lit, ensemble.weights(), floor, &((first + second) * Scale(0.5)))
    }
}

/// Probe (of `probes`) and coefficient of a column among the probes' columns, which are band-major.
fn coefficient_of_column(column: usize, probes: usize) -> (usize, usize) {
    let l = band(column / probes);
    let within = column - probes * l * l;
    (within / (2 * l + 1), l * l + within % (2 * l + 1))
}

/// The rows of so many places that are compressed together.
fn parts_of(places: usize, reception: Reception) -> Vec<Vec<u32>> {
    let mut parts = BTreeMap::<usize, Vec<u32>>::new();
    for row in 0..places * reception.rows() {
        parts.entry(reception.part_of(row % reception.rows())).or_default().push(row as u32);
    }
    parts.into_values().collect()
}
