//! What outlives the process: told as it changes, and taken up again.

use super::{Config, Controller};
use crate::decision::Strategy;
use crate::error::{Error, Result};
use crate::live::belt::Plan;
use crate::live::claims::{Claim, Stage};
use crate::live::clock::Clock;
use crate::live::items::Items;
use crate::live::robots::RobotInfo;
use crate::live::state::{Change, Counters, State};
use crate::station::Station;
use std::collections::BTreeMap;

/// What was last told of the state, to tell what has changed since. The items take note
/// of their changes themselves: there are too many to compare.
#[derive(Debug)]
pub(super) struct Told {
    claims: BTreeMap<u64, Claim>,
    robots: Vec<RobotInfo>,
    counters: Counters,
    plan: Plan,
    now: f64,
}

impl Controller {
    /// The line as it was left, with what happened since unknown. Until the belt is heard
    /// again, if it ever was, no task is given and no item forgotten: it may have stopped
    /// in between. `stamp` is the time now with the system clock [s since 1970].
    ///
    /// # Errors
    /// A state that is none of this station, or of a time to come.
    pub fn restore(
        station: Station,
        strategy: Box<dyn Strategy>,
        config: Config,
        state: State,
        stamp: Option<f64>,
    ) -> Result<Self> {
        /// The machine's clock may have been corrected by this much [s].
        const AHEAD: f64 = 5.0;
        let mut controller = Self::new(station, strategy, config);
        state.check(controller.robots.len())?;
        let mut clock = Clock::resume(config.clock, state.origin, state.now);
        if let Some(stamp) = stamp {
            let time = clock.time(stamp);
            if time < clock.now - AHEAD {
                let ahead = clock.now - time;
                return Err(Error::input(
                    "its last record",
                    format!("it is {ahead:.0} s ahead of this machine's clock"),
                    "set the clock right, or wait until it is past that time",
                ));
            }
            clock.now = clock.now.max(time);
        }
        controller.skip_statuses(clock.now);
        controller.clock = clock;
        controller.motion = state.motion.unwrap_or(controller.motion);
        for (robot, info) in state.robots {
            controller.robots[robot] = info;
        }
        let tasks = state.items.iter().flat_map(|(item, tracked)| {
            let over = tracked.tasks.iter();
            let over = over.filter(|task| !state.claims.contains_key(task));
            over.map(|task| (*task, *item))
        });
        controller.closed = tasks.collect();
        controller.items = Items::restore(state.items, state.counters.numbers);
        controller.claims = state.claims;
        controller.next_task = state.counters.next_task;
        controller.seen = state.counters.seen;
        controller.picked = state.counters.picked;
        controller.missed = state.counters.missed;
        controller.rejected = state.counters.rejected;
        controller.noted = state.counters.noted;
        controller.awaits_belt = controller.motion.is_heard();
        controller.plan_station();
        controller.rebuild_windows();
        controller.send_again();
        controller.output.clear();
        Ok(controller)
    }

    /// Whether nothing is done until the belt has been heard.
    pub fn awaits_belt(&self) -> bool {
        self.awaits_belt
    }

    /// How many items are known, and how many tasks are open.
    pub fn load(&self) -> (usize, usize) {
        (self.items.len(), self.claims.len())
    }

    /// The whole state, as the change from nothing. From now on [`Controller::change`]
    /// tells what changes.
    pub fn whole(&mut self) -> Change {
        self.items.watch();
        let items = self.items.iter();
        let change = Change {
            origin: self.clock.origin(),
            now: self.clock.now,
            items: items.map(|(n, item)| (n, Some(item.clone()))).collect(),
            claims: self
                .claims
                .iter()
                .map(|(n, claim)| (*n, Some(claim.clone())))
                .collect(),
            robots: self.robots.iter().cloned().enumerate().collect(),
            counters: Some(self.counters()),
            motion: self.motion.change(None),
        };
        self.told = Some(self.tell());
        change
    }

    /// What has changed since it was last told; none when that is nothing, or the time
    /// alone and nothing was `said`.
    pub fn change(&mut self, said: bool) -> Option<Change> {
        let before = self.told.take()?;
        let mut change = Change {
            origin: self.clock.origin(),
            now: self.clock.now,
            items: self.items.take_changed(),
            ..Change::default()
        };
        for (task, claim) in &self.claims {
            if before.claims.get(task) != Some(claim) {
                change.claims.push((*task, Some(claim.clone())));
            }
        }
        let over = before.claims.keys();
        let over = over.filter(|task| !self.claims.contains_key(task));
        change.claims.extend(over.map(|task| (*task, None)));
        for (robot, info) in self.robots.iter().enumerate() {
            if before.robots[robot] != *info {
                change.robots.push((robot, info.clone()));
            }
        }
        let counters = self.counters();
        change.counters = (counters != before.counters).then_some(counters);
        change.motion = self.motion.change(Some(before.plan));
        let later = said && before.now != change.now;
        if change.is_empty() && !later {
            self.told = Some(before);
            return None;
        }
        self.told = Some(self.tell());
        Some(change)
    }

    fn tell(&self) -> Told {
        Told {
            claims: self.claims.clone(),
            robots: self.robots.clone(),
            counters: self.counters(),
            plan: self.motion.plan(),
            now: self.clock.now,
        }
    }

    fn counters(&self) -> Counters {
        Counters {
            next_task: self.next_task,
            numbers: self.items.numbers(),
            seen: self.seen,
            picked: self.picked,
            missed: self.missed,
            rejected: self.rejected.clone(),
            noted: self.noted.clone(),
        }
    }

    /// Tells of all open tasks again: the peer is another one, or was away. Those that are
    /// not acknowledged are sent as things are now, the others as they stand, so that the
    /// answers and changes that were lost on the way come again.
    pub fn send_again(&mut self) {
        self.be_patient();
        for claim in self.claims.clone().values() {
            match claim.stage {
                Stage::Sent => {
                    if let Some(claim) = self.claims.get_mut(&claim.task) {
                        claim.deadline = claim.deadline.min(self.clock.now);
                    }
                }
                Stage::Acknowledged => self.send(claim),
                Stage::Cancelling => {
                    let reason = "it was cancelled, and no answer has come";
                    self.cancel(claim.task, claim.robot, reason);
                }
            }
        }
    }

    /// Waits for the results of all open tasks from now on: none could come before.
    pub(super) fn be_patient(&mut self) {
        let until = self.clock.now + self.config.result_timeout;
        let answered = self.claims.values_mut().filter(|c| c.stage != Stage::Sent);
        for claim in answered {
            claim.deadline = claim.deadline.max(until);
        }
    }
}
