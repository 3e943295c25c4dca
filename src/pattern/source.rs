//! Sets of patterns, on which strategies are judged.

use super::feed::Feed;
use super::feeder::{Feeder, check_flow};
use super::grid::check_count;
use super::item::{MOST_ITEMS, Pattern};
use super::random_stream;
use super::recipe::Recipe;
use super::recorded::{RecordedPatterns, describe_given, files_of};
use super::set::{Draw, PatternSet};
use crate::error::{Error, Result, counted, shown_number};
use rand::RngExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Range of grid spacings and Poisson radii of the balanced set [m] (Jermann et al., results of the
/// game-theoretic (GT) approach).
const BALANCED_RANGE: (f64, f64) = (0.15, 0.4);
/// Default number of patterns drawn from a profile, however long they are.
const FEWEST_LONG: usize = 3;
/// Patterns of each kind in the balanced set (Jermann et al., Table 1: 240 in total).
pub(super) const BALANCED_EACH: usize = 120;

/// Where patterns come from. [`PatternSource::from_str`](std::str::FromStr) reads the forms below.
#[derive(Debug, Clone, PartialEq)]
pub enum PatternSource {
    /// `balanced[:N]`: N grids and N Poisson disk patterns, with spacings and radii evenly spaced
    /// over [0.15, 0.4] m.
    Balanced(usize),
    /// `grid:S`: a single grid with spacing S [m].
    Grid(f64),
    /// `poisson:R[:N]`: N Poisson disk patterns with radius R [m].
    Poisson(f64, usize),
    /// `FEED[:F/min][:N]`: N patterns of a feed with flow F [1/min]; a single pattern for a grid.
    Feed {
        /// How the items arrive.
        feed: Feed,
        /// Items per minute [1/min]; `None` if a profile gives the flow, or
        /// [`PatternSource::with_flow`] adds it.
        flow: Option<f64>,
        /// Number of patterns.
        count: usize,
    },
    /// A pattern file, or a folder of pattern files.
    Files(PathBuf),
    /// Patterns that the caller has, at least one; no text stands for them. See
    /// [`PatternSource::given`].
    Given(Arc<[Pattern]>),
}

impl PatternSource {
    /// The source of these patterns.
    ///
    /// # Errors
    /// There are none.
    pub fn given(patterns: Vec<Pattern>) -> Result<Self> {
        if patterns.is_empty() {
            return Err(Error::usage(
                "'patterns'",
                "there is no pattern",
                "give one or more",
            ));
        }
        Ok(Self::Given(patterns.into()))
    }

    /// Whether the patterns are recorded or given, and so have their own items, rather than generated.
    pub fn is_recorded(&self) -> bool {
        matches!(self, Self::Files(_) | Self::Given(_))
    }

    /// The pattern files that the source reads.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub fn files(&self) -> Result<Vec<PathBuf>> {
        match self {
            Self::Files(path) => files_of(path),
            Self::Feed { feed, .. } => Ok(feed.file().map(Path::to_owned).into_iter().collect()),
            _ => Ok(Vec::new()),
        }
    }

    /// The folder from which the patterns are read, if any.
    pub fn folder(&self) -> Option<&Path> {
        match self {
            Self::Files(path) => Some(path.as_path()).filter(|path| path.is_dir()),
            _ => None,
        }
    }

    /// The feed that generates the patterns, if any.
    pub fn feed(&self) -> Option<&Feed> {
        match self {
            Self::Feed { feed, .. } => Some(feed),
            _ => None,
        }
    }

    /// The source with this flow [1/min], if there is one. `poisson:N` then means N patterns, as
    /// for the other feeds.
    ///
    /// # Errors
    /// If the flow is invalid, or the source already has a flow or cannot have one.
    pub fn with_flow(self, flow: Option<f64>) -> Result<Self> {
        let Some(flow) = flow else { return Ok(self) };
        let flow = Some(check_flow(flow)?);
        let refused = |problem: String, cure: &str| Err(Error::usage("'flow'", problem, cure));
        match self {
            Self::Feed {
                feed,
                flow: None,
                count,
            } => Ok(Self::Feed { feed, flow, count }),
            Self::Poisson(n, BALANCED_EACH) if n.fract() == 0.0 => Ok(Self::Feed {
                feed: Feed::PoissonDisk,
                flow,
                count: n as usize,
            }),
            Self::Feed { .. } => refused(
                format!("'patterns' {self} already has a flow"),
                "give only one of the two",
            ),
            Self::Grid(_) | Self::Poisson(..) => refused(
                format!("'patterns' {self} already has a flow, by its distance between items"),
                "omit 'flow', or use grid or poisson[:N] without the distance",
            ),
            Self::Balanced(_) => refused(
                "the balanced set covers a range of flows".into(),
                "omit 'flow', or choose one feed, for example 'patterns' random:100",
            ),
            Self::Files(_) | Self::Given(_) => refused(
                "does not apply to recorded patterns".into(),
                "omit 'flow'; recorded patterns contain their own items",
            ),
        }
    }

    /// Items per pattern: `given` if set, otherwise `usual`; for a profile, otherwise as many as it
    /// yields.
    pub fn items(&self, given: Option<usize>, usual: usize) -> usize {
        let whole = matches!(self, Self::Feed { feed, .. } if feed.file().is_some());
        given.unwrap_or(if whole { MOST_ITEMS } else { usual })
    }

    /// Approximate number of items in one generated pattern; 0 for recorded patterns.
    ///
    /// # Errors
    /// If a profile cannot be read or a flow is invalid.
    pub(crate) fn expected_items(&self, recipe: &Recipe) -> Result<f64> {
        match self {
            Self::Feed { feed, flow, .. } => {
                let feeder = Feeder::new(feed, *flow, &recipe.belt, recipe.shape)
                    .map_err(|error| error.inside(&self.place()))?;
                Ok(feeder.expected_items(recipe.items))
            }
            Self::Files(_) | Self::Given(_) => Ok(0.0),
            _ => Ok(recipe.items as f64),
        }
    }

    /// Builds the set of this source. The same recipe always gives the same set.
    ///
    /// # Errors
    /// If files cannot be read or a size is not valid for a pattern.
    pub fn build(&self, recipe: &Recipe) -> Result<PatternSet> {
        let mut set = PatternSet {
            description: String::new(),
            labels: Vec::new(),
            patterns: Vec::new(),
        };
        let made = recipe.describe();
        match self {
            Self::Balanced(n) => {
                let (low, high) = BALANCED_RANGE;
                let steps = (*n).max(2) - 1;
                let value = |i: usize| low + (high - low) * i as f64 / steps as f64;
                self.check_size(recipe, 2.0 * *n as f64, &self.place())?;
                let grids = (0..*n).map(|i| Draw::Grid(value(i)));
                let poissons = (0..*n).map(|i| Draw::Poisson(value(i)));
                set.draw(recipe, grids.chain(poissons).collect(), &self.place())?;
                set.description = format!(
                    "{n} grid and {n} Poisson disk patterns, spacing and radius evenly over \
                     [{low}, {high}] m, {made}"
                );
            }
            Self::Grid(spacing) => {
                self.check_size(recipe, 1.0, &self.place())?;
                set.draw(recipe, vec![Draw::Grid(*spacing)], &self.place())?;
                set.description = format!("the grid of {spacing} m, {made}");
            }
            Self::Poisson(radius, n) => {
                self.check_size(recipe, *n as f64, &self.place())?;
                set.draw(recipe, vec![Draw::Poisson(*radius); *n], &self.place())?;
                set.description = format!("{n} Poisson disk patterns of {radius} m, {made}");
            }
            Self::Feed { feed, flow, count } => {
                let feeder = Feeder::new(feed, *flow, &recipe.belt, recipe.shape)
                    .map_err(|error| error.inside(&self.place()))?;
                let expected = *count as f64 * feeder.expected_items(recipe.items);
                self.check_items(recipe, *count as f64, expected, &self.place())?;
                set.draw(recipe, vec![Draw::Feed(&feeder); *count], &self.place())?;
                set.description = format!(
                    "{} of the feed {feed}, {} items/min at {} m/s, {made}",
                    counted(*count, "pattern"),
                    shown_number(feeder.flow()),
                    shown_number(recipe.belt.speed),
                );
            }
            Self::Files(path) => {
                let recorded = RecordedPatterns::load(path)?;
                set.description = recorded.description(path);
                (set.labels, set.patterns) = (recorded.labels, recorded.patterns);
            }
            Self::Given(patterns) => {
                set.description = describe_given(patterns);
                set.labels = (1..=patterns.len())
                    .map(|n| format!("pattern {n}"))
                    .collect();
                set.patterns = patterns.to_vec();
            }
        }
        Ok(set)
    }

    /// Rejects sets that would take too much memory, before they are made.
    fn check_size(&self, recipe: &Recipe, patterns: f64, place: &str) -> Result<()> {
        self.check_items(recipe, patterns, patterns * recipe.items as f64, place)
    }

    /// The same check for a total of `items` items.
    fn check_items(&self, recipe: &Recipe, patterns: f64, items: f64, place: &str) -> Result<()> {
        check_count(recipe.items).map_err(|error| error.at("'items'"))?;
        let each = items / patterns.max(1.0);
        if items <= MOST_ITEMS as f64 {
            return Ok(());
        }
        Err(Error::usage(
            place,
            format!("{patterns} patterns of {} items", each.ceil()),
            format!("use fewer; a set has at most {MOST_ITEMS} items"),
        ))
    }

    /// Rejects a number of fresh patterns that would take too much memory, before the work whose
    /// result they validate.
    ///
    /// # Errors
    /// If there are too many.
    pub(crate) fn check_fresh(&self, recipe: &Recipe, count: usize) -> Result<()> {
        let items = count as f64 * self.expected_items(recipe)?;
        self.check_items(
            recipe,
            count as f64,
            items,
            &format!("'validation' {count}"),
        )
    }

    /// The source with fewer patterns, about `items` items in total, if `text`, from which it was
    /// parsed, does not give their number and a profile makes each of them long.
    ///
    /// # Errors
    /// If a profile cannot be read.
    pub(crate) fn for_length(mut self, text: &str, recipe: &Recipe, items: f64) -> Result<Self> {
        let expected = self.expected_items(recipe)?;
        if let Self::Feed { feed, count, .. } = &mut self
            && feed.file().is_some()
            && !text.ends_with(&format!(":{count}"))
        {
            let afforded = (items / expected.max(1.0)) as usize;
            *count = afforded.clamp(FEWEST_LONG.min(*count), *count);
        }
        Ok(self)
    }

    /// The setting and its value, for messages.
    fn place(&self) -> String {
        format!("'patterns' {self}")
    }

    /// `count` patterns that differ from those of [`PatternSource::build`] under any seed, to score
    /// what was selected on such a set; the spacings and radii of the balanced set are then random.
    /// `None` if no fresh patterns can be drawn: for files and for a single grid.
    ///
    /// # Errors
    /// See [`PatternSource::build`].
    pub fn draw_fresh(&self, recipe: &Recipe, count: usize) -> Result<Option<PatternSet>> {
        match self {
            Self::Balanced(_) => {
                self.check_fresh(recipe, count)?;
                let (low, high) = BALANCED_RANGE;
                let mut set = PatternSet {
                    description: format!(
                        "{count} fresh patterns, grid and Poisson disk in turn, spacing and \
                         radius at random over [{low}, {high}] m, {}",
                        recipe.describe()
                    ),
                    labels: Vec::new(),
                    patterns: Vec::new(),
                };
                // A separate stream, after those of the patterns.
                let mut rng = random_stream(recipe.seed, u64::MAX);
                let draws = (0..count).map(|i| {
                    let value = low + (high - low) * rng.random::<f64>();
                    if i % 2 == 0 {
                        Draw::Grid(value)
                    } else {
                        Draw::Poisson(value)
                    }
                });
                set.draw(recipe, draws.collect(), &self.place())?;
                Ok(Some(set))
            }
            Self::Poisson(radius, _) => Self::Poisson(*radius, count).build(recipe).map(Some),
            Self::Feed { feed, flow, .. } if feed.is_random() => {
                let (feed, flow) = (feed.clone(), *flow);
                Self::Feed { feed, flow, count }.build(recipe).map(Some)
            }
            Self::Grid(_) | Self::Feed { .. } | Self::Files(_) | Self::Given(_) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::attributes::Attributes;
    use super::super::feed::FeedShape;
    use super::*;
    use crate::pattern::grid;
    use crate::station::Belt;

    const RECIPE: Recipe = Recipe {
        belt: Belt {
            speed: 0.05,
            length: 4.2,
            width: 1.05,
        },
        items: 20,
        shape: FeedShape {
            cluster_size: 5.0,
            cluster_spread: 0.1,
            gap_length: 1.0,
            gap_share: 0.3,
        },
        attributes: Attributes {
            area_cm2: None,
            p_detection: None,
            p_grasp: None,
            classes: None,
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
    fn fresh_patterns_differ() {
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
            ("grid:0.2", 0, "'items': 0 items"),
            ("balanced", usize::MAX, "'items': "),
            ("grid:1e-9", 20, "'patterns' grid:1e-9: 1e-9 m"),
            ("poisson:5000:1", 20, "'patterns' poisson:5000:1: 5000 m"),
            ("balanced:1000000", 20, "'patterns' balanced:1000000: "),
        ] {
            let recipe = Recipe { items, ..RECIPE };
            let source: PatternSource = source.parse().unwrap();
            let message = source.build(&recipe).unwrap_err().to_string();
            assert!(message.starts_with(flag), "{message}");
        }
        let fresh = PatternSource::Balanced(1).draw_fresh(&RECIPE, usize::MAX);
        let message = fresh.unwrap_err().to_string();
        assert!(message.starts_with("'validation' "), "{message}");
    }

    #[test]
    fn given_patterns_are_the_set_and_have_no_fresh_ones() {
        let patterns = [0.2, 0.3].map(|spacing| grid(1.05, spacing, 5).unwrap());
        let source = PatternSource::given(patterns.to_vec()).unwrap();
        let set = source.build(&RECIPE).unwrap();
        assert_eq!(set.patterns, patterns);
        assert_eq!(set.labels, ["pattern 1", "pattern 2"]);
        assert!(set.description.starts_with("2 given patterns (hash "));
        assert_eq!(source.to_string(), "2 given patterns");
        assert!(source.is_recorded() && !PatternSource::Grid(0.2).is_recorded());
        assert!(source.draw_fresh(&RECIPE, 3).unwrap().is_none());
        let training = source.training_set(&RECIPE, 9).unwrap();
        assert!(training.seen && training.set.patterns == patterns);
        let message = source.with_flow(Some(60.0)).unwrap_err().to_string();
        assert!(
            message.contains("does not apply to recorded patterns"),
            "{message}"
        );
        let message = PatternSource::given(Vec::new()).unwrap_err().to_string();
        assert!(message.contains("there is no pattern"), "{message}");
    }

    #[test]
    fn sources_are_read_and_shown() {
        for text in [
            "balanced:3",
            "grid:0.15",
            "poisson:0.2:7",
            "grid",
            "poisson",
            "grid:600/min",
            "poisson:600/min:7",
            "random:7",
            "random:600/min:7",
            "clustered:0.5/min:1",
            "gaps:120",
            "profile:a/b.csv:7",
            "profile:c:/b.csv:60/min:7",
        ] {
            assert_eq!(text.parse::<PatternSource>().unwrap().to_string(), text);
        }
        let nothing = "not a known kind of pattern, and no such file or folder exists";
        for (bad, problem) in [
            ("", nothing),
            ("balanced:0", "`0` is not a valid count"),
            ("grid:600/min:7", "too many parts for grid"),
            ("random:0.2", "`0.2` is not a valid count"),
            ("random:600:7", "`600` is not a valid flow"),
            ("random:0/min", "`0/min` is not a valid flow"),
            ("profile", "profile needs a file"),
            ("profile:", "profile needs a file"),
            ("grid:-1", "`-1` is not a valid length [m]"),
            ("gird:0.1", "did you mean `grid`"),
            ("no-such.csv", nothing),
            ("poisson:x", "`x` is not a valid length [m]"),
        ] {
            let message = bad.parse::<PatternSource>().unwrap_err().to_string();
            assert!(message.contains(problem), "{bad}: {message}");
        }
    }
}
