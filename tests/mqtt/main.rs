//! The live protocol over MQTT, against mosquitto. `tests/mqtt/run.sh` installs it.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]
#![cfg(all(unix, feature = "mqtt"))]

mod access;
#[path = "../common/authority.rs"]
mod authority;
mod broker;
mod items;
mod outages;
#[path = "../common/programs.rs"]
mod programs;
#[path = "../common/quick_line.rs"]
mod quick_line;
mod refusals;
#[path = "../common/trouble.rs"]
mod trouble;

use broker::Broker;
use pickline_live::protocol::{Incoming, Outgoing, Status, Verdict, decode, decode_outgoing};
use std::collections::BTreeMap;

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
    quick_line::write(&broker.path(""), items);
    let station = broker.path("station.toml");
    format!("--station {} --mqtt {}", station.display(), broker.url())
}
