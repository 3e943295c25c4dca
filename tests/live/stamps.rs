//! Message time: what the stamps say, which of them are believed, and what comes of pauses.

use crate::support::line::Line;
use pickline_live::protocol::{Outgoing, Status};

#[test]
fn with_message_time_statuses_come_by_the_stamps() {
    let statuses = |ticks: &[f64]| {
        let mut line = Line::silent(1.5);
        line.say(r#""kind":"robot","stamp":100,"name":"r1","state":"idle""#);
        line.see(100.0, "a", 1.0, -0.2);
        for tick in ticks {
            line.say(&format!(r#""kind":"tick","stamp":{tick}"#));
        }
        let output = line.0.take_output().into_iter();
        let statuses = output.filter_map(|message| match message {
            Outgoing::Status(status) => Some(*status),
            _ => None,
        });
        statuses.collect::<Vec<Status>>()
    };
    let told = statuses(&[101.0, 101.5, 107.0]);
    let stamps: Vec<f64> = told.iter().map(|status| status.stamp).collect();
    assert_eq!(stamps, [101.5, 103.0, 104.5, 106.0]);
    assert!(
        told.iter()
            .all(|status| !status.last && status.claimed == 1 && status.queued == 0)
    );
    // However time comes there.
    assert_eq!(statuses(&[107.0]), told);
}

/// Wherever it comes, and whatever it says: the line does what it does without it.
#[test]
fn one_wild_stamp_does_not_move_the_clock() {
    let now = 1.7e9;
    let play = |wild: Option<(usize, f64)>| {
        let mut line = Line::silent(0.0);
        let mut stream = vec![
            format!(r#""kind":"robot","stamp":{now},"name":"r1","state":"idle""#),
            format!(r#""kind":"detection","stamp":{now},"id":"a","x":1,"y":-0.2"#),
            format!(r#""kind":"tick","stamp":{now}"#),
            format!(r#""kind":"ack","stamp":{now},"task":1"#),
            format!(r#""kind":"tick","stamp":{}"#, now + 1.0),
        ];
        if let Some((place, stamp)) = wild {
            let wild = format!(r#""kind":"detection","stamp":{stamp},"id":"w","x":1,"y":0.2"#);
            stream.insert(place, wild);
        }
        for fields in &stream {
            // One of 1970 is refused at once, unless it is the first.
            let _ = line.0.handle(Line::message(fields));
        }
        line.0.stop();
        let said = line.0.take_output();
        (said, line.status())
    };
    let (expected, status) = play(None);
    assert!(matches!(&expected[..], [Outgoing::Task(task), ..] if task.start == now));
    assert_eq!((status.seen, status.rejected.len()), (1, 0));
    for stamp in [0.0, now - 61.0, now + 90.0, now + 3e7, 1e11] {
        for place in [0, 2, 3, 4, 5] {
            let is_near_the_first = place == 0 && (stamp - now).abs() < 3600.0;
            if is_near_the_first {
                continue;
            }
            let (said, status) = play(Some((place, stamp)));
            assert_eq!(said, expected, "{stamp} at {place}");
            assert_eq!((status.seen, status.rejected["stamp"]), (1, 1));
        }
    }
}

/// A stream in which nothing is said for long goes on with the first message after it.
#[test]
fn a_pause_of_any_length_loses_nothing() {
    for pause in [50.0, 61.0, 4000.0, 86_400.0 * 30.0] {
        let mut line = Line::silent(1000.0);
        line.say(r#""kind":"robot","stamp":5,"name":"r1","state":"idle""#);
        line.say(r#""kind":"belt","stamp":5,"speed":0.05"#);
        let later = 5.0 + pause;
        line.see(later, "a", 1.0, -0.2);
        line.see(later, "b", 0.9, -0.2);
        let said = line.0.take_output().into_iter();
        let stamps = said.filter_map(|message| match message {
            Outgoing::Status(status) => Some(status.stamp),
            _ => None,
        });
        let stamps: Vec<f64> = stamps.collect();
        // Of what is longer than an hour the statuses of the last one.
        assert!(
            stamps.len() <= 4 && stamps.iter().all(|at| *at > later - 3600.0),
            "{stamps:?}"
        );
        assert_eq!(stamps.is_empty(), pause < 1000.0);
        let task = line.task(later);
        assert_eq!((task.item.as_str(), task.start), ("a", later));
        let status = line.status();
        assert_eq!((status.seen, status.rejected.len()), (2, 0));
        let leaps = status.noted.get("leap").copied().unwrap_or(0);
        assert_eq!(leaps, u64::from(pause > 60.0));
    }
    // Ticks wait for their answers: up to an hour they need nothing more.
    let mut line = Line::silent(0.0);
    for stamp in [7.0, 3600.0] {
        line.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        let said = line.0.take_output();
        assert!(
            matches!(&said[..], [Outgoing::Due(due)] if due.stamp == stamp && due.next.is_none())
        );
    }
    line.say(r#""kind":"tick","stamp":9000"#);
    assert_eq!(line.0.take_output(), vec![]);
    line.say(r#""kind":"tick","stamp":9000"#);
    assert_eq!(line.0.take_output().len(), 2);
}

/// The only message of a stream counts, the last after a pause does not.
#[test]
fn what_nothing_follows() {
    let mut line = Line::silent(0.0);
    line.see(5.0, "a", 1.0, -0.2);
    assert_eq!(line.status().seen, 0);
    line.0.finish();
    assert_eq!((line.status().seen, line.status().stamp), (1, 5.0));
    line.see(100.0, "b", 1.0, -0.2);
    line.0.finish();
    let dropped = line.0.take_dropped().unwrap();
    assert!(
        dropped.message.contains("stamp = 100, but the time is 5"),
        "{dropped:?}"
    );
    let status = line.status();
    assert_eq!((status.seen, status.rejected["stamp"]), (1, 1));
}

/// A status shows things as they are then: what is due at the same time is done before.
#[test]
fn a_status_counts_what_is_due_at_its_stamp() {
    for (free, claimed) in [(101.499, 1), (101.5, 1), (101.501, 0)] {
        let mut line = Line::silent(1.5);
        line.say(&format!(
            r#""kind":"robot","stamp":100,"name":"r1","state":"idle","available_at":{free}"#
        ));
        line.see(100.0, "a", 1.0, -0.2);
        line.say(r#""kind":"tick","stamp":102"#);
        let statuses = line.0.take_output().into_iter();
        let claims = statuses.filter_map(|message| match message {
            Outgoing::Status(status) => Some(status.claimed),
            _ => None,
        });
        assert_eq!(claims.collect::<Vec<u64>>(), [claimed], "{free}");
    }
}

/// With message time it does not matter when a message came.
#[test]
fn with_message_time_nothing_is_mapped() {
    let mut line = Line::silent(0.0);
    for (stamp, received) in [(5.0, 9e8), (6.0, 1.0), (7.0, 1e10)] {
        let message = Line::message(&format!(r#""kind":"belt","stamp":{stamp},"speed":0.05"#));
        line.0.hear(message, received).unwrap();
    }
    line.say(r#""kind":"tick","stamp":7"#);
    assert_eq!(line.0.now(), 2.0);
    assert_eq!(line.0.status(false, 0).noted.len(), 0);
}

#[test]
fn clocks_have_their_names() {
    use pickline_live::ClockKind;
    for (kind, name) in [
        (ClockKind::System, "system"),
        (ClockKind::Messages, "messages"),
    ] {
        assert_eq!((kind.name(), ClockKind::named(name)), (name, Some(kind)));
    }
    assert_eq!(ClockKind::named("wall"), None);
}
