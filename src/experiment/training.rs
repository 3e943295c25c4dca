//! Patterns like those of a comparison's cases, to find robust GT on.

use super::case::{Case, CaseSource};
use crate::error::Result;
use crate::pattern::{PatternSet, Recipe, TrainingSet, grids_around};
use crate::station::Belt;

/// Patterns of each case at least.
const LEAST: usize = 12;
/// How far the seeds of training patterns are from those of the patterns that are judged,
/// which follow the master seed.
const APART: u64 = 1 << 32;

/// About `count` patterns of the kinds of `cases`, equally many of each, under seeds far from
/// those that follow `seed`; a recorded case is trained on itself. `items`, where given,
/// stands in for the cases' own.
///
/// # Errors
/// A pattern that cannot be had.
pub fn training_set(
    cases: &[Case],
    belt: &Belt,
    items: Option<usize>,
    count: usize,
    seed: u64,
) -> Result<TrainingSet> {
    let each = (count / cases.len().max(1)).max(LEAST);
    let seed = seed.wrapping_add(APART);
    let mut set = PatternSet {
        description: String::new(),
        labels: Vec::new(),
        patterns: Vec::new(),
    };
    let mut seen = false;
    for case in cases {
        let case = Case {
            items: items.unwrap_or(case.items),
            ..case.clone()
        };
        let patterns = match &case.source {
            CaseSource::Grid(spacing) => {
                let recipe = Recipe {
                    belt: *belt,
                    items: case.items,
                    shape: Default::default(),
                    attributes: Default::default(),
                    seed,
                };
                grids_around(*spacing, &recipe, each)?.patterns
            }
            _ => {
                let drawn = case.patterns(belt, each, seed)?;
                seen |= drawn.iter().all(|(seed, _)| seed.is_none());
                // As much weight as any other case.
                let copies = each.div_ceil(drawn.len().max(1));
                let drawn = drawn.into_iter().map(|(_, pattern)| pattern);
                std::iter::repeat_n(drawn.collect::<Vec<_>>(), copies)
                    .flatten()
                    .collect()
            }
        };
        let label = |number: usize| format!("like {} #{number}", case.name);
        set.labels.extend((1..=patterns.len()).map(label));
        set.patterns.extend(patterns);
    }
    set.description = format!(
        "{} patterns like those of the cases, as many of each",
        set.patterns.len()
    );
    Ok(TrainingSet { set, seen })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::load_cases;

    #[test]
    fn every_case_has_its_share_and_no_judged_pattern_is_among_them() {
        let cases = load_cases("paper").unwrap();
        let station = crate::station::built_in("paper")
            .unwrap()
            .station(None)
            .unwrap();
        let belt = station.belt();
        let training = training_set(&cases, belt, None, 60, 1).unwrap();
        assert!(!training.seen);
        let labels = &training.set.labels;
        for case in &cases {
            let name = format!("like {} #", case.name);
            let count = labels.iter().filter(|l| l.starts_with(&name)).count();
            assert!((15..=16).contains(&count), "{name}: {count}");
            for (_, judged) in case.patterns(belt, 100, 2).unwrap() {
                assert!(!training.set.patterns.contains(&judged), "{}", case.name);
            }
        }
    }
}
