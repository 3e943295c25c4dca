//! A list of all strategies: how each is written and created.

use super::blueprint::Blueprint;
use super::spec::{
    LOOKAHEAD, Maker, RULES, StrategySpec, default_assignment, lookahead_maker, own_maker,
    rule_maker,
};
use crate::allocation::{Every, Share, Zones};
use crate::decision::Strategy;
use crate::dispatch::Rule;
use crate::error::{Error, Result, known_names, shown};
use crate::planning::{KEYS, WrittenOptions};
#[cfg(feature = "onnx")]
use crate::policy::{Policy, PolicyStrategy, Trained};
use std::path::Path;

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

/// A strategy that was read, and a remark about how.
type ReadStrategy = (Maker, Option<String>);

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
        name: "share",
        form: "share:W1,W2,...[,K=V]",
        summary: "weighted round robin in order of arrival; each robot takes its own",
        options: &Share::KEYS,
        budgeted: false,
        read: |text| allocation(Share::read(text.unwrap_or_default())?),
    },
    StrategyKind {
        name: "every",
        form: "every:N1,N2,...[,K=V]",
        summary: "each robot takes every N-th item that reaches it",
        options: &Every::KEYS,
        budgeted: false,
        read: |text| allocation(Every::read(text.unwrap_or_default())?),
    },
    StrategyKind {
        name: "zones",
        form: "zones[:Y1,Y2,...][,K=V]",
        summary: "each robot takes the items in its band across the belt [equal bands]",
        options: &Zones::KEYS,
        budgeted: false,
        read: |text| allocation(Zones::read(text.unwrap_or_default())?),
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

/// A strategy that is the same for every line of its number of robots.
fn allocation(strategy: impl Strategy + Clone + Send + Sync + 'static) -> Result<ReadStrategy> {
    Ok((own_maker(strategy), None))
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
    let blueprint = Blueprint::new(name, move || {
        Box::new(PolicyStrategy::new(written.clone(), &policy))
    });
    Ok((blueprint.trained_on(trained), remark))
}

#[cfg(not(feature = "onnx"))]
fn read_policy(_: Option<&str>) -> Result<(Blueprint, Option<String>)> {
    Err(Error::usage(
        "'strategy' onnx",
        "pickline was built without the feature `onnx`, which trained policies need",
        "build it with that feature, which is on by default, or choose another strategy",
    ))
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
        return Ok(StrategySpec::read(
            text,
            (kind.name, kind.budgeted),
            (kind.read)(rest)?,
        ));
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

/// [`default_assignment`] as the name of a strategy.
pub fn default_strategy(robots: usize) -> String {
    format!("rules:{}", default_assignment(robots).names().join(","))
}

#[cfg(test)]
mod tests {
    use super::super::blueprint::Setup;
    use super::*;
    use crate::planning::Allowance;

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
