//! What is emulated: the station, its pattern and its faults, and how the belt moves.

use super::trouble::InjectedFaults;
use crate::protocol::{BeltState, Incoming, RobotState, RobotStatus};
use pickline::error::Result;
use pickline::pattern::Pattern;
use pickline::station::{Robot, Station};

/// The camera sees items at least this far upstream of the point where a robot could leave for them
/// [m].
const LEAD: f64 = 0.05;
/// The run ends when the last item is this far past the belt's end [m].
const PAST_THE_END: f64 = 0.75;

/// A station with a pattern on its belt and faults. It does not change during the run.
#[derive(Debug)]
pub(super) struct EmulatedLine {
    pub station: Station,
    /// The robots as they really move, if not as the station says.
    pub arms: Option<Vec<Robot>>,
    pub pattern: Pattern,
    pub faults: InjectedFaults,
    /// Start and end of the belt's stop [s]; infinite if it never stops.
    pub belt_stop: (f64, f64),
}

impl EmulatedLine {
    /// # Errors
    /// An item beside the belt, or invalid faults.
    pub(super) fn new(station: Station, pattern: Pattern, faults: InjectedFaults) -> Result<Self> {
        pattern.check_on(&station)?;
        faults.check(station.robots().len())?;
        let belt_stop = faults
            .belt_stop
            .map_or((f64::INFINITY, f64::INFINITY), |(at, time)| (at, at + time));
        Ok(Self {
            station,
            arms: None,
            pattern,
            faults,
            belt_stop,
        })
    }

    /// The robot with this index, as it really moves.
    pub(super) fn arm_of(&self, index: usize) -> &Robot {
        let robots = self.arms.as_deref().unwrap_or(self.station.robots());
        &robots[index]
    }

    /// Whether arms do not move exactly as the station says.
    pub(super) fn differs(&self) -> bool {
        self.arms.is_some() || self.faults.time_noise > 0.0
    }

    /// The camera's x [m]: upstream of every point where a robot could leave for an item.
    pub(super) fn camera(&self) -> f64 {
        let belt = self.station.belt();
        let windows = self.pattern.items().iter().flat_map(|item| {
            let robots = self.station.robots().iter();
            let windows = robots.filter_map(|robot| robot.widest_window(belt, item.x0, item.y));
            windows.map(|(open, _)| item.x0 + belt.speed * open)
        });
        windows.fold(0.0, f64::min) - LEAD
    }

    /// The belt's travel at `time` [m].
    pub(super) fn travel(&self, time: f64) -> f64 {
        let stood = (time.min(self.belt_stop.1) - self.belt_stop.0).max(0.0);
        let moved = if stood > 0.0 { time - stood } else { time };
        self.station.belt().speed * moved
    }

    /// The time at which the belt's travel is `travel` [s].
    pub(super) fn time_of(&self, travel: f64) -> f64 {
        let time = travel / self.station.belt().speed;
        if time > self.belt_stop.0 {
            time + (self.belt_stop.1 - self.belt_stop.0)
        } else {
            time
        }
    }

    /// When the last item has left the belt [s].
    pub(super) fn end(&self) -> f64 {
        let places = self.pattern.items().iter().map(|item| item.x0);
        let last = places.fold(f64::INFINITY, f64::min);
        self.time_of(self.station.belt().length + PAST_THE_END - last)
    }

    /// What the belt reports at `time` [s].
    pub(super) fn belt_state(&self, time: f64) -> Incoming {
        let stands = (self.belt_stop.0..self.belt_stop.1).contains(&time);
        let speed = if stands {
            0.0
        } else {
            self.station.belt().speed
        };
        Incoming::Belt(BeltState {
            stamp: time,
            speed,
            position: Some(self.travel(time)),
            source: None,
        })
    }

    /// What a robot (index) reports at `time` [s].
    pub(super) fn robot_status(&self, robot: usize, state: RobotState, time: f64) -> Incoming {
        Incoming::Robot(RobotStatus {
            stamp: time,
            name: self.station.robots()[robot].name.clone(),
            state,
            available_at: None,
            task: None,
        })
    }
}
