//! The built-in stations, whose geometries are fitted to the figures in the paper.
//!
//! Jermann et al. state reach, end-effector speed and belt speed, but not belt width, spacing, bins
//! or dwell times. `docs/model.md` gives both geometries and the figures that they reproduce.

use super::geometry::Station;
use super::line::Line;
use crate::error::{Error, Result, known_names};

/// A station that is available without a file.
#[derive(Debug)]
pub struct BuiltIn {
    /// The name to give with `--station`.
    pub name: &'static str,
    /// One-line description for help texts.
    pub summary: &'static str,
    /// Belt speed [m/s].
    pub belt_speed: f64,
    /// Belt width [m].
    pub belt_width: f64,
    /// The robots; `line.robots` is their default number.
    pub line: Line,
}

/// All built-in stations, the default first.
pub const BUILT_INS: &[BuiltIn] = &[
    BuiltIn {
        name: "paper",
        summary: "wide belt at 0.05 m/s: each robot has a strip that only it can reach",
        belt_speed: 0.05,
        belt_width: 1.05,
        line: Line {
            robots: 2,
            first_base_x: 1.3,
            spacing: 1.6,
            base_offset: 0.1,
            bin_offset: 0.0,
            tail: 0.5,
            reach: 0.8,
            speed: 0.5,
            grasp_time: 0.1,
            release_time: 0.1,
        },
    },
    BuiltIn {
        name: "paper-narrow",
        summary: "narrow belt at 0.078 m/s: every item is in every robot's reach",
        belt_speed: 0.078,
        belt_width: 0.4,
        line: Line {
            robots: 2,
            first_base_x: 1.55,
            spacing: 2.0,
            base_offset: 0.1,
            bin_offset: 0.0,
            tail: 1.0,
            reach: 0.8,
            speed: 0.5,
            grasp_time: 0.5,
            release_time: 0.5,
        },
    },
];

impl BuiltIn {
    /// The station with the given number of robots, or the default number.
    ///
    /// # Errors
    /// If the number of robots is not allowed.
    pub fn station(&self, robots: Option<usize>) -> Result<Station> {
        let line = Line {
            robots: robots.unwrap_or(self.line.robots),
            ..self.line
        };
        let made = line.check(&|key| key.to_owned()).and_then(|()| {
            Station::new(
                line.belt(self.belt_speed, self.belt_width),
                line.place(self.belt_width),
            )
        });
        // Everything but the number of robots is known to be right.
        made.map_err(|error| error.at("'robots'").into_usage())
    }
}

/// The built-in station with this name.
///
/// # Errors
/// If the name is unknown; the error suggests the most similar one.
pub fn built_in(name: &str) -> Result<&'static BuiltIn> {
    BUILT_INS.iter().find(|b| b.name == name).ok_or_else(|| {
        let names: Vec<_> = BUILT_INS.iter().map(|b| b.name).collect();
        Error::usage(
            "'station'",
            format!("`{name}` is neither a file nor a built-in station"),
            known_names(name, &names),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_has_the_geometry_of_the_model_page() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        assert_eq!(station.belt().length, 1.3 + 1.6 + 0.8 + 0.5);
        let robots = station.robots();
        assert_eq!(robots.len(), 2);
        assert_eq!(robots[0].base, nalgebra::Point2::new(1.3, -0.625));
        assert_eq!(robots[0].bin, nalgebra::Point2::new(1.3, -0.525));
        assert_eq!(robots[1].bin, nalgebra::Point2::new(1.3 + 1.6, 0.525));
        assert!(
            built_in("papre")
                .unwrap_err()
                .to_string()
                .contains("`paper`")
        );
    }
}
