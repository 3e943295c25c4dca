//! The cases of a comparison.

use crate::error::{Error, Result, shown};
use crate::names::check_name;
use crate::pattern::{
    self, Attributes, Feed, FeedShape, Feeder, Pattern, describe_given, grid, poisson_disk,
    random_stream,
};
use crate::station::Belt;
use rand::rngs::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a case's patterns come from.
#[derive(Debug, Clone, PartialEq)]
pub enum CaseSource {
    /// The grid with this spacing [m]; there is only one.
    Grid(f64),
    /// Poisson disk patterns with this radius [m].
    Poisson(f64),
    /// A feed with this flow [1/min]; a profile may define its own flow.
    Feed(Feed, Option<f64>),
    /// The pattern in this CSV file.
    File(PathBuf),
    /// Patterns that the caller has; see [`Case::given`].
    Given(Arc<[Pattern]>),
}

/// A kind of pattern on which strategies are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Name in tables and result files; no two cases of a comparison share one.
    pub name: String,
    /// Where its patterns come from.
    pub source: CaseSource,
    /// Items in each pattern; for a profile, the maximum; 0 for a recorded pattern.
    pub items: usize,
    /// What its items have besides their position, if they are generated.
    pub attributes: Attributes,
}

/// A built-in case.
#[derive(Clone, Copy)]
struct BuiltInCase {
    is_grid: bool,
    /// Spacing of the grid or radius of the Poisson disks [m].
    distance: f64,
    items: usize,
}

impl BuiltInCase {
    const fn grid(spacing: f64, items: usize) -> Self {
        Self {
            is_grid: true,
            distance: spacing,
            items,
        }
    }

    const fn poisson(radius: f64, items: usize) -> Self {
        Self {
            is_grid: false,
            distance: radius,
            items,
        }
    }
}

/// The paper's four cases with the item counts fitted to its Table 2 (`docs/model.md`).
const PAPER: [BuiltInCase; 4] = [
    BuiltInCase::grid(0.15, 50),
    BuiltInCase::grid(0.3, 50),
    BuiltInCase::poisson(0.2, 29),
    BuiltInCase::poisson(0.3, 36),
];

/// Dense cases, on which strategies differ most.
const DENSE: [BuiltInCase; 4] = [
    BuiltInCase::grid(0.15, 150),
    BuiltInCase::poisson(0.1, 150),
    BuiltInCase::poisson(0.12, 150),
    BuiltInCase::poisson(0.15, 150),
];

/// The built-in cases that `name` stands for: `paper`, `dense` or `all`.
pub(super) fn built_in_cases(name: &str) -> Option<Vec<Case>> {
    let cases = match name {
        "paper" => PAPER.to_vec(),
        "dense" => DENSE.to_vec(),
        "all" => [PAPER, DENSE].concat(),
        _ => return None,
    };
    Some(cases.into_iter().map(Case::built_in).collect())
}

impl Case {
    /// The case `name` of patterns that the caller has.
    ///
    /// # Errors
    /// There are none, or the name is not one.
    pub fn given(name: &str, patterns: Vec<Pattern>) -> Result<Self> {
        if let Err(bad) = check_name(name) {
            let cure = format!("give every case a name; expected {}", bad.expected);
            return Err(Error::usage("'cases'", bad.problem, cure));
        }
        if patterns.is_empty() {
            return Err(Error::usage(
                "'cases'",
                format!("the case `{}` has no pattern", shown(name)),
                "give one or more",
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            source: CaseSource::Given(patterns.into()),
            items: 0,
            attributes: Attributes::default(),
        })
    }

    fn built_in(case: BuiltInCase) -> Self {
        let BuiltInCase {
            is_grid,
            distance,
            items,
        } = case;
        let (kind, source) = match is_grid {
            true => ("grid", CaseSource::Grid(distance)),
            false => ("poisson", CaseSource::Poisson(distance)),
        };
        Self {
            name: format!("{kind} {distance}, {items} items"),
            source,
            items,
            attributes: Attributes::default(),
        }
    }

    /// The same with these attributes of its items; a recorded case keeps its own.
    #[must_use]
    pub fn with_attributes(mut self, attributes: Attributes) -> Self {
        if self.is_generated() {
            self.attributes = attributes;
        }
        self
    }

    /// The file that the case reads: a recorded pattern or a profile.
    pub fn file(&self) -> Option<&Path> {
        match &self.source {
            CaseSource::File(path) => Some(path),
            CaseSource::Feed(feed, _) => feed.file(),
            _ => None,
        }
    }

    /// The case in words: its name, and what tells given patterns from others.
    pub fn in_words(&self) -> String {
        match &self.source {
            CaseSource::Given(patterns) => format!("{}, {}", self.name, describe_given(patterns)),
            _ => self.name.clone(),
        }
    }

    /// Whether its patterns depend on the seed.
    pub fn is_random(&self) -> bool {
        self.attributes != Attributes::default() || self.has_random_places()
    }

    /// Whether the positions of its items depend on the seed.
    fn has_random_places(&self) -> bool {
        match &self.source {
            CaseSource::Grid(_) | CaseSource::File(_) | CaseSource::Given(_) => false,
            CaseSource::Poisson(_) => true,
            CaseSource::Feed(feed, _) => feed.is_random(),
        }
    }

    /// Whether its patterns are generated rather than recorded or given.
    pub fn is_generated(&self) -> bool {
        !matches!(self.source, CaseSource::File(_) | CaseSource::Given(_))
    }

    /// Approximate number of items in one of its patterns on `belt` if `items` are requested; 0
    /// for a recorded or given pattern.
    ///
    /// # Errors
    /// A profile that cannot be read, or an invalid flow.
    pub(crate) fn expected_items(&self, belt: &Belt, items: Option<usize>) -> Result<f64> {
        let items = items.unwrap_or(self.items);
        match &self.source {
            CaseSource::Feed(feed, flow) => {
                let feeder = Feeder::new(feed, *flow, belt, FeedShape::default());
                let feeder = feeder.map_err(|error| error.inside(&self.name).into_input())?;
                Ok(feeder.expected_items(items))
            }
            CaseSource::File(_) | CaseSource::Given(_) => Ok(0.0),
            _ => Ok(items as f64),
        }
    }

    /// The patterns on `belt`, each with the seed from which it is drawn; `None` if nothing is
    /// random. Random cases are replicated with the seeds `first_seed`, `first_seed + 1`, ...
    ///
    /// # Errors
    /// A recorded pattern or a profile that cannot be read, or an invalid flow.
    pub fn patterns(
        &self,
        belt: &Belt,
        replicates: usize,
        first_seed: u64,
    ) -> Result<Vec<(Option<u64>, Pattern)>> {
        let replicated = |draw: &dyn Fn(&mut ChaCha8Rng) -> Result<Pattern>| {
            let seeds = (0..replicates as u64).map(|r| first_seed.wrapping_add(r));
            let drawn = seeds.map(|seed| {
                let mut rng = random_stream(seed, 0);
                let pattern = draw(&mut rng)?;
                Ok((Some(seed), self.attributes.apply(pattern, &mut rng)?))
            });
            drawn.collect()
        };
        match &self.source {
            CaseSource::Grid(spacing) => {
                let grid = |_: &mut ChaCha8Rng| grid(belt.width, *spacing, self.items);
                match self.is_random() {
                    true => replicated(&grid),
                    false => Ok(vec![(None, grid(&mut random_stream(0, 0))?)]),
                }
            }
            CaseSource::File(path) => Ok(vec![(None, pattern::load(path)?.pattern)]),
            CaseSource::Given(patterns) => Ok(patterns.iter().map(|p| (None, p.clone())).collect()),
            CaseSource::Poisson(radius) => {
                replicated(&|rng| poisson_disk(belt.width, *radius, self.items, rng))
            }
            CaseSource::Feed(feed, flow) => {
                let shape = FeedShape::default();
                let feeder = Feeder::new(feed, *flow, belt, shape);
                let feeder = feeder.map_err(|error| error.inside(&self.name).into_input())?;
                match self.is_random() {
                    true => replicated(&|rng| feeder.draw(self.items, rng)),
                    false => {
                        let pattern = feeder.draw(self.items, &mut random_stream(0, 0))?;
                        Ok(vec![(None, pattern)])
                    }
                }
            }
        }
    }
}

/// `cases`, with these attributes of all items that are generated.
///
/// # Errors
/// There are attributes, but no items are generated.
pub fn with_attributes(cases: Vec<Case>, attributes: &Attributes) -> Result<Vec<Case>> {
    if *attributes != Attributes::default() && !cases.iter().any(Case::is_generated) {
        return Err(Error::usage(
            "'area_cm2', 'p_detection', 'p_grasp' and 'classes'",
            "do not apply to recorded patterns",
            "leave them out; recorded patterns have their own items",
        ));
    }
    let cases = cases.into_iter();
    Ok(cases
        .map(|case| case.with_attributes(attributes.clone()))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_cases_are_named_and_drawn() {
        let cases = built_in_cases("all").unwrap();
        assert_eq!(cases.len(), 8);
        assert_eq!(cases[2].name, "poisson 0.2, 29 items");
        let drawn = cases[2].patterns(&BELT, 3, 7).unwrap();
        assert_eq!(
            drawn.iter().map(|d| d.0).collect::<Vec<_>>(),
            [Some(7), Some(8), Some(9)]
        );
        assert_eq!(cases[0].patterns(&BELT, 3, 7).unwrap().len(), 1);
        assert_eq!(built_in_cases("papre"), None);
    }

    #[test]
    fn given_patterns_are_a_case_with_all_of_them() {
        let patterns = [0.2, 0.3].map(|spacing| grid(BELT.width, spacing, 5).unwrap());
        let case = Case::given("mine", patterns.to_vec()).unwrap();
        let drawn = case.patterns(&BELT, 1, 7).unwrap();
        assert_eq!(drawn, patterns.clone().map(|pattern| (None, pattern)));
        let other = Case::given("mine", vec![patterns[0].clone()]).unwrap();
        assert!(case.in_words().starts_with("mine, 2 given patterns (hash "));
        assert_ne!(case.in_words(), other.in_words());
        let attributes = Attributes::named(Some("const:80"), None, None, None).unwrap();
        let refused = with_attributes(vec![case.clone()], &attributes).unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("do not apply to recorded patterns")
        );
        let both = [vec![case], built_in_cases("paper").unwrap()].concat();
        let both = with_attributes(both, &attributes).unwrap();
        assert_eq!(both[0].attributes, Attributes::default());
        assert_eq!(both[1].attributes, attributes);
        for (name, patterns, words) in [
            ("", patterns.to_vec(), "give every case a name"),
            ("mine", Vec::new(), "the case `mine` has no pattern"),
        ] {
            let message = Case::given(name, patterns).unwrap_err().to_string();
            assert!(
                message.contains("'cases'") && message.contains(words),
                "{message}"
            );
        }
    }

    fn of(source: CaseSource, items: usize) -> Case {
        Case {
            name: "c".into(),
            source,
            items,
            attributes: Attributes::default(),
        }
    }

    const BELT: Belt = Belt {
        speed: 0.05,
        length: 4.2,
        width: 1.05,
    };

    #[test]
    fn what_a_case_is_follows_from_its_source() {
        let folder = tempfile::tempdir().unwrap();
        let (own, profile) = (folder.path().join("p.csv"), folder.path().join("f.csv"));
        std::fs::write(&own, "id,x,y\n1,0,0\n").unwrap();
        // 30 items a minute for two minutes.
        std::fs::write(&profile, "time_s,flow_per_min\n0,30\n120,30\n").unwrap();
        let one = grid(BELT.width, 0.2, 4).unwrap();
        let feed = |feed| CaseSource::Feed(feed, Some(60.0));
        let shift = || CaseSource::Feed(Feed::Profile(profile.clone()), None);
        for (source, random, generated, file, expected) in [
            (CaseSource::Grid(0.2), false, true, None, 40.0),
            (CaseSource::Poisson(0.2), true, true, None, 40.0),
            (feed(Feed::Grid), false, true, None, 40.0),
            (feed(Feed::Random), true, true, None, 40.0),
            (shift(), true, true, Some(&profile), 40.0),
            (CaseSource::File(own.clone()), false, false, Some(&own), 0.0),
            (CaseSource::Given([one].into()), false, false, None, 0.0),
        ] {
            let case = of(source, 40);
            let what = format!("{:?}", case.source);
            assert_eq!(case.is_random(), random, "{what}");
            assert_eq!(case.is_generated(), generated, "{what}");
            assert_eq!(case.file(), file.map(|file| file.as_path()), "{what}");
            assert_eq!(
                case.expected_items(&BELT, None).unwrap(),
                expected,
                "{what}"
            );
            let drawn = case.patterns(&BELT, 3, 5).unwrap();
            assert_eq!(drawn.len(), if random { 3 } else { 1 }, "{what}");
            let seeds: Vec<Option<u64>> = drawn.iter().map(|drawn| drawn.0).collect();
            match random {
                true => assert_eq!(seeds, [Some(5), Some(6), Some(7)], "{what}"),
                false => assert_eq!(seeds, [None], "{what}"),
            }
            let patterns = |first: usize| case.patterns(&BELT, 1, 5 + first as u64).unwrap();
            for (place, drawn) in drawn.iter().enumerate() {
                // The first of a set, under the seed of its place.
                assert_eq!(patterns(place)[0].1, drawn.1, "{what}");
            }
            assert_eq!(
                random,
                drawn.len() > 1 && drawn[0].1 != drawn[1].1,
                "{what}"
            );
        }
        let case = of(shift(), 100);
        assert_eq!(case.expected_items(&BELT, None).unwrap(), 60.0);
        assert_eq!(case.expected_items(&BELT, Some(7)).unwrap(), 7.0);
        assert_eq!(
            of(CaseSource::Grid(0.2), 40)
                .expected_items(&BELT, Some(7))
                .unwrap(),
            7.0
        );
        let message = of(CaseSource::Feed(Feed::Random, None), 4).patterns(&BELT, 1, 5);
        let message = message.unwrap_err().to_string();
        assert!(
            message.contains("c: ") && message.contains("needs a flow"),
            "{message}"
        );
        let message = of(CaseSource::Feed(Feed::Random, None), 4).expected_items(&BELT, None);
        let message = message.unwrap_err().to_string();
        assert!(
            message.contains("c: ") && message.contains("needs a flow"),
            "{message}"
        );
    }
}
