//! The set of patterns for every verb that takes `--patterns`.

use super::args::PatternSetArgs;
use super::settings::NOTHING_FAILS;
use pickline::error::{Error, Result};
use pickline::pattern::{FeedShape, PatternSet, PatternSource, Recipe};
use pickline::sim::Conditions;
use pickline::station::Station;

/// Number of items in all patterns of a set without a given size.
pub const USUAL_SET: f64 = 40_000.0;
/// Number of items in a generated pattern, as in the balanced set of `docs/model.md`.
const DEFAULT_ITEMS: usize = 150;

/// How to generate the patterns of `source` for `station`.
///
/// # Errors
/// An invalid distribution, or a flag that does not apply to recorded patterns.
pub fn recipe(
    args: &PatternSetArgs,
    seed: u64,
    source: &PatternSource,
    shape: FeedShape,
    station: &Station,
) -> Result<Recipe> {
    let attributes = args.attributes.resolve()?;
    if matches!(source, PatternSource::Files(_)) {
        let given = [
            ("--items", args.items.is_some()),
            ("--area", attributes.area_cm2.is_some()),
            ("--p-detection", attributes.p_detection.is_some()),
            ("--p-grasp", attributes.p_grasp.is_some()),
        ];
        if let Some((flag, _)) = given.iter().find(|(_, given)| *given) {
            return Err(Error::input(
                *flag,
                "does not apply to recorded patterns",
                "leave it out; recorded patterns have their own items",
            ));
        }
    }
    Ok(Recipe {
        belt: *station.belt(),
        items: source.items(args.items, DEFAULT_ITEMS),
        shape,
        attributes,
        seed,
    })
}

/// Builds the set, and checks that every pattern lies on the belt.
///
/// # Errors
/// A set that cannot be generated or read, or an item beside the belt, with its pattern.
pub fn build(source: &PatternSource, recipe: &Recipe, station: &Station) -> Result<PatternSet> {
    let set = source.build(recipe)?;
    for (label, pattern) in set.labels.iter().zip(&set.patterns) {
        let on_belt = pattern.check_on(station);
        on_belt.map_err(|error| error.inside(label))?;
    }
    Ok(set)
}

/// Total number of runs of a small set if something can go wrong: enough for a mean over luck.
const DRAWS: usize = 100;

/// `set` as scored under `conditions`: if something can go wrong, patterns that are not drawn
/// at random are repeated with different luck, a hundred runs in total.
pub fn with_luck(set: PatternSet, source: &PatternSource, conditions: &Conditions) -> PatternSet {
    let fixed = match source {
        PatternSource::Feed { feed, .. } => !feed.is_random(),
        source => matches!(source, PatternSource::Grid(_) | PatternSource::Files(_)),
    };
    if !fixed || !conditions.disturbances.any() || set.patterns.len() >= DRAWS {
        return set;
    }
    with_draws(set, DRAWS)
}

/// The patterns of `set`, repeated up to `count` in total, but at least once each.
pub fn with_draws(set: PatternSet, count: usize) -> PatternSet {
    let one_each = set.patterns.len();
    let places = (0..count.max(one_each)).map(|place| (place % one_each, place / one_each + 1));
    let (labels, patterns) = places
        .map(|(of, draw)| {
            let label = format!("{}, luck {draw}", set.labels[of]);
            (label, set.patterns[of].clone())
        })
        .unzip();
    PatternSet {
        description: format!(
            "{}, {} runs, each with its own luck",
            set.description,
            count.max(one_each)
        ),
        labels,
        patterns,
    }
}

/// Notes for any result on `set` under `conditions`. `independent` is the number of patterns
/// on which the cascade could be used.
pub fn notes(
    set: &PatternSet,
    conditions: &Conditions,
    independent: usize,
    patterns: usize,
) -> Vec<String> {
    let mut notes = Vec::new();
    let mut rewards = set
        .patterns
        .iter()
        .flat_map(|p| p.items())
        .map(|i| i.reward());
    let first = rewards.next();
    if first.is_some_and(|first| rewards.all(|reward| reward == first)) {
        notes.push(
            "all items weigh the same, so PP picks like FIFO; give areas or probabilities \
             (--area, --p-grasp) to tell them apart"
                .to_owned(),
        );
    }
    let overlapping = patterns - independent;
    if conditions.disturbances.any() {
        let items = set.patterns.iter();
        if items
            .clone()
            .all(|p| conditions.disturbances.never_fails(p.items()))
        {
            notes.push(NOTHING_FAILS.to_owned());
        }
        notes.push(
            "every assignment meets the same luck on a pattern; as something can go wrong, the \
             general event loop simulates each assignment by itself"
                .to_owned(),
        );
    } else if overlapping > 0 {
        notes.push(format!(
            "extended workspaces overlap on {overlapping} of {patterns} patterns; there, the \
             general event loop simulated each assignment by itself"
        ));
    }
    notes
}
