//! Learning from the answers of an expert.

use crate::rl::{small, stations};
use pickline::nn::Adam;
use pickline::optimize::{Environment as Work, Silent};
use pickline::rl::domain::{Domain, scenes};
use pickline::rl::{Imitation, Plan, Round, Trainer};
use pickline::sim::simulate_rules;
use pickline::strategies::read_alone;
use std::sync::atomic::AtomicBool;

/// Imitates `rule` on a line of two robots as `plan` says; the trainer and its rounds.
fn imitate(rule: &str, plan: Plan) -> (Trainer, Vec<Round>) {
    let stop = AtomicBool::new(false);
    let work = Work {
        stop: &stop,
        progress: &Silent,
        ..Work::QUIET
    };
    let station = stations().remove(0);
    let mut trainer = Trainer::new(plan, vec![station], 1).unwrap();
    let mut rounds = Vec::new();
    let expert = |robots| read_alone(rule, robots);
    let report = |_: &Trainer, round: Round| {
        rounds.push(round);
        Ok(())
    };
    trainer.imitate(&expert, &work, report).unwrap();
    (trainer, rounds)
}

fn once(courses: usize) -> Option<Imitation> {
    Some(
        Imitation::of("FIFO,FIFO")
            .with_rounds(1)
            .with_courses(courses)
            .with_epochs(1),
    )
}

#[test]
fn a_rule_is_imitated() {
    let plan = small().with_imitation(
        Imitation::of("SPT,SPT")
            .with_rounds(3)
            .with_courses(60)
            .with_epochs(60),
    );
    let (_, rounds) = imitate("SPT,SPT", plan);
    // Which of the slots has the shortest time stands in the observation.
    assert!(rounds[2].agreement > 0.9, "{rounds:?}");
}

/// What the optimiser remembers of the answers would mislead its first steps in the phases.
#[test]
fn phases_begin_with_a_new_optimiser() {
    let plan = small().with_imitation(once(3));
    let fresh = Trainer::new(plan.clone(), stations(), 1).unwrap();
    let (trainer, _) = imitate("FIFO,FIFO", plan);
    assert!(trainer.parameters() != fresh.parameters());
    let expected = Adam::new(trainer.parameters().len(), 1e-5);
    // Moments of all parameters make no message.
    assert!(trainer.checkpoint().adam == expected);
}

/// Phases go from sparse patterns to dense ones; answers are asked for on all of them from the
/// first round on, as a network that begins with them needs no easy lessons.
#[test]
fn the_densest_patterns_are_among_those_that_the_expert_answers_on() {
    let courses = 12;
    let domain = Domain::BROAD
        .with_spacing((0.05, 0.7))
        .with_items((40, 40))
        .with_grids(1.0)
        .with_speed((1.0, 1.0))
        .with_curriculum(1.0);
    // A rule answers with a pick at every decision, so on sparse patterns once an item.
    let sparse = domain.draw(&stations()[..1], courses, 0.0, 1).unwrap();
    let rules = "FIFO,FIFO".parse().unwrap();
    for scene in scenes(&sparse).unwrap() {
        assert_eq!(simulate_rules(&scene, &rules).unwrap().figures.picked, 40);
    }
    let plan = small().with_imitation(once(courses)).with_domain(domain);
    let (_, rounds) = imitate("FIFO,FIFO", plan);
    let all = courses * 40;
    let answers = rounds[0].answers;
    assert!(
        (all / 4..all * 9 / 10).contains(&answers),
        "{answers} of {all}"
    );
}
