//! The faults of an emulated station.

use pickline::error::{Error, Result, shown_number};
use pickline::pattern::random_stream;
use rand::RngExt as _;

/// The faults; none by default. Everything random follows from the seed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct InjectedFaults {
    /// Share of failing grasps, 0 to 1.
    pub grasp_failures: f64,
    /// Share of lost acknowledgements, 0 to 1.
    pub lost_acks: f64,
    /// Share of detections that are sent twice, 0 to 1.
    pub duplicates: f64,
    /// Share of detections that come up to a second late, 0 to 1.
    pub out_of_order: f64,
    /// Maximum delay of messages [s].
    pub jitter: f64,
    /// A robot breakdown: index of the robot, start [s] and duration [s].
    pub robot_down: Option<(usize, f64, f64)>,
    /// A stop of the belt: start [s] and duration [s].
    pub belt_stop: Option<(f64, f64)>,
    /// Standard deviation of when a movement of an arm ends [s].
    pub time_noise: f64,
    /// Seed of everything random.
    pub seed: u64,
}

/// The purpose of a random draw, so that one kind of fault does not affect another.
#[derive(Debug, Clone, Copy)]
pub(super) enum FaultDraw {
    Grasp = 1,
    Ack = 2,
    Twice = 3,
    Late = 4,
    Jitter = 5,
    WayOut = 6,
    WayHome = 7,
}

impl InjectedFaults {
    /// With this share of failing grasps, 0 to 1.
    #[must_use]
    pub fn with_grasp_failures(mut self, grasp_failures: f64) -> Self {
        self.grasp_failures = grasp_failures;
        self
    }

    /// With this share of lost acknowledgements, 0 to 1.
    #[must_use]
    pub fn with_lost_acks(mut self, lost_acks: f64) -> Self {
        self.lost_acks = lost_acks;
        self
    }

    /// With this share of detections that are sent twice, 0 to 1.
    #[must_use]
    pub fn with_duplicates(mut self, duplicates: f64) -> Self {
        self.duplicates = duplicates;
        self
    }

    /// With this share of detections that come up to a second late, 0 to 1.
    #[must_use]
    pub fn with_out_of_order(mut self, out_of_order: f64) -> Self {
        self.out_of_order = out_of_order;
        self
    }

    /// With messages that are delayed by up to this time [s].
    #[must_use]
    pub fn with_jitter(mut self, jitter: f64) -> Self {
        self.jitter = jitter;
        self
    }

    /// With the breakdown of a robot: its index, start [s] and duration [s].
    #[must_use]
    pub fn with_robot_down(mut self, robot_down: impl Into<Option<(usize, f64, f64)>>) -> Self {
        self.robot_down = robot_down.into();
        self
    }

    /// With a stop of the belt: start [s] and duration [s].
    #[must_use]
    pub fn with_belt_stop(mut self, belt_stop: impl Into<Option<(f64, f64)>>) -> Self {
        self.belt_stop = belt_stop.into();
        self
    }

    /// With movements of arms that end at other times, with this standard deviation [s].
    #[must_use]
    pub fn with_time_noise(mut self, time_noise: f64) -> Self {
        self.time_noise = time_noise;
        self
    }

    /// With this seed of everything random.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Checks the values for a line with `robots` robots.
    ///
    /// # Errors
    /// An invalid share or time, or a robot that the line does not have.
    pub fn check(&self, robots: usize) -> Result<()> {
        for (setting, share) in [
            ("'grasp_failures'", self.grasp_failures),
            ("'lost_acks'", self.lost_acks),
            ("'duplicates'", self.duplicates),
            ("'out_of_order'", self.out_of_order),
        ] {
            if !(0.0..=1.0).contains(&share) {
                let problem = format!("{} is not a valid share", shown_number(share));
                return Err(Error::usage(
                    setting,
                    problem,
                    "give a share between 0 and 1",
                ));
            }
        }
        let (down_at, down) = self
            .robot_down
            .map_or((0.0, 0.0), |(_, at, time)| (at, time));
        let (stop_at, stop) = self.belt_stop.unwrap_or_default();
        for (setting, time, most) in [
            ("'jitter'", self.jitter, 10.0),
            ("'time_noise'", self.time_noise, 10.0),
            ("'robot_down'", down_at, 1e6),
            ("'robot_down'", down, 1e6),
            ("'belt_stop'", stop_at, 1e6),
            ("'belt_stop'", stop, 1e6),
        ] {
            if !(0.0..=most).contains(&time) {
                let problem = format!("{} s is out of range", shown_number(time));
                let cure = format!("give a time from 0 to {most} s");
                return Err(Error::usage(setting, problem, cure));
            }
        }
        match self.robot_down {
            Some((robot, ..)) if robot >= robots => Err(Error::usage(
                "'robot_down'",
                format!(
                    "there is no robot {} on a line with {robots} robots",
                    robot.saturating_add(1)
                ),
                "count robots from 1, upstream first",
            )),
            _ => Ok(()),
        }
    }

    /// A uniform number in [0, 1) that depends on the seed, the purpose and `number`.
    pub(super) fn draw(&self, what: FaultDraw, number: u64) -> f64 {
        let mut rng = random_stream(self.seed ^ ((what as u64) << 56), number);
        rng.random()
    }

    /// By how much a movement ends later than it should [s], normally distributed; `number` is that
    /// of its task.
    pub(super) fn time_off(&self, what: FaultDraw, number: u64) -> f64 {
        if self.time_noise == 0.0 {
            return 0.0;
        }
        // The transform of Box and Muller (1958, DOI 10.1214/aoms/1177706645).
        let [size, angle] = [0, 1].map(|part| self.draw(what, number << 1 | part));
        let size = (-2.0 * (1.0 - size).ln()).sqrt();
        self.time_noise * size * (std::f64::consts::TAU * angle).cos()
    }
}
