//! How long decisions take, in memory that does not grow.

use super::protocol::Latency;

/// How much wider each class is than the one before: 1 %, so that a quantile can be held
/// against a budget.
const WIDER: f64 = 1.01;
/// Classes of the histogram, to over 1,000 s.
const CLASSES: usize = 2_400;
/// Upper end of the first class [s].
const FIRST: f64 = 1e-7;

/// A histogram of durations.
#[derive(Debug, Clone)]
pub struct Histogram {
    counts: Vec<u64>,
    total: u64,
    max: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            counts: vec![0; CLASSES],
            total: 0,
            max: 0.0,
        }
    }
}

impl Histogram {
    /// Notes a duration [s].
    pub fn note(&mut self, seconds: f64) {
        let class = (seconds / FIRST).max(1.0).ln() / WIDER.ln();
        // Saturates at both ends.
        self.counts[(class.ceil() as usize).min(CLASSES - 1)] += 1;
        self.total += 1;
        self.max = self.max.max(seconds);
    }

    /// What is reported of it.
    pub fn latency(&self) -> Latency {
        Latency {
            decisions: self.total,
            p50_ms: 1e3 * self.quantile(0.5),
            p99_ms: 1e3 * self.quantile(0.99),
            max_ms: 1e3 * self.max,
        }
    }

    /// Upper end of the class that holds the quantile [s].
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
        histogram.note(1e9);
        histogram.note(0.0);
    }
}
