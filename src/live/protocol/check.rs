//! What the types cannot say: which numbers and texts make sense.

use super::decode::{Rejected, Rejection};
use super::incoming::{Detection, Incoming};
use crate::error::{shown, shown_number};

/// Ids and names are at most this long [characters].
pub const LONGEST_TEXT: usize = 200;
/// Stamps are at most this late [s]: seconds since 1970 reach it in some thousand years.
pub const LARGEST_STAMP: f64 = 1e11;
/// Positions past this [m] are on no belt.
const LARGEST_POSITION: f64 = 1e6;
/// Speeds past this [m/s] are no belt's.
const LARGEST_SPEED: f64 = 100.0;
/// Areas [cm^2] and weights past this are none.
const LARGEST_AMOUNT: f64 = 1e12;

/// Checks the values of `message`.
pub(super) fn check(message: &Incoming) -> Result<(), Rejected> {
    stamp("stamp", message.stamp())?;
    match message {
        Incoming::Detection(detection) => check_detection(detection),
        Incoming::Belt(belt) => {
            let speeds = -LARGEST_SPEED..=LARGEST_SPEED;
            within("speed", belt.speed, speeds, "a belt speed [m/s]")?;
            let places = -1e12..=1e12;
            optional("position", belt.position, places, "a belt position [m]")
        }
        Incoming::Robot(robot) => {
            text("name", &robot.name)?;
            robot
                .available_at
                .map_or(Ok(()), |t| stamp("available_at", t))
        }
        Incoming::Result(report) => report
            .available_at
            .map_or(Ok(()), |t| stamp("available_at", t)),
        Incoming::Ack(_) | Incoming::Tick { .. } => Ok(()),
    }
}

fn check_detection(detection: &Detection) -> Result<(), Rejected> {
    for (name, value) in [("id", &detection.id), ("class", &detection.class)] {
        value.as_ref().map_or(Ok(()), |value| text(name, value))?;
    }
    let places = -LARGEST_POSITION..=LARGEST_POSITION;
    within("x", detection.x, places.clone(), "a position [m]")?;
    within("y", detection.y, places, "a position [m]")?;
    let amounts = 0.0..=LARGEST_AMOUNT;
    optional(
        "area_cm2",
        detection.area_cm2,
        amounts.clone(),
        "an area [cm^2]",
    )?;
    optional("weight", detection.weight, amounts, "a weight")?;
    optional(
        "p_detection",
        detection.p_detection,
        0.0..=1.0,
        "a probability",
    )?;
    optional("p_grasp", detection.p_grasp, 0.0..=1.0, "a probability")?;
    let Some([xx, xy, yy]) = detection.covariance else {
        return Ok(());
    };
    let squares = 0.0..=1.0;
    if squares.contains(&xx) && squares.contains(&yy) && xy * xy <= xx * yy {
        return Ok(());
    }
    Err(wrong(
        "covariance",
        "is no covariance",
        "[xx, xy, yy] in m^2, with 0 <= xx, yy <= 1 and xy^2 <= xx yy",
    ))
}

fn wrong(field: &str, problem: &str, expected: &str) -> Rejected {
    Rejected {
        reason: Rejection::Value,
        message: format!("{field} {problem}; expected {expected}"),
    }
}

fn stamp(field: &str, value: f64) -> Result<(), Rejected> {
    within(field, value, 0.0..=LARGEST_STAMP, "a stamp [s]")
}

fn within(
    field: &str,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    what: &str,
) -> Result<(), Rejected> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (shown_number(*range.start()), shown_number(*range.end()));
    Err(wrong(
        field,
        &format!("= {}", shown_number(value)),
        &format!("{what} from {low} to {high}"),
    ))
}

fn optional(
    field: &str,
    value: Option<f64>,
    range: std::ops::RangeInclusive<f64>,
    what: &str,
) -> Result<(), Rejected> {
    value.map_or(Ok(()), |value| within(field, value, range, what))
}

fn text(field: &str, value: &str) -> Result<(), Rejected> {
    if value.is_empty() || value.trim() != value {
        return Err(wrong(
            field,
            &format!("`{}` is empty or has blanks at an end", shown(value)),
            "a name without them",
        ));
    }
    if value.chars().nth(LONGEST_TEXT).is_some() {
        return Err(wrong(
            field,
            &format!("`{}` is too long", shown(value)),
            &format!("at most {LONGEST_TEXT} characters"),
        ));
    }
    if value.chars().any(char::is_control) {
        return Err(wrong(
            field,
            &format!("`{}` holds control characters", shown(value)),
            "printable characters only",
        ));
    }
    Ok(())
}
