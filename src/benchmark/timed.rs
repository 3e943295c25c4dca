//! The time that a strategy takes to decide.

use crate::decision::{Action, Snapshot, Strategy};
use crate::error::Result;
use crate::station::Station;
use std::time::{Duration, Instant};

/// A strategy whose decisions are counted and timed.
pub(super) struct TimedStrategy {
    inner: Box<dyn Strategy>,
    pub decisions: u64,
    pub spent: Duration,
}

impl TimedStrategy {
    pub(super) fn new(inner: Box<dyn Strategy>) -> Self {
        Self {
            inner,
            decisions: 0,
            spent: Duration::ZERO,
        }
    }
}

impl Strategy for TimedStrategy {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let begun = Instant::now();
        let action = self.inner.decide(snapshot);
        self.spent += begun.elapsed();
        self.decisions += 1;
        action
    }

    fn name(&self) -> String {
        self.inner.name()
    }

    fn needs_view(&self) -> bool {
        self.inner.needs_view()
    }

    fn trouble(&self) -> Option<String> {
        self.inner.trouble()
    }

    fn remedy(&self) -> String {
        self.inner.remedy()
    }

    fn check_robots(&self, robots: usize) -> Result<()> {
        self.inner.check_robots(robots)
    }

    fn check_station(&self, station: &Station) -> Result<()> {
        self.inner.check_station(station)
    }
}
