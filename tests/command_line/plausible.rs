//! Values that are allowed and most likely wrong: a warning with the likely unit, an error
//! with `--strict`, and none for what the program and its documentation use.

use crate::common::pickline;

const STATION: &str = "[belt]\nspeed = 0.05\nlength = 4.2\nwidth = 1.05\n\n[[robot]]\nname = \"a\"\n\
    base = [1.3, -0.625]\nbin = [1.3, -0.525]\nreach = 0.8\nspeed = 0.5\ngrasp_time = 0.1\n\
    release_time = 0.1\n";

/// The call warns in words, once, and fails with `--strict`.
fn doubtful(arguments: &[&str], words: &[&str]) {
    let output = pickline(arguments);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    let warnings: Vec<&str> = told
        .lines()
        .filter(|l| l.starts_with("warning: "))
        .collect();
    assert_eq!(warnings.len(), 1, "{arguments:?}: {told}");
    for word in words {
        assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
    }
    let strict = pickline(&[arguments, &["--strict"]].concat());
    let told = String::from_utf8(strict.stderr).unwrap();
    assert_eq!(strict.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(strict.stdout.is_empty());
    for word in words.iter().chain(&["cure: "]) {
        assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
    }
}

#[test]
fn stations_in_wrong_units() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    let name = file.to_str().unwrap();
    for (from, to, words) in [
        (
            "width = 1.05",
            "width = 600",
            &["belt.width", "millimetres", "0.6 m"][..],
        ),
        (
            "reach = 0.8",
            "reach = 565",
            &["robot `a`, reach", "millimetres"],
        ),
        (
            "bin = [1.3, -0.525]",
            "bin = [2.7, -0.625]",
            &["bin is 1.4", "its base"],
        ),
        (
            "grasp_time = 0.1",
            "grasp_time = 100",
            &["grasp_time", "milliseconds"],
        ),
        (
            "speed = 0.5\n",
            "speed = 500\n",
            &["robot `a`, speed", "millimetres per second"],
        ),
        (
            "length = 4.2",
            "length = 4200",
            &["belt.length", "millimetres"],
        ),
    ] {
        let text = STATION.replacen(from, to, 1);
        assert!(text != STATION);
        std::fs::write(&file, text).unwrap();
        doubtful(&["station", "check", name], words);
        doubtful(&["station", "show", "--station", name], words);
        let printed = pickline(&["station", "check", name]).stdout;
        let printed = String::from_utf8(printed).unwrap();
        assert!(
            printed.contains("doubtful") && !printed.contains("\nok "),
            "{printed}"
        );
    }
}

#[test]
fn flags_and_patterns_in_wrong_units() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    let name = file.to_str().unwrap();
    std::fs::write(&file, "id,x,y\na,0,0\nb,-150,0.1\nc,-300,0\n").unwrap();
    let quick = ["--no-bound", "-q"];
    for (arguments, words) in [
        (
            &["--camera-x", "300"][..],
            &["--camera-x", "300 mm is 0.3 m"][..],
        ),
        (
            &["--position-noise", "5"],
            &["--position-noise", "millimetres"],
        ),
        (&["--pattern", name], &["p.csv: x", "150 mm is 0.15 m"]),
        (
            &["--belt-speed", "0.0001"],
            &["--belt-speed", "not plausible"],
        ),
    ] {
        doubtful(&[&["simulate"], &quick[..], arguments].concat(), words);
    }
    doubtful(&["pattern", "describe", name], &["p.csv: x"]);
    doubtful(
        &[
            "pattern",
            "generate",
            "-q",
            "--spacing",
            "150",
            "--width",
            "0.5",
        ],
        &["150 m"],
    );
    let sweep =
        "sweep -q --no-bound --robust SPT,FIFO --sweep reach --from 400 --to 800 --step 200";
    let sweep: Vec<&str> = sweep.split(' ').collect();
    doubtful(&sweep, &["--sweep reach at 800", "millimetres"]);
}

#[test]
fn feeds_in_wrong_units() {
    let folder = tempfile::tempdir().unwrap();
    let cases = folder.path().join("cases.toml");
    let case = "[[case]]\nname = \"a\"\nfeed = \"random\"\nflow = 1e6\nitems = 5\n";
    std::fs::write(&cases, case).unwrap();
    let compare = format!(
        "compare -q --robust SPT,SPT --no-policy --no-bound --cases {}",
        cases.display()
    );
    for (line, place, words) in [
        (
            "pattern generate -q random --flow 1e6 --count 5",
            "--flow",
            "items per hour",
        ),
        (
            "pattern generate -q clustered --cluster-spread 100 --count 5",
            "--cluster-spread",
            "100 mm is 0.1 m",
        ),
        (
            "pattern generate -q gaps --gap-length 1000 --count 5",
            "--gap-length",
            "1000 mm is 1 m",
        ),
        (
            "optimize -q --robots 1 --validate 0 --items 5 --patterns random:2 --flow 1e6 --no-bound",
            "--flow",
            "items per hour",
        ),
        (&compare, "case a: flow", "items per hour"),
    ] {
        let arguments: Vec<&str> = line.split(' ').collect();
        let output = pickline(&arguments);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}: {told}");
        let warned = told
            .lines()
            .any(|l| l.starts_with("warning: ") && l.contains(place) && l.contains(words));
        assert!(warned, "{line}: {told}");
        let strict = pickline(&[&arguments[..], &["--strict"]].concat());
        assert_eq!(strict.status.code(), Some(2), "{line}");
    }
}

#[test]
fn built_in_stations_and_patterns_are_plausible() {
    for arguments in [
        "station check paper --strict",
        "station check paper-narrow --strict",
        "station show --robots 12 --strict",
        "simulate -q --no-bound --strict --camera-x 0.5 --position-noise 0.01",
        "simulate -q --no-bound --strict --pattern patterns/recorded.csv",
        "pattern generate poisson -q --strict --area lognormal:80,0.5",
        "pattern describe --strict patterns/recorded.csv",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(&arguments)
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .output()
            .unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    }
}

/// Items that no robot has a bin for are told of, by every verb that reads the pattern; those of a
/// class that is not wanted are not.
#[test]
fn a_class_that_nobody_takes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let pattern = |classes: &str| format!("id,x,y,class\na,0,0,pet\nb,-0.5,0,{classes}\n");
    std::fs::write(at("glass.csv"), pattern("glass")).unwrap();
    std::fs::write(at("wood.csv"), pattern("wood")).unwrap();
    let case = "[[case]]\nname = \"a\"\npattern = \"glass.csv\"\n";
    std::fs::write(at("cases.toml"), case).unwrap();
    let (glass, cases) = (at("glass.csv"), at("cases.toml"));
    let robust = ["--robust", "SPT,SPT,SPT,SPT"];
    for call in [
        &[
            "simulate",
            "--pattern",
            &glass,
            "--strategy",
            "SPT,SPT,SPT,SPT",
        ][..],
        &["bound", "--pattern", &glass],
        &[
            "sweep",
            "--patterns",
            &glass,
            "--from",
            "0.3",
            "--to",
            "0.3",
            robust[0],
            robust[1],
        ],
        &[
            "compare",
            "--no-greedy",
            "--no-policy",
            "--cases",
            &cases,
            robust[0],
            robust[1],
        ],
    ] {
        let call = [call, &["-q", "--station", "sorting"]].concat();
        doubtful(
            &call,
            &["class", "no robot has a bin for 1 item of class `glass`"],
        );
    }
    // All of them are named.
    let many = "id,x,y,class\na,0,0,glass\nb,-0.5,0,tin\nc,-1,0,glass\nd,-1.5,0,iron\ne,-2,0,cork\n\
                f,-2.5,0,felt\ng,-3,0,clay\nh,-3.5,0,pet\n";
    std::fs::write(at("many.csv"), many).unwrap();
    let many = at("many.csv");
    let call = ["simulate", "-q", "--station", "sorting", "--pattern", &many];
    doubtful(
        &[&call[..], &["--strategy", "SPT,SPT,SPT,SPT"]].concat(),
        &[
            "class",
            "2 items of class `glass`, 1 item of class `tin`, 1 item of class `iron`, 1 item of class \
             `cork` and 2 items of 2 other classes, which will stay on the belt",
        ],
    );
    let wood = at("wood.csv");
    let call = [
        "simulate",
        "-q",
        "--station",
        "sorting",
        "--strict",
        "--pattern",
        &wood,
    ];
    let output = pickline(&[&call[..], &["--strategy", "SPT,SPT,SPT,SPT"]].concat());
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{output:?}"
    );
}
