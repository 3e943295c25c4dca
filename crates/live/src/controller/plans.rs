//! The plan of the belt's motion, and what depends on it.

use super::Controller;
use super::tasks::RecheckCause;
use crate::belt::BeltChange;
use crate::protocol::BeltState;

impl Controller {
    pub(super) fn hear_belt(&mut self, time: f64, belt: &BeltState) {
        let resets = self.world.motion().encoder_resets();
        match self.world.hear_belt(time, belt) {
            (BeltChange::Late, _) => self.note("late_belt"),
            (_, true) => {
                self.extend_deadlines();
                self.plan_again();
                self.place_waiting();
            }
            (BeltChange::None, false) => {}
            (BeltChange::Plan, false) => self.plan_again(),
        }
        if self.world.motion().encoder_resets() > resets {
            self.note("encoder_reset");
        }
        self.remarks.append(&mut self.world.take_remarks());
    }

    /// Renews the plan, windows, tasks and waits, because the belt is not at its planned position.
    pub(super) fn plan_again(&mut self) {
        let now = self.stamps.now();
        self.world.plan_again(now);
        for task in self.tasks.numbers() {
            self.follow(task, RecheckCause::Belt);
        }
        self.world.rebuild_windows(now, &mut self.fleet);
    }
}
