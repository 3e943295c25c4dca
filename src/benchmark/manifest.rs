//! The list of instances: CSV with one line for each and what is known of it.

use crate::csv_columns::{Columns, KnownColumns, resembles};
use crate::csv_file::CsvFile;
use crate::decision::Figures;
use crate::error::{Error, Result, rounded, shown};
use crate::files::csv_text;
use csv::StringRecord;
use std::collections::HashSet;

/// The name of the list in the folder of a benchmark.
pub const MANIFEST: &str = "instances.csv";

const NAME: usize = 0;
const ROBOTS: usize = 1;
const ITEMS: usize = 2;
const PICKED: usize = 3;
const RATE: usize = 4;
const PICKS_BOUND: usize = 5;
const RATE_BOUND: usize = 6;
const FOUND_BY: usize = 7;

const KNOWN: KnownColumns = KnownColumns {
    names: &[
        "name",
        "robots",
        "items",
        "picked",
        "rate_per_min",
        "picks_bound",
        "rate_bound_per_min",
        "found_by",
    ],
    required: 1,
    find: |column| {
        let place = KNOWN.names.iter().position(|&known| known == column);
        place.map(|place| (place, 1.0))
    },
    is_misspelt: |column| resembles(column, KNOWN.names),
    beginning: "start it with the header `name` and write one instance per line",
    needs: "the header needs name",
};

/// What is known of an instance.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Known {
    /// The most picks of any solution that is known.
    pub picked: Option<usize>,
    /// The picking rate of that solution [1/min].
    pub rate: Option<f64>,
    /// What no solution exceeds.
    pub picks_bound: Option<usize>,
    /// The picking rate that no solution exceeds [1/min].
    pub rate_bound: Option<f64>,
    /// How the best solution was found; empty if there is none.
    pub found_by: String,
}

/// A bound that was computed anew.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FoundBound {
    /// Picks that no solution exceeds.
    pub picks: usize,
    /// The picking rate that no solution exceeds [1/min]; `None` if no finite one was found.
    pub rate: Option<f64>,
}

/// Rates that differ by less, relatively, differ by rounding.
const SAME_RATE: f64 = 1e-9;

impl Known {
    /// Whether a solution with `figures` is better than the best that is known: more picks, or as many at a
    /// higher rate.
    pub fn is_beaten_by(&self, figures: &Figures) -> bool {
        match self.picked {
            Some(picked) if picked == figures.picked => {
                figures.picking_rate() > self.rate.unwrap_or_default() * (1.0 + SAME_RATE)
            }
            picked => picked.is_none_or(|picked| figures.picked > picked),
        }
    }

    /// Lowers the bounds to `found` where it is lower.
    pub fn tighten(&mut self, found: FoundBound) {
        let picks = self.picks_bound.unwrap_or(usize::MAX);
        self.picks_bound = Some(picks.min(found.picks));
        if let Some(rate) = found.rate {
            self.rate_bound = Some(self.rate_bound.unwrap_or(f64::INFINITY).min(rate));
        }
    }

    /// Why no solution can have `figures`, if a bound says so: then bound or checker is wrong.
    pub fn excess(&self, figures: &Figures) -> Option<String> {
        let (picked, rate) = (figures.picked, figures.picking_rate());
        let picks = self.picks_bound.filter(|bound| picked > *bound);
        if let Some(bound) = picks {
            return Some(format!(
                "{picked} picks are more than the certified bound of {bound}"
            ));
        }
        let bound = self.rate_bound?;
        (rate > bound * (1.0 + SAME_RATE)).then(|| {
            format!(
                "a picking rate of {}/min is more than the certified bound of {}/min",
                rounded(rate, 7),
                rounded(bound, 7)
            )
        })
    }

    /// What differs between the list and the best solution, whose figures are `figures`; `None` if nothing
    /// does, or the list says nothing.
    pub(super) fn mistake(&self, figures: &Figures) -> Option<String> {
        let (picked, rate) = (figures.picked, figures.picking_rate());
        let other = self.picked.is_some_and(|listed| listed != picked)
            || self
                .rate
                .is_some_and(|listed| (listed - rate).abs() > SAME_RATE * rate);
        other.then(|| {
            let listed = |value: Option<String>| value.unwrap_or_else(|| "-".into());
            format!(
                "{MANIFEST} lists {} picks at {}/min, but its file has {picked} at {}/min",
                listed(self.picked.map(|picked| picked.to_string())),
                listed(self.rate.map(|rate| rounded(rate, 7))),
                rounded(rate, 7)
            )
        })
    }
}

/// A line of the list.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ManifestRow {
    pub name: String,
    /// The line of the file.
    pub line: usize,
    /// Numbers of robots and items, where the list has them.
    pub sizes: [Option<usize>; 2],
    pub known: Known,
}

/// Reads the list in `text`; messages call it `file`.
///
/// # Errors
/// The first line that cannot be read, a name that is not one of a file, or one that occurs twice.
pub(super) fn read(text: &str, file: &str) -> Result<Vec<ManifestRow>> {
    let mut csv = CsvFile::new(text, file);
    let columns = Columns::of(&mut csv, &KNOWN)?;
    let mut rows = Vec::new();
    let mut names = HashSet::new();
    let mut record = StringRecord::new();
    while let Some(line) = csv.next(&mut record)? {
        let name = columns.text(&record, NAME).to_owned();
        let place = || columns.place_of(&csv, NAME);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(Error::input(
                place(),
                format!("`{}` is not the name of an instance", shown(&name)),
                "use letters, digits, hyphens, underscores and dots",
            ));
        }
        if !names.insert(name.clone()) {
            return Err(Error::input(
                place(),
                format!("`{}` occurs twice", shown(&name)),
                "give every instance a name of its own",
            ));
        }
        let known = Known {
            picked: count(&columns, &mut csv, &record, PICKED)?,
            rate: number(&columns, &mut csv, &record, RATE)?,
            picks_bound: count(&columns, &mut csv, &record, PICKS_BOUND)?,
            rate_bound: number(&columns, &mut csv, &record, RATE_BOUND)?,
            found_by: columns.text(&record, FOUND_BY).to_owned(),
        };
        let sizes = [ROBOTS, ITEMS].map(|column| count(&columns, &mut csv, &record, column));
        let [robots, items] = sizes;
        rows.push(ManifestRow {
            name,
            line,
            sizes: [robots?, items?],
            known,
        });
    }
    if rows.is_empty() {
        return Err(Error::input(
            file,
            "lists no instance",
            "write the name of one per line",
        ));
    }
    Ok(rows)
}

/// Checks that the list in `text`, which messages call `file`, can be written again without losing anything.
///
/// # Errors
/// A comment, or a column that is not one of a list.
pub(super) fn check_rewritable(text: &str, file: &str) -> Result<()> {
    let lost = |what: String| {
        let cure = "remove it, or keep it in a file of its own, then update";
        Error::input(
            file,
            format!("{what} would be lost if it were updated"),
            cure,
        )
    };
    let mut lines = text.trim_start_matches('\u{feff}').lines();
    let header = lines.next().unwrap_or_default();
    if text.lines().any(|line| line.trim_start().starts_with('#')) {
        return Err(lost("a comment".into()));
    }
    let columns = header
        .split([',', ';', '\t'])
        .map(|name| name.trim().trim_matches('"'));
    let other = |name: &&str| !KNOWN.names.contains(&name.to_ascii_lowercase().as_str());
    let mut others = columns.filter(other);
    others.next().map_or(Ok(()), |name| {
        Err(lost(format!("the column `{}`", shown(name))))
    })
}

/// A number of at least 0; `None` if the field is empty.
fn number(
    columns: &Columns,
    csv: &mut CsvFile,
    record: &StringRecord,
    column: usize,
) -> Result<Option<f64>> {
    let number = columns.number(csv, record, column)?;
    match number {
        Some(value) if !(value.is_finite() && value >= 0.0) => Err(Error::input(
            columns.place_of(csv, column),
            format!("{value} is out of range"),
            "give a number of at least 0, or leave the field empty",
        )),
        number => Ok(number),
    }
}

/// A whole number; `None` if the field is empty.
fn count(
    columns: &Columns,
    csv: &mut CsvFile,
    record: &StringRecord,
    column: usize,
) -> Result<Option<usize>> {
    let number = number(columns, csv, record, column)?;
    match number {
        Some(value) if value.fract() != 0.0 || value > 1e9 => Err(Error::input(
            columns.place_of(csv, column),
            format!("{value} is not a number of items"),
            "give a whole number, or leave the field empty",
        )),
        number => Ok(number.map(|value| value as usize)),
    }
}

/// The list of `rows`, each with its numbers of robots and items, as text.
pub(super) fn text(rows: &[(&ManifestRow, [usize; 2])]) -> String {
    let header = KNOWN.names.iter().map(|name| (*name).to_owned()).collect();
    let field = |value: Option<String>| value.unwrap_or_default();
    let row = |(row, [robots, items]): &(&ManifestRow, [usize; 2])| {
        let known = &row.known;
        vec![
            row.name.clone(),
            robots.to_string(),
            items.to_string(),
            field(known.picked.map(|n| n.to_string())),
            field(known.rate.map(|n| n.to_string())),
            field(known.picks_bound.map(|n| n.to_string())),
            field(known.rate_bound.map(|n| n.to_string())),
            known.found_by.clone(),
        ]
    };
    csv_text(std::iter::once(header).chain(rows.iter().map(row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_read_as_it_was_written() {
        let known = Known {
            picked: Some(7),
            rate: Some(12.5),
            picks_bound: Some(8),
            rate_bound: None,
            found_by: "lookahead:budget=4,depth=1".into(),
        };
        let rows = [("a-1", [2, 9], known), ("b.2", [3, 20], Known::default())];
        let mut line = 1;
        let rows = rows.map(|(name, sizes, known): (&str, [usize; 2], _)| {
            line += 1;
            ManifestRow {
                name: name.into(),
                line,
                sizes: sizes.map(Some),
                known,
            }
        });
        let written = text(&[(&rows[0], [2, 9]), (&rows[1], [3, 20])]);
        assert_eq!(
            written.lines().nth(1),
            Some("a-1,2,9,7,12.5,8,,\"lookahead:budget=4,depth=1\"")
        );
        assert_eq!(read(&written, "m").unwrap(), rows);
    }

    #[test]
    fn a_list_with_more_than_is_written_is_not_rewritten() {
        for (text, words) in [
            ("name,picked\na,1\n", None),
            ("\u{feff}Name;Picked\r\na;1\r\n", None),
            ("# mine\nname\na\n", Some("m: a comment would be lost")),
            ("name\na\n # b\n", Some("m: a comment would be lost")),
            ("name,url\na,x\n", Some("m: the column `url` would be lost")),
        ] {
            let found = check_rewritable(text, "m").err();
            let found = found.map(|error| error.to_string());
            match words {
                None => assert_eq!(found, None),
                Some(words) => assert!(found.unwrap().contains(words), "{text}"),
            }
        }
    }

    fn figures(picked: usize, end: f64) -> Figures {
        Figures {
            items: 20,
            picked,
            weight: 0.0,
            end,
        }
    }

    #[test]
    fn more_picks_are_better_and_of_as_many_those_at_a_higher_rate() {
        let known = Known {
            picked: Some(10),
            rate: Some(60.0),
            picks_bound: Some(11),
            rate_bound: Some(66.0),
            ..Known::default()
        };
        assert!(!known.is_beaten_by(&figures(10, 10.0)));
        assert!(known.is_beaten_by(&figures(10, 9.99)));
        assert!(known.is_beaten_by(&figures(11, 20.0)));
        assert!(!known.is_beaten_by(&figures(9, 1.0)));
        assert!(Known::default().is_beaten_by(&figures(0, 1.0)));
        assert_eq!(known.excess(&figures(11, 10.0)), None);
        let told = |figures: &Figures| known.excess(figures).unwrap();
        assert!(told(&figures(12, 20.0)).starts_with("12 picks are more"));
        assert!(told(&figures(10, 9.0)).starts_with("a picking rate of 66.66667/min"));
        assert_eq!(known.mistake(&figures(10, 10.0)), None);
        let told = known.mistake(&figures(9, 10.0)).unwrap();
        assert!(told.contains("lists 10 picks at 60/min, but its file has 9 at 54/min"));
        assert!(known.mistake(&figures(10, 10.1)).is_some());
        assert_eq!(Known::default().mistake(&figures(9, 10.0)), None);
    }

    #[test]
    fn what_is_wrong_in_a_list_is_named() {
        for (text, words) in [
            ("", "m: the file is empty"),
            ("name\n", "m: lists no instance"),
            ("nmae\na\n", "unknown column `nmae`"),
            ("name\n../a\n", "m:2: name: `../a` is not the name"),
            ("name\n.a\n", "m:2: name: `.a` is not the name"),
            ("name\na\na\n", "m:3: name: `a` occurs twice"),
            (
                "name,picked\na,1.5\n",
                "m:2: picked: 1.5 is not a number of items",
            ),
            ("name,picked\na,x\n", "m:2: picked: `x` is not a number"),
            (
                "name,rate_per_min\na,-1\n",
                "m:2: rate_per_min: -1 is out of range",
            ),
            (
                "name,rate_bound_per_min\na,inf\n",
                "m:2: rate_bound_per_min: inf is out of range",
            ),
        ] {
            let message = read(text, "m").unwrap_err().to_string();
            assert!(message.contains(words), "{words} not in {message}");
        }
    }
}
