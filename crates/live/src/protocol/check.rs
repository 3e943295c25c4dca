//! Checks of values beyond their types: ranges of numbers, valid texts.

use super::incoming::{Detection, Incoming};
use super::rejection::{Rejected, Rejection};
use super::session::{Hello, Role};
use pickline::error::shown_number;
use pickline::names::check_name;
use pickline::plausible::{
    ANGLES, BELT_SPEED, ITEM_AREA, ITEM_PLACE, LENGTHS, SHARES, STAMPS, VARIANCES, question,
};
use serde_json::{Map, Value};

/// Largest timestamp [s]: seconds since 1970 reach it in some thousand years.
pub(super) const LARGEST_STAMP: f64 = 1e11;
/// Largest position on a belt [m].
const LARGEST_POSITION: f64 = 1e6;
/// How far upstream of the belt's start a camera may see [m].
const FURTHEST_UPSTREAM: f64 = 250.0;
/// Largest speed of a belt [m/s].
const LARGEST_SPEED: f64 = 10.0;
/// Largest area of an item [cm^2].
const LARGEST_AREA: f64 = 1e6;
/// Largest weight.
const LARGEST_WEIGHT: f64 = 1e12;
/// Largest variance of a position [m^2]: three standard deviations are then 0.6 m.
const LARGEST_VARIANCE: f64 = 0.04;
/// Largest angle [rad]: a full turn is 6.3, so larger values are degrees.
const LARGEST_ANGLE: f64 = 7.0;
/// Largest length and height of an item [m].
const LARGEST_EXTENT: f64 = 10.0;
/// Maximum size of a detection's `data` as JSON [bytes].
const LONGEST_DATA: usize = 4096;
/// Present timestamps in seconds since 1970 [s], to recognize other units.
const THESE_DAYS: std::ops::RangeInclusive<f64> = 1e9..=1e10;

/// Checks the values of a message to the node that was not decoded from a line. [`decode`] checks
/// those of a line.
///
/// [`decode`]: super::decode
///
/// # Errors
/// A value is out of its range, or a text is not a valid name.
pub(crate) fn check_values(message: &Incoming) -> Result<(), Rejected> {
    stamp("stamp", message.stamp())?;
    match message {
        Incoming::Detection(detection) => check_detection(detection),
        Incoming::Belt(belt) => {
            let source = belt.source.as_ref();
            source.map_or(Ok(()), |source| text("source", source))?;
            let speeds = -LARGEST_SPEED..=LARGEST_SPEED;
            let meant = |speed: f64| BELT_SPEED.question(speed.abs());
            within("speed", belt.speed, speeds, "a belt speed [m/s]", meant)?;
            let places = -1e12..=1e12;
            let what = "a belt position [m]";
            optional("position", belt.position, places, what, nothing)
        }
        Incoming::Robot(robot) => text("name", &robot.name),
        // Extra fields must not cause the loss of a result: see `doubts`.
        Incoming::Result(_) => Ok(()),
        Incoming::Pause(order)
        | Incoming::Resume(order)
        | Incoming::Drain(order)
        | Incoming::Stop(order) => order
            .robot
            .as_ref()
            .map_or(Ok(()), |name| text("robot", name)),
        Incoming::Ack(_) | Incoming::Tick { .. } => Ok(()),
    }
}

/// Checks the values of a hello.
pub(super) fn check_hello(hello: &Hello) -> Result<(), Rejected> {
    hello.stamp.map_or(Ok(()), |time| stamp("stamp", time))?;
    text("name", &hello.name)?;
    for robot in &hello.robots {
        text("robots", robot)?;
    }
    match (hello.role, hello.robots.is_empty()) {
        (Role::Robot, true) => Err(wrong(
            "robots",
            "is empty",
            "the names of the robots that a peer with the role `robot` speaks for",
        )),
        (Role::Camera | Role::Encoder | Role::Operator | Role::Observer, false) => Err(wrong(
            "robots",
            &format!("is given by a peer with the role `{}`", hello.role.name()),
            "robots only from a peer with the role `robot`",
        )),
        _ => Ok(()),
    }
}

fn check_detection(detection: &Detection) -> Result<(), Rejected> {
    for (name, value) in [
        ("id", &detection.id),
        ("class", &detection.class),
        ("source", &detection.source),
    ] {
        value.as_ref().map_or(Ok(()), |value| text(name, value))?;
    }
    let along = -FURTHEST_UPSTREAM..=LARGEST_POSITION;
    let place = |value: f64| ITEM_PLACE.question(value);
    within("x", detection.x, along, "a position [m]", place)?;
    let across = -LARGEST_POSITION..=LARGEST_POSITION;
    within("y", detection.y, across, "a position [m]", place)?;
    let areas = 0.0..=LARGEST_AREA;
    let area = |value: f64| ITEM_AREA.question(value);
    optional(
        "area_cm2",
        detection.area_cm2,
        areas,
        "an area [cm^2]",
        area,
    )?;
    let weights = 0.0..=LARGEST_WEIGHT;
    optional("weight", detection.weight, weights, "a weight", nothing)?;
    for (name, value) in [
        ("p_detection", detection.p_detection),
        ("p_grasp", detection.p_grasp),
    ] {
        optional(name, value, 0.0..=1.0, "a probability", |value| {
            question(value, "", SHARES, |factor| {
                value > 2.0 && value * factor <= 1.0
            })
        })?;
    }
    let angles = -LARGEST_ANGLE..=LARGEST_ANGLE;
    let what = "an angle [rad]";
    optional("angle", detection.angle, angles, what, |value| {
        question(value, "rad", ANGLES, |factor| {
            (value * factor).abs() <= 13.0
        })
    })?;
    let lengths = 0.0..=LARGEST_EXTENT;
    let meant = |value: f64| {
        question(value, "m", LENGTHS, |factor| {
            value > 0.0 && value * factor <= LARGEST_EXTENT
        })
    };
    optional(
        "height",
        detection.height,
        lengths.clone(),
        "a height [m]",
        meant,
    )?;
    for side in detection.size.into_iter().flatten() {
        within("size", side, lengths.clone(), "a length [m]", meant)?;
    }
    detection.data.as_ref().map_or(Ok(()), check_data)?;
    detection.covariance.map_or(Ok(()), check_covariance)
}

fn check_data(data: &Map<String, Value>) -> Result<(), Rejected> {
    // Values that were parsed can be serialized.
    let length = serde_json::to_string(data).map_or(0, |text| text.len());
    if length <= LONGEST_DATA {
        return Ok(());
    }
    Err(wrong(
        "data",
        &format!("has {length} bytes as JSON"),
        &format!("at most {LONGEST_DATA}: it goes into every task and the journal"),
    ))
}

fn check_covariance([xx, xy, yy]: [f64; 3]) -> Result<(), Rejected> {
    let squares = 0.0..=LARGEST_VARIANCE;
    let expected =
        format!("[xx, xy, yy] in m^2, with 0 <= xx, yy <= {LARGEST_VARIANCE} and xy^2 <= xx yy");
    for (name, value) in [("xx", xx), ("yy", yy)] {
        if value > LARGEST_VARIANCE {
            let meant = question(value, "m^2", VARIANCES, |factor| {
                squares.contains(&(value * factor))
            });
            let problem = format!("has {name} = {} m^2", shown_number(value));
            return Err(wrong("covariance", &problem, &(expected + &meant)));
        }
    }
    if squares.contains(&xx) && squares.contains(&yy) && xy * xy <= xx * yy {
        return Ok(());
    }
    Err(wrong("covariance", "is not a covariance", &expected))
}

fn wrong(field: &str, problem: &str, expected: &str) -> Rejected {
    Rejected::new(
        Rejection::Value,
        format!("{field} {problem}; expected {expected}"),
    )
}

fn stamp(field: &str, value: f64) -> Result<(), Rejected> {
    within(
        field,
        value,
        0.0..=LARGEST_STAMP,
        "a timestamp [s]",
        |value| {
            question(value, "s", STAMPS, |factor| {
                THESE_DAYS.contains(&(value * factor))
            })
        },
    )
}

/// Suggests no unit.
fn nothing(_: f64) -> String {
    String::new()
}

/// Checks that a value is within a range. If it is not, `meant` suggests the unit in which it was
/// probably given.
fn within(
    field: &str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    what: &str,
    meant: impl Fn(f64) -> String,
) -> Result<(), Rejected> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (shown_number(*range.start()), shown_number(*range.end()));
    Err(wrong(
        field,
        &format!("= {}", shown_number(value)),
        &format!("{what} from {low} to {high}{}", meant(value)),
    ))
}

fn optional(
    field: &str,
    value: Option<f64>,
    range: std::ops::RangeInclusive<f64>,
    what: &str,
    meant: impl Fn(f64) -> String,
) -> Result<(), Rejected> {
    value.map_or(Ok(()), |value| within(field, value, range, what, meant))
}

fn text(field: &str, value: &str) -> Result<(), Rejected> {
    check_name(value).map_err(|bad| wrong(field, &bad.problem, &bad.expected))
}
