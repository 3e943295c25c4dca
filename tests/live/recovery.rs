//! The state that outlives the node, without processes: what is told of it is all of it,
//! and a node that takes it up keeps every promise.

use crate::trouble::all_troubles;
use pickline::pattern::{poisson_disk, random_stream};
use pickline::station::{Station, built_in};
use pickline::strategies::read_alone;
use pickline_live::emulator::Emulator;
use pickline_live::journal::{OpenedJournal, Owner};
use pickline_live::protocol::{Incoming, Outgoing, Task, decode};
use pickline_live::{ClockKind, Config, Controller, LineState, StateChange};
use rand::RngExt as _;
use std::path::Path;

fn station() -> Station {
    built_in("paper").unwrap().station(Some(2)).unwrap()
}

fn config() -> Config {
    Config::default().with_clock(ClockKind::Messages)
}

fn new(station: &Station) -> Controller {
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    Controller::new(station.clone(), strategy, config()).unwrap()
}

fn restore(station: &Station, state: LineState) -> Controller {
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    Controller::restore(station.clone(), strategy, config(), state, None).unwrap()
}

/// As it is after it was written and read.
fn through_text(change: &StateChange) -> StateChange {
    serde_json::from_str(&serde_json::to_string(change).unwrap()).unwrap()
}

fn state_of(controller: &mut Controller) -> LineState {
    let mut state = LineState::default();
    state.apply(controller.whole());
    state
}

/// Runs a line on which everything goes wrong; after every message the state that the
/// changes make is held to the whole, and with the odds of one in `odds` the controller
/// is killed: what it had to say since the last look is lost.
fn run(odds: u32, seed: u64) -> (Emulator, Controller, usize) {
    let station = station();
    let items = 400;
    let pattern = poisson_disk(
        station.belt().width,
        0.12,
        items,
        &mut random_stream(seed, 0),
    );
    let trouble = all_troubles(seed);
    let mut emulator = Emulator::new(station.clone(), pattern.unwrap(), trouble).unwrap();
    let mut controller = new(&station);
    let mut state = state_of(&mut controller);
    let mut luck = random_stream(seed, 1);
    let (mut due, mut kills) = (None, 0);
    loop {
        let messages = emulator.round(due);
        if messages.is_empty() {
            return (emulator, controller, kills);
        }
        for message in messages {
            controller.handle(message).unwrap();
            if let Some(change) = controller.change(true) {
                state.apply(through_text(&change));
            }
            // Asking for the whole starts over what is told; a clone of the state stays.
            assert!(luck.random_range(0..50) > 0 || state == state_of(&mut controller));
        }
        due = None;
        if odds > 0 && luck.random_range(0..odds) == 0 {
            kills += 1;
            controller = restore(&station, state);
            controller.send_again();
            state = state_of(&mut controller);
        }
        for message in controller.take_output() {
            match message {
                Outgoing::Due(message) => due = message.next,
                other => emulator.receive(other),
            }
        }
    }
}

#[test]
fn the_changes_make_the_state() {
    let (_, mut controller, _) = run(0, 3);
    let mut status = controller.status(true, 0);
    assert_eq!(status.seen, 400);
    // Who speaks is heard again.
    status.sources.clear();
    // Taken up again it is the same, but for what a restart does not know.
    let state = state_of(&mut controller);
    let mut again = restore(&station(), state);
    assert!(again.awaits_belt() && again.take_output().is_empty());
    assert_eq!(again.status(true, 0), status);
}

#[test]
fn killed_at_random_it_keeps_every_promise() {
    let mut kills = 0;
    for seed in 1..=4 {
        let (emulator, controller, killed) = run(20, seed);
        kills += killed;
        assert!(
            emulator.broken_promises().is_empty(),
            "{:?}",
            emulator.broken_promises()
        );
        let status = controller.status(true, 0);
        assert_eq!(status.seen, 400);
        assert_eq!(status.picked + status.missed.total(), 400, "{status:?}");
        let in_bins = emulator.picked().len() as u64;
        let doubtful = status.missed.no_result;
        assert!((status.picked..=status.picked + doubtful).contains(&in_bins));
        assert!(in_bins > 150, "{status:?}");
    }
    assert!(kills > 200, "{kills}");
}

fn say(controller: &mut Controller, fields: &str) -> Vec<Outgoing> {
    let message: Incoming = decode(format!("{{{fields}}}").as_bytes()).unwrap();
    controller.handle(message).unwrap();
    controller.take_output()
}

fn tasks(said: Vec<Outgoing>) -> Vec<Task> {
    let tasks = said.into_iter().filter_map(|message| match message {
        Outgoing::Task(task) => Some(task),
        _ => None,
    });
    tasks.collect()
}

#[test]
fn a_belt_that_stopped_meanwhile_is_noticed() {
    let station = station();
    let mut line = new(&station);
    say(
        &mut line,
        r#""kind":"belt","stamp":0,"speed":0.05,"position":7"#,
    );
    say(
        &mut line,
        r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#,
    );
    say(
        &mut line,
        r#""kind":"detection","stamp":0,"id":"a","x":1,"y":-0.2"#,
    );
    say(
        &mut line,
        r#""kind":"detection","stamp":0,"id":"b","x":0.9,"y":-0.2"#,
    );
    let given = tasks(say(&mut line, r#""kind":"tick","stamp":0"#));
    assert_eq!(given.len(), 1);
    let mut line = restore(&station, state_of(&mut line));
    // A minute later both would be far past the end of what the robot reaches.
    let said = say(&mut line, r#""kind":"tick","stamp":60"#);
    assert!(tasks(said).is_empty());
    assert_eq!(line.status(false, 0).open_tasks, [given[0].id]);
    let moved = r#""kind":"belt","stamp":60,"speed":0.05,"position":7.01"#;
    let again = tasks(say(&mut line, moved));
    assert_eq!((again[0].id, &again[0].item), (given[0].id, &given[0].item));
    let x = 1.01 + 0.05 * (again[0].meet_at - 60.0);
    assert!((again[0].meet.x - x).abs() < 1e-9, "{again:?}");
    let status = line.status(false, 0);
    assert_eq!((status.on_belt, status.claimed), (1, 1), "{status:?}");
}

#[test]
fn open_tasks_are_sent_again() {
    let station = station();
    let mut line = new(&station);
    say(
        &mut line,
        r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#,
    );
    say(
        &mut line,
        r#""kind":"detection","stamp":0,"id":"a","x":1,"y":-0.2"#,
    );
    let task = tasks(say(&mut line, r#""kind":"tick","stamp":0"#)).remove(0);
    let unheard = state_of(&mut line);
    say(
        &mut line,
        &format!(r#""kind":"ack","stamp":0.1,"task":{}"#, task.id),
    );
    let heard = state_of(&mut line);
    // Acknowledged it stands as it was; unheard, as things are now.
    let mut line = restore(&station, heard);
    line.send_again();
    assert_eq!(tasks(line.take_output()), std::slice::from_ref(&task));
    let mut line = restore(&station, unheard.clone());
    line.send_again();
    assert!(line.take_output().is_empty());
    let again = tasks(say(&mut line, r#""kind":"tick","stamp":0.5"#)).remove(0);
    assert_eq!((again.id, again.revision), (task.id, 1));
    // Too late for it, the robot is told, also once more, and the item stays claimed.
    let mut line = restore(&station, unheard);
    let late = format!(r#""kind":"tick","stamp":{}"#, task.latest_start + 1.0);
    let cancels = |said: &[Outgoing]| {
        let cancels = said.iter();
        cancels
            .filter(|message| matches!(message, Outgoing::Cancel(c) if c.task == task.id))
            .count()
    };
    let said = say(&mut line, &late);
    assert_eq!(cancels(&said), 1, "{said:?}");
    let mut line = restore(&station, state_of(&mut line));
    line.send_again();
    let said = line.take_output();
    assert_eq!((cancels(&said), said.len()), (1, 1), "{said:?}");
    assert_eq!(line.status(false, 0).claimed, 1);
    let done = format!(
        r#""kind":"result","stamp":{},"task":{},"result":"PICKED""#,
        task.latest_start + 1.0,
        task.id
    );
    say(&mut line, &done);
    assert_eq!(line.status(false, 0).picked, 1);
}

fn owner(station: &str, clock: ClockKind) -> Owner {
    Owner::new(station, clock, "test")
}

/// A journal of some hundred records, started over on the way if it was asked to be.
fn write_journal(path: &Path, items: u32) -> LineState {
    let station = station();
    let mut line = new(&station);
    let found = OpenedJournal::open(path, &owner("a", ClockKind::Messages)).unwrap();
    assert!(found.reading.is_none());
    let mut journal = found.begin(&line.whole(), false).unwrap();
    let mut state = state_of(&mut line);
    say(&mut line, r#""kind":"belt","stamp":0,"speed":0.4"#);
    for i in 0..items {
        let stamp = 0.02 * f64::from(i);
        say(
            &mut line,
            &format!(r#""kind":"detection","stamp":{stamp},"id":"{i}","x":0,"y":0.1"#),
        );
        say(&mut line, &format!(r#""kind":"tick","stamp":{stamp}"#));
        let change = line.change(true).unwrap();
        if journal.append(&change).unwrap() {
            journal.compact(&line.whole()).unwrap();
        }
        state.apply(change);
    }
    state
}

#[test]
fn a_journal_stays_small_and_what_is_damaged_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("j");
    let state = write_journal(&path, 30_000);
    let mine = owner("a", ClockKind::Messages);
    let open = |bytes: &[u8], owner: &Owner| {
        let copy = folder.path().join("copy");
        std::fs::write(&copy, bytes).unwrap();
        OpenedJournal::open(&copy, owner).map(|found| found.reading.unwrap())
    };
    let bytes = std::fs::read(&path).unwrap();
    // 600 items are known at a time; all 30,000 are 7 MB.
    assert!(bytes.len() < 2_500_000, "{}", bytes.len());
    let whole = open(&bytes, &mine).unwrap();
    assert_eq!((whole.torn, &whole.state), (0, &state));
    // Torn anywhere within the last record, it is left out.
    let last = bytes[..bytes.len() - 1].iter().rposition(|b| *b == b'\n');
    let last = last.unwrap() + 1;
    for end in [last + 1, last + 30, bytes.len() - 1] {
        let reading = open(&bytes[..end], &mine).unwrap();
        assert_eq!(reading.torn, end - last);
        assert_eq!(reading.records, whole.records - 1);
    }
    assert_eq!(open(&bytes[..last], &mine).unwrap().torn, 0);
    let mut holes = bytes.clone();
    holes[last + 20..].fill(0);
    assert_eq!(open(&holes, &mine).unwrap().torn, bytes.len() - last);
    // A byte that is another one, a line that is gone, a file that is cut off.
    let first = bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
    let second = first + bytes[first..].iter().position(|b| *b == b'\n').unwrap() + 1;
    let third = second + bytes[second..].iter().position(|b| *b == b'\n').unwrap() + 1;
    let damaged = |change: &dyn Fn(&mut Vec<u8>), word: &str| {
        let mut bytes = bytes.clone();
        change(&mut bytes);
        let error = open(&bytes, &mine).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains("cure: "), "{error}");
    };
    damaged(&|b| b[5] ^= 1, "line 1: is not the beginning of a journal");
    damaged(&|b| b[first + 100] ^= 1, "line 2: is damaged");
    damaged(&|b| b[third - 1] ^= 1, "line 3: is damaged");
    damaged(&|b| b[last + 20] ^= 1, "is damaged");
    damaged(
        &|b| {
            b.drain(second..third);
        },
        "line 3: is damaged",
    );
    damaged(&|b| b.truncate(first), "line 2: is missing");
    damaged(&|b| b.truncate(first + 50), "line 2: is damaged");
    damaged(&|b| *b = b"[belt]\nspeed = 1\n".to_vec(), "line 1");
    for (other, word) in [
        (
            owner("b", ClockKind::Messages),
            "has station a, but this run has b",
        ),
        (owner("a", ClockKind::System), "has clock messages"),
    ] {
        let error = open(&bytes, &other).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains("cure: "), "{error}");
    }
}

#[test]
fn any_byte_that_changed_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("j");
    let state = write_journal(&path, 100);
    let bytes = std::fs::read(&path).unwrap();
    let mine = owner("a", ClockKind::Messages);
    let mut luck = random_stream(7, 7);
    for _ in 0..1000 {
        let at = luck.random_range(0..bytes.len());
        let mut changed = bytes.clone();
        changed[at] ^= 1 << luck.random_range(0..8);
        std::fs::write(&path, &changed).unwrap();
        match OpenedJournal::open(&path, &mine) {
            Err(error) => assert!(error.to_string().contains("line "), "{error}"),
            // The end of the last line, or a 0 in it: as if it had never been written.
            Ok(found) => {
                let reading = found.reading.unwrap();
                assert!(reading.torn > 0 && reading.state != state, "byte {at}");
            }
        }
    }
}
