//! Planning on lines with several places, unlike arms and classes: the bound holds against every
//! schedule, and look-ahead plays by the rules.

#[path = "../common/real_lines.rs"]
mod common_real_lines;

use common_real_lines::{Book, patterns, stations};
use nalgebra::Point2;
use pickline::checker;
use pickline::dispatch::RuleAssignment;
use pickline::pattern::Pattern;
use pickline::planning::bound::{BoundObjective, BoundOptions, upper_bound};
use pickline::planning::{Lookahead, LookaheadOptions};
use pickline::sim::{Scene, simulate, simulate_rules};
use pickline::station::Station;
use proptest::prelude::*;

/// The best of all schedules, found by trying them all: which robot takes which items in which order,
/// each as early as possible. Leaving later never helps, as the bin, and so the place from which the
/// arm goes on, depends on robot and item alone.
struct Schedules<'a> {
    book: Book<'a>,
    taken: Vec<bool>,
    most: usize,
    heaviest: f64,
    /// The most items of one part of the pattern.
    most_of_part: usize,
}

/// The items that are a part of their pattern, for bounds of such a part: every other one.
fn is_part(item: usize) -> bool {
    item.is_multiple_of(2)
}

/// What a schedule has earned: items, their weight, and the items of the part.
type Earned = (usize, f64, usize);

impl Schedules<'_> {
    fn of(station: &Station, pattern: &Pattern) -> Earned {
        let book = Book {
            station,
            items: pattern.items(),
        };
        let taken = book.items.iter().map(|item| !book.wanted(item)).collect();
        let mut all = Schedules {
            book,
            taken,
            most: 0,
            heaviest: 0.0,
            most_of_part: 0,
        };
        let rest = station.robots()[0].rest;
        all.robot(0, (0.0, rest), (0, 0.0, 0));
        (all.most, all.heaviest, all.most_of_part)
    }

    fn robot(&mut self, index: usize, (free, place): (f64, Point2<f64>), had: Earned) {
        self.most = self.most.max(had.0);
        self.heaviest = self.heaviest.max(had.1);
        self.most_of_part = self.most_of_part.max(had.2);
        let robots = self.book.station.robots();
        if let Some(next) = robots.get(index + 1) {
            self.robot(index + 1, (0.0, next.rest), had);
        }
        let robot = &robots[index];
        for number in 0..self.book.items.len() {
            let item = &self.book.items[number];
            if self.taken[number] {
                continue;
            }
            let Some((open, close)) = self.book.window(robot, place, item) else {
                continue;
            };
            let start = free.max(open);
            if start > close {
                continue;
            }
            let (_, _, release) = self.book.pick(robot, place, item, start);
            let bin = &robot.bins[self.book.bin(robot, item).unwrap()];
            let of_part = usize::from(is_part(number));
            let weight = self.book.weight(item);
            let more = (had.0 + 1, had.1 + weight, had.2 + of_part);
            self.taken[number] = true;
            self.robot(index, (release, bin.at), more);
            self.taken[number] = false;
        }
    }
}

fn cases(robots: usize, items: usize) -> impl Strategy<Value = (Station, Pattern)> {
    let few = stations().prop_filter("few robots", move |s| s.robots().len() <= robots);
    few.prop_flat_map(move |station| {
        let width = station.belt().width;
        (Just(station), patterns(width, items))
    })
}

fn bounds(scene: &Scene, objective: BoundObjective) -> f64 {
    let options = BoundOptions::default()
        .with_objective(objective)
        .with_iterations(60);
    upper_bound(scene, &options, &mut |_, _| true)
        .unwrap()
        .value
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]

    #[test]
    fn no_schedule_has_more_than_the_bound((station, pattern) in cases(2, 5)) {
        let (most, heaviest, most_of_part) = Schedules::of(&station, &pattern);
        let scene = Scene::new(&station, &pattern).unwrap();
        let picks = bounds(&scene, BoundObjective::Picks);
        prop_assert!(most as f64 <= picks, "{most} {picks}");
        let weight = bounds(&scene, BoundObjective::Weight);
        prop_assert!(heaviest <= weight * (1.0 + 1e-9), "{heaviest} {weight}");
        let part: Vec<bool> = (0..pattern.len()).map(is_part).collect();
        let options = BoundOptions::default().with_iterations(60).with_counted(part);
        let part = upper_bound(&scene, &options, &mut |_, _| true).unwrap();
        prop_assert!(most_of_part as f64 <= part.value, "{most_of_part} {}", part.value);
        prop_assert!(part.schedule.is_none() && part.value <= pattern.len() as f64);
    }

    #[test]
    fn no_strategy_has_more_than_the_bound((station, pattern) in cases(6, 40)) {
        let scene = Scene::new(&station, &pattern).unwrap();
        let most = bounds(&scene, BoundObjective::Picks);
        let rules = vec!["SPT"; station.robots().len()].join(",");
        let rules: RuleAssignment = rules.parse().unwrap();
        let by_rules = simulate_rules(&scene, &rules).unwrap();
        let options = LookaheadOptions::default();
        let mut lookahead = Lookahead::new(options);
        let planned = simulate(&scene, &mut lookahead).unwrap();
        for outcome in [&by_rules, &planned] {
            checker::check(&station, &pattern, outcome)
                .map_err(|e| TestCaseError::fail(e.to_string()))?;
            prop_assert!(outcome.figures.picked as f64 <= most);
        }
    }
}
