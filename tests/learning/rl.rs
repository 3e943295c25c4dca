//! The environment keeps its promises, and training finds what is known to be best.

use nalgebra::Point2;
use pickline::decision::observation::{Encoder, Layout, View};
use pickline::decision::{Action, Strategy};
use pickline::nn::{Activation, Architecture, Network, Shape};
use pickline::optimize::{Environment as Work, Silent};
use pickline::pattern::{Item, Pattern, random_stream};
use pickline::rl::domain::{Domain, scenes};
use pickline::rl::ppo::{GROUP, Group, Learner, PpoSettings};
use pickline::rl::{Batch, DispatchEnvironment, NetworkPlayer, Plan, Reward, Step, Trainer};
use pickline::sim::{Run, Scene, simulate};
use pickline::station::{Belt, Robot, Station, built_in};
use pickline::strategies::read_alone;
use rand::RngExt;
use std::sync::atomic::AtomicBool;

const LAYOUT: Layout = Layout {
    view: View::Full,
    slots: 16,
    wait: true,
};

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

pub fn stations() -> Vec<Station> {
    let make = |robots| built_in("paper").unwrap().station(Some(robots)).unwrap();
    vec![make(2), make(3)]
}

/// Plays random allowed actions; returns everything that came of it.
fn play(threads: usize) -> (Vec<f32>, Vec<Step>) {
    on_threads(threads, || {
        let domain = Domain::BROAD.with_items((10, 30));
        let courses = domain.draw(&stations(), 6, 1.0, 3).unwrap();
        let scenes = scenes(&courses).unwrap();
        let count = 40;
        let mut batch = Batch::new(&scenes, LAYOUT, Reward::PAPER, count, 5).unwrap();
        let mut observations = vec![0.0; count * LAYOUT.observation()];
        let mut masks = vec![false; count * LAYOUT.actions()];
        let nothing = Step {
            reward: 0.0,
            ended: None,
        };
        let mut steps = vec![nothing; count];
        let mut all = (Vec::new(), Vec::new());
        let mut rng = random_stream(1, 0);
        batch.reset(&mut observations, &mut masks);
        for _ in 0..100 {
            let draw = |mask: &[bool]| loop {
                let action = rng.random_range(0..mask.len());
                if mask[action] {
                    break action;
                }
            };
            let actions: Vec<usize> = masks.chunks(LAYOUT.actions()).map(draw).collect();
            batch
                .step(&actions, &mut observations, &mut masks, &mut steps)
                .unwrap();
            all.0.extend_from_slice(&observations);
            all.1.extend_from_slice(&steps);
        }
        all
    })
}

#[test]
fn batches_do_not_depend_on_the_number_of_threads() {
    let (one, two) = (play(1), play(2));
    assert!(
        one.0
            .iter()
            .zip(&two.0)
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
    assert_eq!(one.1, two.1);
    assert!(one.1.iter().any(|step| step.ended.is_some()));
    assert!(
        one.0
            .iter()
            .all(|value| value.is_finite() && value.abs() < 10.0)
    );
}

#[test]
fn rewards_are_those_of_the_figures() {
    let courses = Domain::BROAD.draw(&stations(), 2, 1.0, 1).unwrap();
    let scenes = scenes(&courses).unwrap();
    let reward = Reward {
        pick: 2.0,
        rate: 3.0,
    };
    let mut environment = DispatchEnvironment::new(&scenes, LAYOUT, reward, (1, 0)).unwrap();
    let mut observation = vec![0.0; LAYOUT.observation()];
    let mut mask = vec![false; LAYOUT.actions()];
    environment.reset(&mut observation, &mut mask);
    for _ in 0..3 {
        let mut sum = 0.0;
        let figures = loop {
            let step = environment.step(0, &mut observation, &mut mask).unwrap();
            sum += step.reward;
            if let Some(figures) = step.ended {
                break figures;
            }
        };
        let expected = 2.0 * figures.weight + 3.0 * figures.weighted_rate();
        assert!((sum - expected).abs() < 1e-9, "{sum} and {expected}");
    }
}

#[test]
fn illegal_actions_are_errors_and_change_nothing() {
    let courses = Domain::BROAD.draw(&stations(), 1, 1.0, 1).unwrap();
    let scenes = scenes(&courses).unwrap();
    let mut environment = DispatchEnvironment::new(&scenes, LAYOUT, Reward::PAPER, (1, 0)).unwrap();
    let mut observation = vec![0.0; LAYOUT.observation()];
    let mut mask = vec![false; LAYOUT.actions()];
    let early = environment.step(0, &mut observation, &mut mask);
    let message = early.unwrap_err().to_string();
    assert!(message.contains("no episode has begun"), "{message}");
    environment.reset(&mut observation, &mut mask);
    let before = (observation.clone(), mask.clone());
    let empty = mask.iter().position(|allowed| !allowed).unwrap();
    for action in [empty, LAYOUT.actions(), usize::MAX] {
        let refused = environment.step(action, &mut observation, &mut mask);
        let message = refused.unwrap_err().to_string();
        assert!(message.contains(&format!("action {action}")), "{message}");
        assert_eq!(before, (observation.clone(), mask.clone()));
    }
    environment.step(0, &mut observation, &mut mask).unwrap();
    let none = DispatchEnvironment::new(&[], LAYOUT, Reward::PAPER, (1, 0)).err();
    let message = none.unwrap().to_string();
    assert!(message.contains("or there are none"), "{message}");
}

/// Seeds are given again, actions are checked as a whole, and the last step of an episode can be the
/// last: what other programs' environments are made of.
#[test]
fn episodes_begin_when_the_caller_says_so() {
    let domain = Domain::BROAD.with_items((10, 30));
    let courses = domain.draw(&stations(), 6, 1.0, 3).unwrap();
    let scenes = scenes(&courses).unwrap();
    let streams = [(7, 0), (8, 0), (7, 0)];
    let mut batch = Batch::with_streams(&scenes, LAYOUT, Reward::PAPER, &streams).unwrap();
    let (size, actions) = (LAYOUT.observation(), LAYOUT.actions());
    let mut observations = vec![0.0; 3 * size];
    let mut masks = vec![false; 3 * actions];
    let early = batch.check_actions(&[0, 0, 0]).unwrap_err().to_string();
    assert!(early.contains("environment 0"), "{early}");
    batch.reset(&mut observations, &mut masks);
    assert_eq!(observations[..size], observations[2 * size..]);
    assert_ne!(observations[..size], observations[size..2 * size]);

    let empty = masks[2 * actions..].iter().position(|allowed| !allowed);
    let refused = batch.check_actions(&[0, 0, empty.unwrap()]).unwrap_err();
    for words in [
        "environment 2",
        "slots hold an item",
        "cure: choose an action",
    ] {
        assert!(refused.to_string().contains(words), "{refused}");
    }
    batch.check_actions(&[0, 0, 0]).unwrap();

    // The first of them ends and does not go on; its figures are those of the same steps in `step`.
    let (mut row, mut mask) = (vec![0.0; size], vec![false; actions]);
    let ended = loop {
        let one = &mut batch.environments()[0];
        let other = one.check_action(0).map(|()| one.items().len());
        assert_eq!(other.unwrap(), mask_of(one).iter().filter(|a| **a).count());
        let step = one.advance(0, &mut row, &mut mask).unwrap();
        if let Some(figures) = step.ended {
            break figures;
        }
    };
    assert!(row.iter().all(|value| *value == 0.0) && !mask.contains(&true));
    let one = &mut batch.environments()[0];
    assert_eq!(one.run().unwrap().figures(), ended);
    assert!(one.items().is_empty());
    let over = one.advance(0, &mut row, &mut mask).unwrap_err().to_string();
    assert!(over.contains("it is over"), "{over}");
    let twin = &mut batch.environments()[2];
    let figures = loop {
        if let Some(figures) = twin.step(0, &mut row, &mut mask).unwrap().ended {
            break figures;
        }
    };
    assert_eq!(figures, ended);
    assert!(mask.contains(&true));

    // Only the chosen one begins again, with its seed as at the start.
    let first = observations[..size].to_vec();
    batch.environments()[0].reseed((7, 0));
    let before = observations[size..].to_vec();
    observations[..size].fill(9.0);
    batch.reset_chosen(&[true, false, false], &mut observations, &mut masks);
    assert_eq!(observations[..size], first);
    assert_eq!(observations[size..], before);
}

/// The slots that hold an item now.
fn mask_of(environment: &mut DispatchEnvironment) -> Vec<bool> {
    let mut encoder = environment.encoder().clone();
    let snapshot = environment.run().unwrap().next_decision().unwrap();
    let (mut row, mut mask) = (
        vec![0.0; LAYOUT.observation()],
        vec![false; LAYOUT.actions()],
    );
    encoder.encode(&snapshot, &mut row, &mut mask);
    mask.truncate(LAYOUT.slots);
    mask
}

#[test]
fn rewards_are_finite() {
    for (pick, rate) in [(f64::NAN, 1.0), (1.0, f64::INFINITY)] {
        let message = Reward { pick, rate }.check().unwrap_err().to_string();
        assert!(message.contains("is not a finite number"), "{message}");
    }
    Reward::PAPER.check().unwrap();
}

#[test]
fn one_layout_serves_two_to_six_robots_of_either_side() {
    for robots in 1..=6 {
        let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
        let courses = Domain::BROAD.draw(&[station], 1, 1.0, 1).unwrap();
        let scene = courses[0].scene().unwrap();
        for layout in [LAYOUT, Layout::PAPER] {
            let mut encoder = Encoder::new(layout);
            let mut observation = vec![0.0; layout.observation()];
            let mut mask = vec![false; layout.actions()];
            let mut run = Run::new(&scene);
            while let Some(snapshot) = run.next_decision() {
                encoder.encode(&snapshot, &mut observation, &mut mask);
                assert!(observation.iter().all(|value| value.is_finite()));
                let action = encoder.action(&snapshot, 0).unwrap();
                assert_eq!(encoder.index_of(action), Some(0));
                run.act(action).unwrap();
            }
        }
    }
}

/// A small plan, so that a phase takes a moment.
pub fn small() -> Plan {
    let mut plan = Plan::preset("default").unwrap();
    plan.ppo = plan
        .ppo
        .with_n_envs(2 * GROUP)
        .with_n_steps(32)
        .with_batch_size(256);
    plan.architecture = Architecture::Scorer {
        width: 16,
        activation: Activation::Relu,
    };
    plan.domain.items = (10, 30);
    (plan.courses, plan.updates, plan.steps) = (8, 2, 10_000);
    plan
}

#[test]
fn training_goes_on_to_the_bit_from_a_checkpoint_on_any_number_of_threads() {
    let stop = AtomicBool::new(false);
    let work = Work {
        stop: &stop,
        progress: &Silent,
        ..Work::QUIET
    };
    let mut on_a_set = small();
    let domain = on_a_set.domain.with_items((12, 12)).with_curriculum(0.0);
    on_a_set.domain = domain.with_patterns("balanced:3".to_owned());
    let learned = [small(), on_a_set].map(|plan| {
        let whole = on_threads(1, || {
            let mut trainer = Trainer::new(plan.clone(), stations(), 7).unwrap();
            for _ in 0..3 {
                trainer.phase(&work).unwrap();
            }
            trainer.parameters().to_vec()
        });
        let parts = on_threads(2, || {
            let mut trainer = Trainer::new(plan, stations(), 7).unwrap();
            trainer.phase(&work).unwrap();
            let text = serde_json::to_string(&trainer.checkpoint()).unwrap();
            let checkpoint = serde_json::from_str(&text).unwrap();
            let mut trainer = Trainer::resume(checkpoint, stations()).unwrap();
            for _ in 0..2 {
                trainer.phase(&work).unwrap();
            }
            trainer.parameters().to_vec()
        });
        let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
        assert!(whole.iter().zip(&parts).all(same));
        whole
    });
    assert_ne!(learned[0], learned[1]);
}

/// One slow robot over the middle of the belt, between two rows. Items come in pairs,
/// side by side, and it has time for one of each pair: the heavy one.
fn trivial() -> (Station, Vec<Pattern>) {
    let belt = Belt {
        speed: 0.1,
        length: 2.0,
        width: 0.8,
    };
    let robot = Robot::new(
        "r1",
        Point2::new(1.0, 0.0),
        Point2::new(1.0, 0.0),
        1.0,
        pickline::kinematics::Arm::constant(1.0),
    )
    .with_dwell(25.0, 0.0);
    let station = Station::new(belt, vec![robot]).unwrap();
    let mut rng = random_stream(2, 0);
    let pattern = |_| {
        let mut items = Vec::new();
        for pair in 0..10 {
            let heavy = rng.random_range(0..2);
            for (row, y) in [-0.3, 0.3].into_iter().enumerate() {
                let mut item = Item::at(format!("{pair}.{row}"), -4.0 * f64::from(pair), y);
                item.weight = Some(if row == heavy { 1.0 } else { 0.2 });
                items.push(item);
            }
        }
        Pattern::new(items).unwrap()
    };
    (station, (0..20).map(pattern).collect())
}

/// The sum of rewards over all patterns.
fn total(scenes: &[Scene], make: impl Fn() -> Box<dyn Strategy>) -> f64 {
    let weights = scenes.iter().map(|scene| {
        let mut strategy = make();
        simulate(scene, strategy.as_mut()).unwrap().figures.weight
    });
    weights.sum()
}

#[test]
fn the_best_policy_of_a_trivial_station_is_found_exported_and_reloaded() {
    let (station, patterns) = trivial();
    let scenes: Vec<Scene> = patterns
        .iter()
        .map(|pattern| Scene::new(&station, pattern).unwrap())
        .collect();
    let layout = Layout {
        view: View::Full,
        slots: 4,
        wait: false,
    };
    let settings = PpoSettings::SB3
        .with_n_envs(2 * GROUP)
        .with_n_steps(64)
        .with_batch_size(256)
        .with_gamma(0.9)
        .with_learning_rate(2e-3);
    let reward = Reward {
        pick: 1.0,
        rate: 0.0,
    };
    let architecture = Architecture::Scorer {
        width: 16,
        activation: Activation::Relu,
    };
    let network = Network::new(&architecture, Shape::of(&layout));
    let parameters = network.initial(&mut random_stream(1, 0));
    let mut learner = Learner::new(network, parameters);
    let group = |first| Group::new(&scenes, layout, reward, (first * GROUP, GROUP), 1).unwrap();
    let mut groups = [group(0), group(1)];
    let mut rng = random_stream(1, 1);
    for _ in 0..20 {
        for group in &mut groups {
            group
                .collect(&learner.network, &learner.parameters, &settings)
                .unwrap();
        }
        learner.update(&groups, &settings, settings.learning_rate, &mut rng);
    }
    let best = 10.0 * scenes.len() as f64;
    let (network, parameters) = (&learner.network, &learner.parameters);
    let found: f64 = scenes
        .iter()
        .map(|scene| {
            let mut player = NetworkPlayer::new(network, parameters, layout);
            simulate(scene, &mut player).unwrap().figures.weight
        })
        .sum();
    assert!((found - best).abs() < 1e-9, "{found} of {best}");
    // PP, which takes the heaviest, does as well; to SPT both are the same.
    assert_eq!(total(&scenes, || read_alone("PP", 1).unwrap().make()), best);
    assert!(total(&scenes, || read_alone("SPT", 1).unwrap().make()) < best);

    #[cfg(feature = "onnx")]
    {
        use pickline::policy::{Metadata, Policy, PolicyStrategy, export};
        let metadata = Metadata::new(&layout);
        let bytes = export(network, parameters, &layout, &metadata);
        let policy = Policy::from_bytes(&bytes, "trivial.onnx").unwrap();
        for scene in &scenes {
            let picks = |strategy: &mut dyn Strategy| simulate(scene, strategy).unwrap().picks;
            let ours = picks(&mut NetworkPlayer::new(network, parameters, layout));
            assert_eq!(
                ours,
                picks(&mut PolicyStrategy::new("onnx".into(), &policy))
            );
        }
    }
}

/// The paper decides ten times a second.
#[test]
fn a_domain_decides_as_often_as_it_says() {
    let domain = Domain::BROAD.with_items((20, 20)).with_update_hz(10.0);
    let courses = domain.draw(&stations(), 4, 1.0, 9).unwrap();
    let mut decisions = 0;
    for scene in domain.scenes(&courses).unwrap() {
        let mut run = Run::new(&scene);
        while let Some(snapshot) = run.next_decision() {
            let tenths = snapshot.time * 10.0;
            assert!((tenths - tenths.round()).abs() < 1e-6, "{}", snapshot.time);
            decisions += 1;
            run.act(Action::Pick(0)).unwrap();
        }
    }
    assert!(decisions > 20);
    let wrong = domain.with_update_hz(f64::NAN);
    let message = wrong.scenes(&courses).err().unwrap().to_string();
    assert!(
        message.contains("'update_hz'") && message.contains("NaN"),
        "{message}"
    );
}
