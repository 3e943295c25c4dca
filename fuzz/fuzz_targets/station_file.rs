#![no_main]
//! A station file: whatever is accepted reads back, simulates and passes the checker.

use libfuzzer_sys::fuzz_target;
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::{Overrides, parse, to_toml};

fuzz_target!(|text: &str| {
    let Ok(station) = parse(text, "s", Overrides::default()) else {
        return;
    };
    let again = parse(&to_toml(&station), "t", Overrides::default());
    assert_eq!(again.unwrap(), station);
    let width = station.belt().width;
    let items = (0..20).map(|i| {
        let (column, row) = (f64::from(i / 4), f64::from(i % 4));
        Item::at(i.to_string(), -0.3 * column, (row / 3.0 - 0.5) * width)
    });
    let pattern = Pattern::new(items.collect()).unwrap();
    let robots = station.robots().len();
    let rules = RuleAssignment::new(
        pickline::dispatch::Rule::all()
            .cycle()
            .take(robots)
            .collect(),
    );
    let scene = Scene::new(&station, &pattern).unwrap();
    let outcome = simulate_rules(&scene, &rules).unwrap();
    assert!(outcome.figures.picking_rate().is_finite());
    pickline::checker::check(&station, &pattern, &outcome).unwrap();
});
