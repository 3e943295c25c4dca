//! The computing budget of one decision.

use crate::setters::setters;
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

/// What a decision may cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Budget {
    /// This many simulated decisions: choices of one robot among its items, or stops whose
    /// times are recomputed. The result is the same on every machine.
    Decisions(u64),
    /// This much time, for live use.
    Time(Duration),
}

impl Budget {
    /// The default in experiments: a larger budget gained nothing more on the dense cases
    /// (`docs/lookahead.md`).
    pub const EXPERIMENT: Self = Self::Decisions(4000);
    /// The default on a line that runs in real time.
    pub const LIVE: Self = Self::Time(Duration::from_millis(10));
    /// Allowed times for a decision [ms].
    pub const MILLISECONDS: RangeInclusive<f64> = 0.01..=60_000.0;

    /// A budget in milliseconds; `None` if outside [`Budget::MILLISECONDS`].
    pub fn milliseconds(ms: f64) -> Option<Self> {
        let within = Self::MILLISECONDS.contains(&ms);
        within.then(|| Self::Time(Duration::from_secs_f64(ms / 1e3)))
    }
}

/// The budget of a decision if a strategy's own options set none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Allowance {
    /// The budget that the user gave separately.
    pub asked: Option<Budget>,
    /// The budget if the user gave none.
    pub otherwise: Budget,
}

impl Default for Allowance {
    fn default() -> Self {
        Self {
            asked: None,
            otherwise: Budget::EXPERIMENT,
        }
    }
}

setters!(Allowance {
    /// With this budget that the user gave, or none.
    fn with_asked(asked: impl Into<Option<Budget>>);
    /// With this budget if the user gives none.
    fn with_otherwise(otherwise: Budget);
});

/// The cost of one decision so far.
#[derive(Debug)]
pub(super) struct Meter {
    budget: Budget,
    began: Instant,
    spent: u64,
    /// The number of simulated decisions at which the clock must be checked again.
    look_again: u64,
    share: f64,
}

/// Share of the time that is used; the rest is for finishing and for the work around the
/// decision.
const USED: f64 = 0.95;

/// Simulated decisions between two checks of the clock: some microseconds, as one takes about
/// 100 ns, and up to 2 us with 1,000 items in view.
const UNWATCHED: u64 = 20;

impl Meter {
    /// Starts counting.
    pub(super) fn new(budget: Budget) -> Self {
        Self {
            budget,
            began: Instant::now(),
            spent: 0,
            look_again: 0,
            share: 0.0,
        }
    }

    /// Adds simulated decisions.
    pub(super) fn spend(&mut self, decisions: usize) {
        self.spent += decisions as u64;
    }

    /// Share of the budget that is used; the budget is exhausted from 1 on.
    pub(super) fn share(&mut self) -> f64 {
        match self.budget {
            Budget::Decisions(most) => self.share = self.spent as f64 / most as f64,
            Budget::Time(most) if self.spent >= self.look_again => {
                let most = USED * most.as_secs_f64();
                self.share = self.began.elapsed().as_secs_f64() / most;
                self.look_again = self.spent + UNWATCHED;
            }
            Budget::Time(_) => {}
        }
        self.share
    }

    /// Whether time is up. A budget in decisions never ends work early: that work must be
    /// completed, with the same result on every machine.
    pub(super) fn is_late(&mut self) -> bool {
        matches!(self.budget, Budget::Time(_)) && self.share() >= 1.0
    }
}

#[cfg(test)]
impl Meter {
    /// Of a decision that began a minute ago.
    pub(crate) fn of_a_minute(budget: Budget) -> Self {
        let minute = Duration::from_secs(60);
        Self {
            began: Instant::now().checked_sub(minute).unwrap(),
            ..Self::new(budget)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn seconds(seconds: u64) -> Budget {
        Budget::Time(Duration::from_secs(seconds))
    }

    #[test]
    fn time_is_up_by_the_clock_and_a_count_never_is() {
        assert!(Meter::of_a_minute(seconds(30)).is_late());
        // A twentieth is kept back for coming to an end.
        assert!(Meter::of_a_minute(seconds(61)).is_late());
        assert!(!Meter::of_a_minute(seconds(3600)).is_late());
        let mut counted = Meter::of_a_minute(Budget::Decisions(10));
        counted.spend(25);
        assert_eq!(counted.share(), 2.5);
        assert!(!counted.is_late());
    }

    #[test]
    fn the_clock_is_looked_at_again_after_some_decisions() {
        let mut meter = Meter::new(seconds(30));
        assert!(!meter.is_late());
        meter.began = Meter::of_a_minute(seconds(30)).began;
        meter.spend(UNWATCHED as usize - 1);
        assert!(!meter.is_late());
        meter.spend(1);
        assert!(meter.is_late());
    }
}
