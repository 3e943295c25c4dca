//! What detections are worth (`docs/real-lines.md`), written down a second time: who is foreign, what is
//! binned rightly and what is due; and what a threshold leaves on the belt.

use crate::real_lines::common_real_lines::{patterns, stations};
use pickline::checker;
use pickline::decision::{LeftItem, LeftReason, Outcome};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Item, Pattern};
use pickline::purity::{BinContent, bin_contents};
use pickline::sim::{
    Cascade, Conditions, Disturbances, Scene, TrueClass, simulate, simulate_rules,
};
use pickline::station::{Station, built_in};
use pickline::strategies::read_alone;
use proptest::prelude::*;

/// Detections that may be wrong, from this seed.
fn wrong(seed: u64) -> Conditions {
    Conditions::default().with_disturbances(
        Disturbances::default()
            .with_misdetections(true)
            .with_seed(seed),
    )
}

/// The pattern with some `p_detection` and some true classes.
fn doubtful(pattern: &Pattern, choices: &[usize]) -> Pattern {
    const P: [Option<f64>; 5] = [Some(0.5), None, Some(0.0), Some(1.0), Some(0.8)];
    const TRUE: [Option<&str>; 8] = [
        None,
        Some("pet"),
        None,
        Some("-"),
        None,
        Some("other"),
        Some("hdpe"),
        Some("wood"),
    ];
    let items = pattern.items().iter().zip(choices.iter().cycle());
    let items = items.map(|(item, choice)| Item {
        p_detection: P[choice % 5],
        true_class: TRUE[choice / 5 % 8].map(str::to_owned),
        ..item.clone()
    });
    Pattern::new(items.collect()).unwrap()
}

fn rules(numbers: &[usize], robots: usize) -> RuleAssignment {
    let all = ["FIFO", "SPT", "LPT", "SD", "LD", "PP"];
    let names: Vec<&str> = numbers
        .iter()
        .cycle()
        .take(robots)
        .map(|n| all[n % 6])
        .collect();
    names.join(",").parse().unwrap()
}

/// What each item truly is, by the text: a class (which may be none), or nothing. Only the coin is
/// the engine's.
fn truths(items: &[Item], conditions: &Conditions) -> Vec<Option<Option<String>>> {
    let coin = |index: u32, item: &Item| {
        let bare = Item {
            p_detection: item.p_detection,
            ..Item::at("x", 0.0, 0.0)
        };
        conditions.disturbances.true_class(index, &bare) == TrueClass::Of(None)
    };
    let truth = |(item, index): (&Item, u32)| match &item.true_class {
        Some(recorded) if recorded == "-" => None,
        Some(recorded) => Some(Some(recorded.clone())),
        None if item.p_detection == Some(0.0) => None,
        None if item.p_detection.is_none_or(|p| p == 1.0) => Some(item.class.clone()),
        None => coin(index, item).then(|| item.class.clone()),
    };
    items.iter().zip(0..).map(truth).collect()
}

/// The content of all bins, and of those with one name, counted as the text says.
fn counted(
    station: &Station,
    truths: &[Option<Option<String>>],
    outcome: &Outcome,
    bin: Option<&str>,
) -> BinContent {
    let unwanted = |class: &Option<String>| {
        let mut classes = station.classes().iter();
        classes.any(|stated| Some(&stated.name) == class.as_ref() && !stated.wanted)
    };
    let mut content = BinContent::default();
    for class in truths.iter().flatten() {
        let mut robots = station.robots().iter();
        let goes_there = |place: usize, robot: &pickline::Robot| {
            bin.is_none_or(|name| robot.bins[place].name == name)
        };
        let due = robots.any(|robot| {
            let place = robot.bin_for(class.as_deref());
            place.is_some_and(|place| goes_there(place, robot))
        });
        content.due += usize::from(due && !unwanted(class));
    }
    for pick in &outcome.picks {
        let into = &station.robots()[pick.robot].bins[usize::from(pick.bin)];
        if bin.is_some_and(|name| into.name != name) {
            continue;
        }
        content.binned += 1;
        let Some(class) = &truths[pick.item as usize] else {
            continue;
        };
        let own = station.robots()[pick.robot].bin_for(class.as_deref());
        let right = own == Some(usize::from(pick.bin)) && !unwanted(class);
        content.rightly_binned += usize::from(right);
    }
    content
}

/// A line with its pattern, numbers that say which rules and doubts there are, and a seed.
fn cases() -> impl Strategy<Value = (Station, Pattern, Vec<usize>, u64)> {
    let numbers = prop::collection::vec(0..1000usize, 1..60);
    (stations(), numbers, any::<u64>()).prop_flat_map(|(station, numbers, seed)| {
        let width = station.belt().width;
        (
            Just(station),
            patterns(width, 40),
            Just(numbers),
            Just(seed),
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn bins_hold_what_the_transcription_counts((station, pattern, numbers, seed) in cases()) {
        let pattern = doubtful(&pattern, &numbers);
        let (items, conditions) = (pattern.items(), wrong(seed));
        let rules = rules(&numbers, station.robots().len());
        let scene = Scene::under(&station, &pattern, wrong(seed)).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        let found = bin_contents(&scene, &outcome.picks);
        let truths = truths(items, &conditions);
        prop_assert_eq!(found.total, counted(&station, &truths, &outcome, None));
        prop_assert_eq!(found.total.binned, outcome.picks.len());
        for (name, content) in &found.bins {
            let expected = counted(&station, &truths, &outcome, Some(name));
            prop_assert_eq!(*content, expected, "{}", name);
            prop_assert!(content.rightly_binned <= content.binned.min(content.due));
        }
        let binned: usize = found.bins.iter().map(|bin| bin.1.binned).sum();
        prop_assert_eq!(binned, found.total.binned);
        // No strategy learns of it, and nothing else comes of it.
        let plain = Scene::new(&station, &pattern).unwrap();
        prop_assert_eq!(simulate_rules(&plain, &rules).unwrap(), outcome);
        prop_assert_eq!(Cascade::new(&plain).is_some(), Cascade::new(&scene).is_some());
    }

    /// Whatever is below a threshold might as well not be there.
    #[test]
    fn a_threshold_is_a_pattern_without_the_uncertain(
        (station, pattern, numbers, _) in cases(),
        least in prop_oneof![Just(0.0), Just(1.0), Just(0.8), 0.0..=1.0f64],
    ) {
        let pattern = doubtful(&pattern, &numbers);
        let conditions = Conditions::default().with_min_detection(least);
        let rules = rules(&numbers, station.robots().len());
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        checker::check(&station, &pattern, &outcome).unwrap();
        let certain = |item: &&Item| item.p_detection.is_none_or(|p| p >= least);
        let certain: Vec<Item> = pattern.items().iter().filter(certain).cloned().collect();
        let ids = |pattern: &Pattern, outcome: &Outcome| -> Vec<_> {
            let picks = outcome.picks.iter();
            let id = |item: u32| pattern.items()[item as usize].id.clone();
            picks.map(|pick| (id(pick.item), pick.robot, pick.bin, pick.release)).collect()
        };
        if let Some(mut cascade) = Cascade::new(&scene) {
            prop_assert_eq!(cascade.run(rules.rules()).picked, outcome.figures.picked);
        }
        let Ok(rest) = Pattern::new(certain) else {
            prop_assert_eq!((outcome.picks.len(), outcome.figures.items), (0, 0));
            prop_assert_eq!(outcome.figures.end, 0.0);
            return Ok(());
        };
        let plain = simulate_rules(&Scene::new(&station, &rest).unwrap(), &rules).unwrap();
        prop_assert_eq!(ids(&pattern, &outcome), ids(&rest, &plain));
        prop_assert_eq!(outcome.figures, plain.figures);
        let left = |reason| outcome.left.iter().filter(move |left| left.reason == reason);
        let low = left(LeftReason::LowDetection).count();
        prop_assert_eq!(pattern.len() - plain.figures.items - outcome.left.len() + low, low);
    }
}

/// Looking ahead counts how certain a detection is, but does not learn what the item truly is.
#[test]
fn looking_ahead_is_the_same_whatever_items_truly_are() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let grid = pickline::pattern::grid(station.belt().width, 0.15, 60).unwrap();
    let pattern = doubtful(&grid, &[0, 4, 5, 15, 22]);
    let hidden = pattern.items().iter().map(|item| Item {
        true_class: None,
        ..item.clone()
    });
    let unknown = Pattern::new(hidden.collect()).unwrap();
    let run = |pattern: &Pattern, conditions: Conditions| {
        let scene = Scene::under(&station, pattern, conditions).unwrap();
        let blueprint = read_alone("lookahead", 2).unwrap();
        simulate(&scene, blueprint.make().as_mut()).unwrap()
    };
    let outcome = run(&pattern, wrong(3));
    assert_eq!(run(&pattern, wrong(4)), outcome);
    assert_eq!(run(&unknown, wrong(3)), outcome);
    assert_ne!(run(&pattern, Conditions::default()).picks, outcome.picks);
}

/// By hand: a threshold is inclusive, and items without a probability are certain.
#[test]
fn items_at_the_threshold_are_picked() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let item = |id: &str, p_detection, x0| Item {
        p_detection,
        ..Item::at(id, x0, 0.0)
    };
    let items = vec![
        item("at", Some(0.6), 0.0),
        item("below", Some(0.59), -0.5),
        item("unknown", None, -1.0),
    ];
    let pattern = Pattern::new(items).unwrap();
    let conditions = Conditions::default().with_min_detection(0.6);
    let scene = Scene::under(&station, &pattern, conditions).unwrap();
    let outcome = simulate_rules(&scene, &"FIFO,FIFO".parse().unwrap()).unwrap();
    let picked: Vec<u32> = outcome.picks.iter().map(|pick| pick.item).collect();
    assert_eq!(picked, [0, 2]);
    let (item, reason) = (1, LeftReason::LowDetection);
    assert_eq!(outcome.left, [LeftItem { item, reason }]);
    assert_eq!(reason.name(), "low_detection");
    assert_eq!((outcome.figures.items, outcome.figures.picked), (2, 2));
}

/// The checker asks whether some threshold explains what was left.
#[test]
fn the_checker_refutes_items_left_without_a_threshold() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let refuted = |p: [Option<f64>; 2]| {
        let item = |(id, p_detection)| Item {
            p_detection,
            ..Item::at(id, if id == "a" { 0.0 } else { -0.5 }, 0.0)
        };
        let pattern = Pattern::new(["a", "b"].into_iter().zip(p).map(item).collect()).unwrap();
        let only_first = Pattern::new(vec![pattern.items()[0].clone()]).unwrap();
        let scene = Scene::new(&station, &only_first).unwrap();
        let mut outcome = simulate_rules(&scene, &"FIFO,FIFO".parse().unwrap()).unwrap();
        outcome.left.push(LeftItem {
            item: 1,
            reason: LeftReason::LowDetection,
        });
        let checked = checker::check(&station, &pattern, &outcome);
        checked.err().map(|error| error.to_string())
    };
    assert_eq!(refuted([Some(0.6), Some(0.5)]), None);
    assert_eq!(refuted([None, Some(0.5)]), None);
    for p in [
        [Some(0.5), Some(0.5)],
        [Some(0.5), Some(0.6)],
        [Some(0.5), None],
        [None, None],
    ] {
        let told = refuted(p).unwrap();
        assert!(told.contains("is left as too uncertain"), "{told}");
    }
}
