//! The built-in stations.
//!
//! The geometries of `paper` and `paper-narrow` are fitted to the figures in the paper: Jermann et
//! al. state reach, end-effector speed and belt speed, but not belt width, spacing, bins or dwell
//! times. `docs/model.md` gives both geometries and the figures that they reproduce. `delta` and
//! `sorting` are real lines (`docs/real-lines.md`); their files state their sources.

use super::file::{self, Overrides};
use super::geometry::Station;
use crate::error::{Error, Result, known_names};

/// A station that is available without a file.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BuiltIn {
    /// The name by which [`built_in`] finds it.
    pub name: &'static str,
    /// One-line description.
    pub summary: &'static str,
    /// The station as a file.
    text: &'static str,
}

/// All built-in stations, the default first.
pub const BUILT_INS: &[BuiltIn] = &[
    BuiltIn {
        name: "paper",
        summary: "wide belt at 0.05 m/s: each robot has a strip that only it can reach",
        text: include_str!("paper.toml"),
    },
    BuiltIn {
        name: "paper-narrow",
        summary: "narrow belt at 0.078 m/s: every item is in every robot's reach",
        text: include_str!("paper-narrow.toml"),
    },
    BuiltIn {
        name: "delta",
        summary: "three delta robots over a packing belt at 0.4 m/s",
        text: include_str!("delta.toml"),
    },
    BuiltIn {
        name: "sorting",
        summary: "four arms that sort waste into bins by material at 0.3 m/s; wood is left",
        text: include_str!("sorting.toml"),
    },
];

impl BuiltIn {
    /// The station with the given number of robots, or the default number.
    ///
    /// # Errors
    /// If the number of robots is not allowed.
    pub fn station(&self, robots: Option<usize>) -> Result<Station> {
        let overrides = Overrides::default().with_robots(robots);
        // Everything but the number of robots is known to be right.
        let made = file::parse(self.text, self.name, overrides);
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
        assert_eq!(robots[0].bins[0].at, nalgebra::Point2::new(1.3, -0.525));
        assert_eq!(
            robots[1].bins[0].at,
            nalgebra::Point2::new(1.3 + 1.6, 0.525)
        );
        assert!(
            built_in("papre")
                .unwrap_err()
                .to_string()
                .contains("`paper`")
        );
    }
}
