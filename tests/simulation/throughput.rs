//! Throughput: what a line makes in its steady state, whatever the belt behind it and the
//! length of the pattern.

use crate::common;
use pickline::experiment::{Method, Setting, sweep_settings};
use pickline::optimize::{Environment, Silent};
use pickline::pattern::{Item, Pattern, grid, poisson_disk, random_stream};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::{Belt, Station, built_in};
use pickline::throughput::{SteadyState, Throughput, Unsteady, UnsteadyReason, steady_state};
use std::sync::atomic::AtomicBool;

fn run(station: &Station, pattern: &Pattern, rules: &str) -> Result<SteadyState, Unsteady> {
    let scene = Scene::new(station, pattern).unwrap();
    let outcome = simulate_rules(&scene, &rules.parse().unwrap()).unwrap();
    steady_state(&scene, &outcome)
}

fn paper(robots: usize) -> Station {
    built_in("paper").unwrap().station(Some(robots)).unwrap()
}

/// Ten more metres of belt behind the last robot change nothing, to the bit.
#[test]
fn idle_belt_makes_no_difference() {
    let station = paper(2);
    let belt = *station.belt();
    let longer = Belt {
        length: belt.length + 10.0,
        ..belt
    };
    let longer = Station::new(longer, station.robots().to_vec()).unwrap();
    let pattern = grid(belt.width, 0.15, 1200).unwrap();
    let steady = run(&station, &pattern, "SPT,FIFO").unwrap();
    assert_eq!(steady, run(&longer, &pattern, "SPT,FIFO").unwrap());
    // The picking rate loses.
    let rate = |station: &Station| {
        let scene = Scene::new(station, &pattern).unwrap();
        simulate_rules(&scene, &"SPT,FIFO".parse().unwrap())
            .unwrap()
            .figures
            .picking_rate()
    };
    assert!(rate(&longer) < 0.8 * rate(&station));
    assert!(steady.throughput > rate(&station));
}

/// Patterns of one density agree within their intervals, however long they are.
#[test]
fn the_length_of_the_pattern_makes_no_difference() {
    let station = paper(2);
    let width = station.belt().width;
    let sets: [(&str, &dyn Fn(usize) -> Pattern); 2] = [
        ("SPT,FIFO", &|n| grid(width, 0.15, n).unwrap()),
        ("SPT,SPT", &|n| {
            poisson_disk(width, 0.12, n, &mut random_stream(3, 0)).unwrap()
        }),
    ];
    for (rules, pattern) in sets {
        let long = run(&station, &pattern(6000), rules).unwrap();
        let long = long.interval.unwrap();
        assert!(long.high - long.low < 0.05 * long.high, "{long:?}");
        for items in [600, 1200, 2400] {
            let interval = run(&station, &pattern(items), rules)
                .unwrap()
                .interval
                .unwrap();
            assert!(
                interval.low <= long.high && long.low <= interval.high,
                "{items}: {interval:?} beside {long:?}"
            );
        }
    }
}

/// On a line that has more to pick than it can, a further robot is worth nearly what the first is,
/// though the paper's rate, which counts the longer belt, says less and less.
#[test]
fn a_further_robot_is_worth_its_own_capacity() {
    let narrow = |robots| {
        built_in("paper-narrow")
            .unwrap()
            .station(Some(robots))
            .unwrap()
    };
    let width = narrow(1).belt().width;
    let patterns = [poisson_disk(width, 0.06, 4000, &mut random_stream(1, 0)).unwrap()];
    let setting = |robots: usize| Setting {
        value: robots as f64,
        station: narrow(robots),
        min_detection: None,
        methods: vec![Method::Robust(
            vec!["SPT"; robots].join(",").parse().unwrap(),
        )],
    };
    let settings: Vec<Setting> = (1..=5).map(setting).collect();
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let swept = sweep_settings(
        &settings,
        &patterns,
        &Conditions::default(),
        false,
        &environment,
    )
    .unwrap();
    let robust = swept.method("robust_gt").unwrap();
    let throughput: Vec<f64> = robust
        .points()
        .map(|(_, point)| point.throughput.mean.unwrap())
        .collect();
    for pair in throughput.windows(2) {
        // SPT leaves the later robots the items that are further from their bins.
        let worth = (pair[1] - pair[0]) / throughput[0];
        assert!((0.7..1.05).contains(&worth), "{throughput:?}");
    }
    assert_eq!(robust.recommended(), Some(5.0));
}

/// A line that picks everything makes what arrives; the columns of a grid are counted whole.
#[test]
fn a_line_that_keeps_up_makes_the_flow() {
    let station = paper(4).with_belt_speed(0.02).unwrap();
    let pattern = grid(station.belt().width, 0.3, 400).unwrap();
    let steady = run(&station, &pattern, "SPT,SPT,SPT,SPT").unwrap();
    // Four rows every 0.3 m at 0.02 m/s.
    assert!((steady.flow - 16.0).abs() < 1e-9, "{}", steady.flow);
    assert!(
        (steady.throughput - 16.0).abs() < 1e-9,
        "{}",
        steady.throughput
    );
    let busy: f64 = steady.utilisation.iter().sum();
    assert!(
        busy > 0.1
            && steady
                .utilisation
                .iter()
                .all(|share| (0.0..=1.0).contains(share))
    );
}

/// One robot, items in single file, FIFO, at flows about what it can pick: the queue grows for
/// long. Whatever the length of the pattern, there is the throughput of a very long one or
/// none.
#[test]
fn a_growing_queue_is_not_a_steady_state() {
    let station = paper(1);
    let file = |flow: f64, items: usize| {
        let gap = 60.0 * station.belt().speed / flow;
        let item = |i: usize| Item::at(i.to_string(), -gap * i as f64, 0.0);
        Pattern::new((0..items).map(item).collect()).unwrap()
    };
    let mut without = 0;
    for flow in [20.0, 20.7, 21.7, 23.7, 29.6] {
        let long = run(&station, &file(flow, 4000), "FIFO").unwrap();
        for items in [100, 150, 200, 300, 500, 1000] {
            match run(&station, &file(flow, items), "FIFO") {
                Ok(steady) => assert!(
                    (steady.throughput / long.throughput - 1.0).abs() < 0.04,
                    "{flow}, {items}: {} beside {}",
                    steady.throughput,
                    long.throughput
                ),
                Err(_) => without += 1,
            }
        }
    }
    assert!((5..=25).contains(&without), "{without}");
}

/// Where there is no steady state there is no figure, but the reason and a number of items
/// that is enough.
#[test]
fn short_patterns_have_none_and_say_what_is_enough() {
    let station = paper(2);
    let width = station.belt().width;
    let none = run(&station, &grid(width, 0.15, 50).unwrap(), "SPT,FIFO").unwrap_err();
    assert!((none.flow.unwrap() - 160.0).abs() < 1e-9);
    let UnsteadyReason::Short {
        items: Some(items), ..
    } = none.reason
    else {
        panic!("{none:?}");
    };
    assert!(
        none.reason
            .to_string()
            .contains(&format!("give {items} items"))
    );
    run(&station, &grid(width, 0.15, items).unwrap(), "SPT,FIFO").unwrap();
    // A single column, a single item.
    for pattern in [grid(width, 0.15, 8).unwrap(), grid(width, 0.15, 1).unwrap()] {
        let none = run(&station, &pattern, "SPT,FIFO").unwrap_err();
        assert_eq!(none.flow, None);
        assert!(
            none.reason.to_string().contains("give a longer one"),
            "{}",
            none.reason
        );
    }
    // Of several patterns half must have one.
    let steady = run(&station, &grid(width, 0.15, items).unwrap(), "SPT,FIFO");
    let all = |runs: &[&Result<SteadyState, Unsteady>]| Throughput::of(runs.iter().copied());
    let none = Err(none);
    assert!(all(&[&steady, &none]).mean.is_some());
    let few = all(&[&steady, &none, &none]);
    assert_eq!((few.mean, few.steady, few.runs), (None, 1, 3));
    assert!(few.missing.is_some() && few.utilisation.is_empty());
}

/// A pattern of two bunches has items in its run-in and its run-out only, however long it lasts.
#[test]
fn bunches_far_apart_have_no_steady_state() {
    let station = paper(2);
    for (near, far) in [(1, 1), (2, 1), (1, 2), (10, 10)] {
        let bunch = |count: u32, x: f64| {
            (0..count).map(move |i| {
                let x = x - 0.05 * f64::from(i);
                Item::at(format!("{x}"), x, 0.0)
            })
        };
        let items = bunch(near, 0.0).chain(bunch(far, -50.0)).collect();
        let none = run(&station, &Pattern::new(items).unwrap(), "SPT,FIFO").unwrap_err();
        assert!(
            matches!(none.reason, UnsteadyReason::Bunched { .. }),
            "{near} {far}: {none:?}"
        );
        assert!(none.reason.to_string().contains("items in between"));
    }
}

/// A robot that meets every item at the same place, but for some at either end of the pattern
/// that it misses: these are cut off in batches of five, by docs/model.md, step 2.
#[test]
fn run_in_and_run_out_are_cut_off() {
    let station = paper(1);
    // Far enough apart for each to leave the longest window before the next one arrives.
    let apart = 2.0 * station.robots()[0].reach + 0.1;
    let item = |i: usize| Item::at(i.to_string(), -apart * i as f64, 0.0);
    let pattern = Pattern::new((0..103).map(item).collect()).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let mut settled = simulate_rules(&scene, &"FIFO".parse().unwrap()).unwrap();
    assert_eq!(settled.picks.len(), 103);
    for pick in &mut settled.picks {
        pick.meet.x = station.robots()[0].base.x;
    }
    // By numbers of items, at the beginning and at the end.
    let without = |missed: &[std::ops::Range<u32>; 2]| {
        let mut outcome = settled.clone();
        let is_missed = |item: u32| missed.iter().any(|missed| missed.contains(&item));
        outcome.picks.retain(|pick| !is_missed(pick.item));
        outcome
    };
    // Without the first item and the last two, which step 1 leaves out: 100 of them.
    for (missed, items) in [
        ([0..0, 0..0], 1..101),
        ([1..21, 0..0], 21..101),
        ([0..0, 81..101], 1..81),
        ([1..11, 91..101], 11..91),
        // What fills no batch takes its batch along.
        ([0..0, 88..101], 1..86),
    ] {
        let steady = steady_state(&scene, &without(&missed)).unwrap();
        assert_eq!(steady.items, items, "{missed:?}");
        assert_eq!(steady.picked, items.len());
        assert!((steady.throughput - steady.flow).abs() < 1e-9);
    }
    // Cuts of 20 items, by where they are met, and of 35 together leave less than half.
    let mut outcome = without(&[0..0, 66..101]);
    for pick in &mut outcome.picks[1..21] {
        pick.meet.x -= 100.0;
    }
    let unsettled = steady_state(&scene, &outcome).unwrap_err();
    assert_eq!(unsettled.reason, UnsteadyReason::Drifting { items: 206 });
}

/// Everything out of reach, noise, failures and a camera are no exceptions.
#[test]
fn conditions_are_tried_like_other_settings() {
    let station = paper(2);
    let width = station.belt().width;
    let pattern = grid(width, 0.15, 1600).unwrap();
    let conditions = Conditions::default().with_camera_x(0.2).with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.8)
            .with_position_noise(0.004)
            .with_seed(5),
    );
    let scene = Scene::under(&station, &pattern, conditions).unwrap();
    let outcome = simulate_rules(&scene, &"SPT,FIFO".parse().unwrap()).unwrap();
    let steady = steady_state(&scene, &outcome).unwrap();
    let plain = run(&station, &pattern, "SPT,FIFO").unwrap();
    assert!(steady.throughput < 0.95 * plain.throughput);
    assert!(
        steady
            .utilisation
            .iter()
            .all(|share| (0.8..=1.0).contains(share))
    );
    let far = Item::at("a", 0.0, 0.5);
    let mut robot = station.robots()[0].clone();
    (robot.reach, robot.base.y) = (0.1, -1.0);
    let out_of_reach = Station::new(*station.belt(), vec![robot]).unwrap();
    let items = (0..200).map(|i| Item {
        id: i.to_string(),
        x0: -0.1 * f64::from(i),
        ..far.clone()
    });
    let steady = run(
        &out_of_reach,
        &Pattern::new(items.collect()).unwrap(),
        "SPT",
    )
    .unwrap();
    assert_eq!((steady.throughput, steady.picked), (0.0, 0));
}

/// All CSV files of all verbs: provenance once, in comment lines that readers skip, and
/// columns in snake case, each once.
#[test]
fn csv_files_have_one_scheme() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let trace = folder.path().join("trace.csv");
    let to = ["-q", "--out", out.to_str().unwrap()];
    let calls: [&[&str]; 6] = [
        &["simulate", "--trace", trace.to_str().unwrap()],
        &["bound"],
        &[
            "compare",
            "--robust",
            "SPT,FIFO",
            "--replicates",
            "2",
            "--no-policy",
        ],
        &[
            "sweep", "--robust", "SPT,FIFO", "--from", "0.04", "--to", "0.05",
        ],
        &[
            "optimize",
            "--patterns",
            "balanced:4",
            "--items",
            "20",
            "--validate",
            "2",
            "--strategy",
            "SD,FIFO",
        ],
        &["game", "--patterns", "balanced:4"],
    ];
    for call in calls {
        let verb = format!("# pickline {}", call[0]);
        let printed = common::text(&[call, &to, &["--format", "csv"]].concat());
        assert!(printed.starts_with(&verb), "{printed}");
    }
    let files = std::fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|e| e == "csv"));
    let files: Vec<_> = files.chain([trace]).collect();
    assert!(files.len() >= 11, "{files:?}");
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let comments = text
            .lines()
            .take_while(|line| line.starts_with("# "))
            .count();
        assert!(comments >= 5 && !text.lines().skip(comments).any(|l| l.starts_with('#')));
        let rows = common::csv_rows(&text);
        for name in &rows[0] {
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            assert!(
                name.chars().all(plain) && name != "made",
                "{name} in {}",
                file.display()
            );
            assert_eq!(rows[0].iter().filter(|other| *other == name).count(), 1);
        }
        assert!(
            !rows[0].iter().any(|name| name.starts_with("weighted")),
            "{}",
            file.display()
        );
    }
    // Seeds are whole numbers, also of what is not random.
    let runs = std::fs::read_to_string(out.join("runs.csv")).unwrap();
    for seed in common::csv_column(&runs, "pattern_seed") {
        seed.parse::<u64>().unwrap();
    }
}

/// Columns are called by what they hold, and none is empty throughout.
#[test]
fn csv_columns_are_named_by_the_objective_and_none_is_blank() {
    let optimize = ["optimize", "-q", "--patterns", "grid:0.2", "--items", "20"];
    for (objective, name) in [
        ("picking-rate", "picking_rate_mean_per_min"),
        ("picked-share", "picked_share_mean"),
        ("max-speed", "max_speed_mean_m_per_s"),
    ] {
        let of = ["--robots", "1", "--objective", objective, "--format", "csv"];
        let rows = common::csv_rows(&common::text(&[&optimize[..], &of].concat()));
        assert!(rows[0].iter().any(|column| column == name), "{:?}", rows[0]);
        no_blank_column(&rows);
    }
    let sweep = ["sweep", "-q", "--robust", "SPT,FIFO", "--no-bound"];
    let few = ["--from", "0.04", "--to", "0.05", "--format", "csv"];
    let text = common::text(&[&sweep[..], &few].concat());
    no_blank_column(&common::csv_rows(&text));
}

fn no_blank_column(rows: &[Vec<String>]) {
    for (place, name) in rows[0].iter().enumerate() {
        assert!(rows[1..].iter().any(|row| !row[place].is_empty()), "{name}");
    }
}

/// A limit on fifty items is theirs and not that of the line, which a sweep says with the
/// cure; on longer patterns it is lower and nothing is said.
#[test]
fn a_limit_on_a_short_pattern_is_said_to_be_the_patterns() {
    let sweep = ["sweep", "-q", "--robust", "SPT,FIFO", "--no-bound"];
    let to = ["--from", "0.01", "--to", "0.06", "--step", "0.002"];
    let short = common::text(&[&sweep[..], &to].concat());
    assert!(short.contains("is that of the patterns"), "{short}");
    assert!(short.contains("items or more (--items)"), "{short}");
    let long = common::text(&[&sweep[..], &to, &["--items", "3000"]].concat());
    assert!(!long.contains("is that of the patterns"), "{long}");
}

/// The page of a comparison begins with throughput where there is one.
#[test]
fn the_page_of_a_comparison_begins_with_throughput() {
    let folder = tempfile::tempdir().unwrap();
    let html = folder.path().join("compare.html");
    let cases = folder.path().join("cases.toml");
    let case = "[[case]]\nname = \"long\"\ngrid = 0.15\nitems = 800\n";
    std::fs::write(&cases, case).unwrap();
    let compare = ["compare", "-q", "--robust", "SPT,FIFO", "--no-policy"];
    let of = ["--cases", cases.to_str().unwrap(), "--no-bound", "--html"];
    common::text(&[&compare[..], &of, &[html.to_str().unwrap()]].concat());
    let page = std::fs::read_to_string(html).unwrap();
    assert!(page.contains("has a throughput of <"));
    let place = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    assert!(place(">Throughput<") < place(">Picking rate<"));
}
