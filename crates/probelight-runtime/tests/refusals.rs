//! Baked scenes that contradict themselves are refused with a reason, not followed into a panic.

mod support;

use std::sync::Arc;

use half::f16;
use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::{Runtime, RuntimeError};
use support::{SMALL, random_room};

fn refusal(spoil: impl FnOnce(&mut BakedScene)) -> String {
    let mut baked = random_room(SMALL);
    spoil(&mut baked);
    match Runtime::new(Arc::new(baked)) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("the runtime took a spoiled scene"),
    }
}

#[test]
fn unspoiled_scene_is_taken() {
    assert!(Runtime::new(Arc::new(random_room(SMALL))).is_ok());
    assert!(matches!(Runtime::new(Arc::new(BakedScene::default())), Err(RuntimeError::Scene(_))));
}

#[test]
fn contradictions_are_named() {
    type Spoil = fn(&mut BakedScene);
    let cases: [(Spoil, &str); 17] = [
        (|b| drop(b.relight_points.pop()), "relight points"),
        (|b| b.relight_points[3].triangle = 99, "relight point 3"),
        (|b| b.relight_points[4].texel = 1 << 30, "relight point 4"),
        (|b| drop(b.lightmap.back_faces.pop()), "back faces"),
        (|b| b.lightmap.back_faces[0] = 99, "back face"),
        (|b| b.receiver_texels[5] = b.receiver_texels[4], "receiver 5"),
        (|b| b.receiver_texels[5] = 1 << 30, "receiver 5"),
        (|b| b.lightmap.dilation[0][0] = b.receiver_texels[0], "dilated twice"),
        (|b| b.lightmap.dilation[0][1] = b.lightmap.dilation[1][0], "no receiver"),
        (|b| b.cluster_probes[0] = 99, "probe"),
        (|b| b.clusters[2].first_receiver += 1, "cluster 2"),
        (|b| b.clusters[2].rank = u32::MAX, "cluster 2"),
        (|b| b.clusters[1].signal_basis_offset = u64::MAX, "cluster 1"),
        (|b| drop(b.row_scales.pop()), "rows"),
        (|b| b.signal_basis[7] = f16::INFINITY, "not finite"),
        (|b| (b.lightmap.width, b.lightmap.height) = (u32::MAX, u32::MAX), "lightmap texels"),
        (|b| b.settings.sh_degree = u32::MAX, "degree"),
    ];
    for (spoil, reason) in cases {
        let refusal = refusal(spoil);
        assert!(refusal.contains(reason), "'{refusal}' does not say '{reason}'");
    }
}

#[test]
fn geometry_is_checked() {
    assert!(refusal(|b| b.scene.positions[0] = Vec3::NAN).contains("not finite"));
}
