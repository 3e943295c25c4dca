//! What is maximised: a figure of each run, and how it is aggregated over patterns.

use super::speed_limit::SpeedScan;
use crate::decision::Figures;
use crate::error::{Error, Result, known_names, shown, shown_number};
use crate::stats;
use std::fmt;
use std::str::FromStr;
use strum::VariantNames as _;

/// The figure of one pattern that is maximised.
#[derive(
    Debug, Clone, Copy, PartialEq, strum::EnumString, strum::IntoStaticStr, strum::VariantNames,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Objective {
    /// Picks per minute.
    PickingRate,
    /// Share of the items picked.
    PickedShare,
    /// Reward-weighted picks per minute.
    WeightedRate,
    /// Highest belt speed up to which everything is picked [m/s]: the maximal part
    /// flow of Huang et al. 2015 (Robotics and Autonomous Systems 64).
    MaxSpeed(SpeedScan),
}

impl Objective {
    /// The objective with this name; `scan` applies only to `max-speed`.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named(name: &str, scan: SpeedScan) -> Result<Self> {
        // The derived conversion fills in the default scan.
        match Self::try_from(name) {
            Ok(Self::MaxSpeed(_)) => Ok(Self::MaxSpeed(scan)),
            Ok(other) => Ok(other),
            Err(_) => Err(Error::usage(
                "'objective'",
                format!("unknown objective `{}`", shown(name)),
                known_names(name, Self::VARIANTS),
            )),
        }
    }

    /// The name by which it is chosen and which files have.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// The unit in figures of the objective.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::PickingRate | Self::WeightedRate => "1/min",
            Self::PickedShare => "1",
            Self::MaxSpeed(_) => "m/s",
        }
    }

    /// The figure of one run at the station's own belt speed; `None` for `max-speed`, which
    /// needs many runs.
    pub(super) fn of_run(&self, figures: &Figures) -> Option<f64> {
        match self {
            Self::PickingRate => Some(figures.picking_rate()),
            Self::PickedShare => Some(figures.picked_share()),
            Self::WeightedRate => Some(figures.weighted_rate()),
            Self::MaxSpeed(_) => None,
        }
    }
}

/// How the figures of all patterns are combined into one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Risk {
    /// The mean over all patterns.
    Mean,
    /// The figure of the worst pattern.
    Worst,
    /// The mean over the worst share of the patterns, above 0 and at most 1 (conditional value
    /// at risk).
    Cvar(f64),
}

/// What a share of the worst patterns may be.
const SHARE_CURE: &str = "give cvar:A with A above 0 and at most 1, such as cvar:0.1 for the mean of \
                          the worst tenth";

impl Risk {
    /// Itself, checked.
    ///
    /// # Errors
    /// A share that is not above 0 and at most 1.
    pub fn checked(self) -> Result<Self> {
        match self {
            Self::Cvar(share) if !(share > 0.0 && share <= 1.0) => Err(Error::usage(
                "'risk'",
                format!("{} is not above 0 and at most 1", shown_number(share)),
                SHARE_CURE,
            )),
            _ => Ok(self),
        }
    }

    /// Combines the figures of all patterns into one.
    pub fn aggregate(&self, values: &[f64]) -> f64 {
        self.aggregate_in(&mut values.to_vec())
    }

    /// Like [`Risk::aggregate`], but may reorder `values`.
    pub(super) fn aggregate_in(&self, values: &mut [f64]) -> f64 {
        match *self {
            Self::Mean => stats::mean(values),
            Self::Worst => values.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Cvar(share) => stats::worst_mean(values, share),
        }
    }
}

impl fmt::Display for Risk {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Mean => f.write_str("mean"),
            Self::Worst => f.write_str("worst"),
            Self::Cvar(share) => write!(f, "cvar:{}", shown_number(*share)),
        }
    }
}

impl FromStr for Risk {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let name = text.split(':').next().unwrap_or_default();
        let wrong = |problem: String, cure: &str| Err(Error::usage("'risk'", problem, cure));
        match text.split_once(':') {
            None if text == "mean" => Ok(Self::Mean),
            None if text == "worst" => Ok(Self::Worst),
            Some(("cvar", share)) => match share.parse() {
                Ok(number) => match Self::Cvar(number).checked() {
                    // As it was written.
                    Err(_) => wrong(
                        format!("`{}` is not above 0 and at most 1", shown(share)),
                        SHARE_CURE,
                    ),
                    risk => risk,
                },
                Err(_) => wrong(format!("`{}` is not a number", shown(share)), SHARE_CURE),
            },
            None if text == "cvar" => wrong("`cvar` needs a share".into(), SHARE_CURE),
            Some(("mean" | "worst", _)) => wrong(
                format!("`{name}` takes no number, but `{}` has one", shown(text)),
                &format!("write plain {name}, or cvar:A with A above 0 and at most 1"),
            ),
            _ => wrong(
                format!("unknown risk `{}`", shown(text)),
                &known_names(name, &["mean", "worst", "cvar:A"]),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn risks_are_read_and_aggregate() {
        let values = [3.0, 1.0, 2.0, 4.0];
        for (text, expected) in [("mean", 2.5), ("worst", 1.0), ("cvar:0.5", 1.5)] {
            let risk: Risk = text.parse().unwrap();
            assert_eq!(risk.to_string(), text);
            assert_eq!(risk.aggregate(&values), expected);
        }
        // Valid names with invalid numbers are not treated as mistyped names.
        for (bad, words) in [
            ("cvar", "needs a share"),
            ("cvar:0", "`0` is not above 0"),
            ("cvar:2", "`2` is not above 0"),
            ("cvar:a", "`a` is not a number"),
            ("mean:1", "write plain mean"),
        ] {
            let message = bad.parse::<Risk>().unwrap_err().to_string();
            assert!(
                message.contains(words) && !message.contains("did you mean"),
                "{message}"
            );
        }
        for (bad, problem) in [
            ("", "unknown risk ``"),
            ("cvar:nan", "`nan` is not above 0"),
            ("best", "unknown risk `best`"),
        ] {
            let message = bad.parse::<Risk>().unwrap_err().to_string();
            assert!(message.contains(problem), "{bad}: {message}");
        }
    }

    #[test]
    fn names_are_read() {
        for (name, unit) in [
            ("picking-rate", "1/min"),
            ("picked-share", "1"),
            ("weighted-rate", "1/min"),
            ("max-speed", "m/s"),
        ] {
            let objective = Objective::named(name, SpeedScan::default()).unwrap();
            assert_eq!((objective.name(), objective.unit()), (name, unit));
        }
        let error = Objective::named("pickingrate", SpeedScan::default()).unwrap_err();
        assert!(error.to_string().contains("`picking-rate`"));
    }
}
