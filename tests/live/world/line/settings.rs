//! What is played: the pace, the belt, and what goes wrong.

use crate::support::tracker::Mistakes;
use crate::world::robot::{Habits, Tells};
use rand::{Rng, RngExt as _};

/// What the tracker does wrong. 5 mm, the width of the gripper, are three standard deviations.
pub const MISTAKES: Mistakes = Mistakes {
    jitter: 0.0015,
    ..Mistakes::BAD_DAY
};

/// Where the time comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    Messages,
    Clock,
}

/// What is played.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    pub pace: Pace,
    pub items: usize,
    /// Belt for one item, on average [m].
    pub gap: f64,
    pub kills: usize,
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            pace: Pace::Messages,
            items: 1000,
            gap: 0.1,
            kills: 0,
            seed: 1,
        }
    }
}

/// Three robots that tell differently what they do, and have different habits.
pub fn habits() -> [Habits; 3] {
    let usual = Habits {
        tells: Tells::Changes,
        lost_acks: 0.03,
        failing: 0.03,
        late: 0.05,
        very_late: 0.005,
    };
    [
        usual,
        Habits {
            tells: Tells::Work,
            ..usual
        },
        Habits {
            tells: Tells::Cycle,
            late: 0.1,
            ..usual
        },
    ]
}

/// Some faults of 2 s to 15 s.
pub fn faults(start: f64, end: f64, rng: &mut impl Rng) -> Vec<(f64, f64)> {
    let count = ((end - start) / 80.0).ceil() as usize;
    let part = (end - start) / count as f64;
    let faults = (0..count).map(|number| {
        let from = start + part * (number as f64 + rng.random_range(0.1..0.6));
        (from, from + rng.random_range(2.0..15.0_f64.min(0.3 * part)))
    });
    faults.collect()
}

/// How the belt runs: speeds [m/s], and how long each holds [s].
pub fn stretches(pace: Pace) -> &'static [(f64, f64)] {
    match pace {
        Pace::Messages => &[
            (0.3, 60.0),
            (0.0, 6.0),
            (0.25, 50.0),
            (0.35, 40.0),
            (0.0, 10.0),
            (0.3, 70.0),
            (0.2, 30.0),
            (0.0, 2.0),
            (0.3, 1.0),
        ],
        Pace::Clock => &[(0.3, 8.0), (0.0, 2.0), (0.25, 8.0), (0.3, 1.0)],
    }
}
