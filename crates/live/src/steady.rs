//! A clock that cannot be set.
//!
//! Decisions must not jump when the machine's clock is set, by NTP or by hand. This clock follows
//! the machine's clock while that is only slewed, and keeps its own pace when that steps. It reads
//! no clock itself: the caller passes both readings.

/// The machine's clock was set if it gained or lost more than this [s] between two readings.
/// Slewing is at most half a millisecond per second.
const STEP: f64 = 0.05;

/// A reading of the steady clock.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ClockReading {
    /// Time since 1970 [s], starting from the machine's clock at the first reading.
    pub stamp: f64,
    /// By how much the machine's clock is ahead of `stamp` because it was set [s].
    pub ahead: f64,
}

/// The machine's clock without its steps.
///
/// Invariant: the timestamps never go back by more than `STEP`, and `ahead` changes by more than
/// that or not at all.
#[derive(Debug, Clone, Copy, Default)]
pub struct SteadyClock {
    /// The last readings of both clocks [s].
    last: Option<(f64, f64)>,
    ahead: f64,
}

impl SteadyClock {
    /// The steady clock's reading when the monotonic clock shows `monotonic` [s], from any zero,
    /// and the machine's clock `wall` [s since 1970].
    pub fn read(&mut self, monotonic: f64, wall: f64) -> ClockReading {
        if let Some((before, wall_before)) = self.last {
            let gained = (wall - wall_before) - (monotonic - before);
            if gained.abs() > STEP {
                self.ahead += gained;
            }
        }
        self.last = Some((monotonic, wall));
        ClockReading {
            stamp: wall - self.ahead,
            ahead: self.ahead,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_left_out_and_slewing_is_followed() {
        let mut clock = SteadyClock::default();
        let (mut wall, mut worst) = (1.7e9, 0.0_f64);
        for i in 0..100_000 {
            let monotonic = 5.0 + 0.02 * f64::from(i);
            // Slewed by 500 ppm, set back by 5 s, and forward by 100 s for 2 s.
            wall += 0.02 * 1.0005;
            wall += match i {
                10_000 => -5.0,
                20_000 => 100.0,
                20_100 => -100.0,
                _ => 0.0,
            };
            let reading = clock.read(monotonic, wall);
            let slewed = 1.7e9 + 0.02 * 1.0005 * f64::from(i + 1);
            worst = worst.max((reading.stamp - slewed).abs());
            let ahead = match i {
                ..10_000 => 0.0,
                20_000..20_100 => 95.0,
                _ => -5.0,
            };
            assert!((reading.ahead - ahead).abs() < 1e-4, "{i}: {reading:?}");
        }
        assert!(worst < 1e-3, "{worst} s");
    }
}
