//! Every method meets the same patterns, and where something goes wrong the same luck: run
//! by run, each result is that of the method alone on the pattern and under the seed that are
//! said to be its own.

use super::support::{Raw, assert_near, environment, mean, mean_of};
use pickline::error::Result;
use pickline::experiment::{
    Case, CaseSource, Comparison, Draws, Method, Setting, Sweep, SweptMethod, add_bounds,
    compare_methods, find_limits, sweep_settings,
};
use pickline::optimize::{Environment, Evaluator, Objective, Progress, Risk, rivals};
use pickline::pattern::{Pattern, grid, poisson_disk, random_stream};
use pickline::sim::{Conditions, Disturbances, Scene, simulate};
use pickline::station::{Station, built_in};
use pickline::strategies::read_alone;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

const RULES: [&str; 3] = ["SPT,FIFO", "FIFO,SPT", "LD,LPT"];

fn station() -> Station {
    built_in("paper").unwrap().station(None).unwrap()
}

/// Grasps fail, and positions are off.
fn unlucky(seed: u64) -> Conditions {
    Conditions::default().with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.75)
            .with_position_noise(0.01)
            .with_seed(seed),
    )
}

fn methods() -> Vec<Method> {
    let rules = |text: &str| Method::Strategy(read_alone(text, 2).unwrap());
    vec![
        Method::Robust(RULES[0].parse().unwrap()),
        rules(RULES[1]),
        rules(RULES[2]),
    ]
}

/// One run of a method by itself.
fn alone(station: &Station, pattern: &Pattern, rules: &str, conditions: Conditions) -> Raw {
    let scene = Scene::under(station, pattern, conditions).unwrap();
    let strategy = read_alone(rules, 2).unwrap();
    let outcome = simulate(&scene, strategy.make().as_mut()).unwrap();
    Raw::counted(&scene, &outcome)
}

fn case(name: &str, source: CaseSource) -> Case {
    Case {
        name: name.into(),
        source,
        items: 30,
        attributes: Default::default(),
    }
}

fn compared(conditions: &Conditions, environment: &Environment) -> Comparison {
    let cases = [
        case("grid", CaseSource::Grid(0.2)),
        case("disks", CaseSource::Poisson(0.2)),
    ];
    let draws = Draws {
        replicates: 4,
        first_seed: 20,
        conditions,
    };
    compare_methods(&station(), methods(), &cases, draws, environment).unwrap()
}

#[test]
fn methods_of_a_comparison_have_the_same_patterns_and_random_events() {
    let station = station();
    let width = station.belt().width;
    for plain in [true, false] {
        // Another master seed than that of the patterns.
        let conditions = if plain {
            Conditions::default()
        } else {
            unlucky(1)
        };
        let comparison = compared(&conditions, &environment());
        for (case, seeds) in comparison.cases.iter().zip([if plain { 1 } else { 4 }, 4]) {
            assert_eq!(case.seeds.len(), seeds, "{}", case.case.name);
            for (place, seed) in case.seeds.iter().enumerate() {
                let number = 20 + place as u64;
                let pattern = match &case.case.source {
                    CaseSource::Grid(spacing) => grid(width, *spacing, 30).unwrap(),
                    _ => poisson_disk(width, 0.2, 30, &mut random_stream(number, 0)).unwrap(),
                };
                let random = !plain || case.case.name == "disks";
                assert_eq!(*seed, random.then_some(number));
                for (method, rules) in case.methods.iter().zip(RULES) {
                    let expected = alone(&station, &pattern, rules, conditions.with_seed(number));
                    let found = &method.runs[place].figures;
                    let what = format!("{}, {rules}, seed {number}", case.case.name);
                    assert_eq!(
                        (found.picked, found.items),
                        (expected.picked, expected.items),
                        "{what}"
                    );
                    assert_near(Some(found.end), Some(expected.end), &what);
                }
            }
        }
    }
}

fn settings(speeds: &[f64]) -> Vec<Setting> {
    let at = |&value: &f64| Setting {
        value,
        station: station().with_belt_speed(value).unwrap(),
        min_detection: None,
        methods: methods(),
    };
    speeds.iter().map(at).collect()
}

fn setting(value: f64) -> Result<Setting> {
    Ok(settings(&[value]).remove(0))
}

/// Three times the same grid, so that only the luck of the place differs.
fn grids(spacing: f64, count: usize) -> Vec<Pattern> {
    let pattern = grid(station().belt().width, spacing, 30).unwrap();
    vec![pattern; count]
}

#[test]
fn values_of_a_sweep_have_the_same_patterns_and_random_events() {
    let patterns = grids(0.3, 3);
    let conditions = unlucky(40);
    let settings = settings(&[0.03, 0.05, 0.06]);
    let swept = sweep_settings(&settings, &patterns, &conditions, true, &environment()).unwrap();
    for (setting, at) in settings.iter().zip(&swept.values) {
        for (point, rules) in at.methods.iter().zip(RULES) {
            let run = |(place, pattern): (usize, &Pattern)| {
                let conditions = conditions.with_seed(40 + place as u64);
                alone(&setting.station, pattern, rules, conditions)
            };
            let runs: Vec<Raw> = patterns.iter().enumerate().map(run).collect();
            let what = format!("{} at {}", rules, setting.value);
            assert_near(
                Some(point.picked_share),
                Some(mean_of(&runs, Raw::share)),
                &what,
            );
            assert_near(
                Some(point.picking_rate),
                Some(mean_of(&runs, Raw::rate)),
                &what,
            );
            let ends: Vec<f64> = runs.iter().map(|run| run.end).collect();
            assert!(ends[0] != ends[1] && ends[1] != ends[2], "{what}: {ends:?}");
        }
    }
}

/// The limits of a scan are those of a sweep over the same values.
#[test]
fn limits_are_those_of_a_sweep_with_the_same_random_events() {
    let patterns = grids(0.35, 2);
    let mut conditions = unlucky(40);
    conditions.disturbances.position_noise = 0.0;
    for conditions in [Conditions::default(), conditions] {
        let scan = (0.004, 0.16);
        let found = find_limits(setting, scan, &patterns, &conditions, &environment()).unwrap();
        let values: Vec<f64> = (1..=40)
            .map(|k| (f64::from(k) * 4.0).round() / 1000.0)
            .collect();
        let lines = settings(&values);
        let swept = sweep_settings(&lines, &patterns, &conditions, false, &environment()).unwrap();
        let methods: Vec<SweptMethod> = swept.methods().collect();
        for (method, limit) in found.iter().enumerate() {
            let expected = methods[method].complete();
            assert_eq!(limit.highest, expected.highest, "{}", RULES[method]);
            assert_eq!(limit.first_miss, expected.first_miss, "{}", RULES[method]);
        }
        let highest: Vec<Option<f64>> = found.iter().map(|limit| limit.highest).collect();
        assert!(highest.iter().any(Option::is_some), "{highest:?}");
        assert!(
            found.iter().all(|limit| limit.first_miss.is_some()),
            "{found:?}"
        );
    }
    // A scan that ends before anything is missed.
    let plain = Conditions::default();
    let found = find_limits(setting, (0.004, 0.012), &patterns, &plain, &environment()).unwrap();
    for limit in found {
        assert_eq!((limit.highest, limit.first_miss), (Some(0.012), None));
    }
}

/// Assignments and strategies of a search are evaluated on the same patterns, pattern i with
/// the luck of the seed + i.
#[test]
fn a_search_gives_every_assignment_the_same_patterns_and_random_events() {
    let station = station();
    let patterns = grids(0.2, 4);
    let conditions = unlucky(60);
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &conditions);
    let evaluator = evaluator.unwrap();
    let rates = |rules: &str| -> Vec<f64> {
        let run = |(place, pattern): (usize, &Pattern)| {
            alone(
                &station,
                pattern,
                rules,
                conditions.with_seed(60 + place as u64),
            )
            .rate()
        };
        patterns.iter().enumerate().map(run).collect()
    };
    let list = RULES.map(|rules| rules.parse().unwrap()).to_vec();
    let evaluation = evaluator.evaluate(list, &environment()).unwrap();
    assert_eq!(evaluation.patterns, [0, 1, 2, 3]);
    for (assignment, score) in evaluation.assignments.iter().zip(&evaluation.scores) {
        let rules = assignment.names().join(",");
        let expected = rates(&rules);
        for (found, expected) in score.values.iter().zip(&expected) {
            assert_near(Some(*found), Some(*expected), &rules);
        }
    }
    // And those beside the winner: each minus the winner.
    let winner = RULES[0].parse().unwrap();
    let others = RULES[1..].iter().map(|rules| read_alone(rules, 2).unwrap());
    let others: Vec<_> = others.collect();
    let found = rivals(&evaluator, &winner, &others, Risk::Mean, &environment());
    let first = rates(RULES[0]);
    for (rival, rules) in found.unwrap().unwrap().iter().zip(RULES) {
        let own = rates(rules);
        assert_near(Some(rival.mean), Some(mean(&own)), rules);
        let difference = super::support::paired(&own, &first).unwrap();
        let interval = rival.difference.unwrap();
        assert_near(Some(interval.low), Some(difference[0]), rules);
        assert_near(Some(interval.high), Some(difference[1]), rules);
    }
}

/// A bound belongs to the pattern and the luck of its runs.
#[test]
fn bounds_are_of_the_patterns_of_the_runs() {
    let station = station();
    let plain = Conditions::default();
    let mut comparison = compared(&plain, &environment());
    let draws = Draws {
        replicates: 4,
        first_seed: 20,
        conditions: &plain,
    };
    add_bounds(&mut comparison, &station, draws, &environment()).unwrap();
    for case in &comparison.cases {
        let bound = case.bound.as_ref().unwrap();
        assert_eq!(bound.picks.len(), case.seeds.len());
        for (place, most) in bound.picks.iter().enumerate() {
            let picked = case
                .methods
                .iter()
                .map(|method| method.runs[place].figures.picked);
            assert!(
                picked.max().unwrap() <= *most && *most <= 30,
                "{}",
                case.case.name
            );
        }
        let items = 30 * case.seeds.len();
        let most: usize = bound.picks.iter().sum();
        assert_eq!(bound.picked_share, most as f64 / items as f64);
        assert!(bound.difference.is_some() == (case.seeds.len() > 1));
    }
}

/// Stops after so many steps of progress.
struct After {
    steps: u64,
    stop: AtomicBool,
    done: AtomicU64,
    begun: std::sync::Mutex<Vec<(String, u64, String)>>,
}

impl After {
    fn new(steps: u64) -> Self {
        Self {
            steps,
            stop: AtomicBool::new(steps == 0),
            done: AtomicU64::new(0),
            begun: std::sync::Mutex::default(),
        }
    }

    fn environment(&self) -> Environment<'_> {
        Environment {
            stop: &self.stop,
            progress: self,
            ..Environment::QUIET
        }
    }

    fn begun(&self) -> Vec<(String, u64, String)> {
        self.begun.lock().unwrap().clone()
    }
}

impl Progress for After {
    fn begin(&self, stage: &str, total: u64, unit: &str) {
        self.begun
            .lock()
            .unwrap()
            .push((stage.into(), total, unit.into()));
    }
    fn advance(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::SeqCst) + steps;
        if done >= self.steps {
            self.stop.store(true, Ordering::SeqCst);
        }
    }
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

#[test]
fn a_stopped_comparison_ends_with_the_last_whole_case() {
    let cases = [
        case("grid", CaseSource::Grid(0.2)),
        case("disks", CaseSource::Poisson(0.2)),
    ];
    let plain = Conditions::default();
    let run = |after: &After| {
        let draws = Draws {
            replicates: 4,
            first_seed: 20,
            conditions: &plain,
        };
        compare_methods(&station(), methods(), &cases, draws, &after.environment())
    };
    assert!(run(&After::new(0)).is_err_and(|error| error.is_interrupted()));
    // The grid is one pattern; the disks are four.
    for (steps, whole) in [(1, 1), (5, 2), (100, 2)] {
        let after = After::new(steps);
        let comparison = run(&after).unwrap();
        assert_eq!(
            (comparison.cases.len(), comparison.planned),
            (whole, 2),
            "{steps}"
        );
        assert_eq!(comparison.first_seed, 20);
        assert_eq!(after.begun(), [("comparing".into(), 5, "patterns".into())]);
        if steps == 100 {
            assert_eq!(after.done.load(Ordering::SeqCst), 5);
        }
    }
    // Bounds end with the last whole case as well.
    for (steps, bounded) in [
        (0, [false; 2]),
        (1, [true, false]),
        (2, [true, false]),
        (100, [true; 2]),
    ] {
        let mut comparison = compared(&plain, &environment());
        let after = After::new(steps);
        let draws = Draws {
            replicates: 4,
            first_seed: 20,
            conditions: &plain,
        };
        add_bounds(&mut comparison, &station(), draws, &after.environment()).unwrap();
        let found: Vec<bool> = comparison
            .cases
            .iter()
            .map(|case| case.bound.is_some())
            .collect();
        assert_eq!(found, bounded, "{steps}");
        assert_eq!(after.begun(), [("bounding".into(), 5, "patterns".into())]);
    }
}

#[test]
fn a_stopped_sweep_ends_with_the_last_whole_value() {
    let (patterns, plain) = (grids(0.3, 2), Conditions::default());
    let settings = settings(&[0.03, 0.05, 0.06]);
    let run = |after: &After| -> Result<Sweep> {
        sweep_settings(&settings, &patterns, &plain, true, &after.environment())
    };
    assert!(run(&After::new(0)).is_err_and(|error| error.is_interrupted()));
    for (steps, values) in [
        (1, &[0.03][..]),
        (2, &[0.03, 0.05]),
        (9, &[0.03, 0.05, 0.06]),
    ] {
        let after = After::new(steps);
        let swept = run(&after).unwrap();
        let speeds: Vec<f64> = swept.values.iter().map(|at| at.value).collect();
        assert_eq!((speeds.as_slice(), swept.planned), (values, 3), "{steps}");
        for at in &swept.values {
            assert_eq!(at.methods.len(), RULES.len());
            assert!(at.bound.is_some());
        }
        assert_eq!(after.begun(), [("sweeping".into(), 3, "values".into())]);
    }
    let after = After::new(2);
    let stopped = find_limits(
        setting,
        (0.01, 0.05),
        &patterns,
        &plain,
        &after.environment(),
    );
    assert!(stopped.is_err_and(|error| error.is_interrupted()));
    assert_eq!(
        after.begun(),
        [("finding limits".into(), 5, "values".into())]
    );
}
