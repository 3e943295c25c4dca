//! All strategies in one list: how each is written on the command line and made.

use crate::decision::Strategy;
use crate::dispatch::{RuleAssignment, RuleStrategy};
use crate::error::{Error, Result, known_names, shown};

/// One kind of strategy.
pub struct StrategyKind {
    /// What stands before the colon.
    pub name: &'static str,
    /// How it is written.
    pub form: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// Makes it from what stands after the colon, for so many robots.
    build: fn(&str, usize) -> Result<Box<dyn Strategy>>,
}

/// Every kind of strategy.
pub static STRATEGIES: &[StrategyKind] = &[StrategyKind {
    name: "rules",
    form: "rules:R1,R2,...",
    summary: "one dispatching rule for each robot, upstream first",
    build: |text, robots| {
        let rules: RuleAssignment = text.parse()?;
        Ok(Box::new(RuleStrategy(rules.for_robots(robots)?)))
    },
}];

/// The strategy that `text` names, for a line of `robots` robots. Rules may stand
/// alone: `SPT,FIFO` and `[SPT; FIFO]` mean `rules:SPT,FIFO`.
///
/// # Errors
/// An unknown name, with the nearest known one; options that the strategy refuses.
pub fn build(text: &str, robots: usize) -> Result<Box<dyn Strategy>> {
    let (name, rest) = match text.split_once(':') {
        Some((name, rest)) => (name, rest),
        None if STRATEGIES.iter().any(|kind| kind.name == text) => (text, ""),
        None => ("rules", text),
    };
    match STRATEGIES.iter().find(|kind| kind.name == name) {
        Some(kind) => (kind.build)(rest, robots),
        None => {
            let names: Vec<_> = STRATEGIES.iter().map(|kind| kind.name).collect();
            let forms: Vec<_> = STRATEGIES.iter().map(|kind| kind.form).collect();
            Err(Error::input(
                "--strategy",
                format!("unknown strategy `{}`", shown(name)),
                format!(
                    "{}; written {}",
                    known_names(name, &names),
                    forms.join(", ")
                ),
            ))
        }
    }
}

/// The paper's robust assignment for a line of `robots` robots: SPT for all but the
/// last, FIFO for the last (Jermann et al., Table 1).
pub fn default_strategy(robots: usize) -> String {
    let mut rules = vec!["SPT"; robots];
    if let Some(last) = rules.last_mut() {
        *last = "FIFO";
    }
    format!("rules:{}", rules.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strategies_are_built_by_name() {
        for text in ["rules:SPT,FIFO", "SPT,FIFO", "[SPT; FIFO]"] {
            assert_eq!(build(text, 2).unwrap().name(), "rules:SPT,FIFO");
        }
        assert_eq!(default_strategy(3), "rules:SPT,SPT,FIFO");
        for (text, word) in [
            ("rulse:SPT,FIFO", "did you mean `rules`"),
            ("rules", "names no rule"),
            ("SPT", "1 rules for 2 robots"),
            ("SPT,FOFI", "did you mean `FIFO`"),
        ] {
            let message = build(text, 2).err().unwrap().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
