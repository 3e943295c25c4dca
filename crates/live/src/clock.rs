//! The clock of the controller, and which timestamps are accepted.

use super::protocol::{Rejected, Rejection};
use pickline::error::shown_number;

/// Older timestamps than this [s] are refused, because their content is no longer of use.
pub(crate) const OLDEST: f64 = 60.0;
/// With the system clock, timestamps further ahead than this [s] are refused.
const AHEAD: f64 = 5.0;
/// With message time, timestamps further ahead than this [s] are doubtful. One wild timestamp must
/// not make everything after it too old; a step of this size cannot.
const DOUBTFUL: f64 = OLDEST;
/// A tick is only doubtful further ahead than this [s]: it comes from the timekeeper, which waits
/// for an answer.
pub(crate) const LEAP: f64 = 3600.0;

/// Where the time comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClockKind {
    /// The machine's clock [s since 1970]; decisions are made when they are due.
    #[default]
    System,
    /// The timestamps of the messages: the same messages give the same output bit-exactly.
    Messages,
}

impl ClockKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::Messages => "messages",
        }
    }

    /// The kind with this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        let kinds = [Self::System, Self::Messages];
        kinds.into_iter().find(|kind| kind.name() == name)
    }
}

/// How a timestamp is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StampTrust {
    /// It is near enough to the present; its time [s].
    Certain(f64),
    /// With message time: it is far ahead, or the first. The next timestamp decides.
    Doubtful,
}

/// The controller's time. It starts at 0 to keep its precision.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    /// Where the time comes from.
    pub kind: ClockKind,
    /// Timestamp of time 0 [s]; with message time that of the first message.
    origin: Option<f64>,
    /// The controller's time [s]; it never goes back.
    pub now: f64,
}

impl Clock {
    /// A clock that starts at the first timestamp or reading.
    pub(crate) fn new(kind: ClockKind) -> Self {
        Self {
            kind,
            origin: None,
            now: 0.0,
        }
    }

    /// A clock that resumes at `now` [s], with time 0 at the timestamp `origin` [s].
    pub(crate) fn resume(kind: ClockKind, origin: Option<f64>, now: f64) -> Self {
        Self { kind, origin, now }
    }

    /// Timestamp of time 0 [s], once it is known.
    pub(crate) fn origin(&self) -> Option<f64> {
        self.origin
    }

    /// The controller's time [s] of a timestamp [s].
    pub(crate) fn time(&mut self, stamp: f64) -> f64 {
        stamp - *self.origin.get_or_insert(stamp)
    }

    /// The timestamp [s] of a controller time [s].
    pub(crate) fn stamp(&self, time: f64) -> f64 {
        // 0 + t is t, so nothing is rounded in a recording that starts at 0.
        self.origin.unwrap_or(0.0) + time
    }

    /// The first timestamp [s] that is not before `time` [s]. The nearest one may be slightly
    /// earlier, because timestamps have fewer decimals, and a peer that waits for it would wait for
    /// ever.
    pub(crate) fn stamp_reaching(&self, time: f64) -> f64 {
        let origin = self.origin.unwrap_or(0.0);
        let mut stamp = self.stamp(time);
        while stamp - origin < time {
            stamp = stamp.next_up();
        }
        stamp
    }

    /// Judges the timestamp of a message, which may be a tick.
    ///
    /// # Errors
    /// The timestamp is too far from the present to be accepted in any case.
    pub(crate) fn judge(&mut self, stamp: f64, is_tick: bool) -> Result<StampTrust, Rejected> {
        let ahead = match self.kind {
            ClockKind::System => AHEAD,
            ClockKind::Messages if self.origin.is_none() => return Ok(StampTrust::Doubtful),
            ClockKind::Messages if is_tick => LEAP,
            ClockKind::Messages => DOUBTFUL,
        };
        let time = self.time(stamp);
        let is_ahead = time > self.now + ahead;
        if time < self.now - OLDEST || (is_ahead && self.kind == ClockKind::System) {
            return Err(self.refuse(stamp, &format!("{ahead} s ahead")));
        }
        Ok(if is_ahead {
            StampTrust::Doubtful
        } else {
            StampTrust::Certain(time)
        })
    }

    /// Whether the timestamp `doubtful` is confirmed by the next one, `next`. The very first
    /// timestamp must be near the next one, because nothing else shows whether it is wild.
    pub(crate) fn confirms(&self, doubtful: f64, next: f64) -> bool {
        next >= doubtful - OLDEST && (self.origin.is_some() || next <= doubtful + LEAP)
    }

    /// The refusal of a message whose doubtful timestamp was not confirmed.
    pub(crate) fn unconfirmed(&self, stamp: f64) -> Rejected {
        if self.origin.is_some() {
            let ahead = format!("{DOUBTFUL} s ahead, or confirmed by the next message");
            return self.refuse(stamp, &ahead);
        }
        let stamp = shown_number(stamp);
        let problem = format!("stamp = {stamp} is the first, and the next one is not near it");
        let expected = format!("at most {OLDEST} s before or {LEAP} s after it");
        Rejected::new(Rejection::Stamp, format!("{problem}; expected {expected}"))
    }

    fn refuse(&self, stamp: f64, ahead: &str) -> Rejected {
        let (stamp, now) = (shown_number(stamp), shown_number(self.stamp(self.now)));
        let problem = format!("stamp = {stamp}, but the time is {now}");
        let expected = format!("at most {OLDEST} s in the past and {ahead}");
        Rejected::new(Rejection::Stamp, format!("{problem}; expected {expected}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tick at the timestamp given by a `due` triggers what is due then.
    #[test]
    fn a_stamp_that_is_waited_for_brings_its_time() {
        let mut early = 0;
        for origin in [0.0, 0.7, 1000.0, 1_795_656_426.3] {
            let mut clock = Clock::resume(ClockKind::Messages, Some(origin), 0.0);
            for number in 0..10_000 {
                let time = 0.037_1 * f64::from(number);
                let (nearest, stamp) = (clock.stamp(time), clock.stamp_reaching(time));
                early += usize::from(clock.time(nearest) < time);
                assert!(clock.time(stamp) >= time);
                assert!(stamp <= nearest.next_up(), "{stamp} {nearest}");
            }
        }
        assert!(early > 1000, "{early}");
    }
}
