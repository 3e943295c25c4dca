//! When robots are down: outages that are given, and random ones.

use crate::error::{Error, Result, known_names, shown, shown_number};
use crate::setters::setters;
use crate::station::Station;
use std::fmt;
use std::str::FromStr;

/// What an outage looks like, for messages.
const EXAMPLE: &str = "give ROBOT:FROM..TO in seconds from the start of the run, such as r2:30..60, or \
     r2:30.. for the rest of the run";
/// The mean times [s] that random outages can have: shorter stops are part of a pick, and a run is
/// never longer.
const MEAN_TIMES: std::ops::RangeInclusive<f64> = 0.1..=1e9;

/// A time in which a robot is down: it makes no decision from `from` on, and before `to`.
///
/// As text it is `r2:30..60`, or `r2:30..` if it does not end.
///
/// ```
/// use pickline::sim::Outage;
///
/// let outage: Outage = "r2:30..60".parse()?;
/// assert_eq!(outage, Outage::new("r2", 30.0, 60.0));
/// assert_eq!("r2:30..".parse::<Outage>()?.to, f64::INFINITY);
/// # Ok::<(), pickline::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Outage {
    /// The robot's name, or its number in the line, from 1.
    pub robot: String,
    /// When it begins, after the start of the run [s].
    pub from: f64,
    /// When the robot is ready again [s]; infinite if it is down for the rest of the run.
    pub to: f64,
}

impl Outage {
    /// An outage of `robot`, by name or number, from `from` to `to` [s].
    pub fn new(robot: impl Into<String>, from: f64, to: f64) -> Self {
        Self {
            robot: robot.into(),
            from,
            to,
        }
    }

    fn wrong(&self, problem: impl Into<String>, cure: impl Into<String>) -> Error {
        Error::usage(format!("'outage' {self}"), problem, cure)
    }

    /// Checks the times.
    ///
    /// # Errors
    /// A time that is negative or not a number, or an end that is not after the beginning.
    pub(super) fn check(&self) -> Result<()> {
        if !(self.from >= 0.0 && self.from.is_finite()) {
            let problem = format!("{} s is not a time in a run", shown_number(self.from));
            return Err(self.wrong(problem, "give seconds from the start of the run, 0 or more"));
        }
        if self.to.is_nan() || self.to <= self.from {
            let (from, to) = (shown_number(self.from), shown_number(self.to));
            let problem = format!("it ends at {to} s, which is not after {from} s");
            return Err(self.wrong(problem, EXAMPLE));
        }
        Ok(())
    }

    /// The index of its robot on `station`.
    ///
    /// # Errors
    /// There is no robot of this name or number.
    pub(super) fn robot_on(&self, station: &Station) -> Result<usize> {
        let robots = station.robots();
        let named = robots.iter().position(|robot| robot.name == self.robot);
        let numbered = || {
            let number: usize = self.robot.parse().ok()?;
            (1..=robots.len()).contains(&number).then(|| number - 1)
        };
        named.or_else(numbered).ok_or_else(|| {
            let names: Vec<&str> = robots.iter().map(|robot| &*robot.name).collect();
            let problem = format!("the line has no robot `{}`", shown(&self.robot));
            self.wrong(problem, known_names(&self.robot, &names))
        })
    }

    /// The outage in words.
    pub(super) fn describe(&self) -> String {
        let (robot, from) = (shown(&self.robot), shown_number(self.from));
        match (self.from, self.to) {
            (0.0, f64::INFINITY) => format!("robot {robot} is down for the whole run"),
            (_, f64::INFINITY) => format!("robot {robot} is down from {from} s on"),
            (_, to) => format!(
                "robot {robot} is down from {from} s to {} s",
                shown_number(to)
            ),
        }
    }
}

impl fmt::Display for Outage {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}..", shown(&self.robot), shown_number(self.from))?;
        match self.to {
            f64::INFINITY => Ok(()),
            to => f.write_str(&shown_number(to)),
        }
    }
}

impl FromStr for Outage {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let unreadable = || {
            let problem = format!("`{}` is not an outage", shown(text));
            Error::usage("'outage'", problem, EXAMPLE)
        };
        // The name of a robot may contain a colon.
        let (robot, times) = text.rsplit_once(':').ok_or_else(unreadable)?;
        let (from, to) = times.split_once("..").ok_or_else(unreadable)?;
        // In `0...5` it is not clear where the first number ends.
        if robot.is_empty() || to.starts_with('.') {
            return Err(unreadable());
        }
        let read = |text: &str| text.trim().parse::<f64>().map_err(|_| unreadable());
        let to = match to.trim() {
            "" => f64::INFINITY,
            to => read(to)?,
        };
        let outage = Self::new(robot, read(from)?, to);
        outage.check()?;
        Ok(outage)
    }
}

/// Random outages of every robot. The times up to a failure and those of repairs are exponential;
/// each robot draws them from its own stream of random numbers, whatever the strategy.
///
/// As text it is the two times, `300,20`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RandomOutages {
    /// Mean time from the start of the run, or from a repair, to the next failure [s].
    pub mtbf: f64,
    /// Mean time to repair [s].
    pub mttr: f64,
}

setters!(RandomOutages {
    /// With this mean time between failures [s], from a repair to the next failure.
    fn with_mtbf(mtbf: f64);
    /// With this mean time to repair [s].
    fn with_mttr(mttr: f64);
});

impl RandomOutages {
    /// Outages with these mean times from a repair to the next failure, and to repair [s].
    pub fn new(mtbf: f64, mttr: f64) -> Self {
        Self { mtbf, mttr }
    }

    /// The share of time in which a robot is down in the long run.
    pub fn share_down(&self) -> f64 {
        self.mttr / (self.mtbf + self.mttr)
    }

    /// Checks the mean times.
    ///
    /// # Errors
    /// A time that is out of range or not a number.
    pub(super) fn check(&self) -> Result<()> {
        for (time, what) in [
            (self.mtbf, "mean time between failures"),
            (self.mttr, "mean time to repair"),
        ] {
            if !MEAN_TIMES.contains(&time) {
                return Err(Error::usage(
                    "'outages'",
                    format!("{} s is not a valid {what}", shown_number(time)),
                    format!(
                        "give seconds, from {} to {}",
                        MEAN_TIMES.start(),
                        shown_number(*MEAN_TIMES.end())
                    ),
                ));
            }
        }
        Ok(())
    }

    /// The outages in words.
    pub(super) fn describe(&self) -> String {
        let (mtbf, mttr) = (shown_number(self.mtbf), shown_number(self.mttr));
        format!("robots fail after {mtbf} s and are repaired in {mttr} s (means, exponential)")
    }
}

impl FromStr for RandomOutages {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let unreadable = || {
            Error::usage(
                "'outages'",
                format!("`{}` is not a pair of times", shown(text)),
                "give the mean time between failures and the mean time to repair in seconds, such \
                 as 300,20",
            )
        };
        let (mtbf, mttr) = text.split_once(',').ok_or_else(unreadable)?;
        let read = |text: &str| text.trim().parse::<f64>().map_err(|_| unreadable());
        let outages = Self::new(read(mtbf)?, read(mttr)?);
        outages.check()?;
        Ok(outages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::{Conditions, Disturbances};

    #[test]
    fn outages_are_read_as_they_are_written() {
        for (text, outage) in [
            ("r2:30..60", Outage::new("r2", 30.0, 60.0)),
            ("2:0.5..1.25", Outage::new("2", 0.5, 1.25)),
            ("r2:30..", Outage::new("r2", 30.0, f64::INFINITY)),
            ("cell:left:0..1", Outage::new("cell:left", 0.0, 1.0)),
            ("r1:1e3..2e3", Outage::new("r1", 1000.0, 2000.0)),
        ] {
            assert_eq!(text.parse::<Outage>().unwrap(), outage, "{text}");
            assert_eq!(outage.to_string().parse::<Outage>().unwrap(), outage);
        }
    }

    #[test]
    fn invalid_outages_are_refused_with_the_reason() {
        for (text, words) in [
            ("", "`` is not an outage"),
            ("r2", "`r2` is not an outage"),
            ("r2:30", "`r2:30` is not an outage"),
            ("r2:30-60", "is not an outage"),
            (":30..60", "is not an outage"),
            ("r2:..60", "is not an outage"),
            ("r2:0...5", "is not an outage"),
            ("r2:a..b", "is not an outage"),
            ("r2:30,5..60", "is not an outage"),
            ("r2:60..30", "it ends at 30 s, which is not after 60 s"),
            ("r2:30..30", "it ends at 30 s, which is not after 30 s"),
            ("r2:-1..30", "-1 s is not a time in a run"),
            ("r2:nan..30", "NaN s is not a time in a run"),
            ("r2:inf..", "inf s is not a time in a run"),
            ("r2:30..nan", "it ends at NaN s"),
        ] {
            let message = text.parse::<Outage>().unwrap_err().to_string();
            assert!(message.contains("'outage'"), "{message}");
            assert!(message.contains(words), "{words} not in {message}");
        }
    }

    #[test]
    fn mean_times_are_two_numbers_in_range() {
        let read = |text: &str| text.parse::<RandomOutages>();
        assert_eq!(read("300,20").unwrap(), RandomOutages::new(300.0, 20.0));
        assert_eq!(read(" 0.1 , 1e9 ").unwrap(), RandomOutages::new(0.1, 1e9));
        assert_eq!(RandomOutages::new(300.0, 20.0).share_down(), 0.0625);
        for (text, words) in [
            ("300", "`300` is not a pair of times"),
            ("300;20", "is not a pair of times"),
            ("300,20,1", "is not a pair of times"),
            ("0,20", "0 s is not a valid mean time between failures"),
            ("-1,20", "-1 s is not a valid mean time between failures"),
            ("nan,20", "NaN s is not a valid mean time between failures"),
            ("300,0", "0 s is not a valid mean time to repair"),
            ("300,inf", "inf s is not a valid mean time to repair"),
            ("300,1.1e9", "is not a valid mean time to repair"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains("'outages'"), "{message}");
            assert!(message.contains(words), "{words} not in {message}");
        }
    }

    #[test]
    fn robots_are_found_by_name_then_by_number() {
        let station = crate::station::built_in("paper").unwrap();
        let station = station.station(Some(3)).unwrap();
        let on = |robot: &str| Outage::new(robot, 0.0, 1.0).robot_on(&station);
        assert_eq!((on("r1").unwrap(), on("r3").unwrap()), (0, 2));
        assert_eq!((on("1").unwrap(), on("3").unwrap()), (0, 2));
        for unknown in ["r4", "4", "0", "R1", "-1", ""] {
            let message = on(unknown).unwrap_err().to_string();
            assert!(message.contains("the line has no robot"), "{message}");
            assert!(message.contains("known: r1, r2, r3"), "{message}");
        }
    }

    #[test]
    fn outages_have_words() {
        for (text, words) in [
            ("r2:30..60", "robot r2 is down from 30 s to 60 s"),
            ("r2:30..", "robot r2 is down from 30 s on"),
            ("r2:0..", "robot r2 is down for the whole run"),
        ] {
            assert_eq!(text.parse::<Outage>().unwrap().describe(), words);
        }
        assert_eq!(
            RandomOutages::new(300.0, 20.0).describe(),
            "robots fail after 300 s and are repaired in 20 s (means, exponential)"
        );
    }

    #[test]
    fn conditions_say_what_can_go_wrong() {
        let plain = Conditions::default();
        let given = plain.clone().with_outage(Outage::new("r1", 3.0, 4.0));
        let random = plain.clone().with_outages(RandomOutages::new(300.0, 20.0));
        let failing = Disturbances::default().with_grasp_failures(true);
        let failing = plain.clone().with_disturbances(failing);
        let said = |c: &Conditions| (c.has_outages(), c.can_go_wrong(), c.is_random());
        assert_eq!(said(&plain), (false, false, false));
        assert_eq!(said(&given), (true, true, false));
        assert_eq!(said(&random), (true, true, true));
        assert_eq!(said(&failing), (false, true, true));
        for bad in [
            plain.clone().with_outage(Outage::new("r1", 4.0, f64::NAN)),
            plain.with_outages(RandomOutages::new(300.0, f64::NAN)),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains("'outage"), "{message}");
        }
    }
}
