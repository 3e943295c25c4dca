//! What a node that goes on where another was killed knows and does, and what it keeps to
//! itself until the belt is heard.

use crate::support::three::{Three, config, station, strategy};
use pickline::station::built_in;
use pickline_live::protocol::{Incoming, Outgoing, decode};
use pickline_live::{ClockKind, Config, Controller, LineState, StateChange};

fn whole(line: &mut Three) -> LineState {
    let mut state = LineState::default();
    state.apply(line.controller.whole());
    state
}

fn take_up(state: LineState, config: Config, stamp: Option<f64>) -> Three {
    let controller = Controller::restore(station(), strategy(), config, state, stamp).unwrap();
    Three::of(controller)
}

/// A line with one open task, one item that waits, and one picked.
fn busy_line(config: Config) -> Three {
    let mut line = Three::with(config, 0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    line.ack(100.0, 1);
    line.result(100.5, 1, "PICKED");
    line.see(100.6, "b", 1.0, 0.0);
    line.see(100.6, "c", 1.2, 0.0);
    line.tick(100.6);
    line.ack(100.6, 2);
    line.said.clear();
    line
}

#[test]
fn a_resumed_line_sends_nothing_and_keeps_its_counts() {
    let mut line = busy_line(config());
    let mut before = line.status();
    before.sources.clear();
    let mut again = take_up(whole(&mut line), config(), None);
    assert!(again.controller.take_output().is_empty());
    assert_eq!(again.status(), before);
    assert!(again.controller.awaits_belt());
    assert_eq!(again.controller.load(), (3, 1));
    // Nothing is decided, sent again, overdue or forgotten before the belt is heard.
    again.tick(109.0);
    assert_eq!(again.told(), [""; 0]);
    assert_eq!((again.status().claimed, again.status().on_belt), (1, 1));
    again.belt(109.0, 0.0);
    assert!(!again.controller.awaits_belt());
    // The result is waited for as long again.
    again.tick(113.99);
    assert_eq!(again.status().claimed, 1);
    again.tick(114.01);
    assert_eq!(again.status().missed.no_result, 1);
    again.robot(114.0, "delta-1", "idle");
    again.robot(114.02, "delta-1", "idle");
    again.tick(114.02);
    let told = again.told();
    assert!(
        told.len() == 1 && told[0].starts_with("task 3.0 delta-1 "),
        "{told:?}"
    );
}

/// A line that never heard its belt goes on at once: it moves as its file says.
#[test]
fn a_line_without_an_encoder_goes_on_at_once() {
    let mut line = Three::of(Controller::new(station(), strategy(), config()).unwrap());
    line.robot(100.0, "delta-1", "idle");
    line.tick(100.0);
    let mut again = take_up(whole(&mut line), config(), None);
    assert!(!again.controller.awaits_belt());
    again.see(100.1, "a", 1.0, 0.0);
    again.tick(100.1);
    assert_eq!(again.told(), ["task 1.0 delta-1 a"]);
}

/// A machine whose clock is behind the journal: up to 5 s it waits, beyond it does not start.
#[test]
fn a_journal_of_the_future_is_refused() {
    let start = 1.75e9;
    let mut line = Three::of(Controller::new(station(), strategy(), Config::default()).unwrap());
    line.controller.advance(start);
    line.robot(start, "delta-1", "idle");
    line.controller.advance(start + 100.0);
    let state = whole(&mut line);
    let take_up = |ahead: f64| {
        let stamp = Some(start + 100.0 - ahead);
        Controller::restore(
            station(),
            strategy(),
            Config::default(),
            state.clone(),
            stamp,
        )
    };
    for ahead in [-50.0, 0.0, 4.9] {
        let line = take_up(ahead).unwrap();
        // It never goes back.
        let expected = (100.0 - ahead).max(100.0);
        assert!(
            (line.now() - expected).abs() < 1e-6,
            "{ahead}: {}",
            line.now()
        );
    }
    let error = take_up(7.2).err().unwrap().to_string();
    assert!(
        error.contains("it is 7 s ahead of this machine's clock"),
        "{error}"
    );
    assert!(error.contains("correct the clock, or wait until it is past that time"));
    assert!(take_up(5.1).is_err());
}

#[test]
fn a_journal_of_another_station_is_refused() {
    let mut line = busy_line(config());
    line.robot(101.0, "arm-3", "idle");
    let state = whole(&mut line);
    let other = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = pickline::strategies::read_alone("SPT,FIFO", 2)
        .unwrap()
        .make();
    let error = Controller::restore(other, strategy, config(), state, None);
    let error = error.err().unwrap().to_string();
    assert!(error.contains("it refers to robot 3 of 2"), "{error}");
}

/// Statuses go on at the times that they have, none of them twice.
#[test]
fn statuses_go_on_at_their_times() {
    let every = config().with_status_every(1.5);
    let stamps = |line: &mut Three| {
        let said = std::mem::take(&mut line.said).into_iter();
        let stamps = said.filter_map(|message| match message {
            Outgoing::Status(status) => Some(status.stamp),
            _ => None,
        });
        stamps.collect::<Vec<f64>>()
    };
    let mut line = Three::with(every.clone(), 0.0);
    line.tick(103.0);
    // The one at 103 s is told before what comes after it.
    line.tick(103.2);
    assert_eq!(stamps(&mut line), [101.5, 103.0]);
    let mut again = take_up(whole(&mut line), every.clone(), None);
    again.belt(103.3, 0.0);
    again.tick(106.2);
    assert_eq!(stamps(&mut again), [104.5, 106.0]);
    // From a state at the time of one on, that one was told.
    let mut line = Three::with(every.clone(), 0.0);
    line.tick(103.0);
    line.said.clear();
    let mut again = take_up(whole(&mut line), every, None);
    again.tick(104.6);
    assert_eq!(stamps(&mut again), [104.5]);
}

/// Only what has changed is told: nothing where nothing has, each part where it has.
#[test]
fn a_change_names_what_has_changed() {
    let mut line = busy_line(config());
    line.controller.whole();
    assert!(line.controller.change(true).is_none());
    let parts = |change: &StateChange| {
        let json = serde_json::to_value(change).unwrap();
        let keys = json.as_object().unwrap().keys().cloned();
        let parts = keys.filter(|key| !["origin", "now"].contains(&key.as_str()));
        parts.collect::<Vec<String>>()
    };
    type Step = fn(&mut Three);
    let steps: [(Step, &[&str]); 10] = [
        (|line| line.robot(101.0, "arm-3", "busy"), &["robots"]),
        (
            |line| line.say(r#""kind":"pause","stamp":101,"robot":"arm-3""#),
            &["operation"],
        ),
        // A picture counts once it is whole.
        (|line| line.see(101.0, "d", 3.9, 0.0), &[]),
        (
            |line| line.controller.close_picture(),
            &["counters", "items"],
        ),
        (|line| line.belt(101.0, 0.0), &["motion"]),
        (
            |line| line.result(101.1, 2, "PICKED"),
            &["claims", "items", "past", "robots"],
        ),
        // A task is a claim, and its number is used up.
        (
            |line| line.tick(101.15),
            &["claims", "counters", "items", "robots"],
        ),
        (|line| line.ack(101.2, 1), &["counters"]),
        (|line| line.ack(101.3, 3), &["claims"]),
        (
            |line| line.robot(101.35, "delta-1", "fault"),
            &["claims", "items", "robots"],
        ),
    ];
    for (number, (step, expected)) in steps.into_iter().enumerate() {
        step(&mut line);
        let told = line.controller.change(false);
        let told = told.as_ref().map(parts).unwrap_or_default();
        assert_eq!(told, expected, "step {number}");
    }
    // The time alone is told with what was said, and not without.
    line.tick(101.36);
    assert!(line.controller.change(false).is_none());
    let change = line.controller.change(true).unwrap();
    assert_eq!(parts(&change), [""; 0]);
    assert!(line.controller.change(true).is_none());
}

/// What is asked of the drive is a part of it too.
#[test]
fn a_change_names_the_drive() {
    let config = config().with_may_stop_belt(true);
    let mut line = Three::with(config, 0.3);
    line.robot(100.0, "delta-1", "fault");
    line.controller.whole();
    line.tick(100.1);
    let change = line.controller.change(false).unwrap();
    let json = serde_json::to_value(change).unwrap();
    assert!(json.get("drive").is_some(), "{json}");
}

/// What comes before the belt is heard waits, over another restart too, and counts then.
#[test]
fn detections_wait_over_a_second_restart() {
    let mut line = busy_line(config());
    let mut again = take_up(whole(&mut line), config(), None);
    again.controller.whole();
    again.see(101.0, "d", 1.1, 0.1);
    assert_eq!(again.status().seen, 3);
    let change = again.controller.change(true).unwrap();
    let json = serde_json::to_value(&change).unwrap();
    assert_eq!(json["waiting"].as_array().unwrap().len(), 1);
    // One off the belt is refused at once; one past its end when it is known to be.
    let off = Three::message(r#""kind":"detection","stamp":101,"x":1.0,"y":0.5"#);
    again.controller.handle(off).unwrap_err();
    again.see(101.0, "e", 4.5, 0.0);
    let mut third = take_up(whole(&mut again), config(), None);
    third.belt(101.5, 0.0);
    let status = third.status();
    assert_eq!((status.seen, status.rejected["off_belt"]), (4, 2));
    third.controller.whole();
    assert!(third.controller.change(true).is_none());
}

/// There is room for so many items while they wait, as later.
#[test]
fn waiting_detections_fill_no_more_room_than_items() {
    let few = config().with_most_items(5);
    let mut line = busy_line(few.clone());
    let mut again = take_up(whole(&mut line), few, None);
    // Three are known.
    again.see(101.0, "d", 1.1, 0.1);
    again.see(101.0, "e", 1.1, -0.1);
    let text = r#"{"kind":"detection","stamp":101,"id":"f","x":1.3,"y":-0.1}"#;
    let message: Incoming = decode(text.as_bytes()).unwrap();
    let refused = again.controller.handle(message).unwrap_err();
    assert_eq!(refused.reason.name(), "too_many_items");
    assert_eq!(
        refused.message,
        "f exceeds the limit of 5 items; expected fewer at a time"
    );
    again.belt(101.5, 0.0);
    assert_eq!(again.status().seen, 5);
}

/// A robot that waits for work, and an item, before the belt is heard.
#[test]
fn no_task_is_given_before_the_belt_is_heard() {
    let mut line = busy_line(config());
    let mut again = take_up(whole(&mut line), config(), None);
    again.robot(101.0, "scara-2", "idle");
    again.tick(102.0);
    assert_eq!(again.told(), [""; 0]);
    again.belt(102.0, 0.0);
    again.tick(102.0);
    // Its item is where the belt has brought it, and the other task goes on.
    let told = again.told();
    assert!(told.contains(&"task 3.0 scara-2 c".to_owned()), "{told:?}");
}

/// However long the line has run, statuses have the times that they would have had.
#[test]
fn statuses_after_a_long_run_are_not_off() {
    let every = config().with_status_every(0.1);
    let mut line = Three::with(config(), 0.0);
    line.tick(1100.02);
    let mut again = take_up(whole(&mut line), every, None);
    again.said.clear();
    again.tick(1100.15);
    let stamps: Vec<f64> = again
        .said
        .iter()
        .filter(|message| message.kind() == "status")
        .map(Outgoing::stamp)
        .collect();
    assert_eq!(stamps, [1100.1]);
}

/// With message time the end of the stream decides what is due by then; time never passes by
/// the machine's clock. With the system clock it is the other way round.
#[test]
fn whose_time_it_is() {
    for clock in [ClockKind::Messages, ClockKind::System] {
        let by_messages = clock == ClockKind::Messages;
        let config = Config::default().with_clock(clock);
        let controller = Controller::new(station(), strategy(), config).unwrap();
        let mut line = Three::of(controller);
        let start = 1.75e9;
        if !by_messages {
            line.controller.advance(start);
        }
        line.robot(start, "delta-1", "idle");
        line.see(start, "a", 1.0, 0.0);
        line.said.extend(line.controller.take_output());
        assert_eq!(line.told(), [""; 0]);
        // What does not move this clock changes nothing: the picture is not whole either.
        if by_messages {
            line.controller.advance(start + 50.0);
        } else {
            line.controller.finish();
            assert!(line.controller.take_output().is_empty());
            // A picture a little ahead of the clock does not move it.
            line.see(start + 0.2, "b", -0.5, 0.0);
        }
        assert_eq!(line.controller.now(), 0.0);
        assert_eq!(line.status().seen, u64::from(!by_messages));
        if by_messages {
            line.controller.finish();
        } else {
            line.controller.advance(start);
        }
        line.said.extend(line.controller.take_output());
        assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
        // A tick is a matter of message time.
        line.said.clear();
        line.tick(start);
        assert_eq!(line.said.len(), usize::from(by_messages));
        // The next thing that is due is the ack.
        let next = line.controller.next_stamp().unwrap();
        assert!((next - start - 1.0).abs() < 1e-6, "{next}");
    }
    let mut idle = Three::new(0.0);
    assert_eq!(idle.controller.next_stamp(), None);
}

/// Pictures that wait for the belt are told apart when it is heard.
#[test]
fn pictures_that_wait_stay_pictures() {
    // Two boxes in one picture are two items, in two pictures the same.
    for (second, seen) in [(101.0, 5), (101.1, 4)] {
        let mut line = busy_line(config());
        let mut again = take_up(whole(&mut line), config(), None);
        for (stamp, x) in [(101.0, 1.4), (second, 1.408)] {
            again.say(&format!(
                r#""kind":"detection","stamp":{stamp},"x":{x},"y":0.1"#
            ));
        }
        again.belt(101.5, 0.0);
        assert_eq!(again.status().seen, seen, "{second}");
        assert_eq!(again.noted("doubled"), 0);
    }
}

/// No item is forgotten before the belt is heard: it may have stopped.
#[test]
fn no_item_is_forgotten_before_the_belt_is_heard() {
    let mut line = Three::with(config(), 0.3);
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let mut again = take_up(whole(&mut line), config(), None);
    again.tick(150.0);
    assert_eq!(again.controller.load(), (1, 0));
    again.belt(150.0, 0.3);
    again.tick(150.0);
    assert_eq!(again.controller.load(), (0, 0));
}

/// Without an encoder what was known goes on at once: windows are open, what nobody has
/// acknowledged is sent as things are now, and a cancel is repeated later.
#[test]
fn open_tasks_continue_at_once() {
    let controller = Controller::new(station(), strategy(), config()).unwrap();
    let mut line = Three::of(controller);
    for robot in ["delta-1", "scara-2"] {
        line.robot(100.0, robot, "idle");
    }
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    line.controller.hold(&[1]);
    line.see(100.0, "b", 1.5, 0.0);
    line.tick(100.1);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
    let mut again = take_up(whole(&mut line), config(), None);
    again.tick(100.2);
    assert_eq!(again.told(), ["task 1.1 delta-1 a", "task 2.0 scara-2 b"]);
}

/// A state is stamped by the machine's clock, which whoever goes on reads.
#[test]
fn a_state_is_stamped_by_the_machines_clock() {
    let mut line = Three::of(Controller::new(station(), strategy(), Config::default()).unwrap());
    line.controller.advance(1.75e9);
    line.controller.set_clock_ahead(100.0);
    let json = serde_json::to_value(line.controller.whole()).unwrap();
    assert_eq!(json["origin"], 1.75e9 + 100.0);
}

/// When the machine's clock is set open tasks are sent again with its stamps, and messages
/// are read by it.
#[test]
fn a_clock_that_is_set_moves_all_stamps() {
    let start = 1.75e9;
    let mut line = Three::of(Controller::new(station(), strategy(), Config::default()).unwrap());
    line.controller.advance(start);
    line.robot(start, "delta-1", "idle");
    line.see(start, "a", 1.0, 0.0);
    line.controller.advance(start);
    line.said.extend(line.controller.take_output());
    let first = line.task();
    line.controller.set_clock_ahead(0.5);
    line.said.extend(line.controller.take_output());
    let again = line.said().0.remove(0);
    assert_eq!((again.id, again.revision), (1, 1));
    assert!((again.start - first.start - 0.5).abs() < 1e-6);
    line.controller.set_clock_ahead(0.5);
    assert_eq!(line.noted("clock_step"), 1);
    line.controller.set_clock_ahead(100.12);
    let remarks = line.controller.take_remarks();
    let rest = "decisions use a steady clock, timestamps are mapped, and open tasks are sent again \
                with their new timestamps";
    for (remark, by) in remarks.iter().zip(["0.5", "99.62"]) {
        assert_eq!(
            remark,
            &format!("the machine's clock was set forward by {by} s: {rest}")
        );
    }
    assert_eq!(remarks.len(), 2);
    // 0.2 s later, by that clock.
    line.ack(start + 100.32, 1);
    line.said.extend(line.controller.take_output());
    assert_eq!(line.controller.view(0).claims[0].stage, "acknowledged");
}

/// What is told of tasks that are over, step by step, makes the whole: results, late ones,
/// items that are forgotten, and tasks that are.
#[test]
fn the_changes_of_past_tasks_make_the_whole() {
    let mut line = Three::with(config(), 0.3);
    line.robot(100.0, "delta-1", "idle");
    for (id, x) in [("a", 1.0), ("b", 0.8), ("c", 0.6)] {
        line.see(100.0, id, x, 0.0);
    }
    line.tick(100.0);
    let mut state = whole(&mut line);
    type Step = fn(&mut Three);
    let steps: [Step; 9] = [
        |line| line.ack(100.0, 1),
        |line| line.result(100.5, 1, "MISSED"),
        |line| line.tick(100.5),
        // The same task's late word, and the item's next one.
        |line| line.result(100.6, 1, "PICKED"),
        |line| line.tick(110.0),
        // Items are forgotten, and one was picked after all.
        |line| line.tick(115.0),
        |line| line.result(116.0, 2, "PICKED"),
        |line| line.tick(170.0),
        // Nobody will report on them any more.
        |line| line.tick(240.0),
    ];
    for (number, step) in steps.into_iter().enumerate() {
        step(&mut line);
        if let Some(change) = line.controller.change(true) {
            let text = serde_json::to_string(&change).unwrap();
            state.apply(serde_json::from_str(&text).unwrap());
        }
        assert_eq!(state, whole(&mut line), "step {number}");
    }
    let json = serde_json::to_value(line.controller.whole()).unwrap();
    assert!(
        json.get("past").is_none() && json.get("items").is_none(),
        "{json}"
    );
}
