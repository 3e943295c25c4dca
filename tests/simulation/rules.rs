//! The dispatching rules one by one on candidates whose keys are reckoned by hand, and how
//! assignments of them are written.

use crate::FirstRobots;
use nalgebra::Point2;
use pickline::decision::{Candidate, Moment, Strategy};
use pickline::dispatch::{Rule, RuleAssignment, RuleStrategy};
use pickline::error::ErrorKind;
use pickline::pattern::{Item, Pattern};
use pickline::sim::{Run, Scene, Trace, simulate, simulate_observed};
use pickline::station::{Belt, Robot, Station};
use pickline::strategies::read_alone;

/// Base and bin stand apart, so that distance and processing time rank differently.
fn station() -> Station {
    let robot = |name: &str| {
        Robot::new(
            name,
            Point2::new(2.0, -1.0),
            Point2::new(3.0, 0.0),
            2.0,
            pickline::kinematics::Arm::constant(0.75),
        )
        .with_dwell(0.5, 0.25)
    };
    let belt = Belt {
        speed: 0.25,
        length: 5.0,
        width: 1.0,
    };
    Station::new(belt, vec![robot("a"), robot("b")]).unwrap()
}

fn candidate(item: u32, x0: f64, y: f64, weight: f64) -> Candidate {
    Candidate {
        item,
        bin: 0,
        class: pickline::station::ClassId::OTHER,
        x0,
        y,
        weight,
        open: 0.0,
        close: 100.0,
    }
}

/// Eight seconds into the run, so 2 m further down than `x0`.
#[test]
fn every_rule_takes_the_candidate_with_its_smallest_key() {
    let station = station();
    let at = Moment::new(&station, 0, 0, 8.0);
    let candidates = [
        candidate(0, 1.5, 0.0, 0.4), // 0.5 m past the bin: 1 s away, 1.5^2 + 1 off base
        candidate(1, 0.0, 0.0, 0.3), // 1 m before the bin: 1 s away, 0 + 1
        candidate(2, -0.5, 0.5, 0.6), // 1.5 m before, 0.5 m beside: 0.25 + 2.25
        candidate(3, 0.75, 0.0, 0.5), // 0.25 m before the bin: 0.25 s away, 0.5625 + 1
    ];
    let processing = |i: usize| at.processing_time(&candidates[i]);
    assert_eq!([0, 1, 3].map(processing), [2.75, 2.75, 1.25]);
    assert!(processing(2) > 2.75);
    let squares = candidates.map(|c| at.distance_to_base(&c).powi(2));
    let expected = [3.25, 1.0, 2.5, 1.5625];
    assert!(
        squares
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    );
    for (rule, chosen) in [
        ("FIFO", 0),
        ("SPT", 3),
        ("LPT", 2),
        ("SD", 1),
        ("LD", 0),
        ("PP", 2),
    ] {
        let rule: Rule = rule.parse().unwrap();
        assert_eq!(rule.choose(&at, &candidates), chosen, "{rule}");
    }
}

/// Equal keys go to the item further downstream, then to the lower index, wherever they stand.
#[test]
fn ties_go_downstream_and_then_to_the_lower_index() {
    let station = station();
    let at = Moment::new(&station, 0, 0, 8.0);
    let tied = [
        candidate(7, 0.0, 0.25, 0.5),
        candidate(4, 0.0, -0.25, 0.5),
        candidate(5, 0.0, 0.25, 0.5),
    ];
    let pp: Rule = "PP".parse().unwrap();
    for rule in ["FIFO", "SPT", "LPT", "PP"] {
        let rule: Rule = rule.parse().unwrap();
        for turns in 0..3 {
            let mut candidates = tied;
            candidates.rotate_left(turns);
            let chosen = rule.choose(&at, &candidates);
            assert_eq!(candidates[chosen].item, 4, "{rule} {turns}");
        }
    }
    let upstream = candidate(0, -0.25, 0.0, 0.5);
    for candidates in [[tied[0], upstream], [upstream, tied[0]]] {
        let chosen = pp.choose(&at, &candidates);
        assert_eq!(candidates[chosen].item, 7);
    }
}

#[test]
fn assignments_are_written_and_counted() {
    let two: RuleAssignment = "SPT,FIFO".parse().unwrap();
    assert_eq!(two.names(), ["SPT", "FIFO"]);
    assert_eq!(RuleStrategy(two.clone()).name(), "rules:SPT,FIFO");
    assert!(!RuleStrategy(two.clone()).needs_view(), "rules do not look");
    assert_eq!(two.clone().for_robots(2).unwrap(), two);
    let message = two.for_robots(1).unwrap_err().to_string();
    for words in [
        "'strategy' [SPT; FIFO]",
        "2 rules for 1 robot",
        "one rule for each robot",
    ] {
        assert!(message.contains(words), "{message}");
    }
    for (text, words) in [
        ("", "`` contains no rule"),
        (" [ ] ", "contains no rule"),
        ("SPT,", "`` is not a dispatching rule"),
        ("[SPT", "`[SPT` is not a dispatching rule"),
        ("SPT,FIFA", "did you mean `FIFO`"),
    ] {
        let message = text.parse::<RuleAssignment>().unwrap_err().to_string();
        assert!(message.contains(words), "{text}: {message}");
    }
    let places: Vec<usize> = Rule::all().map(Rule::index).collect();
    assert_eq!(places, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn robots_without_a_rule_stand_idle() {
    let station = station();
    let items = (0..6).map(|i| Item::at(i.to_string(), -0.2 * f64::from(i), 0.0));
    let pattern = Pattern::new(items.collect()).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let picks = |rules: &str| {
        let mut strategy = FirstRobots::new(&rules.parse().unwrap());
        let outcome = simulate(&scene, &mut strategy).unwrap();
        [0, 1].map(|robot| outcome.robots[robot].picked)
    };
    let [first, second] = picks("FIFO");
    assert!(first > 0 && second == 0, "{first}, {second}");
    assert!(picks("FIFO,FIFO")[1] > 0);
}

/// Both the general engine and a run that plays to its end refuse it, with and without an observer.
#[test]
fn strategies_for_another_number_of_robots_are_refused() {
    let station = station();
    let pattern = Pattern::new(vec![Item::at("a", 0.0, 0.0)]).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    for (text, robots, message) in [
        (
            "rules:SPT",
            1,
            "'strategy' [SPT]: 1 rule for 2 robots\n  cure: give one rule for each robot, upstream \
             first",
        ),
        (
            "lookahead",
            1,
            "'strategy' lookahead:bases: 1 rule for 2 robots\n  cure: give one rule for each robot, \
             upstream first",
        ),
        (
            "lookahead",
            3,
            "'strategy' lookahead:bases: 3 rules for 2 robots\n  cure: give one rule for each \
             robot, upstream first",
        ),
    ] {
        let make = || read_alone(text, robots).unwrap().make();
        let observed = {
            let mut trace = Trace::new(&station, &pattern);
            simulate_observed(&scene, make().as_mut(), Some(&mut trace), || true).map(|_| ())
        };
        for result in [
            simulate(&scene, make().as_mut()).map(|_| ()),
            Run::new(&scene).play(make().as_mut()),
            observed,
        ] {
            let error = result.unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Usage);
            assert_eq!(error.to_string(), message);
        }
    }
    for text in ["rules:SPT,SPT", "lookahead"] {
        let mut strategy = read_alone(text, 2).unwrap().make();
        simulate(&scene, strategy.as_mut()).unwrap();
    }
}
