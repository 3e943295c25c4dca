//! What the look-ahead strategy promises.

use crate::common;
use common::pickline;
use nalgebra::Point2;
use pickline::checker;
use pickline::decision::{Action, Outcome, Snapshot, Strategy};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Pattern, grid};
use pickline::planning::{Allowance, Lookahead, LookaheadOptions};
use pickline::sim::{Conditions, Disturbances, Scene, simulate, simulate_rules};
use pickline::station::{Belt, Robot, Station, built_in};
use proptest::prelude::*;
use proptest::strategy::Strategy as _;
use std::collections::BTreeSet;

fn options(text: &str, bases: &[RuleAssignment], robots: usize) -> LookaheadOptions {
    let mut options = LookaheadOptions::parse(text, robots, Allowance::default()).unwrap();
    if !bases.is_empty() {
        options.bases = bases.to_vec();
    }
    options
}

fn run(scene: &Scene, options: LookaheadOptions) -> Outcome {
    let outcome = simulate(scene, &mut Lookahead::new(options)).unwrap();
    checker::check(scene.station(), scene.pattern(), &outcome).unwrap();
    outcome
}

/// A line, a pattern and two assignments for it.
fn cases() -> impl proptest::strategy::Strategy<Value = (Station, Pattern, Vec<RuleAssignment>)> {
    let case = prop_oneof![
        common::cases(common::lines(), 30),
        common::cases(common::stations(), 30),
    ];
    case.prop_map(|(station, pattern, rules)| {
        let mut turned = rules.rules().to_vec();
        turned.reverse();
        (station, pattern, vec![rules, RuleAssignment::new(turned)])
    })
}

fn without_weightless_items(pattern: &Pattern) -> Pattern {
    let mut items = pattern.items().to_vec();
    for item in &mut items {
        item.weight = item.weight.map(|weight| weight.max(0.01));
    }
    Pattern::new(items).unwrap()
}

fn everything_in_view<'a>(station: &'a Station, pattern: &'a Pattern) -> Scene<'a> {
    let conditions = Conditions::default().with_camera_x(-1e6);
    Scene::under(station, pattern, conditions).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// With all items in view from the start the old plan can always be kept, so what
    /// the best base would pick is a floor, whatever the budget and the search. Where the
    /// weight counts, plans leave out items that weigh nothing, so there each weighs something.
    #[test]
    fn it_never_does_worse_than_its_best_base(
        (station, pattern, bases) in cases(),
        text in prop_oneof![
            Just("budget=1"),
            Just("budget=300"),
            Just("budget=2000,depth=1,improve=no"),
            Just("budget=100000,depth=2,width=2,improve=no"),
            Just("goal=weight,budget=200"),
        ],
    ) {
        let robots = station.robots().len();
        let pattern = match text.contains("weight") {
            true => without_weightless_items(&pattern),
            false => pattern,
        };
        let scene = everything_in_view(&station, &pattern);
        let ahead = run(&scene, options(text, &bases, robots)).figures;
        for base in &bases {
            let figures = simulate_rules(&scene, base).unwrap().figures;
            if text.contains("weight") {
                let (own, floor) = (ahead.weight, figures.weight);
                prop_assert!(own >= floor - 1e-9, "{own} of {floor} with {base}");
            } else {
                let (own, floor) = (ahead.picked, figures.picked);
                prop_assert!(own >= floor, "{own} of {floor} with {base}");
            }
        }
    }

    /// Whatever the camera sees and whatever goes wrong, it only does what the model
    /// allows, and the same again.
    #[test]
    fn it_acts_legally_and_repeatably(
        (station, pattern, bases) in cases(),
        camera_x in proptest::option::of(-3.0..3.0f64),
        update_hz in prop_oneof![Just(0.0), Just(10.0), Just(1.7)],
        grasp_failures in any::<bool>(),
        position_noise in prop_oneof![Just(0.0), Just(0.02), Just(0.3)],
        text in prop_oneof![
            Just("budget=100"), Just("budget=100,horizon=2.5"), Just("goal=weight,budget=50")
        ],
    ) {
        let disturbances = Disturbances::default()
            .with_grasp_failures(grasp_failures)
            .with_default_p_grasp(0.6)
            .with_position_noise(position_noise)
            .with_seed(7);
        let conditions = Conditions::default()
            .with_update_hz(update_hz)
            .with_camera_x(camera_x)
            .with_disturbances(disturbances);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let options = options(text, &bases, station.robots().len());
        let outcome = run(&scene, options.clone());
        prop_assert_eq!(outcome, run(&scene, options));
    }
}

fn paper(name: &str) -> Station {
    built_in(name).unwrap().station(Some(2)).unwrap()
}

#[test]
fn on_a_dense_belt_it_picks_far_more_than_the_best_rules() {
    for name in ["paper", "paper-narrow"] {
        let station = paper(name);
        let pattern = grid(station.belt().width, 0.15, 150).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let best = RuleAssignment::all(2)
            .map(|rules| simulate_rules(&scene, &rules).unwrap().figures.picked)
            .max()
            .unwrap();
        let ahead = run(&scene, options("", &["SPT,FIFO".parse().unwrap()], 2));
        assert!(ahead.figures.picked as f64 > 1.1 * best as f64, "{name}");
    }
}

#[test]
fn more_budget_is_used() {
    let station = paper("paper");
    let pattern = grid(station.belt().width, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let picked = |budget: &str| run(&scene, options(budget, &[], 2)).figures.picked;
    assert!(picked("budget=20") < picked("budget=4000"));
}

#[test]
fn items_without_weight_are_skipped_when_weight_counts() {
    let station = paper("paper");
    let text = "id,x,y,weight\n1,0,0,0\n2,-0.2,0,1\n3,-0.4,0,0\n4,-0.6,0,0.5\n";
    let pattern = pickline::pattern::parse(text, "test").unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let outcome = run(&scene, options("goal=weight", &[], 2));
    let mut items: Vec<u32> = outcome.picks.iter().map(|pick| pick.item).collect();
    items.sort_unstable();
    assert_eq!(items, [1, 3]);
}

#[test]
fn a_robot_leaves_an_item_to_another_that_is_better_placed() {
    // Both robots reach item 0, only the first item 1, which comes a second later and has
    // passed once the first robot, slow at its grasps, is done with item 0.
    let robot = |name: &str, x: f64, y: f64, grasp_time: f64| {
        Robot::new(
            name.to_owned(),
            Point2::new(x, y),
            Point2::new(x, y),
            0.7,
            pickline::kinematics::Arm::constant(1.0),
        )
        .with_dwell(grasp_time, 0.0)
    };
    let belt = Belt {
        speed: 0.1,
        length: 4.0,
        width: 1.4,
    };
    let robots = vec![robot("r1", 1.0, -0.5, 20.0), robot("r2", 3.0, 0.5, 0.0)];
    let station = Station::new(belt, robots).unwrap();
    let text = "id,x,y\nfirst,0,0\nsecond,-0.3,-0.6\n";
    let pattern = pickline::pattern::parse(text, "test").unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let who = |outcome: &Outcome| {
        let picks = outcome.picks.iter().map(|pick| (pick.robot, pick.item));
        picks.collect::<BTreeSet<_>>()
    };
    // A rule never waits.
    for rules in RuleAssignment::all(2) {
        let outcome = simulate_rules(&scene, &rules).unwrap();
        assert_eq!(who(&outcome), [(0, 0)].into(), "{rules}");
    }
    let outcome = run(&scene, options("", &[], 2));
    assert_eq!(who(&outcome), [(0, 1), (1, 0)].into());
}

/// The station `paper` with so many robots and grasps that take `grasp_time` [s].
fn slow(robots: usize, grasp_time: f64) -> Station {
    let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
    let robot = |robot: &Robot| Robot {
        grasp_time,
        ..robot.clone()
    };
    let robots = station.robots().iter().map(robot).collect();
    Station::new(*station.belt(), robots).unwrap()
}

/// Who picks what, in order of time: robot and the item's id.
fn picks(station: &Station, pattern: &Pattern, text: &str, base: &str) -> Vec<(usize, String)> {
    let scene = Scene::new(station, pattern).unwrap();
    let robots = station.robots().len();
    let bases = [base.parse().unwrap()];
    let outcome = run(&scene, options(text, &bases, robots));
    let id = |item: u32| pattern.items()[item as usize].id.clone();
    let picks = outcome.picks.iter();
    picks.map(|pick| (pick.robot, id(pick.item))).collect()
}

/// The first robot has time for two of three items, of which only the first is in reach of the
/// second robot: under FIFO it takes that one, and another is lost.
#[test]
fn a_base_is_improved_by_search_and_by_trying_candidates() {
    let station = slow(2, 15.0);
    let text = "id,x,y\nA,0,0\nB,-0.02,-0.5\nC,-0.04,-0.5\n";
    let pattern = pickline::pattern::parse(text, "test").unwrap();
    let of = |text: &str| picks(&station, &pattern, text, "FIFO,FIFO");
    let pair = |robot: usize, item: &str| (robot, item.to_owned());
    let base = [pair(0, "B"), pair(0, "A")];
    let best = [pair(0, "B"), pair(0, "C"), pair(1, "A")];
    // Neither improved nor tried, the base is all there is.
    assert_eq!(of("budget=50,improve=no"), base);
    assert_eq!(of("budget=50"), best);
    assert_eq!(of("budget=50,improve=no,depth=1"), best);
    // A base that does so by itself is enough.
    let spt = picks(&station, &pattern, "budget=50,improve=no", "SPT,FIFO");
    assert_eq!(spt, best);
}

/// A pick that takes the robot for a minute: the light item now, or the heavy one, whose
/// window opens 5 s later, instead.
#[test]
fn it_plans_for_its_goal_within_its_horizon() {
    let station = slow(1, 60.0);
    let text = "id,x,y,weight\nlight,0,-0.5,0.1\nheavy,-0.25,-0.5,1\n";
    let pattern = pickline::pattern::parse(text, "test").unwrap();
    for (text, item) in [
        ("budget=50", "light"),
        ("budget=50,goal=weight", "heavy"),
        ("budget=50,goal=weight,horizon=4.99", "light"),
        ("budget=50,goal=weight,horizon=5.01", "heavy"),
    ] {
        let found = picks(&station, &pattern, text, "FIFO");
        assert_eq!(found, [(0, item.to_owned())], "{text}");
    }
}

/// What the options make of a dense belt. Plans are counted, not timed, so these figures are
/// the same on every machine.
#[test]
fn every_option_has_its_effect() {
    let station = paper("paper");
    let pattern = grid(station.belt().width, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    for (text, picked) in [
        ("budget=300,bases=SPT+FIFO", 133),
        ("budget=300,bases=SPT+FIFO,seed=3", 131),
        ("budget=30,bases=SPT+FIFO", 111),
        ("budget=3000,improve=no,bases=FIFO+FIFO", 73),
        ("budget=3000,improve=no,bases=FIFO+FIFO,depth=1", 114),
        (
            "budget=30000,improve=no,bases=FIFO+FIFO,depth=2,width=4",
            110,
        ),
        ("budget=3000,improve=no,bases=SPT+FIFO", 86),
        ("budget=3000,improve=no,bases=SPT+FIFO/FIFO+SPT", 91),
    ] {
        let found = run(&scene, options(text, &[], 2)).figures.picked;
        assert_eq!(found, picked, "{text}");
    }
}

/// Notes what kinds of action a strategy takes.
struct Kinds {
    inner: Lookahead,
    waits: usize,
}

impl Strategy for Kinds {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let action = self.inner.decide(snapshot);
        self.waits += usize::from(!matches!(action, Action::Pick(_)));
        action
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}

#[test]
fn waiting_is_among_its_choices() {
    let station = paper("paper");
    let pattern = grid(station.belt().width, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let inner = Lookahead::new(options("budget=500", &[], 2));
    let mut kinds = Kinds { inner, waits: 0 };
    simulate(&scene, &mut kinds).unwrap();
    assert!(kinds.waits > 0);
}

#[test]
fn a_time_budget_plans_as_well() {
    let station = paper("paper");
    let pattern = grid(station.belt().width, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let spt = simulate_rules(&scene, &"SPT,FIFO".parse().unwrap()).unwrap();
    let ahead = run(
        &scene,
        options("budget-ms=1", &["SPT,FIFO".parse().unwrap()], 2),
    );
    assert!(ahead.figures.picked > spt.figures.picked);
}

#[test]
fn results_do_not_depend_on_threads() {
    let compare = |threads: &str| {
        common::text(&[
            "compare",
            "--cases",
            "dense",
            "--replicates",
            "2",
            "--no-greedy",
            "--robust",
            "SPT,FIFO",
            "--strategy",
            "lookahead:budget=100",
            "--threads",
            threads,
            "--format",
            "json",
            "-q",
        ])
    };
    assert_eq!(compare("1"), compare("2"));
}

/// On a long line nearly all assignments are tied. Its searches have a budget, and the
/// look-ahead does not search for what does not matter there.
#[test]
fn a_long_line_has_a_budget() {
    let told = |arguments: &[&str]| -> (String, String) {
        let output = pickline(&[arguments, &["--robots", "7", "--no-bound"]].concat());
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{arguments:?}: {told}");
        (told, String::from_utf8(output.stdout).unwrap())
    };
    let small = ["--patterns", "grid:0.3", "--items", "10", "--validate", "0"];
    let (_, table) = told(&[&["optimize"], &small[..]].concat());
    assert!(
        table.contains("runs of at most 5142857 (--max-runs)"),
        "{table}"
    );
    let compare = ["compare", "--no-greedy", "--no-policy", "--replicates", "1"];
    let (_, table) = told(&[&compare[..], &["--train-items", "5"]].concat());
    assert!(table.contains("| robust GT ["), "{table}");
    let (_, table) = told(&["simulate", "--strategy", "lookahead"]);
    assert!(table.contains("strategy  lookahead"), "{table}");
}
