//! Which clock rules, and which stamps are believed.

use super::protocol::{Rejected, Rejection};
use crate::error::shown_number;

/// Stamps further behind than this [s] are refused: what they tell is of no use any more.
pub const OLDEST: f64 = 60.0;
/// With the system clock, stamps further ahead than this [s] are refused.
const AHEAD: f64 = 5.0;
/// With message time, stamps further ahead than this [s] are refused: one slip must not
/// make all that follows old.
const LEAP: f64 = 3600.0;

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

    /// The time [s] of a stamp that is near enough to the present to be believed.
    pub fn believe(&mut self, stamp: f64) -> Result<f64, Rejected> {
        let ahead = match self.kind {
            ClockKind::System => AHEAD,
            ClockKind::Messages => LEAP,
        };
        let time = self.time(stamp);
        if time >= self.now - OLDEST && time <= self.now + ahead {
            return Ok(time);
        }
        Err(Rejected::new(
            Rejection::Stamp,
            format!(
                "stamp = {}, while it is {}; expected at most {OLDEST} s behind and {ahead} s ahead",
                shown_number(stamp),
                shown_number(self.stamp(self.now))
            ),
        ))
    }
}
