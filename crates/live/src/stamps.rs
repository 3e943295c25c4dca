//! Which stamps are believed, and the message that waits for its stamp to be confirmed.
//!
//! Invariant: with the system clock nothing is ever held back, and at most one message is.

use super::clock::{Belief, Clock};
use super::protocol::{Incoming, Rejected};

/// The controller's clock, with what it does not believe yet.
#[derive(Debug, Clone)]
pub struct Stamps {
    /// The time.
    pub clock: Clock,
    /// With message time, a message whose stamp the next one has to confirm.
    held_back: Option<Incoming>,
    /// Why such a message was refused, until somebody asks.
    dropped: Option<Rejected>,
}

impl Stamps {
    /// The stamps of a clock.
    pub fn new(clock: Clock) -> Self {
        Self {
            clock,
            held_back: None,
            dropped: None,
        }
    }

    /// The time now [s].
    pub fn now(&self) -> f64 {
        self.clock.now
    }

    /// What is to be thought of a message's stamp.
    ///
    /// # Errors
    /// As for [`Clock::judge`].
    pub fn judge(&mut self, message: &Incoming) -> Result<Belief, Rejected> {
        let is_tick = matches!(message, Incoming::Tick { .. });
        self.clock.judge(message.stamp(), is_tick)
    }

    /// Keeps a message until the next one comes.
    pub fn hold_back(&mut self, message: Incoming) {
        self.held_back = Some(message);
    }

    /// The message that was held back, and whether the stamp of the next, `next` [s],
    /// confirms it. When there is no next one, the first message of all is confirmed:
    /// nothing speaks against it.
    pub fn take_held_back(&mut self, next: Option<f64>) -> Option<(Incoming, bool)> {
        let held = self.held_back.take()?;
        let confirmed = match next {
            Some(next) => self.clock.confirms(held.stamp(), next),
            None => self.clock.origin().is_none(),
        };
        Some((held, confirmed))
    }

    /// A message that was held back was refused.
    pub fn drop_held_back(&mut self, rejected: Rejected) {
        self.dropped = Some(rejected);
    }

    /// Why the message that was held back was refused, if it was since this was last asked.
    pub fn take_dropped(&mut self) -> Option<Rejected> {
        self.dropped.take()
    }
}
