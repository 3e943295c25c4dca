//! The committed results are what the program prints.

use std::path::Path;
use std::process::Command;

#[test]
fn the_committed_tables_are_made_again_to_the_byte() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let folder = tempfile::tempdir().unwrap();
    let status = Command::new("bash")
        .arg(root.join("results/make.sh"))
        .arg(folder.path())
        .env("PICKLINE", env!("CARGO_BIN_EXE_pickline"))
        .env("PARTS", "paper")
        .status()
        .unwrap();
    assert!(status.success());
    let mut compared = 0;
    for part in ["optimize", "compare", "sweep"] {
        compared += compare_folders(&root.join("results").join(part), &folder.path().join(part));
    }
    let part = "sb3/compare";
    compared += compare_folders(&root.join("results").join(part), &folder.path().join(part));
    assert_eq!(compared, 6 + 4 * 7 + 2 * 4 + 3);
}

/// The table of the trained policies in docs/rl.md has the benefits over robust GT that were found.
#[test]
fn the_docs_show_what_the_policies_of_both_trainers_gain() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let rates = read("results/sb3/compare/picking_rate.csv");
    let mut rates = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(rates.as_bytes());
    let column = |name: &str, headers: &csv::StringRecord| {
        headers.iter().position(|header| header == name).unwrap()
    };
    let headers = rates.headers().unwrap().clone();
    let benefit = column("benefit_percent", &headers);
    let rows: Vec<csv::StringRecord> = rates.records().map(Result::unwrap).collect();
    let docs = read("docs/rl.md");
    let cases = ["grid 0.15, 50 items", "grid 0.3, 50 items"];
    let cases = [
        &cases[..],
        &["poisson 0.2, 29 items", "poisson 0.3, 36 items"],
    ]
    .concat();
    for case in cases {
        let of = |policy: &str| {
            let method = format!("onnx:results/sb3/{policy}.onnx");
            let row = rows.iter().find(|row| row[0] == *case && row[1] == *method);
            let percent: f64 = row.unwrap()[benefit].parse().unwrap();
            format!("{percent:.1}")
        };
        let seeds = |trainer: &str| {
            [1, 2, 3]
                .map(|seed| of(&format!("{trainer}-{seed}")))
                .join(" / ")
        };
        let cells = format!("| {case} | {} | {} |", seeds("sb3"), seeds("native"));
        assert!(docs.contains(&cells), "docs/rl.md lacks {cells}");
    }
}

/// The comparisons with look-ahead, on real lines and of failures take too long to be made again; the first
/// pattern of each case is, with the command at the head of the committed file.
#[test]
fn the_first_runs_of_the_long_comparisons_are_made_again() {
    hold_long_comparisons(compare_first_runs);
}

/// The rates of the committed comparisons are the means of the committed runs.
#[test]
fn the_rates_of_the_long_comparisons_are_those_of_their_runs() {
    hold_long_comparisons(hold_rates);
}

/// Calls `hold` with the project's folder and that of every long comparison. It returns how much it has held,
/// which must be one for each case and method.
fn hold_long_comparisons(hold: impl Fn(&Path, &Path) -> usize) {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let mut held = 0;
    for part in ["lookahead", "real-lines", "failures", "single-arm"] {
        for folder in std::fs::read_dir(root.join("results").join(part)).unwrap() {
            let folder = folder.unwrap().path();
            if folder.is_dir() {
                held += hold(root, &folder);
            }
        }
    }
    // The paper's stations, eight cases and four methods; six lines and their constant-speed models, one
    // case each, with three or four methods; four stations and two probabilities, with two cases and four
    // methods; two arms with four cases and four methods.
    assert_eq!(held, 2 * 8 * 4 + 6 * (4 + 3) + 8 * 2 * 4 + 2 * 4 * 4);
}

/// Holds each rate in `folder` to the mean over its runs; returns how many.
fn hold_rates(_root: &Path, folder: &Path) -> usize {
    let read = |file: &str| {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let mut csv = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let headers = csv.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
        let place = |name: &str| headers.iter().position(|header| header == name).unwrap();
        let columns = ["case", "method", "picking_rate_per_min"].map(place);
        let row = |row: csv::StringRecord| {
            let [case, method, rate] = columns.map(|column| row[column].to_owned());
            ((case, method), rate.parse::<f64>().unwrap())
        };
        rows.into_iter().map(row).collect::<Vec<_>>()
    };
    let (rates, runs) = (read("picking_rate.csv"), read("runs.csv"));
    for (of, rate) in &rates {
        let all = runs.iter().filter(|(run, _)| run == of);
        let all: Vec<f64> = all.map(|(_, rate)| *rate).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let file = folder.display();
        assert!(
            (mean - rate).abs() < 1e-9 * mean,
            "{file}: {of:?}: {rate}, not {mean}"
        );
    }
    rates.len()
}

/// The table of single arms in docs/lookahead.md is what its command prints.
#[test]
fn the_table_of_single_arms_is_that_of_its_script() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let called = Command::new("python3")
        .arg("results/single-arm/table.py")
        .current_dir(root)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&called.stderr);
    assert!(called.status.success(), "{said}");
    let table = String::from_utf8(called.stdout).unwrap();
    assert_eq!(table.lines().count(), 2 + 2 * 4);
    let docs = std::fs::read_to_string(root.join("docs/lookahead.md")).unwrap();
    assert!(docs.contains(&table), "docs/lookahead.md lacks {table}");
}

/// Runs the comparison of `folder` again, with one pattern for each case; returns the number of runs
/// that were held to the committed ones.
fn compare_first_runs(root: &Path, folder: &Path) -> usize {
    let committed = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    let command = committed.lines().next().unwrap();
    let command = command.strip_prefix("# pickline ").unwrap();
    let rows: Vec<&str> = committed.lines().filter(|l| !l.starts_with('#')).collect();
    let robust = rows.iter().find(|row| row.contains(",robust_gt,")).unwrap();
    let place = rows[0].split(',').position(|name| name == "assignment");
    // Names of cases may have commas, this column and those after it have none.
    let after = rows[0].split(',').count() - 1 - place.unwrap();
    let robust = robust.rsplit(',').nth(after).unwrap();
    let robust = robust.replace(' ', ",");
    // Found again, the assignment and the bases of the plans would take minutes.
    let table = std::fs::read_to_string(folder.join("table.txt")).unwrap();
    let mut notes = table.lines();
    let bases = notes.find_map(|line| line.strip_prefix("note      lookahead is "));
    let (robust, plans) = match command.contains("--robust") {
        true => (vec![], "lookahead"),
        false => (vec!["--robust", &robust], bases.unwrap()),
    };
    // Then there is nothing to train.
    let mut words = Vec::new();
    let mut all = command.split(' ');
    while let Some(word) = all.next() {
        match word {
            "--train-patterns" | "--train-items" => drop(all.next()),
            "lookahead" => words.push(plans),
            word => words.push(word),
        }
    }
    let made = tempfile::tempdir().unwrap();
    let called = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(words)
        .args(["--quiet", "--replicates", "1"])
        .args(robust)
        .arg("--out")
        .arg(made.path())
        .current_dir(root)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&called.stderr);
    assert!(called.status.success(), "{command}: {said}");
    let made = std::fs::read_to_string(made.path().join("runs.csv")).unwrap();
    let made: Vec<&str> = made.lines().filter(|l| !l.starts_with('#')).collect();
    for row in &made {
        let row = row.replace(plans, "lookahead");
        assert!(
            rows.contains(&&*row),
            "{}: {row}: run bash results/make.sh",
            folder.display()
        );
    }
    made.len() - 1
}

/// The constant-speed models are the built-in stations without acceleration and lift.
#[test]
fn the_constant_speed_models_differ_only_in_the_law() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    for name in ["delta", "sorting"] {
        let read = |path: String| std::fs::read_to_string(root.join(path)).unwrap();
        let built_in = read(format!("src/station/builtin/{name}.toml"));
        let law = ["acceleration", "lift"];
        let lines = built_in.lines();
        let kept = lines.filter(|line| !law.iter().any(|key| line.starts_with(key)));
        let kept: Vec<&str> = kept.collect();
        let model = read(format!("results/real-lines/{name}-constant.toml"));
        assert_eq!(kept, model.lines().collect::<Vec<_>>());
    }
}

/// Holds every file below `committed` to its like below `made`; returns how many.
fn compare_folders(committed: &Path, made: &Path) -> usize {
    let mut compared = 0;
    for entry in std::fs::read_dir(committed).unwrap() {
        let committed = entry.unwrap().path();
        let made = made.join(committed.file_name().unwrap());
        if committed.is_dir() {
            compared += compare_folders(&committed, &made);
            continue;
        }
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        assert!(
            read(&made) == read(&committed),
            "{} differs: run bash results/make.sh",
            committed.display()
        );
        compared += 1;
    }
    compared
}

/// The table in the README is what its first command prints.
#[test]
fn the_readme_shows_what_optimize_prints() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let printed = std::fs::read_to_string(root.join("results/optimize/paper-2.txt")).unwrap();
    let table: Vec<&str> = printed
        .lines()
        .filter(|line| line.starts_with('|'))
        .collect();
    assert_eq!(table.len(), 12);
    assert!(
        readme.contains(&table.join("\n")),
        "the README's table is not {table:#?}"
    );
    let best = printed
        .lines()
        .find(|line| line.starts_with("validated"))
        .unwrap();
    assert!(readme.contains(best), "the README lacks `{best}`");
}
