//! The certified bound against brute force, a linear program and every rule.

use crate::common;
use good_lp::{Expression, ProblemVariables, Solution, SolverModel, constraint, variable};
use pickline::checker;
use pickline::decision::{Candidate, Figures, Moment};
use pickline::pattern::{Item, Pattern, grid, poisson_disk, random_stream};
use pickline::planning::bound::{
    Bound, Objective, Options, StopReason, certified_percent, upper_bound,
};
use pickline::sim::{AssignmentTree, Conditions, Disturbances, Scene};
use pickline::station::{Belt, Robot, Station, built_in};
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::TestRunner;
use std::collections::BTreeMap;

fn bound(scene: &Scene, options: &Options) -> Bound {
    upper_bound(scene, options, &mut |_, _| true).unwrap()
}

fn options(objective: Objective, iterations: usize) -> Options {
    Options {
        objective,
        iterations,
        ..Options::default()
    }
}

/// The best of all schedules.
#[derive(Debug)]
struct Optimum {
    picks: usize,
    weight: f64,
    rate: f64,
    weighted_rate: f64,
    end: f64,
    all_end: Option<f64>,
}

/// Enumerates every schedule: which robot picks which items in which order. Leaving as
/// early as possible is best for any of them, as who leaves earlier is free earlier.
struct Enumeration<'a> {
    scene: &'a Scene<'a>,
    taken: Vec<bool>,
    best: Optimum,
}

impl<'a> Enumeration<'a> {
    fn optimum(scene: &'a Scene<'a>) -> Optimum {
        let mut all = Self {
            scene,
            taken: vec![false; scene.pattern().len()],
            best: Optimum {
                picks: 0,
                weight: 0.0,
                rate: 0.0,
                weighted_rate: 0.0,
                end: f64::INFINITY,
                all_end: None,
            },
        };
        all.robot(0, 0.0, 0.0);
        all.best
    }

    /// All continuations with robot `robot`, free at `free`, and those after it.
    fn robot(&mut self, robot: usize, free: f64, last_release: f64) {
        if robot == self.scene.station().robots().len() {
            return self.enter(last_release);
        }
        self.robot(robot + 1, 0.0, last_release);
        for candidate in self.scene.queue(robot) {
            let start = free.max(candidate.open);
            if self.taken[candidate.item as usize] || start > candidate.close {
                continue;
            }
            let moment = Moment::new(self.scene.station(), robot, start);
            let release = start + moment.processing_time(candidate);
            self.taken[candidate.item as usize] = true;
            self.robot(robot, release, last_release.max(release));
            self.taken[candidate.item as usize] = false;
        }
    }

    fn enter(&mut self, last_release: f64) {
        let items = self.scene.pattern().items();
        let taken = &self.taken;
        let of = |wanted: bool| (0..items.len()).filter(move |&i| taken[i] == wanted);
        let left = of(false).map(|item| self.scene.leaves_belt(item));
        let figures = Figures {
            items: items.len(),
            picked: of(true).count(),
            weight: of(true).map(|item| items[item].reward()).sum(),
            end: left.fold(last_release, f64::max),
        };
        let best = &mut self.best;
        best.picks = best.picks.max(figures.picked);
        best.weight = best.weight.max(figures.weight);
        best.rate = best.rate.max(figures.picking_rate());
        best.weighted_rate = best.weighted_rate.max(figures.weighted_rate());
        best.end = best.end.min(figures.end);
        if figures.complete() {
            let all = best.all_end.unwrap_or(f64::INFINITY);
            best.all_end = Some(all.min(figures.end));
        }
    }
}

/// A sum of weights may differ by the order in which it was added up.
const SUMS: f64 = 1.0 + 1e-12;

fn holds(bound: &Bound, best: &Optimum) {
    let about = format!("{bound:?}\n{best:?}");
    let (earned, rate) = match bound.objective {
        Objective::Picks => (best.picks as f64, best.rate),
        Objective::Weight => (best.weight, best.weighted_rate),
    };
    assert!(earned <= bound.value * SUMS, "{about}");
    assert!(bound.value <= bound.relaxed, "{about}");
    assert!(bound.rate.is_none_or(|most| rate <= most * SUMS), "{about}");
    assert!(bound.end <= best.end, "{about}");
    if let Some(end) = best.all_end {
        assert!(bound.all_end.is_some_and(|least| least <= end), "{about}");
    }
}

/// Tiny lines: as the other tests have them, and with arms so slow and items so close
/// together that robots compete.
fn tiny() -> impl Strategy<Value = (Station, Pattern)> {
    let any = prop_oneof![common::stations(), common::lines()];
    let few = any.prop_filter("at most three robots", |s| s.robots().len() <= 3);
    let dwell = prop_oneof![Just(0.0), 0.0..30.0f64];
    let cases = few.prop_flat_map(|station| {
        let pattern = common::patterns(station.belt().width, 6);
        (Just(station), pattern)
    });
    (cases, dwell, 0.05..1.0f64).prop_map(|((station, pattern), dwell, squeeze)| {
        let robot = |robot: &Robot| Robot {
            grasp_time: robot.grasp_time + dwell,
            ..robot.clone()
        };
        let robots = station.robots().iter().map(robot).collect();
        let item = |item: &Item| Item {
            x0: item.x0 * squeeze,
            ..item.clone()
        };
        let items = pattern.items().iter().map(item).collect();
        let station = Station::new(*station.belt(), robots).unwrap();
        (station, Pattern::new(items).unwrap())
    })
}

/// 300 random instances, every schedule of each enumerated: no bound is ever below the
/// optimum, after one step no more than after many, and mostly it is the optimum.
#[test]
fn no_bound_is_below_the_optimum_of_tiny_instances() {
    let mut runner = TestRunner::deterministic();
    let (mut contested, mut reached) = (0, 0);
    let mut tightness = Vec::new();
    for _ in 0..300 {
        let (station, pattern) = tiny().new_tree(&mut runner).unwrap().current();
        let scene = Scene::new(&station, &pattern).unwrap();
        let best = Enumeration::optimum(&scene);
        for objective in [Objective::Picks, Objective::Weight] {
            for iterations in [1, 2, 7, 60] {
                let found = bound(&scene, &options(objective, iterations));
                holds(&found, &best);
                if let Some(schedule) = &found.schedule {
                    checker::check(&station, &pattern, schedule).unwrap();
                    let earned = found.earned(&schedule.figures);
                    assert!(earned <= found.value * SUMS);
                    assert_eq!(found.stop == StopReason::Optimal, earned >= found.value);
                }
                if objective == Objective::Picks && iterations == 60 && best.picks > 0 {
                    contested += usize::from(best.picks < found.reachable);
                    reached += usize::from(found.value == best.picks as f64);
                    tightness.push(best.rate / found.rate.unwrap_or(f64::INFINITY));
                }
            }
            for slot_s in [0.01, 0.3, 5.0] {
                let slot_s = Some(slot_s);
                let options = Options {
                    slot_s,
                    ..options(objective, 30)
                };
                holds(&bound(&scene, &options), &best);
            }
        }
    }
    tightness.sort_by(f64::total_cmp);
    println!(
        "{contested} of {} instances have items that cannot all be picked; the bound on picks \
         is the optimum of {reached}; the best rate is {:.3} of the bound on it in the median, \
         {:.3} at the lower quartile",
        tightness.len(),
        tightness[tightness.len() / 2],
        tightness[tightness.len() / 4]
    );
    assert!(contested > 50, "only {contested} instances have a contest");
    assert!(reached > 200, "{reached} of 300 bounds are the optimum");
}

/// The same relaxation as a linear program in its other usual form: a variable for every
/// robot, item and slot of departure, every robot in at most one pick at any slot.
fn linear_program(scene: &Scene, slot: f64) -> f64 {
    let station = scene.station();
    let mut variables = ProblemVariables::new();
    let mut objective = Expression::default();
    let mut items: BTreeMap<u32, Expression> = BTreeMap::new();
    let mut busy: BTreeMap<(usize, u64), Expression> = BTreeMap::new();
    let of = |time: f64| (time / slot).floor() as u64;
    for robot in 0..station.robots().len() {
        for candidate in scene.queue(robot) {
            let Candidate { open, close, .. } = *candidate;
            for departure in of(open)..=of(close) {
                let start = open.max(departure as f64 * slot);
                let moment = Moment::new(station, robot, start);
                let free = of(start + moment.processing_time(candidate));
                let pick = variables.add(variable().min(0.0));
                objective += pick;
                *items.entry(candidate.item).or_default() += pick;
                for at in departure..free {
                    *busy.entry((robot, at)).or_default() += pick;
                }
            }
        }
    }
    let mut model = variables
        .maximise(objective.clone())
        .using(good_lp::microlp);
    for sum in items.into_values().chain(busy.into_values()) {
        model.add_constraint(constraint!(sum <= 1.0));
    }
    model.solve().unwrap().eval(objective)
}

/// Items so close together that no line picks them all.
fn dense(station: &Station, items: usize, seed: u64) -> Pattern {
    let mut rng = random_stream(seed, 0);
    poisson_disk(station.belt().width, 0.05, items, &mut rng).unwrap()
}

#[test]
fn the_bound_is_that_of_the_linear_program() {
    let slot = 0.2;
    // Belts so fast that far from everything can be picked, and windows are short.
    for (name, items, speed) in [("paper", 100, 0.1), ("paper-narrow", 80, 0.15)] {
        let station = built_in(name).unwrap().station(Some(2)).unwrap();
        let station = station.with_belt_speed(speed).unwrap();
        let pattern = dense(&station, items, 3);
        let scene = Scene::new(&station, &pattern).unwrap();
        let exact = linear_program(&scene, slot);
        assert!(
            exact < 0.9 * items as f64,
            "{name}: {exact}, hardly a contest"
        );
        let options = Options {
            slot_s: Some(slot),
            ends: false,
            ..options(Objective::Picks, 1000)
        };
        let found = bound(&scene, &options);
        println!(
            "{name}: bound {:.3}, linear program {exact:.3}",
            found.relaxed
        );
        assert!(
            found.relaxed >= exact - 1e-6,
            "{name}: {} < {exact}",
            found.relaxed
        );
        assert!(
            found.relaxed <= 1.01 * exact,
            "{name}: {} > {exact}",
            found.relaxed
        );
    }
}

/// The cases that strategies are judged on.
fn standard_cases(width: f64) -> Vec<Pattern> {
    let mut patterns = Vec::new();
    for (spacing, items) in [(0.15, 50), (0.3, 50), (0.15, 150)] {
        patterns.push(grid(width, spacing, items).unwrap());
    }
    for (radius, items) in [(0.2, 29), (0.3, 36), (0.1, 150), (0.12, 150), (0.15, 150)] {
        let mut rng = random_stream(5, 0);
        patterns.push(poisson_disk(width, radius, items, &mut rng).unwrap());
    }
    patterns
}

#[test]
fn no_rule_beats_the_bound_on_the_standard_cases() {
    for (name, robots) in [("paper", 2), ("paper-narrow", 2), ("paper", 3)] {
        let station = built_in(name).unwrap().station(Some(robots)).unwrap();
        let tree = AssignmentTree::all(robots);
        for pattern in standard_cases(station.belt().width) {
            let scene = Scene::new(&station, &pattern).unwrap();
            let found = bound(&scene, &Options::quick(Objective::Picks));
            let mut runs = 0;
            tree.evaluate(&scene, |_, figures| {
                runs += 1;
                assert!(figures.picked as f64 <= found.value, "{name} {found:?}");
                assert!(
                    found
                        .rate
                        .is_some_and(|most| figures.picking_rate() <= most)
                );
                assert!(found.end <= figures.end);
                if figures.complete() {
                    assert!(found.all_end.is_some_and(|least| least <= figures.end));
                }
            })
            .unwrap();
            assert_eq!(runs, 6usize.pow(robots as u32));
        }
    }
}

/// Failures only cost time, and a pick succeeds only in the window of the true position.
#[test]
fn the_bound_holds_where_things_go_wrong() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let tree = AssignmentTree::all(2);
    for (camera_x, failures, position_noise) in [
        (Some(0.8), false, 0.0),
        (Some(0.8), true, 0.0),
        (None, true, 0.02),
        (Some(-0.5), false, 0.1),
    ] {
        for seed in 1..4 {
            let pattern = dense(&station, 40, seed);
            let conditions = Conditions {
                update_hz: 10.0,
                camera_x,
                disturbances: Disturbances {
                    grasp_failures: failures,
                    default_p_grasp: 0.8,
                    position_noise,
                    seed,
                },
            };
            let scene = Scene::under(&station, &pattern, conditions).unwrap();
            let found = bound(&scene, &options(Objective::Picks, 60));
            tree.evaluate(&scene, |_, figures| {
                assert!(figures.picked as f64 <= found.value, "{conditions:?}");
                assert!(figures.picking_rate() <= found.rate.unwrap());
                assert!(found.end <= figures.end);
            })
            .unwrap();
            if position_noise == 0.0 && !failures {
                let plain = Scene::new(&station, &pattern).unwrap();
                let most = bound(&plain, &options(Objective::Picks, 60));
                assert!(found.relaxed <= most.relaxed + 0.5, "a camera is no help");
            }
        }
    }
}

/// Weak duality: every step's bound holds, so stopping anywhere only makes it looser.
#[test]
fn stopping_early_only_loosens_it() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = grid(1.05, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let whole = bound(&scene, &Options::default());
    let schedule = whole.schedule.as_ref().unwrap();
    checker::check(&station, &pattern, schedule).unwrap();
    assert!(schedule.figures.picked > 120, "{:?}", schedule.figures);
    assert!(
        whole.value < 141.0 && whole.all_end.is_none(),
        "{}",
        whole.value
    );
    let mut last = f64::INFINITY;
    for stop_at in [1, 5, 20, 60, 150, 250] {
        let found =
            upper_bound(&scene, &Options::default(), &mut |step, _| step < stop_at).unwrap();
        assert_eq!(found.stop, StopReason::Interrupted);
        assert_eq!(found.iterations, stop_at);
        assert!(found.value <= last && found.value >= whole.value);
        assert!(found.rate.unwrap() >= whole.rate.unwrap());
        assert!(found.end <= whole.end);
        assert!(schedule.figures.picking_rate() <= found.rate.unwrap());
        last = found.value;
    }
}

#[test]
fn known_answers() {
    let robot = |name: &str, x: f64, dwell: f64| Robot {
        name: name.into(),
        base: [x, -0.5].into(),
        bin: [x, -0.5].into(),
        reach: 0.6,
        speed: 0.5,
        grasp_time: dwell,
        release_time: 0.0,
    };
    let belt = Belt {
        speed: 0.1,
        length: 4.0,
        width: 1.0,
    };
    let items = |weights: &[f64]| {
        let items = weights.iter().enumerate().map(|(i, &weight)| Item {
            weight: Some(weight),
            ..Item::at(i.to_string(), -0.01 * i as f64, -0.4)
        });
        Pattern::new(items.collect()).unwrap()
    };
    // So long a dwell that each robot gets one item, the heaviest two of all.
    let station = Station::new(belt, vec![robot("a", 1.0, 60.0), robot("b", 2.5, 60.0)]).unwrap();
    let pattern = items(&[1.0, 5.0, 0.0, 3.0, 1e-3]);
    let scene = Scene::new(&station, &pattern).unwrap();
    let picks = bound(&scene, &options(Objective::Picks, 100));
    assert_eq!((picks.value, picks.stop), (2.0, StopReason::Optimal));
    assert_eq!((picks.reachable, picks.all_end), (5, None));
    let weight = bound(&scene, &options(Objective::Weight, 100));
    assert!((8.0..8.05).contains(&weight.value), "{}", weight.value);
    // Nothing within reach, nothing worth anything.
    let far = Pattern::new(vec![Item::at("far", 0.0, 0.4)]).unwrap();
    for (pattern, reachable) in [(&far, 0), (&items(&[0.0, 0.0]), 2)] {
        let scene = Scene::new(&station, pattern).unwrap();
        let found = bound(&scene, &options(Objective::Weight, 100));
        assert_eq!((found.value, found.reachable), (0.0, reachable));
        assert!(found.end <= 40.1, "{}", found.end);
    }
    assert_eq!(certified_percent(2.0, 3.0), 66.6);
    assert_eq!(certified_percent(3.0, 3.0), 100.0);
    assert_eq!(certified_percent(0.0, 0.0), 100.0);
    // No rounding up to what is not proven.
    assert_eq!(certified_percent(9999.0, 10000.0), 99.9);
}

#[test]
fn slots_that_cannot_be_are_refused_and_huge_patterns_are_not() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = grid(1.05, 0.15, 60_000).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    for (slot, word) in [
        (0.0, "not a length"),
        (-1.0, "not a length"),
        (f64::NAN, "not a length"),
        (1e-6, "too short"),
    ] {
        let options = Options {
            slot_s: Some(slot),
            ..Options::default()
        };
        let error = upper_bound(&scene, &options, &mut |_, _| true).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let found = bound(&scene, &Options::quick(Objective::Picks));
    assert_eq!(found.stop, StopReason::TooMany);
    assert_eq!(found.value, 60_000.0);
}
