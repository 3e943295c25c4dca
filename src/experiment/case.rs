//! The cases of a comparison.

use crate::error::{Error, Result};
use crate::files::read_text;
use crate::pattern::{self, Pattern, grid, poisson_disk, random_stream};
use crate::toml_file::{File, Section};
use std::path::{Path, PathBuf};

/// What a case's patterns are.
#[derive(Debug, Clone, PartialEq)]
pub enum CaseSource {
    /// The grid of this spacing [m]; there is only one.
    Grid(f64),
    /// Poisson disk patterns of this radius [m].
    Poisson(f64),
    /// A recorded pattern.
    File(PathBuf),
}

/// A kind of pattern that strategies are compared on.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Name in tables.
    pub name: String,
    /// Where its patterns come from.
    pub source: CaseSource,
    /// Items a pattern; a recorded one holds its own.
    pub items: usize,
}

/// The paper's four cases with the item counts fitted to its Table 2
/// (`docs/model.md`): radius or spacing [m], items, whether it is a grid.
pub const PAPER: [(bool, f64, usize); 4] = [
    (true, 0.15, 50),
    (true, 0.3, 50),
    (false, 0.2, 29),
    (false, 0.3, 36),
];

/// Dense cases, on which strategies differ most.
pub const DENSE: [(bool, f64, usize); 4] = [
    (true, 0.15, 150),
    (false, 0.1, 150),
    (false, 0.12, 150),
    (false, 0.15, 150),
];

/// The cases that `name` stands for: `paper`, `dense`, `all` or a TOML file of one's own.
///
/// # Errors
/// A file that cannot be read or that describes no case, naming line and key.
pub fn load_cases(name: &str) -> Result<Vec<Case>> {
    let built_in = |list: &[(bool, f64, usize)]| list.iter().map(|&c| Case::built_in(c)).collect();
    match name {
        "paper" => Ok(built_in(&PAPER)),
        "dense" => Ok(built_in(&DENSE)),
        "all" => Ok(built_in(&[PAPER, DENSE].concat())),
        _ if Path::new(name).exists() || name.contains(['/', '\\', '.']) => {
            let path = Path::new(name);
            parse(&read_text(path)?, name, path.parent())
        }
        _ => Err(Error::input(
            "--cases",
            format!(
                "`{}` is neither a file nor a built-in set",
                crate::error::shown(name)
            ),
            crate::error::known_names(name, &["paper", "dense", "all"]),
        )),
    }
}

fn parse(text: &str, name: &str, folder: Option<&Path>) -> Result<Vec<Case>> {
    let file = File::new(name, text, "`pickline compare --help`");
    file.read(|root| {
        root.only(&["case"])?;
        let cases = root.tables("case")?;
        if cases.is_empty() {
            let cure = "add a [[case]] with a name and one of grid, poisson, pattern";
            return Err(Error::input(name, "the file has no case", cure));
        }
        let mut list: Vec<Case> = Vec::new();
        for section in &cases {
            let case = read_case(section, folder)?;
            if list.iter().any(|other| other.name == case.name) {
                return Err(section.wrong(
                    "name",
                    format!("two cases are named `{}`", crate::error::shown(&case.name)),
                    "give every case a name of its own".into(),
                ));
            }
            list.push(case);
        }
        Ok(list)
    })
}

fn read_case(section: &Section, folder: Option<&Path>) -> Result<Case> {
    section.only(&["name", "grid", "poisson", "pattern", "items"])?;
    let name = section.text("name")?;
    let given = ["grid", "poisson", "pattern"].map(|key| section.table.get(key).is_some());
    if given.iter().filter(|given| **given).count() != 1 {
        return Err(section.wrong(
            "name",
            format!(
                "case `{}` does not say what it is",
                crate::error::shown(&name)
            ),
            "give exactly one of grid = SPACING, poisson = RADIUS, pattern = \"FILE\"".into(),
        ));
    }
    let length = |key: &str| {
        let value = section.number(key)?;
        if (1e-4..=1e3).contains(&value) {
            return Ok(value);
        }
        Err(section.wrong(
            key,
            format!(
                "{} is not a distance between items",
                crate::error::shown_number(value)
            ),
            "give metres, from 0.0001 to 1000".into(),
        ))
    };
    let source = match given {
        [true, ..] => CaseSource::Grid(length("grid")?),
        [_, true, _] => CaseSource::Poisson(length("poisson")?),
        _ => {
            let file = PathBuf::from(section.text("pattern")?);
            // Relative to the case file, so that the two can be moved together.
            CaseSource::File(folder.map_or(file.clone(), |folder| folder.join(&file)))
        }
    };
    let items = match (&source, section.optional_count("items")?) {
        (CaseSource::File(_), None) => 0,
        (CaseSource::File(_), Some(_)) => {
            return Err(section.wrong(
                "items",
                "a recorded pattern holds its own items".into(),
                "leave the key out".into(),
            ));
        }
        (_, Some(items @ 1..=1_000_000)) => items,
        (_, Some(items)) => {
            return Err(section.wrong(
                "items",
                format!("{items} items"),
                "give 1 to 1000000".into(),
            ));
        }
        (_, None) => return Err(section.missing("items")),
    };
    Ok(Case {
        name,
        source,
        items,
    })
}

impl Case {
    fn built_in((is_grid, size, items): (bool, f64, usize)) -> Self {
        Self {
            name: format!(
                "{} {size}, {items} items",
                if is_grid { "grid" } else { "poisson" }
            ),
            source: if is_grid {
                CaseSource::Grid(size)
            } else {
                CaseSource::Poisson(size)
            },
            items,
        }
    }

    /// The file of its recorded pattern.
    pub fn file(&self) -> Option<&Path> {
        match &self.source {
            CaseSource::File(path) => Some(path),
            _ => None,
        }
    }

    /// Whether its patterns are generated, not recorded.
    pub fn is_generated(&self) -> bool {
        !matches!(self.source, CaseSource::File(_))
    }

    /// The patterns on a belt of `width` [m], each with the seed that
    /// `pickline pattern generate --seed` makes it from; none where nothing is random.
    /// Random cases are replicated under the seeds `first_seed`, `first_seed + 1`, ...
    ///
    /// # Errors
    /// A recorded pattern that cannot be read.
    pub fn patterns(
        &self,
        width: f64,
        replicates: usize,
        first_seed: u64,
    ) -> Result<Vec<(Option<u64>, Pattern)>> {
        match &self.source {
            CaseSource::Grid(spacing) => Ok(vec![(None, grid(width, *spacing, self.items)?)]),
            CaseSource::File(path) => Ok(vec![(None, pattern::load(path)?)]),
            CaseSource::Poisson(radius) => (0..replicates as u64)
                .map(|replicate| {
                    let seed = first_seed.wrapping_add(replicate);
                    let mut rng = random_stream(seed, 0);
                    let pattern = poisson_disk(width, *radius, self.items, &mut rng)?;
                    Ok((Some(seed), pattern))
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_cases_are_named_and_drawn() {
        let cases = load_cases("all").unwrap();
        assert_eq!(cases.len(), 8);
        assert_eq!(cases[2].name, "poisson 0.2, 29 items");
        let drawn = cases[2].patterns(1.05, 3, 7).unwrap();
        assert_eq!(
            drawn.iter().map(|d| d.0).collect::<Vec<_>>(),
            [Some(7), Some(8), Some(9)]
        );
        assert_eq!(cases[0].patterns(1.05, 3, 7).unwrap().len(), 1);
        assert!(
            load_cases("papre")
                .unwrap_err()
                .to_string()
                .contains("`paper`")
        );
    }

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
        assert!(parse("", "t", None).is_err());
    }
}
