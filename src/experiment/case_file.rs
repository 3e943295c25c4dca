//! Files of cases, and the names that stand for cases.

use super::case::{Case, CaseSource, built_in_cases};
use crate::error::{Error, Result, known_names, shown, shown_number};
use crate::files::{is_path, read_text};
use crate::pattern::{Attributes, FEEDS, Feed};
use crate::toml_file::{File, Section};
use std::path::{Path, PathBuf};

/// The cases that `name` stands for: `paper`, `dense`, `all` or a TOML file.
///
/// # Errors
/// A file that cannot be read or that does not describe valid cases; the message names line and
/// key.
pub fn load_cases(name: &str) -> Result<Vec<Case>> {
    if let Some(cases) = built_in_cases(name) {
        return Ok(cases);
    }
    let path = Path::new(name);
    // A source of patterns has this form.
    if !path.exists() && is_feed(name) {
        return Err(Error::usage(
            "'cases'",
            format!("`{}` is a feed, not a file of cases", shown(name)),
            "write a case file, for example [[case]] with name = \"own\" and profile = \"FILE\" or \
             feed = \"random\" and flow = 60, and name it (see `pickline help compare`)",
        ));
    }
    if path.exists() || is_path(name) {
        return parse(&read_text(path)?, name, path.parent());
    }
    Err(Error::usage(
        "'cases'",
        format!("`{}` is neither a file nor a built-in set", shown(name)),
        known_names(name, &["paper", "dense", "all"]),
    ))
}

/// Whether `name` has the form of a feed in a source of patterns: `random:20`, `profile:FILE`.
fn is_feed(name: &str) -> bool {
    let kind = name.split_once(':').map(|(kind, _)| kind);
    kind.is_some_and(|kind| FEEDS.iter().any(|(name, _)| *name == kind))
}

fn parse(text: &str, name: &str, folder: Option<&Path>) -> Result<Vec<Case>> {
    let file = File::new(name, text, "`pickline help compare`");
    file.read(|root| {
        root.only(&["case"])?;
        let cases = root.tables("case")?;
        if cases.is_empty() {
            let cure =
                "add a [[case]] with a name and one of grid, poisson, feed, profile, pattern";
            return Err(Error::input(name, "the file has no case", cure));
        }
        let mut list: Vec<Case> = Vec::new();
        for section in &cases {
            let case = read_case(section, folder)?;
            if list.iter().any(|other| other.name == case.name) {
                return Err(section.wrong(
                    "name",
                    format!("two cases are named `{}`", shown(&case.name)),
                    "give every case a different name".into(),
                ));
            }
            list.push(case);
        }
        Ok(list)
    })
}

fn read_case(section: &Section, folder: Option<&Path>) -> Result<Case> {
    section.only(&[
        "name", "grid", "poisson", "feed", "profile", "pattern", "flow", "items",
    ])?;
    let name = section.text("name")?;
    let given = ["grid", "poisson", "feed", "profile", "pattern"]
        .map(|key| section.table.get(key).is_some());
    if given.iter().filter(|given| **given).count() != 1 {
        return Err(section.wrong(
            "name",
            format!(
                "case `{}` does not say where its patterns come from",
                shown(&name)
            ),
            "give exactly one of grid = SPACING, poisson = RADIUS, feed = \"NAME\", \
             profile = \"FILE\", pattern = \"FILE\""
                .into(),
        ));
    }
    let source = read_source(section, given, folder)?;
    let items = read_items(section, &source)?;
    Ok(Case {
        name,
        source,
        items,
        attributes: Attributes::default(),
    })
}

/// The source of a case's patterns; `given` says which of the keys grid, poisson, feed, profile and
/// pattern it has.
fn read_source(section: &Section, given: [bool; 5], folder: Option<&Path>) -> Result<CaseSource> {
    // Relative to the case file, so that both can be moved together.
    let file = |key: &str| {
        let file = PathBuf::from(section.text(key)?);
        Result::Ok(folder.map_or(file.clone(), |folder| folder.join(&file)))
    };
    let flow = || match section.table.get("flow").is_some() {
        true => section.number("flow").map(Some),
        false => Ok(None),
    };
    let source = match given {
        [true, ..] => CaseSource::Grid(read_length(section, "grid")?),
        [_, true, ..] => CaseSource::Poisson(read_length(section, "poisson")?),
        [_, _, true, ..] => CaseSource::Feed(read_feed(section)?, Some(section.number("flow")?)),
        [_, _, _, true, _] => CaseSource::Feed(Feed::Profile(file("profile")?), flow()?),
        _ => CaseSource::File(file("pattern")?),
    };
    if flow()?.is_some() && !matches!(source, CaseSource::Feed(..)) {
        return Err(section.wrong(
            "flow",
            "only a feed or a profile has a flow".into(),
            "remove the key, or write feed = \"grid\" or feed = \"poisson\"".into(),
        ));
    }
    Ok(source)
}

/// A distance between items [m].
fn read_length(section: &Section, key: &str) -> Result<f64> {
    let value = section.number(key)?;
    if (1e-4..=1e3).contains(&value) {
        return Ok(value);
    }
    Err(section.wrong(
        key,
        format!(
            "{} is not a valid distance between items",
            shown_number(value)
        ),
        "give metres, from 0.0001 to 1000".into(),
    ))
}

/// The items in each pattern from `source`, as in [`Case::items`].
fn read_items(section: &Section, source: &CaseSource) -> Result<usize> {
    match (source, section.optional_count("items")?) {
        (CaseSource::File(_), None) => Ok(0),
        (CaseSource::Feed(Feed::Profile(_), _), None) => Ok(usize::MAX),
        (CaseSource::File(_), Some(_)) => Err(section.wrong(
            "items",
            "a recorded pattern has its own items".into(),
            "remove the key".into(),
        )),
        (_, Some(items @ 1..=1_000_000)) => Ok(items),
        (_, Some(items)) => Err(section.wrong(
            "items",
            format!("{items} items"),
            "give 1 to 1000000".into(),
        )),
        (_, None) => Err(section.missing("items")),
    }
}

fn read_feed(section: &Section) -> Result<Feed> {
    let name = section.text("feed")?;
    Feed::named(&name).ok_or_else(|| {
        let known: Vec<&str> = FEEDS
            .iter()
            .map(|f| f.0)
            .filter(|n| *n != "profile")
            .collect();
        section.wrong(
            "feed",
            format!("`{}` is not a feed", shown(&name)),
            known_names(&name, &known),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_file_is_read_and_its_errors_name_line_and_key() {
        let good = "[[case]]\nname = \"a\"\ngrid = 0.2\nitems = 10\n[[case]]\nname = \"b\"\n\
                    pattern = \"p.csv\"\n";
        let cases = parse(good, "t", Some(Path::new("folder"))).unwrap();
        assert_eq!(cases[0].source, CaseSource::Grid(0.2));
        assert_eq!(cases[1].source, CaseSource::File("folder/p.csv".into()));
        for (from, to, words) in [
            ("grid = 0.2", "grid = -1", &["t:3: case[0].grid", "-1"][..]),
            (
                "grid = 0.2",
                "gird = 0.2",
                &["t:3: case[0].gird", "did you mean `grid`"],
            ),
            ("grid = 0.2\n", "", &["case[0].name", "exactly one of"]),
            ("items = 10\n", "", &["case[0].items", "missing"]),
            (
                "items = 10",
                "items = 0",
                &["t:4: case[0].items", "0 items"],
            ),
            (
                "name = \"b\"",
                "name = \"a\"",
                &["case[1].name", "two cases"],
            ),
            ("[[case]]", "[case]", &["case", "not a list of tables"]),
        ] {
            let text = if to == "[case]" {
                "[case]\nname = 1\n".into()
            } else {
                good.replacen(from, to, 1)
            };
            let message = parse(&text, "t", None).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
        let message = parse("", "t", None).unwrap_err().to_string();
        assert!(message.starts_with("t: "), "{message}");
    }

    /// One line of a case after its name, and the result.
    #[test]
    fn every_key_of_a_case_is_read_and_checked_against_its_range() {
        let read = |lines: &str| {
            let text = format!("[[case]]\nname = \"a\"\n{lines}\n");
            parse(&text, "t", Some(Path::new("folder"))).map(|mut cases| cases.remove(0))
        };
        for (lines, source, items) in [
            ("grid = 0.2\nitems = 1", CaseSource::Grid(0.2), 1),
            (
                "grid = 0.0001\nitems = 1000000",
                CaseSource::Grid(1e-4),
                1_000_000,
            ),
            ("poisson = 1000\nitems = 5", CaseSource::Poisson(1e3), 5),
            (
                "feed = \"random\"\nflow = 60\nitems = 5",
                CaseSource::Feed(Feed::Random, Some(60.0)),
                5,
            ),
            (
                "profile = \"f.csv\"",
                CaseSource::Feed(Feed::Profile("folder/f.csv".into()), None),
                usize::MAX,
            ),
            (
                "profile = \"f.csv\"\nflow = 30\nitems = 5",
                CaseSource::Feed(Feed::Profile("folder/f.csv".into()), Some(30.0)),
                5,
            ),
            (
                "pattern = \"p.csv\"",
                CaseSource::File("folder/p.csv".into()),
                0,
            ),
        ] {
            let case = read(lines).unwrap();
            assert_eq!((case.source, case.items), (source, items), "{lines}");
        }
        for (lines, words) in [
            (
                "grid = 0.00009\nitems = 1",
                &["t:3: case[0].grid", "9e-5", "0.0001 to 1000"][..],
            ),
            (
                "poisson = 1000.1\nitems = 1",
                &["t:3: case[0].poisson", "1000.1"],
            ),
            (
                "grid = 0.2\nitems = 1000001",
                &["t:4: case[0].items", "1000001 items"],
            ),
            (
                "pattern = \"p.csv\"\nitems = 3",
                &["t:4: case[0].items", "has its own items"],
            ),
            (
                "pattern = \"p.csv\"\nflow = 3",
                &["t:4: case[0].flow", "only a feed or a profile"],
            ),
            (
                "grid = 0.2\nflow = 3\nitems = 1",
                &["t:4: case[0].flow", "only a feed"],
            ),
            ("feed = \"random\"\nitems = 5", &["case[0].flow", "missing"]),
            (
                "feed = \"randm\"\nflow = 3\nitems = 5",
                &["t:3: case[0].feed", "`randm` is not a feed", "`random`"],
            ),
            // A profile cannot be named like a feed.
            (
                "feed = \"profile\"\nflow = 3\nitems = 5",
                &[
                    "`profile` is not a feed",
                    "grid, poisson, random, clustered, gaps",
                ],
            ),
            (
                "grid = 0.2\npoisson = 0.2\nitems = 5",
                &["case[0].name", "exactly one of"],
            ),
        ] {
            let message = read(lines).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
        let message = parse("case = []\n", "t", None).unwrap_err().to_string();
        assert!(message.contains("the file has no case"), "{message}");
    }

    #[test]
    fn names_of_cases_are_distinguished_from_files_and_feeds() {
        let counts = ["paper", "dense", "all"].map(|name| load_cases(name).unwrap().len());
        assert_eq!(counts, [4, 4, 8]);
        let dense = load_cases("dense").unwrap();
        assert_eq!(dense[0].source, CaseSource::Grid(0.15));
        assert_eq!(dense[1].source, CaseSource::Poisson(0.1));
        assert!(dense.iter().all(|case| case.items == 150));
        for feed in [
            "grid:0.2",
            "poisson:0.2",
            "gaps:3",
            "clustered:60/min:2",
            "profile:x",
            "profile:x.csv",
            "random:20",
        ] {
            let message = load_cases(feed).unwrap_err().to_string();
            assert!(message.contains("write a case file"), "{message}");
            assert!(
                message.contains("is a feed, not a file"),
                "{feed}: {message}"
            );
        }
        for name in ["papre", "own:2"] {
            let message = load_cases(name).unwrap_err().to_string();
            assert!(
                message.contains("neither a file nor a built-in set"),
                "{name}: {message}"
            );
        }
        let message = load_cases("papre").unwrap_err().to_string();
        assert!(message.contains("`paper`"), "{message}");
        for file in ["no/such", "no.toml", "no\\such"] {
            let message = load_cases(file).unwrap_err().to_string();
            assert!(message.contains("cannot read"), "{file}: {message}");
        }
        // A file in the working directory needs no `./`, and it takes precedence over a feed.
        let message = load_cases("src").unwrap_err().to_string();
        assert!(!message.contains("neither a file"), "{message}");
    }
}
