//! A list of all strategies: how each is written and created.

use crate::decision::Strategy;
use crate::dispatch::{Rule, RuleAssignment, RuleStrategy};
use crate::error::{Error, Result, known_names, shown};
use crate::planning::{Allowance, KEYS, Lookahead, WrittenOptions};
use crate::policy::Trained;
#[cfg(feature = "onnx")]
use crate::policy::{Policy, PolicyStrategy};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// One kind of strategy.
pub struct StrategyKind {
    /// The name: what is written before the colon.
    pub name: &'static str,
    /// How it is written, with placeholders for what follows the colon.
    pub form: &'static str,
    /// What the strategy does, in one line.
    pub summary: &'static str,
    /// Its options and their meanings.
    pub options: &'static [(&'static str, &'static str)],
    /// Whether its decisions have a budget.
    budgeted: bool,
    /// Reads the text after the colon (`None` without a colon). Also returns a remark about how
    /// it was read, if there is one.
    read: fn(Option<&str>) -> Result<ReadStrategy>,
}

/// Creates a strategy for a line after its text was read.
type Maker = Box<dyn Fn(&Setup) -> Result<Blueprint> + Send + Sync>;

/// A strategy that was read, and a remark about how.
type ReadStrategy = (Maker, Option<String>);

/// Every kind of strategy.
pub static STRATEGIES: &[StrategyKind] = &[
    StrategyKind {
        name: "rules",
        form: "rules:R1,R2,...",
        summary: "one dispatching rule for each robot, upstream first",
        options: &[],
        budgeted: false,
        read: |text| {
            let rules: RuleAssignment = text.unwrap_or_default().parse()?;
            let make: Maker = Box::new(move |setup| {
                let strategy = RuleStrategy(rules.clone().for_robots(setup.robots)?);
                Ok(Blueprint::new(strategy.name(), move || {
                    Box::new(strategy.clone())
                }))
            });
            Ok((make, None))
        },
    },
    StrategyKind {
        name: "lookahead",
        form: "lookahead[:KEY=VALUE,...]",
        summary: "plans ahead for all robots over the items in view, at every decision",
        options: &KEYS,
        budgeted: true,
        read: |text| {
            let written = WrittenOptions::read(text.unwrap_or_default())?;
            let make: Maker = Box::new(move |setup| {
                let mut options = written.on(setup.robots, setup.allowance)?;
                let name = options.written();
                if options.bases.is_empty() {
                    options.bases = (setup.bases)()?;
                }
                Ok(Blueprint::new(name, move || {
                    Box::new(Lookahead::new(options.clone()))
                }))
            });
            Ok((make, None))
        },
    },
    StrategyKind {
        name: POLICY,
        form: "onnx[:FILE]",
        summary: "a trained policy; without a file, the one that ships with the program",
        options: &[],
        budgeted: false,
        read: |file| {
            let (policy, remark) = read_policy(file)?;
            Ok((Box::new(move |_| Ok(policy.clone())), remark))
        },
    },
];

/// How the built-in policy is written.
pub const POLICY: &str = "onnx";
/// Whether the program contains it.
pub(crate) const HAS_POLICY: bool = cfg!(feature = "onnx");

/// Whether `text` names a trained policy.
pub fn is_policy(text: &str) -> bool {
    text.split_once(':').map_or(text, |(name, _)| name) == POLICY
}

/// The file of the policy that `text` names, if it names one.
pub fn policy_file(text: &str) -> Option<&Path> {
    let (name, file) = text.split_once(':')?;
    (name == POLICY).then(|| Path::new(file))
}

/// The files that contain weights of the policy in `file`; empty for any other file.
#[cfg(feature = "onnx")]
pub fn weight_files(file: &Path) -> Vec<std::path::PathBuf> {
    crate::policy::weight_files(file)
}

/// Without policy support, no files besides `file` are read.
#[cfg(not(feature = "onnx"))]
pub fn weight_files(_: &Path) -> Vec<std::path::PathBuf> {
    Vec::new()
}

/// A name that users try in order to get the bound.
const BOUND: &str = "bound";

/// The policy in `file`, or the built-in one.
#[cfg(feature = "onnx")]
fn read_policy(file: Option<&str>) -> Result<(Blueprint, Option<String>)> {
    let (policy, name) = match file {
        None => (Policy::shipped()?, POLICY.to_owned()),
        // For example a script's variable that is not set; the built-in policy would be the
        // wrong one.
        Some("") => {
            return Err(Error::usage(
                "'strategy' onnx:",
                "has no file after the colon",
                "give the policy's file, or plain `onnx` for the one that ships with the program",
            ));
        }
        Some(file) => (Policy::load(Path::new(file))?, format!("{POLICY}:{file}")),
    };
    let (written, remark) = (name.clone(), policy.remark().map(str::to_owned));
    let trained = Trained::read(policy.metadata());
    let blueprint = Blueprint {
        trained: trained.map(Arc::new),
        ..Blueprint::new(name, move || {
            Box::new(PolicyStrategy::new(written.clone(), &policy))
        })
    };
    Ok((blueprint, remark))
}

#[cfg(not(feature = "onnx"))]
fn read_policy(_: Option<&str>) -> Result<(Blueprint, Option<String>)> {
    Err(Error::usage(
        "'strategy' onnx",
        "pickline was built without the feature `onnx`, which trained policies need",
        "build it with that feature, which is on by default, or choose another strategy",
    ))
}

/// The line for which a strategy is created.
pub(crate) struct Setup<'a> {
    /// Number of robots.
    pub robots: usize,
    /// Finds assignments that perform well on the line, best first. Only strategies that need
    /// them call it, because it may run a search.
    pub bases: &'a dyn Fn() -> Result<Vec<RuleAssignment>>,
    /// Budget of a decision of a strategy that plans, unless its options set one.
    pub allowance: Allowance,
}

/// A strategy read once and created again for every run: runs share nothing, so they can run in
/// any order and in parallel.
#[derive(Clone)]
pub struct Blueprint {
    name: String,
    make: Arc<dyn Fn() -> Box<dyn Strategy> + Send + Sync>,
    trained: Option<Arc<Trained>>,
}

impl Blueprint {
    fn new(name: String, make: impl Fn() -> Box<dyn Strategy> + Send + Sync + 'static) -> Self {
        Self {
            name,
            make: Arc::new(make),
            trained: None,
        }
    }

    /// How the strategy is written, as [`parse`] reads it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it was trained on, if it is a policy with this information.
    pub(crate) fn trained(&self) -> Option<&Trained> {
        self.trained.as_deref()
    }

    /// The strategy at the start of a run.
    pub fn make(&self) -> Box<dyn Strategy> {
        (self.make)()
    }
}

impl fmt::Debug for Blueprint {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("Blueprint").field(&self.name).finish()
    }
}

/// The part of a strategy that does not depend on the line: its parsed text, and its file,
/// which is not read again.
pub struct Parsed {
    text: String,
    kind: &'static StrategyKind,
    make: Maker,
    remark: Option<String>,
}

impl fmt::Debug for Parsed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("Parsed").field(&self.text).finish()
    }
}

impl Parsed {
    /// The text from which it was read.
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
        if setup.allowance.asked.is_some() && !self.kind.budgeted {
            return Err(Error::usage(
                "'budget_ms'",
                format!("does not apply to {}, which does not plan", self.kind.name),
                "remove it, or choose a strategy that plans, such as lookahead",
            ));
        }
        (self.make)(setup)
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

/// The strategy that `text` names. Rules need no prefix: `SPT,FIFO` and `[SPT; FIFO]` mean
/// `rules:SPT,FIFO`.
///
/// # Errors
/// An unknown name (the message suggests the nearest known one), an unknown option or one with an
/// invalid value, or a file that is not a policy.
pub fn parse(text: &str) -> Result<Parsed> {
    let (name, rest) = match text.split_once(':') {
        Some((name, rest)) => (name, Some(rest)),
        None if STRATEGIES.iter().any(|kind| kind.name == text) => (text, None),
        // A single word that is not a rule is a mistyped name.
        None if !text.is_empty()
            && !text.contains([',', ';', '['])
            && text.parse::<Rule>().is_err() =>
        {
            (text, None)
        }
        None => ("rules", Some(text)),
    };
    if let Some(kind) = STRATEGIES.iter().find(|kind| kind.name == name) {
        let (make, remark) = (kind.read)(rest)?;
        return Ok(Parsed {
            text: text.to_owned(),
            kind,
            make,
            remark,
        });
    }
    if name == BOUND {
        return Err(Error::usage(
            "'strategy'",
            "the bound is not a strategy: it is what no strategy can exceed",
            "remove it; every comparison, sweep and simulation shows the bound unless \
             'no_bound' is given, and `pickline bound` computes only the bound",
        ));
    }
    let names: Vec<_> = STRATEGIES.iter().map(|kind| kind.name).collect();
    Err(Error::usage(
        "'strategy'",
        format!("unknown strategy `{}`", shown(name)),
        format!("{}; written {}", known_names(name, &names), forms()),
    ))
}

/// The strategy that `text` names, for a line of `robots` robots as in [`Parsed::alone`].
///
/// # Errors
/// As for [`parse`] and [`Parsed::alone`].
pub fn read_alone(text: &str, robots: usize) -> Result<Blueprint> {
    parse(text)?.alone(robots)
}

/// How every kind of strategy is written, as a list.
pub fn forms() -> String {
    let forms: Vec<_> = STRATEGIES.iter().map(|kind| kind.form).collect();
    forms.join(", ")
}

/// All strategies and their options, for help texts.
pub fn help() -> String {
    let mut help = String::new();
    for kind in STRATEGIES {
        help += &format!("  {:<27}{}\n", kind.form, kind.summary);
        for (key, meaning) in kind.options {
            help += &format!("      {key:<11}{meaning}\n");
        }
    }
    help
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

/// [`default_assignment`] as the name of a strategy.
pub fn default_strategy(robots: usize) -> String {
    format!("rules:{}", default_assignment(robots).names().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strategies_are_read_by_name() {
        let bases = || Ok(vec!["SPT,FIFO".parse()?]);
        let setup = Setup {
            robots: 2,
            bases: &bases,
            allowance: Allowance::default(),
        };
        let read = |text: &str| parse(text)?.on(&setup);
        for text in ["rules:SPT,FIFO", "SPT,FIFO", "[SPT; FIFO]"] {
            let blueprint = read(text).unwrap();
            assert_eq!(blueprint.name(), "rules:SPT,FIFO");
            assert_eq!(blueprint.make().name(), blueprint.name());
        }
        let ahead = read("lookahead:seed=3").unwrap();
        assert_eq!(ahead.name(), "lookahead:seed=3");
        // Its full name contains what it was created with.
        assert_eq!(ahead.make().name(), "lookahead:bases=SPT+FIFO,seed=3");
        assert_eq!(default_strategy(3), "rules:SPT,SPT,FIFO");
        for (text, word) in [
            ("rulse:SPT,FIFO", "did you mean `rules`"),
            ("lookahed:seed=1", "did you mean `lookahead`"),
            ("lookahaed", "did you mean `lookahead`"),
            ("rules", "contains no rule"),
            ("SPT", "1 rule for 2 robots"),
            ("SPT,FOFI", "did you mean `FIFO`"),
            ("lookahead:sed=1", "did you mean `seed`"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
            assert_eq!(read_alone(text, 2).unwrap_err().to_string(), message);
        }
    }

    /// A script with an empty variable must not get the built-in policy.
    #[cfg(feature = "onnx")]
    #[test]
    fn only_the_bare_name_is_the_policy_that_ships() {
        assert_eq!(read_alone("onnx", 2).unwrap().name(), "onnx");
        let message = read_alone("onnx:", 2).unwrap_err().to_string();
        for word in ["'strategy' onnx:", "has no file", "plain `onnx`"] {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }

    #[test]
    fn the_bound_is_said_to_be_no_strategy() {
        let message = read_alone("bound", 2).unwrap_err().to_string();
        for word in [
            "'strategy'",
            "not a strategy",
            "'no_bound'",
            "pickline bound",
        ] {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
}
