#![no_main]
//! A pattern file: whatever is accepted reads back, simulates and passes the checker.

use libfuzzer_sys::fuzz_target;
use pickline::pattern::{describe, parse, to_csv};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::built_in;

fuzz_target!(|text: &str| {
    let Ok(pattern) = parse(text, "p") else {
        return;
    };
    assert_eq!(parse(&to_csv(&pattern), "t").unwrap(), pattern);
    describe(&pattern);
    let station = built_in("paper").unwrap().station(None).unwrap();
    // An item beside this belt is refused, and rightly so.
    let Ok(scene) = Scene::new(&station, &pattern) else {
        return;
    };
    let outcome = simulate_rules(&scene, &"PP,LPT".parse().unwrap()).unwrap();
    assert!(outcome.figures.weighted_rate().is_finite());
    pickline::checker::check(&station, &pattern, &outcome).unwrap();
});
