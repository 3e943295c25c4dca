//! What `compare` and `sweep` have of their own, and the pictures of results.

use super::rig::{RATE, Rig, assert_near, number};
use super::runs::{at_random, one, rate_in};
use super::{Row, hold, row};
use serde_json::{Value, json};

const COMPARE: [&str; 1] = ["compare"];
const SWEEP: [&str; 1] = ["sweep"];
const BOTH: [&str; 2] = ["compare", "sweep"];
const PICTURES: [&str; 3] = ["optimize", "compare", "sweep"];

const DENSE: &str = "[[case]]\nname = \"d\"\npoisson = 0.15\nitems = 40\n";

pub const ROWS: &[Row] = &[
    row(&COMPARE, "--cases", |rig, verb| {
        rig.write("far.csv", "id,x,y\nA,-1,0\n");
        let mine = "[[case]]\nname = \"mine\"\npattern = \"far.csv\"\n";
        rig.write("mine.toml", mine);
        let call = one(verb).replace("c.toml", "mine.toml");
        let report = rig.json(&format!("{call} -q --format json"));
        assert_eq!(report["cases"][0]["name"], "mine");
        assert_near(rate_in(verb, &report), 60.0 / 16.5);
    }),
    row(&COMPARE, "--replicates", |rig, verb| {
        let patterns = |count| {
            let call = at_random(verb).replace("--replicates 2", count);
            let report = rig.json(&format!("{call} -q --format json --station one.toml"));
            number(&report, "/cases/0/patterns")
        };
        assert_eq!((patterns("--replicates 3"), patterns("")), (3.0, 100.0));
    }),
    row(&COMPARE, "--no-greedy", |rig, verb| {
        let call = one(verb).replace("--no-greedy", "");
        assert_eq!(methods(rig, &call), ["robust_gt", "greedy_gt"]);
        assert_eq!(methods(rig, &format!("{call} --no-greedy")), ["robust_gt"]);
    }),
    row(&COMPARE, "--no-policy", |rig, _| {
        let call = "compare --cases c.toml --robust SPT,FIFO --no-greedy --no-bound";
        let shipped: &[&str] = match cfg!(feature = "onnx") {
            true => &["robust_gt", "onnx"],
            false => &["robust_gt"],
        };
        assert_eq!(methods(rig, call), shipped);
        assert_eq!(methods(rig, &format!("{call} --no-policy")), ["robust_gt"]);
    }),
    row(&COMPARE, "--reference", |rig, verb| {
        // Items that FIFO does not take in the order that is best.
        rig.write(
            "c.toml",
            "[[case]]\nname = \"g\"\ngrid = 0.15\nitems = 24\n",
        );
        let call = one(verb).replace("--no-greedy", "");
        let benefit = |flags: &str| {
            let report = rig.json(&format!("{call} -q --format json {flags}"));
            let names: Vec<_> = report["methods"]
                .as_array()
                .unwrap()
                .iter()
                .map(|m| m["id"].clone())
                .collect();
            let results = &report["cases"][0]["results"];
            let value = |at: usize, name: &str| results[at][name].as_f64().unwrap();
            let [first, second] = [0, 1].map(|at| value(at, "picking_rate_per_min"));
            assert_near(value(1, "benefit_percent"), 100.0 * (second / first - 1.0));
            (names, second > first)
        };
        assert_eq!(
            benefit(""),
            (vec![json!("robust_gt"), json!("greedy_gt")], true)
        );
        let other = (vec![json!("greedy_gt"), json!("robust_gt")], false);
        assert_eq!(benefit("--reference greedy_gt"), other);
        rig.refused(
            &format!("{call} --reference nobody"),
            &["--reference: `nobody`"],
        );
    }),
    row(&COMPARE, "--tune", |rig, verb| {
        rig.write("dense.toml", DENSE);
        let call = one(verb).replace("c.toml", "dense.toml");
        assert_eq!(methods(rig, &call), ["robust_gt"]);
        let call = format!("{call} --tune");
        assert_eq!(methods(rig, &call), ["robust_gt", "rival"]);
        let reversed = format!("{call} --reference rival");
        assert_eq!(methods(rig, &reversed), ["rival", "robust_gt"]);
        // The row is the strategy that the note names, with its parameters.
        let report = rig.json(&format!("{call} -q --format json"));
        let notes = report["notes"].as_array().unwrap().iter();
        let mut notes = notes.filter_map(|note| note.as_str()?.strip_prefix("rival is "));
        let (strategy, _) = notes.next().unwrap().split_once(", the best of").unwrap();
        let given = format!("{} -q --format json --strategy {strategy}", one(verb));
        let given = rig.json(&given.replace("c.toml", "dense.toml"));
        for name in ["picked_share", "end_s", "picking_rate_per_min"] {
            let at = format!("/cases/0/results/1/{name}");
            assert_eq!(number(&report, &at), number(&given, &at), "{name}");
        }
    }),
    row(&COMPARE, "--paper", |rig, _| {
        let call = "compare -q --robust SPT,FIFO --no-greedy --no-policy --no-bound --replicates 1";
        let columns = |flags: &str| {
            let table = rig.text(&format!("{call} {flags}"));
            table.matches("paper: picked").count()
        };
        assert_eq!((columns(""), columns("--paper")), (0, 1));
        // Robust GT is found on the paper's own set.
        let call =
            "compare -q --format json --cases c.toml --station one.toml --no-greedy --no-bound";
        let note = |flags: &str| {
            let report = rig.json(&format!("{call} {flags}"));
            report["notes"][0].as_str().unwrap().to_owned()
        };
        assert!(note("").starts_with("robust GT has the highest mean picking rate on"));
        assert!(
            note("--paper --train-items 1")
                .starts_with("robust GT is the best on 120 grid and 120 Poisson")
        );
    }),
    row(&BOTH, "--strategy", |rig, verb| {
        let call = |flags| format!("{} {flags}", one(verb));
        assert_eq!(methods(rig, &call("")), ["robust_gt"]);
        let all = ["robust_gt", "rules:LD", "rules:SPT"];
        assert_eq!(methods(rig, &call("--strategy LD --strategy SPT")), all);
    }),
    row(&BOTH, "--no-bound", |rig, verb| {
        let call = one(verb).replace("--no-bound", "");
        let bounded = |flags: &str| {
            let report = rig.json(&format!("{call} -q --format json {flags}"));
            report["cases"][0]["bound"].is_object() || report["bounds"].is_object()
        };
        assert_eq!((bounded(""), bounded("--no-bound")), (true, false));
    }),
    row(&BOTH, "--robust", |rig, verb| {
        let title = |rules: &str| {
            let call = one(verb).replace("--robust FIFO", &format!("--robust {rules}"));
            title(&rig.json(&format!("{call} -q --format json")))
        };
        assert_eq!(title("SPT"), "robust GT [SPT]");
        assert_eq!(title("LD"), "robust GT [LD]");
    }),
    row(&BOTH, "--train-patterns", |rig, verb| {
        // On a single item all rules are one, and the first of them is taken.
        assert_ne!(trained(rig, verb, ""), "robust GT [FIFO]");
        let found = trained(rig, verb, "--train-patterns p.csv");
        assert_eq!(found, "robust GT [FIFO]");
    }),
    row(&BOTH, "--train-items", |rig, verb| {
        assert_eq!(trained(rig, verb, "--train-items 1"), "robust GT [FIFO]");
        let set = "--train-patterns grid:0.15 --train-items";
        assert_eq!(trained(rig, verb, &format!("{set} 1")), "robust GT [FIFO]");
        assert_ne!(trained(rig, verb, &format!("{set} 24")), "robust GT [FIFO]");
    }),
    row(&SWEEP, "--sweep", |rig, verb| {
        let swept = |name: &str| {
            let call = one(verb).replace("--sweep reach", name);
            let report = rig.json(&format!("{call} -q --format json"));
            let rate = number(&report, "/points/0/picking_rate_per_min");
            (report["sweep"].clone(), report["unit"].clone(), rate)
        };
        let (name, unit, rate) = swept("--sweep reach");
        assert_eq!((name, unit), (json!("reach"), json!("m")));
        assert_near(rate, RATE);
        // Without its only robot the line picks nothing.
        let report = rig.json(
            "sweep -q --format json --patterns p.csv --robust FIFO --station one.toml --sweep \
             robots-down",
        );
        assert_eq!(report["sweep"], "robots-down");
        assert_near(number(&report, "/points/0/picking_rate_per_min"), RATE);
        assert_eq!(report["points"][1]["robot_down"], "a");
        assert_near(number(&report, "/points/1/picking_rate_per_min"), 0.0);
        assert_near(number(&report, "/points/1/loss_percent"), 100.0);
        // At 0.5 m/s the belt is as fast as the arm; at 0.2 m/s see `--belt-speed`.
        let call = "sweep -q --format json --patterns p.csv --robust FIFO --no-bound \
                    --station one.toml --from 0.1 --to 0.2 --step 0.1";
        for name in ["", "--sweep speed"] {
            let report = rig.json(&format!("{call} {name}"));
            assert_eq!(report["sweep"], "speed");
            assert_near(number(&report, "/points/0/picking_rate_per_min"), RATE);
            assert_near(
                number(&report, "/points/1/picking_rate_per_min"),
                60.0 / 4.0,
            );
        }
    }),
    row(&SWEEP, "--purity", |rig, _| {
        let call = "sweep -q --format json --station one.toml --sweep min-detection --patterns \
                    poisson:0.4:4 --items 6 --p-detection uniform:0,1 --robust FIFO --no-bound";
        let report = rig.json(call);
        assert!(report["thresholds"].is_null(), "{report}");
        assert!(
            report["points"][0]["sorting"]["purity"].is_number(),
            "{report}"
        );
        let report = rig.json(&format!("{call} --purity 0.6 --svg chart.svg"));
        assert_eq!(report["thresholds"]["purity"], 0.6);
        let method = &report["thresholds"]["methods"][0];
        assert!(number(method, "/trained/purity") >= 0.6, "{method}");
        let svg = rig.read("chart.svg");
        assert!(svg.contains("Purity and recovery") && svg.contains("wanted purity"));
    }),
    row(&SWEEP, "--from", |rig, verb| {
        let values = values(rig, verb, "--from 0.4");
        assert_eq!((values[0], values.last()), (0.4, Some(&0.8)));
    }),
    row(&SWEEP, "--to", |rig, verb| {
        let values = values(rig, verb, "--to 0.6");
        assert_eq!((values[0], values.last()), (0.2, Some(&0.6)));
    }),
    row(&SWEEP, "--step", |rig, verb| {
        assert_eq!(values(rig, verb, "--step 0.2"), [0.2, 0.4, 0.6, 0.8]);
        assert_eq!(values(rig, verb, "").len(), 13);
    }),
    row(&SWEEP, "--greedy", |rig, verb| {
        let call = format!("{} --greedy", one(verb));
        assert_eq!(methods(rig, &call), ["robust_gt", "greedy_gt"]);
    }),
    row(&SWEEP, "--tune", |rig, verb| {
        let call = format!("{} --tune", one(verb));
        assert_eq!(methods(rig, &call), ["robust_gt", "rival"]);
        let call = "sweep -q --format json --patterns poisson:0.12:3 --items 40 --no-bound";
        let note = |report: &Value| {
            let mut notes = report["notes"].as_array().unwrap().iter();
            let rival = notes.find_map(|note| note.as_str()?.strip_prefix("rival is "));
            rival.unwrap().to_owned()
        };
        let picked = |report: &Value, method: &str| {
            let mut points = report["points"].as_array().unwrap().iter();
            let point = points.rfind(|point| point["method"] == method).unwrap();
            point["picked_share"].as_f64().unwrap()
        };
        // Tuned for every number of robots: the last is what the note names last.
        let robots = format!("{call} --sweep robots --from 2 --to 3");
        let swept = rig.json(&format!("{robots} --tune"));
        let last = note(&swept);
        let (_, last) = last.rsplit_once(", 3 ").unwrap();
        let alone = format!("{call} --sweep robots --from 3 --to 3 --strategy {last}");
        assert_eq!(picked(&swept, "rival"), picked(&rig.json(&alone), last));
        // With a robot down, it is that of the whole line.
        let halted = format!("{call} --sweep robots-down --robust SPT,FIFO");
        let tuned = rig.json(&format!("{halted} --tune"));
        let rival = note(&tuned);
        let (rival, _) = rival.split_once(", the best of").unwrap();
        let given = rig.json(&format!("{halted} --strategy {rival}"));
        assert_eq!(picked(&tuned, "rival"), picked(&given, rival));
    }),
    row(&PICTURES, "--html", |rig, verb| {
        rig.done(&format!("{} -q --html page.html", one(verb)));
        let page = rig.read("page.html");
        assert!(page.starts_with("<!doctype html>") && page.contains("<svg"));
        assert!(page.contains(&format!("pickline {verb} ")), "{page}");
    }),
    row(&PICTURES, "--svg", |rig, verb| {
        let main = match verb {
            "optimize" => "How far below [FIFO]",
            "compare" => "Picking rate",
            _ => "Items picked",
        };
        assert_eq!(drawn(rig, verb, ""), main);
    }),
    row(&PICTURES, "--chart", |rig, verb| {
        let charts: &[[&str; 2]] = match verb {
            "optimize" => &[
                ["spread", "Mean and worst pattern"],
                ["ranking", "All assignments"],
            ],
            "compare" => &[
                [
                    "difference",
                    "Difference from robust GT (game theory) [FIFO]",
                ],
                ["picked", "Items picked"],
            ],
            _ => &[
                ["rate", "Picking rate"],
                ["limits", "Limits of single patterns"],
            ],
        };
        for [chart, title] in charts {
            assert_eq!(drawn(rig, verb, &format!("--chart {chart}")), *title);
        }
    }),
];

#[test]
fn options_of_experiments_have_their_effect() {
    hold(ROWS);
}

/// The methods that `call` reports.
fn methods(rig: &Rig, call: &str) -> Vec<String> {
    let report = rig.json(&format!("{call} -q --format json"));
    let (list, name) = match report["methods"].as_array() {
        Some(methods) => (methods.clone(), "id"),
        None => {
            let points = report["points"].as_array().unwrap();
            let first = points
                .iter()
                .filter(|point| point["value"] == points[0]["value"]);
            (first.cloned().collect(), "method")
        }
    };
    list.iter()
        .map(|method| method[name].as_str().unwrap().to_owned())
        .collect()
}

/// What robust GT is called.
fn title(report: &Value) -> String {
    let title = report
        .pointer("/methods/0/title")
        .or(report.pointer("/points/0/title"));
    title.unwrap().as_str().unwrap().to_owned()
}

/// Robust GT as it is found for a dense grid of 24 items, on which FIFO is not the best.
pub fn trained(rig: &Rig, verb: &str, flags: &str) -> String {
    rig.write(
        "c.toml",
        "[[case]]\nname = \"g\"\ngrid = 0.15\nitems = 24\n",
    );
    let call = one(verb).replace("--robust FIFO", "");
    let call = call.replace("p.csv", "grid:0.15 --items 24");
    title(&rig.json(&format!("{call} -q --format json {flags}")))
}

/// The values of reach that are swept.
fn values(rig: &Rig, verb: &str, flags: &str) -> Vec<f64> {
    let call = one(verb).replace("--from 0.5 --to 0.6 --step 0.1", flags);
    let report = rig.json(&format!("{call} -q --format json"));
    let points = report["points"].as_array().unwrap();
    points
        .iter()
        .map(|point| point["value"].as_f64().unwrap())
        .collect()
}

/// The title of the chart that is drawn.
fn drawn(rig: &Rig, verb: &str, flags: &str) -> String {
    let call = at_random(verb).replace("--no-greedy", "");
    let call = call.replace("--sweep reach --from 0.5 --to 0.6", "--from 0.1 --to 0.2");
    rig.done(&format!(
        "{call} -q --station one.toml --svg chart.svg {flags}"
    ));
    let svg = rig.read("chart.svg");
    let svg = roxmltree::Document::parse(&svg).unwrap();
    let title = svg.descendants().find(|node| node.has_tag_name("title"));
    title.unwrap().text().unwrap().to_owned()
}
