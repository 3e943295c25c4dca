//! A run stepped from outside: the same as the engine's own, in buffers that last.

use crate::common;
use pickline::checker::check;
use pickline::decision::{Action, Outcome, Pick, Strategy as _};
use pickline::dispatch::{RuleAssignment, RuleStrategy};
use pickline::pattern::grid;
use pickline::sim::{Conditions, Disturbances, Run, RunBuffers, Scene, simulate_rules};
use pickline::station::built_in;
use proptest::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts what this thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is passed on to the system's allocator as it came.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that ends frees after its locals are gone; nothing is counted then.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Plays `rules` on `scene` step by step, asking for every decision twice.
fn stepped(scene: &Scene, rules: &RuleAssignment, buffers: RunBuffers) -> (Outcome, RunBuffers) {
    let mut strategy = RuleStrategy(rules.clone());
    let mut run = Run::with_buffers(scene, buffers);
    let mut picks: Vec<Pick> = Vec::new();
    let mut back_at = vec![0.0; scene.station().robots().len()];
    while let Some(snapshot) = run.next_decision() {
        let (time, robot) = (snapshot.time, snapshot.robot);
        let view = snapshot.in_view.to_vec();
        assert!(snapshot.candidates.iter().all(|c| c.open <= time));
        // Idle ones are free by now, and the others when they are back.
        for (&free, &back) in snapshot.free_at.iter().zip(&back_at) {
            assert!(free == back || free <= time && back <= time);
        }
        let action = strategy.decide(&snapshot);
        let again = run.next_decision().unwrap();
        assert_eq!((again.time, again.robot), (time, robot));
        assert_eq!(again.in_view, view);
        let pick = run.act(action).unwrap();
        let failed = run.failures().last().map(|failure| failure.attempt);
        back_at[robot] = pick.or(failed).unwrap().release;
        picks.extend(pick);
        // At any time, as if nothing further were picked.
        if picks.len() % 8 == 1 {
            check(scene.station(), scene.pattern(), &run.outcome()).unwrap();
        }
    }
    assert_eq!(run.picks(), picks);
    let outcome = run.outcome();
    assert_eq!(run.figures(), outcome.figures);
    assert_eq!(run.robots(), outcome.robots);
    (outcome, run.into_buffers())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever scenes the buffers came from.
    #[test]
    fn stepping_gives_the_engines_run(
        cases in prop::collection::vec(common::cases(common::stations(), 70), 1..4),
    ) {
        let mut buffers = RunBuffers::default();
        for (station, pattern, rules) in &cases {
            let scene = Scene::new(station, pattern).unwrap();
            let outcome;
            (outcome, buffers) = stepped(&scene, rules, buffers);
            prop_assert_eq!(outcome, simulate_rules(&scene, rules).unwrap());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Buffers of runs that were given up, before or after a decision, leave nothing behind.
    #[test]
    fn buffers_of_a_run_that_was_given_up_are_as_good_as_new(
        cases in prop::collection::vec((common::cases(common::stations(), 40), 0..60usize), 2..5),
        p in 0.2..1.0f64,
        noise in prop_oneof![Just(0.0), 0.001..0.1f64],
    ) {
        let mut buffers = RunBuffers::default();
        for ((station, pattern, rules), steps) in &cases {
            // Every other scene is one where nothing goes wrong.
            let disturbed = steps % 2 == 0;
            let conditions = Conditions::default().with_disturbances(
                Disturbances::default()
                    .with_grasp_failures(disturbed)
                    .with_default_p_grasp(p)
                    .with_position_noise(if disturbed { noise } else { 0.0 })
                    .with_seed(*steps as u64),
            );
            let scene = Scene::under(station, pattern, conditions).unwrap();
            let outcome;
            (outcome, buffers) = stepped(&scene, rules, buffers);
            prop_assert_eq!(outcome, simulate_rules(&scene, rules).unwrap());
            let mut run = Run::with_buffers(&scene, buffers);
            run.look(steps % 3 == 0);
            for step in 0..*steps {
                if run.next_decision().is_none() || step + 1 == *steps {
                    break;
                }
                let waits = step % 4 == 3;
                let action = if waits { Action::WaitForNextWindow } else { Action::Pick(0) };
                run.act(action).unwrap();
            }
            buffers = run.into_buffers();
        }
    }
}

/// The message names the robot of this run, not one that an earlier run had.
#[test]
fn no_decision_is_due_at_first_whatever_the_buffers() {
    let pattern = grid(1.05, 0.15, 150).unwrap();
    let three = built_in("paper").unwrap().station(Some(3)).unwrap();
    let scene = Scene::new(&three, &pattern).unwrap();
    let mut run = Run::new(&scene);
    while run
        .next_decision()
        .is_some_and(|decision| decision.robot < 2)
    {
        run.act(Action::Pick(0)).unwrap();
    }
    let one = built_in("paper").unwrap().station(Some(1)).unwrap();
    let scene = Scene::new(&one, &pattern).unwrap();
    let mut run = Run::with_buffers(&scene, run.into_buffers());
    let message = run.act(Action::Pick(0)).unwrap_err().to_string();
    assert!(
        message.contains("no decision is due") && message.contains("r1"),
        "{message}"
    );
    assert_eq!(run.figures().picked, 0);
    let first = Run::new(&scene).next_decision().unwrap().time;
    assert_eq!(run.next_decision().unwrap().time, first);
}

#[test]
fn an_illegal_action_changes_nothing() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(1.05, 0.15, 50).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let mut run = Run::new(&scene);
    let refused = |run: &mut Run, action: Action, problem: &str| {
        let message = run.act(action).unwrap_err().to_string();
        assert!(message.contains(problem), "{action:?}: {message}");
    };
    refused(&mut run, Action::Pick(0), "no decision is due");
    while let Some(snapshot) = run.next_decision() {
        let (time, count) = (snapshot.time, snapshot.candidates.len());
        let beyond = format!("candidate {count} of {count}");
        refused(&mut run, Action::Pick(count), &beyond);
        for until in [time, f64::NAN] {
            refused(&mut run, Action::WaitUntil(until), "which is not later");
        }
        refused(&mut run, Action::NoAnswer, "no answer");
        assert!(run.act(Action::Pick(0)).unwrap().is_some());
        refused(&mut run, Action::Pick(0), "no decision is due");
    }
    let fifo = simulate_rules(&scene, &"FIFO,FIFO".parse().unwrap()).unwrap();
    assert_eq!(run.outcome(), fifo);
    run.reset();
    assert_eq!(run.figures().picked, 0);
    run.play(&mut RuleStrategy("FIFO,FIFO".parse().unwrap()))
        .unwrap();
    assert_eq!(run.into_outcome(), fifo);
}

#[test]
fn the_belt_is_shown_as_long_as_it_is_asked_for() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(1.05, 0.15, 50).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let mut run = Run::new(&scene);
    let shown = |run: &mut Run| !run.next_decision().unwrap().in_view.is_empty();
    assert!(shown(&mut run));
    run.reset();
    run.look(false);
    assert!(!shown(&mut run));
    run.reset();
    assert!(!shown(&mut run), "a reset changes nothing about it");
    run.reset();
    run.look(true);
    assert!(shown(&mut run));
    // A new run looks, whatever the one before did.
    run.look(false);
    let mut run = Run::with_buffers(&scene, run.into_buffers());
    assert!(shown(&mut run));
}

#[test]
fn nothing_is_allocated_once_the_buffers_have_grown() {
    // Fewer robots and items in between.
    let stations =
        [3, 1, 3].map(|robots| built_in("paper").unwrap().station(Some(robots)).unwrap());
    let patterns = [(0.15, 150), (0.3, 20), (0.2, 150)];
    let patterns = patterns.map(|(spacing, items)| grid(1.05, spacing, items).unwrap());
    let scenes = stations.iter().zip(&patterns);
    let scenes: Vec<Scene> = scenes
        .map(|(station, pattern)| Scene::new(station, pattern).unwrap())
        .collect();
    let mut buffers = RunBuffers::default();
    let mut counts = Vec::new();
    for _ in 0..2 {
        let before = ALLOCATIONS.get();
        for scene in &scenes {
            let mut run = Run::with_buffers(scene, buffers);
            let mut picks = 0;
            while let Some(snapshot) = run.next_decision() {
                let action = if (snapshot.candidates.len() + picks) % 7 == 3 {
                    Action::WaitUntil(snapshot.time + 0.3)
                } else {
                    Action::Pick(snapshot.candidates.len() / 2)
                };
                picks += usize::from(run.act(action).unwrap().is_some());
            }
            assert_eq!(run.figures().picked, picks);
            buffers = run.into_buffers();
        }
        counts.push(ALLOCATIONS.get() - before);
    }
    assert!(counts[0] > 0, "the count works");
    assert_eq!(counts[1], 0);
}
