//! The live protocol over MQTT, against mosquitto. `tests/mqtt/run.sh` installs it.
#![cfg(all(unix, feature = "mqtt"))]

#[path = "../common/authority.rs"]
mod authority;
mod broker;
#[path = "../common/programs.rs"]
mod programs;
#[path = "../common/trouble.rs"]
mod trouble;

use authority::authority;
use broker::Broker;
use pickline::live::protocol::{Incoming, Outgoing, Status, Verdict, decode, decode_outgoing};
use programs::Program;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use trouble::TROUBLE;

/// What a watcher has seen under a topic: whether it was retained, and the payload.
fn seen<'a>(lines: &'a [String], topic: &'a str) -> impl Iterator<Item = &'a str> {
    lines.iter().filter_map(move |line| {
        let (seen, payload) = line[2..].split_once(' ')?;
        let rest = seen.strip_prefix(topic)?;
        (rest.is_empty() || rest.starts_with('/')).then_some(payload)
    })
}

fn last_status(lines: &[String]) -> Status {
    match decode_outgoing(seen(lines, "pickline/status").last().unwrap().as_bytes()) {
        Ok(Outgoing::Status(status)) => *status,
        other => panic!("{other:?}"),
    }
}

/// How many items an emulated station says, at its end, are in the bins.
fn in_the_bins(remarks: &str) -> u64 {
    let last = remarks.lines().last().unwrap();
    let (count, _) = last.split_once(' ').unwrap();
    count.parse().unwrap()
}

/// The tasks that were given and what was heard of them, by task.
fn tasks(lines: &[String]) -> BTreeMap<u64, (String, Vec<Verdict>)> {
    let mut tasks = BTreeMap::new();
    for line in seen(lines, "pickline/task") {
        if let Ok(Outgoing::Task(task)) = decode_outgoing(line.as_bytes()) {
            let (item, _) = tasks
                .entry(task.id)
                .or_insert((task.item.clone(), Vec::new()));
            assert_eq!(*item, task.item, "a number was given twice");
        }
    }
    for line in seen(lines, "pickline/result") {
        if let Ok(Incoming::Result(report)) = decode(line.as_bytes()) {
            tasks.get_mut(&report.task).unwrap().1.push(report.result);
        }
    }
    tasks
}

/// A line that is quick enough for a test by the clock, and a pattern for it.
fn quick_line(broker: &Broker, items: u32) -> String {
    let (station, pattern) = (broker.path("station.toml"), broker.path("pattern.csv"));
    let text = "[belt]\nspeed = 0.4\nlength = 4.0\nwidth = 1.0\n\
        [[robot]]\nname = \"r1\"\nbase = [1.2, 0.6]\nbin = [1.2, 0.7]\nreach = 1.0\nspeed = 4.0\n\
        grasp_time = 0.1\nrelease_time = 0.1\n\
        [[robot]]\nname = \"r2\"\nbase = [2.8, 0.6]\nbin = [2.8, 0.7]\nreach = 1.0\nspeed = 4.0\n\
        grasp_time = 0.1\nrelease_time = 0.1\n";
    fs::write(&station, text).unwrap();
    let mut csv = String::from("id,x,y\n");
    for i in 0..items {
        csv += &format!(
            "i{i},{},{}\n",
            -0.12 * f64::from(i),
            0.1 * f64::from(i % 5) - 0.2
        );
    }
    fs::write(&pattern, csv).unwrap();
    format!("--station {} --mqtt {}", station.display(), broker.url())
}

/// Plays 1,000 items to the end; returns the pattern's file and what a watcher saw.
fn play_a_thousand(broker: &Broker, robots: u32, trouble: &str) -> (String, Vec<String>) {
    let file = broker.path("p.csv").display().to_string();
    let made = format!(
        "pattern generate poisson --radius 0.12 --count 1000 --robots {robots} --output {file}"
    );
    assert_eq!(Program::pickline(&made, &[]).finish().0, Some(0));
    let mut watcher = broker.watch();
    let line = format!("--clock messages --robots {robots} --mqtt {}", broker.url());
    let mut node = Program::pickline(&format!("run {line}"), &[]);
    let emulate = format!("emulate --pattern {file} {line} {trouble}");
    // It ends with another code where two robots were after one item.
    let (code, remarks) = Program::pickline(&emulate, &[]).finish();
    assert_eq!(code, Some(0), "{remarks}");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    watcher.said.wait_for("\"last\":true");
    watcher.signal("TERM");
    watcher.finish();
    (file, watcher.said.all())
}

#[test]
fn the_picks_are_those_of_the_simulator() {
    for robots in [2, 6] {
        let broker = Broker::open();
        let (file, lines) = play_a_thousand(&broker, robots, "");
        let simulate = format!("simulate -q --format json --pattern {file} --robots {robots}");
        let mut simulated = Program::pickline(&simulate, &[]);
        simulated.finish();
        let simulated: serde_json::Value =
            serde_json::from_str(&simulated.said.all().concat()).unwrap();
        let picks = simulated["picks"].as_array().unwrap();
        let given = seen(&lines, "pickline/task").map(|line| serde_json::from_str(line).unwrap());
        let given: Vec<serde_json::Value> = given.collect();
        assert_eq!(given.len(), picks.len());
        for (task, pick) in given.iter().zip(picks) {
            assert_eq!(pick["item"], task["item"]);
            assert_eq!(pick["decide_s"], task["decided_at"]);
            assert_eq!(pick["release_s"], task["free_at"]);
        }
        // Robots have topics of their own.
        let first = given[0]["robot"].as_str().unwrap();
        assert!(seen(&lines, &format!("pickline/task/{first}")).count() < given.len());
        let status = last_status(&lines);
        assert_eq!((status.seen, status.picked), (1000, picks.len() as u64));
    }
}

#[test]
fn with_everything_going_wrong_every_item_is_accounted_for() {
    for robots in [2, 6] {
        let (_, lines) = play_a_thousand(&Broker::open(), robots, TROUBLE);
        let status = last_status(&lines);
        assert_eq!(status.seen, 1000, "{status:?}");
        assert_eq!(status.picked + status.missed.total(), 1000, "{status:?}");
        assert!(status.picked > 100, "{status:?}");
        assert!(
            status.rejected.is_empty() && status.open_tasks.is_empty(),
            "{status:?}"
        );
    }
}

#[test]
fn a_broker_that_is_killed_loses_and_doubles_nothing() {
    let mut broker = Broker::open();
    let line = quick_line(&broker, 40);
    let pattern = broker.path("pattern.csv");
    let mut node = Program::pickline(&format!("run --ack-timeout 0.3 {line}"), &[]);
    let watcher = broker.watch();
    let emulate = format!("emulate --pattern {} {line}", pattern.display());
    let mut station = Program::pickline(&emulate, &[]);
    let mut before = Vec::new();
    let mut watcher = Some(watcher);
    for _ in 0..2 {
        // In the middle of the work, with tasks under way.
        let so_far = tasks(&before).len();
        programs::wait_for("tasks", || {
            let lines = watcher.as_ref().unwrap().said.all();
            tasks(&[&before[..], &lines].concat()).len() >= so_far + 3
        });
        broker.kill_and_restart(|| {
            let mut watcher = watcher.take().unwrap();
            watcher.signal("TERM");
            watcher.finish();
            before.extend(watcher.said.all());
            node.remarks.wait_for("trying again");
        });
        watcher = Some(broker.watch());
        programs::wait_for("a connection", || {
            let lines = watcher.as_ref().unwrap().said.all();
            seen(&lines, "pickline/node").any(|line| line.contains("online"))
        });
    }
    let (code, remarks) = station.finish();
    // It fails where two robots are after one item.
    assert_eq!(code, Some(0), "{remarks}");
    let bins = in_the_bins(&remarks);
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("connected to mqtt://"), "{remarks}");
    let watcher = watcher.unwrap();
    watcher.said.wait_for("\"last\":true");
    let lines = [before, watcher.said.all()].concat();
    let status = last_status(&lines);
    assert_eq!(
        (status.seen, status.on_belt, status.claimed),
        (40, 0, 0),
        "{status:?}"
    );
    assert_eq!(status.picked, bins, "{status:?}");
    assert_eq!(status.seen, status.picked + status.missed.total());
    assert_eq!(status.missed.no_result, 0, "{status:?}");
    assert!(bins > 20, "{status:?}");
    let mut picked = BTreeSet::new();
    for (task, (item, verdicts)) in tasks(&lines) {
        let first = verdicts.first();
        assert!(
            verdicts.iter().all(|verdict| Some(verdict) == first),
            "task {task}: {verdicts:?}"
        );
        if first == Some(&Verdict::Picked) {
            assert!(picked.insert(item.clone()), "{item} was picked twice");
        }
    }
}

#[test]
fn a_broker_that_stalls_holds_the_line_and_loses_nothing() {
    let broker = Broker::open();
    let line = quick_line(&broker, 30);
    let watcher = broker.watch();
    // Figures wait while nobody takes them.
    let mut node = Program::pickline(
        &format!("run --status-every 0.1 --result-timeout 60 {line}"),
        &[],
    );
    let emulate = format!(
        "emulate --pattern {} {line}",
        broker.path("pattern.csv").display()
    );
    let mut station = Program::pickline(&emulate, &[]);
    programs::wait_for("tasks", || {
        assert!(node.is_running(), "{:?}", node.remarks.all());
        tasks(&watcher.said.all()).len() >= 3
    });
    broker.signal("STOP");
    std::thread::sleep(std::time::Duration::from_secs(6));
    broker.signal("CONT");
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    let bins = in_the_bins(&remarks);
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    watcher.said.wait_for("\"last\":true");
    let lines = watcher.said.all();
    let status = last_status(&lines);
    // What came too late for the belt has come all the same.
    let late = status.rejected.get("off_belt").unwrap_or(&0);
    assert_eq!(status.seen + late, 30, "{status:?}");
    assert_eq!((status.claimed, status.picked), (0, bins), "{status:?}");
    assert_eq!(status.missed.no_result, 0, "{status:?}");
    let most = seen(&lines, "pickline/status").map(|line| {
        let status: serde_json::Value = serde_json::from_str(line).unwrap();
        status["queued"].as_u64().unwrap()
    });
    // They pile up, to half of the room at most: the rest is for tasks.
    let most = most.max().unwrap();
    assert!(most < 512, "{most}");
}

#[test]
fn the_last_will_tells_that_the_node_has_died() {
    let broker = Broker::open();
    let mut watcher = broker.watch();
    let arguments = format!("run --mqtt-client-id line-1 --mqtt {}", broker.url());
    let node = Program::pickline(&arguments, &[]);
    let online = r#"{"state":"online","client":"line-1"}"#;
    watcher.said.wait_for(online);
    // A second one would give the same items to other robots.
    let mut second = Program::pickline(&format!("run --mqtt {}", broker.url()), &[]);
    let (code, remarks) = second.finish();
    assert_eq!(code, Some(2), "{remarks}");
    assert!(
        remarks.contains("another node, `line-1`") && remarks.contains("cure: "),
        "{remarks}"
    );
    programs::wait_for("the first one's word", || {
        seen(&watcher.said.all(), "pickline/node").last() == Some(online)
    });
    node.signal("KILL");
    watcher
        .said
        .wait_for(r#"{"state":"offline","client":"line-1"}"#);
    watcher.signal("TERM");
    watcher.finish();
    // It is retained: whoever comes later hears of it too.
    let later = broker.watch();
    later
        .said
        .wait_for("1 pickline/node {\"state\":\"offline\"");
    // What comes while it is away waits for it under its id.
    let now = std::time::SystemTime::UNIX_EPOCH
        .elapsed()
        .unwrap()
        .as_secs_f64();
    let item = format!(r#"{{"kind":"detection","stamp":{now},"id":"a","x":0,"y":0}}"#);
    broker.publish("pickline/detection", &item, "1");
    let mut node = Program::pickline(&arguments, &[]);
    later.said.wait_for(online);
    programs::wait_for("the item", || {
        let lines = later.said.all();
        seen(&lines, "pickline/status").next().is_some() && last_status(&lines).seen == 1
    });
    // An orderly end says so as well.
    node.signal("INT");
    assert_eq!(node.finish().0, Some(0));
    programs::wait_for("the end", || {
        let lines = later.said.all();
        seen(&lines, "pickline/node")
            .last()
            .unwrap()
            .contains("offline")
    });
}

#[test]
fn passwords_and_certificates_are_asked_for() {
    let mut broker = Broker::place(
        "allow_anonymous false\npassword_file FOLDER/users\n\
         cafile FOLDER/ca.pem\ncertfile FOLDER/broker.pem\nkeyfile FOLDER/broker.key\n\
         require_certificate true\n",
    );
    authority(broker.path("").as_path(), &["broker", "line"]);
    let users = broker.path("users");
    let mut passwd = std::process::Command::new("mosquitto_passwd");
    let passwd = passwd
        .args(["-c", "-b"])
        .arg(&users)
        .args(["line", "s3cret-word"]);
    assert!(passwd.status().unwrap().success());
    broker.start();
    let file = |name: &str| broker.path(name).display().to_string();
    let url = format!("mqtts://127.0.0.1:{}", broker.port);
    let (ca, cert, key) = (file("ca.pem"), file("line.pem"), file("line.key"));
    let whole = format!("--mqtt {url} --mqtt-ca {ca} --mqtt-cert {cert} --mqtt-key {key}");
    let right = [("PICKLINE_MQTT_PASSWORD", "s3cret-word")];
    let wrong = [("PICKLINE_MQTT_PASSWORD", "wr0ng-word")];
    for (arguments, environment, word) in [
        (
            format!("{whole} --mqtt-user line"),
            &wrong[..],
            "refuses user `line`",
        ),
        (whole.clone(), &[], "lets nobody in without user"),
        (
            format!(
                "--mqtt mqtts://line:wr0ng-word@127.0.0.1:{} --mqtt-ca {ca} --mqtt-cert {cert} \
            --mqtt-key {key}",
                broker.port
            ),
            &[],
            "refuses user `line`",
        ),
        (
            format!("--mqtt {url} --mqtt-user line"),
            &right[..],
            "--mqtt-ca",
        ),
        (
            format!("--mqtt {url} --mqtt-user line --mqtt-ca {ca}"),
            &right[..],
            "asks for a certificate of this client",
        ),
        (
            format!("--mqtt {url} --mqtt-user line --mqtt-ca {cert}"),
            &right[..],
            "no TLS with",
        ),
        (whole.clone(), &right[..], "no user"),
    ] {
        let mut node = Program::pickline(&format!("run {arguments}"), environment);
        let (code, remarks) = node.finish();
        assert_eq!(code, Some(2), "{arguments}: {remarks}");
        assert!(
            remarks.contains(word) && remarks.contains("cure: "),
            "{arguments}: {remarks}"
        );
        assert!(
            !remarks.contains("s3cret") && !remarks.contains("wr0ng"),
            "{remarks}"
        );
    }
    fs::write(broker.path("secret"), "s3cret-word\n").unwrap();
    let secret = file("secret");
    let line = format!("--clock messages {whole} --mqtt-user line");
    let run = format!("run --mqtt-prefix plant/one {line} --mqtt-password-file {secret}");
    let mut node = Program::pickline(&run, &[]);
    let mut station = Program::pickline(&format!("emulate --mqtt-prefix plant/one {line}"), &right);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("44 of 50 picked"), "{remarks}");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(!remarks.contains("s3cret"), "{remarks}");
}

/// A server on a free port that says `answer` to whoever speaks to it, and hangs up or not.
fn server(answer: &'static [u8], hangs_up: bool) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        let mut kept = Vec::new();
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let _ = stream.read(&mut [0; 256]);
            let _ = stream.write_all(answer);
            if !hangs_up {
                kept.push(stream);
            }
        }
    });
    port
}

#[test]
fn what_is_no_broker_of_mqtt_5_is_named() {
    for (answer, hangs_up, words) in [
        // Return code 1 of MQTT 3.1.1: unacceptable protocol version.
        (
            &[0x20, 2, 0, 1][..],
            true,
            "does not speak MQTT 5, but an older version",
        ),
        (
            &[0x20, 2, 0, 1],
            false,
            "does not speak MQTT 5, but an older version",
        ),
        (
            b"HTTP/1.1 400 Bad Request\r\n\r\n",
            true,
            "a web server answers at",
        ),
        (b"SSH-2.0-OpenSSH_9.2\r\n", false, "is no MQTT broker"),
        // An alert of TLS.
        (&[0x15, 3, 3, 0, 2, 2, 40], true, "write mqtts://127.0.0.1:"),
    ] {
        let port = server(answer, hangs_up);
        for verb in ["run", "emulate"] {
            let arguments = format!("{verb} --mqtt mqtt://127.0.0.1:{port}");
            let (code, remarks) = Program::pickline(&arguments, &[]).finish();
            assert_eq!(code, Some(2), "{remarks}");
            assert!(
                remarks.contains(words) && remarks.contains("cure: "),
                "{remarks}"
            );
        }
    }
}

#[test]
fn what_is_wrong_with_a_certificate_is_said_with_its_cure() {
    let folder = tempfile::tempdir().unwrap();
    let openssl = |arguments: &str| {
        let mut command = std::process::Command::new("openssl");
        let arguments = arguments.split_whitespace();
        let output = command.args(arguments).current_dir(folder.path()).output();
        let output = output.unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    let key = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes";
    let own = |name: &str, more: &str| {
        openssl(&format!(
            "req -x509 {key} -keyout {name}.key -out {name}.pem -subj /CN=127.0.0.1 {more}"
        ));
    };
    let here = "-addext subjectAltName=IP:127.0.0.1";
    let leaf = "-addext basicConstraints=critical,CA:FALSE";
    // As openssl does by default, as the cure says, past its time, of another host.
    own("authority", &format!("{here} -days 2"));
    own("good", &format!("{here} {leaf} -days 2"));
    fs::write(
        folder.path().join("ca.cnf"),
        "[ca]\ndefault_ca = d\n[d]\ndatabase = index\nserial = serial\nnew_certs_dir = .\n\
         policy = p\ndefault_md = sha256\n[p]\ncommonName = supplied\n[v3]\n\
         subjectAltName = IP:127.0.0.1\nbasicConstraints = critical,CA:FALSE\n",
    )
    .unwrap();
    fs::write(folder.path().join("index"), "").unwrap();
    fs::write(folder.path().join("serial"), "01\n").unwrap();
    openssl(&format!(
        "req -new {key} -keyout expired.key -out expired.csr -subj /CN=127.0.0.1"
    ));
    openssl(
        "ca -batch -config ca.cnf -selfsign -keyfile expired.key -in expired.csr -out expired.pem \
         -startdate 20200101000000Z -enddate 20210101000000Z -extensions v3 -notext",
    );
    own(
        "other",
        &format!("-addext subjectAltName=DNS:broker.plant {leaf} -days 2"),
    );
    let pem = |name: &str| {
        folder
            .path()
            .join(format!("{name}.pem"))
            .display()
            .to_string()
    };
    for (server, trusted, words) in [
        (
            "authority",
            Some("authority"),
            &[
                "CA:TRUE",
                "basicConstraints=critical,CA:FALSE",
                "subjectAltName=IP:127.0.0.1",
            ][..],
        ),
        (
            "good",
            Some("other"),
            &["another one of the same name", "--mqtt-ca"],
        ),
        ("good", None, &["not trusted here", "--mqtt-ca"]),
        (
            "expired",
            Some("expired"),
            &["has expired", "renew the broker's certificate"],
        ),
        (
            "other",
            Some("other"),
            &["is for broker.plant, not for `127.0.0.1`"],
        ),
        ("good", Some("good"), &[]),
    ] {
        let broker = |name: &str| folder.path().join(name).display().to_string();
        let mut mosquitto = Broker::place(&format!(
            "allow_anonymous true\ncertfile {}\nkeyfile {}\n",
            broker(&format!("{server}.pem")),
            broker(&format!("{server}.key"))
        ));
        mosquitto.start();
        let trusted = trusted.map_or(String::new(), |name| format!(" --mqtt-ca {}", pem(name)));
        let arguments = format!("run --mqtt mqtts://127.0.0.1:{}{trusted}", mosquitto.port);
        let mut node = Program::pickline(&arguments, &[]);
        if words.is_empty() {
            std::thread::sleep(std::time::Duration::from_millis(1500));
            node.signal("TERM");
            let (code, remarks) = node.finish();
            assert_eq!(code, Some(0), "{remarks}");
            assert!(!remarks.contains("TLS"), "{remarks}");
            continue;
        }
        let (code, remarks) = node.finish();
        assert_eq!(code, Some(2), "{server}: {remarks}");
        for word in words.iter().chain(&["no TLS with", "cure: "]) {
            assert!(remarks.contains(word), "{server}: {remarks}");
        }
        assert!(!remarks.contains("CaUsedAsEndEntity"), "{remarks}");
    }
}

#[test]
fn a_broker_may_come_later() {
    let mut broker = Broker::place("allow_anonymous true\n");
    let line = format!("--clock messages --mqtt {}", broker.url());
    let mut node = Program::pickline(&format!("run {line}"), &[]);
    let mut station = Program::pickline(&format!("emulate {line}"), &[]);
    node.remarks.wait_for("refused (os error");
    station.remarks.wait_for("trying again");
    broker.start();
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("44 of 50 picked"), "{remarks}");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert_eq!(remarks.matches("trying again").count(), 1, "{remarks}");
}

#[test]
fn bad_messages_are_refused_and_the_stream_goes_on() {
    let broker = Broker::open();
    let watcher = broker.watch();
    let mut node = Program::pickline(
        &format!("run --clock messages --mqtt {}", broker.url()),
        &[],
    );
    watcher.said.wait_for("online");
    let idle = r#"{"kind":"robot","stamp":100,"name":"r1","state":"idle"}"#;
    let tick = |stamp: f64| format!(r#"{{"kind":"tick","stamp":{stamp}}}"#);
    broker.publish("pickline/robot/r1", idle, "0");
    broker.publish("pickline/robot", "{", "1");
    broker.publish("pickline/ack/r1", &tick(100.0), "1");
    broker.publish("pickline/detection", &"x".repeat(70_000), "2");
    broker.publish("pickline/detection/camera", "\u{1b}", "1");
    broker.publish("pickline/nonsense", "{", "1");
    let item = r#"{"kind":"detection","stamp":100,"id":"a","x":0.5,"y":-0.2}"#;
    broker.publish("pickline/detection/camera", item, "1");
    broker.publish("pickline/tick", &tick(101.0), "1");
    watcher.said.wait_for("pickline/task/r1 ");
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert_eq!(remarks.matches("refused (").count(), 4, "{remarks}");
    assert!(
        remarks.contains("topic pickline/ack/r1: refused (kind): kind `tick`; expected `ack`")
            && remarks.contains("topic pickline/detection/camera: refused (syntax): "),
        "{remarks}"
    );
    watcher.said.wait_for("\"last\":true");
    let refused = [("kind", 1), ("syntax", 2), ("too_long", 1)];
    let refused = refused.map(|(reason, count)| (reason.to_owned(), count));
    assert_eq!(last_status(&watcher.said.all()).rejected, refused.into());
}

#[test]
fn wrong_usage_is_refused() {
    for (arguments, word) in [
        ("--mqtt line:1883", "--mqtt"),
        ("--mqtt http://line", "--mqtt"),
        ("--mqtt mqtt://u:secret@line:0", "--mqtt"),
        ("--mqtt mqtt://127.0.0.1 --mqtt-prefix a/#", "--mqtt-prefix"),
        ("--mqtt mqtt://127.0.0.1 --mqtt-ca /dev/null", "--mqtt-ca"),
        ("--mqtt mqtts://127.0.0.1 --mqtt-ca /dev/null", "/dev/null"),
        (
            "--mqtt mqtt://127.0.0.1 --mqtt-password-file /dev/null",
            "/dev/null",
        ),
        ("--mqtt mqtt://127.0.0.1 --listen 127.0.0.1:0", "--listen"),
        ("--mqtt-user me", "--mqtt"),
    ] {
        for verb in ["run", "emulate"] {
            let (code, remarks) = Program::pickline(&format!("{verb} {arguments}"), &[]).finish();
            assert_eq!(code, Some(2), "{arguments}: {remarks}");
            assert!(
                remarks.contains(word) && !remarks.contains("secret"),
                "{remarks}"
            );
        }
    }
}
