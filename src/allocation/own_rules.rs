//! The rules by which robots choose among their own items.

use super::written::Written;
use crate::decision::{Action, Candidate, Snapshot};
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::{Error, Result, counted};

/// The option that sets them.
pub(super) const RULE: &str = "rule";
/// The same with its meaning, for help texts.
pub(super) const RULE_OPTION: (&str, &str) = (
    RULE,
    "how a robot chooses among its own, such as SPT, or SPT+FIFO for each robot [FIFO]",
);

/// One rule for all robots, or one for each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OwnRules {
    rules: Vec<Rule>,
    /// Buffers: the robot's own candidates, and where they are among all.
    own: Vec<Candidate>,
    places: Vec<usize>,
}

impl Default for OwnRules {
    fn default() -> Self {
        Self::new(vec![Rule::FIFO])
    }
}

impl OwnRules {
    /// These rules: one for all robots, or one for each.
    pub(super) fn new(rules: Vec<Rule>) -> Self {
        Self {
            rules,
            own: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Reads `SPT` or `SPT+FIFO`.
    pub(super) fn read(written: &Written, value: &str) -> Result<Self> {
        let rules: Result<RuleAssignment> = value.replace('+', ",").parse();
        let rules = rules.map_err(|error| error.at(&written.place(RULE)))?;
        Ok(Self::new(rules.rules().to_vec()))
    }

    /// Checks that there is one for each of `robots` robots of a strategy of this `kind`.
    pub(super) fn check_robots(&self, kind: &str, robots: usize) -> Result<()> {
        let count = self.rules.len();
        if count == 1 || count == robots {
            return Ok(());
        }
        Err(Error::usage(
            format!("'strategy' {kind}:{RULE}"),
            format!(
                "{} for {}",
                counted(count, "rule"),
                counted(robots, "robot")
            ),
            "give one for all robots, or one for each, upstream first, such as SPT+FIFO",
        ))
    }

    /// The option as it is written; `None` for the default.
    pub(super) fn written(&self) -> Option<String> {
        let names: Vec<_> = self.rules.iter().map(|rule| rule.name()).collect();
        (self.rules != [Rule::FIFO]).then(|| format!("{RULE}={}", names.join("+")))
    }

    /// The pick among those candidates that are the robot's `own`; `None` if there is none.
    pub(super) fn pick(
        &mut self,
        snapshot: &Snapshot,
        own: impl Fn(&Candidate) -> bool,
    ) -> Option<Action> {
        self.own.clear();
        self.places.clear();
        for (place, candidate) in snapshot.candidates.iter().enumerate() {
            if own(candidate) {
                self.own.push(*candidate);
                self.places.push(place);
            }
        }
        if self.own.is_empty() {
            return None;
        }
        let one_for_all = || self.rules.first();
        let rule = match self.rules.len() {
            1 => one_for_all(),
            _ => self.rules.get(snapshot.robot).or_else(one_for_all),
        };
        let rule = rule.copied().unwrap_or(Rule::FIFO);
        let chosen = rule.choose(&snapshot.moment(), &self.own);
        Some(Action::Pick(self.places[chosen]))
    }
}
