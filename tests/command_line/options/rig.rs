//! A line on which every figure can be computed by hand, and calls of the program in its folder.
//!
//! One robot stands over the middle of the belt, with its bin at its base, x = 1; one item lies
//! at x = 0. The robot reaches 0.5 m and is five times as fast as the belt at 0.1 m/s.
//!
//! It meets the item at x = 0.5, after a way of 0.5 m in 1 s, in which the item comes 0.1 m: it
//! leaves when the item is at x = 0.4, at 4 s, and is back and done at 4 + 2 + 0.3 + 0.2 = 6.5 s,
//! one pick in 6.5 s.

use crate::programs::{Program, feed};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// Picks per minute of one item that is in its bin at 6.5 s.
pub const RATE: f64 = 60.0 / 6.5;

/// One robot above the middle of the belt.
pub const STATION: &str = "\
[belt]
speed = 0.1
length = 4.0
width = 1.0

[[robot]]
name = \"a\"
base = [1.0, 0.0]
bin = [1.0, 0.0]
reach = 0.5
speed = 0.5
grasp_time = 0.3
release_time = 0.2
";

/// What is in the folder.
const FILES: [(&str, &str); 6] = [
    ("one.toml", STATION),
    ("p.csv", "id,x,y\nA,0,0\n"),
    // Two items side by side, the second of which weighs more.
    ("ab.csv", "id,x,y,area_cm2\nA,0,0,100\nB,0,0.1,300\n"),
    // One that no grasp holds.
    ("slippery.csv", "id,x,y,p_grasp\nA,0,0,0\n"),
    ("c.toml", "[[case]]\nname = \"own\"\npattern = \"p.csv\"\n"),
    (
        "random.toml",
        "[[case]]\nname = \"random\"\npoisson = 0.4\nitems = 4\n",
    ),
];

/// A folder of its own for each row.
pub struct Rig {
    folder: tempfile::TempDir,
    /// What the program that is called ignores.
    ignored: Option<Ignored>,
}

/// An option of a verb.
struct Ignored {
    verb: Vec<String>,
    names: Vec<String>,
    /// Least and most values that it takes.
    values: [usize; 2],
}

impl Ignored {
    /// `words` without the option, if they are a call of its verb.
    fn dropped_from(&self, words: Vec<String>) -> Vec<String> {
        if !words.starts_with(&self.verb) {
            return words;
        }
        let mut kept = Vec::new();
        let mut words = words.into_iter().peekable();
        while let Some(word) = words.next() {
            let Some(name) = self.names.iter().find(|name| word.starts_with(*name)) else {
                kept.push(word);
                continue;
            };
            // `--seed 7` or `--seed=7`, but not `--seeds`.
            if word != *name {
                if !word[name.len()..].starts_with('=') {
                    kept.push(word);
                }
                continue;
            }
            let [least, most] = self.values;
            for value in 0..most {
                if value >= least && words.peek().is_none_or(|next| next.starts_with("--")) {
                    break;
                }
                words.next();
            }
        }
        kept
    }
}

/// What came of a call.
#[derive(Debug)]
pub struct Called {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Rig {
    pub fn new() -> Self {
        let rig = Self {
            folder: tempfile::tempdir().unwrap(),
            ignored: None,
        };
        for (name, content) in FILES {
            rig.write(name, content);
        }
        // Another robot with twice the speed: it leaves at 4.5 s and is done at 6 s.
        rig.write("fast.toml", &STATION.replace("speed = 0.5", "speed = 1.0"));
        // Metres that look like centimetres.
        rig.write(
            "odd.toml",
            &STATION.replace("length = 4.0", "length = 400.0"),
        );
        rig
    }

    /// As with a program that ignores this option of `verb`; none for what has no flag.
    pub fn ignoring(whole: &clap::Command, verb: &str, option: &str) -> Option<Self> {
        let verb: Vec<String> = verb.split(' ').map(str::to_owned).collect();
        let part = |command, name| clap::Command::find_subcommand(command, name);
        let command = verb.iter().try_fold(whole, part).unwrap();
        let is_named = |argument: &&clap::Arg| argument.get_long() == option.strip_prefix("--");
        let argument = command.get_arguments().find(is_named)?;
        let long = format!("--{}", argument.get_long()?);
        let short = argument.get_short().map(|letter| format!("-{letter}"));
        let values = match argument.get_num_args() {
            Some(range) if argument.get_action().takes_values() => {
                [range.min_values(), range.max_values()]
            }
            _ => [0, 0],
        };
        Some(Self {
            ignored: Some(Ignored {
                verb,
                names: [long].into_iter().chain(short).collect(),
                values,
            }),
            ..Self::new()
        })
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        let path = self.at(name);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    pub fn write(&self, name: &str, content: &str) {
        std::fs::write(self.at(name), content).unwrap();
    }

    /// The names in a folder below, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.at(folder)).unwrap();
        let name = |entry: std::fs::DirEntry| entry.file_name().into_string().unwrap();
        let mut names: Vec<String> = entries.map(|entry| name(entry.unwrap())).collect();
        names.sort();
        names
    }

    /// A command with the words of `line`, to be run in the folder.
    pub fn command(&self, line: &str) -> Command {
        let words = line.split_whitespace().map(str::to_owned).collect();
        let words = match &self.ignored {
            Some(ignored) => ignored.dropped_from(words),
            None => words,
        };
        let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
        command.args(words).current_dir(self.folder.path());
        command
    }

    /// Starts the program with the words of `line`.
    pub fn program(&self, line: &str) -> Program {
        Program::start(&mut self.command(line))
    }

    /// Calls the program with the words of `line` and `input` on stdin.
    pub fn feed(&self, line: &str, input: &str) -> Called {
        let (output, _) = feed(&mut self.command(line), input.as_bytes());
        Called {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Calls the program, whatever comes of it.
    pub fn call(&self, line: &str) -> Called {
        self.feed(line, "")
    }

    /// Calls the program, which has to succeed.
    pub fn done(&self, line: &str) -> Called {
        let called = self.call(line);
        assert_eq!(called.code, Some(0), "{line}: {}", called.stderr);
        called
    }

    /// What a call prints that has to succeed.
    pub fn text(&self, line: &str) -> String {
        self.done(line).stdout
    }

    pub fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.text(line)).unwrap()
    }

    /// A call that has to be refused with these words.
    pub fn refused(&self, line: &str, words: &[&str]) {
        self.ended(line, 2, words);
    }

    /// Calls the program, which must end with this code and a message with all of `words`.
    pub fn ended(&self, line: &str, code: i32, words: &[&str]) {
        let called = self.call(line);
        assert_eq!(called.code, Some(code), "{line}: {}", called.stderr);
        for word in words {
            assert!(called.stderr.contains(word), "{line}: {}", called.stderr);
        }
    }
}

/// The number at `pointer` of `report`.
pub fn number(report: &Value, pointer: &str) -> f64 {
    let found = report.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number {pointer} in {report}"))
}

/// Asserts that two figures are one, up to what a game rounds to.
#[track_caller]
pub fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 2e-7, "{found}, not {expected}");
}
