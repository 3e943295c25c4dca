//! Robots as people and other programs refer to them.

use super::geometry::Station;
use crate::error::{known_names, nearest, shown};

/// Why a text is not a robot of a station.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NoSuchRobot {
    /// What is wrong.
    pub problem: String,
    /// What to write instead.
    pub cure: String,
}

/// The index of the robot with this name or number, from 1, upstream first.
///
/// # Errors
/// Neither a name nor a number of a robot.
pub(crate) fn robot_called(text: &str, station: &Station) -> Result<usize, NoSuchRobot> {
    let robots = station.robots();
    let named = robots.iter().position(|robot| robot.name == text);
    let number: Option<usize> = text.parse().ok();
    let numbered = number.filter(|number| (1..=robots.len()).contains(number));
    named.or(numbered.map(|number| number - 1)).ok_or_else(|| {
        let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
        let meant = nearest(text, names.iter().copied());
        NoSuchRobot {
            problem: format!("there is no robot `{}`", shown(text)),
            cure: match (number, meant) {
                (Some(_), _) => {
                    format!(
                        "robots are counted from 1 to {}, upstream first",
                        robots.len()
                    )
                }
                (None, Some(_)) => known_names(text, &names),
                (None, None) => format!("known: {}", names.join(", ")),
            },
        }
    })
}
