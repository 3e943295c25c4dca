//! What the game of a line pays, worked out from single runs.

use pickline::dispatch::{RULES, RuleAssignment};
use pickline::optimize::game::{Game, LineGame, Payoff, PayoffKind};
use pickline::optimize::{Environment, Silent};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::built_in;
use pickline_report::{GameReport, Provenance};
use std::sync::atomic::AtomicBool;

/// Payoffs are the means of what simulating every assignment by itself gives.
#[test]
fn payoffs_are_mean_rates() {
    let station = built_in("paper-narrow").unwrap().station(Some(2)).unwrap();
    let width = station.belt().width;
    let patterns = [0.15, 0.21, 0.33].map(|s| pickline::pattern::grid(width, s, 40).unwrap());
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let play = |kind| {
        LineGame::new(
            &station,
            &patterns,
            kind,
            &Conditions::default(),
            &environment,
        )
        .unwrap()
    };
    let (own, total) = (play(PayoffKind::Own), play(PayoffKind::Total));
    assert_eq!(own.patterns, 3);
    assert_eq!(own.runs(), 3 * 36);
    for (profile, rules) in RuleAssignment::all(2).enumerate() {
        assert_eq!(own.game.names(profile), rules.names());
        let mut means = [0.0; 2];
        for pattern in &patterns {
            let scene = Scene::new(&station, pattern).unwrap();
            let outcome = simulate_rules(&scene, &rules).unwrap();
            for (mean, robot) in means.iter_mut().zip(&outcome.robots) {
                *mean += 60.0 * robot.picked as f64 / outcome.figures.end / 3.0;
            }
        }
        for (robot, mean) in means.iter().enumerate() {
            let difference = own.game.payoff(profile, robot).value() - mean;
            assert!(difference.abs() < 1e-8, "{rules}: {difference}");
            assert_eq!(total.game.payoff(profile, robot), own.game.welfare(profile));
        }
        assert_eq!(own.rates(profile), own.game.payoffs(profile));
        assert_eq!(total.rates(profile), own.rates(profile));
        // The interval is about the gain.
        for action in 0..RULES.len() {
            let gain =
                own.game.payoff(own.game.with(profile, 1, action), 1) - own.game.payoff(profile, 1);
            let interval = own.gain_interval(profile, 1, action).unwrap();
            let middle = (interval.low + interval.high) / 2.0;
            assert!((middle - gain.value()).abs() < 1e-8, "{interval:?} {gain}");
        }
    }
}

/// What a robot gains by another rule, pattern by pattern under the luck of its place: mean and
/// Student's interval, of which the quantile for three values is 4.302653.
#[test]
fn gains_are_paired_over_the_patterns() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let width = station.belt().width;
    let patterns = [0.15, 0.18, 0.21].map(|s| pickline::pattern::grid(width, s, 40).unwrap());
    let conditions = Conditions::default().with_update_hz(5.0).with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.8)
            .with_seed(4),
    );
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    // Own rates of both robots on each pattern, by profile.
    let rates: Vec<[[f64; 2]; 3]> = RuleAssignment::all(2)
        .map(|rules| {
            [0, 1, 2].map(|place: usize| {
                let luck = conditions.with_seed(4 + place as u64);
                let scene = Scene::under(&station, &patterns[place], luck).unwrap();
                let outcome = simulate_rules(&scene, &rules).unwrap();
                [0, 1].map(|i| 60.0 * outcome.robots[i].picked as f64 / outcome.figures.end)
            })
        })
        .collect();
    for kind in [PayoffKind::Own, PayoffKind::Total] {
        let line = LineGame::new(&station, &patterns, kind, &conditions, &environment).unwrap();
        assert_eq!((line.patterns, line.independent), (3, 0));
        let value = |profile: usize, place: usize, robot: usize| match kind {
            PayoffKind::Own => rates[profile][place][robot],
            PayoffKind::Total => rates[profile][place].iter().sum(),
        };
        for (profile, robot) in (0..36).flat_map(|profile| [(profile, 0), (profile, 1)]) {
            let mean = (0..3)
                .map(|place| rates[profile][place][robot])
                .sum::<f64>()
                / 3.0;
            assert!((line.rates(profile)[robot].value() - mean).abs() < 1e-8);
            for action in 0..6 {
                let other = match robot {
                    0 => 6 * action + profile % 6,
                    _ => profile / 6 * 6 + action,
                };
                let gain = |p: usize| value(other, p, robot) - value(profile, p, robot);
                let gains = [0, 1, 2].map(gain);
                let mean = gains.iter().sum::<f64>() / 3.0;
                let squares: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
                let half = 4.302_652_730 * (squares / 2.0 / 3.0).sqrt();
                let found = line.gain_interval(profile, robot, action).unwrap();
                // The sum of squares about the mean is a difference, so half of its digits
                // may be lost.
                let near = (found.low - (mean - half)).abs() < 1e-5
                    && (found.high - (mean + half)).abs() < 1e-5;
                assert!(near, "{profile} {robot} {action}: {found:?} {mean} {half}");
            }
        }
    }
    let stopped = AtomicBool::new(true);
    let environment = Environment {
        stop: &stopped,
        progress: &Silent,
        ..Environment::QUIET
    };
    let kind = PayoffKind::Own;
    let told = LineGame::new(&station, &patterns, kind, &conditions, &environment).unwrap_err();
    assert!(told.to_string().contains("interrupted"), "{told}");
    assert_eq!((kind.name(), PayoffKind::Total.name()), ("own", "total"));
}

/// Of several assignments that are best for all one may be an equilibrium, whichever comes
/// first.
#[test]
fn any_of_the_best_assignments_may_be_an_equilibrium() {
    let station = built_in("paper").unwrap().station(Some(1)).unwrap();
    let patterns = [pickline::pattern::grid(station.belt().width, 0.2, 8).unwrap()];
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let (kind, plain) = (PayoffKind::Own, Conditions::default());
    let mut line = LineGame::new(&station, &patterns, kind, &plain, &environment).unwrap();
    let whole = |values: [i32; 6]| values.map(Payoff::whole).to_vec();
    // The robot is paid most under one rule, which alone is its equilibrium.
    for (payoffs, welfare, best, is_equilibrium) in [
        ([1, 2, 3, 9, 3, 3], [7, 6, 5, 7, 7, 0], 3, true),
        ([9, 2, 3, 1, 3, 3], [7, 6, 5, 7, 7, 0], 3, true),
        ([1, 9, 3, 2, 3, 3], [7, 6, 5, 7, 7, 0], 3, false),
    ] {
        let players = line.game.players().to_vec();
        line.game = Game::new(players, whole(payoffs), whole(welfare)).unwrap();
        let made = Provenance::new("pickline game", "paper", &station, "a grid", 1);
        let report = GameReport::new(&line, kind, 1, Vec::new(), made);
        assert_eq!(report.equilibria.len(), 1);
        assert_eq!(report.social_optimum.assignments.len(), best);
        assert_eq!(report.social_optimum.is_equilibrium, is_equilibrium);
    }
}
