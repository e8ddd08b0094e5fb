//! Order statistics.

/// The value below which the share `rank` (0 to 1) of `ascending` values lies, linear between neighbours; `None` if
/// there is no value.
pub(crate) fn percentile<T: Copy + Into<f64>>(ascending: &[T], rank: f64) -> Option<f64> {
    let place = rank * ascending.len().checked_sub(1)? as f64;
    let [below, above] = [place.floor(), place.ceil()].map(|place| ascending[place as usize].into());
    Some(below + (above - below) * place.fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_between_two_values_are_interpolated() {
        let values = [1.0, 2.0, 4.0];
        let at = |rank| percentile(&values, rank).unwrap();
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(at), [1.0, 1.5, 2.0, 3.0, 4.0]);
        assert_eq!(percentile(&[7f32], 0.99), Some(7.0));
        assert_eq!(percentile::<f32>(&[], 0.5), None);
    }
}
