//! The code keeps to the layering of `docs/architecture.md`.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod errors;
mod imports;
mod methods;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The modules in the order in which lib.rs lists them, which is the order of imports.
fn modules() -> Vec<String> {
    let lib = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let names = lib.lines().filter_map(|line| {
        let line = line.strip_prefix("pub ").unwrap_or(line);
        line.strip_prefix("mod ")
    });
    names
        .map(|name| name.trim_end_matches(';').to_owned())
        .collect()
}

/// The top-level module that a source file belongs to.
fn module_of(file: &Path) -> String {
    let inside = file.strip_prefix(root().join("src")).unwrap();
    let first = inside.components().next().unwrap().as_os_str();
    first.to_string_lossy().trim_end_matches(".rs").to_owned()
}

/// The first names after `start::` in `text`: of `crate::x::y`, and of `crate::{a::b, c}`.
fn uses(text: &str, start: &str) -> Vec<String> {
    let mut found = Vec::new();
    let start = format!("{start}::");
    for (at, _) in text.match_indices(&start) {
        // `pickline` is the end of no other name, and `crate` neither.
        if text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &text[at + start.len()..];
        if let Some(list) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut name = String::new();
            for c in list.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => found.push(std::mem::take(&mut name)),
                    _ if depth == 0 => name.push(c),
                    _ => {}
                }
            }
            found.push(name);
        } else {
            found.push(rest.to_owned());
        }
    }
    let head = |name: &String| -> String {
        let word = name.trim().chars();
        word.take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    found
        .iter()
        .map(head)
        .filter(|name| !name.is_empty())
        .collect()
}

/// The text of a source file without its tests, which may use whatever helps them.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    // A module of tests in the file ends it; a single item for tests does not.
    let start = text.match_indices("#[cfg(test)]\nmod ").find(|(at, _)| {
        let rest = text[*at..].lines().nth(1);
        rest.is_some_and(|line| line.ends_with('{'))
    });
    text[..start.map_or(text.len(), |(at, _)| at)].to_owned()
}

/// The crates beside the library, by their folder, with those of this workspace that each uses.
const CRATES: [(&str, &[&str]); 4] = [
    ("live", &["pickline"]),
    ("report", &["pickline"]),
    (
        "dashboard",
        &["pickline", "pickline-live", "pickline-report"],
    ),
    (
        "cli",
        &[
            "pickline",
            "pickline-dashboard",
            "pickline-live",
            "pickline-report",
        ],
    ),
];

#[test]
fn modules_use_only_those_before_them() {
    let order = modules();
    assert!(order.len() > 10, "{order:?}");
    let rank = |name: &str| order.iter().position(|module| module == name);
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    let mut checked = 0;
    for file in files {
        let Some(own) = rank(&module_of(&file)) else {
            continue; // lib.rs sees everything
        };
        for name in uses(&code(&file), "crate") {
            let used = rank(&name).unwrap_or_else(|| panic!("{}: crate::{name}?", file.display()));
            assert!(
                used <= own,
                "{} uses crate::{name}, which comes after {}",
                file.display(),
                order[own]
            );
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} uses were found");
}

/// The line itself takes the simulator's place.
#[test]
fn live_control_uses_what_it_decides_with_and_no_simulator() {
    let allowed = [
        "decision",
        "error",
        "files",
        "kinematics",
        "names",
        "pattern",
        "plausible",
        "fit",
        "station",
    ];
    let mut files = Vec::new();
    sources(&root().join("crates/live/src"), &mut files);
    let used = files.iter().flat_map(|file| uses(&code(file), "pickline"));
    let used: BTreeSet<String> = used.collect();
    assert_eq!(used, allowed.map(str::to_owned).into());
}

#[test]
fn crates_use_only_those_below_them() {
    for (folder, below) in CRATES {
        let manifest = root().join("crates").join(folder).join("Cargo.toml");
        let text = fs::read_to_string(manifest).unwrap();
        let manifest: toml::Table = text.parse().unwrap();
        let used = manifest["dependencies"].as_table().unwrap().keys();
        let used: BTreeSet<&str> = used.map(String::as_str).collect();
        let used = used.into_iter().filter(|name| name.starts_with("pickline"));
        assert_eq!(used.collect::<Vec<_>>(), below, "crates/{folder}");
    }
    let folders = fs::read_dir(root().join("crates")).unwrap();
    let folders = folders.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let listed = CRATES.map(|(folder, _)| folder.to_owned());
    assert_eq!(folders.collect::<BTreeSet<_>>(), listed.into());
}

/// Whoever uses the library does not build what draws, prints and serves.
#[test]
fn the_library_builds_no_terminal_and_no_server() {
    let tree = |arguments: &[&str]| {
        let output = std::process::Command::new(env!("CARGO"))
            .args(["tree", "--locked", "--edges", "normal", "--prefix", "none"])
            .args(arguments)
            .current_dir(root())
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        let text = String::from_utf8(output.stdout).unwrap();
        let name = |line: &str| line.split(' ').next().unwrap_or_default().to_owned();
        text.lines().map(name).collect::<BTreeSet<String>>()
    };
    let foreign = ["clap", "comfy-table", "ctrlc", "indicatif", "kuva", "tokio"];
    let program = tree(&["-p", "pickline-cli"]);
    let library = tree(&["-p", "pickline"]);
    let live = tree(&["-p", "pickline-live"]);
    for name in foreign {
        assert!(
            program.contains(name),
            "{name} is no longer used: name another"
        );
        assert!(!library.contains(name), "pickline uses {name}");
        assert!(
            name == "tokio" || !live.contains(name),
            "pickline-live uses {name}"
        );
    }
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    for folder in [
        ".",
        "crates/live",
        "crates/report",
        "crates/dashboard",
        "crates/cli",
    ] {
        let source = root().join(folder).join("src");
        let read = imports::Crate::read(&source);
        let edges = read.edges();
        let uses: usize = edges.values().map(BTreeSet::len).sum();
        assert!(uses > edges.len() / 2, "{folder}: only {uses} uses found");
        let circles = imports::circles(&edges);
        let named = circles.iter().map(|circle| {
            let names = circle
                .iter()
                .map(|file| file.strip_prefix(&source).unwrap());
            names
                .map(|name| name.display().to_string())
                .collect::<Vec<_>>()
        });
        assert!(
            circles.is_empty(),
            "{folder}: {:#?}",
            named.collect::<Vec<_>>()
        );
    }
}

#[test]
fn only_the_command_line_prints() {
    let mut files = Vec::new();
    for folder in ["src", "crates/live", "crates/report", "crates/dashboard"] {
        sources(&root().join(folder), &mut files);
    }
    for file in files
        .iter()
        .filter(|file| !file.iter().any(|part| part == "examples"))
    {
        let text = fs::read_to_string(file).unwrap();
        for word in ["println!", "print!(", "eprintln!", "eprint!("] {
            assert!(!text.contains(word), "{} contains `{word}`", file.display());
        }
    }
}

/// A message or comment names a setting; the program knows how it is written on its command line.
#[test]
fn the_library_names_no_flag() {
    let mut files = Vec::new();
    for folder in ["src", "crates/live/src", "crates/dashboard/src"] {
        sources(&root().join(folder), &mut files);
    }
    for file in files {
        let text = code(&file);
        for line in text.lines() {
            let flag = line.split("--").skip(1).find(|rest| {
                let mut letters = rest.chars();
                letters.next().is_some_and(|c| c.is_ascii_lowercase())
                    && letters
                        .next()
                        .is_some_and(|c| c.is_ascii_lowercase() || c == '-')
            });
            assert_eq!(flag, None, "{}: {line}", file.display());
        }
    }
}

#[test]
fn the_architecture_page_names_every_module() {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let crates = CRATES.map(|(folder, _)| format!("crates/{folder}"));
    for name in modules().into_iter().chain(crates) {
        assert!(
            page.contains(&format!("`{name}`")),
            "docs/architecture.md lacks `{name}`"
        );
    }
}

#[test]
fn the_rule_pages_follow_the_registry() {
    let model = fs::read_to_string(root().join("docs/model.md")).unwrap();
    for rule in pickline::dispatch::RULES {
        let row = format!(
            "| {} | {} | {} |",
            rule.name(),
            rule.title(),
            rule.key_text()
        );
        assert!(model.contains(&row), "docs/model.md lacks the row `{row}`");
    }
}

/// A test waits for what happens, with a deadline (`tests/common/programs.rs`), and runs each
/// time: none sleeps, and none is left out.
#[test]
fn tests_wait_for_what_happens_and_are_all_run() {
    let mut files = Vec::new();
    sources(&root().join("tests"), &mut files);
    assert!(files.len() > 100, "{} files", files.len());
    let here = Path::new("tests/architecture/main.rs");
    let waits = Path::new("tests/common/programs.rs");
    for file in &files {
        let name = file.strip_prefix(root()).unwrap();
        let text = fs::read_to_string(file).unwrap();
        let sleeps = text.contains("sleep(");
        assert_eq!(sleeps && name != here, name == waits, "{}", name.display());
    }
    sources(&root().join("src"), &mut files);
    sources(&root().join("crates"), &mut files);
    for file in files.iter().filter(|file| !file.ends_with(here)) {
        let text = fs::read_to_string(file).unwrap();
        assert!(!text.contains("#[ignore"), "{}", file.display());
    }
}
