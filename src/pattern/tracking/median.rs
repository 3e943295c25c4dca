//! Medians, which a few bad values hardly change.

/// Factor from the median absolute deviation to the standard deviation of normal errors.
const NORMAL: f64 = 1.4826;

/// The median of `values`: the mean of the middle two if their number is even, 0 if there are none.
/// Reorders the values; takes linear time.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    match below.iter().copied().max_by(f64::total_cmp) {
        Some(lower) if even => f64::midpoint(lower, upper),
        _ => upper,
    }
}

/// The median of the values; `None` if there are none.
pub(super) fn median_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| median(&mut values))
}

/// The median and its standard error.
pub(super) fn centre(values: &[f64]) -> Option<(f64, f64)> {
    let middle = median_of(values.iter().copied())?;
    let deviation = median_of(values.iter().map(|value| (value - middle).abs()))?;
    Some((middle, NORMAL * deviation / (values.len() as f64).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_few() {
        assert_eq!(median(&mut []), 0.0);
        assert_eq!(median(&mut [3.0]), 3.0);
        assert_eq!(median(&mut [4.0, 1.0]), 2.5);
        assert_eq!(median(&mut [9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [9.0, 1.0, 2.0, 4.0]), 3.0);
    }
}
