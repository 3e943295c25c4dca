//! One call of the library finds what the same call of the program prints.

use crate::common::text;
use pickline::ErrorKind;
use pickline::optimize::Environment;
use pickline::optimize::game::{PayoffKind, optimum};
use pickline::pattern::{Pattern, grid};
use pickline::sim::{Conditions, Disturbances};
use pickline::station::{Station, built_in};
use pickline::strategies;
use pickline::study::{self, BoundStudyOptions, GameOptions, Note, SimulateOptions};
use serde_json::Value;

fn station() -> Station {
    built_in("paper").unwrap().station(Some(2)).unwrap()
}

/// The pattern that the program takes if it is given none.
fn pattern() -> Pattern {
    let (spacing, count) = study::DEFAULT_GRID;
    grid(station().belt().width, spacing, count).unwrap()
}

/// Conditions under which two grasps in ten fail.
fn failing() -> Conditions {
    Conditions::default().with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.8),
    )
}

/// What the program reports for these arguments.
fn report(arguments: &str) -> Value {
    let arguments = format!("{arguments} --format json -q");
    let words: Vec<&str> = arguments.split(' ').collect();
    serde_json::from_str(&text(&words)).unwrap()
}

#[test]
fn a_run_has_the_picks_the_clearance_and_the_bound_of_simulate() {
    let (station, pattern) = (station(), pattern());
    let strategy = strategies::parse("SPT,FIFO").unwrap();
    for (flags, conditions) in [
        ("", Conditions::default()),
        (" --grasp-success 0.8 --seed 7", failing()),
    ] {
        let options = SimulateOptions::default()
            .with_seed(if flags.is_empty() { 1 } else { 7 })
            .with_conditions(conditions)
            .with_trace(true)
            .with_check(true)
            .with_clearance(true);
        let quiet = Environment::QUIET;
        let run =
            study::simulate_and_check(&station, &pattern, &strategy, &options, &quiet).unwrap();
        let report = report(&format!(
            "simulate --strategy SPT,FIFO --check --robots 2{flags}"
        ));
        assert_eq!(report["strategy"], run.strategy);
        assert_eq!(report["picked"], run.outcome.figures.picked);
        assert_eq!(report["end_s"], run.outcome.figures.end);
        assert_eq!(
            report["clearance"]["distance_m"],
            run.clearance.unwrap().distance
        );
        let bound = run.bound.unwrap().value as usize;
        assert_eq!(report["bound"]["picks_upper_bound"], bound);
        let events = run.trace.unwrap().to_csv().lines().count();
        assert!(events > run.outcome.picks.len(), "{events}");
        assert!(run.notes.is_empty(), "{:?}", run.notes);
    }
}

#[test]
fn a_bound_has_the_picks_the_weight_and_the_notes_of_bound() {
    let (station, pattern) = (station(), pattern());
    let options = BoundStudyOptions::default()
        .with_weight(true)
        .with_slot(0.5)
        .with_iterations(20);
    let command = "bound --robots 2 --objective weight --slot 0.5 --iterations 20";
    let plain = study::bound(&station, &pattern, &options, &Environment::QUIET).unwrap();
    let printed = report(command);
    assert_eq!(printed["picks_relaxed"], plain.picks.relaxed);
    assert_eq!(
        printed["schedule"]["picked"],
        plain.weight.unwrap().schedule.unwrap().figures.picked
    );
    assert!(plain.notes.is_empty(), "{:?}", plain.notes);
    let options = options.with_conditions(failing());
    let failing = study::bound(&station, &pattern, &options, &Environment::QUIET).unwrap();
    assert_eq!(failing.notes, [Note::UndisturbedBound { camera: false }]);
    let printed = report(&format!("{command} --grasp-success 0.8"));
    assert_eq!(printed["picks_relaxed"], failing.picks.relaxed);
    assert_eq!(printed["notes"][0], failing.notes[0].to_string());

    let options = options.with_iterations(0);
    let refused = study::bound(&station, &pattern, &options, &Environment::QUIET).unwrap_err();
    assert_eq!(refused.place(), Some("'iterations'"));
}

#[test]
fn a_game_has_the_optimum_and_the_notes_of_game() {
    let options = GameOptions::default()
        .with_seed(3)
        .with_patterns("poisson:0.15:4".parse().unwrap())
        .with_payoff(PayoffKind::Total);
    let played = study::game(&station(), &options, &Environment::QUIET).unwrap();
    let printed = report("game --robots 2 --seed 3 --patterns poisson:0.15:4 --payoff total");
    assert_eq!((played.planned, played.line.patterns), (4, 4));
    assert_eq!(printed["runs"], played.line.runs());
    let welfare = optimum(&played.line.game).welfare.value();
    assert_eq!(printed["social_optimum"]["welfare"], welfare);
    assert_eq!(played.notes, [Note::EqualWeights]);

    let long = built_in("paper").unwrap().station(Some(5)).unwrap();
    let refused = study::game(&long, &options, &Environment::QUIET).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Usage);
}
