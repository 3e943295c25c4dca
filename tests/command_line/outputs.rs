//! What a call writes, whatever the verb: never over what it reads, nor over what is not its
//! own, and the result is printed even where a file cannot be written.

use crate::common::{pickline, text};

const MINE: &str = "what the user has written\n";

/// A verb with small work, and what it can write: flag and name of the file; a name in
/// brackets is one of `--out`.
type Verb<'v> = (Vec<&'v str>, &'v [(&'v str, &'v str)]);

fn verbs() -> Vec<Verb<'static>> {
    let words = |line: &'static str| line.split(' ').collect::<Vec<_>>();
    vec![
        (
            words("simulate -q --no-bound --station in/s.toml --pattern in/p.csv"),
            &[
                ("--trace", "t.csv"),
                ("--html", "r.html"),
                ("--out", "run.json"),
            ],
        ),
        (
            words("bound -q --iterations 2 --station in/s.toml --pattern in/p.csv"),
            &[("--out", "bound.json"), ("--out", "prices.csv")],
        ),
        (
            words("benchmark -q --dir in/b --strategy rules:FIFO"),
            &[("--out", "benchmark.json"), ("--out", "runs.csv")],
        ),
        (
            words("optimize -q --station in/s.toml --patterns in/p.csv --no-bound"),
            &[
                ("--html", "o.html"),
                ("--svg", "o.svg"),
                ("--out", "ranking.csv"),
            ],
        ),
        (
            words(
                "compare -q --station in/s.toml --cases in/c.toml --robust SPT,FIFO --no-policy \
                 --no-bound",
            ),
            &[
                ("--html", "c.html"),
                ("--svg", "c.svg"),
                ("--out", "runs.csv"),
            ],
        ),
        (
            words(
                "sweep -q --station in/s.toml --patterns in/p.csv --robust SPT,FIFO --no-bound \
                 --from 0.05 --to 0.06 --step 0.01",
            ),
            &[
                ("--html", "w.html"),
                ("--svg", "w.svg"),
                ("--out", "sweep.json"),
            ],
        ),
        (
            words("game -q --station in/s.toml --patterns in/p.csv"),
            &[("--nfg", "g.nfg"), ("--out", "payoffs.csv")],
        ),
        (
            words("station show --station in/s.toml --pattern in/p.csv"),
            &[("--svg", "s.svg")],
        ),
        (
            words("pattern generate -q --station in/s.toml"),
            &[("--output", "p.csv"), ("-o", "q.csv")],
        ),
        (
            words(
                "pattern import mot in/t.txt -q --fps 10 --scale 0.001 --axis x --belt-speed 0.1",
            ),
            &[("-o", "m.csv"), ("--report", "m.json")],
        ),
    ]
}

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        for folder in ["in/b/stations", "in/b/patterns"] {
            std::fs::create_dir_all(place.at(folder)).unwrap();
        }
        for (name, content) in [
            ("in/s.toml", text(&["station", "show"])),
            (
                "in/p.csv",
                text(&["pattern", "generate", "-q", "--count", "4"]),
            ),
            (
                "in/c.toml",
                "[[case]]\nname = \"a\"\npattern = \"p.csv\"\n".into(),
            ),
            ("in/b/instances.csv", "name\na\n".into()),
            ("in/b/stations/a.toml", text(&["station", "show"])),
            ("in/b/patterns/a.csv", "id,x,y\na,0,0\n".into()),
            ("in/t.txt", "1,1,0,0,10,10,0.9\n2,1,10,0,10,10,0.9\n".into()),
        ] {
            std::fs::write(place.at(name), content).unwrap();
        }
        place
    }

    fn at(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    /// Calls the program in the folder: exit code, stdout, stderr.
    fn call(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(arguments)
            .current_dir(self.folder.path())
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (
            output.status.code(),
            text(output.stdout),
            text(output.stderr),
        )
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.at(name)).unwrap()
    }

    fn refused(&self, arguments: &[&str], words: &[&str]) {
        let (code, printed, told) = self.call(arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {told}");
        assert_eq!(printed, "", "{arguments:?}");
        for word in words.iter().chain(&["cure: "]) {
            assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
        }
    }
}

#[test]
fn no_output_replaces_files_of_others() {
    let place = Place::new();
    for (verb, outputs) in verbs() {
        for (flag, name) in outputs {
            // Result files are named by the program, in a folder.
            let target = if *flag == "--out" { "." } else { name };
            let call = [&verb[..], &[flag, target]].concat();
            let forced = [&call[..], &["--force"]].concat();
            std::fs::write(place.at(name), MINE).unwrap();
            place.refused(&call, &[name, "was not written by", "--force"]);
            assert_eq!(place.read(name), MINE, "{call:?}");
            // The new file takes the name: another name of the old one keeps what it leads to.
            std::fs::hard_link(place.at(name), place.at("kept")).unwrap();
            let (code, _, told) = place.call(&forced);
            assert_eq!(code, Some(0), "{forced:?}: {told}");
            let written = place.read(name);
            assert!(written != MINE, "{call:?}");
            assert_eq!(place.read("kept"), MINE, "{call:?}");
            std::fs::remove_file(place.at("kept")).unwrap();
            // A result of the same verb is replaced, and no flag of this changes it.
            let (code, _, told) = place.call(&call);
            assert_eq!(code, Some(0), "{call:?}: {told}");
            assert!(place.read(name) == written, "{call:?}");
            // An empty file holds nothing.
            std::fs::write(place.at(name), "").unwrap();
            assert_eq!(place.call(&call).0, Some(0), "{call:?}");
        }
    }
}

#[test]
fn no_output_is_an_input() {
    let place = Place::new();
    for (verb, outputs) in verbs() {
        for (flag, name) in outputs.iter().filter(|(flag, _)| *flag != "--out") {
            let inputs = ["in/s.toml", "in/p.csv", "in/c.toml", "in/t.txt"];
            let inputs = inputs.iter().filter(|input| verb.contains(input));
            for input in inputs {
                let before = place.read(input);
                // However it is written.
                let link = place.at("link");
                let _ = std::fs::remove_file(&link);
                std::os::unix::fs::symlink(place.at(input), &link).unwrap();
                for target in [input, "link"] {
                    let call = [&verb[..], &[flag, target, "--force"]].concat();
                    place.refused(&call, &["is already used by"]);
                }
                assert_eq!(place.read(input), before, "{verb:?} {flag} {name}");
            }
        }
    }
    // Policies are inputs, and so are weights beside them.
    for target in ["in/a.onnx", "in/a.onnx.data"] {
        std::fs::write(place.at(target), MINE).unwrap();
        for verb in [
            &["simulate", "-q"][..],
            &["compare", "-q"],
            &["sweep", "-q"],
        ] {
            let rest = ["--strategy", "onnx:in/a.onnx", "--force", "--html", target];
            let (code, _, told) = place.call(&[verb, &rest].concat());
            assert_eq!(code, Some(2), "{told}");
            assert_eq!(place.read(target), MINE);
        }
    }
}

#[test]
fn folders_are_tried_before_the_work() {
    let place = Place::new();
    for (verb, outputs) in verbs() {
        for (flag, _) in outputs {
            // A folder in which nobody can make a file.
            let target = if *flag == "--out" {
                "/proc/none"
            } else {
                "/proc/none.x"
            };
            place.refused(
                &[&verb[..], &[flag, target]].concat(),
                &["cannot write /proc/none"],
            );
        }
    }
    assert_eq!(std::fs::read_dir(place.folder.path()).unwrap().count(), 1);
}

#[test]
fn what_was_computed_is_printed_though_the_disk_is_full() {
    let place = Place::new();
    for (verb, outputs) in verbs() {
        let is_file = |flag: &&str| *flag != "--out" && *flag != "-o" && *flag != "--output";
        for flag in outputs.iter().map(|(flag, _)| *flag).filter(is_file) {
            let (code, printed, told) = place.call(&[&verb[..], &[flag, "/dev/full"]].concat());
            assert_eq!(code, Some(1), "{verb:?} {flag}: {told}");
            assert!(told.contains("cannot write /dev/full"), "{told}");
            assert!(printed.lines().count() > 1, "{verb:?} {flag}: {printed}");
            let (code, _, told) = place.call(&[&verb[..], &[flag, "/dev/null"]].concat());
            assert_eq!(code, Some(0), "{told}");
        }
    }
}

#[cfg(feature = "onnx")]
#[test]
fn a_training_replaces_neither_its_input_nor_files_of_others() {
    let place = Place::new();
    std::fs::copy(place.at("in/s.toml"), place.at("s.json")).unwrap();
    let imitated =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../policies/pickline.onnx");
    std::fs::copy(imitated, place.at("i.onnx")).unwrap();
    let call = ["train", "-q", "--steps", "1", "--out"];
    for (rest, word) in [
        (
            &["s.onnx", "--station", "s.json", "--force"][..],
            "already used by --station",
        ),
        (
            &["i.onnx", "--imitate", "onnx:i.onnx", "--force"],
            "already used by --imitate",
        ),
    ] {
        place.refused(&[&call[..], rest].concat(), &[word]);
    }
    for name in ["m.onnx", "m.json", "m.csv", "m.svg", "m.checkpoint.json"] {
        std::fs::write(place.at(name), MINE).unwrap();
        place.refused(&[&call[..], &["m.onnx"]].concat(), &[name, "--force"]);
        std::fs::remove_file(place.at(name)).unwrap();
    }
}

#[test]
fn a_refused_journal_leaves_nothing() {
    let place = Place::new();
    std::fs::write(place.at("notes"), MINE).unwrap();
    for (file, word) in [
        ("notes", "notes"),
        ("in/p.csv", "in/p.csv"),
        ("in/s.toml", "--station"),
    ] {
        let before = place.read(file);
        let call = [
            "run",
            "--clock",
            "messages",
            "--station",
            "in/s.toml",
            "--journal",
            file,
        ];
        place.refused(&call, &[word]);
        assert_eq!(place.read(file), before);
        assert!(!place.at(&format!("{file}.lock")).exists(), "{file}");
    }
    // A lock file of an earlier run stays.
    std::fs::write(place.at("notes.lock"), "").unwrap();
    place.refused(&["run", "--journal", "notes"], &["notes"]);
    assert!(place.at("notes.lock").exists());
}

/// A generated pattern says where it comes from, and is read as one that does not.
#[test]
fn a_pattern_file_names_its_call() {
    let place = Place::new();
    place.call(&[
        "pattern", "generate", "poisson", "-q", "--seed", "3", "-o", "a.csv",
    ]);
    let written = place.read("a.csv");
    let (first, rest) = written.split_once('\n').unwrap();
    assert!(first.starts_with("# pickline "), "{first}");
    assert!(
        first.ends_with(
            "; pickline pattern generate poisson -q --seed 3"
                .replace(" -q", "")
                .as_str()
        )
    );
    assert_eq!(
        rest,
        pickline_text(&["pattern", "generate", "poisson", "-q", "--seed", "3"])
    );
    let simulate = [
        "simulate",
        "-q",
        "--no-bound",
        "--format",
        "csv",
        "--pattern",
    ];
    assert_eq!(place.call(&[&simulate[..], &["a.csv"]].concat()).0, Some(0));
}

fn pickline_text(arguments: &[&str]) -> String {
    String::from_utf8(pickline(arguments).stdout).unwrap()
}

#[test]
fn an_output_among_the_patterns_that_are_read_is_refused() {
    let place = Place::new();
    std::fs::create_dir(place.at("pats")).unwrap();
    std::fs::copy(place.at("in/p.csv"), place.at("pats/p.csv")).unwrap();
    for verb in ["optimize", "sweep"] {
        let call = [verb, "-q", "--station", "in/s.toml", "--patterns", "pats"];
        place.refused(
            &[&call[..], &["--out", "pats"]].concat(),
            &["--out", "among the patterns"],
        );
    }
    assert_eq!(std::fs::read_dir(place.at("pats")).unwrap().count(), 1);
}

#[test]
fn a_picture_may_go_into_the_folder_that_is_made() {
    let place = Place::new();
    let simulate = ["simulate", "-q", "--no-bound", "--out", "new", "--html"];
    let (code, _, told) = place.call(&[&simulate[..], &["new/r.html"]].concat());
    assert_eq!(code, Some(0), "{told}");
    assert!(place.at("new/r.html").exists() && place.at("new/run.json").exists());
    std::fs::remove_dir_all(place.at("new")).unwrap();
    place.refused(
        &[&simulate[..], &["new/run.json"]].concat(),
        &["is already used by --out"],
    );
    place.refused(
        &[&simulate[..], &["new/sub/r.html"]].concat(),
        &["does not exist"],
    );
}

#[test]
fn a_run_that_cannot_begin_leaves_nothing() {
    let place = Place::new();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let before = std::fs::read_dir(place.folder.path()).unwrap().count();
    let call = |address: &str| {
        let mut call = vec!["run", "--journal", "e.j", "--listen"];
        call.push(address);
        if cfg!(feature = "mcap") {
            call.extend(["--record", "e.mcap"]);
        }
        place.call(&call)
    };
    for address in [&address, "nohost.invalid:80"] {
        let (code, _, told) = call(address);
        assert_eq!(code, Some(2), "{told}");
        assert_eq!(
            std::fs::read_dir(place.folder.path()).unwrap().count(),
            before,
            "{told}"
        );
    }
    // What was there stays.
    std::fs::write(place.at("e.j"), "").unwrap();
    call(&address);
    assert!(place.at("e.j").exists());
}
