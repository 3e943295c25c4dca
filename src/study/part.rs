//! The progress of one part of a longer study.

use crate::optimize::Progress;

/// Reports the progress of one part; the names of its stages include the part.
pub(super) struct PartProgress<'p> {
    /// Receives the progress of the whole study.
    pub whole: &'p dyn Progress,
    /// What the part of the work is called in progress reports.
    pub part: String,
}

impl Progress for PartProgress<'_> {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        self.whole
            .begin(&format!("{}: {stage}", self.part), total, unit);
    }

    fn advance(&self, steps: u64) {
        self.whole.advance(steps);
    }

    fn doing(&self, text: &str) {
        self.whole.doing(text);
    }

    fn incumbent(&self, text: &str) {
        self.whole.incumbent(text);
    }

    fn end(&self) {
        self.whole.end();
    }
}
