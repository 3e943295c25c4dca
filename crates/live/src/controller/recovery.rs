//! The state that survives a restart: its changes, and restoring it.

use super::picture::Picture;
use super::reported::Reported;
use super::{Config, Controller};
use crate::clock::Clock;
use crate::items::Items;
use crate::stamps::Stamps;
use crate::state::{Counters, LineState, StateChange};
use crate::tasks::Tasks;
use pickline::decision::Strategy;
use pickline::error::{Error, Result};
use pickline::station::Station;

impl Controller {
    /// Restores the line from `state`; what happened since is unknown. If the belt was ever heard,
    /// no task is given and no item forgotten until it is heard again, because it may have stopped
    /// meanwhile. `stamp` is the present time with the system clock [s since 1970].
    ///
    /// # Errors
    /// As for [`Controller::new`]; a state that is not of this station, or from the future.
    pub fn restore(
        station: Station,
        strategy: Box<dyn Strategy>,
        config: Config,
        state: LineState,
        stamp: Option<f64>,
    ) -> Result<Self> {
        /// The machine's clock may have been set back by up to this much [s].
        const AHEAD: f64 = 5.0;
        let kind = config.clock;
        let mut controller = Self::new(station, strategy, config)?;
        state.check(controller.fleet.len())?;
        let mut clock = Clock::resume(kind, state.origin, state.now);
        if let Some(stamp) = stamp {
            let time = clock.time(stamp);
            if time < clock.now - AHEAD {
                let ahead = clock.now - time;
                return Err(Error::input(
                    "its last record",
                    format!("it is {ahead:.0} s ahead of this machine's clock"),
                    "correct the clock, or wait until it is past that time",
                ));
            }
            clock.now = clock.now.max(time);
        }
        controller.skip_statuses(clock.now);
        controller.stamps = Stamps::new(clock);
        for (robot, info) in state.robots {
            *controller.fleet.get_mut(robot) = info;
        }
        controller.tasks = Tasks::restore(state.claims, state.past, state.counters.next_task);
        let items = Items::restore(state.items, state.counters.numbers);
        controller.world = controller.world.restored(state.motion, items);
        controller.tally = state.counters.tally;
        controller.picture = Picture::restore(state.waiting);
        controller.operation = state.operation;
        controller.drive = state.drive;
        let now = controller.stamps.now();
        controller.world.rebuild_windows(now, &mut controller.fleet);
        controller.send_again();
        controller.output.clear();
        Ok(controller)
    }

    /// Whether the line waits until the belt is heard.
    pub fn awaits_belt(&self) -> bool {
        self.world.awaits_belt()
    }

    /// Number of known items, and of open tasks.
    pub fn load(&self) -> (usize, usize) {
        (self.world.items().len(), self.tasks.holding().count())
    }

    /// The whole state, as a change from nothing. From now on [`Controller::change`] reports what
    /// changes.
    pub fn whole(&mut self) -> StateChange {
        self.world.watch();
        let items = self.world.items().iter();
        let change = StateChange {
            origin: self.origin(),
            now: self.stamps.now(),
            items: items.map(|(n, item)| (n, Some(item.clone()))).collect(),
            claims: self
                .tasks
                .iter()
                .map(|claim| (claim.task, Some(claim.clone())))
                .collect(),
            robots: self
                .fleet
                .iter()
                .map(|(n, info)| (n, info.clone()))
                .collect(),
            operation: Some(self.operation.clone()),
            drive: Some(self.drive),
            counters: Some(self.counters()),
            past: self.tasks.watch(),
            motion: self.world.motion().change(None),
            waiting: Some(self.picture.waiting.clone()),
        };
        self.reported = Some(self.reported_now());
        change
    }

    /// What has changed since the last call. None if nothing changed, or only the time did and no
    /// message was `said`.
    pub fn change(&mut self, said: bool) -> Option<StateChange> {
        let before = self.reported.take()?;
        let mut change = StateChange {
            origin: self.origin(),
            now: self.stamps.now(),
            items: self.world.take_changed(),
            past: self.tasks.take_changed(),
            ..StateChange::default()
        };
        for (task, claim) in self.tasks.table() {
            if before.claims.get(task) != Some(claim) {
                change.claims.push((*task, Some(claim.clone())));
            }
        }
        let over = before.claims.keys();
        let over = over.filter(|task| self.tasks.get(**task).is_none());
        change.claims.extend(over.map(|task| (*task, None)));
        for (robot, info) in self.fleet.iter() {
            if before.fleet.get(robot) != info {
                change.robots.push((robot, info.clone()));
            }
        }
        change.operation = (self.operation != before.operation).then(|| self.operation.clone());
        change.drive = (self.drive != before.drive).then_some(self.drive);
        let counters = self.counters();
        change.counters = (counters != before.counters).then_some(counters);
        change.motion = self.world.motion().change(Some(before.plan));
        // The list only grows until it is emptied.
        let waiting = &self.picture.waiting;
        change.waiting = (waiting.len() != before.waiting).then(|| waiting.clone());
        let later = said && before.now != change.now;
        if change.is_empty() && !later {
            self.reported = Some(before);
            return None;
        }
        self.reported = Some(self.reported_now());
        Some(change)
    }

    /// Timestamp of time 0 by the machine's clock [s], which a resumed run reads.
    fn origin(&self) -> Option<f64> {
        let origin = self.stamps.clock.origin();
        origin.map(|origin| origin + self.sources.ahead())
    }

    fn reported_now(&self) -> Reported {
        Reported {
            claims: self.tasks.table().clone(),
            fleet: self.fleet.clone(),
            operation: self.operation.clone(),
            drive: self.drive,
            counters: self.counters(),
            plan: self.world.motion().plan(),
            waiting: self.picture.waiting.len(),
            now: self.stamps.now(),
        }
    }

    fn counters(&self) -> Counters {
        Counters {
            next_task: self.tasks.next(),
            numbers: self.world.items().numbers(),
            tally: self.tally.clone(),
        }
    }
}
