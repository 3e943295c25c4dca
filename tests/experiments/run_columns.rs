//! Every figure of a single run, counted from its picks and its failed attempts.

use super::support::{Raw, STATION, assert_near, run, shown, table_rows, weighted};
use crate::common::csv_rows;
use pickline::decision::{Outcome, Pick};
use pickline::pattern::{Pattern, load};
use pickline::sim::{Conditions, Disturbances, Scene, simulate};
use pickline::station::{self, Overrides, Station};
use pickline::strategies::read_alone;
use serde_json::Value;
use std::collections::BTreeMap;

/// Robots that do not reach the middle row, grasps that fail, items of unlike weights.
struct Made {
    station: Station,
    pattern: Pattern,
    outcome: Outcome,
    raw: Raw,
    table: String,
    report: Value,
    csv: Vec<Vec<String>>,
}

fn made() -> Made {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(
        file("line.toml"),
        STATION.replace("reach = 0.55", "reach = 0.37"),
    )
    .unwrap();
    std::fs::write(file("own.csv"), weighted(3)).unwrap();
    let (line, own) = (file("line.toml"), file("own.csv"));
    let call = |format: &str| {
        run(&format!(
            "simulate -q --station {line} --pattern {own} --strategy SPT,LPT --grasp-success 0.6 \
             --seed 4 --no-bound --format {format}"
        ))
    };
    let none = Overrides::default();
    let station = station::load(&line, none).unwrap();
    let pattern = load(own.as_ref()).unwrap().pattern;
    let conditions = Conditions::default().with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.6)
            .with_seed(4),
    );
    let scene = Scene::under(&station, &pattern, conditions).unwrap();
    let strategy = read_alone("SPT,LPT", 2).unwrap();
    let outcome = simulate(&scene, strategy.make().as_mut()).unwrap();
    Made {
        raw: Raw::counted(&scene, &outcome),
        report: serde_json::from_str(&call("json")).unwrap(),
        csv: csv_rows(&call("csv")),
        table: call("table"),
        station: station.clone(),
        pattern: pattern.clone(),
        outcome,
    }
}

#[test]
fn the_figures_of_a_run_are_counted_from_its_picks() {
    let Made {
        station,
        pattern,
        outcome,
        raw,
        table,
        report,
        csv,
    } = made();
    assert!(outcome.failures.len() > 2 && raw.picked > 5 && raw.picked < 20);
    for (key, expected) in [
        ("items", 30.0),
        ("picked", raw.picked as f64),
        ("picked_share", raw.share()),
        ("end_s", raw.end),
        ("picking_rate_per_min", raw.rate()),
        ("weighted_rate_per_min", raw.weighted_rate()),
    ] {
        assert_near(report[key].as_f64(), Some(expected), key);
    }
    let rows = table_rows(&table);
    assert_eq!(rows[0], ["robot", "picked", "busy [s]", "utilisation [%]"]);
    for (index, robot) in station.robots().iter().enumerate() {
        let picks = outcome.picks.iter().filter(|pick| pick.robot == index);
        let failed = outcome.failures.iter().map(|failure| &failure.attempt);
        let failed = failed.filter(|attempt| attempt.robot == index);
        let busy = |pick: &Pick| pick.release - pick.decide;
        let busy: f64 = picks.clone().chain(failed.clone()).map(busy).sum();
        let weight: f64 = picks
            .clone()
            .map(|p| pattern.items()[p.item as usize].weight.unwrap())
            .sum();
        let (picked, failed) = (picks.count(), failed.count());
        assert!(picked > 0 && failed > 0 && weight != picked as f64);
        let found = &report["robots"][index];
        assert_eq!(found["name"], robot.name.as_str());
        for (key, expected) in [
            ("picked", picked as f64),
            ("weight", weight),
            ("failed", failed as f64),
            ("busy_s", busy),
            ("utilisation", busy / raw.end),
        ] {
            assert_near(
                found[key].as_f64(),
                Some(expected),
                &format!("{}: {key}", robot.name),
            );
        }
        let share = shown(Some(100.0 * busy / raw.end), 1);
        let expected = [
            robot.name.clone(),
            picked.to_string(),
            shown(Some(busy), 1),
            share,
        ];
        assert_eq!(rows[1 + index][..], expected);
    }
    let failed = |robot: usize| report["robots"][robot]["failed"].clone();
    for line in [
        format!(
            "picked    {} of 30 ({} %) in {} s",
            raw.picked,
            shown(Some(100.0 * raw.share()), 1),
            shown(Some(raw.end), 1)
        ),
        format!(
            "rate      {} picks/min over the whole run, weighted {} /min",
            shown(Some(raw.rate()), 2),
            shown(Some(raw.weighted_rate()), 2)
        ),
        format!(
            "failed    {} attempts (r1 {}, r2 {})",
            outcome.failures.len(),
            failed(0),
            failed(1)
        ),
    ] {
        assert!(table.contains(&line), "{line} not in {table}");
    }
    // Picks and failed attempts, in order of decision.
    let mut attempts: Vec<(&Pick, &str)> = outcome.picks.iter().map(|pick| (pick, "")).collect();
    attempts.extend(outcome.failures.iter().map(|f| (&f.attempt, "grasp")));
    attempts.sort_by(|a, b| {
        a.0.decide
            .total_cmp(&b.0.decide)
            .then(a.0.robot.cmp(&b.0.robot))
    });
    let columns = [
        "robot",
        "item",
        "decide_s",
        "grasp_s",
        "release_s",
        "meet_x_m",
        "meet_y_m",
        "failure",
    ];
    assert_eq!(csv[0], columns);
    assert_eq!(csv.len(), 1 + attempts.len());
    for (row, (pick, cause)) in csv[1..].iter().zip(attempts) {
        let id = &pattern.items()[pick.item as usize].id;
        let words = [&row[0], &row[1], &row[7]];
        assert_eq!(words, [&station.robots()[pick.robot].name, id, cause]);
        let numbers = [
            pick.decide,
            pick.grasp,
            pick.release,
            pick.meet.x,
            pick.meet.y,
        ];
        for (cell, (expected, column)) in row[2..7].iter().zip(numbers.iter().zip(&columns[2..])) {
            assert_near(cell.parse().ok(), Some(*expected), column);
        }
    }
    check_objects(&report, &outcome, &pattern);
}

/// The lists of the JSON: picks, failed attempts and what was missed, each for its reason.
fn check_objects(report: &Value, outcome: &Outcome, pattern: &Pattern) {
    let check = |found: &Value, pick: &Pick| {
        let id = &pattern.items()[pick.item as usize].id;
        assert_eq!(found["robot"], pick.robot);
        assert_eq!(found["item"], id.as_str());
        for (key, expected) in [
            ("decide_s", pick.decide),
            ("grasp_s", pick.grasp),
            ("release_s", pick.release),
        ] {
            assert_near(found[key].as_f64(), Some(expected), key);
        }
        assert_near(found["meet"][0].as_f64(), Some(pick.meet.x), "meet x");
        assert_near(found["meet"][1].as_f64(), Some(pick.meet.y), "meet y");
    };
    let list = |name: &str| report[name].as_array().unwrap().clone();
    assert_eq!(list("picks").len(), outcome.picks.len());
    for (found, pick) in list("picks").iter().zip(&outcome.picks) {
        check(found, pick);
    }
    assert_eq!(list("failures").len(), outcome.failures.len());
    for (found, failure) in list("failures").iter().zip(&outcome.failures) {
        check(found, &failure.attempt);
        assert_eq!(found["cause"], "grasp");
    }
    // The middle row is out of reach; who was attempted and is left was never grasped.
    let picked = |id: &str| list("picks").iter().any(|pick| pick["item"] == id);
    let tried = |id: &str| list("failures").iter().any(|pick| pick["item"] == id);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for item in pattern.items().iter().filter(|item| !picked(&item.id)) {
        let miss = list("missed")
            .into_iter()
            .find(|miss| miss["item"] == item.id.as_str());
        let reason = miss.unwrap()["reason"].as_str().unwrap().to_owned();
        let expected = match (item.y == 0.0, tried(&item.id)) {
            (true, _) => "unreachable",
            (_, true) => "grasp_failed",
            _ if reason == "passed_over" => "passed_over",
            _ => "busy",
        };
        assert_eq!(reason, expected, "{}", item.id);
        *counts.entry(expected).or_default() += 1;
    }
    assert_eq!(counts["unreachable"], 10);
    assert_eq!(list("missed").len(), counts.values().sum::<usize>());
    for reason in [
        "unreachable",
        "grasp_failed",
        "passed_over",
        "unseen",
        "busy",
    ] {
        let count = counts.get(reason).copied().unwrap_or_default();
        assert_eq!(report["missed_by_reason"][reason], count, "{reason}");
    }
}
