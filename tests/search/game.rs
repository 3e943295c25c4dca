//! `pickline game`: the game of a line, what is found in it, and what is printed.

use crate::common;
use pickline::dispatch::RuleAssignment;
use pickline::optimize::game::{Game, Payoff, Player, equilibria};
use pickline::pattern::Pattern;
use pickline::sim::{AssignmentTree, Cascade, Scene, simulate_rules};
use pickline::station::{Station, built_in};
use pickline_report::nfg_text;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

fn pickline(arguments: &[&str]) -> Output {
    common::pickline(&[&["game"], arguments].concat())
}

fn text(arguments: &[&str]) -> String {
    common::text(&[&["game"], arguments].concat())
}

fn solved(arguments: &[&str]) -> Value {
    let all = [arguments, &["-q", "--format", "json"]].concat();
    serde_json::from_str(&text(&all)).unwrap()
}

/// Picks of each robot by the tree are those of the event loop, wherever windows lie.
fn picks_agree(station: &Station, pattern: &Pattern) -> bool {
    let scene = Scene::new(station, pattern).unwrap();
    let robots = station.robots().len();
    // Whole lines and shorter ones, of which the rest stands idle.
    let some = |n: usize| RuleAssignment::all(n).step_by(1 + 6usize.pow(n as u32) / 12);
    let tree = AssignmentTree::new((1..=robots).flat_map(some).collect());
    tree.evaluate_robots(
        &scene,
        || true,
        |place, figures, picks| {
            assert_eq!(picks.len(), robots);
            assert_eq!(picks.iter().sum::<usize>(), figures.picked);
            let rules = &tree.assignments()[place];
            let idle = rules.rules().len();
            assert!(picks[idle..].iter().all(|&n| n == 0), "{rules}");
            if idle == robots {
                let outcome = simulate_rules(&scene, rules).unwrap();
                let alone: Vec<usize> = outcome.robots.iter().map(|r| r.picked).collect();
                assert_eq!(picks, alone, "{rules}");
                assert_eq!(figures, outcome.figures, "{rules}");
            }
        },
    )
    .unwrap();
    Cascade::new(&scene).is_some()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn picks_by_robot_agree_on_lines((station, pattern, _) in common::cases(common::lines(), 60)) {
        picks_agree(&station, &pattern);
    }

    #[test]
    fn picks_by_robot_agree_on_any_station((station, pattern, _) in common::cases(common::stations(), 40)) {
        picks_agree(&station, &pattern);
    }
}

#[test]
fn picks_by_robot_agree_in_both_engines() {
    let station = built_in("paper").unwrap().station(Some(3)).unwrap();
    let pattern = pickline::pattern::grid(station.belt().width, 0.15, 80).unwrap();
    assert!(picks_agree(&station, &pattern), "the cascade serves here");
    let mut robots = station.robots().to_vec();
    for (i, robot) in robots.iter_mut().enumerate() {
        robot.base.x = 1.3 + 0.4 * i as f64;
        robot.bins[0].at.x = robot.base.x;
        robot.rest.x = robot.base.x;
    }
    let close = Station::new(*station.belt(), robots).unwrap();
    assert!(!picks_agree(&close, &pattern), "windows overlap here");
}

/// Every claim of the JSON, checked against its own table of payoffs.
fn consistent(game: &Value) {
    let list = |value: &Value| value.as_array().unwrap().clone();
    let profiles = list(&game["profiles"]);
    let robots = game["robots"].as_array().unwrap().len();
    assert_eq!(profiles.len(), 6usize.pow(robots as u32));
    let find = |assignment: &[Value]| {
        let here = |p: &&Value| p["assignment"].as_array().unwrap() == assignment;
        profiles.iter().find(here).unwrap()
    };
    let rules = list(&game["rules"]);
    let mut stable = Vec::new();
    for profile in &profiles {
        let assignment = list(&profile["assignment"]);
        let mut gains = Vec::new();
        for robot in 0..robots {
            for rule in rules.iter().filter(|&rule| *rule != assignment[robot]) {
                let mut other = assignment.clone();
                other[robot] = rule.clone();
                let value = |p: &Value| p["payoffs"][robot].as_f64().unwrap();
                gains.push(value(find(&other)) - value(profile));
            }
        }
        let kind = match gains.iter().copied().fold(f64::NEG_INFINITY, f64::max) {
            most if most > 0.0 => "",
            0.0 => "weak",
            _ => "strict",
        };
        assert_eq!(profile["equilibrium"], kind, "{profile}");
        if !kind.is_empty() {
            stable.push((assignment.clone(), gains));
            assert_eq!(profile["leads_to"], profile["assignment"]);
        }
        let sum: f64 = list(&profile["rates"])
            .iter()
            .filter_map(Value::as_f64)
            .sum();
        assert!((sum - profile["welfare"].as_f64().unwrap()).abs() < 1e-8);
    }
    let equilibria = list(&game["equilibria"]);
    assert_eq!(equilibria.len(), stable.len());
    let mut basins = 0;
    for equilibrium in &equilibria {
        let own = list(&equilibrium["assignment"]);
        let (_, gains) = stable.iter().find(|(a, _)| *a == own).unwrap();
        let deviations = list(&equilibrium["deviations"]);
        assert_eq!(deviations.len(), 5 * robots);
        for (deviation, gain) in deviations.iter().zip(gains) {
            let at = |name: &str| deviation[name].as_f64().unwrap();
            assert!((at("gain") - gain).abs() < 1e-8, "{deviation} {gain}");
            assert!(at("gain_low") - 1e-9 <= at("gain") && at("gain") <= at("gain_high") + 1e-9);
        }
        let proven = deviations.iter().filter(|deviation| {
            let high = deviation["gain_high"].as_f64();
            high.unwrap() < 0.0
        });
        assert_eq!(equilibrium["proven"], proven.count());
        let least = |deviations: &mut dyn Iterator<Item = &Value>| {
            let losses = deviations.map(|deviation| -deviation["gain"].as_f64().unwrap());
            losses.fold(f64::INFINITY, f64::min)
        };
        let margin = equilibrium["margin"].as_f64().unwrap();
        assert!((margin - least(&mut deviations.iter())).abs() < 1e-8);
        let mut others = deviations.iter().filter(|d| d["equivalent"] == false);
        match equilibrium["margin_to_others"].as_f64() {
            Some(margin) => assert!((margin - least(&mut others)).abs() < 1e-8),
            None => assert!(others.next().is_none()),
        }
        let basin = equilibrium["basin"].as_u64().unwrap() as usize;
        let ends = profiles
            .iter()
            .filter(|p| p["leads_to"] == equilibrium["assignment"]);
        assert_eq!(ends.count(), basin);
        basins += basin;
    }
    let play = &game["best_response"];
    assert_eq!(play["to_equilibrium"], basins);
    assert_eq!(play["to_cycle"], profiles.len() - basins);
    let welfare = |p: &Value| p["welfare"].as_f64().unwrap();
    let best = profiles.iter().map(welfare).fold(0.0, f64::max);
    let optimum = &game["social_optimum"];
    assert_eq!(optimum["welfare"], best);
    let highest = profiles.iter().filter(|p| welfare(p) == best);
    let highest: Vec<Value> = highest.map(|p| p["assignment"].clone()).collect();
    assert_eq!(list(&optimum["assignments"]), highest);
    let is_stable = |p: &Value| stable.iter().any(|(own, _)| json!(own) == *p);
    assert_eq!(optimum["is_equilibrium"], highest.iter().any(is_stable));
    let worst = equilibria.iter().map(welfare).fold(f64::INFINITY, f64::min);
    if !equilibria.is_empty() {
        let price = game["price_of_anarchy"].as_f64().unwrap();
        assert!((price - best / worst).abs() < 1e-12);
        let stability = game["price_of_stability"].as_f64().unwrap();
        assert!(1.0 <= stability && stability <= price);
    }
}

#[test]
fn everything_that_is_printed_follows_from_the_payoffs() {
    // Losses that are not proven, of which there have to be some.
    let mut chance = 0;
    for arguments in [
        &["--robots", "1"][..],
        &["--patterns", "balanced:8", "--items", "60"],
        &[
            "--payoff",
            "total",
            "--robots",
            "3",
            "--patterns",
            "balanced:4",
        ],
        &[
            "--robots",
            "3",
            "--patterns",
            "poisson:0.2:3",
            "--area",
            "lognormal:80,0.5",
        ],
    ] {
        let game = solved(arguments);
        assert_eq!(game["stop_reason"], "enumerated");
        consistent(&game);
        let equilibria = game["equilibria"].as_array().unwrap();
        let deviations = equilibria.iter().flat_map(|e| e["deviations"].as_array());
        // Of a loss its 95 % interval goes beyond 0.
        let unproven =
            |d: &&Value| d["gain"].as_f64() < Some(0.0) && d["gain_high"].as_f64() > Some(0.0);
        chance += deviations.flatten().filter(unproven).count();
    }
    assert!(chance > 0);
}

/// What is said in docs/game.md of the default lines.
#[test]
fn self_interest_costs_a_little_and_common_interest_nothing() {
    let own = solved(&[]);
    assert_eq!(own["equilibria"][0]["assignment"], json!(["FIFO", "SPT"]));
    assert_eq!(
        own["social_optimum"]["assignments"][0],
        json!(["SPT", "FIFO"])
    );
    assert_eq!(own["social_optimum"]["is_equilibrium"], false);
    let price = own["price_of_anarchy"].as_f64().unwrap();
    assert!((1.01..1.02).contains(&price), "{price}");
    assert_eq!(own["rules_of_robots"][0]["dominant"], json!(["FIFO", "PP"]));
    assert_eq!(
        own["rules_of_robots"][0]["equivalent"],
        json!([["FIFO", "PP"]])
    );
    let total = solved(&["--payoff", "total"]);
    assert_eq!(total["equilibria"][0]["assignment"], json!(["SPT", "FIFO"]));
    assert_eq!(total["price_of_stability"], 1.0);
    assert_eq!(total["best_response"]["to_cycle"], 0);
}

/// The social optimum is what `pickline optimize` finds, by its highest mean.
#[test]
fn the_optimum_is_that_of_optimize() {
    let set = [
        "--patterns",
        "balanced:8",
        "--items",
        "60",
        "-q",
        "--format",
        "json",
    ];
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .arg("optimize")
        .args(set)
        .args(["--validate", "0"])
        .output()
        .unwrap();
    let ranking: Value = serde_json::from_slice(&output.stdout).unwrap();
    let game = solved(&set[..4]);
    for line in ranking["ranking"].as_array().unwrap() {
        let profiles = game["profiles"].as_array().unwrap();
        let same = |p: &&Value| p["assignment"] == line["assignment"];
        let welfare = profiles.iter().find(same).unwrap()["welfare"].as_f64();
        assert!((welfare.unwrap() - line["mean"].as_f64().unwrap()).abs() < 1e-8);
    }
    let leaders = game["social_optimum"]["assignments"].as_array().unwrap();
    assert!(leaders.contains(&ranking["leader"]));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    for format in ["table", "json", "csv"] {
        let run = |threads| {
            let set = ["--robots", "3", "--patterns", "balanced:20", "-q"];
            text(&[&set[..], &["--format", format, "--threads", threads]].concat())
        };
        let one = run("1");
        assert_eq!(one, run("2"));
        assert_eq!(one, run("7"));
    }
}

#[test]
fn its_assumptions_and_origin_are_stated() {
    let output = pickline(&[]);
    let remark = String::from_utf8(output.stderr).unwrap();
    assert!(remark.contains("station paper (2 robots"), "{remark}");
    assert!(remark.contains("120 grid and 120 Poisson disk"), "{remark}");
    let table = String::from_utf8(output.stdout).unwrap();
    for word in [
        "[FIFO; SPT]",
        "anarchy",
        "stability",
        "hash",
        "made by",
        "seed 1",
    ] {
        assert!(table.contains(word), "no {word} in {table}");
    }
    let longest = table.lines().map(|line| line.chars().count()).max();
    assert!(longest < Some(180), "{table}");
}

#[test]
fn result_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/er");
    let nfg = folder.path().join("line.nfg");
    let arguments = ["--patterns", "grid:0.2", "--format", "json", "-q"];
    let files = [
        "--out",
        out.to_str().unwrap(),
        "--nfg",
        nfg.to_str().unwrap(),
    ];
    let printed = text(&[&arguments[..], &files].concat());
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    assert_eq!(read(&out.join("game.json")), printed);
    assert_eq!(read(&out.join("game.nfg")), read(&nfg));
    assert_eq!(common::csv_rows(&read(&out.join("payoffs.csv"))).len(), 37);
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 3);
    assert_eq!(
        text(&[&arguments[..], &["--nfg", "-"]].concat()),
        read(&nfg)
    );
    // Where it is written is no part of how it was made.
    assert_eq!(printed, text(&arguments));
    assert!(read(&nfg).starts_with("NFG 1 R \""));
}

#[test]
fn bad_input_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "x").unwrap();
    let below = folder.path().join("file/below");
    let below = below.to_str().unwrap();
    let here = folder.path().to_str().unwrap();
    for (arguments, words) in [
        (
            &["--robots", "5"][..],
            &["--robots", "6^5", "pickline optimize"][..],
        ),
        (&["--robots", "0"], &["--robots"]),
        (&["--payoff", "mine"], &["--payoff", "mine", "own, total"]),
        (
            &["--patterns", "gird:0.2"],
            &["--patterns", "did you mean `grid`"],
        ),
        (&["--items", "0"], &["0"]),
        (&["--update-hz", "-1"], &["--update-hz", "-1"]),
        (&["--nfg", below], &["file/below"]),
        (&["--nfg", here], &["cannot write"]),
        (&["--out", below], &["file/below"]),
        (&["--threads", "0"], &["--threads"]),
        (&["--area", "const:x"], &["--area"]),
    ] {
        let out = folder.path().join("out");
        let mut all = arguments.to_vec();
        if !arguments.contains(&"--out") {
            all.extend(["--out", out.to_str().unwrap()]);
        }
        let output = pickline(&all);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        for word in words {
            assert!(
                message.contains(word),
                "{arguments:?}: no {word} in {message}"
            );
        }
        assert!(!out.exists(), "{arguments:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A game as compare.py expects it: NAME.nfg and NAME.json.
fn write_game(folder: &Path, name: &str, game: &Game) {
    let profiles: Vec<Value> = (0..game.profiles())
        .map(|p| json!({"assignment": game.names(p), "payoffs": game.payoffs(p)}))
        .collect();
    let found: Vec<Value> = equilibria(game)
        .iter()
        .map(|e| json!({"assignment": game.names(e.profile)}))
        .collect();
    let robots: Vec<&str> = game.players().iter().map(|p| p.name.as_str()).collect();
    let all = json!({"robots": robots, "profiles": profiles, "equilibria": found});
    std::fs::write(folder.join(format!("{name}.json")), all.to_string()).unwrap();
    let nfg = nfg_text(game, name, "by tests/search/game.rs");
    std::fs::write(folder.join(format!("{name}.nfg")), nfg).unwrap();
}

fn game(sizes: &[usize], payoffs: Vec<Payoff>) -> Game {
    let player = |(i, &size): (usize, &usize)| Player {
        name: format!("player \"{i}\""),
        actions: (0..size).map(|a| format!("a{a}")).collect(),
    };
    let players = sizes.iter().enumerate().map(player).collect();
    Game::of_payoffs(players, payoffs).unwrap()
}

/// Games with known answers, and random ones: some full of ties, some with payoffs that
/// differ in the ninth digit only. tests/gambit/compare.py gives them to Gambit.
#[test]
fn games_are_written_for_gambit() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gambit");
    std::fs::create_dir_all(&folder).unwrap();
    let whole = |values: &[i32]| values.iter().map(|&v| Payoff::whole(v)).collect();
    for (name, values, count) in [
        ("prisoners", [9, 9, 0, 10, 10, 0, 5, 5], 1),
        ("pennies", [1, -1, -1, 1, -1, 1, 1, -1], 0),
        ("coordination", [2, 2, 0, 0, 0, 0, 1, 1], 2),
        ("chicken", [0, 0, -1, 1, 1, -1, -9, -9], 2),
        ("nothing", [0; 8], 4),
    ] {
        let game = game(&[2, 2], whole(&values));
        assert_eq!(equilibria(&game).len(), count, "{name}");
        write_game(&folder, name, &game);
    }
    let mut rng = pickline::pattern::random_stream(1, 0);
    use rand::RngExt as _;
    for i in 0..200 {
        let players = rng.random_range(1..=4);
        let sizes: Vec<usize> = (0..players).map(|_| rng.random_range(1..=4)).collect();
        let count = players * sizes.iter().product::<usize>();
        let payoffs = (0..count).map(|_| match i % 3 {
            0 => Payoff::whole(rng.random_range(-2..=2)),
            1 => Payoff::rounded(33.3 + Payoff::RESOLUTION * f64::from(rng.random_range(0..4))),
            _ => Payoff::rounded(rng.random_range(0.0..60.0)),
        });
        let payoffs = payoffs.collect();
        write_game(&folder, &format!("random-{i}"), &game(&sizes, payoffs));
    }
}
