//! Every column of a comparison, recomputed from single runs.

use super::support::*;
use crate::common::csv_rows;
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{Feed, Feeder, Pattern, load, poisson_disk, random_stream};
use pickline::planning::bound::{Bound, BoundOptions, upper_bound};
use pickline::sim::Scene;
use pickline::station::{self, Overrides, Station};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::LazyLock;

const METHODS: [&str; 3] = ["robust_gt", "greedy_gt", "rules:LPT,PP"];
const TITLES: [&str; 3] = ["robust GT [SPT; FIFO]", "greedy GT", "rules:LPT,PP"];
const CASES: [&str; 3] = ["few", "long", "own"];
/// The patterns of a random case have the seeds after the master seed.
const SEEDS: [u64; 4] = [8, 9, 10, 11];

/// A case as it is judged: its patterns, and what every method makes of each.
struct Judged {
    seeds: Vec<u64>,
    /// [methods][patterns].
    runs: Vec<Vec<Raw>>,
    /// What greedy GT chooses.
    chosen: Vec<RuleAssignment>,
    bounds: Vec<Bound>,
    weighs: bool,
}

impl Judged {
    fn new(station: &Station, seeds: &[u64], patterns: &[Pattern], weighs: bool) -> Self {
        let of = |rules: &str| -> Vec<Raw> {
            let rules = rules.parse().unwrap();
            patterns
                .iter()
                .map(|p| Raw::of(station, p, &rules))
                .collect()
        };
        // The first of those with the highest rate.
        let best = |pattern: &Pattern| {
            let all = assignments();
            let runs = all.iter().map(|rules| Raw::of(station, pattern, rules));
            runs.zip(all.clone())
                .reduce(|best, next| {
                    if next.0.rate() > best.0.rate() {
                        next
                    } else {
                        best
                    }
                })
                .unwrap()
        };
        let (greedy, chosen): (Vec<Raw>, _) = patterns.iter().map(best).unzip();
        let runs = vec![of("SPT,FIFO"), greedy, of("LPT,PP")];
        let bound = |(place, pattern): (usize, &Pattern)| {
            let most = runs.iter().map(|runs| runs[place].picked).max().unwrap();
            let scene = Scene::new(station, pattern).unwrap();
            upper_bound(
                &scene,
                &BoundOptions::beside(most, pattern.len()),
                &mut |_, _| true,
            )
            .unwrap()
        };
        Self {
            seeds: seeds.to_vec(),
            bounds: patterns.iter().enumerate().map(bound).collect(),
            runs,
            chosen,
            weighs,
        }
    }

    /// A proven share of the optimum [%], rounded down to a tenth.
    fn certified(earned: f64, most: f64) -> f64 {
        (1000.0 * earned / most + 1e-9).floor() / 10.0
    }

    /// On which patterns the throughput of each method counts.
    fn counted(&self) -> Vec<Vec<bool>> {
        let all: Vec<&[Raw]> = self.runs.iter().map(Vec::as_slice).collect();
        counted(&all)
    }

    fn most(&self) -> f64 {
        self.bounds.iter().map(|bound| bound.value).sum()
    }

    fn highest_rate(&self) -> f64 {
        mean(
            &self
                .bounds
                .iter()
                .map(|b| b.rate.unwrap())
                .collect::<Vec<_>>(),
        )
    }

    /// The figures of one method, measured against method `reference`.
    fn expected(&self, method: usize, reference: usize) -> Expected {
        let (runs, first) = (&self.runs[method], &self.runs[reference]);
        let rates = |runs: &[Raw]| -> Vec<f64> { runs.iter().map(Raw::rate).collect() };
        let mut to = Expected::new();
        add_throughput(&mut to, runs, &self.counted()[method]);
        add_rates(&mut to, runs);
        to.insert("end_s", Some(mean_of(runs, |run| run.end)));
        to.insert("patterns", Some(runs.len() as f64));
        let difference = paired(&rates(runs), &rates(first));
        to.insert("diff_low", difference.map(|ends| ends[0]));
        to.insert("diff_high", difference.map(|ends| ends[1]));
        let more = mean(&rates(runs)) / mean(&rates(first)) - 1.0;
        to.insert("benefit_percent", Some(100.0 * more));
        let picked: usize = runs.iter().map(|run| run.picked).sum();
        let certified = Self::certified(picked as f64, self.most());
        to.insert("certified_percent", Some(certified));
        let by_rate = Self::certified(mean(&rates(runs)), self.highest_rate());
        to.insert("certified_rate_percent", Some(by_rate));
        to.insert("picking_rate_upper_bound", Some(self.highest_rate()));
        to
    }
}

struct Made {
    judged: Vec<Judged>,
    report: Value,
    table: String,
    files: BTreeMap<&'static str, Vec<Vec<String>>>,
    /// The same with another method as the reference.
    against_last: Value,
}

const FILES: [&str; 4] = [
    "throughput.csv",
    "picked_time.csv",
    "picking_rate.csv",
    "runs.csv",
];

static MADE: LazyLock<Made> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("line.toml"), STATION).unwrap();
    std::fs::write(at("own.csv"), weighted(0)).unwrap();
    let cases = "[[case]]\nname = \"few\"\npoisson = 0.15\nitems = 40\n\
        [[case]]\nname = \"long\"\nfeed = \"random\"\nflow = 75\nitems = 130\n\
        [[case]]\nname = \"own\"\npattern = \"own.csv\"\n";
    std::fs::write(at("cases.toml"), cases).unwrap();
    let (line, list, out) = (at("line.toml"), at("cases.toml"), at("out"));
    let call = format!(
        "compare -q --no-policy --station {line} --cases {list} --seed 7 --replicates 4 --robust \
         SPT,FIFO --strategy {}",
        METHODS[2]
    );
    let table = run(&format!("{call} --out {out}"));
    let read = |name: &str| std::fs::read_to_string(format!("{out}/{name}")).unwrap();
    let against_last = run(&format!(
        "{call} --reference {} --no-bound --format json",
        METHODS[2]
    ));
    let none = Overrides::default();
    let station = station::load(&line, none).unwrap();
    let belt = station.belt();
    let few = SEEDS.map(|s| poisson_disk(belt.width, 0.15, 40, &mut random_stream(s, 0)).unwrap());
    let feeder = Feeder::new(&Feed::Random, Some(75.0), belt, Default::default()).unwrap();
    let long = SEEDS.map(|s| feeder.draw(130, &mut random_stream(s, 0)).unwrap());
    let own = load(std::path::Path::new(&at("own.csv"))).unwrap().pattern;
    Made {
        judged: vec![
            Judged::new(&station, &SEEDS, &few, false),
            Judged::new(&station, &SEEDS, &long, false),
            Judged::new(&station, &SEEDS[..1], &[own], true),
        ],
        report: serde_json::from_str(&read("compare.json")).unwrap(),
        table,
        files: FILES
            .map(|name| (name, csv_rows(&read(name))))
            .into_iter()
            .collect(),
        against_last: serde_json::from_str(&against_last).unwrap(),
    }
});

/// The runs differ in all that the columns tell apart, or a column could stand in for another.
#[test]
fn the_runs_of_these_cases_differ() {
    for (judged, name) in MADE.judged.iter().zip(CASES) {
        let rates = |method: usize| judged.runs[method].iter().map(Raw::rate);
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            assert!(!rates(a).eq(rates(b)), "{name}: {a} and {b}");
        }
        assert!(
            judged.bounds.iter().all(|bound| bound.rate.is_some()),
            "{name}"
        );
    }
    let steady = |case: usize| {
        let counted = MADE.judged[case].counted().into_iter();
        let count = |counts: Vec<bool>| counts.into_iter().filter(|counts| *counts).count();
        counted.map(count).collect::<Vec<_>>()
    };
    assert_eq!([0, 2].map(steady), [[0; 3], [0; 3]]);
    // Compared on the same patterns, and not on a single one.
    assert!(
        steady(1)[0] >= 2 && steady(1) == [steady(1)[0]; 3],
        "{:?}",
        steady(1)
    );
}

#[test]
fn every_number_of_the_json_is_that_of_the_runs() {
    for (case, judged) in MADE.report["cases"]
        .as_array()
        .unwrap()
        .iter()
        .zip(&MADE.judged)
    {
        let name = case["name"].as_str().unwrap();
        assert_eq!(case["items"], judged.runs[0][0].items, "{name}");
        assert_eq!(case["patterns"], judged.seeds.len(), "{name}");
        for (method, result) in case["results"].as_array().unwrap().iter().enumerate() {
            assert_eq!(result["method"], METHODS[method]);
            let expected = judged.expected(method, 0);
            let what = format!("{name}, {}", METHODS[method]);
            assert_object(result, &expected, &what);
            let busy = result["utilisation_steady"].as_array();
            let found: Vec<f64> = busy
                .into_iter()
                .flatten()
                .map(|v| v.as_f64().unwrap())
                .collect();
            let counts = &judged.counted()[method];
            let steady = judged.runs[method]
                .iter()
                .zip(counts)
                .filter(|(_, counts)| **counts);
            let steady: Vec<_> = steady.flat_map(|(run, _)| run.steady.as_ref()).collect();
            for (robot, found) in found.iter().enumerate() {
                let shares: Vec<f64> = steady.iter().map(|s| s.utilisation[robot]).collect();
                assert_near(
                    Some(*found),
                    Some(mean(&shares)),
                    &format!("{what}: robot {robot}"),
                );
            }
            assert_eq!(found.len(), if steady.is_empty() { 0 } else { 2 });
            assert_eq!(
                result["no_throughput"].is_string(),
                steady.is_empty(),
                "{what}"
            );
        }
        let n = judged.bounds.len() as f64;
        let items: usize = judged.runs[0].iter().map(|run| run.items).sum();
        let first: Vec<f64> = judged.runs[0].iter().map(Raw::rate).collect();
        let highest: Vec<f64> = judged.bounds.iter().map(|b| b.rate.unwrap()).collect();
        let difference = paired(&highest, &first);
        let bound = &case["bound"];
        for (key, expected) in [
            ("picks_upper_bound", judged.most() / n),
            ("picked_share", judged.most() / items as f64),
            ("picking_rate_per_min", mean(&highest)),
            (
                "benefit_percent",
                100.0 * (mean(&highest) / mean(&first) - 1.0),
            ),
        ] {
            assert_near(
                bound[key].as_f64(),
                Some(expected),
                &format!("{name}, bound: {key}"),
            );
        }
        for (place, key) in ["low", "high"].into_iter().enumerate() {
            let found = bound["difference"][key].as_f64();
            let what = format!("{name}, bound minus the first: {key}");
            assert_near(found, difference.map(|ends| ends[place]), &what);
        }
    }
}

/// The method of `--reference` comes first, and the others are measured against it: its rate
/// is taken from theirs.
#[test]
fn differences_are_a_method_minus_the_reference() {
    let order = [2, 0, 1];
    for (case, judged) in MADE.against_last["cases"]
        .as_array()
        .unwrap()
        .iter()
        .zip(&MADE.judged)
    {
        for (place, result) in case["results"].as_array().unwrap().iter().enumerate() {
            assert_eq!(result["method"], METHODS[order[place]]);
            assert_object(
                result,
                &judged.expected(order[place], 2),
                &case["name"].to_string(),
            );
        }
    }
    let lower = &MADE.report["cases"][1]["results"][2];
    let higher = &MADE.against_last["cases"][1]["results"][1];
    assert!(lower["diff_high"].as_f64().unwrap() < 0.0, "{lower}");
    assert!(higher["diff_low"].as_f64().unwrap() > 0.0, "{higher}");
    assert!(lower["benefit_percent"].as_f64().unwrap() < 0.0, "{lower}");
}

/// All methods meet the same patterns, so what these have in common is no part of how their
/// difference scatters.
#[test]
fn a_paired_difference_is_narrower_than_an_unpaired_one() {
    let results = &MADE.report["cases"][1]["results"];
    let width = |of: &Value, name: &str| {
        let end = |side: &str| of[format!("{name}_{side}")].as_f64().unwrap();
        end("high") - end("low")
    };
    let alone = [0, 1].map(|method| width(&results[method], "picking_rate"));
    let unpaired = alone[0].hypot(alone[1]);
    let found = width(&results[1], "diff");
    assert!(found < 0.8 * unpaired, "{found} and {unpaired}");
}

#[test]
fn every_cell_of_the_csv_files_is_that_of_the_runs() {
    for name in &FILES[..3] {
        let rows = &MADE.files[name];
        assert_eq!(rows.len(), 1 + CASES.len() * METHODS.len());
        for (i, row) in rows[1..].iter().enumerate() {
            let (case, method) = (i / METHODS.len(), i % METHODS.len());
            let what = format!("{name}, {}, {}", CASES[case], METHODS[method]);
            assert_eq!(row[..2], [CASES[case], METHODS[method]], "{what}");
            let mut expected = MADE.judged[case].expected(method, 0);
            if method == 0 {
                for column in ["benefit_percent", "diff_low", "diff_high"] {
                    expected.insert(column, None);
                }
            }
            assert_row(&rows[0], row, &["case", "method"], &expected, &what);
        }
    }
}

#[test]
fn every_run_has_its_row() {
    let rows = &MADE.files["runs.csv"];
    let mut row = rows[1..].iter();
    for (judged, case) in MADE.judged.iter().zip(CASES) {
        for (pattern, seed) in judged.seeds.iter().enumerate() {
            for (method, id) in METHODS.iter().enumerate() {
                let row = row.next().unwrap();
                let what = format!("{case}, seed {seed}, {id}");
                let run = &judged.runs[method][pattern];
                let mut expected = Expected::new();
                let counts = [run.steady.is_ok()];
                add_throughput(&mut expected, std::slice::from_ref(run), &counts);
                for (column, value) in [
                    ("pattern_seed", *seed as f64),
                    ("items", run.items as f64),
                    ("picked", run.picked as f64),
                    ("end_s", run.end),
                    ("picking_rate", run.rate()),
                    ("picks_upper_bound", judged.bounds[pattern].value),
                    ("weighted_rate", run.weighted_rate()),
                ] {
                    expected.insert(column, Some(value));
                }
                let words = ["case", "method", "assignment"];
                assert_row(&rows[0], row, &words, &expected, &what);
                let column = |name: &str| {
                    let place = rows[0].iter().position(|column| column == name);
                    row[place.unwrap()].clone()
                };
                assert_eq!([column("case"), column("method")], [case, id], "{what}");
                let rules = match method {
                    0 => "SPT FIFO".to_owned(),
                    1 => judged.chosen[pattern].names().join(" "),
                    _ => String::new(),
                };
                assert_eq!(column("assignment"), rules, "{what}");
            }
        }
    }
    assert!(row.next().is_none());
    assert!(rows[0].contains(&"weighted_rate_per_min".to_owned()));
    assert!(MADE.judged.iter().any(|judged| judged.weighs));
}

#[test]
fn every_cell_of_the_table_is_that_of_the_runs() {
    let rows = table_rows(&MADE.table);
    assert_eq!(
        rows[0],
        [
            "case",
            "method",
            "throughput [1/min]",
            "95 %",
            "flow [1/min]",
            "picked [%]",
            "time [s]",
            "picking rate [1/min]",
            "minus the first, 95 %",
            "benefit [%]",
            "certified [%]",
        ]
    );
    let mut row = rows[1..].iter();
    let dash = |text: String| {
        if text.is_empty() {
            "-".to_owned()
        } else {
            text
        }
    };
    for (judged, case) in MADE.judged.iter().zip(CASES) {
        for (method, title) in TITLES.iter().enumerate() {
            let figures = judged.expected(method, 0);
            let of = |name: &str| figures[name];
            let other = |text: String| if method == 0 { String::new() } else { text };
            let expected = [
                if method == 0 {
                    case.to_owned()
                } else {
                    String::new()
                },
                (*title).to_owned(),
                dash(shown(of("throughput"), 1)),
                shown_interval(of("throughput_low"), of("throughput_high"), 1),
                shown(of("flow"), 1),
                shown(of("picked_share").map(|share| 100.0 * share), 1),
                shown(of("end_s"), 1),
                shown(of("picking_rate"), 1),
                other(shown_interval(of("diff_low"), of("diff_high"), 2)),
                other(shown(of("benefit_percent"), 1)),
                shown(of("certified_percent"), 1),
            ];
            assert_eq!(row.next().unwrap()[..], expected, "{case}, {title}");
        }
        // A bound is rounded up, so that it stays one.
        let up = |value: f64| format!("{:.1}", (10.0 * value - 1e-9).ceil() / 10.0);
        let items: usize = judged.runs[0].iter().map(|run| run.items).sum();
        let first: Vec<f64> = judged.runs[0].iter().map(Raw::rate).collect();
        let highest: Vec<f64> = judged.bounds.iter().map(|b| b.rate.unwrap()).collect();
        let difference = paired(&highest, &first);
        let (low, high) = (difference.map(|d| d[0]), difference.map(|d| d[1]));
        let benefit = 100.0 * (mean(&highest) / mean(&first) - 1.0);
        let expected = [
            String::new(),
            "bound: no strategy beats".into(),
            String::new(),
            String::new(),
            String::new(),
            up(100.0 * judged.most() / items as f64),
            String::new(),
            up(mean(&highest)),
            shown_interval(low, high, 2),
            up(benefit),
            String::new(),
        ];
        assert_eq!(row.next().unwrap()[..], expected, "{case}");
    }
    let counts = "means over 4 of few; 4 of long; 1 of own";
    assert!(MADE.table.contains(counts), "{}", MADE.table);
}
