//! Which clock rules, and which stamps are believed.

use super::protocol::{Rejected, Rejection};
use pickline::error::shown_number;

/// Stamps further behind than this [s] are refused: what they tell is of no use any more.
pub const OLDEST: f64 = 60.0;
/// With the system clock, stamps further ahead than this [s] are refused.
const AHEAD: f64 = 5.0;
/// With message time, what is further ahead than this [s] is doubtful. One wild stamp must
/// not make all that follows too old, and this much makes nothing too old.
const DOUBTFUL: f64 = OLDEST;
/// A tick so far ahead [s] is not: it comes from whoever keeps the time, and waits for an
/// answer.
pub const LEAP: f64 = 3600.0;

/// Where the time comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClockKind {
    /// The machine's clock [s since 1970]; decisions are made when they are due.
    #[default]
    System,
    /// The stamps of the messages: the same messages give the same output, to the bit.
    Messages,
}

impl ClockKind {
    /// Its name, as it is written after `--clock`.
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::Messages => "messages",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        let kinds = [Self::System, Self::Messages];
        kinds.into_iter().find(|kind| kind.name() == name)
    }
}

/// What is thought of a stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Belief {
    /// It is near enough to the present; the time [s].
    Certain(f64),
    /// With message time: it is far ahead, or the first. The next stamp decides.
    Doubtful,
}

/// The controller's time: 0 at its beginning, so that it keeps its digits.
#[derive(Debug, Clone)]
pub struct Clock {
    /// Where the time comes from.
    pub kind: ClockKind,
    /// Stamp of time 0 [s]; with message time that of the first message.
    origin: Option<f64>,
    /// Time of the controller [s]; it never goes back.
    pub now: f64,
}

impl Clock {
    /// A clock that begins with the first stamp it hears of, or the first reading.
    pub fn new(kind: ClockKind) -> Self {
        Self {
            kind,
            origin: None,
            now: 0.0,
        }
    }

    /// A clock that goes on from `now` [s], with its time 0 at the stamp `origin`.
    pub fn resume(kind: ClockKind, origin: Option<f64>, now: f64) -> Self {
        Self { kind, origin, now }
    }

    /// Stamp of time 0 [s], once there is one.
    pub fn origin(&self) -> Option<f64> {
        self.origin
    }

    /// The time [s] of a stamp.
    pub fn time(&mut self, stamp: f64) -> f64 {
        stamp - *self.origin.get_or_insert(stamp)
    }

    /// The stamp of a time [s].
    pub fn stamp(&self, time: f64) -> f64 {
        // 0 + t is t, so with a recording that begins at 0 nothing is rounded.
        self.origin.unwrap_or(0.0) + time
    }

    /// The first stamp by which `time` [s] has come. The nearest one may be a little before,
    /// for stamps have fewer digits after the point, and whoever waits for it would wait for
    /// ever.
    pub fn stamp_reaching(&self, time: f64) -> f64 {
        let origin = self.origin.unwrap_or(0.0);
        let mut stamp = self.stamp(time);
        while stamp - origin < time {
            stamp = stamp.next_up();
        }
        stamp
    }

    /// What is to be thought of the stamp of a message, that of a tick or of another.
    ///
    /// # Errors
    /// A stamp that is too far from the present to be believed, whatever comes.
    pub fn judge(&mut self, stamp: f64, is_tick: bool) -> Result<Belief, Rejected> {
        let ahead = match self.kind {
            ClockKind::System => AHEAD,
            ClockKind::Messages if self.origin.is_none() => return Ok(Belief::Doubtful),
            ClockKind::Messages if is_tick => LEAP,
            ClockKind::Messages => DOUBTFUL,
        };
        let time = self.time(stamp);
        let is_ahead = time > self.now + ahead;
        if time < self.now - OLDEST || (is_ahead && self.kind == ClockKind::System) {
            return Err(self.refuse(stamp, &format!("{ahead} s ahead")));
        }
        Ok(if is_ahead {
            Belief::Doubtful
        } else {
            Belief::Certain(time)
        })
    }

    /// Whether time has come to `doubtful`, a stamp, now that the next one is `next`. The
    /// first of all has to be near its next: there is no other to tell that it is wild.
    pub fn confirms(&self, doubtful: f64, next: f64) -> bool {
        next >= doubtful - OLDEST && (self.origin.is_some() || next <= doubtful + LEAP)
    }

    /// Why a message with this stamp, which was doubtful, is refused.
    pub fn unconfirmed(&self, stamp: f64) -> Rejected {
        if self.origin.is_some() {
            let ahead = format!("{DOUBTFUL} s ahead, or a next stamp as late");
            return self.refuse(stamp, &ahead);
        }
        let stamp = shown_number(stamp);
        let problem = format!("stamp = {stamp} is the first, and the next is not near it");
        let expected = format!("at most {OLDEST} s before or {LEAP} s after it");
        Rejected::new(Rejection::Stamp, format!("{problem}; expected {expected}"))
    }

    fn refuse(&self, stamp: f64, ahead: &str) -> Rejected {
        let (stamp, now) = (shown_number(stamp), shown_number(self.stamp(self.now)));
        let problem = format!("stamp = {stamp}, while it is {now}");
        let expected = format!("at most {OLDEST} s behind and {ahead}");
        Rejected::new(Rejection::Stamp, format!("{problem}; expected {expected}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tick at the stamp that a `due` has named brings what is due then.
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
