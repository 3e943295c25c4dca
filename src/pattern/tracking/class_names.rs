//! The names of the class ids that a detector writes.

use crate::error::{Error, Result, shown};
use crate::names::check_class_name;
use std::collections::BTreeMap;
use std::str::FromStr;

/// Largest class id; larger numbers are treated as mistakes.
const LARGEST_ID: u32 = 999_999;
/// How the names are given.
const FORM: &str = "give each class id once with its name, such as 1:pet,2:hdpe, or a file with one \
                    such pair on each line";

/// Names for the class ids of a recording, parsed from a text such as `1:pet,2:hdpe`. Several ids may
/// have the same name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ClassNames {
    names: BTreeMap<String, String>,
}

impl FromStr for ClassNames {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut names = Self::default();
        for pair in text.split(',') {
            let wrong = |problem| Error::usage("'class_names'", problem, FORM);
            names.add(pair).map_err(wrong)?;
        }
        Ok(names)
    }
}

impl ClassNames {
    /// The names in the text of the file `file`, with a pair such as `1:pet` on each line. A name may
    /// contain commas there. Blank lines are skipped, and so are those that begin with `#`.
    ///
    /// # Errors
    /// A line that is not such a pair, an id that occurs twice, or no pair at all.
    pub fn from_lines(text: &str, file: &str) -> Result<Self> {
        let mut names = Self::default();
        let lines = text.trim_start_matches('\u{feff}').lines();
        for (place, line) in lines.map(str::trim).enumerate() {
            if !line.is_empty() && !line.starts_with('#') {
                let place = format!("{file}:{}", place + 1);
                let wrong = |problem| Error::input(place, problem, FORM);
                names.add(line).map_err(wrong)?;
            }
        }
        if names.names.is_empty() {
            let problem = "there is no class id with a name";
            return Err(Error::input(file, problem, FORM));
        }
        Ok(names)
    }

    /// Adds a pair such as `1:pet`, or says what is wrong with it.
    fn add(&mut self, pair: &str) -> std::result::Result<(), String> {
        let Some((id, name)) = pair.trim().split_once(':') else {
            return Err(format!(
                "`{}` is not a class id with a name",
                shown(pair.trim())
            ));
        };
        let (id, name) = (id.trim(), name.trim());
        let number = id.parse().ok().filter(|id: &u32| *id <= LARGEST_ID);
        let number = number.ok_or_else(|| {
            format!(
                "`{}` is not a class id, a whole number from 0 to {LARGEST_ID}",
                shown(id)
            )
        })?;
        check_class_name(name).map_err(|bad| format!("class id {number}: {}", bad.problem))?;
        match self.names.insert(number.to_string(), name.to_owned()) {
            Some(_) => Err(format!("class id {number} occurs twice")),
            None => Ok(()),
        }
    }

    /// The name of this class id, and the id itself.
    pub(super) fn find(&self, id: &str) -> Option<(&str, &str)> {
        let found = self.names.get_key_value(id);
        found.map(|(id, name)| (id.as_str(), name.as_str()))
    }

    /// All ids that have a name.
    pub(super) fn ids(&self) -> impl Iterator<Item = &str> {
        self.names.keys().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_cannot_be_are_refused() {
        for (text, words) in [
            ("", "`` is not a class id with a name"),
            ("pet", "`pet` is not a class id with a name"),
            ("1:pet,", "`` is not a class id with a name"),
            ("pet:1", "`pet` is not a class id"),
            ("-1:pet", "`-1` is not a class id"),
            ("1.5:pet", "`1.5` is not a class id"),
            ("1000000:pet", "`1000000` is not a class id"),
            ("1:", "class id 1: `` is empty"),
            ("1:pet,01:hdpe", "class id 1 occurs twice"),
        ] {
            let message = text.parse::<ClassNames>().unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
            assert!(message.contains("1:pet,2:hdpe"), "{message}");
        }
        for (text, words) in [
            ("1:a\n2", "names.txt:2: `2` is not a class id with a name"),
            ("1:a\n\n1:b", "names.txt:3: class id 1 occurs twice"),
            ("# nothing\n", "names.txt: there is no class id with a name"),
        ] {
            let error = ClassNames::from_lines(text, "names.txt").unwrap_err();
            assert!(error.to_string().contains(words), "{text}: {error}");
        }
    }
}
