//! Sets of patterns: what a strategy is judged on.

use super::attributes::Attributes;
use super::grid::{check_count, grid};
use super::item::{MOST_ITEMS, Pattern};
use super::poisson::poisson_disk;
use super::random_stream;
use crate::error::{Error, Result, known_names, shown, shown_number};
use rand::RngExt;
use rayon::prelude::*;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Range of grid spacings and Poisson radii of the balanced set [m]
/// (Jermann et al., results of the GT approach).
const BALANCED_RANGE: (f64, f64) = (0.15, 0.4);
/// Patterns of each kind in the balanced set (Jermann et al., Table 1: 240 in all).
const BALANCED_EACH: usize = 120;

/// Where patterns come from, as written after `--patterns`.
#[derive(Debug, Clone, PartialEq)]
pub enum PatternSource {
    /// `balanced[:N]`: N grids and N Poisson disk patterns, spacing and radius evenly
    /// over [0.15, 0.4] m.
    Balanced(usize),
    /// `grid:S`: the one grid of spacing S [m].
    Grid(f64),
    /// `poisson:R[:N]`: N Poisson disk patterns of radius R [m].
    Poisson(f64, usize),
    /// A pattern file, or a folder of them.
    Files(PathBuf),
}

/// How every source is written, for help texts and messages.
const FORMS: &str =
    "balanced[:N], grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of them";

impl FromStr for PatternSource {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |problem: String, cure: String| {
            Error::input(format!("--patterns {}", shown(text)), problem, cure)
        };
        let forms = || format!("write one of {FORMS}");
        let length = |part: &str| {
            part.parse()
                .ok()
                .filter(|value: &f64| value.is_finite() && *value > 0.0)
                .ok_or_else(|| wrong(format!("`{}` is not a length [m]", shown(part)), forms()))
        };
        let count = |part: &str| {
            part.parse()
                .ok()
                .filter(|&n: &usize| (1..=1_000_000).contains(&n))
                .ok_or_else(|| wrong(format!("`{}` is not a count", shown(part)), forms()))
        };
        let parts: Vec<&str> = text.split(':').collect();
        match parts.as_slice() {
            ["balanced"] => Ok(Self::Balanced(BALANCED_EACH)),
            ["balanced", n] => Ok(Self::Balanced(count(n)?)),
            ["grid", s] => Ok(Self::Grid(length(s)?)),
            ["poisson", r] => Ok(Self::Poisson(length(r)?, BALANCED_EACH)),
            ["poisson", r, n] => Ok(Self::Poisson(length(r)?, count(n)?)),
            _ if Path::new(text).exists() => Ok(Self::Files(text.into())),
            [name @ ("grid" | "poisson")] => Err(wrong(format!("{name} needs a length"), forms())),
            [name, ..] => Err(wrong(
                "neither a kind of pattern nor an existing file or folder".into(),
                format!(
                    "{}; {}",
                    forms(),
                    known_names(name, &["balanced", "grid", "poisson"])
                ),
            )),
            [] => Err(wrong("empty".into(), forms())),
        }
    }
}

impl fmt::Display for PatternSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Balanced(n) => write!(f, "balanced:{n}"),
            Self::Grid(s) => write!(f, "grid:{}", shown_number(*s)),
            Self::Poisson(r, n) => write!(f, "poisson:{}:{n}", shown_number(*r)),
            Self::Files(path) => write!(f, "{}", path.display()),
        }
    }
}

/// Patterns with a label each, and how they were made.
#[derive(Debug, Clone)]
pub struct PatternSet {
    /// Where they come from, in words, with the seed.
    pub description: String,
    /// One label a pattern: `grid s=0.15`, `poisson r=0.2 #3`, a file's name.
    pub labels: Vec<String>,
    /// The patterns.
    pub patterns: Vec<Pattern>,
}

/// What generated patterns have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recipe {
    /// Belt width [m].
    pub width: f64,
    /// Items a pattern.
    pub items: usize,
    /// What the items carry.
    pub attributes: Attributes,
    /// Master seed.
    pub seed: u64,
}

impl PatternSource {
    /// The files that it reads.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn files(&self) -> Result<Vec<PathBuf>> {
        match self {
            Self::Files(path) => files_of(path),
            _ => Ok(Vec::new()),
        }
    }

    /// The set this source stands for. The same recipe makes the same set.
    ///
    /// # Errors
    /// Files that cannot be read, sizes that make no pattern.
    pub fn build(&self, recipe: &Recipe) -> Result<PatternSet> {
        let mut set = PatternSet {
            description: String::new(),
            labels: Vec::new(),
            patterns: Vec::new(),
        };
        let made = format!(
            "{} items a pattern, {}, seed {}",
            recipe.items,
            recipe.attributes.describe(),
            recipe.seed
        );
        match self {
            Self::Balanced(n) => {
                let (low, high) = BALANCED_RANGE;
                let steps = (*n).max(2) - 1;
                let value = |i: usize| low + (high - low) * i as f64 / steps as f64;
                self.check_size(recipe, 2.0 * *n as f64, &self.flag())?;
                let grids = (0..*n).map(|i| Draw::Grid(value(i)));
                let poissons = (0..*n).map(|i| Draw::Poisson(value(i)));
                set.draw(recipe, grids.chain(poissons).collect(), self)?;
                set.description = format!(
                    "{n} grid and {n} Poisson disk patterns, spacing and radius evenly over \
                     [{low}, {high}] m, {made}"
                );
            }
            Self::Grid(spacing) => {
                self.check_size(recipe, 1.0, &self.flag())?;
                set.draw(recipe, vec![Draw::Grid(*spacing)], self)?;
                set.description = format!("the grid of {spacing} m, {made}");
            }
            Self::Poisson(radius, n) => {
                self.check_size(recipe, *n as f64, &self.flag())?;
                set.draw(recipe, vec![Draw::Poisson(*radius); *n], self)?;
                set.description = format!("{n} Poisson disk patterns of {radius} m, {made}");
            }
            Self::Files(path) => set.add_files(path)?,
        }
        Ok(set)
    }

    /// Refuses what would not fit into memory with comfort, before it is made.
    fn check_size(&self, recipe: &Recipe, patterns: f64, flag: &str) -> Result<()> {
        check_count(recipe.items).map_err(|error| error.at("--items"))?;
        if patterns * recipe.items as f64 <= MOST_ITEMS as f64 {
            return Ok(());
        }
        Err(Error::input(
            flag,
            format!("{patterns} patterns of {} items", recipe.items),
            format!("ask for fewer: a set holds at most {MOST_ITEMS} items"),
        ))
    }

    /// Refuses more fresh patterns than would fit into memory with comfort, before the
    /// work that they are to judge.
    ///
    /// # Errors
    /// Too many.
    pub fn check_fresh(&self, recipe: &Recipe, count: usize) -> Result<()> {
        self.check_size(recipe, count as f64, &format!("--validate {count}"))
    }

    /// How messages call it.
    fn flag(&self) -> String {
        format!("--patterns {self}")
    }

    /// `count` patterns that no set of [`PatternSource::build`] under another seed
    /// holds, for scoring what was selected on such a set: the balanced set's
    /// spacings and radii are drawn at random then. None where nothing fresh can be
    /// drawn: files and the one grid of a spacing.
    ///
    /// # Errors
    /// As for [`PatternSource::build`].
    pub fn draw_fresh(&self, recipe: &Recipe, count: usize) -> Result<Option<PatternSet>> {
        match self {
            Self::Balanced(_) => {
                self.check_fresh(recipe, count)?;
                let (low, high) = BALANCED_RANGE;
                let mut set = PatternSet {
                    description: format!(
                        "{count} fresh patterns, grid and Poisson disk in turn, spacing and \
                         radius at random over [{low}, {high}] m, {} items a pattern, {}, seed {}",
                        recipe.items,
                        recipe.attributes.describe(),
                        recipe.seed
                    ),
                    labels: Vec::new(),
                    patterns: Vec::new(),
                };
                // A stream of its own, past those of the patterns.
                let mut rng = random_stream(recipe.seed, u64::MAX);
                let draws = (0..count).map(|i| {
                    let value = low + (high - low) * rng.random::<f64>();
                    if i % 2 == 0 {
                        Draw::Grid(value)
                    } else {
                        Draw::Poisson(value)
                    }
                });
                set.draw(recipe, draws.collect(), self)?;
                Ok(Some(set))
            }
            Self::Poisson(radius, _) => Self::Poisson(*radius, count).build(recipe).map(Some),
            Self::Grid(_) | Self::Files(_) => Ok(None),
        }
    }
}

/// A generated pattern that is to be drawn, with its spacing or radius [m].
#[derive(Debug, Clone, Copy)]
enum Draw {
    Grid(f64),
    Poisson(f64),
}

impl PatternSet {
    /// Draws patterns in parallel, each from the stream of its place.
    fn draw(&mut self, recipe: &Recipe, draws: Vec<Draw>, source: &PatternSource) -> Result<()> {
        let draw = |(place, draw): (usize, &Draw)| {
            let mut rng = random_stream(recipe.seed, place as u64);
            let pattern = match *draw {
                Draw::Grid(spacing) => grid(recipe.width, spacing, recipe.items),
                Draw::Poisson(radius) => poisson_disk(recipe.width, radius, recipe.items, &mut rng),
            };
            let pattern = pattern.map_err(|error| error.at(&source.flag()))?;
            recipe.attributes.apply(pattern, &mut rng)
        };
        let patterns = draws.par_iter().enumerate().map(draw);
        self.patterns = patterns.collect::<Result<_>>()?;
        let label = |(place, draw): (usize, &Draw)| match draw {
            Draw::Grid(spacing) => format!("grid s={spacing:.4}"),
            Draw::Poisson(radius) => format!("poisson r={radius:.4} #{}", place + 1),
        };
        self.labels = draws.iter().enumerate().map(label).collect();
        Ok(())
    }

    fn add_files(&mut self, path: &Path) -> Result<()> {
        let files = files_of(path)?;
        if files.is_empty() {
            return Err(Error::input(
                format!("--patterns {}", path.display()),
                "the folder holds no .csv file",
                "put pattern files into it, or name one file",
            ));
        }
        for file in &files {
            self.patterns.push(super::file::load(file)?);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            self.labels.push(name.into_owned());
        }
        let all: String = self.patterns.iter().map(super::file::to_csv).collect();
        self.description = format!(
            "{} recorded pattern(s) from {} (hash {})",
            files.len(),
            path.display(),
            crate::files::fingerprint(&all)
        );
        Ok(())
    }
}

/// The recorded patterns at `path`, one or a folder of them.
fn files_of(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(|e| Error::read(path, e))? {
        let file = entry.map_err(|e| Error::read(path, e))?.path();
        if file
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("csv"))
        {
            files.push(file);
        }
    }
    // The order of a folder is the file system's; names are everybody's.
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECIPE: Recipe = Recipe {
        width: 1.05,
        items: 20,
        attributes: Attributes {
            area_cm2: None,
            p_detection: None,
            p_grasp: None,
        },
        seed: 1,
    };

    #[test]
    fn the_balanced_set_covers_its_range_evenly() {
        let set = PatternSource::Balanced(6).build(&RECIPE).unwrap();
        assert_eq!(set.patterns.len(), 12);
        assert_eq!(set.labels[0], "grid s=0.1500");
        assert_eq!(set.labels[5], "grid s=0.4000");
        assert_eq!(set.labels[11], "poisson r=0.4000 #12");
        let again = PatternSource::Balanced(6).build(&RECIPE).unwrap();
        assert_eq!(set.patterns, again.patterns);
    }

    #[test]
    fn fresh_patterns_are_others() {
        let set = PatternSource::Balanced(6).build(&RECIPE).unwrap();
        let other = Recipe { seed: 2, ..RECIPE };
        let fresh = PatternSource::Balanced(6)
            .draw_fresh(&other, 12)
            .unwrap()
            .unwrap();
        assert_eq!(fresh.patterns.len(), 12);
        assert!(fresh.patterns.iter().all(|p| !set.patterns.contains(p)));
        assert!(
            PatternSource::Grid(0.2)
                .draw_fresh(&other, 3)
                .unwrap()
                .is_none()
        );
    }

    #[test]
    fn sizes_are_refused_by_their_flag() {
        for (source, items, flag) in [
            ("grid:0.2", 0, "--items: 0 items"),
            ("balanced", usize::MAX, "--items: "),
            ("grid:1e-9", 20, "--patterns grid:1e-9: 1e-9 m"),
            ("poisson:5000:1", 20, "--patterns poisson:5000:1: 5000 m"),
            ("balanced:1000000", 20, "--patterns balanced:1000000: "),
        ] {
            let recipe = Recipe { items, ..RECIPE };
            let source: PatternSource = source.parse().unwrap();
            let message = source.build(&recipe).unwrap_err().to_string();
            assert!(message.starts_with(flag), "{message}");
        }
        let fresh = PatternSource::Balanced(1).draw_fresh(&RECIPE, usize::MAX);
        assert!(fresh.is_err());
    }

    #[test]
    fn sources_are_read_and_shown() {
        for text in ["balanced:3", "grid:0.15", "poisson:0.2:7"] {
            assert_eq!(text.parse::<PatternSource>().unwrap().to_string(), text);
        }
        for bad in [
            "",
            "balanced:0",
            "grid",
            "grid:-1",
            "gird:0.1",
            "no-such.csv",
            "poisson:x",
        ] {
            assert!(bad.parse::<PatternSource>().is_err(), "{bad}");
        }
    }
}
