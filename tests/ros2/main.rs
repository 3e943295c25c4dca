//! The live protocol over ROS 2. `tests/ros2/run.sh` installs the other DDS implementation
//! that some of it is tested against, and builds the interface package.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]
#![cfg(all(unix, feature = "ros2"))]

mod message_time;
#[path = "../common/programs.rs"]
mod programs;
#[path = "../common/quick_line.rs"]
mod quick_line;
#[path = "../common/trouble.rs"]
mod trouble;

use pickline_live::transport::ros2::messages::{Time, all};
use programs::Program;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Only the loopback interface, for the other implementation.
const CYCLONE: &str = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\"/>\
    </Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>\
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>60\
    </MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>\
    </Domain></CycloneDDS>";

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ros2/pickline_interfaces")
}

/// A domain that no test beside this one uses.
fn domain(test: u32) -> u32 {
    1 + (std::process::id() + 17 * test) % 100
}

fn line(folder: &Path, items: u32) -> String {
    quick_line::write(folder, items);
    let station = folder.join("station.toml");
    format!("--station {}", station.display())
}

/// What run.sh has made ready.
fn prepared(variable: &str) -> PathBuf {
    let found = std::env::var_os(variable);
    found.map(PathBuf::from).unwrap_or_else(|| {
        panic!("run tests/ros2/run.sh, which installs what is needed and sets {variable}")
    })
}

#[test]
fn the_definitions_are_those_of_the_interface_package() {
    // As ROS's own tools have read it when they built the package.
    let read = fs::read_to_string(prepared("PICKLINE_ROS2_FIELDS")).unwrap();
    let mut read: BTreeMap<String, Vec<(String, String)>> = serde_json::from_str(&read).unwrap();
    for message in all() {
        if message.package != "pickline_interfaces" {
            continue;
        }
        let fields = message.fields.into_iter();
        let fields: Vec<_> = fields.map(|(kind, name)| (kind, name.to_owned())).collect();
        assert_eq!(read.remove(message.name), Some(fields), "{}", message.name);
    }
    assert_eq!(read.keys().collect::<Vec<_>>(), [""; 0]);
    // Nothing in the folder is left out of the build.
    let build = fs::read_to_string(package().join("CMakeLists.txt")).unwrap();
    for folder in ["msg", "action"] {
        for file in fs::read_dir(package().join(folder)).unwrap() {
            let name = file.unwrap().file_name().into_string().unwrap();
            assert!(
                build.contains(&format!("\"{folder}/{name}\"")),
                "CMakeLists.txt lacks {name}"
            );
        }
    }
}

#[test]
fn stamps_keep_their_nanoseconds() {
    for (stamp, sec, nanosec) in [
        (0.0, 0, 0),
        (1.5, 1, 500_000_000),
        (0.999_999_999_9, 1, 0),
        (1_795_000_000.25, 1_795_000_000, 250_000_000),
        (-1.0, 0, 0),
        (1e300, i32::MAX, 0),
        (f64::NAN, 0, 0),
    ] {
        assert_eq!(Time::from_stamp(stamp), Time { sec, nanosec }, "{stamp}");
    }
    for stamp in [0.1, 12.345_678_901, 1_795_000_000.123_456_7] {
        let back = Time::from_stamp(stamp).stamp();
        assert!((back - stamp).abs() < 5e-7, "{stamp} {back}");
    }
}

#[test]
fn run_and_emulate_find_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!(
        "{} --ros2 --ros2-domain {}",
        line(folder.path(), 30),
        domain(1)
    );
    let pattern = folder.path().join("pattern.csv");
    // The station waits for the node.
    let emulate = format!("emulate --pattern {} {line}", pattern.display());
    let mut station = Program::pickline(&emulate, &[]);
    let mut node = Program::pickline(&format!("run {line}"), &[]);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("30 of 30 items in the bins"), "{remarks}");
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(
        remarks.contains("30 of 30 items picked, 0 missed, 0 on the belt, 0 claimed"),
        "{remarks}"
    );
}

fn against_cyclone(test: u32, arguments: &str, peer: &[&str]) {
    let python = prepared("PICKLINE_ROS2_PYTHON");
    let folder = tempfile::tempdir().unwrap();
    let domain = domain(test).to_string();
    let line = line(folder.path(), 0);
    let run = format!("run --ros2 --ros2-namespace line1 --ack-timeout 0.3 {arguments} {line}");
    let mut node = Program::pickline(&run, &[("ROS_DOMAIN_ID", &domain)]);
    let mut command = Command::new(python);
    command
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/ros2/peer.py"))
        .arg(package().join("msg"))
        .arg(&domain)
        .args(peer)
        .env("CYCLONEDDS_URI", CYCLONE);
    let mut peer = Program::start(&mut command);
    programs::wait_for("all picks", || {
        let said = peer.said.all();
        said.iter().any(|line| line == "done") || !peer.is_running()
    });
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    let (code, trouble) = peer.finish();
    assert_eq!(code, Some(0), "{trouble}\n{remarks}");
    let found = peer.said.all().pop().unwrap();
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["wrong"], serde_json::json!([]), "{found}");
    assert_eq!(found["picked"].as_array().unwrap().len(), 20, "{found}");
    assert_eq!(found["tasks"], 20, "{found}");
    assert_eq!(found["resent"], true, "{found}");
    let status = &found["status"];
    assert_eq!(status["last"], true, "{found}");
    assert_eq!(
        (&status["seen"], &status["picked"]),
        (&20.into(), &20.into()),
        "{found}"
    );
    assert_eq!(
        status["rejected"],
        serde_json::json!({"field": 3}),
        "{found}"
    );
    assert_eq!(status["frame"], "belt");
    let robots = status["robots"].as_object().unwrap().values();
    assert_eq!(
        robots.map(|picked| picked.as_u64().unwrap()).sum::<u64>(),
        20
    );
    assert!(
        remarks.contains(
            "topic /line1/detections: refused (field): frame_id `camera`; expected `belt`"
        ),
        "{remarks}"
    );
}

#[test]
fn robots_and_camera_of_another_dds_implementation() {
    against_cyclone(2, "", &[]);
}

#[test]
fn a_camera_that_is_not_reliable() {
    against_cyclone(3, "--ros2-best-effort", &["best-effort"]);
}

#[test]
fn the_first_of_two_nodes_in_a_namespace_stays() {
    let folder = tempfile::tempdir().unwrap();
    let (pattern, journal) = (
        folder.path().join("pattern.csv"),
        folder.path().join("journal"),
    );
    let line = format!(
        "{} --ros2 --ros2-domain {}",
        line(folder.path(), 20),
        domain(4)
    );
    let emulate = format!("emulate --pattern {} {line}", pattern.display());
    let run = format!("run --journal {} {line}", journal.display());
    let mut station = Program::pickline(&emulate, &[]);
    let mut node = Program::pickline(&run, &[]);
    programs::wait_for("a task", || {
        fs::read_to_string(&journal).is_ok_and(|text| text.contains("\"claims\""))
    });
    let mut second = Program::pickline(&format!("run {line}"), &[]);
    let (code, remarks) = second.finish();
    assert_eq!(code, Some(2), "{remarks}");
    assert!(
        remarks.contains("another node sends tasks under /pickline") && remarks.contains("cure: "),
        "{remarks}"
    );
    // Another line of the same domain is no rival.
    let other = format!("run --ros2-namespace line2 {line}");
    let mut other = Program::pickline(&other, &[]);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("20 of 20 items in the bins"), "{remarks}");
    // One that was killed is in nobody's way.
    node.signal("KILL");
    node.finish();
    let mut next = Program::pickline(&format!("run {line}"), &[]);
    let mut station = Program::pickline(&emulate, &[]);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("20 of 20 items in the bins"), "{remarks}");
    for node in [&mut next, &mut other] {
        node.signal("TERM");
        let (code, remarks) = node.finish();
        assert_eq!(code, Some(0), "{remarks}");
    }
}

#[test]
fn one_of_two_nodes_that_come_together_stays() {
    let folder = tempfile::tempdir().unwrap();
    let run = format!(
        "run {} --ros2 --ros2-domain {}",
        line(folder.path(), 0),
        domain(5)
    );
    let mut nodes = [(); 2].map(|()| Program::pickline(&run, &[]));
    programs::wait_for("one to give way", || {
        nodes.iter_mut().any(|node| !node.is_running())
    });
    let stays = nodes.iter_mut().position(Program::is_running);
    let (stays, goes) = (stays.unwrap(), 1 - stays.unwrap());
    let (code, remarks) = nodes[goes].finish();
    assert_eq!(code, Some(2), "{remarks}");
    assert!(remarks.contains("another node sends tasks"), "{remarks}");
    // It has work to do: it is not still waiting for the other.
    let emulate = run.replace("run ", "emulate --pattern PATTERN ");
    fs::write(folder.path().join("pattern.csv"), "id,x,y\na,0,0\n").unwrap();
    let pattern = folder.path().join("pattern.csv").display().to_string();
    let mut station = Program::pickline(&emulate.replace("PATTERN", &pattern), &[]);
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("1 of 1 items in the bins"), "{remarks}");
    nodes[stays].signal("TERM");
    let (code, remarks) = nodes[stays].finish();
    assert_eq!(code, Some(0), "{remarks}");
}

#[test]
fn wrong_usage_is_refused() {
    for (arguments, environment, word) in [
        ("--ros2 --ros2-domain 233", &[][..], "--ros2-domain"),
        ("--ros2", &[("ROS_DOMAIN_ID", "x")][..], "ROS_DOMAIN_ID"),
        (
            "--ros2 --ros2-namespace a-b",
            &[],
            "--ros2-namespace: `/a-b` contains `-`\n  cure: ",
        ),
        (
            "--ros2 --ros2-namespace /line/",
            &[],
            "--ros2-namespace: `/line/` has an extra slash",
        ),
        ("--ros2 --ros2-network nowhere", &[], "--ros2-network"),
        // Of a class that is given to nobody.
        (
            "--ros2 --ros2-network 240.0.0.1",
            &[],
            "--ros2-network: 240.0.0.1 is not an address of this machine\n  cure: give one of ",
        ),
        (
            "--ros2 --ros2-network 127.0.0.1 --ros2-network 0.0.0.0",
            &[],
            "--ros2-network: 0.0.0.0 is not an address",
        ),
        (
            "--ros2 --ros2-network ::1",
            &[],
            "--ros2-network: ::1 is an IPv6 address",
        ),
        ("--ros2 --listen 127.0.0.1:0", &[], "--listen"),
        ("--ros2-frame map", &[], "--ros2"),
    ] {
        for verb in ["run", "emulate"] {
            let command = format!("{verb} {arguments}");
            let (code, remarks) = Program::pickline(&command, environment).finish();
            assert_eq!(code, Some(2), "{arguments}: {remarks}");
            assert!(remarks.contains(word), "{arguments}: {remarks}");
        }
    }
}
