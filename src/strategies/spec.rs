//! Strategies for a line that is not known yet, made from text or from types.

use super::blueprint::{Blueprint, Setup};
use crate::decision::Strategy;
use crate::dispatch::{Rule, RuleAssignment, RuleStrategy};
use crate::error::{Error, Result};
use crate::planning::{Allowance, Lookahead, LookaheadOptions, WrittenOptions};
use crate::station::Station;
use std::fmt;

/// The name of rule assignments among the strategies.
pub(super) const RULES: &str = "rules";
/// The name of the look-ahead.
pub(super) const LOOKAHEAD: &str = "lookahead";

/// Creates a strategy for a line after its text was read.
pub(super) type Maker = Box<dyn Fn(&Setup) -> Result<Blueprint> + Send + Sync>;

/// Makes the strategy of `rules`.
pub(super) fn rule_maker(rules: RuleAssignment) -> Maker {
    Box::new(move |setup| {
        let strategy = RuleStrategy(rules.clone().for_robots(setup.robots)?);
        Ok(Blueprint::new(strategy.name(), move || {
            Box::new(strategy.clone())
        }))
    })
}

/// Makes `strategy`, after checking that it is for the line's number of robots.
pub(super) fn own_maker(strategy: impl Strategy + Clone + Send + Sync + 'static) -> Maker {
    Box::new(move |setup| {
        strategy.check_robots(setup.robots)?;
        let strategy = strategy.clone();
        Ok(Blueprint::new(strategy.name(), move || {
            Box::new(strategy.clone())
        }))
    })
}

/// Makes the look-ahead with the options `written`.
pub(super) fn lookahead_maker(written: WrittenOptions) -> Maker {
    Box::new(move |setup| {
        let mut options = written.on(setup.robots, setup.allowance)?;
        let name = options.written();
        if options.bases.is_empty() {
            options.bases = (setup.bases)()?;
        }
        Ok(Blueprint::new(name, move || {
            Box::new(Lookahead::new(options.clone()))
        }))
    })
}

/// A strategy for a line that is not known yet.
///
/// [`parse`](super::parse) reads one from text. Rules and the look-ahead are also made from their
/// types, and [`StrategySpec::custom`] makes one of any [`Strategy`]:
///
/// ```
/// use pickline::planning::LookaheadOptions;
/// use pickline::{CompareOptions, RuleAssignment};
///
/// let rules: RuleAssignment = "SPT,FIFO".parse()?;
/// let options = CompareOptions::default()
///     .with_strategy(rules)
///     .with_strategy(LookaheadOptions::default().with_depth(2));
/// # Ok::<(), pickline::Error>(())
/// ```
pub struct StrategySpec {
    text: String,
    /// The name of its kind, for messages.
    kind: String,
    /// Whether its decisions have a budget.
    budgeted: bool,
    make: Maker,
    remark: Option<String>,
}

impl fmt::Debug for StrategySpec {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("StrategySpec").field(&self.text).finish()
    }
}

impl From<RuleAssignment> for StrategySpec {
    /// One dispatching rule for each robot, upstream first.
    fn from(rules: RuleAssignment) -> Self {
        Self {
            text: RuleStrategy(rules.clone()).name(),
            kind: RULES.into(),
            budgeted: false,
            make: rule_maker(rules),
            remark: None,
        }
    }
}

impl From<LookaheadOptions> for StrategySpec {
    /// The look-ahead with these options. As in text, a default budget gives way to that of the
    /// study, and a study finds the base assignments if there are none.
    fn from(options: LookaheadOptions) -> Self {
        Self {
            text: options.written(),
            kind: LOOKAHEAD.into(),
            budgeted: true,
            make: lookahead_maker(options.into()),
            remark: None,
        }
    }
}

impl StrategySpec {
    /// The strategy of the kind `kind` that was read from `text`, with a remark about how.
    pub(super) fn read(
        text: &str,
        (kind, budgeted): (&str, bool),
        (make, remark): (Maker, Option<String>),
    ) -> Self {
        Self {
            text: text.to_owned(),
            kind: kind.to_owned(),
            budgeted,
            make,
            remark,
        }
    }

    /// A strategy of the caller's own, called `name` in results. `make` returns it as it is at the
    /// start of a run; every run gets a new one, so that runs in parallel share nothing.
    pub fn custom<S: Strategy + 'static>(
        name: impl Into<String>,
        make: impl Fn() -> S + Send + Sync + 'static,
    ) -> Self {
        let name = name.into();
        let blueprint = Blueprint::new(name.clone(), move || Box::new(make()));
        Self {
            text: name.clone(),
            kind: name,
            budgeted: false,
            make: Box::new(move |_| Ok(blueprint.clone())),
            remark: None,
        }
    }

    /// How it is written: the text from which it was read, or its name.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A remark about how it was read, if there is one.
    pub fn remark(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// The strategy for a line.
    ///
    /// # Errors
    /// Rules for another number of robots, or a budget that the strategy has not or already has.
    pub(crate) fn on(&self, setup: &Setup) -> Result<Blueprint> {
        if setup.allowance.asked.is_some() && !self.budgeted {
            return Err(Error::usage(
                "'budget_ms'",
                format!("does not apply to {}, which does not plan", self.kind),
                "remove it, or choose a strategy that plans, such as lookahead",
            ));
        }
        (self.make)(setup)
    }

    /// Checks that the strategy is for `station`, before any long work.
    ///
    /// # Errors
    /// As for [`StrategySpec::alone`], or what the strategy itself says about the station
    /// ([`Strategy::check_station`]).
    pub fn check_on(&self, station: &Station) -> Result<()> {
        let strategy = self.alone(station.robots().len())?.make();
        strategy.check_station(station)
    }

    /// The strategy for a line of `robots` robots about which nothing else is known. Strategies
    /// that need a base get the paper's robust assignment.
    ///
    /// # Errors
    /// Options that the strategy rejects, or rules for another number of robots.
    pub fn alone(&self, robots: usize) -> Result<Blueprint> {
        let bases = || Ok(vec![default_assignment(robots)]);
        self.on(&Setup {
            robots,
            bases: &bases,
            allowance: Allowance::default(),
        })
    }
}

/// The paper's robust assignment for a line of `robots` robots: SPT for all but the
/// last, FIFO for the last (Jermann et al., Table 1).
pub fn default_assignment(robots: usize) -> RuleAssignment {
    let mut rules = vec![Rule::SPT; robots];
    if let Some(last) = rules.last_mut() {
        *last = Rule::FIFO;
    }
    RuleAssignment::new(rules)
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use crate::planning::Budget;

    /// What is made from types is what is read from its text.
    #[test]
    fn specs_from_types_equal_specs_from_text() {
        let rules: RuleAssignment = "SPT,FIFO".parse().unwrap();
        let bases = vec![rules.clone()];
        let ahead = LookaheadOptions::default().with_depth(2).with_bases(bases);
        for (spec, text) in [
            (StrategySpec::from(rules), "rules:SPT,FIFO"),
            (ahead.clone().into(), "lookahead:bases=SPT+FIFO,depth=2"),
            (
                ahead.with_budget(Budget::Decisions(7)).into(),
                "lookahead:budget=7,bases=SPT+FIFO,depth=2",
            ),
        ] {
            let read = parse(text).unwrap();
            assert_eq!(spec.text(), read.text());
            let allowance = Allowance {
                asked: Some(Budget::Decisions(9)),
                otherwise: Budget::LIVE,
            };
            let names = |spec: &StrategySpec| {
                let setup = Setup {
                    robots: 2,
                    bases: &|| Ok(Vec::new()),
                    allowance,
                };
                let asked = spec.on(&setup).map(|blueprint| blueprint.make().name());
                let alone = spec.alone(2).unwrap();
                let name = (alone.name().to_owned(), alone.make().name());
                (asked.map_err(|error| error.to_string()), name)
            };
            assert_eq!(names(&spec), names(&read), "{text}");
            assert_eq!(
                spec.alone(3).unwrap_err().to_string(),
                read.alone(3).unwrap_err().to_string()
            );
        }
    }

    #[test]
    fn a_custom_strategy_is_made_for_every_run() {
        let spec = StrategySpec::custom("mine", || RuleStrategy(default_assignment(2)));
        let blueprint = spec.alone(2).unwrap();
        assert_eq!((spec.text(), blueprint.name()), ("mine", "mine"));
        assert_eq!(blueprint.make().name(), "rules:SPT,FIFO");
    }
}
