//! The machine's clocks, as a node reads them.

use crate::{ClockReading, SteadyClock};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long to wait at the end for a peer that does not read the remaining output.
pub const CLOSE_TIMEOUT: Duration = Duration::from_secs(2);
/// How often to check for a request to stop.
pub const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// How long to wait for room when too much output is queued.
pub const ROOM_INTERVAL: Duration = Duration::from_millis(1);

/// Seconds since 1970.
pub fn unix_now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap_or_default().as_secs_f64()
}

/// The time from `now` until `stamp`, at least zero and at most [`POLL_INTERVAL`].
pub fn until(stamp: Option<f64>, now: f64) -> Duration {
    let left = stamp.map_or(f64::INFINITY, |stamp| stamp - now);
    Duration::from_secs_f64(left.clamp(0.0, POLL_INTERVAL.as_secs_f64()))
}

/// Combines the machine's two clocks into one that is never set.
#[derive(Debug)]
pub(super) struct NodeClock {
    steady: SteadyClock,
    began: Instant,
}

impl Default for NodeClock {
    fn default() -> Self {
        Self::start()
    }
}

impl NodeClock {
    /// Starts it at the machine's time.
    pub(super) fn start() -> Self {
        let mut clock = Self {
            steady: SteadyClock::default(),
            began: Instant::now(),
        };
        clock.read();
        clock
    }

    /// Reads the clock.
    pub(super) fn read(&mut self) -> ClockReading {
        /// A longer reading means that the process was preempted between the two clocks.
        const AT_ONCE: Duration = Duration::from_millis(1);
        const TRIES: usize = 10;
        let mut best = (Duration::MAX, 0.0, 0.0);
        for _ in 0..TRIES {
            let before = self.began.elapsed();
            let wall = unix_now();
            let after = self.began.elapsed();
            let took = after.saturating_sub(before);
            if took < best.0 {
                best = (took, after.as_secs_f64(), wall);
            }
            if took <= AT_ONCE {
                break;
            }
        }
        let (_, monotonic, wall) = best;
        self.steady.read(monotonic, wall)
    }
}
