//! Classes drawn with given shares.

use super::item::Pattern;
use crate::error::{Error, Result, shown, shown_number};
use crate::names::check_class_name;
use crate::station::Station;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// Shares may exceed 1 together by this much, which is due to rounding.
const ROUNDING: f64 = 1e-9;

/// The shares of classes among generated items, parsed from a text such as `pet:0.4,hdpe:0.3`. If
/// they add up to less than 1, the other items have no class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassShares {
    shares: Vec<(String, f64)>,
}

impl FromStr for ClassShares {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |problem: String| {
            Error::usage(
                format!("classes `{}`", shown(text)),
                problem,
                "write each class with its share, such as pet:0.4,hdpe:0.3,wood:0.3; together at \
                 most 1",
            )
        };
        let mut shares: Vec<(String, f64)> = Vec::new();
        for part in text.split(',') {
            // A name may contain a colon, a share cannot.
            let Some((name, share)) = part.trim().rsplit_once(':') else {
                return Err(wrong(format!("`{}` has no share", shown(part.trim()))));
            };
            if is_several(name) {
                return Err(wrong(format!(
                    "`{}` reads like several classes, which commas separate",
                    shown(part.trim())
                )));
            }
            check_class_name(name).map_err(|bad| wrong(bad.problem))?;
            let number = share.trim().parse().ok();
            let Some(number) = number.filter(|n: &f64| *n > 0.0 && *n <= 1.0 + ROUNDING) else {
                return Err(wrong(format!(
                    "`{}` is not a share: above 0, at most 1",
                    shown(share)
                )));
            };
            if shares.iter().any(|(other, _)| other == name) {
                return Err(wrong(format!("class `{}` occurs twice", shown(name))));
            }
            shares.push((name.to_owned(), number));
        }
        let sum: f64 = shares.iter().map(|(_, share)| share).sum();
        if sum > 1.0 + ROUNDING {
            let sum = shown_number(sum);
            return Err(wrong(format!("the shares add up to {sum}")));
        }
        Ok(Self { shares })
    }
}

/// Whether a name holds a class with its share and then more: other separators than commas.
fn is_several(name: &str) -> bool {
    let separates = |c: char| !(c.is_alphanumeric() || ":._-".contains(c));
    let has_share = |part: &str| {
        let share = part.rsplit_once(':').map(|(_, share)| share.parse());
        matches!(share, Some(Ok::<f64, _>(_)))
    };
    let mut parts = name.split(separates);
    parts.next_back();
    parts.any(has_share)
}

impl fmt::Display for ClassShares {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let parts = self.shares.iter();
        let parts = parts.map(|(name, share)| format!("{name}:{}", shown_number(*share)));
        f.write_str(&parts.collect::<Vec<_>>().join(","))
    }
}

impl ClassShares {
    /// Shares of `classes` that add up to 1, all of which are equally likely; `None` without classes.
    ///
    /// They are exponential variates over their sum (Devroye 1986, Non-Uniform Random Variate
    /// Generation, DOI 10.1007/978-1-4613-8643-8, theorem V.2.2).
    pub(crate) fn drawn<'c>(
        classes: impl Iterator<Item = &'c str>,
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let exponential = |class: &str| (class.to_owned(), -(1.0 - rng.random::<f64>()).ln());
        let mut shares: Vec<(String, f64)> = classes.map(exponential).collect();
        let sum: f64 = shares.iter().map(|(_, share)| share).sum();
        for (_, share) in &mut shares {
            *share /= sum;
        }
        (sum > 0.0).then_some(Self { shares })
    }

    /// The same share of every class that a robot of `station` has a bin for and that is not unwanted,
    /// and of items without a class if there is a bin for them. `None` if bins name no class.
    pub(crate) fn even(station: &Station) -> Option<Self> {
        let bins = || station.robots().iter().flat_map(|robot| &robot.bins);
        let named = bins().filter_map(|bin| bin.classes.as_ref()).flatten();
        let is_wanted = |class: &&String| station.class(class).is_none_or(|class| class.wanted);
        let classes: BTreeSet<&String> = named.filter(is_wanted).collect();
        let kinds = classes.len() + usize::from(bins().any(|bin| bin.classes.is_none()));
        let share = 1.0 / kinds as f64;
        let shares: Vec<_> = classes
            .into_iter()
            .map(|name| (name.clone(), share))
            .collect();
        (!shares.is_empty()).then_some(Self { shares })
    }

    /// The pattern with a class drawn for every item, in index order.
    ///
    /// # Errors
    /// Never, because the names are valid; a `Result` avoids a panic.
    pub fn apply(&self, pattern: &Pattern, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        let mut items = pattern.items().to_vec();
        for item in &mut items {
            let mut left: f64 = rng.random();
            let drawn = self.shares.iter().find(|(_, share)| {
                left -= share;
                left < 0.0
            });
            item.class = drawn.map(|(name, _)| name.clone());
        }
        Pattern::new(items)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{grid, random_stream};

    #[test]
    fn classes_have_their_shares_and_the_rest_has_none() {
        let shares: ClassShares = "pet:0.5, a:b:0.2".parse().unwrap();
        assert_eq!(shares.to_string(), "pet:0.5,a:b:0.2");
        let pattern = grid(1.0, 0.05, 4000).unwrap();
        let drawn = shares.apply(&pattern, &mut random_stream(3, 0)).unwrap();
        for (class, share) in [(Some("pet"), 0.5), (Some("a:b"), 0.2), (None, 0.3)] {
            let items = drawn.items().iter();
            let count = items.filter(|item| item.class.as_deref() == class).count();
            assert!((count as f64 / 4000.0 - share).abs() < 0.025, "{class:?}");
        }
        // Nothing else changes.
        let places = |p: &Pattern| -> Vec<_> { p.items().iter().map(|i| (i.x0, i.y)).collect() };
        assert_eq!(places(&drawn), places(&pattern));
    }

    #[test]
    fn drawn_shares_add_up_to_one_and_differ() {
        let mut rng = random_stream(4, 0);
        let mut draw = || ClassShares::drawn(["a", "b", "c"].into_iter(), &mut rng).unwrap();
        let (mut first, draws) = (0.0, 2_000);
        for _ in 0..draws {
            let shares = draw().shares;
            let sum: f64 = shares.iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-12 && shares.len() == 3);
            // The share of one of three is below one half with probability 3/4.
            first += f64::from(shares[0].1 < 0.5);
        }
        assert!((first / f64::from(draws) - 0.75).abs() < 0.03, "{first}");
        assert_eq!(ClassShares::drawn(std::iter::empty(), &mut rng), None);
    }

    #[test]
    fn shares_that_cannot_be_are_refused() {
        for (text, words) in [
            ("", "has no share"),
            ("pet", "`pet` has no share"),
            ("pet:0", "`0` is not a share"),
            ("pet:-1", "`-1` is not a share"),
            ("pet:nan", "`nan` is not a share"),
            ("pet:inf", "`inf` is not a share"),
            (":0.5", "is empty"),
            ("pet:0.4,pet:0.1", "occurs twice"),
            ("pet:0.7,hdpe:0.4", "add up to 1.1"),
        ] {
            let message = text.parse::<ClassShares>().unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}
