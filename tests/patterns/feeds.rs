//! Feeds: items that arrive at a stated flow.

use crate::common;
use pickline::pattern::{Feed, FeedShape, Feeder, Pattern, PatternSource, Recipe, random_stream};
use pickline::station::Belt;
use std::path::{Path, PathBuf};

const BELT: Belt = Belt {
    speed: 0.3,
    length: 6.0,
    width: 0.6,
};

fn draw(feed: &Feed, flow: Option<f64>, belt: &Belt, count: usize, seed: u64) -> Pattern {
    Feeder::new(feed, flow, belt, FeedShape::default())
        .unwrap()
        .draw(count, &mut random_stream(seed, 0))
        .unwrap()
}

/// Items that pass a place in a minute, those at the last place left out.
fn flow_of(pattern: &Pattern, belt: &Belt) -> f64 {
    let last = pattern.items().last().unwrap().x0;
    let before = pattern.items().iter().filter(|item| item.x0 > last).count();
    60.0 * belt.speed * before as f64 / -last
}

/// Distances along the belt from item to item [m].
fn steps(pattern: &Pattern) -> Vec<f64> {
    let pairs = pattern.items().windows(2);
    pairs.map(|pair| pair[0].x0 - pair[1].x0).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Variance over the square of the mean: 1 of exponential distances.
fn spread(values: &[f64]) -> f64 {
    let middle = mean(values);
    let squares: Vec<f64> = values.iter().map(|v| (v - middle).powi(2)).collect();
    mean(&squares) / (middle * middle)
}

fn profile(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("shift.csv");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn every_feed_keeps_its_flow() {
    let wide = Belt {
        width: 1.5,
        speed: 0.05,
        ..BELT
    };
    let narrow = Belt {
        width: 0.05,
        speed: 0.5,
        ..BELT
    };
    for belt in [BELT, wide, narrow] {
        for flow in [20.0, 600.0] {
            for (feed, count, share) in [
                (Feed::Grid, 2_000, 0.01),
                (Feed::PoissonDisk, 2_000, 0.04),
                (Feed::Random, 20_000, 0.03),
                // Clusters and gaps leave fewer independent pieces.
                (Feed::Clustered, 50_000, 0.05),
                (Feed::Gaps, 50_000, 0.12),
            ] {
                let pattern = draw(&feed, Some(flow), &belt, count, 1);
                assert_eq!(pattern.len(), count, "{feed}");
                let found = flow_of(&pattern, &belt);
                assert!(
                    (found / flow - 1.0).abs() < share,
                    "{feed} of {flow} on {belt:?}: {found}"
                );
                assert_eq!(pattern.items()[0].x0, 0.0);
                let beside = pattern
                    .items()
                    .iter()
                    .find(|i| i.y.abs() > belt.width / 2.0 + 1e-9);
                assert!(beside.is_none(), "{feed}: {beside:?}");
                // The same seed the same pattern, another another.
                assert_eq!(
                    draw(&feed, Some(flow), &belt, 50, 3),
                    draw(&feed, Some(flow), &belt, 50, 3)
                );
                let same =
                    draw(&feed, Some(flow), &belt, 50, 3) == draw(&feed, Some(flow), &belt, 50, 4);
                assert_eq!(same, !feed.is_random(), "{feed}");
            }
        }
    }
}

#[test]
fn random_feeds_are_poisson_processes_and_the_others_are_not() {
    let of = |feed: Feed| steps(&draw(&feed, Some(120.0), &BELT, 20_000, 2));
    let random = of(Feed::Random);
    assert!((spread(&random) - 1.0).abs() < 0.05, "{}", spread(&random));
    // Exponential: 1 - 1/e of the distances are shorter than the mean.
    let middle = mean(&random);
    let shorter = random.iter().filter(|s| **s < middle).count() as f64 / random.len() as f64;
    assert!((shorter - 0.6321).abs() < 0.01, "{shorter}");
    let pattern = draw(&Feed::Random, Some(120.0), &BELT, 20_000, 2);
    let across: Vec<f64> = pattern.items().iter().map(|item| item.y).collect();
    assert!(mean(&across).abs() < 0.01);
    let square = mean(&across.iter().map(|y| y * y).collect::<Vec<_>>());
    assert!(
        (square - 0.03).abs() < 0.001,
        "uniform: W^2 / 12, not {square}"
    );
    assert!(spread(&of(Feed::Clustered)) > 1.5);
    assert!(spread(&of(Feed::Gaps)) > 1.5);
    assert!(spread(&of(Feed::PoissonDisk)) < 1.0);
}

#[test]
fn gaps_leave_their_share_of_the_belt_empty() {
    let shape = FeedShape::default()
        .with_gap_length(5.0)
        .with_gap_share(0.4);
    let feeder = Feeder::new(&Feed::Gaps, Some(6000.0), &BELT, shape).unwrap();
    let pattern = feeder.draw(200_000, &mut random_stream(1, 0)).unwrap();
    // At 333 items/m a step of 0.1 m is no accident of the fed stretches.
    let gaps: Vec<f64> = steps(&pattern).into_iter().filter(|s| *s > 0.1).collect();
    let length = -pattern.items().last().unwrap().x0;
    let share = gaps.iter().sum::<f64>() / length;
    assert!((share - 0.4).abs() < 0.05, "{share}");
    assert!((mean(&gaps) - 5.0).abs() < 1.0, "{}", mean(&gaps));
}

#[test]
fn profiles_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    // A minute up, a step, a minute of nothing, spelt as a spreadsheet would.
    let text = "time_s;flow_per_min\n0;0\n600;1200,0\n600;300\n1200;300\n1200;0\n1800;0\n";
    let feed = Feed::Profile(profile(folder.path(), text));
    let pattern = draw(&feed, None, &BELT, usize::MAX, 1);
    let between = |from: f64, to: f64| {
        let time = |x0: f64| -x0 / BELT.speed;
        let inside = pattern
            .items()
            .iter()
            .filter(|i| (from..to).contains(&time(i.x0)));
        inside.count() as f64
    };
    for (from, to, expected) in [
        (0.0, 300.0, 1500.0),
        (300.0, 600.0, 4500.0),
        (600.0, 1200.0, 3000.0),
    ] {
        let found = between(from, to);
        let off = (found - expected) / f64::sqrt(expected);
        assert!(off.abs() < 4.0, "{from} to {to}: {found} for {expected}");
    }
    assert_eq!(between(1200.0, 1e9), 0.0);
    // Scaled to another mean, and cut at a number of items.
    let scaled = draw(&feed, Some(30.0), &BELT, usize::MAX, 1);
    assert!(
        (scaled.len() as f64 - 900.0).abs() < 120.0,
        "{}",
        scaled.len()
    );
    assert_eq!(
        draw(&feed, None, &BELT, 10, 1).items(),
        &pattern.items()[..10]
    );
    for (text, words) in [
        ("time_s,flow_per_min\n0,1\n", &["no duration"][..]),
        ("time_s,flow_per_min\n0,0\n60,0\n", &["zero flow"]),
        (
            "time_s,flow_per_min\n60,1\n0,1\n",
            &["shift.csv:3: time_s", "sort"],
        ),
        (
            "time_s,flow_per_min\n0,-1\n",
            &["shift.csv:2: flow_per_min", "`-1`"],
        ),
        (
            "time,flow_per_min\n0,1\n",
            &["column 1", "did you mean `time_s`"],
        ),
        ("time_s\n0\n", &["two columns", "time_s,flow_per_min"]),
    ] {
        let feed = Feed::Profile(profile(folder.path(), text));
        let error = Feeder::new(&feed, None, &BELT, FeedShape::default());
        let message = error.unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
}

#[test]
fn flows_are_given_in_the_source_or_beside_it() {
    let source =
        |text: &str, flow: Option<f64>| text.parse::<PatternSource>().unwrap().with_flow(flow);
    let recipe = Recipe::new(BELT, 20, 1);
    for (text, patterns) in [
        ("grid", 1),
        ("poisson", 120),
        ("poisson:3", 3),
        ("random:3", 3),
        ("clustered:3", 3),
        ("gaps:3", 3),
    ] {
        let set = source(text, Some(60.0)).unwrap().build(&recipe).unwrap();
        assert_eq!(set.patterns.len(), patterns, "{text}");
        assert!(
            set.description.contains("60 items/min at 0.3 m/s"),
            "{}",
            set.description
        );
        let named = text.replacen(':', ":60/min:", 1);
        if named != text {
            let other = source(&named, None).unwrap().build(&recipe).unwrap();
            assert_eq!(other.patterns, set.patterns, "{text}");
        }
    }
    for (text, flow, words) in [
        ("grid:0.15", 60.0, "by its distance"),
        ("poisson:0.2", 60.0, "by its distance"),
        ("poisson:0.2:3", 60.0, "by its distance"),
        ("random:60/min", 60.0, "already has a flow"),
        ("balanced", 60.0, "range of flows"),
        (
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests"),
            60.0,
            "recorded",
        ),
        ("random", 0.0, "not a valid flow"),
        ("random", f64::NAN, "not a valid flow"),
    ] {
        let message = source(text, Some(flow)).unwrap_err().to_string();
        assert!(message.contains(words), "{text}: {message}");
    }
    let message = source("random", None)
        .unwrap()
        .build(&recipe)
        .unwrap_err()
        .to_string();
    assert!(message.contains("'flow'"), "{message}");
}

#[test]
fn a_profile_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let text = "time_s,flow_per_min\n0,30\n120,60\n";
    let file = profile(folder.path(), text);
    let name = file.to_str().unwrap();
    let output = common::pickline(&[
        "pattern",
        "generate",
        "profile",
        "--profile",
        name,
        "-o",
        name,
        "--force",
    ]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("is already used by --profile"), "{said}");
    assert_eq!(std::fs::read_to_string(file).unwrap(), text);
}

#[test]
fn columns_of_a_cases_pattern_that_are_ignored_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("p.csv"), "id,x,y,colour\na,0,0,red\nb,-0.2,0.1,blue\n").unwrap();
    let case = "[[case]]\nname = \"mine\"\npattern = \"p.csv\"\n";
    std::fs::write(path("cases.toml"), case).unwrap();
    let output = common::pickline(&[
        "compare",
        "--cases",
        &path("cases.toml"),
        "--robust",
        "SPT,SPT",
        "--no-policy",
        "--no-bound",
    ]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("case mine: ") && said.contains("column colour ignored"),
        "{said}"
    );
}

#[test]
fn verbs_take_flows() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("shift.csv"), "time_s,flow_per_min\n0,30\n120,60\n").unwrap();
    let profile = format!("profile:{}:2", path("shift.csv"));
    let few = ["--validate", "0", "--items", "20", "-q", "--robots", "1"];
    let optimize = |source: &[&str]| common::text(&[&["optimize"], &few[..], source].concat());
    let text = optimize(&["--patterns", "random:3", "--flow", "60"]);
    assert!(text.contains("60 items/min at 0.05 m/s"), "{text}");
    let text = optimize(&["--patterns", &profile]);
    assert!(text.contains("45 items/min at 0.05 m/s"), "{text}");
    std::fs::write(
        path("cases.toml"),
        "[[case]]\nname = \"random\"\nfeed = \"random\"\nflow = 60\nitems = 20\n\
         [[case]]\nname = \"lattice\"\nfeed = \"grid\"\nflow = 60\nitems = 20\n\
         [[case]]\nname = \"shift\"\nprofile = \"shift.csv\"\n",
    )
    .unwrap();
    let text = common::text(&[
        "compare",
        "--cases",
        &path("cases.toml"),
        "--robust",
        "SPT,SPT",
        "--replicates",
        "2",
        "--no-policy",
        "--no-bound",
        "-q",
    ]);
    for name in ["random", "lattice", "shift"] {
        assert!(text.contains(name), "{text}");
    }
    let output = common::pickline(&[
        "pattern", "generate", "random", "--flow", "60", "--count", "400",
    ]);
    let remark = String::from_utf8(output.stderr).unwrap();
    assert!(
        remark.contains("60 items/min at 0.05 m/s: 400 items, "),
        "{remark}"
    );
    // What was generated is what is described.
    std::fs::write(path("p.csv"), output.stdout).unwrap();
    let described = common::text(&["pattern", "describe", &path("p.csv"), "--station", "paper"]);
    let flow = remark
        .split("400 items, ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    assert!(described.contains("flow at 0.05 m/s"), "{described}");
    assert!(described.contains(flow), "{flow} not in {described}");
    let plain = common::text(&["pattern", "describe", &path("p.csv")]);
    assert!(
        !plain.contains("flow") && !plain.contains("0.05 m/s"),
        "{plain}"
    );
    for (flags, word) in [
        (&["random", "--flow", "0"][..], "--flow"),
        (&["random", "--spacing", "1"], "--spacing"),
        (
            &["--spacing", "0.2", "--flow", "60"],
            "--spacing already determines the flow",
        ),
        (&["random", "--gap-share", "0.5"], "--gap-share"),
        (&["gaps", "--gap-share", "1"], "--gap-share"),
        (&["clustered", "--cluster-size", "0"], "--cluster-size"),
        (
            &["clustered", "--cluster-spread", "100", "--flow", "1e6"],
            "--cluster-spread",
        ),
        (&["profile"], "--profile"),
        (&["random", "--profile", "x.csv"], "--profile"),
        (&["profile", "--profile", "no-such.csv"], "no-such.csv"),
        (&["random", "--count", "0"], "--count"),
        (
            &["random", "--count", "10000000", "--flow", "0.001"],
            "--count",
        ),
    ] {
        let output = common::pickline(&[&["pattern", "generate"], flags].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {message}");
        assert!(message.contains(word), "{word} not in {message}");
    }
}

/// What is wrong with a profile is said of it, before any pattern is made.
#[test]
fn invalid_profiles_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    let source = format!("profile:{}", file.display());
    for (text, words) in [
        (None, &["p.csv"][..]),
        (
            Some("time_s,flow_per_min\n0,1e6\n28800,1e6\n"),
            &["p.csv", "4.800e8 items"],
        ),
        (
            Some("time_s,flow_per_min\n0,60\n600,1e8\n"),
            &["p.csv:3: flow_per_min"],
        ),
        (
            Some("time_s,flow_per_min\n6:00,60\n600,1\n"),
            &["time_s", "5400"],
        ),
        (
            Some("time_min,flow_per_min\n0,60\n600,1\n"),
            &["time_min", "give seconds"],
        ),
        (
            Some("time_s,flow_per_min\n0,-10\n600,1\n"),
            &["flow_per_min", "items per minute"],
        ),
    ] {
        if let Some(text) = text {
            std::fs::write(&file, text).unwrap();
        }
        for verb in ["optimize", "sweep"] {
            let output = common::pickline(&[verb, "--patterns", &source]);
            let told = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{told}");
            for word in words {
                assert!(told.contains(word), "{verb}: {word} not in {told}");
            }
        }
    }
}

/// A whole shift is one long pattern, and a few of them show what many short ones do.
#[test]
fn a_long_profile_has_few_patterns_by_default() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    std::fs::write(&file, "time_s,flow_per_min\n0,60\n28800,60\n").unwrap();
    let source = format!("profile:{}", file.display());
    let flags = [
        "--max-runs",
        "6",
        "--no-bound",
        "--validate",
        "1",
        "--format",
        "json",
    ];
    let call = [&["optimize", "-q", "--patterns", &source], &flags[..]].concat();
    let report: serde_json::Value = serde_json::from_str(&common::text(&call)).unwrap();
    let made = report["made"]["patterns"].as_str().unwrap();
    assert!(made.starts_with("3 pattern"), "{made}");
}

#[test]
fn a_count_that_a_profile_does_not_reach_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    std::fs::write(&file, "time_s,flow_per_min\n0,60\n600,60\n").unwrap();
    let file = file.to_str().unwrap();
    let call = [
        "pattern",
        "generate",
        "profile",
        "--profile",
        file,
        "--count",
        "100000",
    ];
    let told = String::from_utf8(common::pickline(&call).stderr).unwrap();
    assert!(told.contains("warning: --count 100000"), "{told}");
    for (flags, words) in [
        (["--from", "9"], "or a lower --from"),
        (["--step", "0"], "at least 0.00"),
    ] {
        let call = ["sweep", "--sweep", "spacing", flags[0], flags[1]];
        let told = String::from_utf8(common::pickline(&call).stderr).unwrap();
        assert!(
            told.contains(words) && !told.contains("000000000004"),
            "{told}"
        );
    }
}
