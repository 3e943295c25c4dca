//! The report of a training.

use crate::charts::curve_chart;
use crate::provenance::Provenance;
use pickline::rl::{Curve, Record};
use pickline::study::{TrainedPolicy, TrainingLine};
use serde::{Serialize, Serializer};

/// How a policy was trained and what it picks. Its JSON is the training record.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TrainingReport {
    /// The training record.
    pub record: Record,
    /// The learning curve.
    pub curve: Curve,
    /// Where the policy comes from.
    pub made: Provenance,
}

impl TrainingReport {
    /// The report of the policy `trained`; `first` is the first line that it was trained on.
    pub fn new(trained: &TrainedPolicy, first: &TrainingLine) -> Self {
        let record = trained.record.clone();
        // The recorded command names the other stations.
        let made = Provenance::new(
            &record.command,
            &first.name,
            &first.station,
            "the built-in cases",
            record.seed,
        );
        Self {
            record,
            curve: trained.curve.clone(),
            made,
        }
    }

    /// The chart of the learning curve as SVG.
    pub(super) fn curve_svg(&self) -> String {
        curve_chart(&self.curve, &self.made)
    }
}

impl Serialize for TrainingReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.record.serialize(serializer)
    }
}
