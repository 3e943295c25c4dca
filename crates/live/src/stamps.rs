//! Which timestamps are accepted, and the message that waits for its timestamp to be confirmed.
//!
//! Invariant: at most one message is held back, and none with the system clock.

use super::clock::{Clock, StampTrust};
use super::protocol::{Incoming, Rejected};

/// The controller's clock, and the message that it does not accept yet.
#[derive(Debug, Clone)]
pub(crate) struct Stamps {
    /// Maps timestamps to the controller's time.
    pub clock: Clock,
    /// With message time, a message whose timestamp the next one must confirm.
    held_back: Option<Incoming>,
    /// The refusal of such a message, until it is taken.
    dropped: Option<Rejected>,
}

impl Stamps {
    /// Timestamps judged by this clock.
    pub(crate) fn new(clock: Clock) -> Self {
        Self {
            clock,
            held_back: None,
            dropped: None,
        }
    }

    /// The present controller time [s], 0 at the first message.
    pub(crate) fn now(&self) -> f64 {
        self.clock.now
    }

    /// Judges a message's timestamp.
    ///
    /// # Errors
    /// As for [`Clock::judge`].
    pub(crate) fn judge(&mut self, message: &Incoming) -> Result<StampTrust, Rejected> {
        let is_tick = matches!(message, Incoming::Tick { .. });
        self.clock.judge(message.stamp(), is_tick)
    }

    /// Keeps a message until the next one comes.
    pub(crate) fn hold_back(&mut self, message: Incoming) {
        self.held_back = Some(message);
    }

    /// Takes the message that was held back. Returns it and whether the next timestamp, `next` [s],
    /// confirms it. Without a next one, only the very first message is confirmed, because nothing
    /// contradicts it.
    pub(crate) fn take_held_back(&mut self, next: Option<f64>) -> Option<(Incoming, bool)> {
        let held = self.held_back.take()?;
        let confirmed = match next {
            Some(next) => self.clock.confirms(held.stamp(), next),
            None => self.clock.origin().is_none(),
        };
        Some((held, confirmed))
    }

    /// Notes that a message that was held back is refused.
    pub(crate) fn drop_held_back(&mut self, rejected: Rejected) {
        self.dropped = Some(rejected);
    }

    /// Takes the refusal of a message that was held back, if there was one since the last call.
    pub(crate) fn take_dropped(&mut self) -> Option<Rejected> {
        self.dropped.take()
    }
}
