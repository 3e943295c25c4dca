//! Payoffs as whole multiples of a small unit, so that a game is solved exactly.

use serde::{Serialize, Serializer};
use std::fmt;
use std::iter::Sum;
use std::ops::{Add, Neg, Sub};

/// A payoff [1/min] in whole multiples of [`Payoff::RESOLUTION`].
///
/// Means over patterns have rounding errors: two that are mathematically equal may differ in
/// the last bit. Payoffs are rounded once, to a unit far above such errors and far below any
/// relevant difference. After that, they are compared, added and subtracted exactly, equality
/// is transitive, and the decimals in a file are exactly the numbers that were compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Payoff(i64);

/// Units per pick per minute.
const UNITS: i64 = 1_000_000_000;

impl Payoff {
    /// The unit [1/min]: payoffs closer to each other than half of it may be equal.
    pub const RESOLUTION: f64 = 1.0 / UNITS as f64;

    /// `value` [1/min] rounded to the nearest unit; values beyond 9e9 are clamped.
    pub fn rounded(value: f64) -> Self {
        // The conversion saturates.
        Self((value * UNITS as f64).round() as i64)
    }

    /// A whole number of picks per minute, for hand-written games.
    pub fn whole(value: i32) -> Self {
        Self(i64::from(value) * UNITS)
    }

    /// The value [1/min]: the double nearest to the decimal, so it prints as that decimal.
    pub fn value(self) -> f64 {
        self.0 as f64 / UNITS as f64
    }
}

impl Add for Payoff {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Payoff {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for Payoff {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Sum for Payoff {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::default(), Add::add)
    }
}

impl fmt::Display for Payoff {
    /// The exact decimal, without trailing zeros.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let size = self.0.unsigned_abs();
        let (whole, part) = (size / UNITS as u64, size % UNITS as u64);
        let sign = if self.0 < 0 { "-" } else { "" };
        if part == 0 {
            return write!(f, "{sign}{whole}");
        }
        let digits = format!("{part:09}");
        write!(f, "{sign}{whole}.{}", digits.trim_end_matches('0'))
    }
}

impl Serialize for Payoff {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn decimals_are_exact() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.5, "1.5"),
            (-1.5, "-1.5"),
            (-1e-9, "-0.000000001"),
            (33.153_333_333_33, "33.153333333"),
            (20.0, "20"),
        ] {
            assert_eq!(Payoff::rounded(value).to_string(), text);
        }
        assert_eq!(Payoff::rounded(1.0), Payoff::whole(1));
        assert_eq!(-Payoff::whole(3), Payoff::whole(-3));
        assert_eq!(Payoff::rounded(0.3), Payoff::rounded(0.1 + 0.2));
        assert_eq!(
            Payoff::rounded(f64::INFINITY) + Payoff::whole(1),
            Payoff(i64::MAX)
        );
    }

    proptest! {
        /// The number in the JSON equals the decimal.
        #[test]
        fn the_double_prints_as_the_decimal(units in -1_000_000_000_000_000i64..1_000_000_000_000_000) {
            let payoff = Payoff(units);
            prop_assert_eq!(payoff.to_string().parse::<f64>().unwrap(), payoff.value());
            prop_assert_eq!(Payoff::rounded(payoff.value()), payoff);
        }
    }
}
