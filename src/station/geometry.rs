//! The validated station: a belt, robots and classes of items.

use super::belt::Belt;
use super::check;
use super::class::ItemClass;
use super::robot::Robot;
use super::sorting::{ClassId, Sorting};
use crate::error::Result;

/// A validated station: the belt and its robots, from upstream to downstream.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    belt: Belt,
    robots: Vec<Robot>,
    classes: Vec<ItemClass>,
    sorting: Sorting,
}

impl Station {
    /// Creates a station after validating the belt and the robots.
    ///
    /// # Errors
    /// If the model forbids a value: a size that is not a positive finite number, an arm that is
    /// not faster than the belt, robots out of order, or a duplicate name.
    pub fn new(belt: Belt, robots: Vec<Robot>) -> Result<Self> {
        Self::checked(belt, robots, Vec::new(), &|key| key.to_owned(), None)
    }

    /// The same station with these classes of items, whose values and whether they are wanted differ
    /// from the default. Replaces those that it had.
    ///
    /// # Errors
    /// If a name occurs twice or is not valid, or a value is negative or not a number.
    pub fn with_classes(self, classes: Vec<ItemClass>) -> Result<Self> {
        let place = |key: &str| key.to_owned();
        Self::checked(self.belt, self.robots, classes, &place, None)
    }

    /// Like [`Station::new`]; `place` turns a key such as `robot[1].reach` into the place that
    /// messages name, for example with the file name and line. An arm that is too slow for the belt
    /// is reported at `too_slow` if given.
    pub(super) fn checked(
        belt: Belt,
        robots: Vec<Robot>,
        classes: Vec<ItemClass>,
        place: &dyn Fn(&str) -> String,
        too_slow: Option<&str>,
    ) -> Result<Self> {
        check::belt(&belt, place)?;
        check::count(place, robots.len())?;
        for (i, robot) in robots.iter().enumerate() {
            check::robot(robot, i, &robots[..i], place)?;
            let key = |field: &str| place(&format!("robot[{i}].{field}"));
            check::lead(
                &|field| too_slow.map_or_else(|| key(field), str::to_owned),
                robot,
                &belt,
            )?;
        }
        check::classes(&classes, place)?;
        let sorting = Sorting::new(&robots, &classes);
        check::class_count(sorting.names().len(), place)?;
        Ok(Self {
            belt,
            robots,
            classes,
            sorting,
        })
    }

    /// The same classes on another belt with other robots.
    fn rebuilt(&self, belt: Belt, robots: Vec<Robot>) -> Result<Self> {
        let place = |key: &str| key.to_owned();
        Self::checked(belt, robots, self.classes.clone(), &place, None)
    }

    /// The belt under the robots.
    pub fn belt(&self) -> &Belt {
        &self.belt
    }

    /// The robots, upstream first.
    pub fn robots(&self) -> &[Robot] {
        &self.robots
    }

    /// The classes whose value or wantedness the station states.
    pub fn classes(&self) -> &[ItemClass] {
        &self.classes
    }

    /// The class with this name; `None` if the station does not state it, so that it has value 1
    /// and is wanted.
    pub fn class(&self, name: &str) -> Option<&ItemClass> {
        self.classes.iter().find(|class| class.name == name)
    }

    /// Whether this is a station of the paper's model alone: [plain](Robot::is_plain) robots and no
    /// classes.
    pub fn is_plain(&self) -> bool {
        self.classes.is_empty() && self.robots.iter().all(Robot::is_plain)
    }

    /// The class with this name on this station.
    pub fn class_id(&self, name: Option<&str>) -> ClassId {
        self.sorting.class(name)
    }

    /// The names of all classes that the bins or the station's classes mention, sorted.
    pub fn class_names(&self) -> &[String] {
        self.sorting.names()
    }

    /// The bin of robot `robot` for items of `class`; `None` if the robot cannot take them.
    #[inline]
    pub fn bin_for(&self, robot: usize, class: ClassId) -> Option<u16> {
        self.sorting.bin(robot, class)
    }

    /// Whether robot `robot` has a bin for items of `class`.
    #[inline]
    pub(crate) fn has_bin_for(&self, robot: usize, class: ClassId) -> bool {
        self.sorting.has_bin(robot, class)
    }

    /// What an item of `class` is worth more than another item, as a factor of its weight.
    pub fn value_of(&self, class: ClassId) -> f64 {
        self.sorting.value(class)
    }

    /// Whether some items are left on the belt on purpose, because their class is not wanted or no
    /// robot has a bin for it.
    pub fn leaves_items(&self) -> bool {
        self.sorting.leaves_items()
    }

    /// Whether items of `class` are to be picked, and some robot has a bin for them. Other items
    /// ride to the end of the belt.
    #[inline]
    pub fn takes(&self, class: ClassId) -> bool {
        self.sorting.takes(class)
    }

    /// Whether every arm is faster than a belt with this speed [m/s].
    pub fn is_faster_than(&self, belt_speed: f64) -> bool {
        let belt = &self.belt;
        self.robots
            .iter()
            .all(|robot| check::has_lead(robot, belt, belt_speed))
    }

    /// The same station with another belt speed [m/s].
    ///
    /// # Errors
    /// If the speed is not positive or not below that of every arm.
    pub fn with_belt_speed(&self, speed: f64) -> Result<Self> {
        let belt = Belt { speed, ..self.belt };
        let (robots, classes) = (self.robots.clone(), self.classes.clone());
        let place = |key: &str| match key {
            "belt.speed" => "belt speed".to_owned(),
            other => other.to_owned(),
        };
        Self::checked(belt, robots, classes, &place, None)
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
        self.rebuilt(self.belt, self.robots.iter().map(robot).collect())
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
            robots.push(robot.moved(moved));
        }
        let belt = Belt {
            length: self.belt.length + moved,
            ..self.belt
        };
        self.rebuilt(belt, robots)
    }

    /// The speed [m/s] of the slowest arm; the belt must be slower. For an arm that accelerates or
    /// follows a table it is the slowest at which the arm gets ahead anywhere on the belt, near its
    /// places: the inverse of the steepest slope of its travel-time law there.
    pub fn slowest_arm(&self) -> f64 {
        self.robots
            .iter()
            .map(|robot| robot.belt_limit(&self.belt))
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::{self, Arm};
    use nalgebra::Point2;

    fn robot(name: &str, x: f64) -> Robot {
        Robot::new(
            name,
            Point2::new(x, -0.6),
            Point2::new(x, -0.5),
            0.8,
            Arm::constant(0.5),
        )
        .with_dwell(0.1, 0.1)
    }
    const BELT: Belt = Belt {
        speed: 0.05,
        length: 4.0,
        width: 1.0,
    };

    #[test]
    fn window_ends_are_meetings_at_the_workspace_edge() {
        let robot = robot("a", 1.3);
        let (open, close) = robot.departure_window(&BELT, 0, 0.0, 0.1).unwrap();
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
        assert!(robot.departure_window(&BELT, 0, 0.0, 0.3).is_none());
        // Beyond the workspace: the robot could only have met it before time 0.
        assert!(robot.departure_window(&BELT, 0, 5.0, 0.0).is_none());
    }

    #[test]
    fn spacing_and_reach_move_what_belongs_to_them() {
        let station = Station::new(BELT, vec![robot("a", 1.0), robot("b", 2.5)]).unwrap();
        let wider = station.with_spacing(2.0).unwrap();
        assert_eq!(wider.robots()[1].base.x, 3.0);
        assert_eq!(wider.robots()[1].bins[0].at.x, 3.0);
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
        let robot = Robot::new(
            "a",
            Point2::new(1.0, 1.0),
            Point2::new(-1.0, 0.003405902764744542),
            2.899362981725246,
            Arm::constant(6.499453492590247),
        );
        let window = robot.departure_window(&belt, 0, -396416.67683246685, -0.0011175175692485723);
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
                // The arm moves at 0.5 m/s.
                true if speed < 0.5 => "not faster by one millionth or more than the belt",
                true => "not faster than the belt",
                false => "is not a usable size",
            };
            assert!(message.contains(problem), "{speed}: {message}");
        }
    }
}
