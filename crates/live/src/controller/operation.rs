//! Handles the operator's orders.

use super::Controller;
use crate::claims::Reason;
use crate::lifecycle::TaskEvent;
use crate::operation::Mode;
use crate::protocol::{Order, Rejected};

impl Controller {
    /// The operator orders `mode`, for the line or for one robot.
    pub(super) fn order(&mut self, order: &Order, mode: Mode) -> Result<(), Rejected> {
        let robot = order.robot.as_ref();
        let robot = robot.map(|name| self.robot_named(name)).transpose()?;
        let was_draining = self.operation.line() == Mode::Draining;
        self.operation.order(robot, mode);
        let now = self.stamps.now();
        if was_draining && self.operation.line() != Mode::Draining {
            self.world.admit_all();
        }
        if mode == Mode::Stopped {
            let open = self.tasks.holding();
            let open = open.filter(|claim| robot.is_none_or(|robot| claim.robot == robot));
            // From the meeting on the robot has the item, or will soon report that it does not.
            let open = open.filter(|c| c.acknowledged.is_none() || now < c.meet_at);
            let open: Vec<u64> = open.map(|claim| claim.task).collect();
            for task in open {
                self.step(task, TaskEvent::Impossible, Some(Reason::Stopped));
            }
        }
        // Others may have waited because this robot was to take their items, and items that it let
        // pass may be taken again.
        self.world.rebuild_windows(now, &mut self.fleet);
        Ok(())
    }

    /// The `mode` of a status.
    pub(super) fn mode(&self) -> &'static str {
        let line = self.operation.line();
        let is_left = line == Mode::Draining && {
            let (now, length) = (self.stamps.now(), self.station().belt().length);
            let travel = self.world.motion().travel(now);
            let waits = |tracked: &crate::items::Tracked| {
                tracked.is_admitted() && tracked.place + travel <= length
            };
            self.tasks.holding().next().is_some()
                || self.world.items().iter().any(|(_, tracked)| waits(tracked))
        };
        line.name(is_left)
    }
}
