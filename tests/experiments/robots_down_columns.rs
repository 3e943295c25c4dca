//! Every column of a sweep over halted robots, recomputed from single runs.

use super::support::*;
use crate::common::csv_rows;
use pickline::pattern::{Pattern, load};
use pickline::sim::{Conditions, Outage, Scene, simulate_rules};
use pickline::station::{self, Overrides, Station};
use serde_json::Value;

/// Methods in files, and the rules that they are.
const METHODS: [(&str, &str); 2] = [("robust_gt", "SPT,FIFO"), ("rules:LPT,PP", "LPT,PP")];
const HALTED: [Option<&str>; 3] = [None, Some("r1"), Some("r2")];

/// The runs of `rules` with this robot down for the whole run.
fn runs(station: &Station, patterns: &[Pattern], robot: Option<&str>, rules: &str) -> Vec<Raw> {
    let run = |pattern: &Pattern| {
        let outage = robot.map(|name| Outage::new(name, 0.0, f64::INFINITY));
        let plain = Conditions::default();
        let conditions = outage.into_iter().fold(plain, Conditions::with_outage);
        let scene = Scene::under(station, pattern, conditions).unwrap();
        Raw::counted(
            &scene,
            &simulate_rules(&scene, &rules.parse().unwrap()).unwrap(),
        )
    };
    patterns.iter().map(run).collect()
}

/// What is expected of `own` runs beside those of the whole line, and of all for the throughput.
fn expected(own: &[Raw], whole: Option<&Vec<Raw>>, counts: &[bool]) -> Expected {
    let mut to = Expected::new();
    add_throughput(&mut to, own, counts);
    add_rates(&mut to, own);
    let picked = |runs: &[Raw]| -> Vec<f64> { runs.iter().map(|run| run.picked as f64).collect() };
    let loss = whole.map(|whole| {
        let (before, after) = (picked(whole), picked(own));
        let lost = 1.0 - mean(&after) / mean(&before);
        // Cochran's variance of a ratio, from the residuals of what is lost on each pattern.
        let off: Vec<f64> = before
            .iter()
            .zip(&after)
            .map(|(b, a)| (b - a - lost * b) / mean(&before))
            .collect();
        let [low, high] = interval(&off).unwrap();
        [lost, lost + low, (lost + high).min(1.0)].map(|share| 100.0 * share)
    });
    let of = |place: usize| loss.map(|loss| loss[place]);
    to.insert("loss_percent", of(0));
    for (place, names) in [
        (1, ["loss_low", "loss_low_percent"]),
        (2, ["loss_high", "loss_high_percent"]),
    ] {
        to.extend(names.map(|name| (name, of(place))));
    }
    to.insert("robot_down", None);
    to
}

#[test]
fn a_sweep_over_halted_robots_is_that_of_its_runs() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(
        file("line.toml"),
        STATION.replace("grasp_time = 0.3", "grasp_time = 1.5"),
    )
    .unwrap();
    std::fs::create_dir(file("set")).unwrap();
    let patterns: Vec<Pattern> = (0..3)
        .map(|n| {
            let file = folder.path().join(format!("set/{n}.csv"));
            std::fs::write(&file, weighted(n)).unwrap();
            load(&file).unwrap().pattern
        })
        .collect();
    let (line, set, out) = (file("line.toml"), file("set"), file("out"));
    let station = station::load(&line, Overrides::default()).unwrap();
    let names: Vec<&str> = station.robots().iter().map(|robot| &*robot.name).collect();
    assert_eq!(names, ["r1", "r2"]);
    let table = run(&format!(
        "sweep -q --sweep robots-down --station {line} --patterns {set} --robust SPT,FIFO \
         --strategy rules:LPT,PP --out {out}"
    ));
    let all: Vec<Vec<Raw>> = HALTED
        .iter()
        .flat_map(|robot| METHODS.map(|(_, rules)| runs(&station, &patterns, *robot, rules)))
        .collect();
    let counts = counted(&all.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let report = std::fs::read_to_string(file("out/sweep.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let csv = csv_rows(&std::fs::read_to_string(file("out/sweep.csv")).unwrap());
    let rows = table_rows(&table);
    assert_eq!(
        (report["sweep"].as_str(), report["patterns"].as_u64()),
        (Some("robots-down"), Some(3))
    );
    assert_eq!((csv.len(), rows.len()), (7, 7));
    for (place, own) in all.iter().enumerate() {
        let (entry, method) = (place / METHODS.len(), place % METHODS.len());
        let whole = (entry > 0).then(|| &all[method]);
        let expected = expected(own, whole, &counts[place]);
        let what = format!("{:?}, {}", HALTED[entry], METHODS[method].0);
        let point = &report["points"][place];
        assert_eq!(point["robot_down"].as_str(), HALTED[entry], "{what}");
        assert_eq!(point["method"], METHODS[method].0, "{what}");
        assert_object(point, &expected, &what);
        let row = &csv[place + 1];
        assert_eq!(row[0], HALTED[entry].unwrap_or_default(), "{what}");
        assert_eq!(row[1], METHODS[method].0, "{what}");
        assert_row(&csv[0], row, &["robot_down", "method"], &expected, &what);
        let cell = |name: &str| {
            let column = rows[0].iter().position(|header| header == name).unwrap();
            rows[place + 1][column].clone()
        };
        let percent = |name: &str| shown(expected[name].map(|share| 100.0 * share), 1);
        let halted = match method {
            0 => HALTED[entry].unwrap_or("none"),
            _ => "",
        };
        assert_eq!(cell("robot down"), halted, "{what}");
        assert_eq!(cell("picked [%]"), percent("picked_share"), "{what}");
        assert_eq!(
            cell("picking rate [1/min]"),
            shown(expected["picking_rate"], 2)
        );
        assert_eq!(
            cell("weighted [1/min]"),
            shown(expected["weighted_rate"], 2)
        );
        assert_eq!(
            cell("loss [%]"),
            shown(expected["loss_percent"], 1),
            "{what}"
        );
        let ends = match whole {
            Some(_) => shown_interval(expected["loss_low"], expected["loss_high"], 1),
            None => String::new(),
        };
        assert_eq!(cell("loss, 95 %"), ends, "{what}");
    }
    // Both robots are missed, and the one that is missed most is named.
    for (method, (name, _)) in METHODS.iter().enumerate() {
        let loss = |entry: usize| {
            report["points"][2 * entry + method]["loss_percent"]
                .as_f64()
                .unwrap()
        };
        let (worst, robot) = if loss(2) > loss(1) {
            (loss(2), "r2")
        } else {
            (loss(1), "r1")
        };
        assert!(loss(1) > 0.0 && loss(2) > 0.0);
        let line = format!("worst     {name}: without {robot}, {worst:.1} % fewer picks\n");
        assert!(table.contains(&line), "{line} not in {table}");
    }
}
