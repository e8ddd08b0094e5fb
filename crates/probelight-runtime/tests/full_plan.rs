//! A frame at full detail has the bits that frames had before there were plans (commit 27ec018), apart from
//! direct light, which lights have driven themselves since file format 10: the values were taken anew then.
//!
//! They depend on the vector units that are compiled for, by the order of sums and by fused products, and on the C library's
//! `exp2` and `pow`; so they are compared where they were taken.
#![cfg(all(
    feature = "cpu",
    target_arch = "x86_64",
    target_os = "linux",
    target_env = "gnu",
    target_feature = "avx512f"
))]

mod support;

use probelight_asset::BakedParts;
use probelight_math::glam::Vec3;
use probelight_runtime::{FrameInput, Runtime};
use support::{SMALL, SMALL_PAPER, Size, all_lights, checked, random_room};

/// Of each room, [`hashes`].
type Expected = [[u64; 5]; 4];

const EXPECTED: Expected = [
    [
        0x3c67_3947_5389_bb7e,
        0x1a72_1b7b_7080_2b3e,
        0x9fc3_921a_8a24_c202,
        0x4802_be99_fc52_4f76,
        0x64d7_3109_7488_baf4,
    ],
    [
        0xadd5_5d96_7003_6f9f,
        0x7b93_851a_54c7_0c28,
        0x454b_725e_a25c_e599,
        0x1bc4_3ab0_67aa_a7d1,
        0x26ca_0b8b_b6b5_bc08,
    ],
    [
        0x7ba2_b804_2262_56ba,
        0xef7a_d85f_4251_709e,
        0x224a_9c27_b5e3_c268,
        0xe0c5_0f35_0ecb_c43e,
        0x9107_79e8_eab6_f800,
    ],
    [
        0x1788_f1bf_07e1_0b9a,
        0xb2fd_f8f8_880c_49c4,
        0x1ccd_c158_8bae_57e3,
        0x2e80_e0fd_1d48_0d54,
        0x3a89_08c0_9b62_a9d4,
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
fn hashes(parts: BakedParts) -> [u64; 5] {
    let mut runtime = Runtime::new(checked(parts));
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
        let found = hashes(random_room(size));
        assert_eq!(found, expected, "room {room}: {found:#x?}");
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
