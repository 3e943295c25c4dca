//! A run stepped from outside: the same as the engine's own, in buffers that last.

use crate::common;
use pickline::decision::{Action, Outcome, Pick, Strategy as _};
use pickline::dispatch::{RuleAssignment, RuleStrategy};
use pickline::pattern::grid;
use pickline::sim::{Run, RunBuffers, Scene, simulate_rules};
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
    while let Some(snapshot) = run.next_decision() {
        let (time, robot) = (snapshot.time, snapshot.robot);
        let view = snapshot.in_view.to_vec();
        assert!(snapshot.candidates.iter().all(|c| c.open <= time));
        let action = strategy.decide(&snapshot);
        let again = run.next_decision().unwrap();
        assert_eq!((again.time, again.robot), (time, robot));
        assert_eq!(again.in_view, view);
        picks.extend(run.act(action).unwrap());
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
fn nothing_is_allocated_once_the_buffers_have_grown() {
    let station = built_in("paper").unwrap().station(Some(3)).unwrap();
    let patterns = [0.15, 0.2].map(|spacing| grid(1.05, spacing, 150).unwrap());
    let scenes = patterns
        .each_ref()
        .map(|pattern| Scene::new(&station, pattern).unwrap());
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
