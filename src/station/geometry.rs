//! The belt, the robots and the validated station.

use crate::error::{Error, Result, shown, shown_number};
use crate::kinematics;
use crate::names::check_name;
use nalgebra::{Point2, Vector2};

/// Larger lengths, times and speeds [m, s, m/s] are rejected: no real line has them, and the closed
/// forms square them.
const LARGEST: f64 = 1e6;
/// Smaller speeds and lengths are rejected for the same reason.
const SMALLEST: f64 = 1e-6;
/// Minimum ratio of arm speed to belt speed. The closed forms divide by the difference of the
/// squared speeds and need a few significant digits of it; no real arm is this close to the speed
/// of its belt.
const LEAD: f64 = 1.0 + 1e-6;
/// More robots than this on one belt are treated as a typing mistake.
const MOST_ROBOTS: usize = 100;

/// The conveyor. It covers `0 <= x <= length`, `|y| <= width / 2` and moves along +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belt {
    /// Speed along +x [m/s].
    pub speed: f64,
    /// Length along x [m].
    pub length: f64,
    /// Width along y [m].
    pub width: f64,
}

/// One arm beside the belt.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Name, unique in the station.
    pub name: String,
    /// Base, the centre of the workspace [m].
    pub base: Point2<f64>,
    /// Bin, which is also the resting position [m].
    pub bin: Point2<f64>,
    /// Radius of the workspace around the base [m].
    pub reach: f64,
    /// End-effector speed [m/s], greater than that of the belt.
    pub speed: f64,
    /// Dwell time at the grasp [s].
    pub grasp_time: f64,
    /// Dwell time at the release [s].
    pub release_time: f64,
}

impl Robot {
    /// Departure window `[open, close]` [s] of an item that was at (`x0`, `y`) [m] at time 0: the
    /// departure times at which this robot still meets it inside its workspace, ends included. The
    /// item is in the robot's *extended workspace* (Jermann et al., section on the custom
    /// environment) exactly while the departure time lies in the window. `None` if the robot can
    /// never reach the item.
    pub fn departure_window(&self, belt: &Belt, x0: f64, y: f64) -> Option<(f64, f64)> {
        let (x_in, x_out) =
            kinematics::meeting_range(self.base.x, self.base.y, self.reach, y, belt.length)?;
        let bin = (self.bin.x, self.bin.y);
        let close = kinematics::departure_time(x_out, x0, y, bin, belt.speed, self.speed);
        if close < 0.0 {
            return None;
        }
        let open = kinematics::departure_time(x_in, x0, y, bin, belt.speed, self.speed).max(0.0);
        // Rounding can swap the ends of a window that is barely more than a point. The model has no
        // such window, so it becomes a point.
        Some((open.min(close), close))
    }
}

/// A validated station: the belt and its robots, from upstream to downstream.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    belt: Belt,
    robots: Vec<Robot>,
}

impl Station {
    /// Creates a station after validating the belt and the robots.
    ///
    /// # Errors
    /// If the model forbids a value: a size that is not a positive finite number, an arm that is
    /// not faster than the belt, robots out of order, or a duplicate name.
    pub fn new(belt: Belt, robots: Vec<Robot>) -> Result<Self> {
        Self::checked(belt, robots, &|key| key.to_owned())
    }

    /// Like [`Station::new`]; `place` turns a key such as `robot[1].reach` into the place that
    /// messages name, for example with the file name and line.
    pub(super) fn checked(
        belt: Belt,
        robots: Vec<Robot>,
        place: &dyn Fn(&str) -> String,
    ) -> Result<Self> {
        for (key, value) in [
            ("belt.speed", belt.speed),
            ("belt.length", belt.length),
            ("belt.width", belt.width),
        ] {
            positive(place, key, value)?;
        }
        check_count(place, robots.len())?;
        for (i, robot) in robots.iter().enumerate() {
            check_robot(robot, i, &robots[..i], &belt, place)?;
        }
        Ok(Self { belt, robots })
    }

    /// The belt under the robots.
    pub fn belt(&self) -> &Belt {
        &self.belt
    }

    /// The robots, upstream first.
    pub fn robots(&self) -> &[Robot] {
        &self.robots
    }

    /// Whether every arm is faster than a belt with this speed [m/s].
    pub fn is_faster_than(&self, belt_speed: f64) -> bool {
        self.robots.iter().all(|robot| has_lead(robot, belt_speed))
    }

    /// The same station with another belt speed [m/s].
    ///
    /// # Errors
    /// If the speed is not positive or not below that of every arm.
    pub fn with_belt_speed(&self, speed: f64) -> Result<Self> {
        let belt = Belt { speed, ..self.belt };
        Self::checked(belt, self.robots.clone(), &|key| match key {
            "belt.speed" => "belt speed".to_owned(),
            other => other.to_owned(),
        })
    }

    /// The same station with this reach [m] for every robot. The belt does not change.
    ///
    /// # Errors
    /// If the reach is not a valid length.
    pub fn with_reach(&self, reach: f64) -> Result<Self> {
        let robot = |robot: &Robot| Robot {
            reach,
            ..robot.clone()
        };
        Self::new(self.belt, self.robots.iter().map(robot).collect())
    }

    /// The same robots with their bases this far apart along the belt [m]. The first robot stays
    /// where it is, the bins move with their robots, and the end of the belt moves with the last
    /// robot.
    ///
    /// # Errors
    /// If the spacing is not a valid distance.
    pub fn with_spacing(&self, spacing: f64) -> Result<Self> {
        let first = self.robots[0].base.x;
        let mut moved = 0.0;
        let mut robots = Vec::with_capacity(self.robots.len());
        for (i, robot) in self.robots.iter().enumerate() {
            moved = first + i as f64 * spacing - robot.base.x;
            robots.push(Robot {
                base: robot.base + Vector2::new(moved, 0.0),
                bin: robot.bin + Vector2::new(moved, 0.0),
                ..robot.clone()
            });
        }
        let belt = Belt {
            length: self.belt.length + moved,
            ..self.belt
        };
        Self::new(belt, robots)
    }

    /// The end-effector speed [m/s] of the slowest arm; the belt must be slower.
    pub fn slowest_arm(&self) -> f64 {
        self.robots
            .iter()
            .map(|robot| robot.speed)
            .fold(f64::INFINITY, f64::min)
    }
}

fn check_robot(
    robot: &Robot,
    index: usize,
    upstream: &[Robot],
    belt: &Belt,
    place: &dyn Fn(&str) -> String,
) -> Result<()> {
    let key = |field: &str| format!("robot[{index}].{field}");
    for (field, value) in [
        ("base", robot.base.x),
        ("base", robot.base.y),
        ("bin", robot.bin.x),
        ("bin", robot.bin.y),
    ] {
        position(place, &key(field), value)?;
    }
    positive(place, &key("reach"), robot.reach)?;
    positive(place, &key("speed"), robot.speed)?;
    dwell(place, &key("grasp_time"), robot.grasp_time)?;
    dwell(place, &key("release_time"), robot.release_time)?;
    check_arm_speed(&|| place(&key("speed")), robot, belt)?;
    if let Err(bad) = check_name(&robot.name) {
        let cure = format!("give every robot a unique name; expected {}", bad.expected);
        return Err(Error::input(place(&key("name")), bad.problem, cure));
    }
    if upstream.iter().any(|other| other.name == robot.name) {
        return Err(Error::input(
            place(&key("name")),
            format!("two robots are named `{}`", shown(&robot.name)),
            "give every robot a unique name",
        ));
    }
    if let Some(before) = upstream.last()
        && robot.base.x < before.base.x
    {
        return Err(Error::input(
            place(&key("base")),
            format!(
                "robot `{}` at x = {} m is upstream of `{}` at x = {} m, which is listed before it",
                shown(&robot.name),
                shown_number(robot.base.x),
                shown(&before.name),
                shown_number(before.base.x)
            ),
            "list the robots from upstream to downstream, by base x",
        ));
    }
    Ok(())
}

/// Checks the number of robots. Call it before the robots are created: a typing mistake such as
/// 1000000000 must not fill the memory.
pub(super) fn check_count(place: &dyn Fn(&str) -> String, robots: usize) -> Result<()> {
    if (1..=MOST_ROBOTS).contains(&robots) {
        return Ok(());
    }
    Err(Error::input(
        place("robot"),
        if robots == 0 {
            "the station has no robots".to_owned()
        } else {
            format!("{robots} robots on one line")
        },
        format!("give 1 to {MOST_ROBOTS} robots"),
    ))
}

fn has_lead(robot: &Robot, belt_speed: f64) -> bool {
    robot.speed >= belt_speed * LEAD
}

/// Checks that the arm is faster than the belt, as the model requires.
pub(super) fn check_arm_speed(
    place: &dyn Fn() -> String,
    robot: &Robot,
    belt: &Belt,
) -> Result<()> {
    if has_lead(robot, belt.speed) {
        return Ok(());
    }
    Err(Error::input(
        place(),
        format!(
            "the arm of robot `{}` moves at {} m/s, which is not faster than the belt at {} m/s",
            shown(&robot.name),
            shown_number(robot.speed),
            shown_number(belt.speed)
        ),
        "every arm must be faster than the belt; use a slower belt or a faster arm",
    ))
}

/// Checks a speed or length that the closed forms square.
pub(super) fn positive(place: &dyn Fn(&str) -> String, key: &str, value: f64) -> Result<()> {
    if (SMALLEST..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::input(
        place(key),
        format!("{} is not a usable size", shown_number(value)),
        format!("give a number in SI units (m, s, m/s) from {SMALLEST:e} to {LARGEST:e}"),
    ))
}

/// Checks a coordinate.
pub(super) fn position(place: &dyn Fn(&str) -> String, key: &str, value: f64) -> Result<()> {
    if (-LARGEST..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::input(
        place(key),
        format!("{} is not a valid position", shown_number(value)),
        format!("give metres, within +/-{LARGEST:e}"),
    ))
}

/// Checks a length that may be 0.
pub(super) fn distance(place: &dyn Fn(&str) -> String, key: &str, value: f64) -> Result<()> {
    if (0.0..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::input(
        place(key),
        format!("{} is not a valid length", shown_number(value)),
        format!("give metres, from 0 to {LARGEST:e}"),
    ))
}

/// Checks a time that may be 0.
pub(super) fn dwell(place: &dyn Fn(&str) -> String, key: &str, value: f64) -> Result<()> {
    if (0.0..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::input(
        place(key),
        format!("{} is not a valid dwell time", shown_number(value)),
        format!("give seconds, from 0 to {LARGEST:e}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(name: &str, x: f64) -> Robot {
        Robot {
            name: name.into(),
            base: Point2::new(x, -0.6),
            bin: Point2::new(x, -0.5),
            reach: 0.8,
            speed: 0.5,
            grasp_time: 0.1,
            release_time: 0.1,
        }
    }
    const BELT: Belt = Belt {
        speed: 0.05,
        length: 4.0,
        width: 1.0,
    };

    #[test]
    fn window_ends_are_meetings_at_the_workspace_edge() {
        let robot = robot("a", 1.3);
        let (open, close) = robot.departure_window(&BELT, 0.0, 0.1).unwrap();
        for (t, edge) in [(open, -1.0), (close, 1.0)] {
            let tau = kinematics::travel_time(0.05 * t - 1.3, 0.6, 0.05, 0.5);
            let meet = 0.05 * (t + tau);
            let half = (0.8f64.powi(2) - 0.7f64.powi(2)).sqrt();
            assert!((meet - (1.3 + edge * half)).abs() < 1e-12);
        }
    }

    #[test]
    fn no_window_for_what_is_out_of_reach_or_past() {
        let robot = robot("a", 1.3);
        assert!(robot.departure_window(&BELT, 0.0, 0.3).is_none());
        // Beyond the workspace: the robot could only have met it before time 0.
        assert!(robot.departure_window(&BELT, 5.0, 0.0).is_none());
    }

    #[test]
    fn spacing_and_reach_move_what_belongs_to_them() {
        let station = Station::new(BELT, vec![robot("a", 1.0), robot("b", 2.5)]).unwrap();
        let wider = station.with_spacing(2.0).unwrap();
        assert_eq!(wider.robots()[1].base.x, 3.0);
        assert_eq!(wider.robots()[1].bin.x, 3.0);
        assert_eq!(wider.belt().length, 4.5);
        assert_eq!(station.with_spacing(1.5).unwrap(), station);
        assert!(
            station
                .with_reach(0.9)
                .unwrap()
                .robots()
                .iter()
                .all(|r| r.reach == 0.9)
        );
        assert!(station.with_reach(-1.0).is_err() && station.with_spacing(f64::NAN).is_err());
    }

    #[test]
    fn a_window_shorter_than_rounding_is_a_point() {
        let belt = Belt {
            speed: 6.499440208623188,
            length: 1e-6,
            width: 0.01,
        };
        let robot = Robot {
            base: Point2::new(1.0, 1.0),
            bin: Point2::new(-1.0, 0.003405902764744542),
            reach: 2.899362981725246,
            speed: 6.499453492590247,
            ..robot("a", 1.0)
        };
        let window = robot.departure_window(&belt, -396416.67683246685, -0.0011175175692485723);
        assert!(window.is_some_and(|(open, close)| open <= close));
    }

    #[test]
    fn order_names_and_speeds_are_checked() {
        assert!(Station::new(BELT, vec![robot("a", 1.0), robot("b", 1.0)]).is_ok());
        for (robots, word) in [
            (vec![], "no robot"),
            (vec![robot("a", 2.0), robot("b", 1.0)], "upstream"),
            (vec![robot("a", 1.0), robot("a", 2.0)], "two robots"),
        ] {
            let message = Station::new(BELT, robots).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        let station = Station::new(BELT, vec![robot("a", 1.0)]).unwrap();
        assert!(station.with_belt_speed(0.4999).is_ok());
        // Here the difference of the squares has lost all significant digits.
        for speed in [
            0.5f64.next_down(),
            0.5,
            0.6,
            0.0,
            -1.0,
            f64::NAN,
            f64::INFINITY,
        ] {
            let message = station.with_belt_speed(speed).unwrap_err().to_string();
            let is_speed = speed.is_finite() && speed > 0.0;
            let problem = match is_speed {
                true => "not faster than the belt",
                false => "is not a usable size",
            };
            assert!(message.contains(problem), "{speed}: {message}");
        }
    }
}
