//! Bounds as shown: rounded so that what is shown holds as well.

use crate::table::fixed;

/// An upper bound rounded up to `digits` decimals.
pub(crate) fn rounded_up(value: f64, digits: usize) -> String {
    let power = 10f64.powi(digits as i32);
    // A value that is only a rounding error above a printable number is that number.
    fixed(((value * power) * (1.0 - 1e-11)).ceil() / power, digits)
}

/// A lower bound rounded down to `digits` decimals.
pub(super) fn rounded_down(value: f64, digits: usize) -> String {
    let power = 10f64.powi(digits as i32);
    fixed(((value * power) * (1.0 + 1e-11)).floor() / power, digits)
}
