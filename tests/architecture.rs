//! The code keeps to the layering of `docs/architecture.md`.

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

/// Every module of the crate named in `text`: `crate::x` and the heads of
/// `crate::{a::b, c}`.
fn uses(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
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
            continue; // lib.rs and main.rs see everything
        };
        let text = fs::read_to_string(&file).unwrap();
        // Tests inside a module may use whatever helps them.
        let code = text.split("#[cfg(test)]").next().unwrap();
        for name in uses(code) {
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
fn live_control_does_not_use_the_simulator() {
    let mut files = Vec::new();
    sources(&root().join("src/live"), &mut files);
    assert!(files.len() > 5);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        assert!(
            !uses(code).contains(&"sim".to_owned()),
            "{}",
            file.display()
        );
    }
}

#[test]
fn only_the_command_line_sees_clap_and_prints() {
    let mut files = Vec::new();
    sources(&root().join("src"), &mut files);
    for file in files {
        if ["cli", "main"].contains(&module_of(&file).as_str()) {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        for word in [
            "clap",
            "println!",
            "print!(",
            "eprintln!",
            "eprint!(",
            "indicatif",
        ] {
            assert!(!text.contains(word), "{} contains `{word}`", file.display());
        }
    }
}

#[test]
fn the_architecture_page_names_every_module() {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    for module in modules() {
        assert!(
            page.contains(&format!("`{module}`")),
            "docs/architecture.md lacks `{module}`"
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
    let here = Path::new("tests/architecture.rs");
    let waits = Path::new("tests/common/programs.rs");
    for file in &files {
        let name = file.strip_prefix(root()).unwrap();
        let text = fs::read_to_string(file).unwrap();
        let sleeps = text.contains("sleep(");
        assert_eq!(sleeps && name != here, name == waits, "{}", name.display());
    }
    sources(&root().join("src"), &mut files);
    for file in files.iter().filter(|file| !file.ends_with(here)) {
        let text = fs::read_to_string(file).unwrap();
        assert!(!text.contains("#[ignore"), "{}", file.display());
    }
}
