//! The set of patterns that a verb is judged on, for every verb that takes `--patterns`.

use super::args::PatternSetArgs;
use crate::error::{Error, Result};
use crate::pattern::{FeedShape, PatternSet, PatternSource, Recipe};
use crate::station::Station;

/// Items in a generated pattern, as in the balanced set of `docs/model.md`.
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

/// What a reader of any result on `set` should know, `independent` being the number of
/// patterns on which the cascade served.
pub fn notes(set: &PatternSet, independent: usize, patterns: usize) -> Vec<String> {
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
    if overlapping > 0 {
        notes.push(format!(
            "on {overlapping} of {patterns} patterns extended workspaces overlap; those were \
             simulated by the general event loop, assignment by assignment"
        ));
    }
    notes
}
