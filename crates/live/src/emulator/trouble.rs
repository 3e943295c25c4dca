//! What goes wrong at an emulated station.

use pickline::error::{Error, Result, shown_number};
use pickline::pattern::random_stream;
use rand::RngExt as _;

/// What goes wrong; nothing by default. All luck follows from the seed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trouble {
    /// Share of grasps that fail.
    pub grasp_failures: f64,
    /// Share of acknowledgements that are lost.
    pub lost_acks: f64,
    /// Share of detections that are sent twice.
    pub duplicates: f64,
    /// Share of detections that come up to a second late.
    pub out_of_order: f64,
    /// Messages are up to this much late [s].
    pub jitter: f64,
    /// The robot of this index is down from a time on for so long [s].
    pub robot_down: Option<(usize, f64, f64)>,
    /// The belt stands from a time on for so long [s].
    pub belt_stop: Option<(f64, f64)>,
    /// Seed of the luck.
    pub seed: u64,
}

/// What a draw is for, so that one kind of trouble does not shift another.
#[derive(Debug, Clone, Copy)]
pub(super) enum Draw {
    Grasp = 1,
    Ack = 2,
    Twice = 3,
    Late = 4,
    Jitter = 5,
}

impl Trouble {
    /// Checks the values for a line of `robots` robots.
    ///
    /// # Errors
    /// A share or a time that is none, a robot that the line does not have.
    pub fn check(&self, robots: usize) -> Result<()> {
        for (flag, share) in [
            ("--failing-grasps", self.grasp_failures),
            ("--lost-acks", self.lost_acks),
            ("--duplicates", self.duplicates),
            ("--out-of-order", self.out_of_order),
        ] {
            if !(0.0..=1.0).contains(&share) {
                let problem = format!("{} is not a share", shown_number(share));
                return Err(Error::input(flag, problem, "give a share from 0 to 1"));
            }
        }
        let (down_at, down) = self
            .robot_down
            .map_or((0.0, 0.0), |(_, at, time)| (at, time));
        let (stop_at, stop) = self.belt_stop.unwrap_or_default();
        for (flag, time, most) in [
            ("--jitter-ms", self.jitter, 10.0),
            ("--robot-down", down_at, 1e6),
            ("--robot-down", down, 1e6),
            ("--belt-stop", stop_at, 1e6),
            ("--belt-stop", stop, 1e6),
        ] {
            if !(0.0..=most).contains(&time) {
                let problem = format!("{} s is not a time for it", shown_number(time));
                let cure = format!("give at most {most} s, 0 or more");
                return Err(Error::input(flag, problem, cure));
            }
        }
        match self.robot_down {
            Some((robot, ..)) if robot >= robots => Err(Error::input(
                "--robot-down",
                format!(
                    "there is no robot {} on a line of {robots}",
                    robot.saturating_add(1)
                ),
                "count from 1, upstream first",
            )),
            _ => Ok(()),
        }
    }

    /// A number evenly from [0, 1) that depends on the seed, what it is for and `number`.
    pub(super) fn draw(&self, what: Draw, number: u64) -> f64 {
        let mut rng = random_stream(self.seed ^ ((what as u64) << 56), number);
        rng.random()
    }
}
