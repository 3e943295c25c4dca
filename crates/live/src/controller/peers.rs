//! Those at the other end: who can be told of tasks, and who has to be told again.

use super::Controller;
use crate::claims::Claim;
use crate::lifecycle::Stage;
use crate::protocol::Incoming;

/// However often a robot's peer comes and goes, a result is waited for at most so many
/// result timeouts.
const MOST_PATIENCE: f64 = 12.0;

impl Controller {
    /// From now on these robots get no task, and none of theirs is sent again: nobody is
    /// there that could take it to them, or whoever does cannot keep up.
    pub fn hold(&mut self, robots: &[usize]) {
        self.held.clear();
        self.held.extend_from_slice(robots);
    }

    /// Whether a robot gets no task for now.
    pub(super) fn is_held(&self, robot: usize) -> bool {
        self.held.contains(&robot)
    }

    /// The robot that says `message`, or that it is an order for, by its place in the
    /// station; none of a message that is no robot's, or of a robot or a task that is not
    /// known.
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

    /// Tells of all open tasks as they stand, to somebody who has just come. Nothing
    /// changes: whoever it is may speak for no robot.
    pub fn tell_open(&mut self) {
        for claim in self.tasks.table().clone().values() {
            match claim.stage {
                Stage::Sent | Stage::Acknowledged => self.send(claim),
                Stage::Cancelling | Stage::Recalled => self.say_cancel(claim),
            }
        }
    }

    /// Tells of all open tasks again: whoever speaks for all robots is another one, or was
    /// away. Those that are not acknowledged are sent as things are now, the others as they
    /// stand, so that the answers and changes that were lost on the way come again, and the
    /// results are waited for again.
    pub fn send_again(&mut self) {
        self.be_patient();
        self.repeat();
    }

    /// The same for a connection of which nothing was heard yet: who is there may be nobody,
    /// so nothing is waited for any longer.
    pub fn repeat(&mut self) {
        self.repeat_where(|_| true);
    }

    /// Somebody speaks for a robot from now on. It has been told of the open tasks as they
    /// stand: those that are not acknowledged are sent as things are now, cancels are
    /// repeated, and the results of the robot are waited for again.
    pub fn send_again_to(&mut self, robot: usize) {
        self.be_patient_where(|claim| claim.robot == robot);
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

    /// Waits for the results of all open tasks from now on: none could come before.
    pub(super) fn be_patient(&mut self) {
        self.be_patient_where(|_| true);
    }

    fn be_patient_where(&mut self, is_meant: impl Fn(&Claim) -> bool) {
        let until = self.stamps.now() + self.config.result_timeout;
        let open = self.tasks.iter_mut();
        for claim in open.filter(|c| c.stage != Stage::Sent && is_meant(c)) {
            // A robot that comes and goes and never says a word must not keep its item.
            let latest = claim.free_at + MOST_PATIENCE * self.config.result_timeout;
            claim.deadline = claim.deadline.max(until.min(latest));
        }
    }
}
