//! The kind of an error and its place agree, as the documentation of `ErrorKind` says.

use super::{root, sources};

/// Starts of a place that is a setting: in single quotes, or a flag.
const SETTINGS: [&str; 8] = [
    "\"'",
    "\"--",
    "format!(\"'",
    "format!(\"--",
    "setting",
    "flag",
    "*setting",
    "*flag",
];
/// Starts of a place that is a file or a part of one.
const FILES: [&str; 7] = [
    "path.display()",
    "file.display()",
    "path,",
    "name,",
    "format!(\"{name}",
    "format!(\"{path}",
    "format!(\"{file}",
];

/// Every place with which `constructor` is called in the code before its tests, as it is written.
fn places(constructor: &str) -> Vec<String> {
    let mut files = Vec::new();
    for folder in ["src", "crates"] {
        sources(&root().join(folder), &mut files);
    }
    let mut found = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
        for (at, _) in code.match_indices(constructor) {
            let place = code[at + constructor.len()..].trim_start();
            let place: String = place.chars().take(40).collect();
            found.push(format!("{place} in {}", file.display()));
        }
    }
    found
}

#[test]
fn an_error_at_a_setting_is_of_kind_usage() {
    let (input, usage) = (places("Error::input("), places("Error::usage("));
    assert!(input.len() > 100 && usage.len() > 100);
    for place in input {
        let is_setting = SETTINGS.iter().any(|start| place.starts_with(start));
        assert!(!is_setting, "Error::input at a setting: {place}");
    }
    for place in usage {
        let is_file = FILES.iter().any(|start| place.starts_with(start));
        assert!(!is_file, "Error::usage at a file: {place}");
    }
}
