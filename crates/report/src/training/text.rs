//! A training as text for the terminal.

use super::report::TrainingReport;

impl TrainingReport {
    /// The weighted rates of the policy beside those of the rules, one line per trial.
    pub(super) fn text(&self) -> String {
        let mut text = String::from(
            "weighted rates [1/min]: [SPT; FIFO], greedy GT (game theory), the policy\n",
        );
        for trial in &self.record.trials {
            text += &format!(
                "{:<40}{:>7.1}{:>7.1}{:>7.1}\n",
                trial.name, trial.robust, trial.greedy, trial.policy
            );
        }
        text
    }
}
