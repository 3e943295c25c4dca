//! Robots that are down, case by case.

use pickline::checker;
use pickline::decision::{Downtime, MissReason, Outcome, Strategy};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern, grid};
use pickline::planning::bound::{BoundObjective, BoundOptions, upper_bound};
use pickline::sim::{
    AssignmentTree, Cascade, Conditions, Disturbances, Outage, RandomOutages, Scene, simulate,
    simulate_rules,
};
use pickline::station::{Station, built_in};
use pickline::strategies::read_alone;

fn paper(robots: usize) -> Station {
    built_in("paper").unwrap().station(Some(robots)).unwrap()
}

fn down(outages: &[&str]) -> Conditions {
    let outages = outages.iter().map(|text| text.parse::<Outage>().unwrap());
    outages.fold(Conditions::default(), Conditions::with_outage)
}

fn random(mtbf: f64, mttr: f64, seed: u64) -> Conditions {
    let outages = RandomOutages::new(mtbf, mttr);
    let conditions = Conditions::default().with_outages(outages);
    conditions.with_seed(seed)
}

fn run(station: &Station, pattern: &Pattern, conditions: Conditions, rules: &str) -> Outcome {
    let scene = Scene::under(station, pattern, conditions).unwrap();
    let outcome = simulate_rules(&scene, &rules.parse().unwrap()).unwrap();
    checker::check(station, pattern, &outcome).unwrap();
    outcome
}

/// When each decision of a robot was made.
fn decisions(outcome: &Outcome, robot: usize) -> Vec<f64> {
    let own = outcome.picks.iter().filter(|pick| pick.robot == robot);
    own.map(|pick| pick.decide).collect()
}

#[test]
fn outages_without_effect_change_nothing() {
    let station = paper(3);
    let pattern = grid(1.05, 0.15, 100).unwrap();
    let plain = Scene::new(&station, &pattern).unwrap();
    let plain_run = simulate_rules(&plain, &"SPT,SD,FIFO".parse().unwrap()).unwrap();
    let end = plain_run.figures.end;
    let after = format!("r2:{end}..");
    for conditions in [down(&[&after]), random(1e9, 0.1, 5)] {
        let outcome = run(&station, &pattern, conditions, "SPT,SD,FIFO");
        assert_eq!(outcome, plain_run);
    }
}

/// A decision at which an outage begins is postponed, and its end is the first at which one is made.
#[test]
fn an_outage_includes_its_beginning_and_excludes_its_end() {
    let station = paper(1);
    let pattern = grid(1.05, 0.15, 40).unwrap();
    let plain = run(&station, &pattern, Conditions::default(), "FIFO");
    let made = decisions(&plain, 0);
    let (before, at) = (made[9], made[10]);
    // From the moment of the decision on, and until just after it.
    for (from, to) in [(at, at + 0.05), (before + 1e-6, at + 1e-6)] {
        let outcome = run(
            &station,
            &pattern,
            down(&[&format!("r1:{from}..{to}")]),
            "FIFO",
        );
        let found = decisions(&outcome, 0);
        assert_eq!(found[..10], made[..10]);
        assert_eq!(found[10], to);
        let downtimes = [Downtime { robot: 0, from, to }];
        assert_eq!(outcome.downtimes, downtimes);
        assert_eq!(outcome.time_down(0), to - from);
    }
    // Until the moment of the decision, while the pick before it is under way.
    let outage = format!("r1:{}..{at}", before + 1e-6);
    let outcome = run(&station, &pattern, down(&[&outage]), "FIFO");
    assert_eq!(outcome.picks, plain.picks);
}

#[test]
fn a_pick_under_way_is_finished() {
    let station = paper(1);
    let pattern = grid(1.05, 0.15, 40).unwrap();
    let plain = run(&station, &pattern, Conditions::default(), "FIFO");
    let pick = plain.picks[5];
    let conditions = down(&[&format!("1:{}..", pick.decide + 1e-6)]);
    let outcome = run(&station, &pattern, conditions, "FIFO");
    assert_eq!(outcome.picks, plain.picks[..6]);
    let last = Downtime {
        robot: 0,
        from: pick.decide + 1e-6,
        to: outcome.figures.end,
    };
    assert_eq!(outcome.downtimes, [last]);
}

#[test]
fn outages_that_overlap_or_touch_are_one() {
    let station = paper(2);
    let pattern = grid(1.05, 0.15, 60).unwrap();
    let parts = [
        "r1:3..5",
        "r2:1..2",
        "r1:5..6",
        "r1:4..4.5",
        "r1:2..3.5",
        "1:8..9",
    ];
    let one = ["r2:1..2", "r1:2..6", "r1:8..9"];
    let outcomes =
        [&parts[..], &one].map(|outages| run(&station, &pattern, down(outages), "SPT,FIFO"));
    assert_eq!(outcomes[0], outcomes[1]);
    let found = outcomes[0]
        .downtimes
        .iter()
        .map(|d| (d.robot, d.from, d.to));
    let expected = [(1, 1.0, 2.0), (0, 2.0, 6.0), (0, 8.0, 9.0)];
    assert_eq!(found.collect::<Vec<_>>(), expected);
    assert_eq!(
        (outcomes[0].time_down(0), outcomes[0].time_down(1)),
        (5.0, 1.0)
    );
}

#[test]
fn a_decision_after_an_outage_is_made_at_an_update() {
    let station = paper(2);
    let pattern = grid(1.05, 0.15, 60).unwrap();
    let updates = |conditions: Conditions| {
        let conditions = conditions.with_update_hz(10.0);
        let outcome = run(&station, &pattern, conditions, "SPT,FIFO");
        let found = decisions(&outcome, 0);
        let is_update = |t: &f64| (t * 10.0 - (t * 10.0).round()).abs() < 1e-6;
        assert!(found.iter().all(is_update), "{found:?}");
        found
    };
    let plain = updates(Conditions::default());
    let at = plain[4];
    // The first outage ends between two updates, and at the next one the robot is down again.
    let outages = [(at - 0.04, at + 1.01), (at + 1.05, at + 1.15)];
    let outages = outages.map(|(from, to)| format!("r1:{from}..{to}"));
    let found = updates(down(&outages.each_ref().map(String::as_str)));
    assert_eq!(found[..4], plain[..4]);
    assert!((found[4] - at - 1.2).abs() < 1e-9, "{found:?}");
}

/// Where workspaces do not overlap, the line does what it would without the robot.
#[test]
fn a_robot_that_is_down_for_the_whole_run_is_not_there() {
    for (name, spacing) in [
        ("paper", 0.15),
        ("paper", 0.1),
        ("sorting", 0.12),
        ("delta", 0.08),
    ] {
        let station = built_in(name).unwrap().station(Some(3)).unwrap();
        let station = match name {
            "paper" => station,
            // Far enough apart.
            _ => station.with_spacing(3.0).unwrap(),
        };
        let pattern = grid(0.9 * station.belt().width, spacing, 150).unwrap();
        let classes = station.class_names().iter().map(|name| Some(name.clone()));
        let classes: Vec<Option<String>> = classes.chain([None]).collect();
        let items = pattern.items().iter().zip(classes.iter().cycle());
        let items = items.map(|(item, class)| Item {
            class: class.clone(),
            ..item.clone()
        });
        let pattern = Pattern::new(items.collect()).unwrap();
        let rules = ["SPT", "SD", "FIFO"];
        for robot in 0..3 {
            let mut others = station.robots().to_vec();
            let halted = others.remove(robot);
            let without = Station::new(*station.belt(), others).unwrap();
            let without = without.with_classes(station.classes().to_vec()).unwrap();
            assert!(Scene::new(&station, &pattern).unwrap().is_independent());
            let mut fewer = rules.to_vec();
            fewer.remove(robot);
            let expected = run(&without, &pattern, Conditions::default(), &fewer.join(","));
            let conditions = down(&[&format!("{}:0..", halted.name)]);
            let scene = Scene::under(&station, &pattern, conditions.clone()).unwrap();
            let outcome = run(&station, &pattern, conditions, &rules.join(","));
            let mut picks = outcome.picks.clone();
            for pick in &mut picks {
                assert_ne!(pick.robot, robot);
                pick.robot -= usize::from(pick.robot > robot);
            }
            assert!(!picks.is_empty());
            assert_eq!(picks, expected.picks, "{name}, robot {robot}");
            assert_eq!(outcome.figures, expected.figures);
            assert_eq!(outcome.time_down(robot), outcome.figures.end);
            let mut cascade = Cascade::new(&scene).unwrap();
            let rules: RuleAssignment = rules.join(",").parse().unwrap();
            assert_eq!(cascade.run(rules.rules()), expected.figures);
        }
    }
}

/// Both engines, for all assignments.
#[test]
fn the_tree_evaluates_lines_with_outages() {
    let station = paper(2);
    let pattern = grid(1.05, 0.15, 100).unwrap();
    let tree = AssignmentTree::all(2);
    for conditions in [down(&["r1:5..30", "r2:20..25"]), random(20.0, 5.0, 3)] {
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        assert!(scene.is_independent());
        tree.evaluate(&scene, |place, figures| {
            let rules = &tree.assignments()[place];
            assert_eq!(figures, simulate_rules(&scene, rules).unwrap().figures);
        })
        .unwrap();
    }
}

#[test]
fn items_that_pass_a_robot_that_is_down_are_missed_for_it() {
    let station = paper(1);
    let item = |id: &str, x0: f64| Item::at(id, x0, 0.0);
    let pattern = Pattern::new(vec![item("a", 0.0), item("b", -20.0)]).unwrap();
    let outcome = run(&station, &pattern, down(&["r1:0..100"]), "FIFO");
    let reasons: Vec<_> = outcome.missed.iter().map(|m| (m.item, m.reason)).collect();
    assert_eq!(reasons, [(0, MissReason::RobotDown)]);
    assert_eq!(outcome.picks.len(), 1);
}

/// The share of time down of an alternating renewal process with exponential times that begins up
/// is m (1 - (1 - exp(-r t)) / (r t)) up to t, with r = 1 / MTBF + 1 / MTTR and m = MTTR / (MTBF +
/// MTTR), for example Trivedi 2001, Probability and Statistics, section 8.2 (availability).
#[test]
fn the_mean_share_of_time_down_is_that_of_the_process() {
    let station = paper(2);
    let pattern = grid(1.05, 0.3, 400).unwrap();
    for (mtbf, mttr) in [(60.0, 20.0), (5.0, 5.0), (300.0, 20.0)] {
        let shares: Vec<f64> = (0..100)
            .flat_map(|seed| {
                let scene = Scene::under(&station, &pattern, random(mtbf, mttr, seed)).unwrap();
                let outcome = simulate(&scene, &mut Nothing).unwrap();
                [0, 1].map(|robot| outcome.time_down(robot) / outcome.figures.end)
            })
            .collect();
        let count = shares.len() as f64;
        let mean = shares.iter().sum::<f64>() / count;
        let squares: f64 = shares.iter().map(|share| (share - mean).powi(2)).sum();
        let error = (squares / (count - 1.0) / count).sqrt();
        let scene = Scene::new(&station, &pattern).unwrap();
        let end = simulate(&scene, &mut Nothing).unwrap().figures.end;
        let rate = 1.0 / mtbf + 1.0 / mttr;
        let begun = (1.0 - (-rate * end).exp()) / (rate * end);
        let expected = RandomOutages::new(mtbf, mttr).share_down() * (1.0 - begun);
        assert!(
            (mean - expected).abs() < 3.0 * error,
            "{mean} for {expected}, error {error}"
        );
        // Tight enough to notice a wrong mean.
        assert!(error < 0.1 * expected, "{error}");
    }
}

/// Picks nothing, so that all runs end when the last item leaves the belt.
struct Nothing;

impl Strategy for Nothing {
    fn decide(&mut self, _: &pickline::decision::Snapshot) -> pickline::decision::Action {
        pickline::decision::Action::WaitForNextWindow
    }

    fn name(&self) -> String {
        "nothing".into()
    }
}

#[test]
fn random_outages_depend_on_seed_and_robot_only() {
    let station = paper(3);
    let pattern = grid(1.05, 0.15, 150).unwrap();
    let failing = Disturbances::default()
        .with_grasp_failures(true)
        .with_default_p_grasp(0.7);
    let of = |conditions: Conditions, rules: &str, robot: usize| {
        let outcome = run(&station, &pattern, conditions, rules);
        let own = outcome.downtimes.iter().filter(|down| down.robot == robot);
        // Where two runs end at different times, the earlier end cuts the last outage.
        let times: Vec<(f64, f64)> = own.map(|down| (down.from, down.to)).collect();
        times[..times.len() - 1].to_vec()
    };
    let conditions = random(8.0, 2.0, 7);
    let first = of(conditions.clone(), "SPT,FIFO,FIFO", 0);
    assert!(first.len() > 3, "{first:?}");
    let same = |other: &[(f64, f64)]| {
        let count = first.len().min(other.len());
        first[..count] == other[..count]
    };
    assert!(same(&of(conditions.clone(), "LPT,LD,SD", 0)));
    assert!(same(&of(
        conditions.clone().with_disturbances(failing.with_seed(7)),
        "SPT,SPT,SPT",
        0
    )));
    assert!(!same(&of(conditions.clone(), "SPT,FIFO,FIFO", 1)));
    assert!(!same(&of(conditions.with_seed(8), "SPT,FIFO,FIFO", 0)));
}

/// Look-ahead and the built-in policy plan without a robot that is down, and nobody decides then.
#[test]
fn strategies_give_legal_answers_while_robots_are_down() {
    let mut names = vec!["lookahead:budget=20,bases=SPT+FIFO"];
    if cfg!(feature = "onnx") {
        names.push(pickline::strategies::POLICY);
    }
    let stations = [
        paper(2),
        built_in("paper-narrow").unwrap().station(Some(2)).unwrap(),
    ];
    for station in &stations {
        let pattern = grid(station.belt().width, 0.15, 40).unwrap();
        for conditions in [
            down(&["r2:0.."]),
            down(&["r1:5..15", "r2:5..15"]),
            random(10.0, 5.0, 2),
            down(&["r1:0..", "r2:0.."]),
        ] {
            let scene = Scene::under(station, &pattern, conditions.clone()).unwrap();
            for name in &names {
                let blueprint = read_alone(name, 2).unwrap();
                let outcome = simulate(&scene, blueprint.make().as_mut()).unwrap();
                checker::check(station, &pattern, &outcome).unwrap();
            }
        }
    }
}

/// With outages the bound is that of the line without them, and no strategy is above it.
#[test]
fn the_bound_ignores_outages() {
    let station = paper(2);
    let pattern = grid(1.05, 0.15, 40).unwrap();
    let options = BoundOptions::in_full(BoundObjective::Picks, pattern.len());
    let bound = |conditions: Conditions| {
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        upper_bound(&scene, &options, &mut |_, _| true).unwrap()
    };
    let plain = bound(Conditions::default());
    for conditions in [down(&["r1:0.."]), random(10.0, 5.0, 2)] {
        let outcome = run(&station, &pattern, conditions.clone(), "SPT,FIFO");
        let found = bound(conditions);
        assert_eq!(found.value, plain.value);
        assert!(outcome.figures.picked as f64 <= found.value);
    }
}

#[test]
fn outages_that_a_line_cannot_have_are_refused() {
    let (station, pattern) = (paper(2), grid(1.05, 0.15, 40).unwrap());
    let refused = |conditions: Conditions| {
        let refused = Scene::under(&station, &pattern, conditions);
        refused.err().unwrap().to_string()
    };
    let message = refused(down(&["r3:1..2"]));
    for words in [
        "'outage' r3:1..2",
        "the line has no robot `r3`",
        "known: r1, r2",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
    let message = refused(Conditions::default().with_outage(Outage::new("r1", 2.0, 1.0)));
    assert!(message.contains("it ends at 1 s"), "{message}");
    // A run of ten million seconds.
    let slow = station.with_belt_speed(1e-6).unwrap();
    let often = Scene::under(&slow, &pattern, random(0.5, 0.1, 1));
    let message = often.err().unwrap().to_string();
    for words in ["'outages'", "more than 1000000 outages", "in seconds"] {
        assert!(message.contains(words), "{words} not in {message}");
    }
}
