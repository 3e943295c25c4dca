//! The live protocol over ROS 2. `tests/ros2/run.sh` installs the other DDS implementation
//! that some of it is tested against.
#![cfg(all(unix, feature = "ros2"))]

#[path = "../common/programs.rs"]
mod programs;

use pickline::live::transport::ros2::messages::{Time, all};
use programs::Program;
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
    Path::new(env!("CARGO_MANIFEST_DIR")).join("ros2/pickline_interfaces")
}

/// A domain that no test beside this one uses.
fn domain(test: u32) -> u32 {
    1 + (std::process::id() + 17 * test) % 100
}

fn line(folder: &Path, items: u32) -> String {
    let robot = |name: &str, x: f64| {
        format!(
            "[[robot]]\nname = \"{name}\"\nbase = [{x}, 0.6]\nbin = [{x}, 0.7]\nreach = 1.0\n\
             speed = 4.0\ngrasp_time = 0.1\nrelease_time = 0.1\n"
        )
    };
    let belt = "[belt]\nspeed = 0.4\nlength = 4.0\nwidth = 1.0\n";
    let station = folder.join("station.toml");
    fs::write(
        &station,
        format!("{belt}{}{}", robot("r1", 1.2), robot("r2", 2.8)),
    )
    .unwrap();
    let mut csv = String::from("id,x,y\n");
    for i in 0..items {
        csv += &format!(
            "i{i},{},{}\n",
            -0.12 * f64::from(i),
            0.1 * f64::from(i % 5) - 0.2
        );
    }
    fs::write(folder.join("pattern.csv"), csv).unwrap();
    format!("--station {}", station.display())
}

#[test]
fn the_definitions_are_those_of_the_interface_package() {
    let mut checked = 0;
    for message in all() {
        if message.package != "pickline_interfaces" {
            continue;
        }
        let file = package().join(format!("msg/{}.msg", message.name));
        let text = fs::read_to_string(&file).unwrap();
        let lines = text
            .lines()
            .map(|line| line.split('#').next().unwrap().trim());
        let fields = lines.filter(|line| !line.is_empty() && !line.contains('='));
        let fields = fields.map(|line| {
            let (kind, name) = line.split_once(' ').unwrap();
            let local = kind.starts_with(char::is_uppercase);
            let package = if local { "pickline_interfaces/" } else { "" };
            (format!("{package}{kind}"), name.trim())
        });
        assert_eq!(
            fields.collect::<Vec<_>>(),
            message.fields,
            "{}",
            file.display()
        );
        checked += 1;
    }
    let files: Vec<_> = fs::read_dir(package().join("msg")).unwrap().collect();
    assert_eq!(files.len(), checked);
    let build = fs::read_to_string(package().join("CMakeLists.txt")).unwrap();
    for file in files {
        let name = file.unwrap().file_name().into_string().unwrap();
        assert!(
            build.contains(&format!("\"msg/{name}\"")),
            "CMakeLists.txt lacks {name}"
        );
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
    let Some(python) = std::env::var_os("PICKLINE_ROS2_PYTHON") else {
        panic!("run tests/ros2/run.sh, which installs Cyclone DDS and sets PICKLINE_ROS2_PYTHON");
    };
    let folder = tempfile::tempdir().unwrap();
    let domain = domain(test).to_string();
    let line = line(folder.path(), 0);
    let run = format!("run --ros2 --ros2-namespace line1 --ack-timeout 0.3 {arguments} {line}");
    let mut node = Program::pickline(&run, &[("ROS_DOMAIN_ID", &domain)]);
    let mut command = Command::new(python);
    command
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros2/peer.py"))
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
        remarks.contains("frame_id `camera`; expected `belt`"),
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
fn wrong_usage_is_refused() {
    for (arguments, environment, word) in [
        ("--ros2 --clock messages", &[][..], "--clock messages"),
        ("--ros2 --ros2-domain 233", &[], "--ros2-domain"),
        ("--ros2", &[("ROS_DOMAIN_ID", "x")][..], "ROS_DOMAIN_ID"),
        ("--ros2 --ros2-namespace a-b", &[], "--ros2-namespace"),
        ("--ros2 --ros2-network nowhere", &[], "--ros2-network"),
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
