//! When robots were down in a run.

use pickline::decision::Outcome;
use serde::Serialize;

/// A time in which a robot was down.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct DowntimeReport {
    /// Index of the robot, upstream first.
    pub robot: usize,
    /// When it began [s].
    pub from_s: f64,
    /// When the robot was ready again, at the latest the end of the run [s].
    pub to_s: f64,
}

impl DowntimeReport {
    /// All times in which robots were down, in order.
    pub(crate) fn all(outcome: &Outcome) -> Vec<Self> {
        let all = outcome.downtimes.iter();
        all.map(|down| Self {
            robot: down.robot,
            from_s: down.from,
            to_s: down.to,
        })
        .collect()
    }
}
