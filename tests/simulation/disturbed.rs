//! Runs in which things go wrong: a plain transcription of the model page agrees with the
//! engine pick by pick, the checker confirms them, luck is the same for all strategies.

use crate::common;
use pickline::checker;
use pickline::decision::{
    Action, Event, FailureCause, Miss, MissReason, Observer, Outcome, Snapshot, Strategy,
};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern};
use pickline::sim::{
    Cascade, Conditions, Disturbances, Scene, simulate, simulate_observed, simulate_rules,
};
use pickline::station::{Robot, Station};
use proptest::prelude::*;
use proptest::strategy::Strategy as _;

/// A decision: robot, item, when, whether it came to a pick.
type Told = (usize, usize, f64, bool);

/// Who decides: a rule for each robot, or a list of numbers that says when to wait.
enum Decider<'a> {
    Rules(&'a [&'static str]),
    Whim(&'a [usize]),
}

/// What decision number `count` is by the list `choices`, with as many candidates.
fn by_whim(choices: &[usize], count: usize, time: f64, candidates: usize) -> Action {
    match choices[count % choices.len()] {
        n if n % 5 == 0 => Action::WaitUntil(time + 0.001 * (n + 1) as f64),
        n if n % 5 == 1 => Action::WaitForNextWindow,
        n => Action::Pick(n % candidates),
    }
}

/// The model page written down as directly as possible; only the draws are the engine's.
fn by_the_book(
    station: &Station,
    items: &[Item],
    decider: Decider,
    conditions: &Conditions,
) -> (Vec<Told>, Vec<Miss>) {
    let belt = station.belt();
    let (v, hz, wrong) = (belt.speed, conditions.update_hz, &conditions.disturbances);
    let reported: Vec<(f64, f64)> = items
        .iter()
        .zip(0..)
        .map(|(item, j)| wrong.reported(j, item, belt.width))
        .collect();
    let window = |r: &Robot, (x0, y): (f64, f64)| -> Option<(f64, f64)> {
        let departure = |x: f64| {
            (x - x0) / v - ((x - r.bin.x).powi(2) + (y - r.bin.y).powi(2)).sqrt() / r.speed
        };
        let half2 = r.reach.powi(2) - (y - r.base.y).powi(2);
        if half2 < 0.0 {
            return None;
        }
        let x_in = (r.base.x - half2.sqrt()).max(0.0);
        let x_out = (r.base.x + half2.sqrt()).min(belt.length);
        let close = departure(x_out);
        if x_in > x_out || close < 0.0 {
            return None;
        }
        Some((departure(x_in).max(0.0).min(close), close))
    };
    let known = |r: &Robot, at: (f64, f64)| -> Option<(f64, f64)> {
        let (open, close) = window(r, at)?;
        let open = match conditions.camera_x {
            Some(x) => open.max((x - at.0) / v),
            None => open,
        };
        (open <= close).then_some((open, close))
    };
    let tick = |t: f64| {
        let ticks = t * hz;
        if hz == 0.0 || (ticks - ticks.round()).abs() <= 1e-9 {
            t
        } else {
            (ticks.ceil() / hz).max(t)
        }
    };
    let mut free = vec![0.0f64; station.robots().len()];
    // Who waits for the next window, and which claims have still to end, when.
    let mut waits = vec![false; free.len()];
    let mut ending: Vec<(f64, usize)> = Vec::new();
    let mut decisions = 0;
    // From when on each item is unclaimed, and how often it was tried.
    let mut unclaimed_from = vec![0.0f64; items.len()];
    let mut tried = vec![0u32; items.len()];
    let mut offered = vec![false; items.len()];
    let mut told = Vec::new();
    loop {
        let mut next: Option<(f64, usize, Vec<usize>)> = None;
        for (i, robot) in station.robots().iter().enumerate() {
            let windows: Vec<_> = (0..items.len())
                .filter_map(|j| Some((j, known(robot, reported[j])?)))
                .collect();
            let mut from = free[i];
            let decision = loop {
                let could = windows
                    .iter()
                    .map(|&(j, (open, close))| (open.max(from).max(unclaimed_from[j]), close));
                let could = could.filter(|(first, close)| first <= close);
                let Some(exact) = could.map(|(first, _)| first).reduce(f64::min) else {
                    break None;
                };
                let d = tick(exact);
                let can: Vec<usize> = windows
                    .iter()
                    .filter(|&&(j, (open, close))| {
                        open <= d && d <= close && unclaimed_from[j] <= d
                    })
                    .map(|(j, _)| *j)
                    .collect();
                if can.is_empty() {
                    from = d;
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
        ending.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(&(ends, item)) = ending.first()
            && next.as_ref().is_none_or(|next| ends <= next.0)
        {
            ending.remove(0);
            for (k, robot) in station
                .robots()
                .iter()
                .enumerate()
                .filter(|(k, _)| waits[*k])
            {
                if let Some((open, close)) = known(robot, reported[item])
                    && ends <= close
                {
                    free[k] = free[k].min(open.max(ends));
                }
            }
            continue;
        }
        let Some((t, i, mut can)) = next else {
            break;
        };
        can.iter().for_each(|&j| offered[j] = true);
        let r = &station.robots()[i];
        let travel = |(x0, y): (f64, f64)| {
            let (dx, dy) = (x0 + v * t - r.bin.x, y - r.bin.y);
            let k = r.speed * r.speed - v * v;
            (v * dx + ((v * dx) * (v * dx) + k * (dx * dx + dy * dy)).sqrt()) / k
        };
        let processing = |at| 2.0 * travel(at) + r.grasp_time + r.release_time;
        let distance = |(x0, y): (f64, f64)| {
            let (dx, dy) = (x0 + v * t - r.base.x, y - r.base.y);
            (dx * dx + dy * dy).sqrt()
        };
        let key = |rule: &str, j: usize| match rule {
            "FIFO" => -(reported[j].0 + v * t),
            "SPT" => processing(reported[j]),
            "LPT" => -processing(reported[j]),
            "SD" => distance(reported[j]),
            "LD" => -distance(reported[j]),
            "PP" => -items[j].reward(),
            other => panic!("no rule {other}"),
        };
        // Furthest downstream first, then by index.
        can.sort_by(|&a, &b| reported[b].0.total_cmp(&reported[a].0).then(a.cmp(&b)));
        decisions += 1;
        let action = match decider {
            Decider::Rules(rules) => {
                let best = (0..can.len()).reduce(|best, place| {
                    let [old, new] = [best, place].map(|place| key(rules[i], can[place]));
                    if new < old { place } else { best }
                });
                Action::Pick(best.unwrap())
            }
            Decider::Whim(choices) => by_whim(choices, decisions, t, can.len()),
        };
        waits[i] = action == Action::WaitForNextWindow;
        let best = match action {
            Action::Pick(place) => can[place],
            Action::WaitUntil(until) => {
                free[i] = until;
                continue;
            }
            _ => {
                let unclaimed = (0..items.len()).filter(|&j| unclaimed_from[j] <= t);
                let opens = unclaimed.filter_map(|j| Some(known(r, reported[j])?.0));
                free[i] = opens.filter(|open| *open > t).fold(f64::INFINITY, f64::min);
                continue;
            }
        };
        let truth = (items[best].x0, items[best].y);
        let there = window(r, truth).is_some_and(|(open, close)| open <= t && t <= close);
        let lucky = wrong.grasp_succeeds(best as u32, &items[best], tried[best]);
        tried[best] += 1;
        let went_to = if there { truth } else { reported[best] };
        free[i] = t + processing(went_to);
        // Without noise the window is the same, but for rounding.
        let picked = (there || wrong.position_noise == 0.0) && lucky;
        unclaimed_from[best] = if picked {
            f64::INFINITY
        } else {
            let ends = t + travel(went_to) + r.grasp_time;
            ending.push((ends, best));
            ends
        };
        told.push((i, best, t, picked));
    }
    let missed = (0..items.len()).filter(|&j| unclaimed_from[j].is_finite());
    let some = |see: &dyn Fn(&Robot) -> bool| station.robots().iter().any(see);
    let missed = missed.map(|j| {
        let reason = if !some(&|robot| window(robot, (items[j].x0, items[j].y)).is_some()) {
            MissReason::Unreachable
        } else if tried[j] > 0 {
            MissReason::GraspFailed
        } else if offered[j] {
            MissReason::PassedOver
        } else if !some(&|robot| known(robot, reported[j]).is_some()) {
            MissReason::Unseen
        } else {
            MissReason::Busy
        };
        let item = j as u32;
        Miss { item, reason }
    });
    let missed = missed.collect();
    (told, missed)
}

/// Everything that was decided, in order.
fn decided(outcome: &Outcome) -> Vec<Told> {
    let picks = outcome.picks.iter().map(|pick| (pick, true));
    let failures = outcome.failures.iter().map(|f| (&f.attempt, false));
    let mut all: Vec<Told> = picks
        .chain(failures)
        .map(|(p, picked)| (p.robot, p.item as usize, p.decide, picked))
        .collect();
    all.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
    all
}

/// Grasp probabilities that differ from item to item, some left out.
fn with_probabilities(pattern: &Pattern) -> Pattern {
    let p = [Some(0.5), None, Some(0.9), Some(0.0), Some(1.0), Some(0.2)];
    let items = pattern.items().iter().zip(p.iter().cycle());
    let items = items.map(|(item, p)| Item {
        p_grasp: *p,
        ..item.clone()
    });
    Pattern::new(items.collect()).unwrap()
}

fn conditions() -> impl proptest::strategy::Strategy<Value = Conditions> {
    let hz = prop_oneof![2 => Just(0.0), 1 => 0.5..20.0f64];
    let camera = prop::option::of(-1.0..2.0f64);
    let noise = prop_oneof![Just(0.0), 0.001..0.05f64, 0.05..1.0f64];
    (hz, camera, any::<bool>(), 0.0..=1.0f64, noise, any::<u64>()).prop_map(
        |(update_hz, camera_x, grasp_failures, default_p_grasp, position_noise, seed)| Conditions {
            update_hz,
            camera_x,
            disturbances: Disturbances {
                grasp_failures,
                default_p_grasp,
                position_noise,
                seed,
            },
        },
    )
}

/// A station with a pattern, rules and conditions.
fn cases()
-> impl proptest::strategy::Strategy<Value = ((Station, Pattern, RuleAssignment), Conditions)> {
    let cases = prop_oneof![
        common::cases(common::lines(), 40),
        common::cases(common::stations(), 40),
    ];
    (cases, conditions())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn the_engine_agrees_with_the_book(((station, pattern, rules), conditions) in cases()) {
        let pattern = with_probabilities(&pattern);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        let rules = rules.names();
        let book = by_the_book(&station, pattern.items(), Decider::Rules(&rules), &conditions);
        prop_assert_eq!((decided(&outcome), outcome.missed.clone()), book);
        checker::check(&station, &pattern, &outcome).unwrap();
        let disturbed = conditions.disturbances.any();
        prop_assert!(!(disturbed && Cascade::new(&scene).is_some()));
        prop_assert!(disturbed || outcome.failures.is_empty());
    }

    /// Strategies that wait, and that look at all they are shown.
    #[test]
    fn the_checker_confirms_any_legal_strategy(
        ((station, pattern, _), conditions) in cases(),
        choices in prop::collection::vec(0..1000usize, 1..200),
    ) {
        let pattern = with_probabilities(&pattern);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let mut whim = Whim { choices, next: 0, conditions };
        let mut events = Events::default();
        let outcome = simulate_observed(&scene, &mut whim, Some(&mut events)).unwrap();
        checker::check(&station, &pattern, &outcome).unwrap();
        events.agree_with(&outcome, &station);
        let book = Decider::Whim(&whim.choices);
        let book = by_the_book(&station, pattern.items(), book, &conditions);
        prop_assert_eq!((decided(&outcome), outcome.missed.clone()), book);
        whim.next = 0;
        prop_assert_eq!(simulate(&scene, &mut whim).unwrap(), outcome);
    }

    /// The cascade knows of the camera too.
    #[test]
    fn both_engines_agree_on_a_camera(
        (station, pattern, rules) in common::cases(common::lines(), 40),
        camera in -1.0..2.5f64,
    ) {
        let scene = Scene::new(&station, &pattern).unwrap().with_camera_x(camera).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        checker::check(&station, &pattern, &outcome).unwrap();
        // What is independent without a camera is so with one.
        let is_plain = Scene::new(&station, &pattern).unwrap().is_independent();
        let cascade = Cascade::new(&scene);
        prop_assert!(cascade.is_some() || !is_plain);
        if let Some(mut cascade) = cascade {
            prop_assert_eq!(cascade.run(rules.rules()), outcome.figures);
        }
        let speed = station.belt().speed;
        for pick in &outcome.picks {
            let x = pattern.items()[pick.item as usize].x0 + speed * pick.decide;
            prop_assert!(x >= camera - 1e-9, "picked at {x}");
        }
    }
}

/// Follows a list of numbers, and looks whether what it sees makes sense.
struct Whim {
    choices: Vec<usize>,
    next: usize,
    conditions: Conditions,
}

impl Strategy for Whim {
    fn decide(&mut self, s: &Snapshot) -> Action {
        self.next += 1;
        assert!(!s.candidates.is_empty());
        let open = |c: &pickline::decision::Candidate| c.open <= s.time && s.time <= c.close;
        assert!(s.candidates.iter().all(open));
        assert!(s.candidates.is_sorted_by(|a, b| a.is_before(b)));
        assert!(s.in_view.is_sorted_by(|a, b| a.x >= b.x));
        assert_eq!(s.time_until_free(s.robot), 0.0);
        if let Some(camera) = self.conditions.camera_x {
            assert!(s.in_view.iter().all(|item| item.x >= camera - 1e-9));
            for candidate in s.candidates {
                let mut seen = s.in_view.iter();
                let seen = seen.find(|item| item.item == candidate.item).unwrap();
                assert_eq!(seen.x, s.moment().x(candidate));
                assert_eq!(seen.y, candidate.y);
            }
        }
        by_whim(&self.choices, self.next, s.time, s.candidates.len())
    }

    fn name(&self) -> String {
        "whim".into()
    }
}

/// What an observer is told.
#[derive(Default)]
struct Events {
    time: f64,
    released: Vec<u32>,
    failed: Vec<(f64, usize, u32)>,
    left: Vec<u32>,
}

impl Observer for Events {
    fn observe(&mut self, event: &Event) {
        assert!(event.time() >= self.time, "events are in order of time");
        self.time = event.time();
        match *event {
            Event::Release { item, .. } => self.released.push(item),
            Event::GraspFailed {
                time, robot, item, ..
            } => self.failed.push((time, robot, item)),
            Event::LeftBelt { item, .. } => self.left.push(item),
            Event::Decision { .. } | Event::Grasp { .. } => {}
        }
    }
}

impl Events {
    fn agree_with(mut self, outcome: &Outcome, station: &Station) {
        let mut picked: Vec<u32> = outcome.picks.iter().map(|p| p.item).collect();
        picked.sort_unstable();
        self.released.sort_unstable();
        assert_eq!(self.released, picked);
        let missed: Vec<u32> = outcome.missed.iter().map(|m| m.item).collect();
        assert_eq!(self.left, missed);
        let failures = outcome.failures.iter().map(|f| {
            let robot = f.attempt.robot;
            let ends = f.claim_ends(station.robots()[robot].grasp_time);
            (ends, robot, f.attempt.item)
        });
        let mut failures: Vec<_> = failures.collect();
        let order = |a: &(f64, usize, u32), b: &(f64, usize, u32)| {
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2))
        };
        failures.sort_by(order);
        self.failed.sort_by(order);
        assert_eq!(self.failed, failures);
    }
}

/// The random cases are worth something only if much goes wrong, and is made good again.
#[test]
fn the_random_cases_cover_failures_and_second_attempts() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut slipped, mut astray, mut retried) = (0, 0, 0);
    for _ in 0..400 {
        let ((station, pattern, rules), conditions) =
            proptest::strategy::ValueTree::current(&cases().boxed().new_tree(&mut runner).unwrap());
        let pattern = with_probabilities(&pattern);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        let cause = |cause| outcome.failures.iter().any(|f| f.cause == cause);
        slipped += usize::from(cause(FailureCause::Grasp));
        astray += usize::from(cause(FailureCause::OutOfReach));
        let failed = |item| outcome.failures.iter().find(|f| f.attempt.item == item);
        let other = |pick: &pickline::decision::Pick| {
            failed(pick.item).is_some_and(|failure| failure.attempt.robot != pick.robot)
        };
        retried += usize::from(outcome.picks.iter().any(other));
    }
    assert!(
        slipped > 100 && astray > 50 && retried > 20,
        "of 400 cases {slipped} with failed grasps, {astray} with vain ways, {retried} with \
         items that another robot picked then"
    );
}
