use proptest::prelude::*;

use super::*;

/// A grey point: all three compared parts add up to `irradiance`.
fn grey(irradiance: f32) -> ReferencePoint {
    ReferencePoint {
        position: Vec3::ZERO,
        normal: Vec3::Y,
        kind: PointKind::Surface,
        sampling: Sampling::ByArea,
        triangle_area: None,
        irradiance_delta: Vec3::splat(1000.0),
        irradiance_area: Vec3::splat(0.25 * irradiance),
        irradiance_sky: Vec3::splat(0.25 * irradiance),
        irradiance_indirect: Vec3::splat(0.5 * irradiance),
        se_area: Vec3::ZERO,
        se_sky: Vec3::ZERO,
        se_indirect: Vec3::ZERO,
    }
}

fn table(irradiances: &[f32]) -> ReferencePoints {
    ReferencePoints { points: irradiances.iter().copied().map(grey).collect() }
}

fn greys(irradiances: &[f32]) -> Vec<Option<Vec3>> {
    irradiances.iter().map(|e| Some(Vec3::splat(*e))).collect()
}

fn measure(reference: &[f32], predictions: &[f32]) -> PointErrors {
    PointErrors::measure(&table(reference), &greys(predictions), &PointSelection::default()).unwrap()
}

#[track_caller]
fn assert_near(value: Option<f64>, expected: f64) {
    let value = value.expect("a figure");
    assert!((value - expected).abs() < 1e-6, "{value} instead of {expected}");
}

#[test]
fn a_perfect_answer_has_no_error() {
    let errors = measure(&[1.0, 2.0, 0.0], &[1.0, 2.0, 0.0]);
    for figure in [
        errors.relative_rmse,
        errors.relative_rmse_with_noise,
        errors.median_relative_error,
        errors.p95_relative_error,
        errors.max_relative_error,
        errors.mean_bias,
    ] {
        assert_near(figure, 0.0);
    }
    assert_eq!((errors.answered, errors.unanswered, errors.compared), (3, 0, COMPARED));
}

#[test]
fn figures_agree_with_their_closed_forms() {
    // Differences 1, −1, 0, 2 and a mean reference of 4.
    let errors = measure(&[1.0, 3.0, 4.0, 8.0], &[2.0, 2.0, 4.0, 10.0]);
    assert_near(errors.relative_rmse, (6.0f64 / 90.0).sqrt());
    assert_near(errors.relative_rmse_with_noise, (6.0f64 / 90.0).sqrt());
    assert_near(errors.mean_bias, 0.5 / 4.0);
    let relative = [0.0, 2.0 / 8.08, 1.0 / 3.08, 1.0 / 1.08];
    assert_near(errors.median_relative_error, 0.5 * (relative[1] + relative[2]));
    assert_near(errors.p95_relative_error, relative[2] + 0.85 * (relative[3] - relative[2]));
    assert_near(errors.max_relative_error, relative[3]);
    assert_near(Some(errors.max_prediction), 10.0);
    assert_near(Some(errors.max_reference), 8.0);
}

#[test]
fn colours_are_compared_by_luminance() {
    let green = [Some(Vec3::new(1.0, 2.0, 1.0))];
    let errors = PointErrors::measure(&table(&[1.0]), &green, &PointSelection::default()).unwrap();
    assert_near(errors.relative_rmse, 0.7152);
    assert_near(errors.mean_bias, 0.7152);
}

#[test]
fn the_references_noise_is_subtracted() {
    let mut reference = table(&[10.0, 10.0]);
    reference.points[0].se_indirect = Vec3::new(3.0, 0.0, 0.0);
    reference.points[0].se_area = Vec3::new(0.0, 2.0, 0.0);
    reference.points[1].se_sky = Vec3::new(0.0, 0.0, 5.0);
    let variance = ((0.2126f64 * 3.0).powi(2) + (0.7152f64 * 2.0).powi(2) + (0.0722f64 * 5.0).powi(2)) / 2.0;
    let measure =
        |e: &[f32]| PointErrors::measure(&reference, &greys(e), &PointSelection::default()).unwrap();
    let errors = measure(&[12.0, 8.0]);
    assert_near(errors.relative_rmse, (4.0 - variance).sqrt() / 10.0);
    assert_near(errors.relative_rmse_with_noise, 0.2);
    assert_near(errors.reference_noise, variance.sqrt() / 10.0);
    // An error below the noise is 0, not the root of a negative number.
    assert_near(measure(&[10.1, 10.0]).relative_rmse, 0.0);
}

#[test]
fn rows_without_answer_are_counted_and_left_out() {
    let mut reference = table(&[1.0, 2.0, 3.0]);
    reference.points[2].kind = PointKind::FreeSpace;
    let predictions = [None, Some(Vec3::splat(4.0)), Some(Vec3::splat(100.0))];
    let errors = PointErrors::measure(&reference, &predictions, &PointSelection::default()).unwrap();
    assert_eq!((errors.answered, errors.unanswered), (1, 1));
    assert_near(errors.mean_bias, 1.0);
    let free = PointSelection { kind: PointKind::FreeSpace, ..PointSelection::default() };
    assert_eq!(PointErrors::measure(&reference, &predictions, &free).unwrap().answered, 1);
}

#[test]
fn a_box_restricts_the_comparison() {
    let mut reference = table(&[1.0, 1.0]);
    reference.points[1].position = Vec3::splat(5.0);
    let predictions = [Some(Vec3::splat(9.0)), Some(Vec3::new(0.0, 0.0, 0.5))];
    let within = Some(Bounds { min: Vec3::splat(4.0), max: Vec3::splat(6.0) });
    let selection = PointSelection { within, ..PointSelection::default() };
    assert_eq!(PointErrors::measure(&reference, &predictions, &selection).unwrap().answered, 1);
    assert_eq!(largest_irradiance(&reference, &predictions, &selection).unwrap(), Some(0.5));
    assert_eq!(largest_irradiance(&reference, &predictions, &PointSelection::default()).unwrap(), Some(9.0));
    assert_eq!(largest_irradiance(&reference, &[None; 2], &selection).unwrap(), None);
}

#[test]
fn points_on_small_triangles_are_judged_by_themselves() {
    let mut reference = table(&[1.0, 2.0, 4.0, 8.0]);
    for (point, area) in reference.points[1..].iter_mut().zip([0.01, 0.04, 3.0]) {
        (point.sampling, point.triangle_area) = (Sampling::ByTriangle, Some(area));
    }
    let measure = |selection: PointSelection| {
        PointErrors::measure(&reference, &greys(&[1.0, 1.0, 5.0, 0.0]), &selection).unwrap()
    };
    let by_area = measure(PointSelection::default());
    assert_near(by_area.relative_rmse, 0.0);
    assert_eq!(by_area.answered, 1);
    let small = measure(PointSelection::small_triangles());
    assert_near(small.relative_rmse, (2.0f64 / 20.0).sqrt());
    let by_triangle = PointSelection { triangles_below: None, ..PointSelection::small_triangles() };
    assert_near(measure(by_triangle).relative_rmse, (66.0f64 / 84.0).sqrt());
}

#[test]
fn exactly_black_places_count_where_the_reference_is_surely_lit() {
    // The second is dark in truth too, the third is almost black; the last is black, but for all its noise.
    let mut reference = table(&[1.0, 0.01, 1.0, 1.0, 1.0]);
    let share = |reference: &ReferencePoints| {
        PointErrors::measure(reference, &greys(&[0.0, 0.0, 1e-6, 1.0, 0.0]), &PointSelection::default())
            .unwrap()
            .black_share
    };
    assert_eq!(share(&reference), 0.4);
    reference.points[4].se_indirect = Vec3::ONE;
    assert_eq!(share(&reference), 0.2);
}

#[test]
fn a_black_reference_has_no_relative_figures() {
    let errors = measure(&[0.0, 0.0], &[0.0, 1.0]);
    assert_eq!((errors.relative_rmse, errors.median_relative_error, errors.mean_bias), (None, None, None));
    assert_near(Some(errors.mean_prediction), 0.5);
    let json = serde_json::to_value(&errors).unwrap();
    assert!(json["relative_rmse"].is_null() && json["answered"] == 2);
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let selection = PointSelection::default();
    let failure = |predictions: &[Option<Vec3>]| {
        PointErrors::measure(&table(&[1.0, 2.0]), predictions, &selection).unwrap_err().to_string()
    };
    assert!(failure(&greys(&[1.0])).contains("1 predictions for 2"));
    assert!(failure(&greys(&[1.0, f32::NAN])).contains("point 1 is not finite"));
    assert!(failure(&[None, None]).contains("none of the 2 selected"));
}

proptest! {
    #[test]
    fn a_scaled_answer_is_off_by_its_scale(
        reference in prop::collection::vec(0.1f32..100.0, 1..40),
        scale in 0.0f32..3.0,
    ) {
        let scaled: Vec<f32> = reference.iter().map(|e| e * scale).collect();
        let errors = measure(&reference, &scaled);
        let expected = f64::from(scale) - 1.0;
        prop_assert!((errors.mean_bias.unwrap() - expected).abs() < 1e-5);
        prop_assert!((errors.relative_rmse.unwrap() - expected.abs()).abs() < 1e-5);
        prop_assert!(errors.median_relative_error <= errors.p95_relative_error);
        prop_assert!(errors.p95_relative_error <= errors.max_relative_error);
        prop_assert!(errors.max_relative_error.unwrap() <= expected.abs() + 1e-5);
    }
}
