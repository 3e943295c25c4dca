//! The names of the class ids that a detector writes.

use super::formats::FileLines;
use super::report::named;
use crate::error::{Error, Result, shown};
use crate::names::check_name;
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
        check_name(name).map_err(|bad| format!("class id {number}: {}", bad.problem))?;
        match self.names.insert(number.to_string(), name.to_owned()) {
            Some(_) => Err(format!("class id {number} occurs twice")),
            None => Ok(()),
        }
    }

    /// Replaces the class ids of all boxes by their names; messages call the recording `file`.
    ///
    /// # Errors
    /// An id without a name, a class that is a name already, or a recording without classes.
    pub(super) fn apply(&self, lines: &mut FileLines, file: &str) -> Result<()> {
        let mut unnamed: Vec<String> = Vec::new();
        let mut first = String::new();
        let mut used: Vec<&str> = Vec::new();
        for line in &mut lines.lines {
            let Ok(row) = &mut line.row else { continue };
            // -1 stands for a box without a class.
            let Some(class) = row.class.take().filter(|class| class != "-1") else {
                continue;
            };
            if let Some((id, name)) = self.names.get_key_value(&class) {
                row.class = Some(name.clone());
                if !used.contains(&id.as_str()) {
                    used.push(id);
                }
            } else if !unnamed.contains(&class) {
                if unnamed.is_empty() {
                    first = match &line.file {
                        Some(part) => format!("{file}/{part}:{}", line.number),
                        None => format!("{file}:{}", line.number),
                    };
                }
                unnamed.push(class);
            }
        }
        if let Some(class) = unnamed.first() {
            return Err(self.without_name(&first, class, &unnamed));
        }
        if used.is_empty() {
            return Err(Error::usage(
                "'class_names'",
                format!("no box of {file} has a class"),
                "leave it out, or give a recording with class ids",
            ));
        }
        let named_ids = used.len();
        lines.remarks.push(format!("{named_ids} class ids named"));
        let idle = self.names.keys().map(String::as_str);
        let idle: Vec<&str> = idle.filter(|id| !used.contains(id)).collect();
        if !idle.is_empty() {
            let ids = named(idle.iter().copied());
            lines
                .remarks
                .push(format!("named class ids without a box: {ids}"));
        }
        Ok(())
    }

    /// The error for the classes `unnamed`, the first of which, `class`, stands at `place`.
    fn without_name(&self, place: &str, class: &str, unnamed: &[String]) -> Error {
        if class.parse::<u32>().is_err() {
            return Error::input(
                place,
                format!("class `{}` is a name, not a class id", shown(class)),
                "leave out 'class_names': the classes of this recording have names",
            );
        }
        let more = match unnamed.len() {
            1 => String::new(),
            _ => format!(
                ", of all without one: {}",
                named(unnamed.iter().map(String::as_str))
            ),
        };
        Error::input(
            place,
            format!("class id {class} has no name{more}"),
            format!("add it to 'class_names', such as {class}:wood"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::import::import_text;
    use super::super::options::{ImageAxis, ImportOptions};
    use super::*;

    fn options(names: &str) -> ImportOptions {
        with(names.parse().unwrap())
    }

    fn with(names: ClassNames) -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1).with_class_names(names)
    }

    /// Tracks with the class ids 1, 2, none and again 1.
    fn recording() -> String {
        let mut text = String::new();
        for (track, class) in [(1, 1), (2, 2), (3, -1), (4, 1)] {
            for frame in 1..6 {
                let left = 10 * frame + 200 * track;
                text += &format!(
                    "{frame},{track},{left},{},40,20,0.9,{class},1\n",
                    60 * track
                );
            }
        }
        text
    }

    #[test]
    fn class_ids_become_names() {
        let lines = "\u{feff}# of the detector\r\n1: pet\r\n\r\n2: hdpe\r\n";
        for names in [
            "1:pet,2:hdpe".parse().unwrap(),
            " 2 : hdpe , 01:pet ".parse().unwrap(),
            ClassNames::from_lines(lines, "names.txt").unwrap(),
        ] {
            let import = import_text(&recording(), "t.txt", &with(names)).unwrap();
            let items = import.pattern.items().iter();
            let mut classes: Vec<_> = items.map(|i| (&*i.id, i.class.as_deref())).collect();
            classes.sort_unstable();
            let (pet, hdpe) = (Some("pet"), Some("hdpe"));
            let expected = [("1", pet), ("2", hdpe), ("3", None), ("4", pet)];
            assert_eq!(classes, expected);
        }
        // Several ids may be one class, and a name on a line may have commas.
        let names = ClassNames::from_lines("1:PET, clear\n2:PET, clear", "names.txt").unwrap();
        let one = import_text(&recording(), "t.txt", &with(names)).unwrap();
        let is_pet = |item: &&crate::pattern::Item| item.class.as_deref() == Some("PET, clear");
        assert_eq!(one.pattern.items().iter().filter(is_pet).count(), 3);
    }

    #[test]
    fn names_without_boxes_are_told() {
        let import = import_text(&recording(), "t.txt", &options("1:pet,2:hdpe,7:wood")).unwrap();
        let remarks = import.report.remarks;
        assert!(
            remarks.contains(&"2 class ids named".to_owned()),
            "{remarks:?}"
        );
        assert!(
            remarks.contains(&"named class ids without a box: 7".to_owned()),
            "{remarks:?}"
        );
    }

    #[test]
    fn an_id_without_a_name_is_an_error_with_its_line() {
        let error = import_text(&recording(), "t.txt", &options("1:pet")).unwrap_err();
        let message = error.to_string();
        for words in ["t.txt:6", "class id 2 has no name", "such as 2:wood"] {
            assert!(message.contains(words), "{words} not in {message}");
        }
        let text = "frame,tracker_id,x_min,y_min,x_max,y_max,class_name\n1,1,0,0,40,20,PET\n\
                    2,1,10,0,50,20,PET\n";
        let message = import_text(text, "t.csv", &options("1:pet"))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("class `PET` is a name, not a class id"),
            "{message}"
        );
        let text = recording()
            .replace(",1,1\n", ",-1,1\n")
            .replace(",2,1\n", ",-1,1\n");
        let message = import_text(&text, "t.txt", &options("1:pet"))
            .unwrap_err()
            .to_string();
        assert!(message.contains("no box of t.txt has a class"), "{message}");
    }

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
