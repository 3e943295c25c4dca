//! The list of all rules, from which help texts, parsing, the search and the table in the
//! documentation are derived.

use super::DispatchingRule;
use super::fifo::Fifo;
use super::ld::Ld;
use super::lpt::Lpt;
use super::pp::Pp;
use super::sd::Sd;
use super::spt::Spt;
use crate::error::{Error, Result, known_names, shown};
use std::fmt;
use std::str::FromStr;

/// Every rule (Jermann et al., list of single-player strategies). The order affects results: it
/// decides the order of assignments that are otherwise equal.
pub static RULES: &[&dyn DispatchingRule] = &[&Fifo, &Spt, &Lpt, &Sd, &Ld, &Pp];

/// A rule, identified by its index in [`RULES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Rule(u8);

impl Rule {
    /// First in, first out.
    pub const FIFO: Self = Self(0);
    /// Shortest processing time.
    pub const SPT: Self = Self(1);
    /// Priority picking.
    pub const PP: Self = Self(5);
    /// The first rule of the registry.
    pub(super) const FIRST: Self = Self(0);

    /// All rules, in registry order.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator + Clone {
        // The registry is short, so the cast is safe.
        (0..RULES.len() as u8).map(Self)
    }

    /// Index in the registry.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// The rule after this one in the registry; `None` for the last.
    pub(super) fn next(self) -> Option<Self> {
        (self.index() + 1 < RULES.len()).then_some(Self(self.0 + 1))
    }
}

impl std::ops::Deref for Rule {
    type Target = dyn DispatchingRule;

    fn deref(&self) -> &Self::Target {
        RULES[self.index()]
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Rule {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::all()
            .find(|rule| rule.name().eq_ignore_ascii_case(text))
            .ok_or_else(|| {
                let names: Vec<_> = RULES.iter().map(|rule| rule.name()).collect();
                Error::usage(
                    "'strategy'",
                    format!("`{}` is not a dispatching rule", shown(text)),
                    known_names(text, &names),
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_the_rules_of_their_names() {
        let names = [Rule::FIFO, Rule::SPT, Rule::PP].map(|rule| rule.name());
        assert_eq!(names, ["FIFO", "SPT", "PP"]);
    }

    #[test]
    fn names_are_unique_and_read_back() {
        for rule in Rule::all() {
            assert_eq!(rule.name().parse::<Rule>().unwrap(), rule);
            assert_eq!(rule.name().to_lowercase().parse::<Rule>().unwrap(), rule);
        }
        let message = "STP".parse::<Rule>().unwrap_err().to_string();
        assert!(message.contains("did you mean `SPT`"), "{message}");
    }
}
