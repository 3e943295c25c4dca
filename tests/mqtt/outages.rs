//! Brokers that die, stall or come late, and a node that dies.

use super::{in_the_bins, last_status, quick_line, seen, tasks};
use crate::broker::Broker;
use crate::programs::{self, Program};
use pickline_live::protocol::Verdict;
use std::collections::BTreeSet;
use std::time::Duration;

#[test]
fn a_killed_broker_loses_and_duplicates_nothing() {
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
            node.remarks.wait_for("retrying");
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
    // Time in which the belt goes on by the clock.
    programs::let_pass(Duration::from_secs(6));
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
fn the_last_will_reports_that_the_node_has_died() {
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
fn a_broker_may_come_later() {
    let mut broker = Broker::place("allow_anonymous true\n");
    let line = format!("--clock messages --mqtt {}", broker.url());
    let mut node = Program::pickline(&format!("run {line}"), &[]);
    let mut station = Program::pickline(&format!("emulate {line}"), &[]);
    node.remarks.wait_for("refused (os error");
    station.remarks.wait_for("retrying");
    broker.start();
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(remarks.contains("44 of 50 picked"), "{remarks}");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert_eq!(remarks.matches("retrying").count(), 1, "{remarks}");
}
