//! The general engine, for any strategy, any station and observers.

use super::announcer::Announcer;
use super::run::Run;
use super::scene::Scene;
use crate::decision::{Observer, Outcome, Strategy, answer};
use crate::dispatch::{RuleAssignment, RuleStrategy};
use crate::error::{Error, Result};

/// Simulates `strategy` on `scene`.
///
/// # Errors
/// If the strategy is for another number of robots, or takes an action that the model forbids.
pub fn simulate(scene: &Scene, strategy: &mut dyn Strategy) -> Result<Outcome> {
    let mut run = Run::new(scene);
    run.play(strategy)?;
    Ok(run.into_outcome())
}

/// Like [`simulate`], but looks before every decision whether to `go_on`.
///
/// # Errors
/// See [`simulate`]; [`Interrupted`](crate::error::ErrorKind::Interrupted) if it is not to go on.
pub fn simulate_while(
    scene: &Scene,
    strategy: &mut dyn Strategy,
    go_on: impl Fn() -> bool,
) -> Result<Outcome> {
    let mut run = Run::new(scene);
    run.play_while(strategy, go_on)?;
    Ok(run.into_outcome())
}

/// Simulates a rule assignment, which never takes a forbidden action, on `scene`.
///
/// # Errors
/// If the number of rules differs from the number of robots.
pub fn simulate_rules(scene: &Scene, rules: &RuleAssignment) -> Result<Outcome> {
    let rules = rules.clone().for_robots(scene.station().robots().len())?;
    simulate(scene, &mut RuleStrategy(rules))
}

/// Like [`simulate_while`], but reports every event to `observer` in order of time.
///
/// # Errors
/// See [`simulate_while`].
pub fn simulate_observed(
    scene: &Scene,
    strategy: &mut dyn Strategy,
    observer: Option<&mut dyn Observer>,
    go_on: impl Fn() -> bool,
) -> Result<Outcome> {
    let Some(observer) = observer else {
        return simulate_while(scene, strategy, go_on);
    };
    strategy.check_station(scene.station())?;
    let mut announcer = Announcer::new(observer, scene);
    let mut run = Run::new(scene);
    run.look(strategy.needs_view());
    while let Some(snapshot) = run.next_decision() {
        if !go_on() {
            return Err(Error::interrupted());
        }
        let time = snapshot.time;
        let action = answer(strategy, &snapshot)?;
        announcer.advance(&run, time);
        let failed = run.failures().len();
        let pick = run.act(action)?;
        announcer.decided(&run.seen(), action);
        if let Some(pick) = &pick {
            announcer.picks(pick);
        }
        for failure in &run.failures()[failed..] {
            let robot = &scene.station().robots()[failure.attempt.robot];
            announcer.fails(failure, robot.grasp_time);
        }
    }
    announcer.finish(&run);
    Ok(run.into_outcome())
}
