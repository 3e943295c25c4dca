//! Which source sent a message, and its timestamps in the node's time.

use super::Controller;
use crate::protocol::{Incoming, Rejected, Rejection, RobotState, SourceKind};
use crate::sources::{ClockStep, SourceKey};
use pickline::error::{rounded, shown, shown_number};

impl Controller {
    /// With the system clock: notes that the machine's clock was set and is `ahead` [s] of the
    /// steady clock of [`Controller::advance`]. Open tasks are sent again, because their timestamps
    /// are by the old clock.
    pub fn set_clock_ahead(&mut self, ahead: f64) {
        let Some(step) = self.sources.set_ahead(ahead) else {
            return;
        };
        self.note("clock_step");
        let (way, by) = (
            if step < 0.0 { "back" } else { "forward" },
            rounded(step.abs(), 4),
        );
        self.remarks.push(format!(
            "the machine's clock was set {way} by {by} s: decisions use a steady clock, timestamps \
             are mapped, and open tasks are sent again with their new timestamps"
        ));
        self.plan_again();
    }

    /// The source of a message; none for ticks, and for unknown robots and tasks.
    fn source_of(&self, message: &Incoming) -> Option<SourceKey> {
        let robot = |index: usize| self.robot_keys.get(index).cloned();
        let of_task = |task: u64| robot(self.tasks.get(task)?.robot);
        let named = |kind: SourceKind, name: &Option<String>| {
            let name = name.as_deref().unwrap_or(kind.name());
            Some((kind, name.to_owned()))
        };
        match message {
            Incoming::Detection(detection) => named(SourceKind::Camera, &detection.source),
            Incoming::Belt(belt) => named(SourceKind::Belt, &belt.source),
            Incoming::Robot(status) => {
                let mut keys = self.robot_keys.iter();
                keys.find(|(_, name)| *name == status.name).cloned()
            }
            Incoming::Ack(ack) => of_task(ack.task),
            Incoming::Result(report) => of_task(report.task),
            Incoming::Pause(_)
            | Incoming::Resume(_)
            | Incoming::Drain(_)
            | Incoming::Stop(_)
            | Incoming::Tick { .. } => None,
        }
    }

    /// Maps the timestamps of a message to the node's time.
    ///
    /// # Errors
    /// A timestamp in the future, or too far in the past.
    pub(super) fn map_stamps(&mut self, message: &mut Incoming) -> Result<(), Rejected> {
        let (Some(key), Some(received)) = (self.source_of(message), self.received) else {
            message.shift(-self.sources.ahead());
            return Ok(());
        };
        let Some(mapped) = self.sources.map(&key, message.stamp(), received) else {
            let stamp = shown_number(message.stamp());
            let now = shown_number(received + self.sources.ahead());
            return Err(Rejected::new(
                Rejection::Stamp,
                format!(
                    "stamp = {stamp}, but the time is {now}; expected at most 60 s in the past and \
                     0.25 s ahead, or three messages in a row that agree"
                ),
            ));
        };
        message.shift(mapped.shift);
        if let Some(ClockStep { by, is_first }) = mapped.stepped {
            self.note("source_step");
            let (kind, name) = (key.0.name(), shown(&key.1));
            let (is_behind, by) = (by < 0.0, rounded(by.abs(), 4));
            let what = match (is_first, is_behind) {
                (true, true) => format!("is {by} s behind the node's"),
                (true, false) => format!("is {by} s ahead of the node's"),
                (false, true) => format!("was set back by {by} s relative to the node's"),
                (false, false) => format!("was set forward by {by} s relative to the node's"),
            };
            self.remarks.push(format!(
                "{kind} `{name}`: its clock {what}; its timestamps are mapped"
            ));
            if key.0 == SourceKind::Robot {
                self.plan_again();
            }
        }
        Ok(())
    }

    /// Notes that the source of an accepted message was heard at `time` [s].
    pub(super) fn hear_source(&mut self, time: f64, message: &Incoming) {
        let Some(key) = self.source_of(message) else {
            return;
        };
        let says = match message {
            Incoming::Belt(belt) => Some(belt.speed),
            Incoming::Robot(status) => Some(match status.state {
                RobotState::Idle => 0.0,
                RobotState::Busy => 1.0,
                RobotState::Fault => 2.0,
            }),
            Incoming::Detection(_) => Some(0.0),
            Incoming::Ack(_)
            | Incoming::Result(_)
            | Incoming::Pause(_)
            | Incoming::Resume(_)
            | Incoming::Drain(_)
            | Incoming::Stop(_)
            | Incoming::Tick { .. } => None,
        };
        let received = self.received.map(|stamp| self.stamps.clock.time(stamp));
        self.sources.hear(&key, received.unwrap_or(time), says);
    }
}
