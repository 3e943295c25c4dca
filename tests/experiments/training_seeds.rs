//! Robust GT is found on patterns that no method is judged on: training has the master seed,
//! or seeds far from it, and what is judged has those that follow it.

use super::support::{Raw, assignments, mean_of, run};
use pickline::experiment::{load_cases, training_set};
use pickline::pattern::{Pattern, PatternSource, Recipe};
use pickline::station::{Station, built_in};
use serde_json::Value;

fn station() -> Station {
    built_in("paper").unwrap().station(None).unwrap()
}

fn json(call: &str) -> Value {
    serde_json::from_str(&run(&format!("{call} -q --format json --no-bound"))).unwrap()
}

/// The assignment with the highest mean rate on `patterns`, as titles have it.
fn best_on(station: &Station, patterns: &[Pattern]) -> String {
    let rate = |text: &pickline::dispatch::RuleAssignment| {
        let runs: Vec<Raw> = patterns.iter().map(|p| Raw::of(station, p, text)).collect();
        mean_of(&runs, Raw::rate)
    };
    let all = assignments();
    let rates: Vec<f64> = all.iter().map(rate).collect();
    let best = (0..all.len()).reduce(|a, b| if rates[b] > rates[a] { b } else { a });
    format!("robust GT {}", all[best.unwrap()])
}

fn recipe(seed: u64) -> Recipe {
    Recipe {
        belt: *station().belt(),
        items: 15,
        shape: Default::default(),
        attributes: Default::default(),
        seed,
    }
}

#[test]
fn a_sweep_trains_under_the_master_seed_and_judges_under_the_next() {
    let station = station();
    let text = "random:40/min:5";
    let source: PatternSource = text.parse().unwrap();
    let judged = source.build(&recipe(4)).unwrap().patterns;
    let training = source.training_set(&recipe(3), 60).unwrap().set.patterns;
    assert_eq!(training.len(), 60);
    assert!(!judged.iter().any(|pattern| training.contains(pattern)));
    let report = json(&format!(
        "sweep --seed 3 --patterns {text} --items 15 --from 0.05 --to 0.05"
    ));
    let point = &report["points"][0];
    assert_eq!(point["title"], best_on(&station, &training));
    let rules = point["title"]
        .as_str()
        .unwrap()
        .trim_start_matches("robust GT ");
    let rules = rules
        .trim_matches(['[', ']'])
        .replace("; ", ",")
        .parse()
        .unwrap();
    let runs: Vec<Raw> = judged
        .iter()
        .map(|p| Raw::of(&station, p, &rules))
        .collect();
    let found = point["picking_rate_per_min"].as_f64().unwrap();
    assert!((found - mean_of(&runs, Raw::rate)).abs() < 1e-9, "{point}");
    let notes = report["notes"].to_string();
    assert!(notes.contains("seed 3"), "{notes}");
    assert!(
        report["made"].to_string().contains("seed 4"),
        "{}",
        report["made"]
    );
}

#[test]
fn a_comparison_trains_on_patterns_that_none_of_its_tables_has() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cases.toml");
    let cases = "[[case]]\nname = \"a\"\npoisson = 0.2\nitems = 15\n\
        [[case]]\nname = \"b\"\ngrid = 0.2\nitems = 15\n";
    std::fs::write(&file, cases).unwrap();
    let file = file.to_str().unwrap();
    let cases = load_cases(file).unwrap();
    let station = station();
    let training = training_set(&cases, station.belt(), None, 60, 3)
        .unwrap()
        .set
        .patterns;
    for case in &cases {
        for (_, judged) in case.patterns(station.belt(), 20, 4).unwrap() {
            assert!(!training.contains(&judged), "{}", case.name);
        }
    }
    let out = folder.path().join("out");
    let report = json(&format!(
        "compare --seed 3 --cases {file} --replicates 2 --no-policy --out {}",
        out.display()
    ));
    assert_eq!(report["methods"][0]["title"], best_on(&station, &training));
    // The rows are those of the seeds that follow the master seed.
    let runs = std::fs::read_to_string(out.join("runs.csv")).unwrap();
    let seeds = crate::common::csv_column(&runs, "pattern_seed");
    assert_eq!(seeds, ["4", "4", "5", "5", "4", "4"]);
}

/// Where something can go wrong robust GT meets other luck than what is judged: under the
/// same luck, on one grid, it would be found on the very runs.
#[test]
fn training_has_other_luck() {
    use pickline::sim::{Conditions, Disturbances, Scene, simulate};
    use pickline::strategies::read_alone;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    let rows = (0..12).map(|i: usize| {
        let x = -0.11 * i as f64;
        format!("{i},{x},{}\n", 0.15 * ((5 * i) % 7) as f64 - 0.45)
    });
    std::fs::write(&file, format!("id,x,y\n{}", rows.collect::<String>())).unwrap();
    let pattern = pickline::pattern::load(&file).unwrap().pattern;
    let station = station();
    let report = json(&format!(
        "sweep --seed 3 --patterns {} --grasp-success 0.6 --from 0.05 --to 0.05",
        file.display()
    ));
    let rate = |rules: &str, seeds: std::ops::Range<u64>| {
        let strategy = read_alone(rules, 2).unwrap();
        let run = |seed: u64| {
            let disturbances = Disturbances {
                grasp_failures: true,
                default_p_grasp: 0.6,
                position_noise: 0.0,
                seed,
            };
            let conditions = Conditions {
                disturbances,
                ..Conditions::default()
            };
            let scene = Scene::under(&station, &pattern, conditions).unwrap();
            let outcome = simulate(&scene, strategy.make().as_mut()).unwrap();
            Raw::counted(&scene, &outcome)
        };
        let runs: Vec<Raw> = seeds.map(run).collect();
        mean_of(&runs, Raw::rate)
    };
    let best = |seeds: std::ops::Range<u64>| {
        let all = assignments();
        let of = |a: &pickline::dispatch::RuleAssignment| rate(&a.names().join(","), seeds.clone());
        let rates: Vec<f64> = all.iter().map(of).collect();
        let best = (0..all.len()).reduce(|a, b| if rates[b] > rates[a] { b } else { a });
        all[best.unwrap()].clone()
    };
    let far = 3 + (1u64 << 32);
    let found = best(far..far + 60);
    let point = &report["points"][0];
    assert_eq!(point["title"], format!("robust GT {found}"));
    let judged = point["picking_rate_per_min"].as_f64().unwrap();
    // One pattern, with the luck of the seed after the master seed.
    let expected = rate(&found.names().join(","), 4..5);
    assert!((judged - expected).abs() < 1e-9, "{judged} and {expected}");
}
