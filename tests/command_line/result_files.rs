//! Result files: what is left alone, and what is written of work that the user stops.

use crate::common::{pickline, text};
#[cfg(target_os = "linux")]
use crate::terminal::Terminal;
use pickline::error::Error;
use pickline::experiment::{
    Comparison, Draws, Method, Setting, add_bounds, compare_methods, load_cases, sweep_settings,
};
use pickline::optimize::{Environment, Progress};
use pickline::pattern::grid;
use pickline::sim::Conditions;
use pickline::station::built_in;
use pickline_report::{
    BoundReport, ComparisonReport, GameReport, OptimumReport, RaceReport, RobotsDownReport,
    RunReport, SweepReport, VerbReport as _,
};
#[cfg(target_os = "linux")]
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Result files do not overwrite what the call reads, whatever the verb.
#[test]
fn result_files_leave_the_input_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let pattern = text(&["pattern", "generate", "-q"]);
    let case = "[[case]]\nname = \"a\"\npattern = \"runs.csv\"\n";
    let grid = "[[case]]\nname = \"a\"\ngrid = 0.3\nitems = 5\n".to_owned();
    let station = text(&["station", "show"]);
    for (name, content) in [
        ("picks.csv", &pattern),
        ("prices.csv", &pattern),
        ("ranking.csv", &pattern),
        ("payoffs.csv", &pattern),
        ("sweep.csv", &pattern),
        ("runs.csv", &pattern),
        ("compare.json", &grid),
        ("sweep.json", &station),
    ] {
        std::fs::write(at(name), content).unwrap();
    }
    let cases = at("cases.toml");
    std::fs::write(&cases, case).unwrap();
    let page = at("optimize.json");
    for (arguments, file) in [
        (
            &["simulate", "--pattern", &at("picks.csv")][..],
            "picks.csv",
        ),
        (&["bound", "--pattern", &at("prices.csv")], "prices.csv"),
        (
            &["optimize", "--patterns", &at("ranking.csv")],
            "ranking.csv",
        ),
        (&["optimize", "--html", &page], "optimize.json"),
        (&["game", "--patterns", out], "payoffs.csv"),
        (&["sweep", "--patterns", &at("sweep.csv")], "sweep.csv"),
        (&["sweep", "--station", &at("sweep.json")], "sweep.json"),
        (&["compare", "--cases", &at("compare.json")], "compare.json"),
        (&["compare", "--cases", &cases], "runs.csv"),
    ] {
        let output = pickline(&[arguments, &["-q", "--out", out]].concat());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        for word in ["--out", file, "cure:"] {
            assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
        }
        let of_a_folder = "would be among the patterns in --patterns";
        let why = ["is already used by --", of_a_folder][usize::from(arguments.contains(&out))];
        assert!(told.contains(why), "{arguments:?}: {told}");
    }
    assert_eq!(std::fs::read_to_string(at("runs.csv")).unwrap(), pattern);
    // Anywhere else it is welcome.
    let other = at("other");
    text(&[
        "simulate",
        "-q",
        "--pattern",
        &at("picks.csv"),
        "--out",
        &other,
    ]);
    text(&[
        "simulate",
        "-q",
        "--pattern",
        &at("picks.csv"),
        "--out",
        &other,
    ]);
}

/// What a verb writes to a folder is what it has checked before the work.
#[test]
fn result_files_are_those_that_are_announced() {
    let cases: [(&str, Vec<&str>); 8] = [
        ("simulate --no-bound", RunReport::file_names()),
        ("bound --iterations 2", BoundReport::file_names()),
        (
            "optimize --patterns grid:0.3 --items 9 --validate 0 --strategy rules:SPT,SPT",
            OptimumReport::file_names(),
        ),
        (
            "optimize --robots 1 --race 5 --max-patterns 200 --patterns poisson:0.2 --items 9",
            RaceReport::file_names(),
        ),
        (
            "compare --station sorting --classes pet:1 --robust SPT,SPT,SPT,SPT --no-policy --no-greedy \
             --no-bound --replicates 1 --misdetections",
            ComparisonReport::file_names(),
        ),
        (
            "sweep --station sorting --classes pet:1 --robust SPT,SPT,SPT,SPT --no-bound --sweep \
             min-detection --from 0.5 --to 0.5 --items 9 --p-detection uniform:0,1 --purity 0.1",
            SweepReport::file_names(),
        ),
        (
            "sweep --sweep robots-down --robust SPT,FIFO --patterns grid:0.3 --items 20",
            RobotsDownReport::file_names(),
        ),
        (
            "game --patterns grid:0.3 --items 9",
            GameReport::file_names(),
        ),
    ];
    for (call, mut announced) in cases {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let out = out.to_str().unwrap();
        let words: Vec<&str> = call.split(' ').chain(["-q", "--out", out]).collect();
        text(&words);
        let written = std::fs::read_dir(out).unwrap();
        let written = written.map(|file| file.unwrap().file_name().into_string().unwrap());
        let mut written: Vec<String> = written.collect();
        written.sort();
        announced.sort_unstable();
        assert_eq!(written, announced, "{call}");
    }
}

/// Asks to stop once so many patterns are done.
struct StopAfter<'s> {
    stop: &'s AtomicBool,
    left: AtomicU64,
}

impl Progress for StopAfter<'_> {
    fn begin(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, steps: u64) {
        if self.left.fetch_sub(steps, Ordering::Relaxed) <= steps {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

/// What was finished when the user stopped is the whole of it, and no more.
#[test]
fn whole_cases_outlive_an_interruption() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let cases = load_cases("paper").unwrap();
    let plain = Conditions::default();
    let run = |patterns: u64, bounds: u64| {
        let stop = AtomicBool::new(false);
        let after = |left| StopAfter {
            stop: &stop,
            left: AtomicU64::new(left),
        };
        let methods = vec![Method::Robust("SPT,FIFO".parse().unwrap())];
        let progress = after(patterns);
        let environment = Environment {
            stop: &stop,
            progress: &progress,
            ..Environment::QUIET
        };
        let draws = Draws {
            replicates: 3,
            first_seed: 2,
            conditions: &plain,
        };
        let mut comparison = compare_methods(&station, methods, &cases, draws, &environment)?;
        let progress = after(bounds);
        let environment = Environment {
            stop: &stop,
            progress: &progress,
            ..Environment::QUIET
        };
        add_bounds(&mut comparison, &station, draws, &environment)?;
        Ok::<_, Error>(comparison)
    };
    let never = u64::MAX;
    let whole = run(never, never).unwrap();
    let rates = |of: &Comparison| -> Vec<f64> {
        of.cases
            .iter()
            .map(|case| case.methods[0].picking_rate)
            .collect()
    };
    let bounded = |of: &Comparison| of.cases.iter().filter(|case| case.bound.is_some()).count();
    assert_eq!(
        (rates(&whole).len(), whole.planned, bounded(&whole)),
        (4, 4, 4)
    );
    // One pattern a grid, three of the third case: stopped after its first.
    let part = run(3, never).unwrap();
    assert_eq!((part.planned, bounded(&part)), (4, 0));
    assert_eq!(rates(&part), rates(&whole)[..2]);
    let part = run(never, 2).unwrap();
    assert_eq!(rates(&part), rates(&whole));
    // The bounds of the two grids, not those of the case after them.
    assert_eq!(bounded(&part), 2);
}

#[test]
fn whole_values_outlive_an_interruption() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let setting = |value: f64| Setting {
        value,
        station: station.with_belt_speed(value).unwrap(),
        min_detection: None,
        methods: vec![Method::Robust("SPT,FIFO".parse().unwrap())],
    };
    let settings = [0.04, 0.05, 0.06].map(setting);
    let patterns = [grid(1.05, 0.15, 50).unwrap()];
    let run = |values: u64| {
        let stop = AtomicBool::new(false);
        let progress = StopAfter {
            stop: &stop,
            left: AtomicU64::new(values),
        };
        let environment = Environment {
            stop: &stop,
            progress: &progress,
            ..Environment::QUIET
        };
        let plain = Conditions::default();
        sweep_settings(&settings, &patterns, &plain, true, &environment).unwrap()
    };
    let (whole, part) = (run(u64::MAX), run(2));
    assert_eq!((whole.values.len(), whole.planned), (3, 3));
    let speeds: Vec<f64> = part.values.iter().map(|at| at.value).collect();
    assert_eq!((&speeds[..], part.planned), (&[0.04, 0.05][..], 3));
    assert!(part.values.iter().all(|at| at.bound.is_some()));
    assert_eq!(
        part.values[1].methods[0].picking_rate,
        whole.values[1].methods[0].picking_rate
    );
}

/// What is printed and written of work that Ctrl-C ends once `stage` has done more than
/// `count` steps: the text for the terminal, and the files by their names.
#[cfg(target_os = "linux")]
fn interrupted(
    folder: &Path,
    call: &str,
    stage: &str,
    count: u64,
) -> (String, Vec<(String, String)>) {
    let (out, printed) = (folder.join("out"), folder.join("printed"));
    let mut terminal = Terminal::pickline(&format!("{call} --out {}", out.display()), &printed);
    terminal.wait_for_more_than(count, stage);
    terminal.press_ctrl_c();
    assert_eq!(terminal.finish(), Some(130), "{}", terminal.shown());
    let files = std::fs::read_dir(out).unwrap().map(|entry| {
        let file = entry.unwrap();
        let name = file.file_name().into_string().unwrap();
        (name, std::fs::read_to_string(file.path()).unwrap())
    });
    (std::fs::read_to_string(printed).unwrap(), files.collect())
}

/// Ctrl-C: the case that is done is printed and written, and every file says that it is
/// not all; so it does where only bounds are missing.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_comparison_is_marked_as_partial() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cases.toml");
    let cases = "[[case]]\nname = \"quick\"\ngrid = 0.3\nitems = 10\n\
                 [[case]]\nname = \"endless\"\npoisson = 0.15\nitems = 60\n";
    std::fs::write(&file, cases).unwrap();
    let compare = format!(
        "compare --robust SPT,FIFO --replicates 500 --no-greedy --no-policy --cases {}",
        file.display()
    );
    let slow = format!("{compare} --strategy lookahead:bases=SPT+FIFO,budget=40000");
    for (call, stage, mark) in [
        (slow, "comparing", "interrupted, with 1 of 2 cases done"),
        (
            compare,
            "bounding",
            "interrupted, with 1 of 2 cases' bounds done",
        ),
    ] {
        // The one grid of the quick case, and a pattern of the other.
        let (printed, files) = interrupted(folder.path(), &call, stage, 1);
        assert!(printed.contains(&format!("partial   {mark}")), "{printed}");
        assert!(printed.contains("| quick"), "{printed}");
        assert_eq!(printed.contains("| endless"), stage == "bounding");
        assert_eq!(files.len(), 5);
        for (name, written) in files {
            assert!(written.contains(mark), "{name}: {written}");
        }
    }
}

/// A game over some of the patterns is one, but not the one that was asked for: whoever has
/// only one of its files can see that.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_game_is_marked_as_partial() {
    let folder = tempfile::tempdir().unwrap();
    let game = "game --robots 3 --patterns random:80/min:20000 --items 60 --format json";
    let (printed, files) = interrupted(folder.path(), game, "playing", 0);
    let report: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(report["stop_reason"], "interrupted");
    let patterns = report["patterns"].as_u64().unwrap();
    assert!(0 < patterns && patterns < 20_000, "{patterns}");
    assert_eq!(report["runs"], 216 * patterns);
    let mark = format!("interrupted, with {patterns} of 20000 patterns done");
    assert_eq!(files.len(), 3);
    for (name, written) in files {
        assert!(written.contains(&mark), "{name}: no {mark}");
    }
}

/// A ranking by some of the patterns says so in its table too.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_ranking_is_marked_as_partial() {
    let folder = tempfile::tempdir().unwrap();
    let search = "optimize --robots 4 --search exhaustive --patterns random:80/min:2000 \
                  --items 60";
    let (printed, files) = interrupted(folder.path(), search, "enumerating", 0);
    let (_, rest) = printed.split_once("partial   interrupted, with ").unwrap();
    let (patterns, rest) = rest.split_once(" of ").unwrap();
    assert!((1..2000).contains(&patterns.parse().unwrap()), "{patterns}");
    assert!(rest.starts_with("2000 patterns done\n"), "{printed}");
    let mark = format!("interrupted, with {patterns} of 2000 patterns done");
    assert!(!files.is_empty());
    for (name, written) in files {
        assert!(written.contains(&mark), "{name}: no {mark}");
    }
}

/// Ctrl-C in a race: the best so far, of which nothing is guaranteed.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_race_is_marked_as_partial() {
    let folder = tempfile::tempdir().unwrap();
    let race = "optimize --robots 2 --race 1e-9 --max-patterns 90000 --patterns poisson:0.2 \
                --items 60";
    let (printed, files) = interrupted(folder.path(), race, "racing", 10);
    let (_, rest) = printed.split_once("partial   interrupted, with ").unwrap();
    let (patterns, rest) = rest.split_once(" of ").unwrap();
    assert!(
        (10..90_000).contains(&patterns.parse().unwrap()),
        "{patterns}"
    );
    assert!(rest.starts_with("90000 patterns done\n"), "{printed}");
    assert!(printed.contains("nothing is guaranteed"), "{printed}");
    let mark = format!("interrupted, with {patterns} of 90000 patterns done");
    assert_eq!(files.len(), 2);
    for (name, written) in files {
        assert!(written.contains(&mark), "{name}: no {mark}");
    }
}
