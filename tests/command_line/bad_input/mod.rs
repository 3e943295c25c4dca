//! Bad input ends in exit code 2 and a message that names place, problem and cure: every
//! field of both files and every flag wrong in turn. Good but unusual input is read like any
//! other.
//!
//! The cases are in `tests/data/bad_input/`, each with its message beside it.

mod flags;
mod patterns;
mod stations;
#[cfg(target_os = "linux")]
mod surroundings;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const BELT: &str = "[belt]\nspeed = 0.05\nlength = 4.2\nwidth = 1.05\n";
const ROBOT: &str = "[[robot]]\nname = \"r1\"\nbase = [1.3, -0.625]\nbin = [1.3, -0.525]\n\
    reach = 0.8\nspeed = 0.5\ngrasp_time = 0.1\nrelease_time = 0.1\n";
const LINE: &str = "[line]\nrobots = 2\nfirst_base_x = 1.3\nspacing = 1.6\nbase_offset = 0.1\n\
    bin_offset = 0.0\ntail = 0.5\nreach = 0.8\nspeed = 0.5\ngrasp_time = 0.1\nrelease_time = 0.1\n";
const PATTERN: &str = "id,x,y,area_cm2,p_detection,p_grasp,weight,class\n\
    a,0,0.1,80,0.9,0.8,,PET\nb,-0.2,-0.1,,,,0.7,\nc,-0.4,0,,,,,glass\n";

/// What is said of bad input.
#[derive(Debug, Deserialize)]
struct Message {
    /// Place and problem.
    says: Option<String>,
    /// Their begin, where the rest is worded by the reader of TOML.
    begins: Option<String>,
    /// The cure; none where the argument parser has found the problem, which names --help.
    cure: Option<String>,
}

/// Files that are wrong as a whole.
#[derive(Deserialize)]
struct Files {
    case: Vec<File>,
}

#[derive(Deserialize)]
struct File {
    file: String,
    #[serde(flatten)]
    message: Message,
}

impl Message {
    fn new(says: &str, cure: &str) -> Self {
        Self {
            says: Some(says.to_owned()),
            begins: None,
            cure: Some(cure.to_owned()),
        }
    }

    fn check(&self, stderr: &str, about: &str) {
        let Some(cure) = &self.cure else {
            let says = self.says.as_ref().unwrap();
            assert!(stderr.starts_with(&format!("error: {says}\n")), "{about}");
            assert!(
                stderr.ends_with("\n\nFor more information, try '--help'.\n"),
                "{about}"
            );
            return;
        };
        // Behind what is only warned of.
        let start = match stderr.starts_with("pickline: ") {
            true => 0,
            false => 1 + stderr.find("\npickline: ").expect(about),
        };
        let said = stderr[start..].strip_prefix("pickline: ").unwrap();
        let said = said.strip_suffix(&format!("\n  cure: {cure}\n"));
        let said = said.unwrap_or_else(|| panic!("no cure `{cure}`: {about}"));
        match (&self.says, &self.begins) {
            (Some(says), None) => assert_eq!(said, says, "{about}"),
            (None, Some(begins)) => assert!(said.starts_with(begins.as_str()), "{about}"),
            _ => panic!("either `says` or `begins`: {about}"),
        }
    }
}

/// The cases of a file in `tests/data/bad_input/`.
fn cases<T: DeserializeOwned>(name: &str) -> T {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/bad_input/");
    let text = std::fs::read_to_string(format!("{folder}{name}")).unwrap();
    toml::from_str(&text).unwrap()
}

fn pickline(folder: &Path, arguments: &[impl AsRef<std::ffi::OsStr>]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Everything below `folder`, so that a leftover shows.
fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path.clone());
            }
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Runs what must be refused: exit code 2, nothing on stdout, nothing written, the message.
fn refused(folder: &Path, arguments: &[impl AsRef<str>], message: &Message) {
    let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
    let before = listing(folder);
    let output = pickline(folder, &arguments);
    let said = stderr(&output);
    let about = format!("{arguments:?}\n{message:?}\n{said}");
    assert_eq!(output.status.code(), Some(2), "{about}");
    assert!(output.stdout.is_empty(), "{about}");
    assert!(!said.contains("panicked"), "{about}");
    message.check(&said, &about);
    assert_eq!(listing(folder), before, "{about}");
}

fn accepted(folder: &Path, arguments: &[&str]) -> String {
    let output = pickline(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}
