//! Of which kind an error is, what it names as its place, and which error is beneath it.

use pickline::error::{Error, ErrorKind, Result};
use pickline::experiment::{Axis, load_cases};
use pickline::optimize::{Environment, Evaluator, Objective, Risk};
use pickline::pattern::{self, PatternSet, PatternSource};
use pickline::rl::Plan;
use pickline::sim::Conditions;
use pickline::station::{self, Overrides, Station, built_in};
use pickline::strategies::{self, STRATEGIES};
use pickline::study::{
    self, CompareOptions, OptimizeOptions, RobustTraining, ScoredPatterns, SweepOptions,
};
use std::error::Error as _;
use std::path::Path;

fn line() -> Station {
    built_in("paper").unwrap().station(None).unwrap()
}

fn refused<T>(result: Result<T>) -> Error {
    match result {
        Ok(_) => panic!("not refused"),
        Err(error) => error,
    }
}

fn compared(options: &CompareOptions) -> Error {
    let cases = load_cases("paper").unwrap();
    refused(study::compare(
        &line(),
        &cases,
        options,
        &Environment::QUIET,
    ))
}

fn optimized(options: &OptimizeOptions) -> Error {
    refused(study::optimize(&line(), options, &Environment::QUIET))
}

fn swept(options: &SweepOptions) -> Error {
    refused(study::sweep(&line(), options, &Environment::QUIET))
}

/// A station file that is right.
const FILE: &str = "[belt]\nspeed = 0.05\nwidth = 1.05\n[line]\nrobots = 2\nfirst_base_x = 1.3\n\
                    spacing = 1.6\nbase_offset = 0.1\nbin_offset = 0.0\ntail = 1.3\nreach = 0.8\n\
                    speed = 1.0\ngrasp_time = 0.5\nrelease_time = 0.5\n";

fn read(from: &str, to: &str, overrides: Overrides) -> Result<Station> {
    assert!(FILE.contains(from));
    station::parse(&FILE.replace(from, to), "t.toml", overrides)
}

#[test]
fn what_the_caller_asks_for_is_of_kind_usage() {
    let overrides = |robots: Option<usize>, belt_speed: Option<f64>| {
        Overrides::default()
            .with_robots(robots)
            .with_belt_speed(belt_speed)
    };
    let two = "SPT,FIFO,SPT".parse().unwrap();
    for (error, place) in [
        (
            compared(&CompareOptions::default().with_replicates(0)),
            "'replicates'",
        ),
        (
            compared(&CompareOptions::default().with_reference("robust")),
            "'reference'",
        ),
        (
            compared(&CompareOptions::default().with_training(RobustTraining::Given(two))),
            "'robust'",
        ),
        (
            optimized(&OptimizeOptions::default().with_risk(Risk::Cvar(2.0))),
            "'risk'",
        ),
        (
            swept(&SweepOptions::default().with_axis(Axis::Robots)),
            "'sweep_axis' robots at 1",
        ),
        (
            swept(
                &SweepOptions::default()
                    .with_axis(Axis::Reach)
                    .with_from(-1.0),
            ),
            "'from'",
        ),
        (refused(built_in("papre")), "'station'"),
        (
            refused(built_in("paper").unwrap().station(Some(0))),
            "'robots'",
        ),
        (
            refused(station::load("paper", overrides(None, Some(9.0)))),
            "'belt_speed'",
        ),
        (
            refused(read("2", "2", overrides(Some(0), None))),
            "'robots'",
        ),
        (
            refused(read("2", "2", overrides(None, Some(9.0)))),
            "'belt_speed'",
        ),
        (refused(load_cases("papre")), "'cases'"),
        (
            refused("gird:0.1".parse::<PatternSource>()),
            "'patterns' gird:0.1",
        ),
        (
            refused("grid:0".parse::<ScoredPatterns>()),
            "'patterns' grid:0",
        ),
        (refused(strategies::parse("lookahed")), "'strategy'"),
        (refused(strategies::parse("SPT,FIFOO")), "'strategy'"),
        (
            refused(strategies::read_alone("SPT,FIFO", 3)),
            "'strategy' [SPT; FIFO]",
        ),
        (refused(Plan::preset("no-such")), "'preset'"),
    ] {
        assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
        assert_eq!(error.place(), Some(place), "{error}");
    }
}

#[test]
fn the_content_of_files_is_of_kind_input() {
    let none = Overrides::default();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let cases = file("c.toml", "[[case]]\nname = \"a\"\ngrid = -1\nitems = 10\n");
    let flow = "[[case]]\nname = \"a\"\nfeed = \"random\"\nflow = -1\nitems = 10\n";
    let of_flow = load_cases(&file("f.toml", flow)).unwrap();
    for error in [
        refused(read("robots = 2", "robots = 0", none)),
        refused(read("speed = 0.05", "speed = 9.0", none)),
        refused(read("reach = 0.8", "raech = 0.8", none)),
        refused(pattern::read("id,x,y\na,1\n", "p.csv")),
        refused(pattern::read("id,x,y\na,1,x\n", "p.csv")),
        refused(load_cases(&cases)),
        refused(of_flow[0].patterns(line().belt(), 1, 1)),
        refused(Plan::from_file("{\"preset\": \"no-such\"}", "p.json")),
        refused(Plan::from_file("{\"courses\": 0}", "p.json")),
        refused(Station::new(*line().belt(), Vec::new())),
    ] {
        assert_eq!(error.kind(), ErrorKind::Input, "{error}");
    }
}

#[test]
fn a_path_that_is_not_there_is_of_kind_path_wherever_it_is_given() {
    for error in [
        refused(station::load("no/such.toml", Overrides::default())),
        refused(station::load("no/paper", Overrides::default())),
        refused(load_cases("no/such.toml")),
        refused("/no/such".parse::<ScoredPatterns>()),
        refused("no-such.csv".parse::<PatternSource>()),
        refused(pattern::load(Path::new("no-such.csv"))),
        #[cfg(feature = "onnx")]
        refused(strategies::parse("onnx:no-such.onnx")),
    ] {
        assert_eq!(error.kind(), ErrorKind::Path, "{error}");
    }
}

#[test]
fn the_error_beneath_that_of_a_file_is_kept() {
    let none = Overrides::default();
    let cause = |error: Error| error.source().map(ToString::to_string).unwrap_or_default();
    let error = refused(read("[belt]", "[belt", none));
    assert!(error.source().unwrap().is::<toml::de::Error>(), "{error}");
    for (from, to) in [
        ("robots = 2", "robots = 99999999999999999999"),
        ("reach = 0.8", "reach = 99999999999999999999"),
    ] {
        let error = refused(read(from, to, none));
        assert!(error.source().unwrap().is::<std::num::ParseIntError>());
    }
    for (field, why) in [
        ("1m", "invalid float literal"),
        ("1e400", "the number is too large"),
        ("\"0,5\"", "the decimal mark does not fit the file"),
    ] {
        let text = format!("id,x,y\na,1,{field}\n");
        assert_eq!(cause(refused(pattern::read(&text, "p.csv"))), why);
    }
    let profile = tempfile::NamedTempFile::with_suffix(".csv").unwrap();
    std::fs::write(&profile, "time_s,flow_per_min\n0,1\n1,x\n").unwrap();
    let source: PatternSource = format!("profile:{}", profile.path().display())
        .parse()
        .unwrap();
    let patterns = ScoredPatterns::from(source);
    let error = optimized(&OptimizeOptions::default().with_patterns(patterns));
    assert_eq!(error.kind(), ErrorKind::Input);
    assert_eq!(cause(error), "invalid float literal");
    let error = refused(Plan::from_file("{", "p.json"));
    assert!(error.source().unwrap().is::<serde_json::Error>());
}

/// Not only when the strategy is put on a line, which may be after hours of other work.
#[test]
fn wrong_options_of_a_strategy_are_refused_as_it_is_read() {
    let options = STRATEGIES
        .iter()
        .flat_map(|kind| kind.options.iter().map(move |(key, _)| (kind, key)));
    for (kind, key) in options {
        let name = kind.name;
        // What must be given before options.
        let values = match kind.form.split_once(":W1").or(kind.form.split_once(":N1")) {
            Some(_) => "1,1,",
            None => "",
        };
        let error = refused(strategies::parse(&format!("{name}:{values}{key}=?")));
        let place = format!("'strategy' {name}:{key}");
        assert_eq!(error.place(), Some(&*place), "{error}");
        assert_eq!(error.kind(), ErrorKind::Usage);
        assert!(error.problem().contains("`?`"), "{error}");
        assert!(error.to_string().contains("\n  cure: "), "{error}");
    }
    for text in ["lookahead:budget=1,budget-ms=1", "lookahead:seed=1,seed=2"] {
        assert_eq!(refused(strategies::parse(text)).kind(), ErrorKind::Usage);
    }
    // How many robots there are is not known yet.
    let parsed = strategies::parse("lookahead:bases=SPT+FIFO").unwrap();
    assert!(parsed.alone(2).is_ok());
    let error = refused(parsed.alone(3));
    assert_eq!(error.place(), Some("'strategy' lookahead:bases"));
}

#[test]
fn every_study_names_the_place_of_wrong_conditions_alike() {
    let wrong = || Conditions::at_update_hz(f64::NAN);
    for error in [
        compared(&CompareOptions::default().with_conditions(wrong())),
        optimized(&OptimizeOptions::default().with_conditions(wrong())),
        swept(&SweepOptions::default().with_conditions(wrong())),
    ] {
        assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
        assert_eq!(error.place(), Some("'update_hz'"), "{error}");
    }
}

#[test]
fn a_set_without_patterns_is_refused_as_such() {
    let empty = || {
        RobustTraining::On(PatternSet {
            description: String::new(),
            labels: Vec::new(),
            patterns: Vec::new(),
        })
    };
    for error in [
        compared(&CompareOptions::default().with_training(empty())),
        swept(&SweepOptions::default().with_training(empty())),
    ] {
        assert_eq!(error.place(), Some("'training'"), "{error}");
        assert!(
            error.to_string().contains("one or more patterns"),
            "{error}"
        );
    }
    let rate = Objective::PickingRate;
    let station = line();
    let error = refused(Evaluator::new(&station, &[], rate, &Conditions::default()));
    assert_eq!(error.place(), Some("'patterns'"), "{error}");
}
