//! The simulated line: both engines, the checker, disturbances, what a line makes.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod allocation;
mod checker;
mod clearance;
#[path = "../common/mod.rs"]
mod common;
mod detections;
mod disturbed;
mod disturbed_transcription;
mod engines;
mod events;
mod failures;
mod fit;
mod fit_doubts;
mod flow;
mod outages;
mod queueing;
mod real_lines;
mod real_station_files;
mod rules;
mod run;
mod scenes;
mod station_files;
mod station_warnings;
mod stations;
mod throughput;

use pickline::decision::{Action, Snapshot, Strategy};
use pickline::dispatch::{RuleAssignment, RuleStrategy};

/// The rules of the first robots of a line; the others stay idle.
struct FirstRobots(RuleStrategy);

impl FirstRobots {
    fn new(rules: &RuleAssignment) -> Self {
        Self(RuleStrategy(rules.clone()))
    }
}

impl Strategy for FirstRobots {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.0.decide(snapshot)
    }

    fn name(&self) -> String {
        self.0.name()
    }

    fn needs_view(&self) -> bool {
        self.0.needs_view()
    }
}
