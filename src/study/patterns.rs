//! The patterns that a study scores on.

use crate::error::{Error, Result};
use crate::pattern::{
    Attributes, Feed, FeedParameters, FeedShape, Pattern, PatternSet, PatternSource, Recipe,
};
use crate::sim::Conditions;
use crate::station::Station;
use std::str::FromStr;

/// Number of items in all patterns of a set whose number of patterns is not given.
const USUAL_SET: f64 = 40_000.0;
/// Number of items in a generated pattern, as in the balanced set of `docs/model.md`.
const DEFAULT_ITEMS: usize = 150;
/// Number of runs of a small set if something can go wrong: enough for a mean over random events.
const DRAWS: usize = 100;

/// Which patterns a study scores on. Parsed from a text such as `balanced:120` or
/// `poisson:0.15:100`; the other settings apply to patterns that are generated.
#[derive(Debug, Clone)]
pub struct ScoredPatterns {
    source: PatternSource,
    /// As written, which tells whether the number of patterns is given.
    text: String,
    items: Option<usize>,
    shape: FeedShape,
    attributes: Attributes,
}

impl From<PatternSource> for ScoredPatterns {
    /// The patterns of `source`, exactly as many as it says.
    fn from(source: PatternSource) -> Self {
        Self {
            text: source.to_string(),
            source,
            items: None,
            shape: FeedShape::default(),
            attributes: Attributes::default(),
        }
    }
}

impl FromStr for ScoredPatterns {
    type Err = Error;

    /// Parses a source of patterns. A profile without a number of patterns gives fewer of
    /// them if each is long.
    fn from_str(text: &str) -> Result<Self> {
        Ok(Self {
            text: text.to_owned(),
            ..text.parse::<PatternSource>()?.into()
        })
    }
}

impl ScoredPatterns {
    /// With this flow [1/min] of the feed, which must not have one yet.
    ///
    /// # Errors
    /// As for [`PatternSource::with_flow`].
    pub fn with_flow(self, flow: f64) -> Result<Self> {
        Ok(Self {
            source: self.source.with_flow(Some(flow))?,
            ..self
        })
    }

    /// With this number of items in each generated pattern.
    #[must_use]
    pub fn with_items(mut self, items: usize) -> Self {
        self.items = Some(items);
        self
    }

    /// With the shape that these parameters give the feed.
    ///
    /// # Errors
    /// As for [`FeedParameters::shape`].
    pub fn with_parameters(self, parameters: &FeedParameters) -> Result<Self> {
        let feeds: Vec<&Feed> = self.source.feed().into_iter().collect();
        let shape = parameters.shape(&feeds)?;
        Ok(self.with_shape(shape))
    }

    /// With this shape of clusters and gaps.
    #[must_use]
    pub fn with_shape(mut self, shape: FeedShape) -> Self {
        self.shape = shape;
        self
    }

    /// With these attributes of the generated items.
    #[must_use]
    pub fn with_attributes(mut self, attributes: Attributes) -> Self {
        self.attributes = attributes;
        self
    }

    /// Where the patterns come from.
    pub fn source(&self) -> &PatternSource {
        &self.source
    }

    /// The number of items asked for.
    pub(super) fn items(&self) -> Option<usize> {
        self.items
    }

    /// Where the patterns come from and how they are generated for `station`, with
    /// `usual_items` items in each unless another number is given.
    ///
    /// # Errors
    /// A setting that does not apply to recorded patterns, or a profile that cannot be read.
    pub(super) fn recipe(
        &self,
        station: &Station,
        seed: u64,
        usual_items: usize,
    ) -> Result<(PatternSource, Recipe)> {
        if self.source.is_recorded() {
            let given = [
                ("'items'", self.items.is_some()),
                ("'area_cm2'", self.attributes.area_cm2.is_some()),
                ("'p_detection'", self.attributes.p_detection.is_some()),
                ("'p_grasp'", self.attributes.p_grasp.is_some()),
                ("'classes'", self.attributes.classes.is_some()),
            ];
            if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
                return Err(Error::usage(
                    *option,
                    "does not apply to recorded patterns",
                    "leave it out; recorded patterns have their own items",
                ));
            }
        }
        let recipe = Recipe {
            belt: *station.belt(),
            items: self.source.items(self.items, usual_items),
            shape: self.shape,
            attributes: self.attributes.clone(),
            seed,
        };
        let source = self.source.clone();
        let source = source.for_length(&self.text, &recipe, USUAL_SET)?;
        Ok((source, recipe))
    }

    /// Where more patterns such as these come from, and how they are generated for `station`.
    ///
    /// # Errors
    /// As for [`ScoredPatterns::draw`], except for what only the patterns themselves show.
    pub(super) fn drawn_as(&self, station: &Station, seed: u64) -> Result<(PatternSource, Recipe)> {
        self.recipe(station, seed, DEFAULT_ITEMS)
    }

    /// The patterns for `station` under `conditions`.
    ///
    /// # Errors
    /// A setting that does not apply, a set that cannot be generated or read, or an item beside
    /// the belt.
    pub fn draw(&self, station: &Station, seed: u64, conditions: &Conditions) -> Result<ScoredSet> {
        let (source, recipe) = self.recipe(station, seed, DEFAULT_ITEMS)?;
        let drawn = source.build(&recipe)?;
        drawn.check_on(station)?;
        let repeated = is_repeated(&drawn, &source, conditions).then(|| with_draws(&drawn, DRAWS));
        Ok(ScoredSet {
            source,
            recipe,
            drawn,
            repeated,
        })
    }
}

/// The patterns of a study, generated or read.
#[derive(Debug, Clone)]
pub struct ScoredSet {
    pub(super) source: PatternSource,
    pub(super) recipe: Recipe,
    drawn: PatternSet,
    /// The same patterns several times, if each has different random events.
    repeated: Option<PatternSet>,
}

impl ScoredSet {
    /// The patterns, each once.
    pub fn drawn(&self) -> &PatternSet {
        &self.drawn
    }

    /// The patterns as they are scored: if something can go wrong, patterns that are not drawn
    /// at random are repeated with different random events, a hundred runs in total.
    pub fn scored(&self) -> &PatternSet {
        self.repeated.as_ref().unwrap_or(&self.drawn)
    }
}

/// Whether the patterns of `set` have several draws of random events each.
fn is_repeated(set: &PatternSet, source: &PatternSource, conditions: &Conditions) -> bool {
    is_fixed(source) && conditions.is_random() && set.patterns.len() < DRAWS
}

/// Whether the patterns of `source` are not drawn at random.
fn is_fixed(source: &PatternSource) -> bool {
    match source {
        PatternSource::Feed { feed, .. } => !feed.is_random(),
        source => source.is_recorded() || matches!(source, PatternSource::Grid(_)),
    }
}

/// The patterns of `set`, which is from `source`: those that are not drawn at random are repeated
/// with other draws of what their items truly are, a hundred runs in total.
pub(super) fn with_detection_draws(
    set: PatternSet,
    source: &PatternSource,
    conditions: &Conditions,
) -> PatternSet {
    let chance = &conditions.disturbances;
    let draws = |pattern: &Pattern| chance.draws_detections(pattern.items());
    let few = set.patterns.len() < DRAWS;
    match is_fixed(source) && few && set.patterns.iter().any(draws) {
        true => with_draws(&set, DRAWS),
        false => set,
    }
}

/// The patterns of `set`, repeated up to `count` in total, but at least once each.
pub(super) fn with_draws(set: &PatternSet, count: usize) -> PatternSet {
    let one_each = set.patterns.len();
    let places = (0..count.max(one_each)).map(|place| (place % one_each, place / one_each + 1));
    let (labels, patterns) = places
        .map(|(of, draw)| {
            let label = format!("{}, replication {draw}", set.labels[of]);
            (label, set.patterns[of].clone())
        })
        .unzip();
    PatternSet {
        description: format!(
            "{}, {} runs, each with independent random numbers",
            set.description,
            count.max(one_each)
        ),
        labels,
        patterns,
    }
}

/// Offset from one seed of random events to another, far from the consecutive seeds of
/// pattern sets.
const OTHER_LUCK: u64 = 1 << 32;

/// `conditions` with a seed that scoring under `conditions` never uses, for training and for
/// fresh patterns.
pub(super) fn independent_events(conditions: &Conditions) -> Conditions {
    let seed = conditions.disturbances.seed;
    conditions.with_seed(seed.wrapping_add(OTHER_LUCK))
}
