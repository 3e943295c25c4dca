//! One strategy on one line, and how far the line is from what it was trained on.

use super::robust::LineSearch;
use crate::error::Result;
use crate::optimize::Environment;
use crate::planning::Allowance;
use crate::policy::Outside;
use crate::setters::setters;
use crate::station::Station;
use crate::strategies::{Blueprint, StrategySpec};
use std::cell::OnceCell;
use std::fmt;

/// How a strategy is put on a line.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct BlueprintOptions {
    /// Master seed of the search for bases.
    pub seed: u64,
    /// Decisions are taken at multiples of 1 / `update_hz` [s]; 0 for the exact time.
    pub update_hz: f64,
    /// Budget of one decision, unless the strategy itself sets it.
    pub allowance: Allowance,
}

impl Default for BlueprintOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            update_hz: 0.0,
            allowance: Allowance::default(),
        }
    }
}

setters!(BlueprintOptions {
    /// With this master seed.
    fn with_seed(seed: u64);
    /// With decisions at multiples of 1 / `update_hz` [s]; 0 for the exact time.
    fn with_update_hz(update_hz: f64);
    /// With this budget of one decision.
    fn with_allowance(allowance: Allowance);
});

/// `strategy` on the line of `station`. A strategy that looks ahead and names no bases gets the
/// best assignments of a short search.
///
/// # Errors
/// Options that the strategy rejects, rules for another number of robots, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted).
pub fn blueprint(
    strategy: &StrategySpec,
    station: &Station,
    options: &BlueprintOptions,
    environment: &Environment,
) -> Result<Blueprint> {
    let line = LineSearch::new(station, options.seed, options.update_hz, environment);
    line.put(strategy, &OnceCell::new(), options.allowance)
}

/// How a line differs from what a policy was trained on.
#[derive(Debug, Clone, PartialEq)]
pub struct PolicyDistance {
    text: String,
    is_far: bool,
}

impl PolicyDistance {
    /// Whether the difference is too large for the policy's scores to mean much.
    pub fn is_far(&self) -> bool {
        self.is_far
    }
}

impl fmt::Display for PolicyDistance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// How `station` differs from what `blueprint` was trained on; `None` if it does not differ, or
/// if nothing was trained.
pub fn policy_distance(blueprint: &Blueprint, station: &Station) -> Option<PolicyDistance> {
    let outside = blueprint.trained()?.outside(station);
    let is_far = outside.iter().any(Outside::is_far);
    let facts: Vec<String> = outside.iter().map(Outside::to_string).collect();
    let how = if is_far {
        "is far from its training"
    } else {
        "is a little outside its training"
    };
    (!facts.is_empty()).then(|| PolicyDistance {
        text: format!(
            "{}: this line {how}: {}",
            blueprint.name(),
            facts.join(", ")
        ),
        is_far,
    })
}
