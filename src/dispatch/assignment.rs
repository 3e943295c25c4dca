//! One rule for each robot: the assignments that the combinatorial strategy searches.

use super::registry::Rule;
use crate::decision::{Action, Snapshot, Strategy};
use crate::error::{Error, Result, counted, shown};
use std::fmt;
use std::str::FromStr;

/// One rule for each robot, upstream first.
#[derive(
    Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(try_from = "String", into = "String")]
pub struct RuleAssignment(Vec<Rule>);

impl RuleAssignment {
    /// Creates an assignment from these rules.
    pub fn new(rules: Vec<Rule>) -> Self {
        Self(rules)
    }

    /// All assignments in registry order, `6^robots` with six rules. The rule of the first robot
    /// varies slowest.
    pub fn all(robots: usize) -> impl Iterator<Item = Self> {
        let mut next = Some(vec![Rule::FIRST; robots]);
        std::iter::from_fn(move || {
            let current = next.take()?;
            let mut places = current.iter().enumerate().rev();
            next = places
                .find_map(|(place, rule)| Some((place, rule.next()?)))
                .map(|(place, rule)| {
                    let mut rules = current.clone();
                    rules[place] = rule;
                    rules[place + 1..].fill(Rule::FIRST);
                    rules
                });
            Some(Self::new(current))
        })
    }

    /// The rules, upstream first.
    pub fn rules(&self) -> &[Rule] {
        &self.0
    }

    /// The rules' names, upstream first.
    pub fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|rule| rule.name()).collect()
    }

    /// The same assignment, after checking that there is one rule for each robot.
    ///
    /// # Errors
    /// If the number of rules differs from the number of robots.
    pub fn for_robots(self, robots: usize) -> Result<Self> {
        self.check_robots(robots).map(|()| self)
    }

    /// Checks that there is one rule for each robot.
    ///
    /// # Errors
    /// If the number of rules differs from the number of robots.
    pub(crate) fn check_robots(&self, robots: usize) -> Result<()> {
        if self.0.len() == robots {
            return Ok(());
        }
        Err(Error::usage(
            format!("'strategy' {self}"),
            format!(
                "{} for {}",
                counted(self.0.len(), "rule"),
                counted(robots, "robot")
            ),
            "give one rule for each robot, upstream first",
        ))
    }
}

impl fmt::Display for RuleAssignment {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "[{}]", self.names().join("; "))
    }
}

impl TryFrom<String> for RuleAssignment {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<RuleAssignment> for String {
    fn from(assignment: RuleAssignment) -> Self {
        assignment.names().join(",")
    }
}

impl FromStr for RuleAssignment {
    type Err = Error;

    /// Parses `SPT,FIFO` or `[SPT; FIFO]`.
    fn from_str(text: &str) -> Result<Self> {
        let inner = text.trim();
        let inner = inner
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .unwrap_or(inner);
        if inner.trim().is_empty() {
            return Err(Error::usage(
                "'strategy'",
                format!("`{}` contains no rule", shown(text)),
                "write one rule for each robot, upstream first, for example SPT,FIFO",
            ));
        }
        inner
            .split([',', ';'])
            .map(|part| part.trim().parse())
            .collect::<Result<_>>()
            .map(Self)
    }
}

/// A strategy that follows a rule assignment. It leaves robots beyond its end idle; a simulation
/// requires one rule for each robot ([`Strategy::check_robots`]).
#[derive(Debug, Clone)]
pub struct RuleStrategy(pub RuleAssignment);

impl Strategy for RuleStrategy {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        match self.0.0.get(snapshot.robot) {
            Some(rule) => Action::Pick(rule.choose(&snapshot.moment(), snapshot.candidates)),
            None => Action::WaitUntil(f64::INFINITY),
        }
    }

    fn name(&self) -> String {
        format!("rules:{}", self.0.names().join(","))
    }

    fn needs_view(&self) -> bool {
        false
    }

    fn check_robots(&self, robots: usize) -> Result<()> {
        self.0.check_robots(robots)
    }
}

#[cfg(test)]
mod tests {
    use super::super::RULES;
    use super::*;

    #[test]
    fn both_ways_of_writing_are_read() {
        let plain: RuleAssignment = "SPT,FIFO".parse().unwrap();
        assert_eq!("[SPT; FIFO]".parse::<RuleAssignment>().unwrap(), plain);
        assert_eq!(" spt , fifo ".parse::<RuleAssignment>().unwrap(), plain);
        assert_eq!(plain.to_string(), "[SPT; FIFO]");
        for (bad, problem) in [
            ("", "`` contains no rule"),
            ("[]", "`[]` contains no rule"),
            ("SPT,", "`` is not a dispatching rule"),
            ("SPT FIFO", "`SPT FIFO` is not a dispatching rule"),
            ("[SPT", "`[SPT` is not a dispatching rule"),
            ("SPT,XXX", "`XXX` is not a dispatching rule"),
        ] {
            let message = bad.parse::<RuleAssignment>().unwrap_err().to_string();
            assert!(message.contains(problem), "{bad}: {message}");
        }
        let message = plain.for_robots(3).unwrap_err().to_string();
        assert!(message.contains("2 rules for 3 robots"), "{message}");
    }

    #[test]
    fn all_assignments_come_once_in_order() {
        let all: Vec<_> = RuleAssignment::all(2).collect();
        assert_eq!(all.len(), RULES.len() * RULES.len());
        assert!(all.is_sorted());
        assert_eq!(all[1].to_string(), "[FIFO; SPT]");
        assert_eq!(RuleAssignment::all(0).count(), 1);
    }
}
