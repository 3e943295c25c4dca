//! The state of a live line as data: what a controller needs to resume where another one was
//! killed.
//!
//! Windows, plans and a strategy's own memory are not part of it. They follow from it or are
//! rebuilt.

use super::belt::{BeltMotion, MotionChange};
use super::claims::Claim;
use super::drive::Drive;
use super::items::{Numbers, Tracked};
use super::operation::Operation;
use super::protocol::Detection;
use super::robots::RobotInfo;
use super::tally::Tally;
use super::tasks::{PastChange, PastTasks};
use pickline::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Numbers that only grow.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Counters {
    pub next_task: u64,
    pub numbers: Numbers,
    /// How many items were seen, picked and missed, and how often unusual events happened.
    #[serde(flatten)]
    pub tally: Tally,
}

/// How a state differs from an earlier one: the present value of every part that has changed.
/// Applied in order to `LineState::default()`, the changes give the state.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StateChange {
    /// Timestamp of time 0 [s].
    pub(super) origin: Option<f64>,
    /// Controller time [s].
    pub(super) now: f64,
    /// Changed items by number; none for those that are forgotten.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) items: Vec<(u32, Option<Tracked>)>,
    /// Changed open tasks by number; none for those that are over.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) claims: Vec<(u64, Option<Claim>)>,
    /// Changes of the tasks that are over.
    #[serde(skip_serializing_if = "PastChange::is_empty")]
    pub(super) past: PastChange,
    /// Changed robots by index.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) robots: Vec<(usize, RobotInfo)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) counters: Option<Counters>,
    /// The operator's orders.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) operation: Option<Operation>,
    /// The requests to the belt's drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) drive: Option<Drive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) motion: Option<MotionChange>,
    /// Detections that wait for the belt, with their times [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) waiting: Option<Vec<(f64, Detection)>>,
}

impl StateChange {
    /// Whether nothing but the time differs.
    pub(super) fn is_empty(&self) -> bool {
        self.items.is_empty()
            && self.claims.is_empty()
            && self.past.is_empty()
            && self.robots.is_empty()
            && self.operation.is_none()
            && self.drive.is_none()
            && self.counters.is_none()
            && self.motion.is_none()
            && self.waiting.is_none()
    }
}

/// The state of a live line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineState {
    pub(super) origin: Option<f64>,
    pub(super) now: f64,
    pub(super) items: BTreeMap<u32, Tracked>,
    pub(super) claims: BTreeMap<u64, Claim>,
    pub(super) past: PastTasks,
    pub(super) robots: BTreeMap<usize, RobotInfo>,
    pub(super) counters: Counters,
    pub(super) operation: Operation,
    pub(super) drive: Drive,
    pub(super) motion: Option<BeltMotion>,
    pub(super) waiting: Vec<(f64, Detection)>,
}

impl LineState {
    /// Applies a change.
    pub fn apply(&mut self, change: StateChange) {
        self.origin = change.origin;
        self.now = change.now;
        for (item, tracked) in change.items {
            match tracked {
                Some(tracked) => self.items.insert(item, tracked),
                None => self.items.remove(&item),
            };
        }
        for (task, claim) in change.claims {
            match claim {
                Some(claim) => self.claims.insert(task, claim),
                None => self.claims.remove(&task),
            };
        }
        self.past.apply(change.past);
        self.robots.extend(change.robots);
        if let Some(operation) = change.operation {
            self.operation = operation;
        }
        if let Some(drive) = change.drive {
            self.drive = drive;
        }
        if let Some(counters) = change.counters {
            self.counters = counters;
        }
        if let Some(change) = change.motion {
            let motion = self.motion.get_or_insert_with(|| BeltMotion::new(0.0));
            motion.apply(change);
        }
        if let Some(waiting) = change.waiting {
            self.waiting = waiting;
        }
    }

    /// Checks that this is the state of a line with `robots` robots.
    pub(super) fn check(&self, robots: usize) -> Result<()> {
        let strange = self.claims.values().map(|claim| claim.robot);
        let strange = strange.chain(self.past.robots());
        let strange = strange.chain(self.operation.robots());
        let strange = strange.chain(self.robots.keys().copied());
        match strange.max().filter(|robot| *robot >= robots) {
            None => Ok(()),
            Some(robot) => Err(Error::input(
                "its state",
                format!("it refers to robot {} of {robots}", robot + 1),
                "use the journal of this station, or start a new one",
            )),
        }
    }
}
