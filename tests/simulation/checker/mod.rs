//! The checker confirms real runs, and every one of its checks refutes a run that all the
//! others confirm.

mod bench;
mod bent_attempts;
mod bent_figures;
mod bent_misses;
mod downtimes;
mod listed;
mod rounding;
mod vain_ways;

use bench::{Bench, Draft};
use pickline::checker::check;
use pickline::pattern::grid;
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::built_in;

#[test]
fn real_runs_are_confirmed() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(1.05, 0.15, 150).unwrap();
    for (fails, noise) in [(false, 0.0), (true, 0.0), (false, 0.05), (true, 0.05)] {
        let disturbances = Disturbances::default()
            .with_grasp_failures(fails)
            .with_default_p_grasp(0.6)
            .with_position_noise(noise)
            .with_seed(3);
        let conditions = Conditions::default().with_disturbances(disturbances);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let outcome = simulate_rules(&scene, &"SPT,FIFO".parse().unwrap()).unwrap();
        check(&station, &pattern, &outcome).unwrap();
        assert_eq!(outcome.failures.is_empty(), !fails && noise == 0.0);
    }
}

/// A bend of the bench's run and the words in which it is refuted.
type Bent = (&'static str, fn(&Bench, &mut Draft), &'static str);

/// Bends the bench's run in one way after the other. Figures follow from what is bent.
fn assert_refuted(bends: &[Bent]) {
    let bench = Bench::new();
    check(&bench.station, &bench.pattern, &bench.finish(bench.run())).unwrap();
    for (name, bend, words) in bends {
        let mut draft = bench.run();
        bend(&bench, &mut draft);
        let refuted = check(&bench.station, &bench.pattern, &bench.finish(draft));
        let message = refuted.expect_err(name).to_string();
        assert!(message.contains(words), "{name}: {message}");
    }
}
