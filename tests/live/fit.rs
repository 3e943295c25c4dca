//! From a recording of a line whose arms move otherwise than its station says, to how they do.

use crate::programs::feed;
use crate::recording::said_to_a_node;
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::grid;
use pickline::station::{Overrides, Robot, Station, built_in, parse, to_toml};
use pickline_live::emulator::{Emulator, InjectedFaults};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const SPEED: f64 = 5.0;
const ACCELERATION: f64 = 40.0;
const LIFT: f64 = 0.04;
const GRASP: f64 = 0.07;
const RELEASE: f64 = 0.05;

/// What the program prints, called in `folder` with `input`.
fn printed(folder: &Path, line: &str, input: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(line.split(' ')).current_dir(folder);
    let (output, _) = feed(&mut command, input.as_bytes());
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{line}: {told}");
    String::from_utf8(output.stdout).unwrap()
}

/// How the arms really move.
fn truth() -> Arm {
    Arm {
        law: TravelLaw::Trapezoid {
            speed: SPEED,
            acceleration: ACCELERATION,
            deceleration: ACCELERATION,
        },
        lift: LIFT,
    }
}

/// The same station with arms that are slower than it says.
fn as_built(planned: &Station) -> Station {
    let robots = planned.robots().iter().map(|robot| {
        let arm = truth();
        Robot {
            arm,
            ..robot.clone()
        }
        .with_dwell(GRASP, RELEASE)
    });
    Station::new(*planned.belt(), robots.collect()).unwrap()
}

#[test]
fn a_recording_tells_how_the_arms_really_move() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let planned = built_in("delta").unwrap().station(None).unwrap();
    let text = to_toml(&planned);
    std::fs::write(path.join("planned.toml"), &text).unwrap();
    std::fs::write(
        path.join("other.toml"),
        text.replace("name = \"r", "name = \"x"),
    )
    .unwrap();
    let pattern = grid(planned.belt().width, 0.1, 1000).unwrap();
    let faults = InjectedFaults::default()
        .with_grasp_failures(0.1)
        .with_time_noise(0.002)
        .with_seed(4);
    let emulator = Emulator::new(planned.clone(), pattern, faults).unwrap();
    let emulator = emulator.with_true_station(&as_built(&planned)).unwrap();
    let said = said_to_a_node(emulator, planned, "SPT,SPT,SPT");
    let run =
        "run -q --clock messages --station planned.toml --strategy SPT,SPT,SPT --record r.mcap";
    printed(path, run, &said);
    let fit = "station fit r.mcap --resamples 200 --format json --out fitted.toml";
    let report: Value = serde_json::from_str(&printed(path, fit, "")).unwrap();
    // A station with other robots has none of these moves.
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["station", "fit", "r.mcap", "--station", "other.toml"])
        .current_dir(path)
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    let words = "r.mcap: its tasks: they are of `r1`, `r2` and `r3`, but the station has `x1`, `x2` and `x3`";
    assert!(!output.status.success() && told.contains(words), "{told}");
    let robots = report["robots"].as_array().unwrap();
    assert_eq!(robots.len(), 3);
    let (mut told, mut inside) = (0, 0);
    for robot in robots {
        assert_eq!(robot["law"], "trapezoid", "{robot}");
        assert!(robot["moves"].as_u64().unwrap() > 60, "{}", robot["moves"]);
        // Errors are those of the noise of two movements: 0.67 and 1.96 times their deviation.
        let error = |key: &str| robot["error"][key].as_f64().unwrap();
        assert!(
            (0.0012..0.003).contains(&error("median_s")),
            "{}",
            robot["error"]
        );
        assert!(
            (0.004..0.008).contains(&error("p95_s")),
            "{}",
            robot["error"]
        );
        let parameters = robot["parameters"].as_array().unwrap();
        for (name, truth) in [
            ("speed", SPEED),
            ("acceleration", ACCELERATION),
            ("lift", LIFT),
            ("grasp_time", GRASP),
            ("grasp_time + release_time", GRASP + RELEASE),
        ] {
            // A robot that failed at few items has no grasp time of its own.
            let mut named = parameters.iter().filter(|p| p["name"] == name);
            let interval = named.next().map_or(&Value::Null, |p| &p["interval"]);
            // What few moves do not determine has none.
            let Some(low) = interval["low"].as_f64() else {
                continue;
            };
            told += 1;
            let high = interval["high"].as_f64().unwrap_or(f64::INFINITY);
            inside += usize::from((low..=high).contains(&truth));
        }
    }
    // Of at most fifteen 95 % intervals.
    assert!(
        told >= 10 && inside + 2 >= told,
        "{inside} of {told}: {report}"
    );
    let text = std::fs::read_to_string(path.join("fitted.toml")).unwrap();
    let fitted = parse(&text, "fitted", Overrides::default()).unwrap();
    for robot in fitted.robots() {
        // Without the start of the grasp only whole picks are known, whatever the shares in them.
        let dwell = robot.grasp_time + robot.bins[0].release_time - GRASP - RELEASE;
        for way in [0.3, 0.5, 0.7] {
            let off = 2.0 * (robot.arm.time(way) - truth().time(way)) + dwell;
            assert!(off.abs() < 0.006, "{}, {way}: {off}", robot.name);
        }
    }
}

/// A true station differs from the planned one in how its arms move, and in nothing else.
#[test]
fn a_true_station_is_the_planned_one() {
    let planned = built_in("delta").unwrap().station(None).unwrap();
    let refused = |real: &Station| {
        let pattern = grid(planned.belt().width, 0.2, 10).unwrap();
        let emulator = Emulator::new(planned.clone(), pattern, InjectedFaults::default()).unwrap();
        let refused = emulator
            .with_true_station(real)
            .err()
            .map(|e| e.to_string());
        refused.inspect(|text| assert!(text.contains("'true_station'"), "{text}"))
    };
    assert_eq!(refused(&as_built(&planned)), None);
    let fewer = Station::new(*planned.belt(), planned.robots()[..2].to_vec()).unwrap();
    assert!(refused(&fewer).unwrap().contains("other names"));
    let slower = planned.with_belt_speed(0.5 * planned.belt().speed).unwrap();
    assert!(refused(&slower).unwrap().contains("its belt is not"));
    let mut robots = planned.robots().to_vec();
    robots[1].reach *= 0.9;
    let short = Station::new(*planned.belt(), robots).unwrap();
    assert!(refused(&short).unwrap().contains("another reach"));
}
