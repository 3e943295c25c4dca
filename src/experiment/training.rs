//! Patterns similar to those of a comparison's cases, for training robust GT (game theory).

use super::case::{Case, CaseSource};
use crate::error::Result;
use crate::pattern::{PatternSet, Recipe, TrainingSet, grids_around};
use crate::station::Belt;

/// Minimum number of patterns of each case.
const LEAST: usize = 12;
/// Distance between the seeds of training patterns and those of the evaluated patterns, which
/// start at the master seed.
const APART: u64 = 1 << 32;

/// About `count` patterns of the kinds of `cases`, equally many of each, with seeds far from
/// those that start at `seed`. A recorded case is used for training itself. `items`, if given,
/// overrides the cases' own number.
///
/// # Errors
/// A pattern that cannot be generated or read.
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
                    attributes: case.attributes.clone(),
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
        "{} patterns like those of the cases, equally many of each",
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

    /// Random cases use seeds that no table uses; those start at the master seed.
    #[test]
    fn training_seeds_are_far_from_judged_ones() {
        let station = crate::station::built_in("paper").unwrap();
        let station = station.station(None).unwrap();
        let belt = station.belt();
        let cases = &load_cases("paper").unwrap()[2..];
        for (count, each) in [(60, 30), (24, 12), (4, 12)] {
            let training = training_set(cases, belt, Some(10), count, 7).unwrap();
            let mut expected = Vec::new();
            for case in cases {
                let case = Case {
                    items: 10,
                    ..case.clone()
                };
                let far = case.patterns(belt, each, 7 + (1 << 32)).unwrap();
                assert_eq!(far[0].0, Some(4_294_967_303));
                expected.extend(far.into_iter().map(|(_, pattern)| pattern));
            }
            assert_eq!(training.set.patterns, expected, "{count}");
            assert_eq!(training.set.labels.len(), expected.len());
            assert_eq!(training.set.labels[0], "like poisson 0.2, 29 items #1");
            assert_eq!(training.set.labels[each], "like poisson 0.3, 36 items #1");
            let words = format!("{} patterns like those of the cases", 2 * each);
            assert!(training.set.description.starts_with(&words));
            assert!(!training.seen);
        }
    }

    /// A case that cannot be drawn again is used for training itself, as often as the others.
    #[test]
    fn a_recorded_case_is_seen_and_weighs_as_much_as_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("p.csv");
        std::fs::write(&file, "id,x,y\n1,0,0\n2,-0.5,0.1\n").unwrap();
        let case = |name: &str, source, items| Case {
            name: name.into(),
            source,
            items,
            attributes: Default::default(),
        };
        let cases = [
            case("own", CaseSource::File(file), 0),
            case("grid", CaseSource::Grid(0.2), 30),
        ];
        let station = crate::station::built_in("paper").unwrap();
        let station = station.station(None).unwrap();
        let training = training_set(&cases, station.belt(), None, 40, 7).unwrap();
        assert!(training.seen);
        let labels = |name: &str| {
            let labels = training.set.labels.iter();
            labels
                .filter(|l| l.starts_with(&format!("like {name} #")))
                .count()
        };
        assert_eq!([labels("own"), labels("grid")], [20, 20]);
        let own = &training.set.patterns[..20];
        assert!(
            own.iter()
                .all(|pattern| pattern.len() == 2 && *pattern == own[0])
        );
        assert!(
            training.set.patterns[20..]
                .iter()
                .all(|pattern| pattern.len() == 30)
        );
        let grids = training_set(&cases[1..], station.belt(), None, 40, 7).unwrap();
        assert!(!grids.seen);
    }
}
