//! Options of studies that do not fit are refused, as the program refuses its arguments.

use pickline::ErrorKind;
use pickline::experiment::{Axis, load_cases};
use pickline::optimize::{Environment, Risk};
use pickline::sim::Conditions;
use pickline::station::{Station, built_in};
use pickline::study::{self, CompareOptions, GameOptions, OptimizeOptions, SweepOptions};

fn station() -> Station {
    built_in("paper").unwrap().station(Some(2)).unwrap()
}

#[test]
fn a_risk_is_a_share_of_the_patterns() {
    for share in [f64::NAN, 0.0, -1.0, 2.0] {
        let options = OptimizeOptions::default().with_risk(Risk::Cvar(share));
        let refused = study::optimize(&station(), &options, &Environment::QUIET).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Usage);
        assert_eq!(refused.place(), Some("'risk'"));
    }
}

#[test]
fn a_line_of_three_robots_has_three() {
    let options = SweepOptions::default()
        .with_axis(Axis::Robots)
        .with_robots(|_| Ok(station()))
        .with_to(3.0);
    let refused = study::sweep(&station(), &options, &Environment::QUIET).unwrap_err();
    let told = refused.to_string();
    assert!(
        told.contains("'robots'") || told.contains("'sweep_axis' robots"),
        "{told}"
    );
    assert!(told.contains("gives 2 robots for"), "{told}");
}

#[test]
fn a_comparison_has_cases_and_conditions_that_hold() {
    let compare = |cases: &[_], options: &CompareOptions| {
        study::compare(&station(), cases, options, &Environment::QUIET).unwrap_err()
    };
    let refused = compare(&[], &CompareOptions::default());
    assert_eq!(refused.place(), Some("'cases'"));
    let conditions = Conditions::at_update_hz(f64::NAN);
    let options = CompareOptions::default().with_conditions(conditions);
    let refused = compare(&load_cases("paper").unwrap(), &options);
    assert_eq!(refused.place(), Some("'update_hz'"));
}

/// Without classes, no robot of `sorting` has a bin for the items.
#[test]
fn patterns_of_which_nothing_is_to_be_picked_have_no_best_rules() {
    let sorting = built_in("sorting").unwrap().station(None).unwrap();
    let quiet = &Environment::QUIET;
    let optimized = study::optimize(&sorting, &OptimizeOptions::default(), quiet);
    let played = study::game(&sorting, &GameOptions::default(), quiet);
    for refused in [optimized.unwrap_err(), played.unwrap_err()] {
        assert_eq!(refused.kind(), ErrorKind::Usage);
        assert_eq!(refused.place(), Some("the patterns"));
        assert!(refused.to_string().contains("no item is to be picked"));
    }
}
