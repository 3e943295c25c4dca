//! The patterns on which a policy is scored while it learns.

use crate::error::Result;
use crate::experiment::load_cases;
use crate::pattern::{Pattern, random_stream};
use crate::rl::domain::with_classes;
use crate::station::Station;

/// Number of patterns per random case.
const TRIALS: usize = 10;
/// The first seed of these patterns, far from the seeds of tables, which start at 1.
const TRIAL_SEED: u64 = 990_000;

/// The patterns of every case in `cases` (`paper`, `dense`, `all` or a TOML file) on which trainings on
/// `station` score their policies, by the names of the cases.
///
/// # Errors
/// Cases that cannot be read, or that cannot be generated for the station.
pub fn trials(cases: &str, station: &Station) -> Result<Vec<(String, Vec<Pattern>)>> {
    let mut list = Vec::new();
    for case in load_cases(cases)? {
        let patterns = case.patterns(station.belt(), TRIALS, TRIAL_SEED)?;
        let complete = |(index, (_, pattern)): (usize, (_, Pattern))| {
            let mut rng = random_stream(TRIAL_SEED, index as u64);
            Ok(with_classes(&pattern, station, &mut rng)?.unwrap_or(pattern))
        };
        let patterns = patterns.into_iter().enumerate().map(complete);
        list.push((case.name, patterns.collect::<Result<_>>()?));
    }
    Ok(list)
}
