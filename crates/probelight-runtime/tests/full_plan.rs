//! A frame at full detail has the bits that frames had before there were plans (commit 27ec018).
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
        0x6fe2_471b_bfc0_b544,
        0xff01_b9ef_c04c_72cb,
        0x4b8b_f036_9476_a286,
        0x878b_7504_e4f6_555a,
        0xd8db_5e1f_d62b_e120,
    ],
    [
        0x1e17_3f86_d468_bae7,
        0x4175_f429_6f13_3c75,
        0x0863_1d51_40d7_58fa,
        0xc75d_d721_693c_cfd5,
        0xae44_f878_ac8d_97b3,
    ],
    [
        0xd053_6a13_4861_e762,
        0x68c4_c8bd_c385_5b01,
        0x0d97_dbb9_d259_1fd4,
        0xc029_c492_df69_12d1,
        0x0719_68f7_a5d0_e55e,
    ],
    [
        0x48af_5b3c_ad26_f75f,
        0x2ebd_17b3_cc94_2e41,
        0xd1dc_6265_a93e_d772,
        0x78a3_aabd_6f94_b0bc,
        0x3627_b746_d9e5_739a,
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
