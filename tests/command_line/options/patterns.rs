//! The patterns that are drawn, for a search, a sweep or a file.

use super::rig::{RATE, Rig, assert_near, number};
use super::runs::{on, one, rate_in};
use super::{Row, hold, row};
use crate::common::{csv_column, csv_rows};
use std::collections::BTreeSet;

/// Verbs with `--patterns`.
const SETS: [&str; 3] = ["optimize", "sweep", "game"];
/// Verbs whose items have attributes.
const ATTRIBUTES: [&str; 2] = ["optimize", "game"];
/// Those that report only the weighted rate of what they draw.
const EXPERIMENTS: [&str; 2] = ["compare", "sweep"];
/// Verbs whose items have classes.
const CLASSED: [&str; 4] = ["optimize", "game", "compare", "sweep"];
const GENERATE: [&str; 1] = ["pattern generate"];

pub const ROWS: &[Row] = &[
    row(&SETS, "--patterns", |rig, verb| {
        // Ten seconds later.
        rig.write("far.csv", "id,x,y\nA,-1,0\n");
        assert_near(rate(rig, verb, "far.csv"), 60.0 / 16.5);
    }),
    // Rows further apart than the belt is wide are one, in the middle; columns come 15 s apart.
    row(&SETS, "--items", |rig, verb| {
        assert_near(rate(rig, verb, "grid:1.5 --items 1"), RATE);
        assert_near(rate(rig, verb, "grid:1.5 --items 2"), 2.0 * 60.0 / 21.5);
    }),
    // 3 items a minute come 20 s apart, 4 of them 15 s.
    row(&SETS, "--flow", |rig, verb| {
        assert_near(
            rate(rig, verb, "grid --items 2 --flow 3"),
            2.0 * 60.0 / 26.5,
        );
        assert_near(
            rate(rig, verb, "grid --items 2 --flow 4"),
            2.0 * 60.0 / 21.5,
        );
    }),
    row(&SETS, "--cluster-size", |rig, verb| {
        shapes(
            rig,
            verb,
            "clustered:1",
            "--cluster-size 5",
            "--cluster-size 2",
        );
    }),
    row(&SETS, "--cluster-spread", |rig, verb| {
        shapes(
            rig,
            verb,
            "clustered:1",
            "--cluster-spread 0.1",
            "--cluster-spread 0.01",
        );
    }),
    row(&SETS, "--gap-length", |rig, verb| {
        shapes(rig, verb, "gaps:1", "--gap-length 1", "--gap-length 3");
    }),
    row(&SETS, "--gap-share", |rig, verb| {
        shapes(rig, verb, "gaps:1", "--gap-share 0.3", "--gap-share 0.8");
    }),
    row(&ATTRIBUTES, "--area", |rig, verb| {
        // An area of 100 cm^2 has the weight 1 / (1 + 1/e).
        weighted(rig, verb, "--area const:100", 1.0 / (1.0 + (-1.0f64).exp()));
        by_weight(rig, verb, "--area uniform:1,200");
    }),
    row(&ATTRIBUTES, "--p-detection", |rig, verb| {
        weighted(rig, verb, "--p-detection const:0.4", 0.4 * 0.5);
        by_weight(rig, verb, "--p-detection uniform:0,1");
    }),
    row(&ATTRIBUTES, "--p-grasp", |rig, verb| {
        weighted(rig, verb, "--p-grasp const:0.4", 0.4 * 0.5);
        by_weight(rig, verb, "--p-grasp uniform:0,1");
    }),
    // An area of 100 cm^2 has the weight 1 / (1 + 1/e).
    row(&EXPERIMENTS, "--area", |rig, verb| {
        worth(rig, verb, "--area const:100", 1.0 / (1.0 + (-1.0f64).exp()));
    }),
    row(&EXPERIMENTS, "--p-detection", |rig, verb| {
        worth(rig, verb, "--p-detection const:0.4", 0.4 * 0.5);
    }),
    row(&EXPERIMENTS, "--p-grasp", |rig, verb| {
        worth(rig, verb, "--p-grasp const:0.4", 0.4 * 0.5);
    }),
    row(&CLASSED, "--classes", |rig, verb| {
        // The one item is not wanted.
        let station = format!(
            "{}\n[[class]]\nname = \"wood\"\nwanted = false\n",
            rig.read("one.toml")
        );
        rig.write("classed.toml", &station);
        rig.write("c.toml", "[[case]]\nname = \"g\"\ngrid = 1.5\nitems = 1\n");
        let call = on(verb, "classed.toml").replace("p.csv", "grid:1.5 --items 1");
        let more = if verb == "compare" {
            "--replicates 2"
        } else {
            ""
        };
        let rate = |flags: &str| {
            let report = rig.json(&format!("{call} -q --format json {more} {flags}"));
            rate_in(verb, &report)
        };
        assert_near(rate("--classes pet:1"), RATE);
        // There are no best rules where nothing is to be picked, but rules that are given can run.
        match ["compare", "sweep"].contains(&verb) {
            true => assert_near(rate("--classes wood:1"), 0.0),
            false => rig.refused(
                &format!("{call} -q {more} --classes wood:1"),
                &["the patterns: no item is to be picked", "--classes"],
            ),
        }
    }),
    row(&GENERATE, "<kind>", |rig, _| {
        let y = |kind: &str| csv_column(&generated(rig, kind), "y");
        let lattice = ["-0.525", "-0.375", "-0.22499999999999998"];
        assert_eq!(y("grid")[..3], lattice);
        assert_eq!(y(""), y("grid"));
        for kind in ["poisson", "random", "clustered", "gaps"] {
            assert_ne!(y(kind)[..3], lattice, "{kind}");
        }
        let all: BTreeSet<String> = ["poisson", "random", "clustered", "gaps"]
            .map(|kind| generated(rig, kind))
            .into();
        assert_eq!(all.len(), 4);
    }),
    row(&GENERATE, "--count", |rig, _| {
        assert_eq!(csv_rows(&generated(rig, "grid --count 3")).len(), 1 + 3);
        assert_eq!(csv_rows(&generated(rig, "poisson --count 4")).len(), 1 + 4);
        assert_eq!(csv_rows(&generated(rig, "random --count 5")).len(), 1 + 5);
    }),
    row(&GENERATE, "--spacing", |rig, _| {
        let pattern = generated(rig, "grid --spacing 0.5 --count 4");
        assert_eq!(csv_column(&pattern, "y"), ["-0.5", "0", "0.5", "-0.5"]);
        assert_eq!(csv_column(&pattern, "x"), ["0", "0", "0", "-0.5"]);
    }),
    row(&GENERATE, "--radius", |rig, _| {
        let least = |flags: &str| nearest(&places(&generated(rig, flags)));
        let (wide, narrow) = (least("poisson --radius 0.4"), least("poisson --radius 0.1"));
        assert!(
            (0.4..0.6).contains(&wide) && (0.1..0.2).contains(&narrow),
            "{wide} {narrow}"
        );
    }),
    row(&GENERATE, "--profile", |rig, _| {
        // 60 a minute for 3 s, and 120 a minute.
        rig.write("slow.csv", "time_s,flow_per_min\n0,60\n30,60\n");
        rig.write("quick.csv", "time_s,flow_per_min\n0,120\n30,120\n");
        let count =
            |name: &str| csv_rows(&generated(rig, &format!("profile --profile {name}"))).len() - 1;
        let (slow, quick) = (count("slow.csv"), count("quick.csv"));
        assert!(
            (15..45).contains(&slow) && (45..80).contains(&quick),
            "{slow} {quick}"
        );
    }),
    row(&GENERATE, "--flow", |rig, _| {
        let second = |flow: &str| {
            let call = format!("grid --count 2 --station one.toml --flow {flow}");
            csv_column(&generated(rig, &call), "x")[1].clone()
        };
        assert_eq!((second("3").as_str(), second("4").as_str()), ("-2", "-1.5"));
    }),
    row(&GENERATE, "--cluster-size", |rig, _| {
        // As many clusters as the size goes into the number of items, by chance.
        let clusters = |size: &str| {
            let call = format!("clustered --count 60 --cluster-spread 0.001 --cluster-size {size}");
            let places = places(&generated(rig, &call));
            let near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.01;
            let alone = |i: &usize| !places[..*i].iter().any(|other| near(other, &places[*i]));
            (0..places.len()).filter(alone).count()
        };
        let (large, small) = (clusters("10"), clusters("2"));
        assert!(
            (3..12).contains(&large) && (20..45).contains(&small),
            "{large} {small}"
        );
    }),
    row(&GENERATE, "--cluster-spread", |rig, _| {
        let least = |spread: &str| {
            let call = format!("clustered --count 20 --cluster-spread {spread}");
            nearest(&places(&generated(rig, &call)))
        };
        assert!(
            least("0.0001") < 1e-3 && least("0.2") > 1e-3,
            "{}",
            least("0.2")
        );
    }),
    row(&GENERATE, "--gap-length", |rig, _| {
        let longest = |length: &str| {
            let call = format!("gaps --count 300 --gap-length {length}");
            let places = places(&generated(rig, &call));
            let gaps = places.windows(2).map(|pair| pair[0][0] - pair[1][0]);
            gaps.fold(0.0, f64::max)
        };
        // Of some gaps with this mean length the longest is longer.
        let (short, long) = (longest("0.2"), longest("2"));
        assert!((0.3..1.9).contains(&short) && long > 2.0, "{short} {long}");
    }),
    row(&GENERATE, "--gap-share", |rig, _| {
        // The first items lie in one stretch, in which the same flow comes on the share of the
        // belt that is not empty.
        let second = |share: &str| {
            let call = format!("gaps --count 2 --gap-share {share}");
            places(&generated(rig, &call))[1][0]
        };
        assert_near(second("0.9") / second("0.3"), 0.1 / 0.7);
    }),
    row(&GENERATE, "--width", |rig, _| {
        let pattern = generated(rig, "grid --spacing 0.5 --count 3 --width 0.6");
        assert_eq!(csv_column(&pattern, "y"), ["-0.25", "0.25", "-0.25"]);
    }),
    row(&GENERATE, "--area", |rig, _| {
        let pattern = generated(rig, "grid --count 2 --area const:80");
        assert_eq!(csv_column(&pattern, "area_cm2"), ["80", "80"]);
    }),
    row(&GENERATE, "--p-detection", |rig, _| {
        let pattern = generated(rig, "grid --count 2 --p-detection const:0.5");
        assert_eq!(csv_column(&pattern, "p_detection"), ["0.5", "0.5"]);
    }),
    row(&GENERATE, "--p-grasp", |rig, _| {
        let pattern = generated(rig, "grid --count 2 --p-grasp const:0.25");
        assert_eq!(csv_column(&pattern, "p_grasp"), ["0.25", "0.25"]);
    }),
    row(&GENERATE, "--classes", |rig, _| {
        let classes = "--classes pet:0.5,wood:0.5";
        let pattern = generated(rig, &format!("grid --count 40 {classes}"));
        let drawn: BTreeSet<String> = csv_column(&pattern, "class").into_iter().collect();
        assert_eq!(drawn, ["pet", "wood"].map(str::to_owned).into());
        // The items stay where they are.
        assert_eq!(places(&pattern), places(&generated(rig, "grid --count 40")));
    }),
    row(&GENERATE, "--seed", |rig, _| {
        let random = |flags: &str| generated(rig, &format!("random {flags}"));
        assert_eq!(random(""), random("--seed 1"));
        assert_ne!(random(""), random("--seed 2"));
    }),
    row(&GENERATE, "--output", |rig, _| {
        for (flag, name) in [("--output", "a.csv"), ("-o", "b.csv")] {
            assert_eq!(generated(rig, &format!("grid --count 2 {flag} {name}")), "");
            let rows = csv_rows(&rig.read(name));
            assert_eq!(rows[1..], csv_rows(&generated(rig, "grid --count 2"))[1..]);
        }
    }),
    row(&GENERATE, "--quiet", |rig, verb| {
        let loud = rig.done(&format!("{verb} poisson"));
        assert!(loud.stderr.starts_with("generating a Poisson disk pattern"));
        for flag in ["-q", "--quiet"] {
            let silent = rig.done(&format!("{verb} poisson {flag}"));
            assert_eq!((silent.stderr.as_str(), &silent.stdout), ("", &loud.stdout));
        }
        assert_ne!(rig.done(&format!("{verb} random")).stderr, "");
        assert_eq!(rig.done(&format!("{verb} random -q")).stderr, "");
    }),
];

#[test]
fn pattern_options_have_their_effect() {
    hold(ROWS);
}

/// The picking rate of `verb` on `patterns`, with the flags behind.
fn rate(rig: &Rig, verb: &str, patterns: &str) -> f64 {
    let call = format!("{} -q --format json", one(verb).replace("p.csv", patterns));
    rate_in(verb, &rig.json(&call))
}

/// The shape of a feed is that of the flag: the usual one where it is not given.
fn shapes(rig: &Rig, verb: &str, feed: &str, usual: &str, other: &str) {
    let rate = |flags: &str| rate(rig, verb, &format!("{feed} --flow 30 --items 24 {flags}"));
    assert_eq!(rate(""), rate(usual));
    assert_ne!(rate(""), rate(other));
}

/// One item of `weight` is worth so much a minute; without the flag half.
fn weighted(rig: &Rig, verb: &str, flags: &str, weight: f64) {
    if verb != "optimize" {
        return;
    }
    let set = "grid:1.5 --items 1 --objective weighted-rate";
    assert_near(rate(rig, verb, set), 0.5 * RATE);
    assert_near(rate(rig, verb, &format!("{set} {flags}")), weight * RATE);
}

/// One generated item of `weight` is worth so much a minute; without the flag half.
fn worth(rig: &Rig, verb: &str, flags: &str, weight: f64) {
    rig.write("c.toml", "[[case]]\nname = \"g\"\ngrid = 1.5\nitems = 1\n");
    let call = one(verb).replace("p.csv", "grid:1.5 --items 1");
    let (more, place) = match verb {
        "compare" => ("--replicates 2", "/cases/0/results/0/weighted_rate_per_min"),
        _ => ("", "/points/0/weighted_rate_per_min"),
    };
    let rate = |flags: &str| {
        let report = rig.json(&format!("{call} -q --format json {more} {flags}"));
        number(&report, place)
    };
    assert_near(rate(""), 0.5 * RATE);
    assert_near(rate(flags), weight * RATE);
}

/// PP picks like FIFO as long as all items weigh the same, and otherwise where they do not.
fn by_weight(rig: &Rig, verb: &str, flags: &str) {
    let rates = |flags: &str| {
        let set = format!("grid:0.15 --items 24 {flags}");
        let call = format!("{} -q --format csv", one(verb).replace("p.csv", &set));
        let text = rig.text(&call);
        let rows = csv_rows(&text);
        let column = match verb {
            "optimize" => "picking_rate_mean",
            _ => "rate_a_per_min",
        };
        let place = rows[0]
            .iter()
            .position(|name| name.starts_with(column))
            .unwrap();
        let of = |rule: &str| {
            let row = rows
                .iter()
                .find(|row| row.iter().any(|cell| cell == rule))
                .unwrap();
            row[place].parse::<f64>().unwrap()
        };
        (of("FIFO"), of("PP"))
    };
    let (first, by_weight) = rates("");
    assert_near(first, by_weight);
    let (first, by_weight) = rates(flags);
    assert!(first != by_weight, "{first}");
}

fn generated(rig: &Rig, flags: &str) -> String {
    rig.text(&format!("pattern generate -q {flags}"))
}

fn places(pattern: &str) -> Vec<[f64; 2]> {
    let numbers = |name| -> Vec<f64> {
        let column = csv_column(pattern, name);
        column.iter().map(|cell| cell.parse().unwrap()).collect()
    };
    let (x, y) = (numbers("x"), numbers("y"));
    x.into_iter().zip(y).map(|(x, y)| [x, y]).collect()
}

/// The least distance between two of `places`.
fn nearest(places: &[[f64; 2]]) -> f64 {
    let mut least = f64::INFINITY;
    for (i, a) in places.iter().enumerate() {
        for b in &places[..i] {
            least = least.min((a[0] - b[0]).hypot(a[1] - b[1]));
        }
    }
    least
}
