//! The axes of a chart: where they begin and end, and their ticks.

use pickline::stats::Interval;

/// The scale along one edge of a chart.
#[derive(Debug)]
pub(crate) enum ChartAxis {
    /// Numbers from `low` to `high`.
    Numbers {
        /// The measured quantity, with its unit in brackets.
        title: String,
        low: f64,
        high: f64,
        /// Distance between two ticks.
        step: f64,
    },
    /// Names; the first is at 0, the next at 1.
    Names(Vec<String>),
}

impl ChartAxis {
    /// An axis with round ends that includes all `values`, and 0 if `from_zero`. Values that
    /// are not finite are ignored.
    pub(crate) fn around(
        title: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        from_zero: bool,
    ) -> Self {
        let start = if from_zero {
            (0.0, 0.0)
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        };
        let finite = values.into_iter().filter(|value| value.is_finite());
        let (low, high) = finite.fold(start, |(low, high), v| (v.min(low), v.max(high)));
        // No values, or a single one, still need an axis around them.
        let (low, high) = match (low < high, low.is_finite()) {
            (true, _) => (low, high),
            (false, true) => {
                let room = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
                (low - room, low + room)
            }
            (false, false) => (0.0, 1.0),
        };
        let step = round_step((high - low) / 6.0);
        Self::Numbers {
            title: title.into(),
            low: (low / step + 1e-9).floor() * step,
            high: (high / step - 1e-9).ceil() * step,
            step,
        }
    }

    /// An axis of whole numbers from `first` to `last`, such as robots or places. Its ticks are
    /// whole numbers as well, none below `first`.
    pub(crate) fn counted(title: impl Into<String>, first: f64, last: f64) -> Self {
        let step = round_step(((last - first) / 15.0).max(1.0));
        Self::Numbers {
            title: title.into(),
            low: first - 0.5,
            high: last + 0.5,
            step,
        }
    }

    /// Whether the axis does not include 0, so that lengths along it cannot be compared. Such
    /// an axis is drawn with a break.
    pub(crate) fn is_cut(&self) -> bool {
        match self {
            Self::Numbers { low, high, .. } => *low > 0.0 || *high < 0.0,
            Self::Names(_) => false,
        }
    }

    /// The same axis, ending at `end` at most.
    pub(crate) fn up_to(mut self, end: f64) -> Self {
        if let Self::Numbers { high, .. } = &mut self {
            *high = high.min(end);
        }
        self
    }
}

/// The interval of a share in percent. An interval of a mean may pass 100 %, a share cannot.
pub(crate) fn percent(share: Interval) -> Interval {
    Interval {
        low: 100.0 * share.low,
        high: (100.0 * share.high).min(100.0),
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter();
    let steps = factor.map(|factor| factor * power);
    steps
        .into_iter()
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(values: &[f64], from_zero: bool) -> (f64, f64, f64) {
        match ChartAxis::around("", values.iter().copied(), from_zero) {
            ChartAxis::Numbers {
                low, high, step, ..
            } => (low, high, step),
            ChartAxis::Names(_) => unreachable!(),
        }
    }

    #[test]
    fn axes_have_round_ends_around_their_values() {
        let near = |(low, high, step): (f64, f64, f64), expected: [f64; 3]| {
            for (a, b) in [low, high, step].into_iter().zip(expected) {
                assert!(
                    (a - b).abs() < 1e-9,
                    "{low} to {high} by {step}: {expected:?}"
                );
            }
        };
        near(ends(&[28.3, 31.1], true), [0.0, 40.0, 10.0]);
        near(ends(&[-0.2, 0.9], false), [-0.2, 1.0, 0.2]);
        near(ends(&[3.0], false), [2.7, 3.3, 0.1]);
        near(ends(&[0.0], false), [-1.0, 1.0, 0.5]);
        near(ends(&[], false), [0.0, 1.0, 0.2]);
        near(ends(&[1.0, f64::INFINITY, 2.0], false), [1.0, 2.0, 0.2]);
    }

    #[test]
    fn axes_of_counts_have_whole_ticks_from_the_first() {
        for (first, last, expected) in [
            (1.0, 3.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.0, 14.0, 1.0),
            (2.0, 25.0, 2.0),
        ] {
            let axis = ChartAxis::counted("", first, last);
            let ChartAxis::Numbers { low, step, .. } = axis else {
                unreachable!()
            };
            assert_eq!(step, expected);
            // The tick below the first would be outside.
            assert!(low > first - 1.0 && low < first);
            assert!(ChartAxis::counted("", 1.0, last).is_cut());
        }
        assert!(ChartAxis::around("", [0.03, 0.05], false).is_cut());
        assert!(ChartAxis::around("", [-3.0, -1.0], false).is_cut());
        assert!(!ChartAxis::around("", [-1.0, 1.0], false).is_cut());
        assert!(!ChartAxis::around("", [3.0], true).is_cut());
    }
}
