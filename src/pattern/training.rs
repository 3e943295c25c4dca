//! Patterns on which strategies are searched: of the same kind as those on which they are judged,
//! but with a different seed.

use super::grid::grid;
use super::random_stream;
use super::recipe::Recipe;
use super::set::PatternSet;
use super::source::PatternSource;
use crate::error::Result;

/// Half the width of the range around a grid's spacing, as a share of the spacing.
const AROUND: f64 = 0.1;

/// A set of patterns on which strategies are searched.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TrainingSet {
    /// The patterns to search on.
    pub set: PatternSet,
    /// Whether these are the same patterns on which strategies are judged, which must be reported.
    pub seen: bool,
}

impl PatternSource {
    /// About `count` patterns of the same kind as this source. The seed of the recipe must differ
    /// from that of the patterns used for judging. A grid is a single pattern, so grids with
    /// similar spacings are used instead. Recorded patterns have no alternatives and are used
    /// themselves.
    ///
    /// # Errors
    /// See [`PatternSource::build`].
    pub fn training_set(&self, recipe: &Recipe, count: usize) -> Result<TrainingSet> {
        if let Self::Grid(spacing) = self {
            let set = grids_around(*spacing, recipe, count)?;
            return Ok(TrainingSet { set, seen: false });
        }
        Ok(match self.draw_fresh(recipe, count)? {
            Some(set) => TrainingSet { set, seen: false },
            None => TrainingSet {
                set: self.build(recipe)?,
                seen: true,
            },
        })
    }
}

/// `count` grids, rounded up to an even number so that `spacing` [m] itself is not among them, with
/// spacings evenly distributed around it.
///
/// # Errors
/// If a spacing is not valid for a grid.
pub(crate) fn grids_around(spacing: f64, recipe: &Recipe, count: usize) -> Result<PatternSet> {
    let count = count.next_multiple_of(2).max(2);
    let share = |place: usize| 1.0 - AROUND + 2.0 * AROUND * place as f64 / (count - 1) as f64;
    let spacings: Vec<f64> = (0..count).map(|place| spacing * share(place)).collect();
    let grids = spacings.iter().zip(0..).map(|(&spacing, place)| {
        let pattern = grid(recipe.belt.width, spacing, recipe.items)?;
        let mut rng = random_stream(recipe.seed, place);
        recipe.attributes.apply(pattern, &mut rng)
    });
    Ok(PatternSet {
        description: format!(
            "{count} grids of {:.4} to {:.4} m, {} items a pattern",
            spacings[0],
            spacings[count - 1],
            recipe.items
        ),
        labels: spacings.iter().map(|s| format!("grid s={s:.4}")).collect(),
        patterns: grids.collect::<Result<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn training_patterns_are_of_the_same_kind_and_differ() {
        let recipe = Recipe {
            belt: *crate::station::built_in("paper")
                .unwrap()
                .station(None)
                .unwrap()
                .belt(),
            items: 20,
            shape: Default::default(),
            attributes: Default::default(),
            seed: 1,
        };
        let judged = Recipe {
            seed: 2,
            ..recipe.clone()
        };
        for text in [
            "grid:0.15",
            "poisson:0.2:10",
            "balanced:5",
            "random:100/min:4",
        ] {
            let source: PatternSource = text.parse().unwrap();
            let training = source.training_set(&recipe, 30).unwrap();
            assert!(
                !training.seen && training.set.patterns.len() == 30,
                "{text}"
            );
            let judged = source.build(&judged).unwrap();
            let shared = |p| training.set.patterns.contains(p);
            assert!(!judged.patterns.iter().any(shared), "{text}");
        }
    }
}
