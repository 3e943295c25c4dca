//! How often a source repeats itself.

/// Gaps that are remembered; with fewer there is no period.
const GAPS: usize = 15;
/// Messages that are nearer to each other [s] are one: detections of one picture.
const ONE: f64 = 1e-3;
/// A period is learned over at least so much time [s]: a ramp of the speed, told step by step,
/// is none.
const LEARNED: f64 = 2.0;
/// Of regular gaps three quarters are at most so many times the median.
const REGULAR: f64 = 3.0;

/// The time between two messages of a source, as a rule.
#[derive(Debug, Clone, Default)]
pub struct Period {
    /// The last gaps [s].
    gaps: Vec<f64>,
    next: usize,
    /// For how long it has repeated itself without a break [s].
    span: f64,
    /// As it was learned [s].
    learned: Option<f64>,
}

impl Period {
    /// A message has come `gap` [s] after the one before, and repeats it or not.
    pub fn note(&mut self, gap: f64, repeats: bool) {
        if !repeats {
            (self.span, self.next) = (0.0, 0);
            self.gaps.clear();
            return;
        }
        if gap < ONE {
            return;
        }
        if self.gaps.len() < GAPS {
            self.gaps.push(gap);
        } else {
            self.gaps[self.next] = gap;
        }
        self.next = (self.next + 1) % GAPS;
        self.span += gap;
        if self.gaps.len() < GAPS || self.span < LEARNED {
            return;
        }
        let mut gaps = self.gaps.clone();
        gaps.sort_unstable_by(f64::total_cmp);
        let median = gaps[GAPS / 2];
        let is_regular = gaps[GAPS * 3 / 4] <= REGULAR * median;
        self.learned = is_regular.then_some(median);
    }

    /// The time between two messages [s], if the source repeats itself regularly.
    pub fn get(&self) -> Option<f64> {
        self.learned
    }
}
