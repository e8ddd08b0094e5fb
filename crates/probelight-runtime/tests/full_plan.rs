//! A frame at full detail has the bits that frames had before there were plans (commit f51b1b1).
//!
//! They depend on the vector units that are compiled for, by the order of sums and by fused products, and on the C library's
//! `exp2` and `pow`; so they are compared where they were taken.
#![cfg(all(
    feature = "cpu",
    target_arch = "x86_64",
    target_os = "linux",
    target_env = "gnu",
    any(
        target_feature = "avx512f",
        all(target_feature = "avx2", target_feature = "fma"),
        not(any(target_feature = "avx", target_feature = "fma"))
    )
))]

mod support;

use std::sync::Arc;

use probelight_asset::BakedScene;
use probelight_math::glam::Vec3;
use probelight_runtime::{FrameInput, Runtime};
use support::{SMALL, SMALL_PAPER, Size, all_lights, random_room};

/// Of each room, [`hashes`].
type Expected = [[u64; 5]; 4];

#[cfg(target_feature = "avx512f")]
const EXPECTED: Expected = [
    [
        0x5a4f_2b97_fcc6_994c,
        0x49eb_a61f_80f2_2f58,
        0xfc00_5d4c_c82a_3c0f,
        0x4b1b_95aa_90c9_96a0,
        0x708c_49a2_e094_21b3,
    ],
    [
        0xea62_4343_d4dc_b840,
        0x7fe0_508e_efc2_3731,
        0xa382_2e92_7977_a6cc,
        0xa6d6_de7a_080a_ac15,
        0x6fad_07bb_4c2d_4b31,
    ],
    [
        0x0396_c592_5425_67b6,
        0x8ee6_c5b2_57dd_2e91,
        0xf3bd_f6bc_4265_2ec9,
        0x7640_1716_50a0_eee9,
        0x30bf_482d_0481_ade9,
    ],
    [
        0x924e_2ade_8614_8fa1,
        0x60e9_beb4_f082_f34d,
        0xc7cd_1eec_3293_1c3b,
        0xc760_6623_f670_469e,
        0xfb49_5fc5_dc39_6828,
    ],
];

#[cfg(all(target_feature = "fma", not(target_feature = "avx512f")))]
const EXPECTED: Expected = [
    [
        0x83be_dec3_8546_0144,
        0x1fe8_0c79_76e2_3016,
        0x2bb6_4445_65e1_bd99,
        0xd3b7_fc13_6aa1_dccc,
        0x6a75_0d9e_d573_6d3b,
    ],
    [
        0x0fc1_42f3_c783_fc78,
        0xe403_c328_1038_ecd0,
        0x8fa8_fafe_8e6a_3b24,
        0x7f5c_d3d9_f834_0bc5,
        0xa7fa_35d3_dc12_e3dc,
    ],
    [
        0x6aac_abd8_d8c6_624c,
        0xe8a7_3cef_59b8_f214,
        0x1518_dc29_b10d_ca36,
        0xcb36_6174_b830_c77e,
        0x1bc5_73c7_46fd_0c4e,
    ],
    [
        0x8e3e_e0e5_a6c9_1351,
        0xe3d2_dbc4_0588_455a,
        0x34c6_58cc_fa33_3224,
        0x01a8_91d8_ba3c_6c99,
        0x0b7c_7baf_d9bd_45ac,
    ],
];

#[cfg(not(target_feature = "fma"))]
const EXPECTED: Expected = [
    [
        0x7c0b_3e22_f682_b289,
        0x302b_ab48_b518_6d48,
        0x5807_4a98_1dc5_b74b,
        0x640f_a6f8_ddc1_3926,
        0xa09e_c168_4070_9d62,
    ],
    [
        0xb07c_c1df_c7f0_12e6,
        0x6eeb_9071_7b94_4f05,
        0x7a30_fe54_5c1e_b6de,
        0x6e46_6bc5_abc0_bc02,
        0xd09b_c3cd_5d98_fb8e,
    ],
    [
        0x47bd_0ad6_c200_6004,
        0x4ce3_a0dd_f5f4_39e9,
        0x1151_2678_d512_b2e7,
        0xce8e_1fb5_23fd_c8da,
        0xf83f_b2a3_f6dc_b9a5,
    ],
    [
        0xd87c_f897_92c9_4112,
        0xa560_292e_5d1c_11b3,
        0x5a10_76da_591a_673e,
        0x572d_c903_8a21_f5ef,
        0x47d7_1818_1afe_d5a1,
    ],
];

/// FNV-1a of the bits of numbers.
fn hash(values: impl IntoIterator<Item = f32>) -> u64 {
    let bytes = values.into_iter().flat_map(|value| value.to_bits().to_le_bytes());
    bytes
        .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

fn hash_rgb<'a>(values: impl IntoIterator<Item = &'a Vec3>) -> u64 {
    hash(values.into_iter().flat_map(|value| value.to_array()))
}

/// What each stage left behind after three frames.
fn hashes(baked: BakedScene) -> [u64; 5] {
    let mut runtime = Runtime::new(Arc::new(baked)).unwrap();
    runtime.set_lighting(all_lights()).unwrap();
    for _ in 0..3 {
        runtime.step(&FrameInput::default());
    }
    let probes = runtime.probe_radiance();
    let coefficients = (0..runtime.baked().probes.len())
        .flat_map(|probe| [0, 1, 2].map(|channel| probes.coefficients(probe, channel)))
        .flatten();
    [
        hash_rgb(runtime.signals().values()),
        hash(coefficients.copied()),
        hash(runtime.cluster_coefficients().values().iter().flatten().copied()),
        hash_rgb(runtime.receiver_irradiance()),
        hash_rgb(&runtime.irradiance().texels),
    ]
}

fn rooms() -> [Size; 4] {
    let many =
        Size { clusters: 40, receivers_per_cluster: 300, signals_per_cluster: 256, rays: 512, ..SMALL };
    [SMALL, SMALL_PAPER, many, Size::hybrid(5000)]
}

#[test]
fn frames_have_the_bits_that_they_had() {
    for (room, (size, expected)) in rooms().into_iter().zip(EXPECTED).enumerate() {
        assert_eq!(hashes(random_room(size)), expected, "room {room}");
    }
}

#[test]
fn one_other_bit_is_noticed() {
    let mut baked = random_room(SMALL);
    baked.column_exponents[0] ^= 1;
    let found = hashes(baked);
    // Signals and probes come before; the first frames' feedback reaches them.
    assert!(found.iter().zip(EXPECTED[0]).all(|(found, expected)| *found != expected));
}
