//! What `run` has of its own. The robot leaves for the item at 4 s, meets it at 5 s and is done at
//! 6.5 s, as long as nothing else is said.

use super::rig::{Rig, assert_near, number};
use super::{Row, hold, row};
use serde_json::Value;

const RUN: [&str; 1] = ["run"];
/// A run that says nothing but tasks and its last status.
const PLAIN: &str = "run -q --clock messages --status-every 0 --station one.toml";

const BELT: &str = r#"{"kind":"belt","stamp":0,"speed":0.1}"#;
const IDLE: &str = r#"{"kind":"robot","stamp":0,"name":"a","state":"idle"}"#;
const SEEN: &str = r#"{"kind":"detection","stamp":0,"id":"A","x":0,"y":0}"#;
const ACK: &str = r#"{"kind":"ack","stamp":4.2,"task":1}"#;

pub const ROWS: &[Row] = &[
    row(&RUN, "--station", |rig, _| {
        // The other robot leaves at 4.5 s.
        let found = said(
            rig,
            &PLAIN.replace("one.toml", "fast.toml"),
            &[BELT, IDLE, SEEN, &tick(6.0)],
        );
        assert_near(number(first(&found, "task"), "/start"), 4.5);
    }),
    row(&RUN, "--robots", |rig, _| {
        let found = said(rig, "run -q --clock messages --robots 3", &[]);
        assert_eq!(
            first(&found, "status")["robots"].as_array().unwrap().len(),
            3
        );
    }),
    row(&RUN, "--belt-speed", |rig, _| {
        // Until the belt is heard of it goes as fast as planned.
        let start = |flags: &str| {
            let found = said(rig, &format!("{PLAIN} {flags}"), &[IDLE, SEEN, &tick(6.0)]);
            number(first(&found, "task"), "/start")
        };
        assert_near(start(""), 4.0);
        assert_near(start("--belt-speed 0.2"), 1.5);
    }),
    row(&RUN, "--strategy", |rig, _| {
        let name = |flags: &str| {
            let found = said(
                rig,
                &format!("{PLAIN} {flags}"),
                &[BELT, IDLE, SEEN, &tick(6.0)],
            );
            first(&found, "task")["strategy"].clone()
        };
        assert_eq!(name(""), "rules:FIFO");
        assert_eq!(name("--strategy LD"), "rules:LD");
    }),
    row(&RUN, "--budget-ms", |rig, _| {
        let told = |flags: &str| {
            let strategy = "--strategy lookahead:bases=FIFO/SPT";
            let call = format!("run --clock messages --station one.toml {strategy} {flags}");
            rig.done(&call).stderr
        };
        assert!(told("").starts_with("running lookahead:bases=FIFO/SPT, "));
        let told = told("--budget-ms 3");
        assert!(
            told.starts_with("running lookahead:budget-ms=3,bases=FIFO/SPT, "),
            "{told}"
        );
    }),
    row(&RUN, "--seed", |rig, _| {
        // The bases of a look-ahead are the best on patterns drawn under it.
        let told = |flags: &str| {
            let call = format!("run --clock messages --strategy lookahead {flags}");
            let told = rig.done(&call).stderr;
            let is_it = |line: &&str| line.starts_with("running lookahead:bases=");
            assert!(told.starts_with("searching for the assignments"), "{told}");
            told.lines().find(is_it).unwrap().to_owned()
        };
        let usual = told("");
        assert_ne!(usual, told("--seed 2"));
    }),
    row(&RUN, "--tolerance", |rig, _| {
        // The second is 5 cm from where the first has come.
        let second = r#"{"kind":"detection","stamp":1,"x":0.15,"y":0}"#;
        let first_one = r#"{"kind":"detection","stamp":0,"x":0,"y":0}"#;
        let seen = |flags: &str| {
            let call = format!("{PLAIN} {flags}");
            let found = said(
                rig,
                &call,
                &[BELT, first_one, &tick(1.0), second, &tick(2.0)],
            );
            first(&found, "status")["seen"].as_u64().unwrap()
        };
        assert_eq!((seen(""), seen("--tolerance 0.1")), (2, 1));
    }),
    row(&RUN, "--ack-timeout", |rig, _| {
        let again = |flags: &str| {
            let found = said(
                rig,
                &format!("{PLAIN} {flags}"),
                &[BELT, IDLE, SEEN, &tick(7.5)],
            );
            let tasks = found.iter().filter(|message| message["kind"] == "task");
            tasks.map(|task| number(task, "/start")).collect::<Vec<_>>()
        };
        assert_eq!(again(""), [4.0, 5.0, 6.0, 7.0]);
        assert_eq!(again("--ack-timeout 3"), [4.0, 7.0]);
    }),
    row(&RUN, "--result-timeout", |rig, _| {
        // A result is due at 6.5 s.
        let waits_until = |flags: &str| {
            let lines = [BELT, IDLE, SEEN, &tick(4.1), ACK, &tick(7.0)];
            let found = said(rig, &format!("{PLAIN} {flags}"), &lines);
            let due = found
                .iter()
                .rfind(|message| message["kind"] == "due")
                .unwrap();
            number(due, "/next")
        };
        assert_near(waits_until(""), 6.5 + 5.0);
        assert_near(waits_until("--result-timeout 2"), 6.5 + 2.0);
    }),
    row(&RUN, "--belt-timeout", |rig, _| {
        let seen = r#"{"kind":"detection","stamp":3,"id":"A","x":0.35,"y":0}"#;
        let tasks = |flags: &str| {
            let lines = [BELT, IDLE, &tick(3.0), seen, &tick(4.0)];
            count(&said(rig, &format!("{PLAIN} {flags}"), &lines), "task")
        };
        let given = [
            "",
            "--belt-timeout 2",
            "--belt-timeout 0",
            "--belt-timeout 9",
        ]
        .map(tasks);
        assert_eq!(given, [1, 0, 1, 1]);
    }),
    row(&RUN, "--robot-timeout", |rig, _| {
        let seen = r#"{"kind":"detection","stamp":3,"id":"A","x":0.35,"y":0}"#;
        let belt = r#"{"kind":"belt","stamp":3,"speed":0.1}"#;
        let tasks = |flags: &str| {
            let lines = [BELT, IDLE, belt, seen, &tick(4.0)];
            count(&said(rig, &format!("{PLAIN} {flags}"), &lines), "task")
        };
        let given = [
            "",
            "--robot-timeout 2",
            "--robot-timeout 0",
            "--robot-timeout 9",
        ]
        .map(tasks);
        assert_eq!(given, [1, 0, 1, 1]);
    }),
    row(&RUN, "--camera-delay", |rig, _| {
        // The picture was taken a second before its stamp: the item is 0.1 m further.
        let start = |flags: &str| start(rig, flags, "/start");
        assert_near(start(""), 4.0);
        assert_near(start("--camera-delay 1000"), 3.0);
        assert_near(start("--camera-delay -500"), 4.5);
    }),
    row(&RUN, "--lead", |rig, _| {
        for (flags, ahead) in [
            ("", 0.0),
            ("--lead 0.5", 0.5),
            ("--lead a=0.25", 0.25),
            ("--lead a=0.25 --lead 2", 0.25),
        ] {
            assert_near(start(rig, flags, "/start"), 4.0);
            assert_near(start(rig, flags, "/decided_at"), 4.0 - ahead);
        }
    }),
    row(&RUN, "--may-stop-belt", |rig, _| {
        let fault = r#"{"kind":"robot","stamp":1,"name":"a","state":"fault"}"#;
        let asked = |flags: &str| {
            let found = said(
                rig,
                &format!("{PLAIN} {flags}"),
                &[BELT, IDLE, fault, &tick(2.0)],
            );
            found
                .into_iter()
                .find(|message| message["kind"] == "belt_request")
        };
        assert!(asked("").is_none());
        assert_eq!(number(&asked("--may-stop-belt").unwrap(), "/speed"), 0.0);
    }),
    row(&RUN, "--stop-margin", |rig, _| {
        // The robot is still at the first item. It reaches the second, at y = 0.3, up to 0.4 m
        // behind its base, after a way of 0.5 m in 1 s: the last start is when that is at
        // x = 1.3, at 3 s.
        let items = [
            r#"{"kind":"detection","stamp":0,"id":"A","x":1,"y":0}"#,
            r#"{"kind":"detection","stamp":0,"id":"B","x":1,"y":0.3}"#,
        ];
        let ack = r#"{"kind":"ack","stamp":0.1,"task":1}"#;
        let asked = |flags: &str| {
            let lines = [BELT, IDLE, items[0], items[1], &tick(0.1), ack, &tick(3.0)];
            let found = said(rig, &format!("{PLAIN} --may-stop-belt {flags}"), &lines);
            number(first(&found, "belt_request"), "/stamp")
        };
        assert_near(asked(""), 3.0 - 0.5);
        assert_near(asked("--stop-margin 1.5"), 3.0 - 1.5);
    }),
    row(&RUN, "--min-detection", |rig, _| {
        let doubtful = SEEN.replace(r#""y":0"#, r#""y":0,"p_detection":0.6"#);
        let is_picked = |least: &str| {
            let call = format!("{PLAIN} --min-detection {least}");
            let found = said(rig, &call, &[BELT, IDLE, &doubtful, &tick(6.0)]);
            count(&found, "task") > 0
        };
        assert_eq!([is_picked("0.6"), is_picked("0.61")], [true, false]);
    }),
    row(&RUN, "--status-every", |rig, _| {
        let stamps = |every: &str| {
            let call = PLAIN.replace("--status-every 0", every);
            let found = said(rig, &call, &[BELT, &tick(5.0)]);
            let found = found.iter().filter(|message| message["kind"] == "status");
            found
                .map(|status| number(status, "/stamp"))
                .collect::<Vec<_>>()
        };
        assert_eq!(stamps(""), [1.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
        assert_eq!(stamps("--status-every 2"), [2.0, 4.0, 5.0]);
        assert_eq!(stamps("--status-every 0"), [5.0]);
    }),
    row(&RUN, "--schema", |rig, verb| {
        let schema = rig.json(&format!("{verb} --schema"));
        assert!(schema["$defs"]["Incoming"]["oneOf"].is_array());
    }),
    row(&RUN, "--clock", |rig, _| {
        // With the machine's clock the last status is of now, with that of the messages of the
        // last stamp.
        let stamp = |clock: &str| {
            let call = PLAIN.replace("--clock messages", clock);
            number(
                first(&said(rig, &call, &[BELT, &tick(5.0)]), "status"),
                "/stamp",
            )
        };
        assert_eq!(stamp("--clock messages"), 5.0);
        assert!(stamp("") > 1e9 && stamp("--clock system") > 1e9);
    }),
    row(&RUN, "--dialect", |rig, _| {
        let line = |dialect: &str| {
            let called = rig.feed(&format!("{PLAIN} {dialect}"), "");
            called.stdout.lines().next().unwrap().to_owned()
        };
        assert!(line("").starts_with("{\"v\":1,\"kind\":\"status\""));
        assert!(line("--dialect json").starts_with("{\"v\":1,\"kind\":\"status\""));
        let csv = line("--dialect csv");
        assert!(
            csv.contains(",0,") && csv.rsplit_once('*').unwrap().1.len() == 5,
            "{csv}"
        );
    }),
    row(&RUN, "--journal", |rig, _| {
        let call = PLAIN.replace(" -q", "") + " --journal line.journal";
        let told = |lines: &[&str]| rig.feed(&call, &lines.join("\n")).stderr;
        assert!(!told(&[BELT, IDLE, SEEN, &tick(1.0)]).contains("going on"));
        let before = rig.read("line.journal");
        std::fs::hard_link(rig.at("line.journal"), rig.at("kept")).unwrap();
        let again = told(&[]);
        let words = "resuming from line.journal: 1 items, 0 open tasks";
        assert!(again.lines().any(|line| line.starts_with(words)), "{again}");
        // It begins a file of its own.
        assert_eq!(rig.read("kept"), before);
        assert_ne!(rig.read("line.journal"), before);
    }),
    #[cfg(feature = "mcap")]
    row(&RUN, "--record", |rig, _| {
        rig.done(&format!("{PLAIN} --record run.mcap"));
        assert!(
            std::fs::read(rig.at("run.mcap"))
                .unwrap()
                .starts_with(b"\x89MCAP0\r\n")
        );
    }),
    #[cfg(feature = "mcap")]
    row(&RUN, "--replay", |rig, verb| {
        let lines = [BELT, IDLE, SEEN, &tick(6.0)].map(|line| line.to_owned() + "\n");
        let run = rig.feed(&format!("{PLAIN} --record run.mcap"), &lines.concat());
        assert!(run.stdout.contains("\"kind\":\"task\""));
        let again = rig.done(&format!("{verb} --replay run.mcap"));
        // Decisions take another time.
        let said = |text: &str| {
            text.lines()
                .filter(|line| !line.contains("\"status\""))
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        assert_eq!(said(&again.stdout), said(&run.stdout));
        assert!(again.stderr.contains("as recorded"), "{}", again.stderr);
    }),
];

#[test]
fn options_of_a_run_have_their_effect() {
    hold(ROWS);
}

fn tick(stamp: f64) -> String {
    format!(r#"{{"kind":"tick","stamp":{stamp}}}"#)
}

/// What `call` says of `lines`.
fn said(rig: &Rig, call: &str, lines: &[&str]) -> Vec<Value> {
    let called = rig.feed(call, &(lines.join("\n") + "\n"));
    assert_eq!(called.code, Some(0), "{call}: {}", called.stderr);
    let lines = called.stdout.lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// The first message of a kind.
fn first<'v>(messages: &'v [Value], kind: &str) -> &'v Value {
    let found = messages.iter().find(|message| message["kind"] == kind);
    found.unwrap_or_else(|| panic!("no {kind} in {messages:?}"))
}

fn count(messages: &[Value], kind: &str) -> usize {
    messages
        .iter()
        .filter(|message| message["kind"] == kind)
        .count()
}

/// A figure of the first task.
fn start(rig: &Rig, flags: &str, pointer: &str) -> f64 {
    let found = said(
        rig,
        &format!("{PLAIN} {flags}"),
        &[BELT, IDLE, SEEN, &tick(6.0)],
    );
    number(first(&found, "task"), pointer)
}
