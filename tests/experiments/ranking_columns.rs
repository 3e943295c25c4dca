//! Every column of a search's ranking, of its validation and of the strategies beside it,
//! recomputed from single runs. That the fresh patterns are others than those of the search is
//! held here too.

use super::support::*;
use crate::common::csv_rows;
use pickline::pattern::{Pattern, PatternSource, Recipe};
use pickline::sim::{Conditions, Disturbances, Scene, simulate};
use pickline::station::{self, Overrides, Station};
use pickline::strategies::read_alone;
use serde_json::Value;

const SOURCE: &str = "random:60/min:4";
const RIVAL: &str = "rules:LPT,PP";

struct Found {
    station: Station,
    report: Value,
    table: String,
    ranking: Vec<Vec<String>>,
    strategies: Vec<Vec<String>>,
}

fn optimize(more: &str) -> Found {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    std::fs::write(&file, STATION).unwrap();
    let (line, out) = (file.to_str().unwrap(), folder.path().join("out"));
    let call = format!(
        "optimize -q --station {line} --patterns {SOURCE} --items 50 --seed 5 --validate 3 \
         --top 36 --strategy {RIVAL} --out {}",
        out.display()
    );
    let table = run(&format!("{call} {more}"));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let none = Overrides::default();
    Found {
        station: station::load(line, none).unwrap(),
        report: serde_json::from_str(&read("optimize.json")).unwrap(),
        ranking: csv_rows(&read("ranking.csv")),
        strategies: csv_rows(&read("strategies.csv")),
        table,
    }
}

/// The patterns of the source under `seed`.
fn drawn(station: &Station, source: &str, seed: u64) -> Vec<Pattern> {
    let recipe = Recipe::new(*station.belt(), 50, seed);
    let source: PatternSource = source.parse().unwrap();
    source.build(&recipe).unwrap().patterns
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// What `values` count as under a risk.
fn at_risk(values: &[f64], risk: &str) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match risk {
        "mean" => mean(values),
        "worst" => sorted[0],
        // The mean of the worse half.
        _ => mean(&sorted[..values.len().div_ceil(2)]),
    }
}

/// The figures of one line: `values` of the objective, `minus` those of the other.
fn add_objective(to: &mut Expected, values: &[f64], value: f64, difference: Option<[f64; 2]>) {
    to.insert("mean", Some(mean(values)));
    to.insert("value", Some(value));
    to.insert("diff_low", difference.map(|ends| ends[0]));
    to.insert("diff_high", difference.map(|ends| ends[1]));
    to.insert("worst", Some(least(values)));
}

/// The objective that `name` stands for.
fn objective(name: &str) -> fn(&Raw) -> f64 {
    match name {
        "picking-rate" => Raw::rate,
        "picked-share" => Raw::share,
        "weighted-rate" => Raw::weighted_rate,
        _ => panic!("{name}"),
    }
}

#[test]
fn ranking_validation_and_rivals_are_those_of_their_runs() {
    for (name, risk) in [
        ("picking-rate", "mean"),
        ("picked-share", "mean"),
        ("weighted-rate", "mean"),
        ("picking-rate", "worst"),
        ("weighted-rate", "cvar:0.5"),
    ] {
        let found = optimize(&format!("--objective {name} --risk {risk}"));
        let (station, report, of) = (&found.station, &found.report, objective(name));
        let patterns = drawn(station, SOURCE, 5);
        // Three fresh ones, of the seed after that of the search.
        let fresh = drawn(station, "random:60/min:3", 6);
        assert!(!fresh.iter().any(|pattern| patterns.contains(pattern)));
        let runs = |rules: &str, on: &[Pattern]| -> Vec<Raw> {
            let rules = rules.parse().unwrap();
            on.iter()
                .map(|pattern| Raw::of(station, pattern, &rules))
                .collect()
        };
        let values = |runs: &[Raw]| -> Vec<f64> { runs.iter().map(of).collect() };
        let rules = |line: &Value, separator: &str| {
            let names = line["assignment"].as_array().unwrap().iter();
            names
                .map(|n| n.as_str().unwrap())
                .collect::<Vec<_>>()
                .join(separator)
        };
        let lines = report["ranking"].as_array().unwrap();
        assert_eq!((lines.len(), found.ranking.len()), (36, 37));
        let best = values(&runs(&rules(&lines[0], ","), &patterns));
        let column = |figure: &str| format!("{}_{figure}", name.replace('-', "_"));
        for (place, (line, row)) in lines.iter().zip(&found.ranking[1..]).enumerate() {
            let what = format!("{name}, {}", rules(line, " "));
            let runs = runs(&rules(line, ","), &patterns);
            let own = values(&runs);
            let mut expected = Expected::new();
            // The best minus this one.
            let difference = match risk {
                "mean" => paired(&best, &own),
                // By bootstrap, which has no plain formula.
                _ => Some(["diff_low", "diff_high"].map(|key| line[key].as_f64().unwrap())),
            };
            add_objective(&mut expected, &own, at_risk(&own, risk), difference);
            expected.insert("picked_share", Some(mean_of(&runs, Raw::share)));
            let mut in_json = expected.clone();
            in_json.insert("max_speed", line["max_speed"].as_f64());
            assert_object(line, &in_json, &what);
            let [low, high] = difference.unwrap();
            assert_eq!(line["tied"], low <= 1e-12 && high >= -1e-12, "{what}");
            let worst = own.iter().position(|value| *value == least(&own)).unwrap();
            let label = format!("random 60/min #{}", worst + 1);
            assert_eq!(line["worst_pattern"], label, "{what}");
            // In the file under the objective's name.
            let header: Vec<String> = found.ranking[0]
                .iter()
                .map(|name| name.replace(&column(""), ""))
                .collect();
            assert!(header.contains(&"diff_low_per_min".into()) || name == "picked-share");
            let mut in_csv = expected.clone();
            in_csv.insert("rank", Some(1.0 + place as f64));
            in_csv.insert("max_speed_m_per_s", line["max_speed"].as_f64());
            let words = ["assignment", "tied", "worst_pattern"];
            assert_row(&header, row, &words, &in_csv, &what);
            let cell = |name: &str| {
                let place = header.iter().position(|column| column == name).unwrap();
                row[place].clone()
            };
            assert_eq!(cell("assignment"), rules(line, " "), "{what}");
            assert_eq!(cell("tied"), line["tied"].to_string(), "{what}");
            assert_eq!(cell("worst_pattern"), label, "{what}");
        }
        check_table(&found, name);
        let winner = runs(&rules(&lines[0], ","), &fresh);
        let own = values(&winner);
        let validation = &report["validation"];
        let mean_95 = interval(&own).unwrap();
        let whole = winner.iter().filter(|run| run.complete()).count();
        for (key, expected) in [
            ("count", 3.0),
            ("mean", mean(&own)),
            ("mean_low", mean_95[0]),
            ("mean_high", mean_95[1]),
            ("value", at_risk(&own, risk)),
            ("picked_share", mean_of(&winner, Raw::share)),
            ("worst", least(&own)),
            ("speed", 0.1),
            ("complete", whole as f64),
            ("complete_share", whole as f64 / 3.0),
        ] {
            assert_near(
                validation[key].as_f64(),
                Some(expected),
                &format!("{name}, {key}"),
            );
        }
        // This one minus the winner, on the fresh patterns.
        let rival = runs("LPT,PP", &fresh);
        let strategies = report["beside"]["strategies"].as_array().unwrap();
        for (place, (line, row)) in strategies.iter().zip(&found.strategies[1..]).enumerate() {
            let runs = [&winner, &rival][place];
            let difference = (place > 0).then(|| paired(&values(runs), &own).unwrap());
            let mut expected = Expected::new();
            let value = at_risk(&values(runs), risk);
            add_objective(&mut expected, &values(runs), value, difference);
            expected.insert("picked_share", Some(mean_of(runs, Raw::share)));
            expected.insert("patterns", Some(3.0));
            let what = format!("{name}, beside: {}", line["strategy"]);
            assert_object(line, &expected, &what);
            let header: Vec<String> = found.strategies[0]
                .iter()
                .map(|n| n.replace(&column(""), ""))
                .collect();
            assert_row(&header, row, &["strategy"], &expected, &what);
            assert_eq!(line["strategy"], row[0].as_str());
        }
        assert_eq!((strategies.len(), found.strategies.len()), (2, 3));
        assert_eq!(strategies[1]["strategy"], RIVAL);
        // It picks less, so the difference is mostly negative.
        let ends = ["diff_low", "diff_high"].map(|key| strategies[1][key].as_f64().unwrap());
        assert!(ends[0] + ends[1] < 0.0, "{name}: {ends:?}");
    }
}

/// The table for a terminal shows the numbers of the JSON, which the runs were held to.
fn check_table(found: &Found, name: &str) {
    let rows = table_rows(&found.table);
    let digits = if name == "picked-share" { 4 } else { 2 };
    let lines = found.report["ranking"].as_array().unwrap();
    let place = |header: &str| {
        rows[0]
            .iter()
            .position(|cell| cell.starts_with(header))
            .unwrap()
    };
    for (i, (row, line)) in rows[1..].iter().zip(lines).enumerate() {
        let of = |key: &str| line[key].as_f64();
        let difference = match i {
            0 => String::new(),
            _ => shown_interval(of("diff_low"), of("diff_high"), digits),
        };
        for (header, expected) in [
            ("#", (i + 1).to_string()),
            ("mean", shown(of("mean"), digits)),
            ("best minus this", difference),
            (
                "picked [%]",
                shown(of("picked_share").map(|share| 100.0 * share), 1),
            ),
            ("worst", shown(of("worst"), digits)),
            (
                "on pattern",
                line["worst_pattern"].as_str().unwrap().to_owned(),
            ),
        ] {
            assert_eq!(row[place(header)], expected, "{name}, {header}: {row:?}");
        }
    }
    let beside = &rows[1 + lines.len()..];
    let minus = beside[0]
        .iter()
        .position(|cell| cell.starts_with("minus ["))
        .unwrap();
    for (i, row) in beside[1..].iter().enumerate() {
        let line = &found.report["beside"]["strategies"][i];
        let of = |key: &str| line[key].as_f64();
        let difference = match i {
            0 => String::new(),
            _ => shown_interval(of("diff_low"), of("diff_high"), digits),
        };
        assert_eq!(row[0], line["strategy"].as_str().unwrap());
        assert_eq!(row[1], shown(of("mean"), digits), "{name}: {row:?}");
        let share = shown(of("picked_share").map(|share| 100.0 * share), 1);
        let expected = [difference, share, shown(of("worst"), digits)];
        assert_eq!(row[minus..], expected, "{name}: {row:?}");
    }
    let headers = [beside[0][minus + 1].as_str(), &beside[0][minus + 2][..5]];
    assert_eq!(headers, ["picked [%]", "worst"]);
    let words = "beside    the winner and other strategies on the same patterns\n";
    assert!(found.table.contains(words), "{}", found.table);
}

/// The balanced set's fresh patterns come of another seed and of other spacings.
#[test]
fn fresh_patterns_differ_from_those_of_the_search() {
    let station = station::built_in("paper").unwrap().station(None).unwrap();
    let recipe = |seed| Recipe::new(*station.belt(), 40, seed);
    for text in [
        "balanced:30",
        "poisson:0.2:30",
        "random:60/min:30",
        "clustered:60/min:30",
    ] {
        let source: PatternSource = text.parse().unwrap();
        let set = source.build(&recipe(1)).unwrap().patterns;
        let fresh = source.draw_fresh(&recipe(2), 60).unwrap().unwrap().patterns;
        assert_eq!(fresh.len(), 60);
        assert!(!fresh.iter().any(|pattern| set.contains(pattern)), "{text}");
        // What the verb draws is of the seed after its own.
        let call = format!(
            "optimize -q --format json --patterns {text} --items 40 --seed 1 --validate 2 \
             --no-bound --speed-step 0.02"
        );
        let report: Value = serde_json::from_str(&run(&call)).unwrap();
        let names = report["best"].as_array().unwrap().iter();
        let best: Vec<&str> = names.map(|name| name.as_str().unwrap()).collect();
        let best = best.join(",").parse().unwrap();
        let two = source.draw_fresh(&recipe(2), 2).unwrap().unwrap().patterns;
        let runs: Vec<Raw> = two.iter().map(|p| Raw::of(&station, p, &best)).collect();
        let expected = mean_of(&runs, Raw::rate);
        assert_near(report["validation"]["mean"].as_f64(), Some(expected), text);
    }
}

/// One grid is one pattern: where something can go wrong it is validated with luck that the
/// search did not have.
#[test]
fn a_grid_is_validated_with_independent_random_events() {
    let call = "optimize -q --format json --patterns grid:0.2 --items 24 --grasp-success 0.7 --seed 3 \
                --validate 5 --no-bound --speed-step 0.05";
    let report: Value = serde_json::from_str(&run(call)).unwrap();
    let station = station::built_in("paper").unwrap().station(None).unwrap();
    let grid = drawn_grid(&station);
    let best = &report["ranking"][0];
    let names = best["assignment"].as_array().unwrap().iter();
    let rules: Vec<&str> = names.map(|name| name.as_str().unwrap()).collect();
    let strategy = read_alone(&rules.join(","), 2).unwrap();
    let rates = |seeds: std::ops::Range<u64>| -> Vec<f64> {
        let of = |seed: u64| {
            let conditions = Conditions::default().with_disturbances(
                Disturbances::default()
                    .with_grasp_failures(true)
                    .with_default_p_grasp(0.7)
                    .with_seed(seed),
            );
            let scene = Scene::under(&station, &grid, conditions).unwrap();
            let outcome = simulate(&scene, strategy.make().as_mut()).unwrap();
            Raw::counted(&scene, &outcome).rate()
        };
        seeds.map(of).collect()
    };
    // A hundred draws of luck from the master seed on; the fresh ones are far from them.
    let searched = rates(3..103);
    assert_near(best["mean"].as_f64(), Some(mean(&searched)), "search");
    let far = 3 + (1 << 32);
    let fresh = rates(far..far + 5);
    assert_near(
        report["validation"]["mean"].as_f64(),
        Some(mean(&fresh)),
        "validation",
    );
    assert!((mean(&fresh) - mean(&rates(3..8))).abs() > 1e-6);
}

fn drawn_grid(station: &Station) -> Pattern {
    pickline::pattern::grid(station.belt().width, 0.2, 24).unwrap()
}
