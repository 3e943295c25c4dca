//! The sweep and the speed limits.

use pickline::experiment::{Method, Setting, sweep_settings};
use pickline::optimize::{Environment, Silent, SpeedScan};
use pickline::pattern::{PatternSource, Recipe};
use pickline::sim::{AssignmentTree, Conditions, Scene, simulate_rules};
use pickline::station::built_in;
use serde_json::Value;
use std::process::Command;
use std::slice::from_ref;
use std::sync::atomic::AtomicBool;

/// The limits of the search, of the sweep and of a plain scan with the event loop, on 100
/// random patterns.
#[test]
fn speed_limits_are_those_of_a_brute_force_scan() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let recipe = Recipe::new(
        pickline::station::Belt {
            speed: 0.05,
            length: 4.2,
            width: 1.05,
        },
        40,
        5,
    );
    let set = PatternSource::Poisson(0.16, 100).build(&recipe).unwrap();
    let rules = "SPT,FIFO".parse().unwrap();
    let values: Vec<f64> = (1..=35).map(|k| f64::from(k) * 4.0 / 1000.0).collect();
    let settings: Vec<Setting> = values
        .iter()
        .map(|&value| Setting {
            value,
            station: station.with_belt_speed(value).unwrap(),
            min_detection: None,
            methods: vec![Method::Robust("SPT,FIFO".parse().unwrap())],
        })
        .collect();
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let swept = sweep_settings(
        &settings,
        &set.patterns,
        &Conditions::default(),
        false,
        &environment,
    )
    .unwrap();
    let of_sweep = swept.method("robust_gt").unwrap().limits();
    let scan = SpeedScan::new(0.004, &station).unwrap();
    let tree = AssignmentTree::new(vec!["SPT,FIFO".parse().unwrap()]);
    let mut not_monotone = 0;
    for (pattern, of_sweep) in set.patterns.iter().zip(of_sweep) {
        let complete: Vec<bool> = settings
            .iter()
            .map(|setting| {
                let scene = Scene::new(&setting.station, pattern).unwrap();
                simulate_rules(&scene, &rules).unwrap().figures.complete()
            })
            .collect();
        let held = complete.iter().take_while(|c| **c).count();
        let limit = if held == 0 { 0.0 } else { values[held - 1] };
        assert!(
            limit < values[values.len() - 1],
            "the scan must end with a miss"
        );
        let (searched, _) = scan
            .limits(&station, pattern, &tree, &Conditions::default())
            .unwrap();
        assert_eq!(searched, [limit]);
        assert_eq!(of_sweep, limit);
        not_monotone += usize::from(complete[held..].iter().any(|c| *c));
    }
    // The reason why the limit is not bisected.
    assert!(
        not_monotone > 0,
        "no pattern is picked completely again above its limit"
    );
}

fn json(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["sweep", "-q", "--format", "json"])
        .args(arguments)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {told}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_default_is_the_papers_case() {
    let report = json(&[]);
    let limit = &report["limits"][0];
    assert_eq!(limit["method"], "robust_gt");
    assert_eq!(limit["highest"], 0.043);
    assert_eq!(limit["first_miss"], 0.044);
    assert_eq!(report["paper"]["robust_gt"], 0.042);
    assert_eq!(report["paper"]["rl"], 0.047);
    let benefit = report["paper"]["benefit_percent"].as_f64().unwrap();
    assert!((benefit - 11.9).abs() < 0.05);
    // About thirty rows around the limit, which is one of them, as is the first miss.
    let points = report["points"].as_array().unwrap();
    let values: Vec<f64> = points
        .iter()
        .map(|p| p["value"].as_f64().unwrap())
        .collect();
    assert!((20..=33).contains(&values.len()), "{values:?}");
    assert!(values[0] < 0.03 && values.contains(&0.043) && values.contains(&0.044));
    assert!(values.is_sorted() && *values.last().unwrap() > 0.06);
    assert_eq!(report["made"]["command"], "pickline sweep");
}

/// The file of a station: speed [m/s] and width [m] of the belt, robots, and their speed [m/s].
fn line([belt_speed, width]: [f64; 2], robots: usize, speed: f64) -> String {
    format!(
        "[belt]\nspeed = {belt_speed:?}\nwidth = {width:?}\n[line]\nrobots = {robots}\n\
         first_base_x = 1.0\nspacing = 1.6\nbase_offset = 0.1\nbin_offset = 0.0\ntail = 0.5\n\
         reach = 0.7\nspeed = {speed:?}\ngrasp_time = 0.1\nrelease_time = 0.1\n"
    )
}

/// A belt far above what the line can do: the sweep begins below the limit, and has no
/// thousands of rows.
#[test]
fn a_fast_belt_is_swept_around_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fast.toml");
    std::fs::write(&file, line([2.0, 0.6], 2, 5.0)).unwrap();
    let fast = ["--station", file.to_str().unwrap(), "--robust", "SPT,FIFO"];
    let report = json(&[&fast[..], &["--no-bound"]].concat());
    let rows = report["points"].as_array().unwrap();
    assert!((10..=33).contains(&rows.len()), "{}", rows.len());
    let limit = &report["limits"][0];
    let (highest, miss) = (
        limit["highest"].as_f64().unwrap(),
        limit["first_miss"].as_f64(),
    );
    assert!(rows[0]["value"].as_f64().unwrap() < highest);
    assert!(miss.unwrap() - highest <= highest / 9.0, "{limit}");
    // The limit is that of a scan in the same steps, all of them verified.
    let step = ((miss.unwrap() - highest) * 1e9).round() / 1e9;
    let (from, to) = (step.to_string(), miss.unwrap().to_string());
    let scan = ["--from", &from, "--to", &to, "--step", &from, "--no-bound"];
    let scan = json(&[&fast[..], &scan].concat());
    assert_eq!(scan["limits"][0]["highest"], limit["highest"]);
}

/// An implausible line at an end of the range is named with the value of that end.
#[test]
fn warnings_are_of_the_end_of_the_range_that_they_name() {
    let folder = tempfile::tempdir().unwrap();
    let station = folder.path().join("s.toml");
    let text = "[belt]\nspeed = 0.3\nwidth = 0.5\n[line]\nrobots = 1\nfirst_base_x = 4.0\nspacing = 1.4\n\
                base_offset = 0.1\ntail = 4.0\nreach = 3.5\nspeed = 2.0\ngrasp_time = 0.04\n\
                release_time = 0.04\nrest = [0.0, 2.0]\n[[line.bin]]\noffset = [0.0, 0.1]\n";
    std::fs::write(&station, text).unwrap();
    let station = station.to_str().unwrap();
    let range = [
        "--sweep", "reach", "--from", "0.6", "--to", "3.4", "--step", "1.4",
    ];
    let out = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["sweep", "--station", station])
        .args(range)
        .args(["--robust", "SPT", "--no-bound", "--patterns", "grid:0.2"])
        .output()
        .unwrap();
    assert!(out.status.success(), "{out:?}");
    let told = String::from_utf8(out.stderr).unwrap();
    assert!(told.contains("--sweep reach at 0.6"), "{told}");
    assert!(told.contains("beyond its reach of 0.6 m"), "{told}");
    assert!(!told.contains("at 3.4"), "{told}");
}

/// Where the workspaces are apart the spacing makes no difference, so the least such one is
/// recommended and none at which arms can meet.
#[test]
fn no_spacing_is_recommended_at_which_arms_meet() {
    let spacing = ["--sweep", "spacing", "--robust", "SPT,FIFO", "--no-bound"];
    let report = json(&spacing);
    let points = report["points"].as_array().unwrap();
    assert!((15..=31).contains(&points.len()));
    let throughput = |point: &Value| point["throughput_per_min"].as_f64().unwrap();
    for point in points {
        assert!(
            (throughput(point) / throughput(&points[0]) - 1.0).abs() < 0.01,
            "{point}"
        );
    }
    // Bases on either side are 1.25 m apart across the belt, reaches are 0.8 m, and arms have
    // to stay 0.05 m apart.
    let apart = (1.65f64 * 1.65 - 1.25 * 1.25).sqrt();
    let recommended = report["limits"][0]["recommended"].as_f64().unwrap();
    assert!((apart..apart + 0.1).contains(&recommended), "{recommended}");
    let meet = report["arms_can_meet"].as_array().unwrap();
    assert_eq!(
        meet.len(),
        points
            .iter()
            .filter(|p| p["value"].as_f64().unwrap() < apart)
            .count()
    );
    // The paper's rate says that the shorter line is better.
    let rate = |point: &Value| point["picking_rate_per_min"].as_f64().unwrap();
    assert!(rate(&points[0]) > rate(&points[points.len() - 1]));
}

#[test]
fn every_axis_is_swept() {
    let robots = json(&["--sweep", "robots", "--to", "4", "--items", "50"]);
    let shares: Vec<f64> = robots["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| point["picked_share"].as_f64().unwrap())
        .collect();
    assert_eq!(shares.len(), 4);
    assert!(shares[0] < 0.6 && shares[3] == 1.0, "{shares:?}");
    for axis in ["spacing", "reach"] {
        let range = [
            "--sweep", axis, "--from", "0.8", "--to", "1.6", "--step", "0.4",
        ];
        let report = json(&[&range[..], &["--robust", "SPT,FIFO", "--greedy"]].concat());
        assert_eq!(report["points"].as_array().unwrap().len(), 6, "{axis}");
    }
}

/// The arm is little faster than the belt: the sweep ends below the arm's speed.
#[test]
fn the_default_range_ends_below_the_slowest_arm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("slow.toml");
    std::fs::write(&file, line([0.05, 0.4], 1, 0.06)).unwrap();
    let slow = ["--station", file.to_str().unwrap(), "--robust", "SPT"];
    for range in [&[][..], &["--from", "0.04"]] {
        let report = json(&[&slow[..], &["--no-bound"], range].concat());
        let points = report["points"].as_array().unwrap();
        let values = points.iter().map(|p| p["value"].as_f64().unwrap());
        assert!(values.clone().all(|value| value < 0.06) && values.count() > 5);
    }
}

/// Numbers of robots between those that were run may be fewer.
#[test]
fn the_fewest_robots_are_of_those_that_were_run() {
    let table = |to: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(["sweep", "-q", "--sweep", "robots", "--no-bound", "--step"])
            .args([to, "--to", "5", "--items", "600", "--train-items", "20"])
            .args(["--train-patterns", "grid:0.2"])
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(table("1").contains(" robots, the fewest with"));
    assert!(table("2").contains(" robots, the fewest of the numbers that were run with"));
}

/// The page calls the policy what the tables call it, not what files do.
#[cfg(feature = "onnx")]
#[test]
fn the_page_names_the_policy_as_the_tables_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sweep.html");
    let range = ["--from", "0.05", "--to", "0.052", "--robust", "SPT,FIFO"];
    let page = ["--strategy", "onnx", "--html", file.to_str().unwrap()];
    json(&[&range[..], &page].concat());
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(page.contains("RL policy (onnx) picks everything up to"));
    assert!(page.contains("<td class=\"words\">RL policy (onnx)</td>"));
    assert!(!page.contains(">onnx<") && !page.contains(">onnx picks"));
}

#[test]
fn wrong_ranges_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (arguments, words) in [
        (
            &["--to", "0.6"][..],
            &["--sweep speed at 0.5", "faster than the belt"][..],
        ),
        (&["--from", "0.05", "--to", "0.04"], &["--to", "0.04"]),
        (&["--step", "0"], &["--step", "0"]),
        (&["--from", "-1"], &["--from", "-1"]),
        (&["--sweep", "sped"], &["--sweep", "did you mean `speed`"]),
        (
            &["--sweep", "robots", "--step", "0.5"],
            &["1.5 is not a number of robots"],
        ),
        (&["--strategy", "rules:SPT"], &["1 rule for 2 robots"]),
        (&["--patterns", "gird:0.1"], &["did you mean `grid`"]),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .arg("sweep")
            .args(arguments)
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        for word in words {
            assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
        }
    }
    assert!(!out.exists());
}

/// A pattern of which nothing is to be picked is picked completely, and has no share.
#[test]
fn patterns_of_unwanted_items_count_as_picked() {
    let station = built_in("sorting").unwrap().station(None).unwrap();
    let items = |class: &str| {
        let text = format!("id,x,y,class\n1,0,0,{class}\n2,-0.3,0.1,{class}\n");
        pickline::pattern::parse(&text, "t").unwrap()
    };
    let setting = Setting {
        value: 0.3,
        station,
        min_detection: None,
        methods: vec![Method::Robust("SPT,SPT,SPT,SPT".parse().unwrap())],
    };
    for (patterns, share) in [
        (vec![items("wood")], None),
        (vec![items("wood"), items("pet")], Some(1.0)),
    ] {
        let conditions = Conditions::default();
        let quiet = &Environment::QUIET;
        let swept = sweep_settings(from_ref(&setting), &patterns, &conditions, true, quiet);
        let value = &swept.unwrap().values[0];
        let point = &value.methods[0];
        assert_eq!(
            (point.complete_share, point.nearly_complete_share),
            (1.0, 1.0)
        );
        assert_eq!(
            Some(point.picked_share).filter(|share| !share.is_nan()),
            share
        );
        assert!(value.bound.as_ref().unwrap().complete());
    }
}
