//! Shares, every n-th item and zones: whose each item is, counted a second time, and what the checker
//! says of the runs.

use crate::common;
use nalgebra::Point2;
use pickline::allocation::Share;
use pickline::checker;
use pickline::decision::Outcome;
use pickline::kinematics::Arm;
use pickline::pattern::{ClassShares, Item, Pattern, poisson_disk, random_stream};
use pickline::sim::{Conditions, Disturbances, Scene, simulate};
use pickline::station::{Belt, Robot, Station, built_in};
use pickline::strategies::{parse, read_alone};
use proptest::prelude::*;

fn run(scene: &Scene, text: &str) -> Outcome {
    let robots = scene.station().robots().len();
    let strategy = read_alone(text, robots).unwrap();
    let outcome = simulate(scene, strategy.make().as_mut()).unwrap();
    let conditions = scene.conditions();
    if !conditions.is_random() {
        checker::check(scene.station(), scene.pattern(), &outcome).unwrap();
    }
    outcome
}

/// Three robots far apart that all reach the whole width; the arm of the first has this speed [m/s].
fn line_of_three(first: f64) -> Station {
    let robot = |place: usize, speed: f64| {
        let x = 1.5 + 2.5 * place as f64;
        let (base, bin) = (Point2::new(x, 0.3), Point2::new(x, 0.2));
        Robot::new(
            format!("r{}", place + 1),
            base,
            bin,
            1.0,
            Arm::constant(speed),
        )
        .with_dwell(0.1, 0.1)
    };
    let belt = Belt {
        speed: 0.1,
        length: 9.0,
        width: 0.4,
    };
    let robots = vec![robot(0, first), robot(1, 5.0), robot(2, 5.0)];
    Station::new(belt, robots).unwrap()
}

/// Items one after the other, so that each arrives alone.
fn procession(items: usize) -> Pattern {
    let item = |place: usize| {
        let y = [-0.1, 0.05, 0.15, -0.02][place % 4];
        Item::at(format!("i{place}"), -0.08 * place as f64, y)
    };
    Pattern::new((0..items).map(item).collect()).unwrap()
}

/// How many each of three robots picked.
fn picked(outcome: &Outcome) -> [usize; 3] {
    [0, 1, 2].map(|robot| outcome.robots[robot].picked)
}

/// A third each: the first gets 33 % of all items, and so do the others if nobody misses any.
#[test]
fn three_equal_shares_are_a_third_each_of_all_items() {
    let (station, pattern) = (line_of_three(5.0), procession(300));
    let scene = Scene::new(&station, &pattern).unwrap();
    for text in ["share:1,1,1", "share:33,33,33,feedback=yes", "every:3,2,1"] {
        let outcome = run(&scene, text);
        assert_eq!(picked(&outcome), [100, 100, 100], "{text}");
        // In turns, in order of arrival.
        for pick in &outcome.picks {
            let turn = match text {
                // The third item that it sees is the first robot's.
                "every:3,2,1" => [2, 1, 0][pick.robot],
                _ => pick.robot,
            };
            assert_eq!(pick.item as usize % 3, turn, "{text}");
        }
    }
    let uneven = run(&scene, "share:50,0,25");
    assert_eq!(picked(&uneven), [200, 0, 100]);
}

/// The first robot is too slow for its third. Without feedback the others have their thirds, with it
/// also half each of what the first left.
#[test]
fn what_the_first_robot_misses_goes_to_the_others_in_proportion() {
    let (station, pattern) = (line_of_three(0.15), procession(300));
    let scene = Scene::new(&station, &pattern).unwrap();
    let [first, second, third] = picked(&run(&scene, "share:1,1,1"));
    assert!((10..90).contains(&first), "{first}");
    assert_eq!([second, third], [100, 100]);

    // The second robot begins.
    let left = 100 - first;
    let fed_back = picked(&run(&scene, "share:1,1,1,feedback=yes"));
    assert_eq!(fed_back, [first, 100 + left.div_ceil(2), 100 + left / 2]);

    // In proportion to the shares: three to one of what is left, and of the rest.
    let [first, second, third] = picked(&run(&scene, "share:40,60,20"));
    assert_eq!([second, third], [150, 50]);
    let left = 100 - first;
    let [same, more, rest] = picked(&run(&scene, "share:40,60,20,feedback=yes"));
    assert_eq!(same, first);
    assert_eq!(more + rest, 200 + left);
    let due = 150.0 + 0.75 * left as f64;
    assert!((more as f64 - due).abs() < 1.0, "{more} of {due}");

    // A robot without a share gets nothing of what is left either.
    let [_, second, third] = picked(&run(&scene, "share:50,0,50,feedback=yes"));
    assert_eq!(second, 0);
    assert!(third > 150);
}

/// An item whose turn is that of a robot without a bin for it goes to one that has; unwanted items take
/// no turn.
#[test]
fn only_robots_with_a_bin_take_turns() {
    let station = built_in("sorting").unwrap().station(None).unwrap();
    let mut robots = station.robots().to_vec();
    // The first two robots take no paper.
    for robot in &mut robots[..2] {
        robot.bins.retain(|bin| bin.name != "paper");
    }
    let classes = station.classes().to_vec();
    let station = Station::new(*station.belt(), robots).unwrap();
    let station = station.with_classes(classes).unwrap();
    let classes: ClassShares = "pet:0.3,hdpe:0.2,paper:0.3,wood:0.2".parse().unwrap();
    let mut rng = random_stream(5, 0);
    let pattern = poisson_disk(station.belt().width, 0.25, 200, &mut rng).unwrap();
    let pattern = classes.apply(&pattern, &mut random_stream(5, 1)).unwrap();
    let scene = Scene::under(&station, &pattern, everything_in_view()).unwrap();
    let owners = owners(&station, &pattern, &[3, 2, 2, 1]);
    for (item, owner) in pattern.items().iter().zip(&owners) {
        let class = item.class.as_deref();
        assert_eq!(owner.is_none(), class == Some("wood"));
        assert!(class != Some("paper") || *owner > Some(1));
    }
    let outcome = run(&scene, "share:3,2,2,1");
    assert!(outcome.picks.len() > 100);
    for pick in &outcome.picks {
        assert_eq!(Some(pick.robot), owners[pick.item as usize]);
    }
}

fn everything_in_view() -> Conditions {
    Conditions::default().with_camera_x(-1e6)
}

/// Whose each item is, reckoned in whole numbers: the turn is that of the robot which, of those that can
/// take the item, is owed the most.
fn owners(station: &Station, pattern: &Pattern, weights: &[i64]) -> Vec<Option<usize>> {
    let mut owed = vec![0; weights.len()];
    let mut owner = |item: &Item| {
        let class = item.class_on(station);
        let robots = station.robots().iter().enumerate();
        let takes = |&(index, robot): &(usize, &Robot)| {
            let window = robot.widest_window(station.belt(), item.x0, item.y);
            station.bin_for(index, class).is_some() && window.is_some() && weights[index] > 0
        };
        let able: Vec<usize> = robots.filter(takes).map(|(index, _)| index).collect();
        if !station.takes(class) {
            return None;
        }
        for &robot in &able {
            owed[robot] += weights[robot];
        }
        let next = able
            .iter()
            .copied()
            .rev()
            .max_by_key(|&robot| owed[robot])?;
        owed[next] -= able.iter().map(|&robot| weights[robot]).sum::<i64>();
        Some(next)
    };
    pattern.items().iter().map(&mut owner).collect()
}

#[test]
fn zones_are_bands_from_the_lowest_y_up() {
    let (station, pattern) = (line_of_three(5.0), procession(120));
    let scene = Scene::new(&station, &pattern).unwrap();
    // Equal bands end at -0.0667 and 0.0667 m: of four items one, two and one.
    let equal = run(&scene, "zones");
    assert_eq!(picked(&equal), [30, 60, 30]);
    // An item on a border belongs to the band above it.
    let given = run(&scene, "zones:0.05,0.15");
    assert_eq!(picked(&given), [60, 30, 30]);
    let bands = [-0.2..0.05, 0.05..0.15, 0.15..0.2];
    for pick in &given.picks {
        let y = pattern.items()[pick.item as usize].y;
        assert!(bands[pick.robot].contains(&y), "{y} by {}", pick.robot);
    }
}

/// A robot counts what reaches it, which is what those upstream have left.
#[test]
fn every_robot_counts_what_reaches_it() {
    let (station, pattern) = (line_of_three(5.0), procession(240));
    let scene = Scene::new(&station, &pattern).unwrap();
    for (text, expected) in [
        ("every:1,1,1", [240, 0, 0]),
        ("every:2,2,2", [120, 60, 30]),
        ("every:4,3,1", [60, 60, 120]),
        ("every:300,5,300", [0, 48, 0]),
    ] {
        assert_eq!(picked(&run(&scene, text)), expected, "{text}");
    }
}

/// Among its own items, a robot follows its rule.
#[test]
fn rules_order_a_robots_own_items() {
    let station = line_of_three(0.5);
    let mut rng = random_stream(3, 0);
    let pattern = poisson_disk(0.4, 0.08, 120, &mut rng).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    // With all items, the order is that of the rules alone.
    let alone = |rule: &str| run(&scene, &format!("rules:{rule},{rule},{rule}")).picks;
    let first = |text: &str| {
        let picks = run(&scene, text).picks;
        let first = picks.into_iter().filter(|pick| pick.robot == 0);
        first.collect::<Vec<_>>()
    };
    for rule in ["FIFO", "SPT", "PP"] {
        let expected: Vec<_> = alone(rule).into_iter().filter(|p| p.robot == 0).collect();
        assert_eq!(first(&format!("share:1,0,0,rule={rule}")), expected);
        assert_eq!(first(&format!("every:1,9,9,rule={rule}+LD+LD")), expected);
        // Nothing lies beyond the first border.
        assert!(pattern.items().iter().all(|item| item.y < 0.1999));
        let zones = format!("zones:0.1999,0.19995,rule={rule}");
        assert_eq!(first(&zones), expected);
    }
    assert!(first("share:1,0,0") != first("share:1,0,0,rule=SPT"));
}

#[test]
fn types_and_texts_make_the_same_strategies() {
    let share = Share::new(vec![40.0, 60.0]).unwrap().with_feedback(true);
    let share = share.with_rules(vec!["SPT".parse().unwrap(), "FIFO".parse().unwrap()]);
    let name = "share:40,60,feedback=yes,rule=SPT+FIFO";
    assert_eq!(pickline::Strategy::name(&share), name);
    for (text, name) in [
        (name, name),
        ("share: 1.5 , 2,rule=FIFO,feedback=no", "share:1.5,2"),
        ("every:2,1,rule=spt", "every:2,1,rule=SPT"),
        ("zones", "zones"),
        ("zones:0.1", "zones:0.1"),
        ("zones:rule=LD", "zones:rule=LD"),
    ] {
        let blueprint = read_alone(text, 2).unwrap();
        assert_eq!(blueprint.name(), name);
        assert_eq!(blueprint.make().name(), name);
    }
}

/// Every message names the strategy, what is wrong, and what to write.
#[test]
fn wrong_values_name_place_problem_and_cure() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    for (text, place, problem, cure) in [
        ("share", "share", "no weight", "share:40,60"),
        ("share:", "share", "no weight", "share:40,60"),
        ("share:1", "share", "1 weight for 2 robots", "one weight"),
        (
            "share:1,2,3",
            "share",
            "3 weights for 2 robots",
            "one weight",
        ),
        ("share:-1,2", "share", "`-1` is not a valid value", "from 0"),
        ("share:NaN,2", "share", "`NaN` is not", "from 0 to 1e9"),
        ("share:inf,2", "share", "`inf` is not", "from 0 to 1e9"),
        ("share:1,,2", "share", "`` is not", "from 0 to 1e9"),
        ("share:0,0", "share", "every weight is 0", "above 0"),
        (
            "share:1,1,feedbak=yes",
            "share",
            "`feedbak`",
            "did you mean `feedback`",
        ),
        ("share:1,1,feedback=1", "share:feedback", "`1`", "yes or no"),
        ("share:1,1,rule=SPT,rule=SPT", "share:rule", "twice", "once"),
        (
            "share:1,1,rule=STP",
            "share:rule",
            "`STP`",
            "did you mean `SPT`",
        ),
        ("share:1,1,rule=", "share:rule", "no rule", "for example"),
        (
            "every:1,1,rule=SPT+LD+PP",
            "every:rule",
            "3 rules for 2 robots",
            "one for all",
        ),
        ("every:2", "every", "1 interval for 2 robots", "every:2,1"),
        ("every:0,1", "every", "`0`", "from 1"),
        (
            "every:1.5,1",
            "every",
            "`1.5` is not a whole number",
            "whole number",
        ),
        ("every", "every", "no interval", "every:2,1"),
        (
            "zones:0.1,0.2",
            "zones",
            "2 borders for 2 robots",
            "equal bands",
        ),
        (
            "zones:0.2,0.1",
            "zones",
            "do not increase",
            "increasing order",
        ),
        (
            "zones:0.1,0.1",
            "zones",
            "do not increase",
            "increasing order",
        ),
        ("zones:NaN", "zones", "`NaN`", "one border"),
        (
            "zones:0.9",
            "zones",
            "0.9 m is not on the belt",
            "between -0.525 and 0.525",
        ),
        (
            "zones:-0.525",
            "zones",
            "|y| <= 0.525 m",
            "without these ends",
        ),
    ] {
        let read = parse(text).and_then(|spec| spec.check_on(&station));
        let message = read.unwrap_err().to_string();
        for word in [&format!("'strategy' {place}:"), problem, cure] {
            assert!(message.contains(word), "{text}: {word} not in {message}");
        }
    }
    // A run checks the station too.
    let pattern = procession(3);
    let scene = Scene::new(&station, &pattern).unwrap();
    let strategy = read_alone("zones:0.9", 2).unwrap();
    let error = simulate(&scene, strategy.make().as_mut()).unwrap_err();
    assert!(error.to_string().contains("is not on the belt"), "{error}");
}

/// A strategy of each kind for a line of `robots` robots.
fn texts(robots: usize, width: f64) -> Vec<String> {
    let list = |value: &dyn Fn(usize) -> f64, count: usize| {
        let values: Vec<_> = (0..count).map(|i| value(i).to_string()).collect();
        values.join(",")
    };
    let weights = list(&|i| [3.0, 1.0, 2.0][i % 3], robots);
    let intervals = list(&|i| (robots - i) as f64, robots);
    let mut texts = vec![
        format!("share:{weights}"),
        format!("share:{weights},feedback=yes"),
        format!("share:{weights},feedback=yes,rule=SPT"),
        format!("every:{intervals}"),
        "zones".into(),
    ];
    if robots > 1 {
        let border = |i: usize| width * (0.8 * (i + 1) as f64 / robots as f64 - 0.45);
        texts.push(format!("zones:{}", list(&border, robots - 1)));
    }
    texts
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    /// The checker accepts all runs, a second one is the same, and without feedback every pick is by the
    /// robot whose turn it was.
    #[test]
    fn runs_are_valid_and_deterministic(
        (station, pattern, _) in prop_oneof![
            common::cases(common::lines(), 40),
            common::cases(common::stations(), 40),
        ],
    ) {
        let robots = station.robots().len();
        let scene = Scene::under(&station, &pattern, everything_in_view()).unwrap();
        for text in texts(robots, station.belt().width) {
            let outcome = run(&scene, &text);
            prop_assert_eq!(&outcome, &run(&scene, &text));
            if text.starts_with("share") && !text.contains("feedback") {
                let weights: Vec<i64> = (0..robots).map(|i| [3, 1, 2][i % 3]).collect();
                let owners = owners(&station, &pattern, &weights);
                for pick in &outcome.picks {
                    prop_assert_eq!(Some(pick.robot), owners[pick.item as usize]);
                }
            }
        }
        // With the camera at the belt's start.
        let scene = Scene::new(&station, &pattern).unwrap();
        for text in texts(robots, station.belt().width) {
            prop_assert_eq!(run(&scene, &text), run(&scene, &text));
        }
    }

    /// Items come back after failed grasps, and stand elsewhere than reported.
    #[test]
    fn runs_end_under_disturbances(
        (station, pattern, _) in common::cases(common::lines(), 40),
        seed in 0_u64..1000,
    ) {
        let disturbances = Disturbances::default()
            .with_position_noise(0.01)
            .with_grasp_failures(true)
            .with_default_p_grasp(0.6);
        let conditions = Conditions::default().with_disturbances(disturbances).with_seed(seed);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        for text in texts(station.robots().len(), station.belt().width) {
            let outcome = run(&scene, &text);
            prop_assert_eq!(&outcome, &run(&scene, &text));
            prop_assert!(outcome.picks.len() + outcome.missed.len() == pattern.len());
        }
    }
}
