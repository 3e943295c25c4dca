//! The time that a strategy takes to decide.

use crate::decision::{Action, Snapshot, Strategy};
use crate::error::Result;
use crate::optimize::Stop;
use crate::station::Station;
use std::time::{Duration, Instant};

/// A strategy whose decisions are counted and timed, and which has no answer once it is to stop.
pub(super) struct TimedStrategy<'a> {
    inner: Box<dyn Strategy>,
    stop: &'a dyn Stop,
    pub decisions: u64,
    pub spent: Duration,
}

impl<'a> TimedStrategy<'a> {
    pub(super) fn new(inner: Box<dyn Strategy>, stop: &'a dyn Stop) -> Self {
        Self {
            inner,
            stop,
            decisions: 0,
            spent: Duration::ZERO,
        }
    }
}

impl Strategy for TimedStrategy<'_> {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        if self.stop.is_set() {
            return Action::NoAnswer;
        }
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

    fn check_robots(&self, robots: usize) -> Result<()> {
        self.inner.check_robots(robots)
    }

    fn check_station(&self, station: &Station) -> Result<()> {
        self.inner.check_station(station)
    }
}
