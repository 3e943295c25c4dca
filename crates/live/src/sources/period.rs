//! How often a source repeats itself.

/// Number of gaps that are kept; with fewer there is no period.
const GAPS: usize = 15;
/// Messages closer than this [s] count as one: detections of one picture.
const ONE: f64 = 1e-3;
/// A period is learned over at least this time [s], so that a speed ramp reported in steps does not
/// count.
const LEARNED: f64 = 2.0;
/// Gaps are regular if three quarters of them are at most this many times the median.
const REGULAR: f64 = 3.0;

/// The typical interval of a source's messages.
#[derive(Debug, Clone, Default)]
pub(super) struct Period {
    /// The last gaps [s].
    gaps: Vec<f64>,
    next: usize,
    /// How long it has repeated itself without interruption [s].
    span: f64,
    /// The learned period [s].
    learned: Option<f64>,
}

impl Period {
    /// Notes a message `gap` [s] after the previous one; `repeats` is whether it repeats that.
    pub(super) fn note(&mut self, gap: f64, repeats: bool) {
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

    /// The period [s], if the source repeats itself regularly.
    pub(super) fn get(&self) -> Option<f64> {
        self.learned
    }
}
