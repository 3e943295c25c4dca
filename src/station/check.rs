//! What the model requires of a belt, its robots and its classes.

use super::belt::Belt;
use super::class::ItemClass;
use super::robot::{Bin, Robot};
use crate::error::{Error, Result, counted, shown, shown_number, significant};
use crate::kinematics::TravelLaw;
use crate::names::{check_class_name, check_name};

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
/// More bins than this beside one robot are treated as a mistake.
const MOST_BINS: usize = 100;

/// More classes than this on one station are treated as a mistake.
const MOST_CLASSES: usize = 1000;

/// Turns a key such as `robot[1].reach` into the place that messages name.
type Place<'a> = &'a dyn Fn(&str) -> String;

/// Checks the sizes and the speed of the belt.
pub(super) fn belt(belt: &Belt, place: Place) -> Result<()> {
    positive(place, "belt.speed", belt.speed)?;
    positive(place, "belt.length", belt.length)?;
    positive(place, "belt.width", belt.width)
}

/// Checks one robot by itself and against those listed before it, `upstream`; not against the belt,
/// for which see [`lead`].
pub(super) fn robot(robot: &Robot, index: usize, upstream: &[Robot], place: Place) -> Result<()> {
    let key = |field: &str| format!("robot[{index}].{field}");
    position(place, &key("base"), robot.base.x)?;
    position(place, &key("base"), robot.base.y)?;
    bins(robot, &key, place)?;
    position(place, &key("rest"), robot.rest.x)?;
    position(place, &key("rest"), robot.rest.y)?;
    positive(place, &key("reach"), robot.reach)?;
    law(&robot.arm.law, &key, place)?;
    distance(place, &key("lift"), robot.arm.lift)?;
    dwell(place, &key("grasp_time"), robot.grasp_time)?;
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

/// Checks the bins of one robot.
fn bins(robot: &Robot, key: &dyn Fn(&str) -> String, place: Place) -> Result<()> {
    if robot.bins.is_empty() || robot.bins.len() > MOST_BINS {
        return Err(Error::input(
            place(&key("bin")),
            format!(
                "robot `{}` has {} bins",
                shown(&robot.name),
                robot.bins.len()
            ),
            format!("give every robot 1 to {MOST_BINS} bins"),
        ));
    }
    for (i, bin) in robot.bins.iter().enumerate() {
        let of_bin = |field: &str| key(&format!("bin[{i}].{field}"));
        position(place, &of_bin("at"), bin.at.x)?;
        position(place, &of_bin("at"), bin.at.y)?;
        dwell(place, &of_bin("release_time"), bin.release_time)?;
        if let Err(bad) = check_name(&bin.name) {
            let cure = format!(
                "give every bin of a robot its own name; expected {}",
                bad.expected
            );
            return Err(Error::input(place(&of_bin("name")), bad.problem, cure));
        }
        if robot.bins[..i].iter().any(|other| other.name == bin.name) {
            return Err(Error::input(
                place(&of_bin("name")),
                format!(
                    "two bins of robot `{}` are named `{}`",
                    shown(&robot.name),
                    shown(&bin.name)
                ),
                "give every bin of a robot its own name",
            ));
        }
        bin_classes(robot, i, bin, &place(&of_bin("classes")))?;
    }
    Ok(())
}

/// Checks that the classes of bin `index` are in no earlier bin, at `place`.
fn bin_classes(robot: &Robot, index: usize, bin: &Bin, place: &str) -> Result<()> {
    let earlier = &robot.bins[..index];
    let Some(classes) = &bin.classes else {
        let Some(other) = earlier.iter().find(|other| other.classes.is_none()) else {
            return Ok(());
        };
        return Err(Error::input(
            place,
            format!(
                "the bins `{}` and `{}` of robot `{}` both take every class that no other bin names",
                shown(&other.name),
                shown(&bin.name),
                shown(&robot.name)
            ),
            "name the classes of all bins of a robot but one",
        ));
    };
    if classes.is_empty() {
        return Err(Error::input(
            place,
            format!("the bin `{}` takes no class", shown(&bin.name)),
            "name its classes, or leave the key out for every class that no other bin names",
        ));
    }
    for (i, class) in classes.iter().enumerate() {
        if let Err(bad) = check_class_name(class) {
            let cure = format!("expected {}", bad.expected);
            return Err(Error::input(place, bad.problem, cure));
        }
        let twice = classes[..i].contains(class);
        let other = earlier
            .iter()
            .find(|other| other.classes.iter().flatten().any(|c| c == class));
        if twice {
            return Err(Error::input(
                place,
                format!(
                    "the bin `{}` of robot `{}` names class `{}` twice",
                    shown(&bin.name),
                    shown(&robot.name),
                    shown(class)
                ),
                "name it once",
            ));
        }
        if let Some(other) = other {
            return Err(Error::input(
                place,
                format!(
                    "class `{}` goes into bin `{}` and into bin `{}` of robot `{}`",
                    shown(class),
                    shown(&other.name),
                    shown(&bin.name),
                    shown(&robot.name)
                ),
                "give every class of a robot one bin",
            ));
        }
    }
    Ok(())
}

/// Checks the numbers of a travel-time law.
fn law(law: &TravelLaw, key: &dyn Fn(&str) -> String, place: Place) -> Result<()> {
    match law {
        TravelLaw::Constant { speed } => positive(place, &key("speed"), *speed),
        TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration,
        } => {
            positive(place, &key("speed"), *speed)?;
            positive(place, &key("acceleration"), *acceleration)?;
            positive(place, &key("deceleration"), *deceleration)
        }
        TravelLaw::Table(points) => table(points, &place(&key("travel"))),
    }
}

/// Checks the points of a measured table, at `place`.
fn table(points: &[(f64, f64)], place: &str) -> Result<()> {
    let wrong = |problem: String, cure: &str| Err(Error::input(place, problem, cure));
    if points.len() < 2 {
        return wrong(
            format!("the table has {}", counted(points.len(), "point")),
            "give two points [length in m, time in s] or more, the first at length 0",
        );
    }
    let valid = |value: f64| (0.0..=LARGEST).contains(&value);
    for (i, &(length, time)) in points.iter().enumerate() {
        let point = || {
            format!(
                "point {}, [{}, {}],",
                i + 1,
                shown_number(length),
                shown_number(time)
            )
        };
        if !valid(length) || !valid(time) {
            return wrong(
                format!("{} is not a length in m and a time in s", point()),
                "give numbers from 0 to 1e6",
            );
        }
        let Some(before) = i.checked_sub(1).map(|before| points[before]) else {
            if length != 0.0 {
                return wrong(
                    format!("{} is not at length 0", point()),
                    "begin with the time that the shortest move takes: [0.0, t]",
                );
            }
            continue;
        };
        if length - before.0 < SMALLEST {
            return wrong(
                format!("{} is not longer than the one before it", point()),
                "sort the points by length, at least 1e-6 m apart",
            );
        }
        if time < before.1 {
            return wrong(
                format!(
                    "{} takes less time than the shorter path before it",
                    point()
                ),
                "give times that never decrease with the length",
            );
        }
    }
    Ok(())
}

/// Checks the classes of a station.
pub(super) fn classes(classes: &[ItemClass], place: Place) -> Result<()> {
    for (i, class) in classes.iter().enumerate() {
        let key = |field: &str| place(&format!("class[{i}].{field}"));
        if let Err(bad) = check_class_name(&class.name) {
            let cure = format!("give every class a unique name; expected {}", bad.expected);
            return Err(Error::input(key("name"), bad.problem, cure));
        }
        if classes[..i].iter().any(|other| other.name == class.name) {
            return Err(Error::input(
                key("name"),
                format!("two classes are named `{}`", shown(&class.name)),
                "describe every class once",
            ));
        }
        if !(0.0..=LARGEST).contains(&class.value) {
            return Err(Error::input(
                key("value"),
                format!("{} is not a valid value", shown_number(class.value)),
                "give what an item of the class is worth, from 0 to 1e6; for items that are not \
                 to be picked give `wanted = false`",
            ));
        }
    }
    Ok(())
}

/// Checks the number of different classes that a station names.
pub(super) fn class_count(names: usize, place: Place) -> Result<()> {
    if names <= MOST_CLASSES {
        return Ok(());
    }
    Err(Error::input(
        place("class"),
        format!("the station names {names} classes"),
        format!("name at most {MOST_CLASSES} classes, in bins and class tables together"),
    ))
}

/// Checks the number of robots. Call it before the robots are created: a typing mistake such as
/// 1000000000 must not fill the memory.
pub(super) fn count(place: Place, robots: usize) -> Result<()> {
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

/// Whether the arm is faster than a belt of these sizes at this speed [m/s], at every distance.
pub(super) fn has_lead(robot: &Robot, belt: &Belt, belt_speed: f64) -> bool {
    robot.belt_limit(belt) >= belt_speed * LEAD
}

/// Checks that the arm is faster than the belt at every distance, as the model requires. `place`
/// gives the place of a key of the robot.
pub(super) fn lead(place: Place, robot: &Robot, belt: &Belt) -> Result<()> {
    if has_lead(robot, belt, belt.speed) {
        return Ok(());
    }
    let (name, belt_speed) = (shown(&robot.name), shown_number(belt.speed));
    let path = robot.shortest_path(belt);
    let nearest = robot.nearest_place(belt);
    let (from, kind) = match robot.bins.get(nearest) {
        Some(_) if robot.has_only_bin() => ("its bin".to_owned(), "bin"),
        Some(bin) => (format!("its bin `{}`", shown(&bin.name)), "bin"),
        None => ("its rest".to_owned(), "rest"),
    };
    // What the arm gets ahead at over that path: the inverse of the slope of T.
    let arm_speed = shown_number(rounded_down(robot.belt_limit(belt)));
    match robot.arm.law {
        TravelLaw::Trapezoid {
            speed,
            acceleration,
            ..
        } if speed >= belt.speed * LEAD => {
            // T is steep for short paths: v sqrt(c / 2 l) must not exceed 1.
            let c = robot.arm.law.ramp();
            let v = belt.speed * LEAD;
            let needed = rounded_up(0.5 * c * v * v);
            let lift = rounded_up(0.5 * (needed - path) + robot.arm.lift);
            let mut cures = vec![format!("a lift of {lift} m")];
            if path > 0.0 {
                let factor = c * v * v / (2.0 * path);
                let needed = rounded_up(acceleration * factor);
                cures.push(format!(
                    "an acceleration of {needed} m/s^2 (and a deceleration in proportion)"
                ));
                let slower = rounded_down((2.0 * path / c).sqrt() / LEAD);
                cures.push(format!("a belt of {slower} m/s"));
            }
            cures.push(format!("a {kind} farther from the belt"));
            Err(Error::input(
                place("acceleration"),
                format!(
                    "robot `{name}` may have to travel only {} m from {from} to an item, over which \
                     its arm gets ahead at {arm_speed} m/s, but the belt moves at {belt_speed} m/s: it \
                     needs {} m",
                    shown_number(rounded_down(path)),
                    shown_number(needed),
                ),
                format!("any of these would do: {}", cures.join(", ")),
            ))
        }
        TravelLaw::Table(_) => {
            let limit = rounded_down(robot.belt_limit(belt) / LEAD);
            // The last piece goes on for ever, so longer paths do not avoid it.
            let other = match robot.arm.law.steepest(f64::INFINITY) * belt.speed * LEAD < 1.0 {
                true => format!(
                    "a lift or a {kind} farther from the belt that makes the shortest path longer"
                ),
                false => {
                    "a table whose last piece, which holds for all longer paths, is less steep"
                        .to_owned()
                }
            };
            Err(Error::input(
                place("travel"),
                format!(
                    "the table of robot `{name}` is too steep for the belt at {belt_speed} m/s: for \
                     paths of {} m or more, the shortest from {from} to an item, its steepest piece is \
                     an arm at {arm_speed} m/s",
                    shown_number(rounded_down(path)),
                ),
                format!(
                    "every arm must be faster than the belt at every distance; use a belt of at most \
                     {limit} m/s, or {other}"
                ),
            ))
        }
        TravelLaw::Constant { speed } | TravelLaw::Trapezoid { speed, .. } => Err(Error::input(
            place("speed"),
            format!(
                "the arm of robot `{name}` moves at {} m/s, which is not {} than the belt at \
                 {belt_speed} m/s",
                shown_number(speed),
                match speed > belt.speed {
                    true => "faster by one millionth or more",
                    false => "faster",
                },
            ),
            "every arm must be faster than the belt; use a slower belt or a faster arm",
        )),
    }
}

/// `value` to four significant digits, upwards: a cure must suffice.
fn rounded_up(value: f64) -> f64 {
    significant(value, 4, f64::ceil)
}

/// `value` to four significant digits, downwards.
fn rounded_down(value: f64) -> f64 {
    significant(value, 4, f64::floor)
}

/// Checks a speed or length that the closed forms square.
pub(super) fn positive(place: Place, key: &str, value: f64) -> Result<()> {
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
pub(super) fn position(place: Place, key: &str, value: f64) -> Result<()> {
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
pub(super) fn distance(place: Place, key: &str, value: f64) -> Result<()> {
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
pub(super) fn dwell(place: Place, key: &str, value: f64) -> Result<()> {
    if (0.0..=LARGEST).contains(&value) {
        return Ok(());
    }
    Err(Error::input(
        place(key),
        format!("{} is not a valid dwell time", shown_number(value)),
        format!("give seconds, from 0 to {LARGEST:e}"),
    ))
}
