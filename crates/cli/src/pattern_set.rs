//! The set of patterns that a verb is judged on, for every verb that takes `--patterns`.

use super::args::PatternSetArgs;
use super::settings::NOTHING_FAILS;
use pickline::error::{Error, Result};
use pickline::pattern::{FeedShape, PatternSet, PatternSource, Recipe};
use pickline::sim::Conditions;
use pickline::station::Station;

/// Items in a generated pattern, as in the balanced set of `docs/model.md`.
/// Items in all of a set whose size is left open.
pub const USUAL_SET: f64 = 40_000.0;
const DEFAULT_ITEMS: usize = 150;

/// How the patterns of `source` are made for `station`.
///
/// # Errors
/// A distribution that is none, a flag that has no meaning for recorded patterns.
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
                "has no meaning for recorded patterns",
                "leave it out; recorded patterns hold their own items",
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

/// The set, every pattern of it checked to lie on the belt.
///
/// # Errors
/// A set that cannot be made or read, an item beside the belt, with its pattern.
pub fn build(source: &PatternSource, recipe: &Recipe, station: &Station) -> Result<PatternSet> {
    let set = source.build(recipe)?;
    for (label, pattern) in set.labels.iter().zip(&set.patterns) {
        let on_belt = pattern.check_on(station);
        on_belt.map_err(|error| error.inside(label))?;
    }
    Ok(set)
}

/// Runs of every pattern where it is one of few and something can go wrong: enough for a
/// mean over luck.
const DRAWS: usize = 100;

/// `set` as it is judged under `conditions`: where something can go wrong, patterns that are
/// not drawn at random are run on as many draws of luck as make a hundred runs.
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

/// The patterns of `set` again and again, `count` in all or one of each.
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
            "{}, {} runs with luck of their own",
            set.description,
            count.max(one_each)
        ),
        labels,
        patterns,
    }
}

/// What a reader of any result on `set` under `conditions` should know, `independent` being the number of
/// patterns on which the cascade served.
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
            "every assignment meets the same luck on a pattern; where something can go wrong \
             the general event loop simulates, assignment by assignment"
                .to_owned(),
        );
    } else if overlapping > 0 {
        notes.push(format!(
            "on {overlapping} of {patterns} patterns extended workspaces overlap; those were \
             simulated by the general event loop, assignment by assignment"
        ));
    }
    notes
}
