//! The mean of a noisy speed since it last changed.

/// A difference between messages that are further apart than this [s] is a change, not noise. After
/// a silence of this time the last message holds.
pub(super) const FRESH: f64 = 1.0;
/// Number of deviations in the window for the spread.
const WINDOW: usize = 15;
/// With fewer deviations than this there is no spread.
const LEAST: usize = 5;
/// Noise is at most this share of the speed: anything larger is real motion.
const MOST_NOISE: f64 = 0.05;
/// The mean covers at most this many messages, or [`LONGEST`] [s] if that is more.
const MOST: f64 = 100.0;
const LONGEST: f64 = 1.0;
/// The noise level is smoothed over this many messages.
const SMOOTHED: f64 = 32.0;
/// Allowance and threshold of the change test [standard deviations]: one false alarm in some
/// thousands of messages; a change of three standard deviations is found within four messages.
const ALLOWANCE: f64 = 0.5;
const THRESHOLD: f64 = 10.0;
/// A single message that is this far off [standard deviations] is a change.
const FAR: f64 = 6.0;

/// The size of the last deviations without the largest quarter, because a single change is not
/// noise.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spread {
    values: [f64; WINDOW],
    len: usize,
    next: usize,
}

impl Spread {
    /// Adds a deviation.
    pub(super) fn note(&mut self, value: f64) {
        self.values[self.next] = value.abs();
        self.next = (self.next + 1) % WINDOW;
        self.len = WINDOW.min(self.len + 1);
    }

    /// The upper quartile of the deviations; 0 while there are too few.
    pub(super) fn level(&self) -> f64 {
        if self.len < LEAST {
            return 0.0;
        }
        let mut values = self.values;
        let values = &mut values[..self.len];
        values.sort_unstable_by(f64::total_cmp);
        values[self.len * 3 / 4]
    }
}

/// A cumulative sum of deviations to one side, and its number of messages.
#[derive(Debug, Clone, Copy, Default)]
struct DeviationSum {
    sum: f64,
    messages: u32,
}

impl DeviationSum {
    fn note(&mut self, deviation: f64) -> bool {
        self.sum += deviation - ALLOWANCE;
        self.messages += 1;
        if self.sum <= 0.0 {
            *self = Self::default();
        }
        self.sum > THRESHOLD || deviation > FAR
    }

    /// The change of the mean [standard deviations].
    fn shift(&self) -> f64 {
        ALLOWANCE + self.sum / f64::from(self.messages)
    }
}

/// The mean of a speed since it last changed by more than its noise: the test for the change
/// is the cumulative sum of E. S. Page (1954), doi:10.1093/biomet/41.1-2.100.
///
/// Without noise, every different value is a change, and the mean is the last value.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedMean {
    mean: f64,
    /// Speeds up to this are noise around 0 [m/s].
    dead: f64,
    count: u32,
    up: DeviationSum,
    down: DeviationSum,
    /// The last two speeds.
    before: [Option<f64>; 2],
    /// Second differences: a ramp has none.
    bends: Spread,
    /// Their level, smoothed.
    level: f64,
}

impl SpeedMean {
    /// A mean that starts at `mean` [m/s] before any message; speeds up to `dead` [m/s] are noise
    /// around 0.
    pub(super) fn new(mean: f64, dead: f64) -> Self {
        Self {
            mean,
            dead,
            count: 1,
            up: DeviationSum::default(),
            down: DeviationSum::default(),
            before: [None; 2],
            bends: Spread::default(),
            level: 0.0,
        }
    }

    /// The mean of the reported speed since it last changed [m/s].
    pub(super) fn mean(&self) -> f64 {
        self.mean
    }

    /// Standard deviation of a single message [m/s].
    pub(super) fn noise(&self) -> f64 {
        // A second difference has sqrt(6) times the standard deviation of a single value, and three
        // quarters of a normal distribution lie within 1.15 standard deviations.
        let noise = self.level / (1.15 * 6_f64.sqrt());
        noise.min(self.dead.max(MOST_NOISE * self.mean.abs()))
    }

    /// Standard deviation of the mean [m/s].
    pub(super) fn doubt(&self) -> f64 {
        self.noise() / f64::from(self.count).sqrt()
    }

    /// Adds a speed [m/s], measured `gap` [s] after the previous one, if there was one. Returns
    /// whether the speed has changed.
    pub(super) fn note(&mut self, speed: f64, gap: Option<f64>) -> bool {
        let is_apart = gap.is_none_or(|gap| gap > FRESH);
        if is_apart {
            self.before = [None; 2];
        }
        let stands = speed.abs() <= self.dead && self.mean.abs() <= self.dead;
        let noise = self.noise().max(if stands { self.dead } else { 0.0 });
        let changed = if is_apart || noise == 0.0 {
            let changed = speed != self.mean;
            (self.mean, self.count) = (speed, 1);
            changed
        } else {
            let most = MOST.max(LONGEST / gap.unwrap_or(LONGEST).max(1e-6));
            self.test(speed, noise, most)
        };
        if changed || is_apart {
            (self.up, self.down) = (DeviationSum::default(), DeviationSum::default());
        }
        if let [Some(last), Some(first)] = self.before {
            self.bends.note(speed - 2.0 * last + first);
            let level = self.bends.level();
            if level == 0.0 || self.level == 0.0 {
                self.level = level;
            }
            self.level += (level - self.level) / SMOOTHED;
        }
        self.before = [Some(speed), self.before[0]];
        changed
    }

    fn test(&mut self, speed: f64, noise: f64, most: f64) -> bool {
        let deviation = (speed - self.mean) / noise;
        let (up, down) = (self.up.note(deviation), self.down.note(-deviation));
        if !up && !down {
            self.count = most.min(f64::from(self.count) + 1.0) as u32;
            self.mean += (speed - self.mean) / f64::from(self.count);
            return false;
        }
        let (side, sign) = if up {
            (self.up, 1.0)
        } else {
            (self.down, -1.0)
        };
        self.count = side.messages;
        self.mean = if side.messages == 1 || deviation.abs() > FAR {
            self.count = 1;
            speed
        } else {
            self.mean + sign * noise * side.shift()
        };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reproducible noise of standard deviation 1.
    fn noise() -> impl Iterator<Item = f64> {
        let mut state = 1_u64;
        std::iter::repeat_with(move || {
            let uniform = || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            std::iter::repeat_with(uniform).take(12).sum()
        })
    }

    #[test]
    fn without_noise_every_change_counts_at_once() {
        let mut speed = SpeedMean::new(0.3, 0.003);
        for value in [0.3, 0.3, 0.3, 0.302, 0.302, 0.0, 0.0, 0.3, 0.15] {
            let before = speed.mean();
            assert_eq!(speed.note(value, Some(0.4)), value != before);
            assert_eq!(speed.mean(), value);
        }
        // A ramp has no noise.
        let mut speed = SpeedMean::new(0.3, 0.003);
        for i in 0..30 {
            let value = 0.3 - 0.01 * f64::from(i);
            speed.note(value, Some(0.02));
            assert!((speed.mean() - value).abs() < 0.01, "{i}");
        }
    }

    #[test]
    fn noise_is_averaged_and_changes_are_found() {
        let mut speed = SpeedMean::new(0.3, 0.003);
        let mut noise = noise();
        let mut say = |speed: &mut SpeedMean, mean: f64| {
            let value = mean * (1.0 + 0.02 * noise.next().unwrap());
            speed.note(value, Some(0.02))
        };
        for _ in 0..20 {
            say(&mut speed, 0.3);
        }
        let changes = (0..2000).filter(|_| say(&mut speed, 0.3)).count();
        assert!(changes <= 4, "{changes} changes");
        assert!((speed.mean() - 0.3).abs() < 0.0025, "{}", speed.mean());
        assert!((0.5..2.0).contains(&(speed.noise() / 0.006)));
        // A stop is found at once, a tenth slower within a few messages.
        let mut other = speed;
        assert!(say(&mut other, 0.0) && other.mean() == 0.0);
        let heard = (1..).find(|_| say(&mut speed, 0.27)).unwrap();
        assert!(heard <= 8, "{heard} messages");
        for _ in 0..30 {
            say(&mut speed, 0.27);
        }
        assert!((speed.mean() - 0.27).abs() < 0.004, "{}", speed.mean());
    }

    #[test]
    fn after_a_silence_the_last_message_holds() {
        let mut speed = SpeedMean::new(0.3, 0.003);
        let mut noise = noise();
        for _ in 0..100 {
            speed.note(0.3 + 0.006 * noise.next().unwrap(), Some(0.02));
        }
        assert!(speed.note(0.302, Some(1.5)));
        assert_eq!(speed.mean(), 0.302);
    }
}
