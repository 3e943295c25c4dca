//! Warnings about station values that the model allows but that are implausible.

use super::geometry::Station;
use super::robot::Robot;
use crate::error::{known_names, listed, rounded, shown, shown_number};
use crate::kinematics::TravelLaw;
use crate::kinematics::distance;
use crate::plausible::{
    ACCELERATION, ARM_SPEED, BASE_GAP, BELT_LENGTH, BELT_SPEED, BELT_WIDTH, DWELL, LENGTHS, LIFT,
    PATH, REACH, TRAVEL_TIME, Warning, question,
};

/// A camera further upstream than this [m] does not belong to this line.
const FURTHEST_UPSTREAM: f64 = 25.0;

impl Station {
    /// The implausible values of the station, which the user knows as `name`. Each kind of warning
    /// is given only for the first robot that it concerns.
    pub fn warnings(&self, name: &str) -> Vec<Warning> {
        let belt = self.belt();
        let place = |key: &str| format!("{name}: {key}");
        let mut list: Vec<Warning> = [
            (&BELT_SPEED, "belt.speed", belt.speed),
            (&BELT_LENGTH, "belt.length", belt.length),
            (&BELT_WIDTH, "belt.width", belt.width),
        ]
        .into_iter()
        .filter_map(|(quantity, key, value)| quantity.check(&place(key), value))
        .collect();
        let robots = self.robots();
        let first = |check: &dyn Fn(&Robot, &str) -> Option<Warning>| {
            robots
                .iter()
                .find_map(|robot| check(robot, &place(&format!("robot `{}`", shown(&robot.name)))))
        };
        list.extend(first(&|robot, at| {
            REACH.check(&format!("{at}, reach"), robot.reach)
        }));
        list.extend(first(&check_speed));
        list.extend(first(&|robot, at| check_law(&robot.arm.law, at)));
        list.extend(first(&check_lift));
        list.extend(first(&|robot, at| {
            DWELL.check(&format!("{at}, grasp_time"), robot.grasp_time)
        }));
        list.extend(first(&|robot, at| {
            let mut bins = robot.bins.iter();
            bins.find_map(|bin| DWELL.check(&format!("{at}, release_time"), bin.release_time))
        }));
        list.extend(first(&|robot, at| self.check_base(robot, at)));
        list.extend(first(&check_bin));
        let gaps = robots
            .windows(2)
            .map(|pair| pair[1].base.x - pair[0].base.x);
        let widest = gaps.fold(0.0, f64::max);
        list.extend(BASE_GAP.check(&place("bases along the belt"), widest));
        list.extend(self.check_classes(&place("class")));
        list.extend(self.check_unwanted(&place("class")));
        list.extend(first(&|robot, at| self.check_unused_bin(robot, at)));
        list
    }

    /// Warns about a class that is worth something, but not wanted.
    fn check_unwanted(&self, at: &str) -> Option<Warning> {
        let mut classes = self.classes().iter();
        let class = classes.find(|class| !class.wanted && class.value != 1.0)?;
        let problem = format!(
            "class `{}` has a value, but is not wanted: nothing of it is ever picked",
            shown(&class.name)
        );
        let cure = "leave out `value`, or `wanted = false`";
        Some(Warning::new(at, problem, cure))
    }

    /// Warns about a bin of `robot` that nothing goes into.
    fn check_unused_bin(&self, robot: &Robot, at: &str) -> Option<Warning> {
        let is_unwanted = |name: &String| self.class(name).is_some_and(|class| !class.wanted);
        let mut named = robot.bins.iter().filter_map(|bin| {
            let classes = bin.classes.as_ref()?;
            Some((bin, classes))
        });
        let (bin, classes) =
            named.find(|(_, classes)| !classes.is_empty() && classes.iter().all(is_unwanted))?;
        let problem = format!(
            "nothing goes into bin `{}`: {} not wanted",
            shown(&bin.name),
            match classes.as_slice() {
                [only] => format!("its class `{}` is", shown(only)),
                _ => "all of its classes are".to_owned(),
            }
        );
        let cure = "leave out `wanted = false` of a class, or the bin";
        Some(Warning::new(at, problem, cure))
    }

    /// Warns about a class that the station describes and wants, but that no bin takes.
    fn check_classes(&self, at: &str) -> Option<Warning> {
        let untaken = self.classes().iter().filter(|class| class.wanted);
        let untaken = untaken.filter(|class| !self.takes(self.class_id(Some(&class.name))));
        let names: Vec<&str> = untaken.map(|class| class.name.as_str()).collect();
        let first = names.first()?;
        let bins = self.robots().iter().flat_map(|robot| &robot.bins);
        let named: Vec<&str> = bins
            .flat_map(|bin| bin.classes.iter().flatten())
            .map(String::as_str)
            .collect();
        let quoted: Vec<String> = names
            .iter()
            .map(|name| format!("`{}`", shown(name)))
            .collect();
        let problem = match quoted.as_slice() {
            [only] => {
                format!("no robot has a bin for class {only}, whose items will stay on the belt")
            }
            _ => format!(
                "no robot has a bin for the classes {}, whose items will stay on the belt",
                listed(&quoted)
            ),
        };
        let cure = format!(
            "name {} at a bin ({}), or give {} `wanted = false`",
            if names.len() == 1 {
                "the class"
            } else {
                "each"
            },
            known_names(first, &named),
            if names.len() == 1 { "it" } else { "them" },
        );
        Some(Warning::new(at, problem, cure))
    }

    /// Warns about a robot that cannot reach the belt.
    fn check_base(&self, robot: &Robot, at: &str) -> Option<Warning> {
        let belt = self.belt();
        let touches = |x: f64, y: f64, reach: f64| {
            let (dx, dy) = (x - x.clamp(0.0, belt.length), y.abs() - belt.width / 2.0);
            distance(dx, dy.max(0.0)) <= reach
        };
        let (x, y) = (robot.base.x, robot.base.y);
        if touches(x, y, robot.reach) {
            return None;
        }
        let size = x.abs().max(y.abs());
        let problem = format!(
            "its base at ({}, {}) m is farther from the belt than its reach of {} m{}",
            shown_number(x),
            shown_number(y),
            shown_number(robot.reach),
            question(size, "m", LENGTHS, |factor| {
                size > 5.0 && slips(x, y, factor).any(|(x, y)| touches(x, y, robot.reach))
            }),
        );
        let cure = "give base and reach in metres, y from the belt's centre line; or remove the \
                    robot, which cannot pick anything";
        Some(Warning::new(format!("{at}, base"), problem, cure))
    }

    /// Warns about an implausible camera position `x` [m], which comes from `place`.
    pub fn check_camera(&self, place: &str, x: f64) -> Option<Warning> {
        let length = self.belt().length;
        let fits = |x: f64| (-FURTHEST_UPSTREAM..=length).contains(&x);
        if fits(x) || !x.is_finite() {
            return None;
        }
        let problem = format!(
            "a camera at {} m is not plausible along a belt from 0 to {} m{}",
            shown_number(x),
            shown_number(length),
            question(x, "m", LENGTHS, |factor| fits(x * factor)),
        );
        let cure = "give the position along the belt in metres, negative upstream of its start; \
                    a camera beyond its end never sees an item";
        Some(Warning::new(place, problem, cure))
    }
}

/// The point (x, y) with both coordinates converted from another unit, or only the larger one.
fn slips(x: f64, y: f64, factor: f64) -> impl Iterator<Item = (f64, f64)> {
    let one = match x.abs() > y.abs() {
        true => (x * factor, y),
        false => (x, y * factor),
    };
    [(x * factor, y * factor), one].into_iter()
}

impl Robot {
    /// The implausible values of the arm, at `at`.
    pub(crate) fn check_arm(&self, at: &str) -> Vec<Warning> {
        let checks = [
            check_speed(self, at),
            check_law(&self.arm.law, at),
            check_lift(self, at),
        ];
        checks.into_iter().flatten().collect()
    }
}

/// Warns about an implausible speed of the arm.
fn check_speed(robot: &Robot, at: &str) -> Option<Warning> {
    match robot.arm.law.top_speed() {
        Some(speed) => ARM_SPEED.check(&format!("{at}, speed"), speed),
        None => {
            let slow = ARM_SPEED.check(&format!("{at}, travel"), robot.cruising_speed())?;
            Some(Warning {
                problem: format!(
                    "a move of {} m takes {} s by the table: {}",
                    shown_number(robot.reach),
                    rounded(robot.crossing_time(), 6),
                    slow.problem
                ),
                cure: "give lengths in metres and times in seconds; if the table is right, ignore \
                       this warning"
                    .into(),
                ..slow
            })
        }
    }
}

/// Warns about an implausible lift.
fn check_lift(robot: &Robot, at: &str) -> Option<Warning> {
    LIFT.check(&format!("{at}, lift"), robot.arm.lift)
}

/// Warns about an implausible acceleration or table of travel times.
fn check_law(law: &TravelLaw, at: &str) -> Option<Warning> {
    match law {
        TravelLaw::Constant { .. } => None,
        TravelLaw::Trapezoid {
            acceleration,
            deceleration,
            ..
        } => ACCELERATION
            .check(&format!("{at}, acceleration"), *acceleration)
            .or_else(|| ACCELERATION.check(&format!("{at}, deceleration"), *deceleration)),
        TravelLaw::Table(points) => points.iter().find_map(|(length, time)| {
            let at = format!("{at}, travel");
            let length = PATH.check(&at, *length);
            length.or_else(|| TRAVEL_TIME.check(&at, *time))
        }),
    }
}

/// Warns about a bin, or a resting position, that its robot cannot reach.
fn check_bin(robot: &Robot, at: &str) -> Option<Warning> {
    let away = |bin: (f64, f64)| distance(bin.0 - robot.base.x, bin.1 - robot.base.y);
    // Rounding must not cause a warning about a bin exactly at the limit.
    let within = |bin| away(bin) <= robot.reach * (1.0 + 1e-9);
    let only = robot.has_only_bin();
    let bins = robot.bins.iter();
    let bins = bins.map(|bin| ((bin.at.x, bin.at.y), Some(&bin.name)));
    let rest = ((robot.rest.x, robot.rest.y), None);
    let (bin, name) = bins.chain([rest]).find(|(bin, _)| !within(*bin))?;
    let size = bin.0.abs().max(bin.1.abs());
    let which = match name {
        None => "rest".to_owned(),
        Some(_) if only => "bin".to_owned(),
        Some(name) => format!("bin `{}`", shown(name)),
    };
    let problem = format!(
        "its {which} is {:.3} m from its base, beyond its reach of {} m{}",
        away(bin),
        shown_number(robot.reach),
        question(size, "m", LENGTHS, |factor| {
            slips(bin.0, bin.1, factor).any(within)
        }),
    );
    let cure =
        "give base, bins, rest and reach in metres, with bins and rest within reach of the base";
    Some(Warning::new(format!("{at}, {which}"), problem, cure))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Arm;
    use crate::station::{BUILT_INS, Belt};
    use nalgebra::Point2;

    fn paper() -> Station {
        BUILT_INS[0].station(None).unwrap()
    }

    /// Warnings for the station with its belt or its first robot changed.
    fn changed(belt: impl Fn(&mut Belt), robot: impl Fn(&mut Robot)) -> Vec<Warning> {
        let (mut its_belt, mut robots) = (*paper().belt(), paper().robots().to_vec());
        belt(&mut its_belt);
        robot(&mut robots[0]);
        Station::new(its_belt, robots).unwrap().warnings("s")
    }

    #[test]
    fn slips_are_warned_of_and_built_in_stations_are_not() {
        for built_in in BUILT_INS {
            for robots in [1, 2, 12] {
                let station = built_in.station(Some(robots)).unwrap();
                assert_eq!(station.warnings("s"), []);
            }
        }
        let same = |_: &mut Belt| {};
        let none = |_: &mut Robot| {};
        for (warnings, words) in [
            (
                changed(|belt| belt.width = 600.0, none),
                &["belt.width", "millimetres"][..],
            ),
            (
                changed(|belt| belt.length = 4200.0, none),
                &["belt.length", "millimetres"],
            ),
            (
                changed(same, |r| r.reach = 565.0),
                &["`r1`, reach", "0.565 m"],
            ),
            (
                changed(same, |r| r.arm = Arm::constant(500.0)),
                &["`r1`, speed", "millimetres per second"],
            ),
            (
                changed(same, |r| r.grasp_time = 100.0),
                &["grasp_time", "milliseconds"],
            ),
            (
                changed(same, |r| r.bins[0].release_time = 80.0),
                &["release_time", "0.08 s"],
            ),
            (
                changed(same, |r| r.base.y = -625.0),
                &["`r1`, base", "millimetres"],
            ),
            (
                changed(same, |r| {
                    *r = r.clone().with_only_bin(Point2::new(1300.0, -525.0))
                }),
                &["`r1`, bin", "millimetres"],
            ),
            (
                changed(same, |r| {
                    r.reach = 0.565;
                    *r = r
                        .clone()
                        .with_only_bin(r.base + nalgebra::Vector2::new(1.4, 0.1));
                }),
                &["bin is 1.4", "0.565 m"],
            ),
        ] {
            let texts: Vec<String> = warnings.iter().map(Warning::to_string).collect();
            let all = |text: &&String| words.iter().all(|word| text.contains(word));
            assert!(
                texts.iter().any(|text| all(&text)),
                "{words:?} not in {texts:?}"
            );
        }
    }

    #[test]
    fn a_camera_stands_along_the_belt_or_upstream_of_it() {
        let station = paper();
        for x in [-3.0, 0.0, 0.5, 4.2] {
            assert_eq!(station.check_camera("'camera_x'", x), None);
        }
        for (x, word) in [
            (300.0, "300 mm is 0.3 m"),
            (-500.0, "-0.5 m"),
            (5.0, "never sees an item"),
        ] {
            let text = station.check_camera("'camera_x'", x).unwrap().to_string();
            assert!(text.contains(word), "{text}");
        }
    }
}
