//! Which patterns a case gets, and the random events of each run.

use super::case::Case;
use crate::error::Result;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Scene};
use crate::station::Station;

/// What a case is drawn from: its patterns, and the random events of each run.
#[derive(Clone, Copy)]
pub struct Draws<'a> {
    /// Number of patterns of each random case.
    pub replicates: usize,
    /// The seed of the first pattern; the others follow.
    pub first_seed: u64,
    /// What the camera sees and what goes wrong.
    pub conditions: &'a Conditions,
}

impl Draws<'_> {
    /// The patterns of `case`, each with its seed if it has one.
    pub(super) fn patterns(
        &self,
        case: &Case,
        station: &Station,
    ) -> Result<Vec<(Option<u64>, Pattern)>> {
        let patterns = case.patterns(station.belt(), self.replicates, self.first_seed)?;
        let has_seeds = patterns.iter().any(|(seed, _)| seed.is_some());
        let chance = &self.conditions.disturbances;
        let draws = |(_, pattern): &(_, Pattern)| chance.draws_detections(pattern.items());
        if has_seeds || !(self.conditions.is_random() || patterns.iter().any(draws)) {
            return Ok(patterns);
        }
        // Every pattern at least once.
        let runs = self.replicates.max(patterns.len());
        let seeds = (0..runs as u64).map(|r| Some(self.first_seed.wrapping_add(r)));
        let again = patterns.iter().map(|(_, pattern)| pattern).cycle();
        Ok(seeds.zip(again.cloned()).collect())
    }

    /// The scene for one of the patterns.
    pub(super) fn scene<'s>(
        &self,
        seed: Option<u64>,
        pattern: &'s Pattern,
        station: &'s Station,
    ) -> Result<Scene<'s>> {
        let conditions = self.conditions.with_seed(seed.unwrap_or(self.first_seed));
        Scene::under(station, pattern, conditions)
    }
}
