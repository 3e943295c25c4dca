//! Live control against the simulator, with a station emulated message by message.

use crate::support::three::check_settled;
use crate::trouble::all_troubles;
use pickline::pattern::{ClassShares, Pattern, grid, poisson_disk, random_stream};
use pickline::sim::{Conditions, Scene, simulate};
use pickline::station::{Station, built_in};
use pickline::strategies::{Blueprint, read_alone};
use pickline_live::emulator::{Emulator, InjectedFaults};
use pickline_live::protocol::{Incoming, Outgoing, Status, encode};
use pickline_live::{ClockKind, Config, Controller};

fn station(name: &str, robots: usize) -> Station {
    built_in(name).unwrap().station(Some(robots)).unwrap()
}

fn controller(station: &Station, strategy: &Blueprint, min_detection: f64) -> Controller {
    let config = Config::default()
        .with_clock(ClockKind::Messages)
        .with_min_detection(min_detection);
    Controller::new(station.clone(), strategy.make(), config).unwrap()
}

/// What came of a whole run.
struct Live {
    input: Vec<Incoming>,
    output: Vec<Outgoing>,
    picked: Vec<(usize, String)>,
    broken: Vec<String>,
    status: Status,
}

fn live(
    station: &Station,
    pattern: &Pattern,
    strategy: &Blueprint,
    trouble: InjectedFaults,
) -> Live {
    live_above(station, pattern, strategy, trouble, 0.0)
}

/// The same, with items whose p_detection is below `min_detection` left on the belt.
fn live_above(
    station: &Station,
    pattern: &Pattern,
    strategy: &Blueprint,
    trouble: InjectedFaults,
    min_detection: f64,
) -> Live {
    let mut emulator = Emulator::new(station.clone(), pattern.clone(), trouble).unwrap();
    let mut controller = controller(station, strategy, min_detection);
    let (mut input, mut output) = (Vec::new(), Vec::new());
    let mut due = None;
    loop {
        let messages = emulator.round(due);
        if messages.is_empty() {
            break;
        }
        for message in messages {
            input.push(message.clone());
            controller
                .handle(message)
                .unwrap_or_else(|e| panic!("{}", e.message));
        }
        for message in controller.take_output() {
            output.push(message.clone());
            match message {
                Outgoing::Due(message) => due = message.next,
                other => emulator.receive(other),
            }
        }
    }
    Live {
        input,
        output,
        picked: emulator.picked().to_vec(),
        broken: emulator.broken_promises().to_vec(),
        status: controller.status(true, 0),
    }
}

/// Every item is accounted for, and no promise was broken.
fn accounts(live: &Live, items: usize) {
    assert!(live.broken.is_empty(), "{:?}", live.broken);
    check_settled(&live.status, items as u64);
}

/// The tasks are the picks of the simulation, to the bit.
fn equals_simulation(station: &Station, pattern: &Pattern, text: &str) {
    equals_simulation_above(station, pattern, text, 0.0);
}

/// The same, with items whose p_detection is below `min_detection` left on the belt.
fn equals_simulation_above(station: &Station, pattern: &Pattern, text: &str, min_detection: f64) {
    let strategy = read_alone(text, station.robots().len()).unwrap();
    let conditions = Conditions::default().with_min_detection(min_detection);
    let scene = Scene::under(station, pattern, conditions).unwrap();
    let outcome = simulate(&scene, strategy.make().as_mut()).unwrap();
    let faults = InjectedFaults::default();
    let run = live_above(station, pattern, &strategy, faults, min_detection);
    accounts(&run, pattern.len());
    let tasks = run.output.iter().filter_map(|message| match message {
        Outgoing::Task(task) => Some(task),
        _ => None,
    });
    let tasks: Vec<_> = tasks.collect();
    assert_eq!(tasks.len(), outcome.picks.len(), "{text}");
    for (task, pick) in tasks.iter().zip(&outcome.picks) {
        assert_eq!(
            task.robot,
            station.robots()[pick.robot].name,
            "{text}: {task:?}"
        );
        assert_eq!(
            task.item,
            pattern.items()[pick.item as usize].id,
            "{text}: {task:?}"
        );
        let bin = &station.robots()[pick.robot].bins[usize::from(pick.bin)];
        assert_eq!(
            (task.bin.x, task.bin.y),
            (bin.at.x, bin.at.y),
            "{text}: {task:?}"
        );
        let theirs = [
            task.start,
            task.meet_at,
            task.free_at,
            task.meet.x,
            task.meet.y,
        ];
        let ours = [
            pick.decide,
            pick.grasp,
            pick.release,
            pick.meet.x,
            pick.meet.y,
        ];
        assert_eq!(theirs, ours, "{text}");
    }
    let count = |name: &str| {
        let missed = outcome.missed.iter();
        missed.filter(|miss| miss.reason.name() == name).count() as u64
    };
    let missed = run.status.missed;
    assert_eq!(missed.unreachable, count("unreachable"), "{text}");
    let leaves = min_detection > 0.0 || station.leaves_items();
    let left = leaves.then_some(outcome.left.len() as u64);
    assert_eq!(run.status.unwanted, left, "{text}");
    assert_eq!(run.status.picked_share, outcome.figures.picked_share());
    assert_eq!(missed.passed_over, count("passed_over"), "{text}");
    assert_eq!(missed.busy, count("busy"), "{text}");
    assert_eq!(run.picked.len(), outcome.picks.len());
}

/// Arms that accelerate and lift, several bins by class, and items that are to be left.
#[test]
fn real_lines_pick_what_the_simulator_picks() {
    for name in ["delta", "sorting"] {
        let station = built_in(name).unwrap().station(None).unwrap();
        let robots = station.robots().len();
        let classes: ClassShares = "pet:0.3,hdpe:0.3,paper:0.2,wood:0.1".parse().unwrap();
        for pattern in patterns(&station, 120) {
            let pattern = classes.apply(&pattern, &mut random_stream(7, 1)).unwrap();
            for rule in ["SPT", "LPT", "LD", "PP"] {
                equals_simulation(
                    &station,
                    &pattern,
                    &format!("rules:{}", vec![rule; robots].join(",")),
                );
            }
            equals_simulation(&station, &pattern, "lookahead:budget=200");
            allocations_equal_simulation(&station, &pattern);
        }
    }
}

/// Shares, every n-th item and zones.
fn allocations_equal_simulation(station: &Station, pattern: &Pattern) {
    let robots = station.robots().len();
    let list = |value: &dyn Fn(usize) -> usize| {
        let values = (0..robots).map(|robot| value(robot).to_string());
        values.collect::<Vec<_>>().join(",")
    };
    let (weights, intervals) = (list(&|robot| 2 + robot % 2), list(&|robot| robots - robot));
    for text in [
        format!("share:{weights}"),
        format!("share:{weights},feedback=yes,rule=SPT"),
        format!("every:{intervals}"),
        "zones".into(),
    ] {
        equals_simulation(station, pattern, &text);
    }
}

/// Items that are too uncertain to be picked.
#[test]
fn uncertain_items_are_left_as_in_the_simulator() {
    let station = station("paper", 2);
    for pattern in patterns(&station, 60) {
        let mut items = pattern.items().to_vec();
        for (place, item) in items.iter_mut().enumerate() {
            item.p_detection = (place % 5 > 0).then_some(0.2 * (place % 5) as f64);
        }
        let pattern = Pattern::new(items).unwrap();
        for rules in ["SPT,FIFO", "PP,PP"] {
            equals_simulation_above(&station, &pattern, rules, 0.5);
        }
    }
}

fn patterns(station: &Station, items: usize) -> Vec<Pattern> {
    let width = station.belt().width;
    let disks = poisson_disk(width, 0.12, items, &mut random_stream(7, 0)).unwrap();
    vec![grid(width, 0.15, items).unwrap(), disks]
}

#[test]
fn all_rules_pick_what_the_simulator_picks() {
    for name in ["paper", "paper-narrow"] {
        let station = station(name, 2);
        for pattern in patterns(&station, 60) {
            for rules in pickline::dispatch::RuleAssignment::all(2) {
                let text = format!("rules:{}", rules.names().join(","));
                equals_simulation(&station, &pattern, &text);
            }
        }
    }
}

#[test]
fn a_thousand_items_on_lines_of_two_and_six() {
    for robots in [2, 6] {
        let station = station("paper", robots);
        for pattern in patterns(&station, 1000) {
            let text = pickline::strategies::default_strategy(robots);
            equals_simulation(&station, &pattern, &text);
        }
    }
}

#[test]
fn looking_ahead_picks_what_the_simulator_picks() {
    for name in ["paper", "paper-narrow"] {
        let station = station(name, 2);
        for pattern in patterns(&station, 60) {
            equals_simulation(&station, &pattern, "lookahead:budget=200");
        }
    }
}

/// Windows that are apart and ones that overlap, so that missed items are handed over within reach.
#[test]
fn allocations_pick_what_the_simulator_picks() {
    for name in ["paper", "paper-narrow"] {
        let apart = station(name, 3);
        let mut robots = apart.robots().to_vec();
        for (place, robot) in robots.iter_mut().enumerate() {
            let back = 1.5 * place as f64;
            robot.base.x -= back;
            robot.rest.x -= back;
            robot.bins[0].at.x -= back;
        }
        let close = Station::new(*apart.belt(), robots).unwrap();
        for station in [apart, close] {
            for pattern in patterns(&station, 80) {
                allocations_equal_simulation(&station, &pattern);
            }
        }
    }
}

#[cfg(feature = "onnx")]
#[test]
fn the_trained_policy_picks_what_the_simulator_picks() {
    for (name, robots, items) in [("paper", 2, 200), ("paper-narrow", 2, 60), ("paper", 6, 60)] {
        let station = station(name, robots);
        for pattern in patterns(&station, items) {
            equals_simulation(&station, &pattern, "onnx");
        }
    }
}

#[test]
fn trouble_costs_picks_and_nothing_else() {
    for (robots, text) in [
        (2, "SPT,FIFO"),
        (6, "SPT,SPT,SPT,SPT,SPT,FIFO"),
        (2, "lookahead:budget=100"),
    ] {
        let station = station("paper", robots);
        let items = if text.starts_with("look") { 200 } else { 1000 };
        for (pattern, seed) in patterns(&station, items).into_iter().zip(1..) {
            let strategy = read_alone(text, robots).unwrap();
            let plain = live(&station, &pattern, &strategy, InjectedFaults::default());
            let run = live(&station, &pattern, &strategy, all_troubles(seed));
            accounts(&run, items);
            let (least, most) = (0.6 * plain.status.picked as f64, plain.status.picked + 30);
            let picked = run.status.picked;
            assert!(
                picked as f64 > least && picked <= most,
                "{picked} {:?}",
                plain.status
            );
            // Every item in a bin is known to be there, save what a fault or a lost
            // result has left in doubt.
            let in_bins = run.picked.len() as u64;
            assert!(in_bins >= picked && in_bins <= picked + run.status.missed.no_result);
        }
    }
}

#[test]
fn a_recorded_stream_gives_the_same_output_to_the_bit() {
    let station = station("paper", 2);
    let pattern = &patterns(&station, 200)[1];
    let strategy = read_alone("lookahead:budget=100", 2).unwrap();
    let run = live(&station, pattern, &strategy, all_troubles(5));
    let text = |messages: &[Outgoing]| messages.iter().map(encode).collect::<String>();
    for _ in 0..2 {
        let mut controller = controller(&station, &strategy, 0.0);
        for message in &run.input {
            controller.handle(message.clone()).unwrap();
        }
        assert_eq!(text(&controller.take_output()), text(&run.output));
    }
}
