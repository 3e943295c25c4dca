//! The keys of an arm in a station file: its travel-time law and its lift.

use crate::error::Result;
use crate::kinematics::{Arm, TravelLaw};
use crate::toml_file::Section;

/// The keys, in a `[[robot]]` or a `[line]`.
pub(super) const KEYS: [&str; 5] = ["speed", "acceleration", "deceleration", "lift", "travel"];

/// The arm that the keys of `owner` describe.
pub(super) fn read(owner: &Section) -> Result<Arm> {
    let lift = owner.optional("lift")?.unwrap_or(0.0);
    let travel = owner.optional_pairs("travel")?;
    let speed = owner.optional("speed")?;
    let acceleration = owner.optional("acceleration")?;
    let deceleration = owner.optional("deceleration")?;
    let law = match (travel, speed, acceleration, deceleration) {
        (Some(points), None, None, None) => TravelLaw::Table(points),
        (Some(_), ..) => {
            return Err(owner.wrong(
                "travel",
                "a measured table, and speed, acceleration or deceleration as well".into(),
                "keep the table, or describe the arm by speed and acceleration".into(),
            ));
        }
        (None, None, ..) => {
            let table = ", or a measured table: `travel = [[0.0, 0.08], [0.1, 0.15]]`";
            return Err(owner.missing_or("speed", table));
        }
        (None, Some(_), None, Some(_)) => {
            return Err(owner.wrong(
                "deceleration",
                "a deceleration without an acceleration".into(),
                "add `acceleration = ...` in m/s^2, or remove the key".into(),
            ));
        }
        (None, Some(speed), None, None) => TravelLaw::Constant { speed },
        (None, Some(speed), Some(acceleration), deceleration) => TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration: deceleration.unwrap_or(acceleration),
        },
    };
    Ok(Arm { law, lift })
}

/// The keys and values of `arm`, which [`read`] reads back.
pub(super) fn write(arm: &Arm) -> Vec<(&'static str, String)> {
    let number = |value: f64| format!("{value:?}");
    let mut list = match &arm.law {
        TravelLaw::Constant { speed } => vec![("speed", number(*speed))],
        TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration,
        } => {
            let mut list = vec![
                ("speed", number(*speed)),
                ("acceleration", number(*acceleration)),
            ];
            if deceleration != acceleration {
                list.push(("deceleration", number(*deceleration)));
            }
            list
        }
        TravelLaw::Table(points) => {
            let points: Vec<String> = points
                .iter()
                .map(|(l, t)| format!("[{l:?}, {t:?}]"))
                .collect();
            vec![("travel", format!("[{}]", points.join(", ")))]
        }
    };
    if arm.lift != 0.0 {
        list.push(("lift", number(arm.lift)));
    }
    list
}
