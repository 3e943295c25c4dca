//! Result files: what is left alone, and what is written of work that the user stops.

use crate::common::{pickline, text};
#[cfg(target_os = "linux")]
use crate::terminal::Terminal;
use pickline::error::Error;
use pickline::experiment::{
    Comparison, Draws, Method, Setting, add_bounds, compare, load_cases, sweep,
};
use pickline::optimize::{Environment, Progress};
use pickline::pattern::grid;
use pickline::sim::Conditions;
use pickline::station::built_in;
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
        };
        let mut comparison = compare(&station, methods, &cases, 3, 2, &plain, &environment)?;
        let progress = after(bounds);
        let environment = Environment {
            stop: &stop,
            progress: &progress,
        };
        let draws = Draws {
            replicates: 3,
            first_seed: 2,
            conditions: &plain,
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
        };
        let plain = Conditions::default();
        sweep(&settings, &patterns, &plain, true, &environment).unwrap()
    };
    let (whole, part) = (run(u64::MAX), run(2));
    assert_eq!((whole.values.len(), whole.planned), (3, 3));
    assert_eq!((&part.values[..], part.planned), (&[0.04, 0.05][..], 3));
    assert_eq!(part.bounds.unwrap().len(), 2);
    assert_eq!(
        part.points[1][0].picking_rate,
        whole.points[1][0].picking_rate
    );
}

/// Ctrl-C: the case that is done is printed and written, and every file says that it is
/// not all.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_comparison_is_marked_as_partial() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let cases = "[[case]]\nname = \"quick\"\ngrid = 0.3\nitems = 10\n\
                 [[case]]\nname = \"endless\"\npoisson = 0.2\nitems = 60\n";
    std::fs::write(at("cases.toml"), cases).unwrap();
    let out = at("out");
    let compare = format!(
        "compare --robust SPT,FIFO --replicates 500 --strategy \
         lookahead:bases=SPT+FIFO,budget=40000 --no-greedy --no-policy --cases {} --out {}",
        at("cases.toml").display(),
        out.display()
    );
    let mut terminal = Terminal::pickline(&compare, &at("table"));
    // The one grid of the quick case, and a pattern of the other.
    terminal.wait_for_more_than(1, "comparing");
    terminal.press_ctrl_c();
    assert_eq!(terminal.finish(), Some(130), "{}", terminal.shown());
    let printed = std::fs::read_to_string(at("table")).unwrap();
    let mark = "interrupted, with 1 of 2 cases done";
    assert!(printed.contains(&format!("partial   {mark}")), "{printed}");
    assert!(
        printed.contains("| quick") && !printed.contains("| endless"),
        "{printed}"
    );
    for name in [
        "picked_time.csv",
        "picking_rate.csv",
        "runs.csv",
        "compare.json",
    ] {
        let written = std::fs::read_to_string(out.join(name)).unwrap();
        assert!(written.contains(mark), "{name}: {written}");
    }
}
