//! `pickline pattern import` on films.

use super::DATA;
use super::film::{Film, STRAIGHT};
use crate::common;
use std::path::Path;

/// How the films were shot.
const SHOT: [&str; 8] = [
    "--fps",
    "25",
    "--scale",
    "0.002",
    "--axis",
    "x",
    "--belt-speed",
    "0.25",
];

#[test]
fn strict_and_quiet_apply_to_implausible_patterns() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (text, _) = Film {
        angle: 0.6,
        ..STRAIGHT
    }
    .shoot();
    std::fs::write(path("film.txt"), text).unwrap();
    let run = |more: &[&str]| {
        let (film, out) = (path("film.txt"), path("p.csv"));
        let words = ["pattern", "import", "tracks", &film, "-o", &out];
        let output = common::pickline(&[&words[..], &SHOT, more].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    };
    let (code, said) = run(&["--strict"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("--angle 0.6"), "{said}");
    assert!(!Path::new(&path("p.csv")).exists());
    let (code, said) = run(&["-q"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.starts_with("warning: ") && said.contains("--angle 0.6"),
        "{said}"
    );
    assert!(!said.contains("centre line"), "{said}");
    for (flag, metres) in [("--split-distance", "100"), ("--merge-distance", "20")] {
        let (code, said) = run(&["--strict", flag, metres]);
        assert_eq!(code, Some(2), "{said}");
        assert!(
            said.contains(flag) && said.contains("millimetres"),
            "{said}"
        );
    }
}

#[test]
fn no_output_goes_into_the_folder_of_labels() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels");
    std::fs::create_dir(&labels).unwrap();
    let from = format!("{DATA}ultralytics-labels");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), labels.join(entry.file_name())).unwrap();
        names.push(entry.file_name());
    }
    names.sort();
    let film = labels.display().to_string();
    for name in [names[0].to_str().unwrap(), "new_7.txt"] {
        let before = std::fs::read(labels.join(name)).ok();
        let out = labels.join(name).display().to_string();
        let words = ["pattern", "import", "tracks", &film, "-o", &out, "--force"];
        let size = ["--image-size", "1280x400"];
        let output = common::pickline(&[&words[..], &size, &SHOT].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("folder of the recording"), "{said}");
        assert_eq!(std::fs::read(labels.join(name)).ok(), before);
    }
}

#[test]
fn the_program_imports_films() {
    let file = |name: &str| format!("{DATA}{name}");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.csv");
    let out = out.to_str().unwrap();
    let labels = [file("ultralytics-labels")];
    let run = |verb: &str, file: &str, more: &[&str]| {
        let words = [&["pattern", "import", verb, file][..], &SHOT, more].concat();
        let output = common::pickline(&words);
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for verb in ["tracks", "mot"] {
        let (code, said) = run(verb, &file("supervision.csv"), &["-o", out]);
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("CSV with a header"), "{said}");
        assert!(std::fs::read_to_string(out).unwrap().contains(",PET"));
        std::fs::remove_file(out).unwrap();
    }
    let (code, said) = run(
        "tracks",
        &labels[0],
        &["--image-size", "1280x400", "-o", out],
    );
    assert_eq!(code, Some(0), "{said}");
    for (flags, word) in [
        (&["--image-size", "1280"][..], "--image-size"),
        (&["--image-size", "0x400"], "--image-size"),
        (&["--as", "mott"], "did you mean `mot`"),
        (&["--angle", "90"], "--angle"),
        (&["--boxes", "middle"], "--boxes"),
    ] {
        let (code, said) = run("tracks", &labels[0], flags);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(word), "{word} not in {said}");
    }
}
