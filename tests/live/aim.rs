//! Items that are not where the camera says: what the results tell, and what cures it.

use crate::support::line::Line;
use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::protocol::{FoundPlace, Outgoing, Verdict};
use pickline_live::protocol::{Incoming, ResultMessage};
use pickline_live::{ClockKind, Config, Controller};

/// What comes of 40 items on a belt of 0.3 m/s, seen by a camera that stamps its pictures
/// `late` [s], when a robot reaches 20 mm around where it is sent: grasps that found nothing,
/// and the remarks.
fn play(late: f64, camera_delay_ms: f64, says_where: bool) -> (usize, usize, Vec<String>) {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let config = Config::default()
        .with_clock(ClockKind::Messages)
        .with_camera_delay(1e-3 * camera_delay_ms);
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
    let speed = 0.3;
    line.say(&format!(r#""kind":"belt","stamp":100,"speed":{speed}"#));
    for name in ["r1", "r2"] {
        line.say(&format!(
            r#""kind":"robot","stamp":100,"name":"{name}","state":"idle""#
        ));
    }
    let (mut missed, mut done) = (0, 0);
    // Where each item was at time 100, in truth.
    let mut truth = std::collections::BTreeMap::new();
    let mut open: Vec<(f64, u64, f64, f64, f64)> = Vec::new();
    for step in 0..4000 {
        let stamp = 100.0 + 0.05 * f64::from(step);
        if step % 80 == 0 && truth.len() < 40 {
            let (id, y) = (format!("i{step}"), -0.2);
            truth.insert(id.clone(), -1.0 - speed * (stamp - late - 100.0));
            line.see(stamp, &id, -1.0, y);
        }
        let (due, rest) = std::mem::take(&mut open)
            .into_iter()
            .partition::<Vec<_>, _>(|(at, ..)| *at <= stamp);
        open = rest;
        for (_, task, at, x, place) in due {
            let real = place + speed * (at - 100.0);
            let is_there = (real - x).abs() <= 0.02;
            let found = says_where.then_some(FoundPlace { x: real, y: -0.2 });
            missed += usize::from(!is_there);
            done += 1;
            let result = if is_there {
                Verdict::Picked
            } else {
                Verdict::Missed
            };
            let report = ResultMessage {
                stamp,
                task,
                result,
                available_at: None,
                found,
            };
            line.0.handle(Incoming::Result(report)).unwrap();
        }
        line.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        for message in line.0.take_output() {
            if let Outgoing::Task(task) = message {
                line.ack(stamp, task.id);
                open.retain(|(_, id, ..)| *id != task.id);
                let place = truth[&task.item];
                open.push((task.free_at, task.id, task.meet_at, task.meet.x, place));
            }
        }
    }
    let mut remarks = line.0.take_remarks();
    // The pictures end before the line does.
    remarks.retain(|remark| !remark.contains("silent"));
    (done, missed, remarks)
}

#[test]
fn late_pictures_are_reported_with_the_setting_that_corrects_them() {
    for late in [0.15, 0.2, -0.1] {
        let (done, missed, remarks) = play(late, 0.0, true);
        assert!(done >= 10 && missed == done, "{done} {missed}");
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        let setting = format!("'camera_delay' {:.0} ", 1e3 * late);
        let way = if late < 0.0 { "early" } else { "late" };
        let told = format!(
            "as if timestamps of pictures were {:.0} ms {way}: {setting}",
            1e3 * f64::abs(late)
        );
        assert!(remarks[0].contains(&told), "{remarks:?}");
        let (done, missed, remarks) = play(late, 1e3 * late, true);
        assert!(done >= 10 && missed == 0, "{done} {missed}");
        assert!(remarks.is_empty(), "{remarks:?}");
    }
}

#[test]
fn a_series_of_misses_is_reported() {
    let (done, missed, remarks) = play(0.15, 0.0, false);
    assert!(done >= 10 && missed == done);
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert!(remarks[0].contains("100 ms correspond to 30 mm at this speed, and 'camera_delay'"));
}

#[test]
fn an_indexing_belt_shifts_items_by_its_speed_when_the_picture_was_taken() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let config = Config::default().with_clock(ClockKind::Messages);
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
    for name in ["r1", "r2"] {
        line.say(&format!(
            r#""kind":"robot","stamp":100,"name":"{name}","state":"idle""#
        ));
    }
    // Runs 1.8 s and stands 4.2 s; pictures are taken on the run and stamped 0.15 s late.
    let (speed, late) = (0.3, 0.15);
    let runs = |step: u32| step % 120 < 36;
    let (mut travel, mut open) = (0.0, Vec::<(f64, u64, f64)>::new());
    for step in 0..6000 {
        let stamp = 100.0 + 0.05 * f64::from(step);
        let said = if runs(step) { speed } else { 0.0 };
        line.say(&format!(
            r#""kind":"belt","stamp":{stamp},"speed":{said},"position":{travel}"#
        ));
        if step % 120 == 20 {
            line.see(stamp, &format!("i{step}"), 0.4, -0.2);
        }
        let (due, rest) = std::mem::take(&mut open)
            .into_iter()
            .partition::<Vec<_>, _>(|(at, ..)| *at <= stamp);
        open = rest;
        for (_, task, x) in due {
            let found = Some(FoundPlace {
                x: x + speed * late,
                y: -0.2,
            });
            let report = ResultMessage {
                stamp,
                task,
                result: Verdict::Missed,
                available_at: None,
                found,
            };
            line.0.handle(Incoming::Result(report)).unwrap();
        }
        line.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        for message in line.0.take_output() {
            if let Outgoing::Task(task) = message {
                line.ack(stamp, task.id);
                open.retain(|(_, id, _)| *id != task.id);
                open.push((task.free_at, task.id, task.meet.x));
            }
        }
        travel += said * 0.05;
    }
    let remarks = line.0.take_remarks();
    let told: Vec<_> = remarks
        .iter()
        .filter(|r| r.contains("timestamps of pictures"))
        .collect();
    assert_eq!(told.len(), 1, "{remarks:?}");
    let cure = "were 150 ms late: 'camera_delay' 150 corrects";
    assert!(told[0].contains(cure), "{remarks:?}");
}

#[test]
fn items_found_elsewhere_are_reported_once_for_each_robot() {
    let mut line = Line::new();
    line.say(r#""kind":"belt","stamp":0,"speed":0"#);
    let mut done = 0;
    for step in 0..20 {
        let stamp = 0.5 + 3.0 * f64::from(step);
        line.see(stamp, &format!("i{step}"), 1.3, -0.2);
        line.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        for message in line.0.take_output() {
            let Outgoing::Task(task) = message else {
                continue;
            };
            line.ack(stamp, task.id);
            let at = stamp + 2.5;
            let x = 2.3 + 0.1 * f64::from(step);
            line.say(&format!(
                r#""kind":"result","stamp":{at},"task":{},"result":"PICKED","found":{{"x":{x},"y":-0.2}}"#,
                task.id
            ));
            done += 1;
        }
    }
    let mut remarks = line.0.take_remarks();
    remarks.retain(|remark| remark.contains("`found`"));
    assert!(done > 3 && remarks.len() == 1, "{done} {remarks:?}");
    assert!(remarks[0].starts_with("robot `r1`: "), "{remarks:?}");
    let noted = line.0.status(false, 0).noted;
    assert_eq!(noted["found_elsewhere"], done, "{noted:?}");
}
