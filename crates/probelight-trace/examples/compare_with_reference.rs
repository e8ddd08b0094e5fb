//! Compares the path tracer with reference points made by another renderer:
//!
//! ```text
//! cargo run --release -p probelight-trace --example compare_with_reference -- SCENE.glb SETUP.json POINTS.csv [PATHS]
//! ```
//!
//! Prints for each part of the irradiance the mean bias and the distribution of z-scores.
#![expect(clippy::print_stdout, reason = "an example that prints its findings")]

#[path = "../tests/agreement/mod.rs"]
mod agreement;

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use agreement::{Agreement, ESTIMATED_PARTS, delta_mismatches, read_reference};
use probelight_scene::{Setup, load_gltf};
use probelight_trace::{PathTracer, Silent, Tracer};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut path = || arguments.next().map(PathBuf::from).ok_or("usage: SCENE SETUP POINTS [PATHS]");
    let (scene, setup, points) = (path()?, path()?, path()?);
    let paths = arguments.next().map_or(Ok(1024), |count| count.parse())?;

    let tracer = Arc::new(Tracer::new(Arc::new(load_gltf(&scene)?)));
    let setup = Setup::load(&setup)?;
    let reference = read_reference(&points);
    let places: Vec<_> = reference.iter().map(|point| (point.position, point.normal)).collect();
    let ours = PathTracer::new(tracer, setup.lighting).irradiance_of_points(&places, paths, 1, &Silent)?;
    for (what, part) in ESTIMATED_PARTS {
        let Some(found) = Agreement::of(part, &ours, &reference) else { continue };
        println!(
            "{} | {what} | bias {:+.2} ± {:.2} % | z mean {:+.3} | z std {:.3} | beyond 3: {:.2} % | {} values",
            setup.name,
            found.bias * 100.0,
            found.bias_error * 100.0,
            found.mean_z,
            found.std_z,
            found.outliers * 100.0,
            found.count
        );
    }
    let mismatches = delta_mismatches(&ours, &reference) * 100.0;
    println!("{} | delta | {mismatches:.2} % of points differ by more than 1 %", setup.name);
    Ok(())
}
