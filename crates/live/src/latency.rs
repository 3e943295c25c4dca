//! Durations of decisions, in constant memory.

use super::protocol::Latency;
use hdrhistogram::Histogram;

/// Digits to which a duration is exact: it falls into a class at most 1 % wide, so that a quantile
/// can be compared with a budget.
const DIGITS: u8 = 2;
/// Longest duration that is told from longer ones [ns]: 2,000 s.
const LONGEST: u64 = 2_000_000_000_000;
/// Nanoseconds per second.
const NS: f64 = 1e9;

/// Limits of [`DecisionTimes`] [s].
const LIMITS: [f64; 14] = [
    1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 1.0,
];

/// Durations of decisions, for programs that collect histograms.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct DecisionTimes {
    /// Limits [s], and how many decisions took at most that long; the limits are exact to 1 %.
    pub within: Vec<(f64, u64)>,
    /// Number of decisions.
    pub count: u64,
    /// Total duration [s].
    pub sum: f64,
}

/// The durations of all decisions so far.
#[derive(Debug, Clone)]
pub(crate) struct DurationHistogram {
    /// Durations [ns].
    counts: Histogram<u64>,
    /// Total duration [s].
    sum: f64,
    /// Longest duration, exactly [s].
    max: f64,
}

impl Default for DurationHistogram {
    fn default() -> Self {
        let counts = Histogram::new_with_bounds(1, LONGEST, DIGITS);
        Self {
            counts: counts.expect("the bounds and digits are constants that it allows"),
            sum: 0.0,
            max: 0.0,
        }
    }
}

impl DurationHistogram {
    /// Counts a decision that took `seconds` [s].
    pub(crate) fn note(&mut self, seconds: f64) {
        self.counts.saturating_record(whole_ns(seconds));
        self.sum += seconds;
        self.max = self.max.max(seconds);
    }

    /// The figures for a status.
    pub(crate) fn latency(&self) -> Latency {
        Latency {
            decisions: self.counts.len(),
            p50_ms: 1e3 * self.quantile(0.5),
            p99_ms: 1e3 * self.quantile(0.99),
            max_ms: 1e3 * self.max,
        }
    }

    /// Counts within fixed limits.
    pub(crate) fn decision_times(&self) -> DecisionTimes {
        let within = LIMITS.map(|limit| (limit, self.counts.count_between(0, whole_ns(limit))));
        DecisionTimes {
            within: within.to_vec(),
            count: self.counts.len(),
            sum: self.sum,
        }
    }

    /// Upper limit of the class that contains the quantile [s].
    fn quantile(&self, share: f64) -> f64 {
        (self.counts.value_at_quantile(share) as f64 / NS).min(self.max)
    }
}

fn whole_ns(seconds: f64) -> u64 {
    (seconds * NS).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_a_class() {
        let mut histogram = DurationHistogram::default();
        assert_eq!(histogram.latency().p99_ms, 0.0);
        for i in 1..=1000 {
            histogram.note(1e-6 * f64::from(i));
        }
        histogram.note(0.5);
        let latency = histogram.latency();
        assert!((0.5..0.506).contains(&latency.p50_ms), "{latency:?}");
        assert!((0.99..1.001).contains(&latency.p99_ms), "{latency:?}");
        assert_eq!((latency.max_ms, latency.decisions), (500.0, 1001));
        let times = histogram.decision_times();
        assert!(times.within.is_sorted());
        let within = |limit: f64| times.within.iter().find(|(l, _)| *l == limit).unwrap().1;
        assert!((98..=102).contains(&within(1e-4)), "{times:?}");
        assert_eq!((within(1e-3), within(0.1), within(1.0)), (1000, 1000, 1001));
        assert!((times.sum - 1.0005).abs() < 1e-9 && times.count == 1001);
        histogram.note(1e9);
        histogram.note(0.0);
    }
}
