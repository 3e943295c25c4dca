//! An instance of the benchmark, and which of them are chosen.

use super::manifest::{self, Known, MANIFEST, ManifestRow};
use crate::error::{Error, Result, nearest, shown};
use crate::files;
use crate::pattern::{self, Pattern};
use crate::station::{self, Overrides, Station};
use std::path::{Path, PathBuf};

/// A pattern on a station, and what is known of it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Instance {
    /// Its name, unique in its benchmark.
    pub name: String,
    /// The line.
    pub station: Station,
    /// The items.
    pub pattern: Pattern,
    /// What is known of it.
    pub known: Known,
    /// The folder of the benchmark.
    folder: PathBuf,
}

impl Instance {
    /// Reads the instance of `row` in `folder`.
    ///
    /// # Errors
    /// A file that cannot be read, or an item beside the belt.
    pub(super) fn load(folder: &Path, row: ManifestRow) -> Result<Self> {
        let station_file = station_file(folder, &row.name);
        let name = station_file.display().to_string();
        let text = files::read_text(&station_file)?;
        let station = station::parse(&text, &name, Overrides::default())?;
        let pattern_file = pattern_file(folder, &row.name);
        let pattern = pattern::load(&pattern_file)?.pattern;
        let fits = pattern.check_on(&station);
        fits.map_err(|error| error.inside(&pattern_file.display().to_string()))?;
        let found = [station.robots().len(), pattern.len()];
        for ((listed, found), column) in row.sizes.iter().zip(found).zip(["robots", "items"]) {
            if let Some(listed) = listed.filter(|listed| *listed != found) {
                let list = folder.join(MANIFEST);
                return Err(Error::input(
                    format!("{}:{}: {column}", list.display(), row.line),
                    format!("{listed}, but the instance has {found}"),
                    "correct the number, or leave the field empty",
                ));
            }
        }
        Ok(Self {
            name: row.name,
            station,
            pattern,
            known: row.known,
            folder: folder.to_owned(),
        })
    }

    /// The file of its station.
    pub fn station_file(&self) -> PathBuf {
        station_file(&self.folder, &self.name)
    }

    /// The file of its pattern.
    pub fn pattern_file(&self) -> PathBuf {
        pattern_file(&self.folder, &self.name)
    }

    /// The file of the picks of the best solution that is known.
    pub fn best_file(&self) -> PathBuf {
        self.folder.join("best").join(format!("{}.csv", self.name))
    }

    /// Where all items are known from time 0 on, as a position of the camera [m].
    pub(super) fn far_camera(&self) -> f64 {
        let items = self.pattern.items().iter();
        items.map(|item| item.x0).fold(0.0, f64::min)
    }
}

fn station_file(folder: &Path, name: &str) -> PathBuf {
    folder.join("stations").join(format!("{name}.toml"))
}

fn pattern_file(folder: &Path, name: &str) -> PathBuf {
    folder.join("patterns").join(format!("{name}.csv"))
}

/// The list of the benchmark in `folder`.
///
/// # Errors
/// No list, or one that cannot be read.
pub(super) fn load_manifest(folder: &Path) -> Result<Vec<ManifestRow>> {
    let file = folder.join(MANIFEST);
    if !file.exists() {
        return Err(Error::usage(
            "'dir'",
            format!("there is no {}", file.display()),
            "give the folder of a benchmark: patterns/benchmark in pickline's repository",
        ));
    }
    manifest::read(&files::read_text(&file)?, &file.display().to_string())
}

/// The instances of the benchmark in `folder` whose names match one of `only`, or all of them, in the order
/// of its list. In `only`, `*` stands for any characters.
///
/// # Errors
/// A list, a station or a pattern that cannot be read, or an entry of `only` that matches nothing.
pub fn load_instances(folder: &Path, only: &[String]) -> Result<Vec<Instance>> {
    let rows = load_manifest(folder)?;
    for wanted in only {
        if !rows.iter().any(|row| matches(wanted, &row.name)) {
            let cure = match nearest(wanted, rows.iter().map(|row| row.name.as_str())) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("{MANIFEST} lists the names; * stands for any characters"),
            };
            let problem = format!("no instance is called `{}`", shown(wanted));
            return Err(Error::usage("'only'", problem, cure));
        }
    }
    let chosen =
        |row: &ManifestRow| only.is_empty() || only.iter().any(|wanted| matches(wanted, &row.name));
    let rows = rows.into_iter().filter(chosen);
    rows.map(|row| Instance::load(folder, row)).collect()
}

/// Whether `name` is like `wanted`, in which `*` stands for any characters.
fn matches(wanted: &str, name: &str) -> bool {
    let mut parts = wanted.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else {
        return rest.is_empty();
    };
    for part in middle {
        let Some(at) = rest.find(part) else {
            return false;
        };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn stars_stand_for_any_characters() {
        for (wanted, name, holds) in [
            ("a-1", "a-1", true),
            ("a-1", "a-10", false),
            ("a-*", "a-10", true),
            ("*", "", true),
            ("*-20-*", "delta-20-1", true),
            ("*-20-*", "delta-200-1", false),
            ("a*a", "a", false),
            ("a*b*c", "axbyc", true),
            ("a*b*c", "axcyb", false),
            ("*c", "abc", true),
        ] {
            assert_eq!(matches(wanted, name), holds, "{wanted} {name}");
        }
    }
}
