//! Incoming messages: which of them are accepted, and which code handles them.

use super::Controller;
use crate::clock::{ClockKind, LEAP, StampTrust};
use crate::operation::Mode;
use crate::protocol::{Due, Incoming, Outgoing, Rejected};

/// What happened to a message that was not refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandledAs {
    /// It took effect.
    Accepted,
    /// It is held back until the next message confirms its timestamp or not.
    Held,
}

impl Controller {
    /// Handles a message. With message time, a message that was held back may take effect first, or
    /// be refused, which [`Controller::take_dropped`] reports.
    ///
    /// # Errors
    /// The message is refused. It is counted, and nothing else changes.
    pub fn handle(&mut self, mut message: Incoming) -> Result<HandledAs, Rejected> {
        let is_doubtful = self.doubts.look(&mut message);
        let result = self.take(message);
        match &result {
            Ok(_) if is_doubtful => self.note("doubtful_value"),
            Ok(_) => {}
            Err(rejected) => {
                self.doubts.take();
                self.count_rejected(rejected.reason);
            }
        }
        result
    }

    /// Handles a message, as [`Controller::handle`] does, that arrived at `received` [s since 1970]
    /// by the clock of [`Controller::advance`].
    ///
    /// # Errors
    /// As for [`Controller::handle`].
    pub fn hear(&mut self, message: Incoming, received: f64) -> Result<HandledAs, Rejected> {
        self.received = Some(received);
        let result = self.handle(message);
        self.received = None;
        result
    }

    /// With message time: notes that no further message comes.
    pub fn finish(&mut self) {
        if self.stamps.clock.kind == ClockKind::Messages {
            self.resolve_last();
            self.close_picture();
            self.settle(self.stamps.now(), true);
        }
    }

    /// Ends the line: from now on no task is given, and no message comes.
    pub fn stop(&mut self) {
        self.stopping = true;
        self.resolve_last();
        self.close_picture();
    }

    fn take(&mut self, mut message: Incoming) -> Result<HandledAs, Rejected> {
        if self.stamps.clock.kind == ClockKind::System {
            self.map_stamps(&mut message)?;
        }
        let stamp = message.stamp();
        let mut belief = self.stamps.judge(&message)?;
        if let Some((held, confirmed)) = self.stamps.take_held_back(Some(stamp)) {
            self.resolve(held, confirmed);
            belief = self.stamps.judge(&message)?;
        }
        if let StampTrust::Certain(time) = belief {
            return self.act_on(time, message).map(|()| HandledAs::Accepted);
        }
        let is_tick = matches!(message, Incoming::Tick { .. });
        if is_tick && self.stamps.clock.origin().is_none() {
            // Nothing is due at any time, and the sender may wait for this answer before it sends
            // anything else.
            self.output.push(Outgoing::Due(Due { stamp, next: None }));
        }
        self.stamps.hold_back(message);
        Ok(HandledAs::Held)
    }

    /// Resolves the message held back, as no further message comes.
    fn resolve_last(&mut self) {
        if let Some((held, confirmed)) = self.stamps.take_held_back(None) {
            self.resolve(held, confirmed);
        }
    }

    /// Handles a message that was held back, or refuses it.
    fn resolve(&mut self, held: Incoming, confirmed: bool) {
        let is_first = self.stamps.clock.origin().is_none();
        let result = if confirmed {
            let time = self.stamps.clock.time(held.stamp());
            if !is_first {
                self.note("leap");
            }
            // After a long pause only its end gets statuses.
            self.skip_statuses(time - LEAP);
            if is_first && matches!(held, Incoming::Tick { .. }) {
                // It has already been answered.
                Ok(())
            } else {
                self.act_on(time, held)
            }
        } else {
            Err(self.stamps.clock.unconfirmed(held.stamp()))
        };
        if let Err(rejected) = result {
            self.count_rejected(rejected.reason);
            self.stamps.drop_held_back(rejected);
        }
    }

    fn act_on(&mut self, time: f64, message: Incoming) -> Result<(), Rejected> {
        let taken = time - self.config.camera_delay;
        let belongs = match &message {
            Incoming::Detection(seen) => self.picture.takes(seen.source.as_deref(), taken),
            _ => false,
        };
        if !belongs {
            self.close_picture();
        }
        if self.stamps.clock.kind == ClockKind::Messages && time > self.stamps.clock.now {
            // Whatever was due before this message is decided without it.
            self.settle(time, false);
        }
        self.hear_source(time, &message);
        match message {
            Incoming::Detection(detection) => self.detect(taken, detection),
            Incoming::Belt(belt) => {
                self.hear_belt(time, &belt);
                Ok(())
            }
            Incoming::Robot(robot) => self.hear_robot(time, &robot),
            Incoming::Ack(ack) => self.hear_ack(time, ack.task),
            Incoming::Result(report) => self.hear_result(time, &report),
            Incoming::Pause(order) => self.order(&order, Mode::Paused),
            Incoming::Resume(order) => self.order(&order, Mode::Running),
            Incoming::Drain(order) => self.order(&order, Mode::Draining),
            Incoming::Stop(order) => self.order(&order, Mode::Stopped),
            Incoming::Tick { stamp } => {
                if self.stamps.clock.kind == ClockKind::Messages {
                    self.settle(time, true);
                    let next = self
                        .next_due()
                        .map(|time| self.stamps.clock.stamp_reaching(time));
                    self.output.push(Outgoing::Due(Due { stamp, next }));
                }
                Ok(())
            }
        }
    }
}
