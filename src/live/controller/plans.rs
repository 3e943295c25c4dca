//! What is planned with: the belt as it is believed to move, and the windows that follow.

use super::Controller;
use crate::live::belt::Change;
use crate::live::protocol::BeltState;
use crate::live::robots::{Service, Wait};
use crate::live::windows::Windows;

impl Controller {
    pub(super) fn heed_belt(&mut self, time: f64, belt: &BeltState) {
        let resets = self.motion.encoder_resets();
        match self.motion.heed(time, belt) {
            Change::Late => self.note("late_belt"),
            Change::None | Change::Plan if self.awaits_belt => {
                self.awaits_belt = false;
                self.be_patient();
                self.plan_anew();
            }
            Change::None => {}
            Change::Plan => self.plan_anew(),
        }
        if self.motion.encoder_resets() > resets {
            self.note("encoder_reset");
        }
    }

    /// The belt is not where plans put it: windows, tasks and waits are made anew.
    pub(super) fn plan_anew(&mut self) {
        self.motion.plan_anew(self.clock.now);
        self.plan_station();
        let tasks: Vec<u64> = self.claims.keys().copied().collect();
        for task in tasks {
            self.follow(task);
        }
        self.rebuild_windows();
    }

    pub(super) fn plan_station(&mut self) {
        let backwards = self.motion.speed() < 0.0;
        let station = self.nominal.with_belt_speed(self.motion.planned_speed());
        self.planning = station.ok().filter(|_| !backwards);
    }

    /// Makes all windows anew and wakes whoever waits: the plans they waited by are void.
    pub(super) fn rebuild_windows(&mut self) {
        self.windows.iter_mut().for_each(Windows::clear);
        let free: Vec<u32> = self.items.iter().map(|(item, _)| item).collect();
        for item in free {
            self.open_windows(item);
        }
        for robot in &mut self.robots {
            if robot.service == Service::Ready && robot.wait != Wait::No {
                robot.free_at = self.clock.now;
                robot.wait = Wait::No;
            }
        }
    }
}
