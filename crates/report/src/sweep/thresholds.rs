//! The thresholds of detections that a sweep names for a wanted purity.

use crate::purity::PurityReport;
use crate::table::fixed;
use pickline::experiment::{ThresholdChoice, ThresholdChoices};
use serde::Serialize;

/// The threshold of each method for a wanted purity.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ThresholdsReport {
    /// The wanted purity.
    pub purity: f64,
    /// Description of the patterns that the thresholds were chosen on.
    pub trained_on: String,
    /// The methods, in the order of the sweep.
    pub methods: Vec<ThresholdReport>,
}

/// The threshold of one method.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ThresholdReport {
    /// The method's name in files.
    pub method: String,
    /// Items with a lower `p_detection` are left on the belt; `None` if no threshold reaches the
    /// wanted purity on the training patterns, as for the next two.
    pub threshold: Option<f64>,
    /// Purity and recovery on the training patterns.
    pub trained: Option<PurityReport>,
    /// Purity and recovery on the patterns of the sweep, which are fresh.
    pub fresh: Option<PurityReport>,
    /// The threshold with the highest purity on the training patterns; `None` if nothing was
    /// binned, as for the next.
    pub purest_threshold: Option<f64>,
    /// That purity.
    pub purest_purity: Option<f64>,
}

impl ThresholdsReport {
    /// The report of `choices`.
    pub(super) fn new(choices: &ThresholdChoices) -> Self {
        Self {
            purity: choices.purity,
            trained_on: choices.trained_on.clone(),
            methods: choices.methods.iter().map(ThresholdReport::new).collect(),
        }
    }

    /// What was chosen for each method, in words; `named` gives the name of a method.
    pub(super) fn words(&self, named: impl Fn(&str) -> String) -> Vec<String> {
        let methods = self.methods.iter();
        let words = methods.map(|method| format!("{}: {}", named(&method.method), self.of(method)));
        words.collect()
    }

    fn of(&self, method: &ThresholdReport) -> String {
        let wanted = percent(self.purity);
        let Some((threshold, fresh)) = method.threshold.zip(method.fresh) else {
            let Some((purest, purity)) = method.purest_threshold.zip(method.purest_purity) else {
                return "nothing, because nothing is binned at any threshold".into();
            };
            return format!(
                "nothing, because no threshold reaches a purity of {wanted} %; the highest is {} % at \
                 {purest}",
                fixed(100.0 * purity, 1)
            );
        };
        let missed = match (fresh.content.purity, fresh.purity_interval) {
            (_, Some(ends)) if ends.high < self.purity => ", which is below what is wanted",
            (Some(purity), _) if purity < self.purity => {
                ", which is not proven to be what is wanted"
            }
            _ => "",
        };
        format!(
            "{threshold} for a purity of {wanted} %; on fresh patterns {}{missed}",
            fresh.words()
        )
    }
}

/// A share as a percentage with all its digits.
fn percent(share: f64) -> String {
    // 98 rather than 98.00000000000001.
    ((1e9 * share).round() / 1e7).to_string()
}

impl ThresholdReport {
    fn new(choice: &ThresholdChoice) -> Self {
        let chosen = choice.chosen.as_ref();
        Self {
            method: choice.method.clone(),
            threshold: chosen.map(|chosen| chosen.value),
            trained: chosen.map(|chosen| PurityReport::new(&chosen.trained)),
            fresh: chosen.map(|chosen| PurityReport::new(&chosen.fresh)),
            purest_threshold: choice.purest.map(|purest| purest.0),
            purest_purity: choice.purest.map(|purest| purest.1),
        }
    }
}
