//! Station files and names on the command line: what is read from where, and what is blamed.

use pickline::station::{
    Overrides, built_in, commented_example, is_file, load, load_with_strategy, parse,
    parse_with_strategy,
};
use std::fs;

/// The example with one value of its line changed.
fn with_line(key: &str, value: &str) -> String {
    let (head, line) = commented_example().split_once("[line]\n").unwrap();
    let changed = line.lines().map(|line| match line.starts_with(key) {
        true => format!("{key} = {value}"),
        false => line.to_owned(),
    });
    let changed: Vec<String> = changed.collect();
    format!("{head}[line]\n{}\n", changed.join("\n"))
}

#[test]
fn every_value_of_a_line_is_checked_against_its_limits() {
    let (size, length) = ("is not a usable size", "is not a valid length");
    let (place, time) = ("is not a valid position", "is not a valid dwell time");
    for (key, good, bad, words) in [
        ("robots", ["1", "100"], ["0", "101"], "robots"),
        ("first_base_x", ["-1e4", "1e4"], ["-2e6", "2e6"], place),
        ("spacing", ["0", "10"], ["-1e-9", "2e6"], length),
        ("base_offset", ["-1e4", "1e4"], ["-2e6", "2e6"], place),
        ("bin_offset", ["-1e4", "1e4"], ["-2e6", "2e6"], place),
        ("tail", ["0", "10"], ["-1e-9", "2e6"], length),
        ("reach", ["1e-6", "10"], ["0", "2e6"], size),
        ("speed", ["0.06", "1e6"], ["0", "2e6"], size),
        ("grasp_time", ["0", "1e6"], ["-1e-9", "2e6"], time),
        ("release_time", ["0", "1e6"], ["-1e-9", "2e6"], time),
    ] {
        for value in good {
            // Far upstream of its start there is no belt to speak of.
            if (key, value) != ("first_base_x", "-1e4") {
                let text = with_line(key, value);
                parse(&text, "t", Overrides::default())
                    .unwrap_or_else(|e| panic!("{key} = {value}: {e}"));
            }
        }
        for value in bad {
            let message = parse(&with_line(key, value), "t", Overrides::default()).unwrap_err();
            let message = message.to_string();
            let blamed = message.contains(&format!("line.{key}: ")) && message.contains(words);
            assert!(blamed, "{key} = {value}: {message}");
        }
    }
}

/// A built-in station is a file too, with any valid number of robots.
#[test]
fn a_built_in_line_has_the_robots_that_are_asked_for() {
    let paper = built_in("paper").unwrap();
    assert!(paper.station(Some(0)).is_err() && paper.station(Some(101)).is_err());
    assert_eq!(paper.station(Some(7)).unwrap().robots().len(), 7);
}

/// What looks like a path is one, and so is what exists.
#[test]
fn paths_are_files_and_other_names_are_not() {
    for name in ["a/paper", "a\\paper", "paper.toml", "./paper", "src"] {
        assert!(is_file(name), "{name}");
    }
    for name in ["paper", "paper-narrow", "nowhere"] {
        assert!(!is_file(name), "{name}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("paper.toml");
    let path = path.to_str().unwrap();
    let message = load(path, Overrides::default()).unwrap_err().to_string();
    assert!(
        message.contains("the file does not exist") && message.contains("use `paper`"),
        "{message}"
    );
    // A file of nearly that name is what was meant.
    let near = folder.path().join("papers.toml");
    fs::write(&near, with_line("robots", "5")).unwrap();
    let message = load(path, Overrides::default()).unwrap_err().to_string();
    assert!(
        message.contains("papers.toml") && !message.contains("use `paper`"),
        "{message}"
    );
    let other = folder.path().join("elsewhere.toml");
    let message = load(other.to_str().unwrap(), Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(!message.contains("built-in"), "{message}");
    fs::rename(&near, path).unwrap();
    assert_eq!(load(path, Overrides::default()).unwrap().robots().len(), 5);
    assert_eq!(
        load("paper", Overrides::default()).unwrap().robots().len(),
        2
    );
}

/// A name without its extension means the file in this folder, if that is a station file.
#[test]
fn a_file_named_without_its_extension_is_suggested() {
    let message = load("Cargo", Overrides::default()).unwrap_err().to_string();
    assert!(
        message.contains("`Cargo` is neither a file nor a built-in station")
            && message.contains("did you mean Cargo.toml?"),
        "{message}"
    );
    let message = load("Cargo-lock", Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("is neither")
            && message.contains("known: paper, paper-narrow, delta, sorting"),
        "{message}"
    );
}

#[test]
fn a_strategy_is_read_with_its_place() {
    let text = format!("strategy = \"rules:SPT,FIFO\"\n{}", commented_example());
    let (station, saved) = parse_with_strategy(&text, "t", Overrides::default()).unwrap();
    assert_eq!(station, load("paper", Overrides::default()).unwrap());
    let saved = saved.unwrap();
    assert_eq!(
        (saved.text.as_str(), saved.place.as_str()),
        ("rules:SPT,FIFO", "t:1: strategy")
    );
    let (_, none) = parse_with_strategy(commented_example(), "t", Overrides::default()).unwrap();
    assert_eq!(none, None);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    let (_, saved) = load_with_strategy(path.to_str().unwrap(), Overrides::default()).unwrap();
    assert_eq!(saved.unwrap().text, "rules:SPT,FIFO");
    assert_eq!(
        load_with_strategy("paper", Overrides::default()).unwrap().1,
        None
    );
}

/// A speed of 0 is the file's fault, whatever the flag.
#[test]
fn errors_name_the_setting_that_caused_them() {
    let fast = Overrides::default().with_belt_speed(0.4);
    let of = |value: &str| parse(&with_line("speed", value), "t", fast);
    assert_eq!(of("0.5").unwrap().belt().speed, 0.4);
    let message = of("0.3").unwrap_err().to_string();
    assert!(message.starts_with("'belt_speed': "), "{message}");
    let message = of("0").unwrap_err().to_string();
    assert!(
        message.contains("line.speed: 0 is not a usable size"),
        "{message}"
    );
    assert!(!message.contains("'belt_speed'"), "{message}");
}

/// What follows from a line is blamed on the line, and keys that nobody knows are refused.
#[test]
fn values_derived_from_a_line_name_that_line() {
    let far = with_line("first_base_x", "999999.5");
    let with_length = far.replace("[belt]\n", "[belt]\nlength = 4.0\n");
    let wide = with_line("bin_offset", "999999").replace("width = 1.05", "width = 1000.0");
    assert!(with_length != far && wide.contains("1000.0"));
    for (text, words) in [
        (far, "is not a usable size"),
        (with_length, "is not a valid position"),
        (wide, "is not a valid position"),
    ] {
        let message = parse(&text, "t", Overrides::default())
            .unwrap_err()
            .to_string();
        assert!(
            message.contains(": line: ") && message.contains(words),
            "{message}"
        );
    }
    let key = with_line("reach", "0.8\nreech = 0.8");
    let message = parse(&key, "t", Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("line.reech") && message.contains("`reach`"),
        "{message}"
    );
}

#[test]
fn robots_of_a_list_are_blamed_one_by_one() {
    let list = pickline::station::to_toml(&load("paper", Overrides::default()).unwrap());
    parse(&list, "t", Overrides::default()).unwrap();
    let key = list.replacen("reach =", "reech =", 1);
    let message = parse(&key, "t", Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("robot[0].reech") && message.contains("`reach`"),
        "{message}"
    );
    // A speed of 0 is the file's fault here too.
    let fast = Overrides::default().with_belt_speed(0.4);
    let still = list.replacen("speed = 0.5", "speed = 0.0", 1);
    let message = parse(&still, "t", fast).unwrap_err().to_string();
    assert!(
        message.contains("robot[0].speed: 0 is not a usable size"),
        "{message}"
    );
}
