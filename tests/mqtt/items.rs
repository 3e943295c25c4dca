//! A thousand items over a broker: the simulator's picks, and everything that goes wrong.

use super::{last_status, seen};
use crate::broker::Broker;
use crate::programs::Program;
use crate::trouble::TROUBLE;

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
