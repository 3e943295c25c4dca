//! The two engines and a plain transcription of the model page agree pick by pick.

use crate::FirstRobots;
use crate::common;
use pickline::checker;
use pickline::decision::{Action, Figures, Outcome, Pick, Snapshot, Strategy};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern, grid};
use pickline::sim::{AssignmentTree, Cascade, Scene, simulate, simulate_rules};
use pickline::station::{Robot, Station, built_in};
use proptest::prelude::*;
use proptest::strategy::{Strategy as _, ValueTree as _};

/// The model page written down as directly as possible: every decision looks at every
/// robot and every item. Shares nothing with the engines.
fn transcribed(
    station: &Station,
    items: &[Item],
    rules: &[&str],
    hz: f64,
) -> Vec<(usize, usize, f64)> {
    let belt = station.belt();
    let departure = |r: &Robot, x: f64, item: &Item| {
        (x - item.x0) / belt.speed
            - ((x - r.bins[0].at.x).powi(2) + (item.y - r.bins[0].at.y).powi(2)).sqrt()
                / r.arm.constant_speed().unwrap()
    };
    let window = |r: &Robot, item: &Item| -> Option<(f64, f64)> {
        let half2 = r.reach.powi(2) - (item.y - r.base.y).powi(2);
        if half2 < 0.0 {
            return None;
        }
        let x_in = (r.base.x - half2.sqrt()).max(0.0);
        let x_out = (r.base.x + half2.sqrt()).min(belt.length);
        let close = departure(r, x_out, item);
        if x_in > x_out || close < 0.0 {
            return None;
        }
        let open = departure(r, x_in, item).max(0.0);
        // Rounding can turn a window of hardly more than a point inside out.
        Some((open.min(close), close))
    };
    let tick = |t: f64| {
        let ticks = t * hz;
        if hz == 0.0 || (ticks - ticks.round()).abs() <= 1e-9 {
            t
        } else {
            (ticks.ceil() / hz).max(t)
        }
    };
    let mut free = vec![0.0f64; rules.len()];
    let mut claimed = vec![false; items.len()];
    let mut picks = Vec::new();
    loop {
        let mut next: Option<(f64, usize, Vec<usize>)> = None;
        for (i, robot) in station.robots().iter().enumerate() {
            let decision = loop {
                let windows = items.iter().enumerate().filter(|(j, _)| !claimed[*j]);
                let windows: Vec<_> = windows
                    .filter_map(|(j, item)| Some((j, window(robot, item)?)))
                    .collect();
                let Some(exact) = windows
                    .iter()
                    .filter(|(_, w)| w.1 >= free[i])
                    .map(|(_, w)| w.0.max(free[i]))
                    .reduce(f64::min)
                else {
                    break None;
                };
                let d = tick(exact);
                let can: Vec<usize> = windows
                    .iter()
                    .filter(|(_, w)| w.0 <= d && d <= w.1)
                    .map(|(j, _)| *j)
                    .collect();
                if can.is_empty() {
                    free[i] = d;
                } else {
                    break Some((d, i, can));
                }
            };
            if let Some(d) = decision
                && next.as_ref().is_none_or(|n| d.0 < n.0)
            {
                next = Some(d);
            }
        }
        let Some((t, i, can)) = next else {
            return picks;
        };
        let r = &station.robots()[i];
        let (v, u) = (belt.speed, r.arm.constant_speed().unwrap());
        let processing = |item: &Item| {
            let (dx, dy) = (item.x0 + v * t - r.bins[0].at.x, item.y - r.bins[0].at.y);
            let k = u * u - v * v;
            let tau = (v * dx + ((v * dx) * (v * dx) + k * (dx * dx + dy * dy)).sqrt()) / k;
            2.0 * tau + r.grasp_time + r.bins[0].release_time
        };
        let distance = |item: &Item| {
            let (dx, dy) = (item.x0 + v * t - r.base.x, item.y - r.base.y);
            (dx * dx + dy * dy).sqrt()
        };
        let key = |item: &Item| match rules[i] {
            "FIFO" => -(item.x0 + v * t),
            "SPT" => processing(item),
            "LPT" => -processing(item),
            "SD" => distance(item),
            "LD" => -distance(item),
            "PP" => -item.reward(),
            other => panic!("no rule {other}"),
        };
        let mut best = can[0];
        for &j in &can[1..] {
            if key(&items[j]) < key(&items[best]) {
                best = j;
            }
        }
        claimed[best] = true;
        free[i] = t + processing(&items[best]);
        picks.push((i, best, t));
    }
}

/// Which robot picks which item when.
fn plain(picks: &[Pick]) -> Vec<(usize, usize, f64)> {
    picks
        .iter()
        .map(|p| (p.robot, p.item as usize, p.decide))
        .collect()
}

/// All picks of a cascade run, in the event loop's order.
fn cascade_picks(scene: &Scene, rules: &RuleAssignment) -> Option<(Figures, Vec<Pick>)> {
    let mut picks = Vec::new();
    let figures = Cascade::new(scene)?.run_observed(rules.rules(), |pick| picks.push(pick));
    picks.sort_by(|a, b| a.decide.total_cmp(&b.decide).then(a.robot.cmp(&b.robot)));
    Some((figures, picks))
}

fn compare(station: &Station, pattern: &Pattern, rules: &RuleAssignment, hz: f64) -> bool {
    let scene = Scene::new(station, pattern)
        .unwrap()
        .with_update_hz(hz)
        .unwrap();
    let outcome = simulate_rules(&scene, rules).unwrap();
    checker::check(station, pattern, &outcome).unwrap();
    let transcription = transcribed(station, pattern.items(), &rules.names(), hz);
    assert_eq!(
        plain(&outcome.picks),
        transcription,
        "{rules} against the transcription"
    );
    let Some((figures, picks)) = cascade_picks(&scene, rules) else {
        return false;
    };
    assert_eq!(figures, outcome.figures, "{rules}");
    assert_eq!(picks, outcome.picks, "{rules}");
    true
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn engines_agree_on_any_station((station, pattern, rules) in common::cases(common::stations(), 40)) {
        compare(&station, &pattern, &rules, 0.0);
    }

    #[test]
    fn engines_agree_on_lines((station, pattern, rules) in common::cases(common::lines(), 60)) {
        compare(&station, &pattern, &rules, 0.0);
    }

    #[test]
    fn engines_agree_at_an_update_frequency(
        (station, pattern, rules) in prop_oneof![
            common::cases(common::lines(), 40),
            common::cases(common::stations(), 40),
        ],
        hz in prop_oneof![Just(10.0), 0.5..20.0f64],
    ) {
        compare(&station, &pattern, &rules, hz);
    }

    /// A strategy that waits and picks at random obeys the model too.
    #[test]
    fn any_legal_strategy_passes_the_checker(
        (station, pattern, _) in common::cases(common::stations(), 40),
        choices in prop::collection::vec(0..1000usize, 1..200),
    ) {
        let scene = Scene::new(&station, &pattern).unwrap();
        let outcome = simulate(&scene, &mut Whim { choices, next: 0 }).unwrap();
        checker::check(&station, &pattern, &outcome).unwrap();
    }
}

/// Follows a list of numbers.
struct Whim {
    choices: Vec<usize>,
    next: usize,
}

impl Strategy for Whim {
    fn decide(&mut self, s: &Snapshot) -> Action {
        self.next += 1;
        assert!(!s.candidates.is_empty());
        assert!(
            s.candidates
                .iter()
                .all(|c| c.open <= s.time && s.time <= c.close)
        );
        assert!(s.candidates.is_sorted_by_key(|c| c.item));
        assert_eq!(s.time_until_free(s.robot), 0.0);
        let belt = s.station.belt();
        assert!(s.in_view.iter().all(|i| (0.0..=belt.length).contains(&i.x)));
        match self.choices[self.next % self.choices.len()] {
            n if n % 5 == 0 => Action::WaitUntil(s.time + 0.001 * (n + 1) as f64),
            n if n % 5 == 1 => Action::WaitForNextWindow,
            n => Action::Pick(n % s.candidates.len()),
        }
    }

    fn name(&self) -> String {
        "whim".into()
    }
}

#[test]
fn the_cascade_is_used_on_the_built_in_stations_and_refused_on_overlaps() {
    for name in ["paper", "paper-narrow"] {
        for robots in 1..=6 {
            let station = built_in(name).unwrap().station(Some(robots)).unwrap();
            let pattern = grid(station.belt().width, 0.15, 150).unwrap();
            let scene = Scene::new(&station, &pattern).unwrap();
            assert!(scene.is_independent(), "{name} {robots}");
            assert!(Cascade::new(&scene).is_some(), "{name} {robots}");
        }
    }
    let station = built_in("paper").unwrap().station(None).unwrap();
    let mut robots = station.robots().to_vec();
    robots[1].base.x -= 1.2;
    robots[1].bins[0].at.x -= 1.2;
    robots[1].rest.x -= 1.2;
    let station = Station::new(*station.belt(), robots).unwrap();
    let pattern = grid(1.05, 0.15, 150).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    assert!(!scene.is_independent());
    assert!(Cascade::new(&scene).is_none());
}

#[test]
fn the_tree_gives_every_assignment_the_figures_of_its_own_run() {
    let crowded = {
        let station = built_in("paper").unwrap().station(Some(3)).unwrap();
        let mut robots = station.robots().to_vec();
        robots[1].base.x -= 1.2;
        robots[1].bins[0].at.x -= 1.2;
        robots[1].rest.x -= 1.2;
        Station::new(*station.belt(), robots).unwrap()
    };
    for station in [
        built_in("paper").unwrap().station(Some(3)).unwrap(),
        crowded,
    ] {
        let pattern = grid(station.belt().width, 0.15, 80).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let prefixes = (1..=3).flat_map(RuleAssignment::all).collect();
        let tree = AssignmentTree::new(prefixes);
        let rules = pickline::dispatch::RULES.len();
        let all = rules + rules.pow(2) + rules.pow(3);
        assert_eq!(tree.passes(), all);
        let mut seen = 0;
        tree.evaluate(&scene, |place, figures| {
            let rules = &tree.assignments()[place];
            let alone = simulate(&scene, &mut FirstRobots::new(rules)).unwrap();
            assert_eq!(figures, alone.figures, "{rules}");
            assert_eq!(place, seen);
            seen += 1;
        })
        .unwrap();
        assert_eq!(seen, all);
    }
}

/// Figures of `docs/model.md`, measured in an independent prototype of the model.
#[test]
fn the_papers_grid_gives_the_figures_of_the_model_page() {
    let run = |station: &str, rules: &str, spacing: f64, items: usize| -> Outcome {
        let station = built_in(station).unwrap().station(None).unwrap();
        let pattern = grid(station.belt().width, spacing, items).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        simulate_rules(&scene, &rules.parse().unwrap()).unwrap()
    };
    for (station, rules, spacing, items, picked, end, rate) in [
        ("paper", "SPT,FIFO", 0.15, 50, 44, 99.0, 26.7),
        ("paper", "SPT,SPT", 0.15, 50, 43, 93.1, 27.7),
        ("paper", "SPT,FIFO", 0.3, 50, 50, 110.9, 27.1),
        ("paper", "SPT,FIFO", 0.15, 150, 86, 135.0, 38.2),
        ("paper-narrow", "SPT,FIFO", 0.15, 50, 44, 95.5, 27.6),
        ("paper-narrow", "SPT,FIFO", 0.3, 50, 50, 114.9, 26.1),
    ] {
        let f = run(station, rules, spacing, items).figures;
        assert_eq!(f.picked, picked, "{station} {rules} {spacing} {items}");
        assert!(
            (f.end - end).abs() < 0.3,
            "{station} {rules} {spacing}: {}",
            f.end
        );
        assert!(
            (f.picking_rate() - rate).abs() < 0.06,
            "{}",
            f.picking_rate()
        );
    }
}

#[test]
fn illegal_actions_are_errors() {
    struct Bad(Action);
    impl Strategy for Bad {
        fn decide(&mut self, _: &Snapshot) -> Action {
            self.0
        }
        fn name(&self) -> String {
            "bad".into()
        }
    }
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(1.05, 0.15, 50).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    for (action, problem) in [
        (
            Action::Pick(usize::MAX),
            "candidate 18446744073709551615 of 1",
        ),
        (
            Action::WaitUntil(0.0),
            "it waits until 0 s, which is not later",
        ),
        (
            Action::WaitUntil(f64::NAN),
            "it waits until NaN s, which is not later",
        ),
        (Action::NoAnswer, "no answer"),
    ] {
        let message = simulate(&scene, &mut Bad(action)).unwrap_err().to_string();
        assert!(message.contains(problem), "{action:?}: {message}");
    }
}

/// The random cases above are worth something only if both engines get work.
#[test]
fn the_random_cases_cover_both_engines() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut count = |cases: BoxedStrategy<(Station, Pattern, RuleAssignment)>| {
        let (mut cascade, mut contested) = (0, 0);
        for _ in 0..400 {
            let (station, pattern, rules) = cases.new_tree(&mut runner).unwrap().current();
            let scene = Scene::new(&station, &pattern).unwrap();
            let picks = simulate_rules(&scene, &rules).unwrap().picks;
            let several = picks.iter().any(|p| p.robot != picks[0].robot);
            cascade += usize::from(several && scene.is_independent());
            contested += usize::from(several && !scene.is_independent());
        }
        (cascade, contested)
    };
    let (cascade, _) = count(common::cases(common::lines(), 60).boxed());
    assert!(cascade > 100, "{cascade} of 400 lines run in the cascade");
    let (cascade, contested) = count(common::cases(common::stations(), 40).boxed());
    assert!(
        cascade > 10 && contested > 100,
        "{cascade} and {contested} of 400 stations"
    );
}
