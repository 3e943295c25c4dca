//! Values and names that cannot be, or are most likely wrong, in what a live line is told.

use crate::programs::feed;
use std::process::{Command, Output};

fn pickline(arguments: &[&str], input: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    feed(command.args(arguments), input.as_bytes()).0
}

/// What `pickline run` says on stderr about a line after a belt that is right.
fn remarks_on(fields: &str) -> String {
    let input = format!(
        "{{\"kind\":\"belt\",\"stamp\":1,\"speed\":0.05}}\n{{\"kind\":\"belt\",\"stamp\":1,\
         \"speed\":0.05}}\n{{{fields}}}\n"
    );
    let output = pickline(&["run", "--clock", "messages"], &input);
    assert_eq!(output.status.code(), Some(0));
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn impossible_values_are_refused_with_the_likely_unit() {
    for (fields, words) in [
        (
            r#""kind":"detection","stamp":1,"x":-350,"y":0"#,
            &[
                "refused (value): x = -350",
                "millimetres",
                "-350 mm is -0.35 m",
            ][..],
        ),
        (
            r#""kind":"detection","stamp":1,"x":350,"y":0"#,
            &["refused (off_belt)", "x = 350 m", "350 mm is 0.35 m"],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":-120"#,
            &["refused (off_belt)", "y = -120 m", "-120 mm is -0.12 m"],
        ),
        (
            r#""kind":"belt","stamp":1,"speed":300"#,
            &[
                "refused (value): speed = 300",
                "300 mm/s is 0.3 m/s",
                "metres per minute",
            ],
        ),
        (
            r#""kind":"belt","stamp":1,"speed":-18"#,
            &["refused (value): speed = -18", "18 m/min is 0.3 m/s"],
        ),
        (
            r#""kind":"belt","stamp":1795656426000,"speed":0.3"#,
            &["refused (value): stamp", "1795656426000 ms is 1795656426 s"],
        ),
        (
            r#""kind":"belt","stamp":1795656426000000000,"speed":0.3"#,
            &[
                "refused (value): stamp",
                "nanoseconds",
                " ns is 1795656426 s",
            ],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":0,"p_detection":95"#,
            &["refused (value): p_detection = 95", "95 % is 0.95"],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":0,"area_cm2":1e7"#,
            &["refused (value): area_cm2"],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":0,"covariance":[4,0,4]"#,
            &[
                "refused (value): covariance has xx = 4 m^2",
                "square millimetres",
            ],
        ),
    ] {
        let remarks = remarks_on(fields);
        let refused: Vec<&str> = remarks.lines().filter(|l| l.contains("refused")).collect();
        assert_eq!(refused.len(), 1, "{fields}: {remarks}");
        for word in words {
            assert!(refused[0].contains(word), "{word} not in {remarks}");
        }
    }
}

#[test]
fn unlikely_values_give_a_warning_and_are_used() {
    for (fields, words) in [
        (
            r#""kind":"detection","stamp":1,"x":-40,"y":0"#,
            &["stdin line 3: detection: x: -40 m", "-40 mm is -0.04 m"][..],
        ),
        (
            r#""kind":"belt","stamp":1,"speed":3"#,
            &["belt: speed: 3 m/s is 60 times", "3 m/min is 0.05 m/s"],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":0,"area_cm2":8000"#,
            &["detection: area_cm2", "8000 mm^2 is 80 cm^2"],
        ),
        (
            r#""kind":"detection","stamp":1,"x":0,"y":0,"covariance":[0.01,0,0.01]"#,
            &["detection: covariance", "treated as one item"],
        ),
        (
            r#""kind":"robot","name":"r1","state":"busy","stamp":1,"available_at":1000000001"#,
            &["robot: available_at: 1000000001 s", "is ignored"],
        ),
        (
            r#""kind":"robot","name":"r1","state":"busy","stamp":1,"available_at":5e4"#,
            &[
                "robot: available_at: 50000 s",
                "milliseconds",
                "50000 ms is 50 s",
            ],
        ),
        (
            r#""kind":"robot","name":"r1","state":"busy","stamp":1,"available_at":-100"#,
            &["robot: available_at: -100 s"],
        ),
    ] {
        let remarks = remarks_on(fields);
        assert!(!remarks.contains("refused"), "{remarks}");
        for word in words {
            assert!(remarks.contains(word), "{word} not in {remarks}");
        }
    }
    // Nothing is asked of a line where all is well.
    let usual = r#""kind":"detection","stamp":1,"x":-0.35,"y":0.1,"area_cm2":80"#;
    assert_eq!(remarks_on(usual).lines().count(), 2);
}

/// The result counts, whatever is wrong with what it says besides.
#[test]
fn no_pick_is_lost_by_an_impossible_place_or_time() {
    use pickline_live::protocol::{Incoming, Outgoing, decode};
    use pickline_live::{ClockKind, Config, Controller};
    for (fields, words) in [
        (
            r#""found":{"x":1300,"y":-0.2}"#,
            &["found.x", "1300 mm is 1.3 m"][..],
        ),
        (r#""found":{"x":1.3,"y":-1e9}"#, &["found.y"]),
        (
            r#""available_at":1000500000"#,
            &["available_at", "1000500000 s"],
        ),
        (
            r#""available_at":0.5"#,
            &["available_at", "seconds from now?"],
        ),
        (
            r#""available_at":1000100"#,
            &["available_at", "1000100 ms is 1000.1 s"],
        ),
    ] {
        let station = pickline::station::built_in("paper").unwrap();
        let strategy = pickline::strategies::read_alone("SPT,FIFO", 2).unwrap();
        let config = Config::default().with_clock(ClockKind::Messages);
        let station = station.station(Some(2)).unwrap();
        let mut line = Controller::new(station, strategy.make(), config).unwrap();
        let mut say = |fields: &str| {
            let message: Incoming = decode(format!("{{{fields}}}").as_bytes()).unwrap();
            line.handle(message).unwrap();
            let doubt = line.take_doubt().map(|doubt| doubt.to_string());
            (line.take_output(), doubt)
        };
        for _ in 0..2 {
            say(r#""kind":"belt","stamp":1000,"speed":0"#);
        }
        say(r#""kind":"robot","stamp":1000,"name":"r1","state":"idle""#);
        let see = |id: &str, x: f64| {
            format!(r#""kind":"detection","stamp":1000,"id":"{id}","x":{x},"y":-0.2"#)
        };
        let tasks = |output: &[Outgoing]| {
            let tasks = output.iter().filter_map(|message| match message {
                Outgoing::Task(task) => Some(task.id),
                _ => None,
            });
            tasks.collect::<Vec<u64>>()
        };
        say(&see("a", 1.3));
        say(&see("b", 1.2));
        let given = tasks(&say(r#""kind":"tick","stamp":1000"#).0);
        assert_eq!(given.len(), 1);
        let task = given[0];
        say(&format!(r#""kind":"ack","stamp":1000,"task":{task}"#));
        let result =
            format!(r#""kind":"result","stamp":1003,"task":{task},"result":"PICKED",{fields}"#);
        let (mut output, doubt) = say(&result);
        let doubt = doubt.unwrap();
        for word in words {
            assert!(doubt.contains(word), "{word} not in {doubt}");
        }
        // It is free at the stamp of its result, as if nothing had been said.
        output.extend(say(r#""kind":"tick","stamp":1003.1"#).0);
        assert_eq!(tasks(&output).len(), 1, "{fields}");
        line.report(true, 0);
        let status = line
            .take_output()
            .into_iter()
            .find_map(|message| match message {
                Outgoing::Status(status) => Some(status),
                _ => None,
            });
        let status = serde_json::to_value(status.unwrap()).unwrap();
        assert_eq!(status["picked"], 1, "{fields}");
        assert_eq!(status["noted"]["doubtful_value"], 1, "{fields}");
    }
}

/// A robot whose name no message may carry gets no task for ever.
#[test]
fn stations_have_no_names_that_messages_cannot_carry() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    let path = file.to_str().unwrap();
    let template = "[belt]\nspeed = 0.05\nlength = 4.0\nwidth = 1.0\n\n[[robot]]\nname = \"NAME\"\n\
                    base = [1.3, -0.6]\nbin = [1.3, -0.5]\nreach = 0.8\nspeed = 0.5\n\
                    grasp_time = 0.1\nrelease_time = 0.1\n";
    let long = "x".repeat(201);
    for (name, word) in [
        ("", "empty"),
        (" r1", "ends with a space"),
        ("r1 ", "ends with a space"),
        ("r\\u0007", "control characters"),
        ("r\\n1", "line breaks"),
        ("r\\u202e1", "control characters"),
        (&long, "too long: 201 characters"),
    ] {
        std::fs::write(&file, template.replace("NAME", name)).unwrap();
        for arguments in [
            &["station", "check", path][..],
            &["station", "show", "--station", path],
            &["simulate", "--station", path],
            &["run", "--station", path],
            &["emulate", "--station", path],
        ] {
            let output = pickline(arguments, "");
            let errors = String::from_utf8(output.stderr).unwrap();
            assert_eq!(
                output.status.code(),
                Some(2),
                "{arguments:?} {name}: {errors}"
            );
            assert!(
                errors.contains(word) && errors.contains("line.toml:7"),
                "{errors}"
            );
        }
    }
    for name in ["SCARA-2", "\u{e9}", "delta 1"] {
        std::fs::write(&file, template.replace("NAME", name)).unwrap();
        assert!(pickline(&["station", "check", path], "").status.success());
        let robot =
            format!("{{\"kind\":\"robot\",\"stamp\":1,\"name\":\"{name}\",\"state\":\"idle\"}}\n");
        let output = pickline(&["run", "--station", path, "--clock", "messages"], &robot);
        let remarks = String::from_utf8(output.stderr).unwrap();
        assert!(!remarks.contains("refused"), "{remarks}");
    }
}

#[test]
fn patterns_have_no_names_that_messages_cannot_carry() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("items.csv");
    std::fs::write(&file, "id,x,y\na\u{7},0,0\n").unwrap();
    let arguments = ["emulate", "--pattern", file.to_str().unwrap()];
    let output = pickline(&arguments, "");
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("control characters"), "{errors}");
}

#[test]
fn wrong_flags_are_named_with_their_cure() {
    let folder = tempfile::tempdir().unwrap();
    let station = folder.path().join("station.toml");
    std::fs::write(&station, "").unwrap();
    let station = station.to_str().unwrap();
    for (arguments, words) in [
        (
            &["--listen", "127.0.0.1:99999"][..],
            &["--listen", "HOST:PORT"][..],
        ),
        (&["--listen", "7400"], &["--listen", "HOST:PORT"]),
        (&["--listen", "8.8.8.8:7400"], &["--listen", "cure: "]),
        (
            &["--listen", "127.0.0.1:7531", "--connect", "127.0.0.1:7532"],
            &["--listen", "--connect"],
        ),
        (
            &["--journal", "/nonexistent/j"],
            &["/nonexistent", "cure: "],
        ),
        #[cfg(feature = "mcap")]
        (&["--record", station], &["exists", "cure: "]),
    ] {
        let arguments = [&["run"], arguments].concat();
        let output = pickline(&arguments, "");
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        for word in words {
            assert!(errors.contains(word), "{word} not in {errors}");
        }
    }
    assert_eq!(std::fs::read_to_string(station).unwrap(), "");
}
