//! What `optimize`, `game`, `bound` and `simulate` have of their own.

use super::rig::{RATE, Rig, assert_near, number};
use super::runs::{at_random, one, rate_in, report};
use super::{Row, hold, row};
use serde_json::{Value, json};

const OPTIMIZE: [&str; 1] = ["optimize"];
const GAME: [&str; 1] = ["game"];
const BOUND: [&str; 1] = ["bound"];
const SIMULATE: [&str; 1] = ["simulate"];

/// A race of the rules of two robots on dense patterns.
fn raced(flags: &str) -> String {
    format!(
        "optimize --station paper --robots 2 --belt-speed 0.2 --patterns poisson:0.2 --items 30 -q \
         --format json {flags}"
    )
}

pub const ROWS: &[Row] = &[
    row(&OPTIMIZE, "--objective", |rig, verb| {
        let best = |objective: &str| {
            let report = report(rig, verb, &format!("--objective {objective}"));
            (
                report["unit"].as_str().unwrap().to_owned(),
                rate_in(verb, &report),
            )
        };
        for (objective, unit, value) in [
            ("picking-rate", "1/min", RATE),
            ("picked-share", "1", 1.0),
            // An item without attributes weighs a half.
            ("weighted-rate", "1/min", 0.5 * RATE),
            // Below that of the arm.
            ("max-speed", "m/s", 0.499),
        ] {
            let found = best(objective);
            assert_eq!(found.0, unit);
            assert_near(found.1, value);
        }
    }),
    row(&OPTIMIZE, "--risk", |rig, verb| {
        // Two patterns, the item of one ten seconds behind that of the other.
        std::fs::create_dir(rig.at("set")).unwrap();
        rig.write("set/near.csv", "id,x,y\nA,0,0\n");
        rig.write("set/far.csv", "id,x,y\nA,-1,0\n");
        let call = one(verb).replace("p.csv", "set");
        let value = |risk: &str| {
            let report = rig.json(&format!("{call} -q --format json {risk}"));
            number(&report, "/ranking/0/value")
        };
        let far = 60.0 / 16.5;
        for (risk, expected) in [
            ("", 0.5 * (RATE + far)),
            ("--risk mean", 0.5 * (RATE + far)),
            ("--risk worst", far),
            ("--risk cvar:0.5", far),
        ] {
            assert_near(value(risk), expected);
        }
    }),
    row(&OPTIMIZE, "--speed-step", |rig, verb| {
        // The greatest multiple of it below the speed of the arm, at which all is picked.
        let limit = |step: &str| {
            let flags = format!("--objective max-speed --speed-step {step}");
            rate_in(verb, &report(rig, verb, &flags))
        };
        assert_near(limit("0.01"), 0.49);
        assert_near(limit("0.03"), 0.48);
    }),
    row(&OPTIMIZE, "--search", |rig, verb| {
        let found = |search: &str| {
            let report = report(rig, verb, &format!("--search {search}"));
            (
                report["search"].as_str().unwrap().to_owned(),
                report["grasp"].is_null(),
            )
        };
        assert_eq!(found("exhaustive"), ("exhaustive".into(), true));
        assert_eq!(found("grasp"), ("grasp".into(), false));
        assert_eq!(found("both"), ("exhaustive".into(), false));
        assert_eq!(found("auto"), ("exhaustive".into(), false));
        assert_eq!(found("exact"), ("exact".into(), false));
        let proof = report(rig, verb, "--search exact")["proof"].clone();
        assert_eq!(proof["gap"], 0.0, "{proof}");
    }),
    row(&OPTIMIZE, "--starts", |rig, verb| {
        let starts = |flags| number(&report(rig, verb, flags), "/grasp/starts");
        assert_eq!(
            (
                starts("--search grasp"),
                starts("--search grasp --starts 3")
            ),
            (8.0, 3.0)
        );
    }),
    row(&OPTIMIZE, "--alpha", |rig, verb| {
        let alpha = |flags| number(&report(rig, verb, flags), "/grasp/alpha");
        assert_eq!(
            (alpha("--search grasp"), alpha("--search grasp --alpha 0.7")),
            (0.3, 0.7)
        );
    }),
    row(&OPTIMIZE, "--max-runs", |rig, verb| {
        let report = |flags| report(rig, verb, flags);
        let short = report("--max-runs 4");
        assert_eq!(short["stop_reason"], "budget");
        assert!(number(&short, "/runs") <= 4.0, "{short}");
        assert_eq!(number(&short, "/max_runs"), 4.0);
        let whole = report("--max-runs 0");
        assert_eq!(
            (&whole["stop_reason"], &whole["max_runs"]),
            (&json!("enumerated"), &json!(null))
        );
    }),
    row(&OPTIMIZE, "--time-limit", |rig, verb| {
        let words = ["--time-limit: the time limit passed before any assignment was scored"];
        rig.refused(&format!("{} --time-limit 1e-9", one(verb)), &words);
        assert_eq!(
            report(rig, verb, "--time-limit 1e6")["stop_reason"],
            "enumerated"
        );
    }),
    row(&OPTIMIZE, "--race", |rig, _| {
        let fine = rig.json(&raced("--race 0.1"));
        let coarse = rig.json(&raced("--race 5"));
        assert_eq!(
            (&fine["delta"], &coarse["delta"]),
            (&json!(0.1), &json!(5.0))
        );
        assert!(
            number(&fine, "/patterns") > number(&coarse, "/patterns"),
            "{fine}"
        );
        assert_eq!(fine["assignments"], 36);
    }),
    row(&OPTIMIZE, "--confidence", |rig, _| {
        let found = |flags: &str| {
            let report = rig.json(&raced(&format!("--race 5 {flags}")));
            number(&report, "/probability_of_correct_selection")
        };
        assert_eq!((found(""), found("--confidence 0.6")), (0.95, 0.6));
    }),
    row(&OPTIMIZE, "--max-patterns", |rig, _| {
        let report = rig.json(&raced("--race 1e-6 --max-patterns 219"));
        // Whole batches.
        assert_eq!(report["patterns"], 210);
        assert_eq!(report["stop_reason"], "max_patterns");
        assert!(report["probability_of_correct_selection"].is_null());
    }),
    row(&OPTIMIZE, "--validate", |rig, verb| {
        let count = |count: &str| validated(rig, verb, count, "")["count"].clone();
        assert_eq!((count("3"), count("0")), (json!(3), json!(null)));
    }),
    row(&OPTIMIZE, "--strategy", |rig, verb| {
        let names = |flags| -> Value {
            let report = report(rig, verb, flags);
            let beside = report["beside"]["strategies"].as_array();
            let names = beside.map(|all| all.iter().map(|one| one["strategy"].clone()));
            names.map_or(json!(null), |names| names.collect())
        };
        assert_eq!(names(""), json!(null));
        let both = names("--strategy LD --strategy SPT");
        // The winner stands first.
        assert_eq!(both, json!(["rules:FIFO", "rules:LD", "rules:SPT"]));
        // Its figure is that of the same line under the same conditions.
        let report = report(rig, verb, "--strategy LD --update-hz 0.3");
        let end = 20.0 / 3.0 + 10.0 / 9.0 + 0.5;
        assert_near(number(&report, "/beside/strategies/1/mean"), 60.0 / end);
    }),
    row(&OPTIMIZE, "--save", |rig, verb| {
        let before = rig.read("one.toml");
        std::fs::hard_link(rig.at("one.toml"), rig.at("kept.toml")).unwrap();
        let saved = format!("strategy = \"rules:FIFO\"\n\n{before}");
        rig.done(&format!("{} --save new.toml", one(verb)));
        assert_eq!(
            (rig.read("new.toml"), rig.read("one.toml")),
            (saved.clone(), before.clone())
        );
        rig.done(&format!("{} --save", one(verb)));
        assert_eq!(
            (rig.read("one.toml"), rig.read("kept.toml")),
            (saved, before)
        );
    }),
    row(&OPTIMIZE, "--no-bound", |rig, verb| {
        assert!(validated(rig, verb, "3", "")["bound"].is_object());
        assert!(validated(rig, verb, "3", "--no-bound")["bound"].is_null());
    }),
    row(&["optimize", "game"], "--top", |rig, verb| {
        // The lines of the ranking, or of the equilibria: all six assignments.
        let lines = |flags: &str| {
            let table = rig.text(&format!("{} -q {flags}", one(verb)));
            let is_numbered = |line: &&str| {
                let cell = line.split('|').nth(1).unwrap_or_default().trim();
                cell.parse::<u32>().is_ok()
            };
            (
                table.lines().filter(is_numbered).count(),
                table.contains(" 4 more "),
            )
        };
        assert_eq!((lines(""), lines("--top 2")), ((6, false), (2, true)));
    }),
    row(&GAME, "--payoff", |rig, verb| {
        // The first robot picks the only item; the second is paid for it with the line.
        rig.write("pair.toml", &pair(rig));
        let call = one(verb).replace("one.toml", "pair.toml");
        let paid = |flags: &str| {
            let report = rig.json(&format!("{call} -q --format json {flags}"));
            [0, 1].map(|robot| number(&report, &format!("/equilibria/0/payoffs/{robot}")))
        };
        for (flags, second) in [("", 0.0), ("--payoff own", 0.0), ("--payoff total", RATE)] {
            let found = paid(flags);
            assert_near(found[0], RATE);
            assert_near(found[1], second);
        }
    }),
    row(&GAME, "--nfg", |rig, verb| {
        let table = rig.text(&format!("{} -q --nfg line.nfg", one(verb)));
        assert!(table.starts_with("| "), "{table}");
        let game = rig.read("line.nfg");
        assert!(game.starts_with("NFG 1 R "), "{game}");
        let payoffs = game.lines().filter_map(|line| line.parse::<f64>().ok());
        let payoffs: Vec<f64> = payoffs.collect();
        assert_eq!(payoffs.len(), 6);
        payoffs
            .into_iter()
            .for_each(|payoff| assert_near(payoff, RATE));
        // Printed it is the game alone.
        assert_eq!(rig.text(&format!("{} -q --nfg -", one(verb))), game);
    }),
    row(&["bound", "simulate"], "--pattern", |rig, verb| {
        let items = |file: &str, input: &str| {
            let call = one(verb).replace("p.csv", file);
            let called = rig.feed(&format!("{call} -q --format json"), input);
            let report: Value = serde_json::from_str(&called.stdout).unwrap();
            number(&report, "/items")
        };
        assert_eq!((items("p.csv", ""), items("ab.csv", "")), (1.0, 2.0));
        assert_eq!(items("-", &rig.read("ab.csv")), 2.0);
    }),
    row(&BOUND, "--objective", |rig, verb| {
        let weight = |flags: &str| {
            let call = one(verb).replace("p.csv", "ab.csv");
            rig.json(&format!("{call} -q --format json {flags}"))["weight_upper_bound"].clone()
        };
        assert_eq!(
            (weight(""), weight("--objective picks")),
            (json!(null), json!(null))
        );
        // Both items, of 100 and 300 cm^2.
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let all = sigmoid(1.0) + sigmoid(3.0);
        let found = weight("--objective weight").as_f64().unwrap();
        assert!(found >= all && found < all + 1e-6, "{found} {all}");
    }),
    row(&BOUND, "--slot", |rig, verb| {
        let slots = |flags| {
            let report = report(rig, verb, flags);
            (number(&report, "/slot_s"), number(&report, "/arcs"))
        };
        // The robot may leave for 10 s, in the last 2 of which it is no better than before.
        assert_eq!(
            (slots("--slot 0.1"), slots("--slot 0.2")),
            ((0.1, 81.0), (0.2, 41.0))
        );
    }),
    row(&BOUND, "--iterations", |rig, verb| {
        let steps = |flags| number(&report(rig, verb, flags), "/iterations");
        assert_eq!(
            (steps("--iterations 1"), steps("--iterations 3")),
            (1.0, 3.0)
        );
    }),
    row(&SIMULATE, "--strategy", |rig, verb| {
        // With the first item in its bin, at 6.5 s, the robot has the choice between one at
        // x = 0.55 and one at x = 0.45, which is further away.
        rig.write("three.csv", "id,x,y\nX,0,0\nnear,-0.1,0\nfar,-0.2,0\n");
        let call = format!("{verb} -q --no-bound --station one.toml --pattern three.csv");
        let second = |flags: &str| {
            let report = rig.json(&format!("{call} --format json {flags}"));
            (
                report["strategy"].clone(),
                report["picks"][1]["item"].clone(),
            )
        };
        let fifo = (json!("rules:FIFO"), json!("near"));
        assert_eq!(
            (second(""), second("--strategy FIFO")),
            (fifo.clone(), fifo)
        );
        assert_eq!(second("--strategy LPT"), (json!("rules:LPT"), json!("far")));
    }),
    row(&SIMULATE, "--budget-ms", |rig, verb| {
        let name = |flags: &str| {
            let call = one(verb).replace("FIFO", "lookahead:bases=FIFO/SPT");
            rig.json(&format!("{call} -q --format json {flags}"))["strategy"].clone()
        };
        assert_eq!(name(""), "lookahead:bases=FIFO/SPT");
        assert_eq!(
            name("--budget-ms 3"),
            "lookahead:budget-ms=3,bases=FIFO/SPT"
        );
    }),
    row(&SIMULATE, "--check", |rig, verb| {
        let found = |flags: &str| {
            let report = rig.json(&format!("{verb} -q --no-bound --format json {flags}"));
            (report["checked"].clone(), report["clearance"].is_object())
        };
        assert_eq!(found(""), (json!(null), false));
        assert_eq!(found("--check"), (json!(true), true));
    }),
    row(&SIMULATE, "--no-bound", |rig, verb| {
        let call = one(verb).replace("--no-bound", "");
        let bound =
            |flags: &str| rig.json(&format!("{call} -q --format json {flags}"))["bound"].clone();
        assert_eq!(bound("")["picks_upper_bound"], 1);
        assert!(bound("--no-bound").is_null());
    }),
    row(&SIMULATE, "--trace", |rig, verb| {
        rig.done(&format!("{} -q --trace events.csv", one(verb)));
        let trace = rig.read("events.csv");
        let times = crate::common::csv_rows(&trace);
        let times: Vec<_> = times
            .iter()
            .map(|row| (row[0].as_str(), row[1].as_str()))
            .collect();
        assert_eq!(
            times[1..],
            [("4", "decide"), ("5", "grasp"), ("6.5", "release")]
        );
    }),
    row(&SIMULATE, "--html", |rig, verb| {
        rig.done(&format!("{} -q --html replay.html", one(verb)));
        let page = rig.read("replay.html");
        assert!(page.starts_with("<!doctype html>"));
        let data = page.split_once("type=\"application/json\">").unwrap().1;
        let data = data.split_once("</script>").unwrap().0;
        let data: Value = serde_json::from_str(data).unwrap();
        assert_eq!(data["report"]["picks"][0]["release_s"], 6.5);
    }),
];

#[test]
fn options_of_searches_have_their_effect() {
    hold(ROWS);
}

/// The winner on `count` fresh patterns.
fn validated(rig: &Rig, verb: &str, count: &str, flags: &str) -> Value {
    let call = at_random(verb).replace("--validate 0 --no-bound", "");
    let call = format!("{call} -q --format json --station one.toml --validate {count} {flags}");
    rig.json(&call)["validation"].clone()
}

/// The station with a second robot, 2 m behind the first.
fn pair(rig: &Rig) -> String {
    let one = rig.read("one.toml");
    let (belt, robot) = one.split_once("[[robot]]").unwrap();
    let second = robot
        .replace("\"a\"", "\"b\"")
        .replace("[1.0, 0.0]", "[3.0, 0.0]");
    format!("{belt}[[robot]]{robot}\n[[robot]]{second}")
}
