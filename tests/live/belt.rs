//! The belt as it is measured: noise, stops, and an encoder that counts from another zero.

use crate::support::line::Line;
use crate::support::table::Table;
use crate::support::three;
use pickline::strategies::read_alone;
use pickline_live::protocol::Outgoing;
use pickline_live::{ClockKind, Config, Controller};

/// A belt of 0.3 m/s with one robot that reaches 0.6 m around (1, 0).
fn line() -> Line {
    let station = three::station_of(&["delta-1"]);
    let config = Config::default().with_clock(ClockKind::Messages);
    let strategy = read_alone("FIFO", 1).unwrap().make();
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
    line.say(r#""kind":"robot","stamp":1000,"name":"delta-1","state":"idle""#);
    line
}

fn belt(line: &mut Line, stamp: f64, speed: f64, position: Option<f64>) {
    let position = position.map_or(String::new(), |p| format!(r#","position":{p}"#));
    line.say(&format!(
        r#""kind":"belt","stamp":{stamp},"speed":{speed}{position}"#
    ));
}

/// Noise of standard deviation 1, always the same.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        let uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        std::iter::repeat_with(uniform).take(12).sum()
    }
}

/// What a robot that obeys makes of a line.
#[derive(Debug, Default)]
struct Robot {
    /// Tasks that it has, with the time of their result.
    open: Vec<(f64, u64)>,
    messages: usize,
    tasks: usize,
    cancels: usize,
    picked: usize,
    /// The last place where each task meets its item, and when.
    meets: std::collections::BTreeMap<u64, (String, f64, f64)>,
}

impl Robot {
    fn step(&mut self, line: &mut Line, stamp: f64) {
        let (due, open) = std::mem::take(&mut self.open)
            .into_iter()
            .partition::<Vec<_>, _>(|(at, _)| *at <= stamp);
        self.open = open;
        for (_, task) in due {
            line.result(stamp, task, "PICKED");
            self.picked += 1;
        }
        line.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        for message in line.0.take_output() {
            match message {
                Outgoing::Task(task) => {
                    self.messages += 1;
                    self.open.retain(|(_, id)| *id != task.id);
                    self.open.push((task.free_at, task.id));
                    self.tasks += usize::from(task.revision == 0);
                    line.ack(stamp, task.id);
                    let meet = (task.item, task.meet_at, task.meet.x);
                    self.meets.insert(task.id, meet);
                }
                Outgoing::Cancel(cancel) => {
                    self.cancels += 1;
                    self.open.retain(|(_, id)| *id != cancel.task);
                    line.result(stamp, cancel.task, "CANCELLED");
                }
                Outgoing::BeltRequest(_) | Outgoing::Status(_) | Outgoing::Due(_) => {}
            }
        }
    }
}

#[test]
fn noise_around_a_standing_belt_is_no_motion() {
    for sigma in [0.0, 1e-5, 1e-4, 1e-3] {
        for position in [Some(0.0), None] {
            let (mut line, mut robot, mut noise) = (line(), Robot::default(), noise());
            belt(&mut line, 1000.0, 0.0, position);
            for i in 0..10 {
                let x = 0.8 + 0.04 * f64::from(i);
                line.see(1000.0, &format!("i{i}"), x, -0.1);
            }
            for i in 0..1000 {
                let stamp = 1000.0 + 0.02 * f64::from(i);
                belt(&mut line, stamp, sigma * noise(), position);
                robot.step(&mut line, stamp);
            }
            let case = format!("{sigma} m/s, {position:?}");
            assert_eq!((robot.picked, robot.cancels), (10, 0), "{case}");
            assert_eq!(robot.messages, 10, "{case}");
        }
    }
}

/// Tasks of a belt that runs at `speed(time)` [m/s] and says so with noise.
fn drive(
    hz: f64,
    seconds: f64,
    sigma: f64,
    has_encoder: bool,
    speed: impl Fn(f64) -> f64,
) -> (Robot, f64) {
    let (mut line, mut robot, mut noise) = (line(), Robot::default(), noise());
    let (mut travel, mut worst) = (0.0, 0.0_f64);
    let mut places = std::collections::BTreeMap::new();
    for i in 0..(hz * seconds) as u32 {
        let time = f64::from(i) / hz;
        let stamp = 1000.0 + time;
        let said = speed(time) * (1.0 + sigma * noise());
        let position = travel + 1e-5 * noise();
        belt(&mut line, stamp, said, has_encoder.then_some(position));
        if i % (0.5 * hz) as u32 == 0 {
            line.see(stamp, &format!("i{i}"), 0.0, -0.1);
            places.insert(format!("i{i}"), -travel);
        }
        robot.step(&mut line, stamp);
        let before = speed(time - 1.0 / hz);
        robot.meets.retain(|_, (item, at, x)| {
            if *at > stamp {
                return true;
            }
            worst = worst.max((places[item.as_str()] + travel - before * (stamp - *at) - *x).abs());
            false
        });
        travel += speed(time) / hz;
    }
    (robot, worst)
}

/// With the table of docs/live.md, which `cargo test --test live belt::noise -- --nocapture`
/// prints.
#[test]
fn noise_of_the_speed_sends_no_task_again() {
    let mut table = Table::new(&[
        "readings [Hz]",
        "encoder",
        "tasks",
        "sent again",
        "cancels",
        "furthest off [mm]",
    ]);
    for hz in [20.0, 50.0, 500.0] {
        for has_encoder in [true, false] {
            let (robot, worst) = drive(hz, 300.0, 0.02, has_encoder, |_| 0.3);
            let case = format!("{hz} Hz, encoder {has_encoder}: {robot:?}");
            assert!(robot.tasks > 500 && robot.cancels == 0, "{case}");
            let again = robot.messages - robot.tasks;
            assert!(again < robot.tasks / 5, "{again} revisions, {case}");
            assert!(worst < 0.006, "{worst} m, {case}");
            table.row(&[
                hz.to_string(),
                if has_encoder { "yes" } else { "no" }.to_owned(),
                robot.tasks.to_string(),
                again.to_string(),
                robot.cancels.to_string(),
                format!("{:.1}", 1e3 * worst),
            ]);
        }
    }
    table.is_in_the_docs();
}

#[test]
fn ramps_and_stops_are_still_followed() {
    // From 0.3 to 0.1 m/s within half a second, a stop, and back.
    let speed = |t: f64| match t % 20.0 {
        t if t < 8.0 => 0.3,
        t if t < 8.5 => 0.3 - 0.4 * (t - 8.0),
        t if t < 14.0 => 0.1,
        t if t < 17.0 => 0.0,
        _ => 0.3,
    };
    for sigma in [0.0, 0.02] {
        for has_encoder in [true, false] {
            let (robot, worst) = drive(50.0, 60.0, sigma, has_encoder, speed);
            assert!(robot.picked > 50, "{robot:?}");
            // What meets its item just after the change cannot know of it.
            assert!(worst < 0.02, "{sigma}, {has_encoder}: {worst} m");
        }
    }
}

#[test]
fn a_late_picture_is_placed_by_the_travel_since_whatever_the_rate() {
    for hz in [20_u32, 1000] {
        let (mut line, mut noise) = (line(), noise());
        let (mut travel, rate) = (0.0, f64::from(hz));
        let mut then = 0.0;
        for i in 0..=8 * hz {
            let time = f64::from(i) / rate;
            let speed = if time < 4.0 { 0.3 } else { 0.0 };
            if i > 0 {
                travel += speed / rate;
            }
            if i == 3 * hz {
                then = travel;
            }
            let position = travel + 1e-5 * noise();
            belt(
                &mut line,
                1000.0 + time,
                speed * (1.0 + 1e-3 * noise()),
                Some(position),
            );
        }
        line.see(1003.0, "late", 0.5, -0.1);
        let task = line.task(1008.001);
        let truth = 0.5 + travel - then;
        assert!(
            (task.meet.x - truth).abs() < 1e-3,
            "{hz} Hz: {task:?}, {truth}"
        );
    }
}

#[test]
fn a_minute_of_travel_is_kept_at_a_thousand_readings_a_second() {
    let (mut line, mut noise) = (line(), noise());
    // Half a minute of driving 0.05 m/s, then a stop.
    let travel = |time: f64| 0.05 * time.min(30.0);
    for i in 0..=59_000 {
        let time = f64::from(i) / 1000.0;
        let speed = if time < 30.0 { 0.05 } else { 0.0 };
        belt(
            &mut line,
            1000.0 + time,
            speed,
            Some(travel(time) + 1e-5 * noise()),
        );
    }
    line.see(1001.0, "old", -0.7, -0.1);
    let task = line.task(1059.001);
    let truth = -0.7 + travel(59.0) - travel(1.0);
    assert!((task.meet.x - truth).abs() < 1e-3, "{task:?}, {truth}");
}

/// The range of an encoder that counts in a circle, how often it is read, and which reading
/// is lost.
#[test]
fn an_encoder_may_count_in_a_circle() {
    for (range, hz, lost) in [
        (6.5536, 10.0, Some(5)),
        (0.08, 10.0, None),
        (0.08, 5.0, None),
        (0.08, 50.0, Some(13)),
        (1.0, 20.0, None),
    ] {
        for scale in [1.0, 0.97] {
            let mut line = line();
            let (mut travel, mut robot) = (0.0, Robot::default());
            line.see(1000.0, "a", -0.4, -0.1);
            line.see(1000.0, "b", -0.2, -0.1);
            for i in 0..(3.0 * hz) as u32 {
                let stamp = 1000.0 + f64::from(i) / hz;
                let position = (range - 0.03 + travel) % range;
                if lost != Some(i) {
                    belt(&mut line, stamp, 0.3, Some(position));
                }
                robot.step(&mut line, stamp);
                travel += 0.3 * scale / hz;
            }
            let case = format!("{range} m, {hz} Hz, {scale}: {:?}", line.status().noted);
            assert_eq!(robot.tasks, 2, "{case}");
            for (item, at, x) in robot.meets.values() {
                let place = if item == "a" { -0.4 } else { -0.2 };
                let truth = place + 0.3 * scale * (at - 1000.0);
                // Until the difference is learned, what each reset hides of it is lost.
                let allowed = if scale == 1.0 { 1e-3 } else { 8e-3 };
                assert!((x - truth).abs() < allowed, "{item} {x} {truth}, {case}");
            }
            if range < 1.0 {
                assert!(line.status().noted["encoder_reset"] > 5, "{case}");
            }
        }
    }
}

#[test]
fn a_reset_during_an_unreported_stop_is_reported_as_uncertain() {
    let mut line = line();
    belt(&mut line, 1000.0, 0.3, Some(50.0));
    line.see(1000.0, "a", 0.2, -0.1);
    belt(&mut line, 1002.0, 0.0, Some(0.0));
    // It was somewhere between 0 and 0.6 m: the middle is off by half of that at most.
    let task = line.tick(1002.0).0.pop().unwrap();
    assert!((task.meet.x - 0.5).abs() < 0.11, "{task:?}");
    let remarks = line.0.take_remarks();
    assert!(
        remarks.len() == 1 && remarks[0].contains("may be off by 0.3 m"),
        "{remarks:?}"
    );
    assert_eq!(line.status().noted["encoder_reset"], 1);
}

#[test]
fn an_encoder_that_contradicts_the_speed_is_used_and_reported() {
    for (said, real) in [(0.3, 0.28), (0.3, 0.33), (0.3, 0.0), (0.0, 0.2), (0.1, 0.3)] {
        let (mut line, mut robot) = (line(), Robot::default());
        let hz = 10.0;
        for i in 0..60 {
            let time = f64::from(i) / hz;
            let stamp = 1000.0 + time;
            belt(&mut line, stamp, said, Some(7.0 + real * time));
            if i == 40 {
                line.see(stamp, "a", 0.6, -0.1);
            }
            robot.step(&mut line, stamp);
        }
        let case = format!("{said} and {real}");
        assert_eq!((robot.tasks, robot.cancels), (1, 0), "{case}: {robot:?}");
        assert!(robot.messages <= 2, "{case}: {robot:?}");
        for (_, at, x) in robot.meets.values() {
            let truth = 0.6 + real * (at - 1004.0);
            assert!((x - truth).abs() < 1e-3, "{case}: {x} {truth}");
        }
        let remarks = line.0.take_remarks();
        let told = format!("its encoder shows {real} m/s");
        assert!(
            remarks.len() == 1 && remarks[0].contains(&told),
            "{case}: {remarks:?}"
        );
    }
}

/// A drive says 0.3 m/s a hundred times a second, and with every `every`th of its messages, or
/// `after` [s] after it, an encoder is read that shows `real` [m/s].
fn slips(real: f64, every: u32, after: Option<f64>) {
    let case = format!("{real} m/s, every {every}, {after:?}");
    let (mut line, mut robot) = (line(), Robot::default());
    let seconds = if every > 100 { 30 } else { 12 };
    let mut seen = std::collections::BTreeMap::new();
    for i in 0..100 * seconds {
        let time = f64::from(i) / 100.0;
        let stamp = 1000.0 + time;
        let is_read = i % every == 0;
        let shown = |time: f64| Some(7.0 + real * time);
        match after {
            Some(after) => {
                belt(&mut line, stamp, 0.3, None);
                if is_read {
                    belt(&mut line, stamp + after, 0.3, shown(time + after));
                }
            }
            None => belt(&mut line, stamp, 0.3, shown(time).filter(|_| is_read)),
        }
        // Not at the moment of a reading.
        if i % 100 == 55 && i > 100 * (seconds / 2) && i < 100 * (seconds - 3) {
            line.see(stamp, &format!("i{i}"), 0.4, -0.1);
            seen.insert(format!("i{i}"), time);
        }
        robot.step(&mut line, stamp + 0.002);
    }
    assert!(robot.tasks > 2 && robot.cancels == 0, "{case}: {robot:?}");
    for (item, at, x) in robot.meets.values() {
        let truth = 0.4 + real * (at - 1000.0 - seen[item]);
        assert!((x - truth).abs() < 2e-3, "{case}: {item} {x} {truth}");
    }
    assert!(
        !line.status().noted.contains_key("encoder_reset"),
        "{case}: {:?}",
        line.status().noted
    );
    let remarks = line.0.take_remarks();
    if (real / 0.3 - 1.0).abs() < 0.0199 {
        assert!(remarks.is_empty(), "{case}: {remarks:?}");
        return;
    }
    let told = format!("the belt reports 0.3 m/s but its encoder shows {real} m/s");
    assert!(
        remarks.len() == 1 && remarks[0].contains(&told),
        "{case}: {remarks:?}"
    );
}

#[test]
fn an_encoder_beside_more_frequent_speeds_is_compared_with_its_own_last_reading() {
    for real in [0.3, 0.297, 0.294, 0.285, 0.27, 0.303, 0.306, 0.33] {
        for every in [1, 10, 500] {
            slips(real, every, None);
        }
    }
}

#[test]
fn an_encoder_may_be_another_source_than_the_drive() {
    for real in [0.3, 0.294, 0.27, 0.315] {
        for every in [1, 10, 500] {
            for after in [0.0, 1e-3] {
                slips(real, every, Some(after));
            }
        }
    }
}

#[test]
fn a_reset_between_speeds_without_a_position_is_still_found() {
    let mut line = line();
    line.see(1000.0, "a", -0.5, -0.1);
    for i in 0..400 {
        let time = f64::from(i) / 100.0;
        let zero = if time < 2.0 { 50.0 } else { 0.0 };
        let position = (i % 10 == 0).then_some(zero + 0.3 * time);
        belt(&mut line, 1000.0 + time, 0.3, position);
    }
    let task = line.tick(1004.0).0.pop().unwrap();
    let truth = -0.5 + 0.3 * (task.meet_at - 1000.0);
    assert!((task.meet.x - truth).abs() < 1e-3, "{task:?} {truth}");
    assert_eq!(line.status().noted["encoder_reset"], 1);
}

#[test]
fn an_encoder_that_counts_backwards_is_reported() {
    let mut line = line();
    for i in 0..40 {
        let time = f64::from(i) / 10.0;
        belt(&mut line, 1000.0 + time, 0.3, Some(9.0 - 0.3 * time));
    }
    let remarks = line.0.take_remarks();
    assert!(
        remarks.len() == 1 && remarks[0].contains("check its sign"),
        "{remarks:?}"
    );
    // Positions follow from the speed.
    line.see(1000.0, "a", -0.5, -0.1);
    let task = line.task(1004.0);
    let truth = -0.5 + 0.3 * (task.meet_at - 1000.0);
    assert!((task.meet.x - truth).abs() < 1e-3, "{task:?}");
}

/// What the station file says of the speed is no measurement: a picture from before the first
/// word of the belt is placed by that word.
#[test]
fn a_picture_before_the_first_belt_message_is_placed_by_it() {
    // With the first message of all, and after others.
    for first in [1000.0, 1002.0] {
        let mut line = line();
        belt(&mut line, first, 0.2, None);
        line.see(first - 0.5, "a", -0.5, -0.1);
        line.tick(first);
        let items = line.0.view(0).items;
        assert!((items[0].x - (-0.5 + 0.5 * 0.2)).abs() < 1e-9, "{items:?}");
    }
}
