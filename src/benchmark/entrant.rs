//! Who takes part.

use super::program::OutsideProgram;
use crate::dispatch::Rule;
use std::path::PathBuf;

/// What is known when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Foresight {
    /// An item becomes known when it passes the beginning of the belt, x = 0.
    #[default]
    Online,
    /// All items are known from the beginning.
    Clairvoyant,
}

impl Foresight {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Who takes part.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Entrant {
    /// A strategy, as [`parse`](crate::strategies::parse) reads it, on a track. If rules, shares or every n-th item have
    /// one value only, it is that of every robot.
    Strategy(String, Foresight),
    /// An outside program, which knows everything.
    Program(OutsideProgram),
    /// A folder of files of picks, one for each instance.
    Picks(PathBuf),
    /// The schedule that is found with the bound, which is computed anew.
    Bound,
    /// The best solutions that are known.
    Best,
}

impl Entrant {
    /// Its name in results.
    pub fn name(&self) -> String {
        match self {
            Self::Strategy(text, _) => text.clone(),
            Self::Program(program) => format!("program {}", program.text()),
            Self::Picks(folder) => format!("picks in {}", folder.display()),
            Self::Bound => "schedule of the bound".into(),
            Self::Best => "best known".into(),
        }
    }

    /// What it knows when. Whoever reads the whole pattern is clairvoyant.
    pub fn track(&self) -> Foresight {
        match self {
            Self::Strategy(_, track) => *track,
            _ => Foresight::Clairvoyant,
        }
    }
}

/// Strategies with a value for each robot.
const PER_ROBOT: [&str; 3] = ["rules", "share", "every"];

/// The strategy in `text` for a line of `robots` robots: a single value of rules, shares or every n-th item is
/// that of every robot.
pub(super) fn for_robots(text: &str, robots: usize) -> String {
    let Some((kind, rest)) = text.split_once(':') else {
        return match text.parse::<Rule>() {
            Ok(_) => vec![text; robots].join(","),
            Err(_) => text.to_owned(),
        };
    };
    let (options, values): (Vec<&str>, Vec<&str>) =
        rest.split(',').partition(|part| part.contains('='));
    if !PER_ROBOT.contains(&kind) || values.len() != 1 {
        return text.to_owned();
    }
    let values = vec![values[0]; robots];
    let parts: Vec<&str> = values.into_iter().chain(options).collect();
    format!("{kind}:{}", parts.join(","))
}

#[cfg(test)]
mod tests {
    use super::for_robots;

    #[test]
    fn a_single_value_is_that_of_every_robot() {
        for (text, robots, expected) in [
            ("rules:SPT", 3, "rules:SPT,SPT,SPT"),
            ("rules:SPT,FIFO", 3, "rules:SPT,FIFO"),
            ("SPT", 3, "SPT,SPT,SPT"),
            ("SPT,FIFO", 3, "SPT,FIFO"),
            ("share:1,rule=SPT", 2, "share:1,1,rule=SPT"),
            ("every:2", 1, "every:2"),
            ("zones", 4, "zones"),
            ("zones:0.1", 4, "zones:0.1"),
            ("lookahead:budget=9", 2, "lookahead:budget=9"),
        ] {
            assert_eq!(for_robots(text, robots), expected);
        }
    }
}
