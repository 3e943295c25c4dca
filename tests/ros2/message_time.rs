//! Both programs over ROS 2 in message time.

use super::domain;
use super::programs::{Program, wait_for};
use super::trouble::TROUBLE;
use serde_json::Value;
use std::path::Path;

/// Plays 1,000 items to the end; returns the pattern's file and the last remarks of station
/// and node.
fn play(
    folder: &Path,
    test: u32,
    (robots, radius): (u32, f64),
    trouble: &str,
    record: bool,
) -> [String; 3] {
    let file = folder.join("p.csv").display().to_string();
    let made = format!(
        "pattern generate poisson --radius {radius} --count 1000 --robots {robots} --output {file}"
    );
    assert_eq!(Program::pickline(&made, &[]).finish().0, Some(0));
    let domain = domain(test);
    let line = format!("--clock messages --robots {robots} --ros2 --ros2-domain {domain}");
    let record = match record {
        true => format!("--record {}", folder.join("r.mcap").display()),
        false => String::new(),
    };
    let mut node = Program::pickline(&format!("run {line} {record}"), &[]);
    let emulate = format!("emulate --pattern {file} {line} {trouble}");
    let mut station = Program::pickline(&emulate, &[]);
    // It ends with another code where two robots were after one item.
    let (code, bins) = station.finish();
    assert_eq!(code, Some(0), "{bins}");
    let (code, figures) = node.finish();
    assert_eq!(code, Some(0), "{figures}");
    [file, bins, figures]
}

fn lines(command: &str) -> Vec<String> {
    let mut program = Program::pickline(command, &[]);
    let (code, remarks) = program.finish();
    assert_eq!(code, Some(0), "{remarks}");
    program.said.all()
}

#[test]
fn the_picks_are_those_of_the_simulator() {
    // Where robots never rest, one pick decides when the next one is, and the nanoseconds to
    // which stamps are rounded grow; these lines rest now and then.
    for (test, robots, radius) in [(5, 2, 0.25), (6, 6, 0.12)] {
        let folder = tempfile::tempdir().unwrap();
        let [file, bins, figures] = play(folder.path(), test, (robots, radius), "", true);
        let simulate = format!("simulate -q --format json --pattern {file} --robots {robots}");
        let simulated: Value = serde_json::from_str(&lines(&simulate).concat()).unwrap();
        let picks = simulated["picks"].as_array().unwrap();
        let count = picks.len();
        for words in [
            format!("{count} of 1000 items in the bins"),
            format!("{count} of 1000 picked"),
        ] {
            assert!(bins.contains(&words), "{bins}");
        }
        assert!(
            figures.contains(&format!("{count} of 1000 items picked")),
            "{figures}"
        );
        // What went over the wire, as it was recorded.
        let replay = format!("run -q --replay {}", folder.path().join("r.mcap").display());
        let said = lines(&replay);
        let said = said.iter().map(|line| serde_json::from_str(line).unwrap());
        let tasks: Vec<Value> = said.filter(|line: &Value| line["kind"] == "task").collect();
        assert_eq!(tasks.len(), count);
        for (task, pick) in tasks.iter().zip(picks) {
            assert_eq!(pick["item"], task["item"]);
            // Stamps are whole nanoseconds there.
            for (simulated, said) in [("decide_s", "decided_at"), ("release_s", "free_at")] {
                let times = [&pick[simulated], &task[said]].map(|time| time.as_f64().unwrap());
                assert!((times[0] - times[1]).abs() < 1e-6, "{pick} {task}");
            }
        }
    }
}

#[test]
fn with_everything_going_wrong_every_item_is_accounted_for() {
    for (test, robots) in [(7, 2), (8, 6)] {
        let folder = tempfile::tempdir().unwrap();
        let [_, bins, figures] = play(folder.path(), test, (robots, 0.12), TROUBLE, false);
        // Picked and missed are all that were seen.
        let last = figures
            .lines()
            .find(|line| line.contains(" items picked, "));
        let numbers: Vec<u32> = last
            .unwrap_or_else(|| panic!("{figures}"))
            .split(|c: char| !c.is_ascii_digit())
            .filter_map(|number| number.parse().ok())
            .collect();
        let [picked, seen, missed, on_belt, claimed] = numbers[..5] else {
            panic!("{figures}");
        };
        assert_eq!((seen, on_belt, claimed), (1000, 0, 0), "{figures}");
        assert_eq!(picked + missed, seen, "{figures}");
        assert!(picked > 100, "{figures}");
        assert!(bins.contains("of 1000 items in the bins"), "{bins}");
    }
}

#[test]
fn a_node_that_goes_early_leaves_nobody_waiting() {
    let domain = domain(9);
    let line = format!("--clock messages --ros2 --ros2-domain {domain}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv").display().to_string();
    let made = format!("pattern generate poisson --radius 0.12 --count 20000 --output {file}");
    assert_eq!(Program::pickline(&made, &[]).finish().0, Some(0));
    let status = "--status-every 0";
    let journal = folder.path().join("journal");
    let keeps = format!("--journal {}", journal.display());
    let mut node = Program::pickline(&format!("run {line} {status} {keeps}"), &[]);
    let mut station = Program::pickline(&format!("emulate --pattern {file} {line}"), &[]);
    station.remarks.wait_for("ROS domain");
    wait_for("tasks", || {
        std::fs::read(&journal).is_ok_and(|text| text.len() > 10_000)
    });
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(
        remarks.contains("the node left before the end"),
        "{remarks}"
    );
}
