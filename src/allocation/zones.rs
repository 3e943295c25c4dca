//! Zones: each robot takes the items within its band across the belt.

use super::own_rules::{OwnRules, RULE_OPTION};
use super::written::{Written, check_count};
use crate::decision::{Action, Snapshot, Strategy};
use crate::dispatch::Rule;
use crate::error::{Error, Result};
use crate::station::{Belt, Station};

/// Its name among the strategies.
const KIND: &str = "zones";

/// Bands along the belt, one for each robot: the first robot has the one with the lowest y, and a robot
/// leaves what lies in another's. An item on a border belongs to the band above it.
///
/// `docs/rivals.md` names the line software that works like this.
#[derive(Debug, Clone, Default)]
pub struct Zones {
    /// The borders between the bands, in increasing order of y [m]; empty for equal bands.
    borders: Vec<f64>,
    rules: OwnRules,
}

impl Zones {
    /// Options and their meanings, for help texts.
    pub(crate) const KEYS: [(&'static str, &'static str); 1] = [RULE_OPTION];

    /// No border is farther from the middle of a belt [m].
    const MOST: f64 = 1e3;
    const CURE: &str = "give one border [m] less than there are robots, in increasing order of y, \
                        such as zones:-0.1,0.1 for three robots, or plain `zones` for equal bands";

    /// Bands between these borders, in increasing order of y [m]; equal ones if there is none. Each
    /// robot takes its own items by FIFO.
    ///
    /// # Errors
    /// Boundaries that do not increase.
    pub fn new(borders: Vec<f64>) -> Result<Self> {
        // So that NaN is an error.
        let increases = |pair: &[f64]| pair[0] < pair[1];
        if !borders.windows(2).all(increases) {
            return Err(Error::usage(
                format!("'strategy' {KIND}"),
                "the borders do not increase",
                Self::CURE,
            ));
        }
        Ok(Self {
            borders,
            rules: OwnRules::default(),
        })
    }

    /// With these rules by which robots choose among their own items: one for all, or one for each.
    #[must_use]
    pub fn with_rules(mut self, rules: Vec<Rule>) -> Self {
        self.rules = OwnRules::new(rules);
        self
    }

    /// Reads what stands after the colon.
    pub(crate) fn read(text: &str) -> Result<Self> {
        let written = Written::read(KIND, text, &Self::KEYS)?;
        let mut zones = Self::new(written.numbers(-Self::MOST..=Self::MOST, Self::CURE)?)?;
        for (_, rules) in &written.options {
            zones.rules = OwnRules::read(&written, rules)?;
        }
        Ok(zones)
    }
}

/// The robot of `robots` whose band has `y` [m].
fn robot_at(y: f64, borders: &[f64], belt: &Belt, robots: usize) -> usize {
    if !borders.is_empty() {
        return borders.partition_point(|border| *border <= y);
    }
    let share = (y + belt.width / 2.0) / belt.width;
    // Negative numbers become 0.
    let band = (share * robots as f64) as usize;
    band.min(robots.saturating_sub(1))
}

impl Strategy for Zones {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let (belt, robots) = (snapshot.station.belt(), snapshot.station.robots().len());
        let borders = &self.borders;
        let pick = self.rules.pick(snapshot, |candidate| {
            robot_at(candidate.y, borders, belt, robots) == snapshot.robot
        });
        pick.unwrap_or(Action::WaitForNextWindow)
    }

    fn name(&self) -> String {
        let borders = self.borders.iter().map(f64::to_string);
        let parts: Vec<_> = borders.chain(self.rules.written()).collect();
        match parts.is_empty() {
            true => KIND.into(),
            false => format!("{KIND}:{}", parts.join(",")),
        }
    }

    fn needs_view(&self) -> bool {
        false
    }

    fn check_robots(&self, robots: usize) -> Result<()> {
        if !self.borders.is_empty() {
            let given = self.borders.len();
            let needed = robots.saturating_sub(1);
            check_count(KIND, (given, "border"), needed, robots, Self::CURE)?;
        }
        self.rules.check_robots(KIND, robots)
    }

    fn check_station(&self, station: &Station) -> Result<()> {
        self.check_robots(station.robots().len())?;
        let edge = station.belt().width / 2.0;
        let beside = |border: &&f64| border.abs() >= edge;
        match self.borders.iter().find(beside) {
            None => Ok(()),
            Some(border) => Err(Error::usage(
                format!("'strategy' {KIND}"),
                format!("the border {border} m is not on the belt, which covers |y| <= {edge} m"),
                format!("give borders between -{edge} and {edge}, without these ends"),
            )),
        }
    }
}
