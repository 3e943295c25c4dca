//! Durations of decisions, in constant memory.

use super::protocol::Latency;

/// Ratio of the limits of neighbouring classes: 1 %, so that a quantile can be compared with a
/// budget.
const WIDER: f64 = 1.01;
/// Number of classes of the histogram, which reach beyond 1,000 s.
const CLASSES: usize = 2_400;
/// Upper limit of the first class [s].
const FIRST: f64 = 1e-7;

/// Limits of [`DecisionTimes`] [s].
const LIMITS: [f64; 14] = [
    1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 1.0,
];

/// Durations of decisions, for programs that collect histograms.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DecisionTimes {
    /// Limits [s], and how many decisions took at most that long; the limits are exact to 1 %.
    pub within: Vec<(f64, u64)>,
    /// Number of decisions.
    pub count: u64,
    /// Total duration [s].
    pub sum: f64,
}

/// A histogram of durations.
#[derive(Debug, Clone)]
pub struct Histogram {
    counts: Vec<u64>,
    total: u64,
    sum: f64,
    max: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            counts: vec![0; CLASSES],
            total: 0,
            sum: 0.0,
            max: 0.0,
        }
    }
}

impl Histogram {
    /// Adds a duration [s].
    pub fn note(&mut self, seconds: f64) {
        let class = (seconds / FIRST).max(1.0).ln() / WIDER.ln();
        // Clamped at both ends.
        self.counts[(class.ceil() as usize).min(CLASSES - 1)] += 1;
        self.total += 1;
        self.sum += seconds;
        self.max = self.max.max(seconds);
    }

    /// The figures for a status.
    pub fn latency(&self) -> Latency {
        Latency {
            decisions: self.total,
            p50_ms: 1e3 * self.quantile(0.5),
            p99_ms: 1e3 * self.quantile(0.99),
            max_ms: 1e3 * self.max,
        }
    }

    /// Counts within fixed limits.
    pub fn decision_times(&self) -> DecisionTimes {
        let within = LIMITS.map(|limit| {
            let classes = (limit / FIRST).ln() / WIDER.ln();
            let counts = &self.counts[..=classes.round() as usize];
            (limit, counts.iter().sum())
        });
        DecisionTimes {
            within: within.to_vec(),
            count: self.total,
            sum: self.sum,
        }
    }

    /// Upper limit of the class that contains the quantile [s].
    fn quantile(&self, share: f64) -> f64 {
        let rank = share * self.total as f64;
        let mut below = 0;
        for (class, count) in self.counts.iter().enumerate() {
            below += count;
            if below > 0 && below as f64 >= rank {
                return (FIRST * WIDER.powi(class as i32)).min(self.max);
            }
        }
        self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_a_class() {
        let mut histogram = Histogram::default();
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
