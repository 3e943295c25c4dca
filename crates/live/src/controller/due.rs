//! Carries out what is due, in order of time.

use super::Controller;
use crate::clock::ClockKind;

impl Controller {
    /// With the system clock: sets the time to `stamp` [s since 1970] and does what is due.
    pub fn advance(&mut self, stamp: f64) {
        if self.stamps.clock.kind == ClockKind::System {
            self.close_picture();
            let time = self.stamps.clock.time(stamp);
            // Decisions are never made for the past, because no robot can leave then.
            self.stamps.clock.now = self.stamps.now().max(time);
            self.settle(self.stamps.now(), true);
        }
    }

    /// Timestamp of what is due next if no message comes [s].
    pub fn next_stamp(&mut self) -> Option<f64> {
        self.next_due()
            .map(|time| self.stamps.clock.stamp_reaching(time))
    }

    pub(super) fn next_due(&mut self) -> Option<f64> {
        let decision = self.next_decision().map(|(time, _)| time);
        let deadline = self.next_deadline().map(|(time, _)| time);
        let drive = self.next_drive();
        let all = [decision, deadline, drive];
        all.into_iter().flatten().reduce(f64::min)
    }

    /// Skips the statuses up to `time` [s].
    pub(super) fn skip_statuses(&mut self, time: f64) {
        if !self.next_status.is_finite() {
            return;
        }
        // The first status time that is not past.
        let every = self.config.status_every;
        self.next_status = self.next_status.max((time / every).floor() * every);
        while self.next_status <= time {
            self.next_status += every;
        }
    }

    /// Does what is due up to `until` [s] in order of time, with or without that moment itself.
    pub(super) fn settle(&mut self, until: f64, included: bool) {
        let is_due = |time: f64| time < until || (included && time == until);
        // The messages since the last step may be a reason to stop the belt.
        self.request_drive();
        loop {
            if self.world.is_off(self.stamps.now()) {
                self.plan_again();
            }
            let deadline = self.next_deadline().filter(|(time, _)| is_due(*time));
            let decision = self.next_decision().filter(|(time, _)| is_due(*time));
            let drive = self.next_drive().filter(|time| is_due(*time));
            let first = [
                deadline.map(|(time, _)| time),
                decision.map(|(time, _)| time),
                drive,
            ];
            let first = first.into_iter().flatten().fold(f64::INFINITY, f64::min);
            if is_due(self.next_status) && self.next_status < first {
                // With the state at that time: anything due at the same time is done first.
                self.stamps.clock.now = self.stamps.now().max(self.next_status);
                self.next_status += self.config.status_every;
                self.forget_gone();
                self.report(false, 0);
                continue;
            }
            if let Some(time) = drive.filter(|time| *time <= first) {
                self.stamps.clock.now = self.stamps.now().max(time);
                self.request_drive();
                continue;
            }
            match (deadline, decision) {
                (Some((at, task)), decision) if decision.is_none_or(|(time, _)| at <= time) => {
                    self.stamps.clock.now = self.stamps.now().max(at);
                    self.overdue(task);
                    self.request_drive();
                }
                (_, Some((time, robot))) => {
                    self.stamps.clock.now = self.stamps.now().max(time);
                    self.decide(robot);
                }
                _ => break,
            }
        }
        self.stamps.clock.now = self.stamps.now().max(until);
        self.forget_gone();
        let mut remarks = self.sources.remarks(self.stamps.now());
        self.remarks.append(&mut remarks);
    }
}
