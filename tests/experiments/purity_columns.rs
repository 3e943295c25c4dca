//! Every figure of purity and recovery, recomputed from single runs.

use super::support::*;
use crate::common::csv_rows;
use pickline::pattern::{Pattern, load};
use pickline::purity::{BinContent, BinContents, bin_contents};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::{self, Overrides, Station};
use serde_json::Value;
use std::path::Path;

/// A line that sorts: pet and plastics at the first robot, whatever is left at the second.
const LINE: &str = "\
belt = { speed = 0.1, length = 3.2, width = 0.6 }
[[class]]
name = \"wood\"
wanted = false
[[robot]]
name = \"r1\"
base = [0.8, -0.4]
reach = 0.6
speed = 0.6
grasp_time = 0.4
release_time = 0.2
[[robot.bin]]
name = \"pet\"
at = [0.8, -0.5]
classes = [\"pet\"]
[[robot.bin]]
name = \"plastics\"
at = [0.9, -0.5]
classes = [\"pp\", \"hdpe\"]
[[robot]]
name = \"r2\"
base = [2.4, -0.4]
reach = 0.6
speed = 0.6
grasp_time = 0.4
release_time = 0.2
[[robot.bin]]
name = \"rest\"
at = [2.4, -0.5]
";

const METHODS: [&str; 2] = ["robust_gt", "rules:LPT,PP"];
const RULES: [&str; 2] = ["SPT,FIFO", "LPT,PP"];

/// A recorded pattern: classes, how certain they are, and of some items what they truly were.
fn recorded(first: usize) -> String {
    let rows = (0..24).map(|i| {
        let n = 7 * i + 5 * first;
        let class = ["pet", "pp", "hdpe", "glass", "wood"][n % 5];
        let p = ["0.9", "0.5", "", "0.7", "0.3"][(3 * i + i / 5 + first) % 5];
        let truth = ["", "", "pet", "", "-", "", "hdpe", ""][n % 8];
        let (x, y) = (-0.11 * i as f64, 0.1 * (n % 5) as f64 - 0.2);
        format!("{i},{x},{y},{p},{class},{truth}\n")
    });
    let rows: String = rows.collect();
    format!("id,x,y,p_detection,class,true_class\n{rows}")
}

/// The line, the patterns on which it is judged, and those on which thresholds are chosen.
struct Recorded {
    folder: tempfile::TempDir,
    station: Station,
    judged: Vec<Pattern>,
    training: Vec<Pattern>,
}

impl Recorded {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("line.toml"), LINE).unwrap();
        let write = |name: &str, numbers: [usize; 2]| -> Vec<Pattern> {
            let set = folder.path().join(name);
            std::fs::create_dir(&set).unwrap();
            let pattern = |number: usize| {
                let file = set.join(format!("{number}.csv"));
                std::fs::write(&file, recorded(number)).unwrap();
                load(&file).unwrap().pattern
            };
            numbers.map(pattern).to_vec()
        };
        let (judged, training) = (write("judged", [1, 2]), write("training", [3, 4]));
        let line = folder.path().join("line.toml");
        let station = station::load(line.to_str().unwrap(), Overrides::default()).unwrap();
        Self {
            station,
            judged,
            training,
            folder,
        }
    }

    fn call(&self, words: &str) -> String {
        let folder = self.folder.path().to_str().unwrap();
        run(&words.replace("DIR", folder))
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    /// What `rules` put into the bins in `count` runs on `patterns` in turn, the first with `seed`.
    fn contents(
        &self,
        patterns: &[Pattern],
        (count, seed): (usize, u64),
        rules: &str,
        least: f64,
    ) -> Vec<BinContents> {
        let runs = (0..count).map(|place| {
            let chance = Disturbances::default()
                .with_misdetections(true)
                .with_seed(seed + place as u64);
            let conditions = Conditions::default()
                .with_disturbances(chance)
                .with_min_detection(least);
            let pattern = &patterns[place % patterns.len()];
            let scene = Scene::under(&self.station, pattern, conditions).unwrap();
            let outcome = simulate_rules(&scene, &rules.parse().unwrap()).unwrap();
            bin_contents(&scene, &outcome.picks)
        });
        runs.collect()
    }
}

/// Student's t for 95 %, by the number of runs.
fn student(runs: usize) -> f64 {
    match runs {
        4 => 3.182_446_305,
        60 => 2.000_995_378,
        100 => 1.984_216_952,
        other => panic!("{other} runs"),
    }
}

/// A share over all runs with its ends, by the ratio estimator, or Wilson's if nothing scatters.
fn pooled(runs: &[(usize, usize)]) -> [Option<f64>; 3] {
    let sum = |of: fn(&(usize, usize)) -> usize| runs.iter().map(of).sum::<usize>() as f64;
    let (hits, trials) = (sum(|run| run.0), sum(|run| run.1));
    if trials == 0.0 {
        return [None; 3];
    }
    let (share, n) = (hits / trials, runs.len() as f64);
    let off = |run: &(usize, usize)| (run.0 as f64 - share * run.1 as f64) / (trials / n);
    let squares: f64 = runs.iter().map(|run| off(run).powi(2)).sum();
    let ends = if squares == 0.0 {
        // Wilson's.
        let z: f64 = 1.959_963_984_540_054;
        let middle = (share + z * z / (2.0 * trials)) / (1.0 + z * z / trials);
        let spread = share * (1.0 - share) / trials + (z / (2.0 * trials)).powi(2);
        let half = z / (1.0 + z * z / trials) * spread.sqrt();
        [middle - half, middle + half]
    } else {
        let half = student(runs.len()) * (squares / (n - 1.0) / n).sqrt();
        [share - half, share + half]
    };
    let ends = ends.map(|end| Some(end.clamp(0.0, 1.0)));
    [Some(share), ends[0], ends[1]]
}

/// The figures of some runs, in all bins or one.
fn expected(runs: &[BinContents], bin: Option<usize>) -> Expected {
    let of = |run: &BinContents| bin.map_or(run.total, |bin| run.bins[bin].1);
    let runs: Vec<BinContent> = runs.iter().map(of).collect();
    let sum = |of: fn(&BinContent) -> usize| Some(runs.iter().map(of).sum::<usize>() as f64);
    let share = |of: fn(&BinContent) -> usize| -> [Option<f64>; 3] {
        let pairs = runs.iter().map(|run| (run.rightly_binned, of(run)));
        pooled(&pairs.collect::<Vec<_>>())
    };
    let mut to = Expected::from([
        ("binned", sum(|run| run.binned)),
        ("rightly_binned", sum(|run| run.rightly_binned)),
        ("due", sum(|run| run.due)),
    ]);
    let purity = ["purity", "purity_low", "purity_high"];
    to.extend(purity.into_iter().zip(share(|run| run.binned)));
    let recovery = ["recovery", "recovery_low", "recovery_high"];
    to.extend(recovery.into_iter().zip(share(|run| run.due)));
    to
}

/// Holds an object of JSON to the figures of `runs`, and each bin in it.
fn assert_sorting(object: &Value, runs: &[BinContents], what: &str) {
    assert_object(object, &expected(runs, None), what);
    let bins = object["bins"].as_array().unwrap();
    let names: Vec<&str> = bins
        .iter()
        .map(|bin| bin["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["pet", "plastics", "rest"]);
    for (place, bin) in bins.iter().enumerate() {
        assert_object(
            bin,
            &expected(runs, Some(place)),
            &format!("{what}, bin {place}"),
        );
    }
}

/// Holds four rows of `purity.csv`, one in total and three of bins, to the figures of `runs`.
fn assert_purity_rows(
    header: &[String],
    rows: &[Vec<String>],
    runs: &[BinContents],
    words: &[&str],
) {
    let bin = header.iter().position(|name| name == "bin").unwrap();
    for (row, (name, place)) in rows.iter().zip([
        ("", None),
        ("pet", Some(0)),
        ("plastics", Some(1)),
        ("rest", Some(2)),
    ]) {
        assert_eq!(row[bin], name);
        assert_row(
            header,
            row,
            words,
            &expected(runs, place),
            &format!("{row:?}"),
        );
    }
}

#[test]
fn a_sweep_of_the_threshold_is_that_of_its_runs() {
    let line = Recorded::new();
    let values = [0.0, 0.4, 0.6, 0.8];
    let call = "sweep -q --seed 3 --station DIR/line.toml --sweep min-detection --from 0 --to 0.8 \
                --step 0.2 --patterns DIR/judged --train-patterns DIR/training --purity 0.6 \
                --strategy SPT,FIFO --strategy rules:LPT,PP --no-bound";
    let table = line.call(&format!("{call} --out DIR/out"));
    let report: Value = serde_json::from_str(&line.read("out/sweep.json")).unwrap();
    // Two recorded patterns, with a hundred draws of what their items are.
    assert_eq!(report["patterns"], 100);
    let purity = csv_rows(&line.read("out/purity.csv"));
    let sweep = csv_rows(&line.read("out/sweep.csv"));
    let points = report["points"].as_array().unwrap();
    for value in values {
        for (method, rules) in RULES.iter().enumerate() {
            // The seed after the master seed.
            let runs = line.contents(&line.judged, (100, 4), rules, value);
            let name = format!("rules:{rules}");
            let is_it = |point: &Value| point["value"] == value && point["method"] == *name;
            let place = points.iter().position(is_it).unwrap();
            let what = format!("{rules} at {value}");
            assert_sorting(&points[place]["sorting"], &runs, &what);
            let rows = &purity[1 + 4 * place..][..4];
            assert_eq!(rows[0][..2], [value.to_string(), name]);
            let words = ["min_detection", "method", "bin"];
            assert_purity_rows(&purity[0], rows, &runs, &words);
            let figures = expected(&runs, None);
            for (column, cell) in sweep[0].iter().zip(&sweep[1 + place]) {
                if let Some(figure) = figures.get(column.as_str()) {
                    assert_near(cell.parse().ok(), *figure, &format!("{what}: {column}"));
                }
            }
            assert!(sweep[0].contains(&"recovery_high".to_owned()), "{method}");
        }
    }
    check_thresholds(&line, &report, &table);
    // Next to rules that are given, the training set is for the threshold.
    line.call(&format!("{call} --robust SPT,FIFO --out DIR/given"));
    let given: Value = serde_json::from_str(&line.read("given/sweep.json")).unwrap();
    for place in [1, 2] {
        let of = |report: &Value| report["thresholds"]["methods"][place].clone();
        assert_eq!(of(&given), of(&report));
    }
}

/// The thresholds are those of the highest recovery on the training patterns, and what they are
/// worth is counted on the others.
fn check_thresholds(line: &Recorded, report: &Value, table: &str) {
    let thresholds = &report["thresholds"];
    assert_eq!(thresholds["purity"], 0.6);
    let rows = csv_rows(&line.read("out/thresholds.csv"));
    let methods = thresholds["methods"].as_array().unwrap();
    assert_eq!((methods.len(), rows.len()), (3, 7));
    for (place, rules) in RULES.iter().enumerate() {
        let method = &methods[1 + place];
        assert_eq!(method["method"], format!("rules:{rules}"));
        let at = |least: f64| line.contents(&line.training, (60, 3 + (1 << 32)), rules, least);
        let mut best: Option<(f64, f64)> = None;
        let mut purest = 0.0f64;
        for value in [0.0, 0.2, 0.4, 0.6, 0.8] {
            let figures = expected(&at(value), None);
            let [purity, recovery] = ["purity", "recovery"].map(|name| figures[name].unwrap());
            purest = purest.max(purity);
            if purity >= 0.6 && best.is_none_or(|best| recovery > best.1) {
                best = Some((value, recovery));
            }
        }
        let (value, _) = best.unwrap();
        assert_eq!(method["threshold"], value, "{method}");
        assert_near(method["purest_purity"].as_f64(), Some(purest), "purest");
        let trained = expected(&at(value), None);
        let fresh = expected(&line.contents(&line.judged, (100, 4), rules, value), None);
        assert_object(&method["trained"], &trained, "trained");
        assert_object(&method["fresh"], &fresh, "fresh");
        let words = ["method", "wanted_purity", "min_detection", "patterns"];
        assert_row(&rows[0], &rows[3 + 2 * place], &words, &trained, "training");
        assert_row(&rows[0], &rows[4 + 2 * place], &words, &fresh, "fresh");
        assert_eq!(
            rows[4 + 2 * place][1..4],
            ["0.6".into(), value.to_string(), "fresh".into()]
        );
        let told =
            format!("choose    rules:{rules}: {value} for a purity of 60 %; on fresh patterns");
        assert!(table.contains(&told), "{told} not in {table}");
    }
}

#[test]
fn where_no_threshold_is_pure_enough_it_says_so() {
    let line = Recorded::new();
    let call = "sweep -q --station DIR/line.toml --sweep min-detection --from 0 --to 0.4 --step 0.4 \
                --patterns DIR/judged --train-patterns DIR/training --purity 1 --no-bound";
    let table = line.call(call);
    assert!(
        table.contains("no threshold reaches a purity of 100 %; the highest is"),
        "{table}"
    );
    let report: Value = serde_json::from_str(&line.call(&format!("{call} --format json"))).unwrap();
    let method = &report["thresholds"]["methods"][0];
    for name in ["threshold", "trained", "fresh"] {
        assert!(method[name].is_null(), "{method}");
    }
}

#[test]
fn a_comparison_has_the_purity_of_its_runs() {
    let line = Recorded::new();
    let cases = "[[case]]\nname = \"own\"\npattern = \"judged/1.csv\"\n";
    std::fs::write(line.folder.path().join("cases.toml"), cases).unwrap();
    let table = line.call(
        "compare -q --seed 3 --station DIR/line.toml --cases DIR/cases.toml --replicates 4 \
         --misdetections --no-policy --no-greedy --no-bound --robust SPT,FIFO --strategy \
         rules:LPT,PP --out DIR/out",
    );
    let report: Value = serde_json::from_str(&line.read("out/compare.json")).unwrap();
    let purity = csv_rows(&line.read("out/purity.csv"));
    let all = csv_rows(&line.read("out/runs.csv"));
    for (method, rules) in RULES.iter().enumerate() {
        let runs = line.contents(&line.judged[..1], (4, 4), rules, 0.0);
        let result = &report["cases"][0]["results"][method];
        assert_sorting(&result["sorting"], &runs, rules);
        let rows = &purity[1 + 4 * method..][..4];
        assert_eq!(rows[0][..2], ["own", METHODS[method]]);
        assert_purity_rows(&purity[0], rows, &runs, &["case", "method", "bin"]);
        for (place, run) in runs.iter().enumerate() {
            let row = &all[1 + 2 * place + method];
            let cell = |name: &str| {
                let column = all[0].iter().position(|column| column == name).unwrap();
                row[column].parse::<usize>().unwrap()
            };
            let counts = ["picked", "rightly_binned", "due"].map(cell);
            let total = run.total;
            assert_eq!(counts, [total.binned, total.rightly_binned, total.due]);
        }
        // As the terminal shows it.
        let total = expected(&runs, None);
        let share = |name: &str| shown(total[name].map(|share| 100.0 * share), 1);
        let ends = |low: &str, high: &str| format!("{} to {}", share(low), share(high));
        let cells = table_rows(&table);
        let row = cells
            .iter()
            .filter(|row| row.get(2).is_some_and(|bin| bin == "all"));
        let row = row.clone().nth(method).unwrap();
        let expected = [
            share("purity"),
            ends("purity_low", "purity_high"),
            share("recovery"),
            ends("recovery_low", "recovery_high"),
        ];
        assert_eq!(row[4..], expected);
    }
}

#[test]
fn a_run_has_its_own_purity() {
    let line = Recorded::new();
    let call = "simulate -q --seed 5 --station DIR/line.toml --pattern DIR/judged/2.csv --strategy \
                SPT,FIFO --misdetections --check";
    let report: Value = serde_json::from_str(&line.call(&format!("{call} --format json"))).unwrap();
    let one = &line.contents(&line.judged[1..], (1, 5), "SPT,FIFO", 0.0)[0];
    let figures = |content: &BinContent| -> Expected {
        Expected::from([
            ("binned", Some(content.binned as f64)),
            ("rightly_binned", Some(content.rightly_binned as f64)),
            ("due", Some(content.due as f64)),
            ("purity", content.purity()),
            ("recovery", content.recovery()),
        ])
    };
    let sorting = &report["sorting"];
    assert_object(sorting, &figures(&one.total), "all bins");
    for (bin, (name, content)) in sorting["bins"].as_array().unwrap().iter().zip(&one.bins) {
        assert_eq!(bin["name"], *name);
        assert_object(bin, &figures(content), name);
    }
    let text = line.call(call);
    let words = format!(
        "{} of {} binned belong there",
        one.total.rightly_binned, one.total.binned
    );
    assert!(text.contains(&words), "{words} not in {text}");
}

/// Files of results are the same without the flag.
#[test]
fn nothing_is_said_of_purity_unless_it_is_asked_for() {
    let line = Recorded::new();
    let report = line.call(
        "simulate -q --station DIR/line.toml --pattern DIR/judged/1.csv --strategy SPT,FIFO \
         --format json",
    );
    assert!(
        !report.contains("purity") && !report.contains("sorting"),
        "{report}"
    );
    line.call(
        "sweep -q --station DIR/line.toml --patterns DIR/judged --robust SPT,FIFO --from 0.1 --to \
         0.2 --step 0.1 --no-bound --out DIR/out",
    );
    assert!(
        !Path::new(line.folder.path())
            .join("out/purity.csv")
            .exists()
    );
    for name in ["out/sweep.json", "out/sweep.csv"] {
        assert!(!line.read(name).contains("purity"), "{name}");
    }
}
