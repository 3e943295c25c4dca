//! How laws are fitted.

use crate::error::{Error, Result, shown_number};
use crate::setters::setters;
use strum::VariantArray as _;

/// Which law is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum FitLaw {
    /// The simplest that fits: constant speed, acceleration, or a table.
    #[default]
    Auto,
    /// Constant speed.
    Speed,
    /// Speed and acceleration.
    Trapezoid,
    /// A monotone table.
    Table,
}

impl FitLaw {
    /// All of them.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// The name in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// How laws are fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitOptions {
    /// Which law is fitted.
    pub law: FitLaw,
    /// The lift [m] if it is known, so that it is not estimated.
    pub lift: Option<f64>,
    /// Number of resamples for the intervals; 0 for none.
    pub resamples: usize,
    /// Seed of the resamples.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            law: FitLaw::Auto,
            lift: None,
            resamples: 500,
            seed: 1,
        }
    }
}

setters!(FitOptions {
    /// With this law.
    fn with_law(law: FitLaw);
    /// With a known lift [m], or with one that is estimated.
    fn with_lift(lift: impl Into<Option<f64>>);
    /// With this number of resamples for the intervals; 0 for none.
    fn with_resamples(resamples: usize);
    /// With this seed of the resamples.
    fn with_seed(seed: u64);
});

/// Most resamples; more would not change the intervals.
const MOST_RESAMPLES: usize = 100_000;
/// Fewer resamples do not tell what 2.5 % are.
const LEAST_RESAMPLES: usize = 100;
/// Higher lifts are more than a robot's reach [m].
const HIGHEST_LIFT: f64 = 10.0;

impl FitOptions {
    /// Checks the values.
    ///
    /// # Errors
    /// A lift or a number of resamples out of range.
    pub fn check(&self) -> Result<()> {
        if let Some(lift) = self
            .lift
            .filter(|lift| !(0.0..=HIGHEST_LIFT).contains(lift))
        {
            return Err(Error::usage(
                "'lift'",
                format!("{} m is not a valid lift", shown_number(lift)),
                format!("give metres, from 0 to {HIGHEST_LIFT}"),
            ));
        }
        let allowed = LEAST_RESAMPLES..=MOST_RESAMPLES;
        if self.resamples == 0 || allowed.contains(&self.resamples) {
            return Ok(());
        }
        Err(Error::usage(
            "'resamples'",
            format!("{} resamples are out of range", self.resamples),
            format!("give {LEAST_RESAMPLES} to {MOST_RESAMPLES}, or 0 for no intervals"),
        ))
    }
}
