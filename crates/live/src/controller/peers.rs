//! The peers: which robots can be sent tasks, and what is sent again to new peers.

use super::Controller;
use crate::claims::Claim;
use crate::lifecycle::Stage;
use crate::protocol::Incoming;

/// However often a robot's peer reconnects, a result is waited for at most this many result
/// timeouts.
const MOST_RESULT_TIMEOUTS: f64 = 12.0;

impl Controller {
    /// Index of the robot that sends `message`, or to which an order applies. None if the message
    /// is not from a robot, or the robot or task is unknown.
    pub fn robot_of(&self, message: &Incoming) -> Option<usize> {
        let of_task = |task: u64| {
            let open = self.tasks.get(task).map(|claim| claim.robot);
            open.or_else(|| self.tasks.over(task).map(|over| over.robot))
        };
        let named = |name: &String| {
            let mut robots = self.station().robots().iter();
            robots.position(|robot| robot.name == *name)
        };
        match message {
            Incoming::Robot(status) => named(&status.name),
            Incoming::Ack(ack) => of_task(ack.task),
            Incoming::Result(report) => of_task(report.task),
            other => named(other.order()?.robot.as_ref()?),
        }
    }

    /// Sends all open tasks as they stand, for a peer that has just connected. Nothing changes,
    /// because it may speak for no robot.
    pub fn send_open_tasks(&mut self) {
        for claim in self.tasks.table().clone().values() {
            match claim.stage {
                Stage::Sent | Stage::Acknowledged => self.send(claim),
                Stage::Cancelling | Stage::Recalled => self.send_cancel(claim),
            }
        }
    }

    /// Sends all open tasks again, because the peer that speaks for all robots is new or was away.
    /// Unacknowledged tasks are sent with updated times, the others as they stand. So lost answers
    /// and changes are repeated. The wait for results starts again.
    pub fn send_again(&mut self) {
        self.extend_deadlines();
        self.repeat();
    }

    /// The same for a connection from which nothing was heard yet. It may not lead to a robot, so
    /// waits are not extended.
    pub fn repeat(&mut self) {
        self.repeat_where(|_| true);
    }

    /// A peer speaks for a robot from now on. It was already sent the open tasks as they stand.
    /// Unacknowledged tasks are sent with updated times, cancels are repeated, and the wait for the
    /// robot's results starts again.
    pub fn send_again_to(&mut self, robot: usize) {
        self.extend_deadlines_where(|claim| claim.robot == robot);
        let is_meant = |claim: &Claim| claim.robot == robot && claim.stage != Stage::Acknowledged;
        self.repeat_where(is_meant);
    }

    fn repeat_where(&mut self, is_meant: impl Fn(&Claim) -> bool) {
        let now = self.stamps.now();
        let meant = self.tasks.iter().filter(|claim| is_meant(claim));
        let meant: Vec<u64> = meant.map(|claim| claim.task).collect();
        for task in meant {
            let Some(mut claim) = self.tasks.take(task) else {
                continue;
            };
            match claim.stage {
                Stage::Sent => {
                    claim.deadline = claim.deadline.min(now);
                    claim.unheard = 0;
                }
                Stage::Acknowledged => self.send(&claim),
                Stage::Cancelling | Stage::Recalled => self.cancel(&mut claim),
            }
            self.tasks.put(claim);
        }
    }

    /// Restarts the wait for the results of all open tasks, because none could come before.
    pub(super) fn extend_deadlines(&mut self) {
        self.extend_deadlines_where(|_| true);
    }

    fn extend_deadlines_where(&mut self, is_meant: impl Fn(&Claim) -> bool) {
        let until = self.stamps.now() + self.config.result_timeout;
        let open = self.tasks.iter_mut();
        for claim in open.filter(|c| c.stage != Stage::Sent && is_meant(c)) {
            // A robot that keeps reconnecting and reports nothing must not keep its item.
            let latest = claim.free_at + MOST_RESULT_TIMEOUTS * self.config.result_timeout;
            claim.deadline = claim.deadline.max(until.min(latest));
        }
    }
}
