//! The certified bound against brute force, a linear program and every rule.

use crate::brute_force::{SUMS, bound, holds, optimum, options, tiny, undisturbed};
use good_lp::{Expression, ProblemVariables, Solution, SolverModel, constraint, variable};
use pickline::checker;
use pickline::decision::{Candidate, Moment};
use pickline::pattern::{Item, Pattern, grid, poisson_disk, random_stream};
use pickline::planning::bound::{
    BoundObjective, BoundOptions, BoundStop, certified_percent, upper_bound,
};
use pickline::sim::{AssignmentTree, Conditions, Disturbances, Scene};
use pickline::station::{Station, built_in};
use proptest::strategy::{Strategy as _, ValueTree as _};
use proptest::test_runner::TestRunner;
use std::collections::BTreeMap;

/// 300 random instances, every schedule of each enumerated: no bound is ever below the
/// optimum, after one step no more than after many, and mostly it is the optimum.
#[test]
fn no_bound_is_below_the_optimum_of_tiny_instances() {
    let mut runner = TestRunner::deterministic();
    let (mut contested, mut reached) = (0, 0);
    let mut tightness = Vec::new();
    for _ in 0..300 {
        let (station, pattern) = tiny(6).new_tree(&mut runner).unwrap().current();
        let scene = Scene::new(&station, &pattern).unwrap();
        let best = optimum(&scene);
        for objective in [BoundObjective::Picks, BoundObjective::Weight] {
            for iterations in [1, 2, 7, 60] {
                let found = bound(&scene, &options(objective, iterations));
                holds(&found, &best);
                if let Some(schedule) = &found.schedule {
                    checker::check(&station, &pattern, schedule).unwrap();
                    let earned = found.earned(&schedule.figures);
                    assert!(earned <= found.value * SUMS);
                    assert_eq!(found.stop == BoundStop::Optimal, earned >= found.value);
                }
                if objective == BoundObjective::Picks && iterations == 60 && best.picks > 0 {
                    contested += usize::from(best.picks < found.reachable);
                    reached += usize::from(found.value == best.picks as f64);
                    tightness.push(best.rate / found.rate.unwrap_or(f64::INFINITY));
                }
            }
            for slot_s in [0.01, 0.3, 5.0] {
                let slot_s = Some(slot_s);
                let options = options(objective, 30).with_slot_s(slot_s);
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
    assert_eq!(reached, tightness.len(), "bounds that are not the optimum");
    assert!(tightness[tightness.len() / 2] > 0.999, "the rate is loose");
    assert!(tightness[tightness.len() / 4] > 0.99, "the rate is loose");
}

/// The same under a camera, failing grasps and noise, where the schedules are those that
/// succeed: what is picked is in its true window, left for while it is in the reported one.
#[test]
fn no_bound_is_below_the_optimum_where_things_go_wrong() {
    let mut runner = TestRunner::deterministic();
    let (mut picked, mut differ) = (0, 0);
    for seed in 0..250 {
        let (station, pattern) = tiny(4).new_tree(&mut runner).unwrap().current();
        let (noisy, failing) = (seed % 3 > 0, seed % 3 != 1 && station.robots().len() < 3);
        let conditions = Conditions::default()
            .with_camera_x([None, Some(-0.3), Some(0.5)][seed as usize / 3 % 3])
            .with_disturbances(
                Disturbances::default()
                    .with_grasp_failures(failing)
                    .with_default_p_grasp(0.7)
                    .with_position_noise(if noisy { 0.1 } else { 0.0 })
                    .with_seed(seed),
            );
        let scene = Scene::under(&station, &pattern, conditions.clone()).unwrap();
        let best = optimum(&scene);
        let plain = optimum(&undisturbed(&scene, conditions.camera_x));
        for objective in [BoundObjective::Picks, BoundObjective::Weight] {
            for slot_s in [None, Some(0.3)] {
                let options = options(objective, 30).with_slot_s(slot_s);
                holds(&bound(&scene, &options), &best);
            }
        }
        picked += usize::from(best.picks > 0);
        differ += usize::from(best.picks != plain.picks || best.end != plain.end);
    }
    assert!(picked > 150 && differ > 80, "{picked} {differ}");
}

/// The same relaxation as a linear program in its other usual form: a variable for every
/// robot, item and slot of departure, every robot in at most one pick at any slot. It does not
/// know that a robot picks no item twice in a row.
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
                let moment = Moment::new(station, robot, 0, start);
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

/// Where picks last longer than windows are open, no robot could pick an item twice, and the bound
/// is that of the linear program. Otherwise it is lower.
#[test]
fn the_bound_is_that_of_the_linear_program() {
    let slot = 0.2;
    // Belts so fast that far from everything can be picked, and windows are short.
    for (name, items, speed) in [("paper", 100, 0.1), ("paper-narrow", 80, 0.15)] {
        let plain = built_in(name).unwrap().station(Some(2)).unwrap();
        for (dwell, once) in [(None, false), (Some(16.0), true)] {
            let robots = plain.robots().iter().cloned().map(|robot| match dwell {
                Some(dwell) => robot.with_dwell(dwell, 0.0),
                None => robot,
            });
            let station = Station::new(*plain.belt(), robots.collect()).unwrap();
            let station = station.with_belt_speed(speed).unwrap();
            let pattern = match once {
                true => {
                    poisson_disk(station.belt().width, 0.25, 40, &mut random_stream(3, 0)).unwrap()
                }
                false => dense(&station, items, 3),
            };
            let scene = Scene::new(&station, &pattern).unwrap();
            let lasts = |c: &Candidate| c.close - c.open;
            let longest = scene.queue(0).iter().map(lasts).fold(0.0, f64::max);
            assert_eq!(longest < dwell.unwrap_or(0.0), once, "{longest}");
            let exact = linear_program(&scene, slot);
            assert!(
                exact < 0.9 * pattern.len() as f64,
                "{name}: {exact}, hardly a contest"
            );
            let options = options(BoundObjective::Picks, 1000)
                .with_slot_s(slot)
                .with_ends(false);
            let found = bound(&scene, &options);
            println!(
                "{name}, dwell {dwell:?}: bound {:.3}, linear program {exact:.3}",
                found.relaxed
            );
            let least = if once { exact } else { 0.95 * exact };
            assert!(
                found.relaxed >= least - 1e-6,
                "{name}: {} < {exact}",
                found.relaxed
            );
            assert!(
                found.relaxed <= 1.001 * exact,
                "{name}: {} > {exact}",
                found.relaxed
            );
        }
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
            let found = bound(&scene, &BoundOptions::quick(BoundObjective::Picks));
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
            let conditions = Conditions::default()
                .with_update_hz(10.0)
                .with_camera_x(camera_x)
                .with_disturbances(
                    Disturbances::default()
                        .with_grasp_failures(failures)
                        .with_default_p_grasp(0.8)
                        .with_position_noise(position_noise)
                        .with_seed(seed),
                );
            let scene = Scene::under(&station, &pattern, conditions.clone()).unwrap();
            let found = bound(&scene, &options(BoundObjective::Picks, 60));
            tree.evaluate(&scene, |_, figures| {
                assert!(figures.picked as f64 <= found.value, "{conditions:?}");
                assert!(figures.picking_rate() <= found.rate.unwrap());
                assert!(found.end <= figures.end);
            })
            .unwrap();
            if position_noise == 0.0 && !failures {
                let plain = Scene::new(&station, &pattern).unwrap();
                let most = bound(&plain, &options(BoundObjective::Picks, 60));
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
    let whole = bound(&scene, &BoundOptions::default());
    let schedule = whole.schedule.as_ref().unwrap();
    checker::check(&station, &pattern, schedule).unwrap();
    // The first row of the table in docs/bound.md.
    assert_eq!((whole.value, schedule.figures.picked), (138.0, 135));
    let rates = (whole.rate.unwrap(), schedule.figures.picking_rate());
    assert!(
        (rates.0 - 68.721).abs() < 0.01 && (rates.1 - 61.364).abs() < 1e-3,
        "{rates:?}"
    );
    assert!(whole.all_end.is_none());
    let mut last = f64::INFINITY;
    for stop_at in [1, 5, 20, 60, 150, 250] {
        let found = upper_bound(&scene, &BoundOptions::default(), &mut |step, _| {
            step < stop_at
        })
        .unwrap();
        assert_eq!(found.stop, BoundStop::Interrupted);
        assert_eq!(found.iterations, stop_at);
        assert!(found.schedule.is_none());
        assert!(found.value <= last && found.value >= whole.value);
        assert!(found.rate.unwrap() >= whole.rate.unwrap());
        assert!(found.end <= whole.end);
        assert!(schedule.figures.picking_rate() <= found.rate.unwrap());
        last = found.value;
    }
}

/// Every step is told, of four times as many where end and rate are bounded too, and something
/// known that reaches the bound ends the search.
#[test]
fn steps_are_counted_and_reported() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = dense(&station, 60, 1);
    let scene = Scene::new(&station, &pattern).unwrap();
    let run = |options: &BoundOptions| {
        let mut told = Vec::new();
        let mut go_on = |step, of| {
            told.push((step, of));
            true
        };
        let found = upper_bound(&scene, options, &mut go_on).unwrap();
        (found, told)
    };
    let plain = options(BoundObjective::Picks, 40);
    for (ends, expected) in [(true, 160), (false, 40)] {
        let (found, told) = run(&plain.clone().with_ends(ends));
        let counted: Vec<_> = (1..=found.iterations)
            .map(|step| (step, expected))
            .collect();
        assert_eq!((told, found.stop), (counted, BoundStop::Done));
        // Three quarters of the further steps towards the rate, an eighth towards each of the
        // ends, with three slot lengths.
        let most = if ends { 40 + 3 * (30 + 5 + 5) } else { 40 };
        assert!(
            (40..=most).contains(&found.iterations),
            "{}",
            found.iterations
        );
        assert_eq!(found.iterations > 40, ends);
        assert!(found.schedule.is_some() && !found.coarse);
        assert!(found.value < 60.0, "{}", found.value);
        assert_eq!(found.prices.len(), 60);
        assert!(found.prices.iter().all(|price| (0.0..=1.0).contains(price)));
        assert!(found.prices.iter().any(|price| *price > 0.1));
    }
    let (whole, _) = run(&plain);
    let known = |known: f64, ends: bool| {
        let quiet = plain
            .clone()
            .with_known(known)
            .with_ends(ends)
            .with_schedule(false);
        let (found, told) = run(&quiet);
        assert!(found.schedule.is_none());
        (found.stop, told.len())
    };
    assert_eq!(known(60.0, false), (BoundStop::Optimal, 0));
    let (stop, steps) = known(whole.value, false);
    assert!(
        stop == BoundStop::Optimal && (1..40).contains(&steps),
        "{steps}"
    );
    assert_eq!(known(whole.value - 1.0, false), (BoundStop::Done, 40));
    let long = plain.clone().with_arcs(6000);
    let (found, _) = run(&long);
    assert!(found.coarse && found.arcs <= 6000 && found.slot_s > whole.slot_s);
    let names = [
        BoundStop::Optimal,
        BoundStop::Done,
        BoundStop::Interrupted,
        BoundStop::TooManyItems,
    ]
    .map(BoundStop::name);
    assert_eq!(names, ["optimal", "done", "interrupted", "too_many_items"]);
}

#[test]
fn known_answers() {
    let items = |weights: &[f64]| {
        let items = weights.iter().enumerate().map(|(i, &weight)| Item {
            weight: Some(weight),
            ..Item::at(i.to_string(), -0.01 * i as f64, -0.4)
        });
        Pattern::new(items.collect()).unwrap()
    };
    // So long a dwell that each robot gets one item, the heaviest two of all.
    let station = crate::bound_limits::line(&[60.0, 60.0]);
    let pattern = items(&[1.0, 5.0, 0.0, 3.0, 1e-3]);
    let scene = Scene::new(&station, &pattern).unwrap();
    let picks = bound(&scene, &options(BoundObjective::Picks, 100));
    assert_eq!((picks.value, picks.stop), (2.0, BoundStop::Optimal));
    assert_eq!((picks.reachable, picks.all_end), (5, None));
    let weight = bound(&scene, &options(BoundObjective::Weight, 100));
    assert!((8.0..8.05).contains(&weight.value), "{}", weight.value);
    // Nothing within reach, nothing worth anything.
    let far = Pattern::new(vec![Item::at("far", 0.0, 0.4)]).unwrap();
    for (pattern, reachable) in [(&far, 0), (&items(&[0.0, 0.0]), 2)] {
        let scene = Scene::new(&station, pattern).unwrap();
        let found = bound(&scene, &options(BoundObjective::Weight, 100));
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
fn invalid_slots_are_refused_and_huge_patterns_are_not() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = grid(1.05, 0.15, 60_000).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    for (slot, word) in [
        (0.0, "not a valid slot length"),
        (-1.0, "not a valid slot length"),
        (f64::NAN, "not a valid slot length"),
        (1e-6, "too short"),
    ] {
        let options = BoundOptions::default().with_slot_s(slot);
        let error = upper_bound(&scene, &options, &mut |_, _| true).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let found = bound(&scene, &BoundOptions::quick(BoundObjective::Picks));
    assert_eq!(found.stop, BoundStop::TooManyItems);
    assert_eq!(
        (found.value, found.relaxed, found.reachable),
        (60_000.0, 60_000.0, 60_000)
    );
    assert_eq!(
        (found.rate, found.end, found.all_end),
        (None, 0.0, Some(0.0))
    );
    assert!(found.coarse && found.schedule.is_none() && found.prices == vec![1.0; 60_000]);
}
