//! How many steps a bound takes: three quarters as many for the rate as for what is earned, an eighth
//! for each end, in rounds of three, with each slot length, and no more where 24 rounds in a row have
//! changed nothing.

use crate::bound_limits::line;
use pickline::pattern::{Item, Pattern};
use pickline::planning::bound::{BoundOptions, upper_bound};
use pickline::sim::Scene;

/// Steps that are done for the rate and the ends alone, and how many were announced.
fn steps(pattern: &Pattern, iterations: usize, slot_s: f64) -> (usize, usize) {
    let station = line(&[1.0, 2.0]);
    let scene = Scene::new(&station, pattern).unwrap();
    // As much as any bound allows, so that no step is needed for what is earned.
    let known = 1e9;
    let options = BoundOptions::default()
        .with_iterations(iterations)
        .with_slot_s(slot_s)
        .with_known(known);
    let mut told = Vec::new();
    let bound = upper_bound(&scene, &options, &mut |done, of| {
        told.push((done, of));
        true
    });
    let steps = bound.unwrap().iterations;
    let announced = told.first().map_or(0, |first| first.1);
    assert_eq!(
        told,
        (1..=steps)
            .map(|done| (done, announced))
            .collect::<Vec<_>>()
    );
    (steps, announced)
}

#[test]
fn the_rate_takes_three_quarters_of_the_steps_and_each_end_an_eighth() {
    let item = |i: usize| Item::at(i.to_string(), -0.15 * i as f64, -0.3);
    let pattern = Pattern::new((0..40).map(item).collect()).unwrap();
    // Longer slots would be longer than a quarter of a pick.
    let alone = 0.5;
    assert_eq!(steps(&pattern, 24, alone), (18 + 3 + 3, 48));
    // Whole rounds: 30 of 40, 5 of 40 and 5 of 40.
    assert_eq!(steps(&pattern, 40, alone), (30 + 3 + 3, 80));
    let (most, announced) = steps(&pattern, 24, 0.05);
    assert_eq!(announced, 4 * 24);
    assert!((24 + 9 + 9..=3 * 24).contains(&most), "{most}");
}

#[test]
fn rounds_without_a_change_end_the_search() {
    let pattern = Pattern::new(vec![Item::at("0", 0.0, -0.5)]).unwrap();
    let (alone, _) = steps(&pattern, 3000, 0.5);
    assert!(0 < alone && alone <= 3 * 24 * 3, "{alone}");
    // Shorter slots try once what was in vain with longer ones.
    let (all, _) = steps(&pattern, 3000, 0.05);
    assert!(alone < all && all <= 3 * (24 * 3 + 3 + 3), "{all}");
}
