//! How allocations are written: values first, then options, such as `share:40,60,rule=SPT`.

use crate::error::{Error, Result, counted, known_names, shown};

/// The text after the colon, taken apart.
#[derive(Debug)]
pub(super) struct Written<'a> {
    /// The name of the strategy.
    kind: &'static str,
    /// What has no key.
    pub values: Vec<&'a str>,
    /// Keys and values of the options.
    pub options: Vec<(&'a str, &'a str)>,
}

impl<'a> Written<'a> {
    /// Takes `text` apart; `keys` are the options that the strategy knows.
    ///
    /// # Errors
    /// An option that is unknown or given twice.
    pub(super) fn read(
        kind: &'static str,
        text: &'a str,
        keys: &[(&'static str, &str)],
    ) -> Result<Self> {
        let mut written = Self {
            kind,
            values: Vec::new(),
            options: Vec::new(),
        };
        if text.trim().is_empty() {
            return Ok(written);
        }
        for part in text.split(',') {
            let Some((key, value)) = part.split_once('=') else {
                written.values.push(part.trim());
                continue;
            };
            let (key, value) = (key.trim(), value.trim());
            if !keys.iter().any(|(known, _)| *known == key) {
                let names: Vec<_> = keys.iter().map(|(known, _)| *known).collect();
                return Err(Error::usage(
                    format!("'strategy' {kind}"),
                    format!("unknown option `{}`", shown(key)),
                    known_names(key, &names),
                ));
            }
            if written.options.iter().any(|(given, _)| *given == key) {
                return Err(written.wrong(key, "is given twice", "give it once"));
            }
            written.options.push((key, value));
        }
        Ok(written)
    }

    /// Where the option `key` stands, for messages.
    pub(super) fn place(&self, key: &str) -> String {
        format!("'strategy' {}:{key}", self.kind)
    }

    /// An error at the option `key`.
    pub(super) fn wrong(&self, key: &str, problem: &str, cure: &str) -> Error {
        Error::usage(self.place(key), problem, cure)
    }

    /// The values as numbers.
    ///
    /// # Errors
    /// One that is not a number of the `range`, which `cure` says.
    pub(super) fn numbers(
        &self,
        range: std::ops::RangeInclusive<f64>,
        cure: &str,
    ) -> Result<Vec<f64>> {
        let read = |text: &&str| {
            let number = text.parse().ok().filter(|number| range.contains(number));
            number.ok_or_else(|| {
                Error::usage(
                    format!("'strategy' {}", self.kind),
                    format!("`{}` is not a valid value", shown(text)),
                    cure,
                )
            })
        };
        self.values.iter().map(read).collect()
    }
}

/// Checks that a strategy of this `kind` has `needed` values for a line of `robots` robots.
///
/// # Errors
/// If `given`, the number of its values, which are called `what`, is another.
pub(super) fn check_count(
    kind: &str,
    (given, what): (usize, &str),
    needed: usize,
    robots: usize,
    cure: &str,
) -> Result<()> {
    if given == needed {
        return Ok(());
    }
    Err(Error::usage(
        format!("'strategy' {kind}"),
        format!("{} for {}", counted(given, what), counted(robots, "robot")),
        cure,
    ))
}
