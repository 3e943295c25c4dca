//! A list of all strategies: how each is written and created.

use crate::decision::Strategy;
use crate::dispatch::{Rule, RuleAssignment, RuleStrategy};
use crate::error::{Error, Result, known_names, shown};
use crate::planning::{Allowance, KEYS, Lookahead, LookaheadOptions, WrittenOptions};
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

/// The name of rule assignments among the strategies.
const RULES: &str = "rules";
/// The name of the look-ahead.
const LOOKAHEAD: &str = "lookahead";

/// Every kind of strategy.
pub static STRATEGIES: &[StrategyKind] = &[
    StrategyKind {
        name: RULES,
        form: "rules:R1,R2,...",
        summary: "one dispatching rule for each robot, upstream first",
        options: &[],
        budgeted: false,
        read: |text| Ok((rule_maker(text.unwrap_or_default().parse()?), None)),
    },
    StrategyKind {
        name: LOOKAHEAD,
        form: "lookahead[:KEY=VALUE,...]",
        summary: "plans ahead for all robots over the items in view, at every decision",
        options: &KEYS,
        budgeted: true,
        read: |text| {
            let written = WrittenOptions::read(text.unwrap_or_default())?;
            Ok((lookahead_maker(written), None))
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

/// Makes the strategy of `rules`.
fn rule_maker(rules: RuleAssignment) -> Maker {
    Box::new(move |setup| {
        let strategy = RuleStrategy(rules.clone().for_robots(setup.robots)?);
        Ok(Blueprint::new(strategy.name(), move || {
            Box::new(strategy.clone())
        }))
    })
}

/// Makes the look-ahead with the options `written`.
fn lookahead_maker(written: WrittenOptions) -> Maker {
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

/// A strategy for a line that is not known yet.
///
/// [`parse`] reads one from text. Rules and the look-ahead are also made from their types, and
/// [`StrategySpec::custom`] makes one of any [`Strategy`]:
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
pub fn parse(text: &str) -> Result<StrategySpec> {
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
        None => (RULES, Some(text)),
    };
    if let Some(kind) = STRATEGIES.iter().find(|kind| kind.name == name) {
        let (make, remark) = (kind.read)(rest)?;
        return Ok(StrategySpec {
            text: text.to_owned(),
            kind: kind.name.into(),
            budgeted: kind.budgeted,
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

/// The strategy that `text` names, for a line of `robots` robots as in [`StrategySpec::alone`].
///
/// # Errors
/// As for [`parse`] and [`StrategySpec::alone`].
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
    use crate::planning::Budget;

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
    fn the_bound_is_rejected_as_a_strategy() {
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
