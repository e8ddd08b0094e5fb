//! Checks of a baked scene: every index and range that the stages rely on.

use probelight_asset::{BakedScene, NONE};

use crate::RuntimeError;

/// Most texels a lightmap may have (3 GiB of irradiance), so that a wrong size cannot exhaust the memory.
const MOST_TEXELS: u64 = 1 << 28;

/// Most bands of the probes (coefficients up to degree 31 already outnumber any sensible set of relight rays).
const HIGHEST_DEGREE: u32 = 31;

/// # Errors
/// Names the first contradiction.
pub(crate) fn validate(baked: &BakedScene) -> Result<(), RuntimeError> {
    baked.scene.validate()?;
    let texels = u64::from(baked.lightmap.width) * u64::from(baked.lightmap.height);
    ensure(texels <= MOST_TEXELS, || format!("{texels} lightmap texels are more than {MOST_TEXELS}"))?;
    ensure(baked.settings.sh_degree <= HIGHEST_DEGREE, || {
        format!("spherical-harmonics degree {} is above {HIGHEST_DEGREE}", baked.settings.sh_degree)
    })?;
    validate_relight_points(baked, texels)?;
    validate_layout(baked)?;
    validate_texels(baked, texels as usize)?;
    validate_clusters(baked)
}

fn ensure(holds: bool, reason: impl FnOnce() -> String) -> Result<(), RuntimeError> {
    if holds { Ok(()) } else { Err(RuntimeError::Inconsistent { reason: reason() }) }
}

fn validate_relight_points(baked: &BakedScene, texels: u64) -> Result<(), RuntimeError> {
    let expected = baked.probes.len() * baked.relight_directions.len();
    ensure(baked.relight_points.len() == expected, || {
        format!("{} relight points instead of {expected}", baked.relight_points.len())
    })?;
    for (i, point) in baked.relight_points.iter().enumerate() {
        let triangle = point.triangle == NONE || (point.triangle as usize) < baked.scene.triangles.len();
        let texel = point.texel == NONE || u64::from(point.texel) < texels;
        ensure(triangle && texel, || {
            format!("relight point {i} refers to a triangle or texel that does not exist")
        })?;
    }
    Ok(())
}

fn validate_layout(baked: &BakedScene) -> Result<(), RuntimeError> {
    let layout = &baked.lightmap;
    let triangles = baked.scene.triangles.len();
    ensure(layout.faces.len() >= triangles && layout.back_faces.len() == triangles, || {
        format!(
            "{} faces and {} back faces for {triangles} triangles",
            layout.faces.len(),
            layout.back_faces.len()
        )
    })?;
    let exists = |face: &u32| *face == NONE || (*face as usize) < layout.faces.len();
    ensure(layout.back_faces.iter().all(exists), || "a back face does not exist".into())
}

/// Each texel takes its value from one place, and dilation copies from receivers.
fn validate_texels(baked: &BakedScene, texels: usize) -> Result<(), RuntimeError> {
    ensure(baked.receiver_texels.len() <= texels && baked.lightmap.dilation.len() <= texels, || {
        "there are more receivers or dilated texels than lightmap texels".into()
    })?;
    let mut is_receiver = vec![false; texels];
    for (receiver, texel) in baked.receiver_texels.iter().enumerate() {
        let is_free = is_receiver.get(*texel as usize) == Some(&false);
        ensure(is_free, || format!("receiver {receiver} lies in no texel or shares texel {texel}"))?;
        is_receiver[*texel as usize] = true;
    }
    let mut is_filled = is_receiver.clone();
    for [texel, source] in &baked.lightmap.dilation {
        let is_free = is_filled.get(*texel as usize) == Some(&false);
        ensure(is_free, || format!("texel {texel} is dilated twice, a receiver, or does not exist"))?;
        let has_source = is_receiver.get(*source as usize) == Some(&true);
        ensure(has_source, || format!("dilation copies from texel {source}, which is no receiver"))?;
        is_filled[*texel as usize] = true;
    }
    Ok(())
}

/// Clusters follow each other without gaps in receivers and rows, and their matrices exist and are finite.
fn validate_clusters(baked: &BakedScene) -> Result<(), RuntimeError> {
    let probes_exist = baked.cluster_probes.iter().all(|p| (*p as usize) < baked.probes.len());
    ensure(probes_exist, || "a cluster draws on a probe that does not exist".into())?;
    let (mut receivers, mut rows) = (0u64, 0u64);
    for (i, cluster) in baked.clusters.iter().enumerate() {
        let follows =
            u64::from(cluster.first_receiver) == receivers && u64::from(cluster.row_scale_offset) == rows;
        ensure(follows, || format!("cluster {i} does not begin where the one before it ends"))?;
        let (rank, count) = (u64::from(cluster.rank), u64::from(cluster.receiver_count));
        receivers += count;
        rows += rank;
        let columns = baked.column_count(cluster) as u64;
        let inside = |start: u64, length: Option<u64>, available: usize| {
            length.and_then(|length| start.checked_add(length)).is_some_and(|end| end <= available as u64)
        };
        let fits =
            inside(cluster.first_probe.into(), Some(cluster.probe_count.into()), baked.cluster_probes.len())
                && inside(cluster.receiver_basis_offset, rank.checked_mul(count), baked.receiver_basis.len())
                && inside(cluster.signal_basis_offset, rank.checked_mul(columns), baked.signal_basis.len());
        ensure(fits, || format!("cluster {i} reaches beyond its probes or matrices"))?;
    }
    ensure(receivers == baked.receiver_texels.len() as u64 && rows == baked.row_scales.len() as u64, || {
        format!(
            "the clusters hold {receivers} receivers and {rows} rows instead of {} and {}",
            baked.receiver_texels.len(),
            baked.row_scales.len()
        )
    })?;
    let matrices = baked.receiver_basis.iter().chain(&baked.signal_basis);
    let is_finite =
        matrices.into_iter().all(|v| v.is_finite()) && baked.row_scales.iter().all(|s| s.is_finite());
    ensure(is_finite, || "a transport matrix has a value that is not finite".into())
}
