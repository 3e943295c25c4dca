//! Clocks that are set, and clocks of others.

use super::{START, STEPS, Whose, World};
use crate::support::table::Table;
use crate::support::three::{Three, station, strategy};
use pickline_live::{Config, Controller};

/// With the table of docs/live.md, which `cargo test --test live clock:: -- --nocapture` prints.
#[test]
fn the_line_goes_on_however_the_machines_clock_is_set() {
    let mut table = Table::new(&[
        "the machine's clock",
        "tasks",
        "off by more than 5 mm",
        "longest time without one [s]",
    ]);
    for (case, steps) in STEPS {
        let mut world = World::new(Config::default());
        world.play(60.0, steps);
        table.row(&[
            case.to_owned(),
            world.given.len().to_string(),
            world.wrong().len().to_string(),
            format!("{:.1}", world.longest_gap()),
        ]);
        world.check(case);
        let noted = world.status().noted;
        let count = noted.get("clock_step").copied().unwrap_or(0);
        assert_eq!(count, steps.len() as u64, "{case}");
        assert_eq!(
            world.remarks.len(),
            steps.len(),
            "{case}: {:?}",
            world.remarks
        );
        let stamp = world.status().stamp;
        assert!(
            (stamp - world.stamp(Whose::Machine, 60.0)).abs() < 0.02,
            "{case}"
        );
        assert_eq!(world.source("camera").mapped, None, "{case}");
        let offset = world.source("belt").offset.unwrap();
        assert!((offset - 0.002).abs() < 1e-3, "{case}: {offset}");
    }
    table.is_in_the_docs();
}

#[test]
fn a_stop_just_after_the_clock_was_set_back_is_heard() {
    let mut world = World::new(Config::default());
    world.stop = 6.0;
    world.play(12.0, &[(5.0, -5.0)]);
    world.check("stop");
    // Nothing is sent after the belt to where it would be if it ran.
    assert!(!world.status().noted.contains_key("late_belt"));
}

#[test]
fn peers_with_clocks_of_their_own_are_mapped_and_keep_their_time() {
    let steps = [(5.0, -5.0), (12.0, 3.0)];
    for (camera, robots) in [(0.0, 0.0), (3.0, 0.5), (1000.0, 1.0)] {
        let mut world = World::new(Config::default());
        (world.camera, world.robots) = (Whose::Own(camera), Whose::Own(robots));
        world.play(20.0, &steps);
        let case = format!("{camera} {robots}");
        // A robot's first word after a step tells whose clock that was: its answer to a task.
        let mut heard = std::collections::BTreeSet::new();
        let mut is_first = |at: f64, robot: &str| {
            let step = steps.iter().filter(|(step, _)| *step <= at).count();
            heard.insert((step, robot.to_owned()))
        };
        let given = world.given.iter();
        let known = given.filter(|(at, _, robot)| !is_first(*at, robot));
        let wrong: Vec<_> = known.filter(|(_, off, _)| *off > 0.01).collect();
        assert!(wrong.is_empty(), "{case}: {wrong:?}");
        assert!(
            world.given.len() > 25 && world.given.last().unwrap().0 > 18.0,
            "{case}"
        );
        assert!(world.refused.len() <= 2, "{case}: {:?}", world.refused);
        let mapped = world.source("camera").mapped.unwrap();
        assert!((mapped - (3.0 - camera)).abs() < 0.03, "{case}: {mapped}");
    }
}

/// A camera that was cut off does not know which of its pictures have arrived, so it sends those of
/// the last seconds again. Its clock was not set: items that were picked since stay picked, and no
/// robot is sent to where they would be now.
#[test]
fn pictures_that_are_sent_again_are_not_those_of_another_clock() {
    for (seconds, apart, arrive) in [(2.0, 0.1, 0.02), (8.0, 0.1, 0.01), (1.0, 0.05, 0.03)] {
        let case = format!("{seconds} s of pictures, {apart} s apart, that come {arrive} s apart");
        let mut world = World::new(Config::default());
        world.play(12.0, &[]);
        let (items, picked) = (world.items.clone(), world.status().picked);
        assert!(picked > 10, "{case}");
        let mut taken = world.now - seconds;
        while taken < world.now {
            for (id, (x, y)) in &items {
                let x = x + world.travel(taken);
                if !(0.2..0.5).contains(&x) {
                    continue;
                }
                let text = format!(r#""kind":"detection","x":{x},"y":{y},"id":"{id}""#);
                world.say_of(Whose::Machine, taken, &text);
            }
            taken += apart;
            world.play(world.now + arrive, &[]);
        }
        world.play(30.0, &[]);
        world.check(&case);
        let status = world.status();
        assert_eq!(status.noted.get("source_step"), None, "{case}");
        assert_eq!(world.source("camera").mapped, None, "{case}");
        assert_eq!(status.seen, world.items.len() as u64, "{case}");
        assert_eq!(world.sent_twice(), Vec::<String>::new(), "{case}");
    }
}

/// Behind by 3 s or slow by 3 s: nobody can tell, so it is not passed over in silence.
#[test]
fn a_source_that_is_always_late_is_reported() {
    let mut world = World::new(Config::default());
    world.camera = Whose::Own(-3.0);
    world.play(12.0, &[]);
    assert!(
        world.remarks.len() == 1
            && world.remarks[0].contains(
                "come at least 3 s after their \
                                                               timestamps"
            ),
        "{:?}",
        world.remarks
    );
    assert!((world.source("camera").offset.unwrap() - 3.002).abs() < 1e-3);
}

/// The program itself, whose clock libfaketime sets: it goes on, and its recording replays.
#[test]
#[cfg(all(feature = "mcap", target_os = "linux"))]
fn the_program_goes_on_when_its_clock_is_set() {
    use crate::programs::wait_for;
    use std::io::{BufRead as _, BufReader, Write as _};
    use std::process::{Command, Stdio};
    use std::sync::{Arc, Mutex};
    use std::time::{Instant, SystemTime, UNIX_EPOCH};

    let folders = std::fs::read_dir("/usr/lib")
        .into_iter()
        .flatten()
        .flatten();
    let library = folders
        .map(|folder| folder.path().join("faketime/libfaketimeMT.so.1"))
        .find(|file| file.exists());
    let library = library.expect("libfaketime; on Debian `apt-get install faketime` installs it");
    let folder = tempfile::tempdir().unwrap();
    let (file, next) = (folder.path().join("ahead"), folder.path().join("next"));
    let recording = folder.path().join("a.mcap");
    let set = |ahead: f64| {
        std::fs::write(&next, format!("{ahead:+.3}\n")).unwrap();
        std::fs::rename(&next, &file).unwrap();
    };
    set(0.0);
    let mut node = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--status-every", "0.02", "--record"])
        .arg(&recording)
        .envs([
            ("LD_PRELOAD", library.as_os_str()),
            ("FAKETIME_TIMESTAMP_FILE", file.as_os_str()),
        ])
        .envs([
            ("FAKETIME_NO_CACHE", "1"),
            ("FAKETIME_DONT_FAKE_MONOTONIC", "1"),
        ])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    let stdout = BufReader::new(node.stdout.take().unwrap());
    let lines = Arc::<Mutex<Vec<String>>>::default();
    let kept = Arc::clone(&lines);
    let reader = std::thread::spawn(move || {
        for line in stdout.lines() {
            kept.lock().unwrap().push(line.unwrap());
        }
    });
    let (began, mut ahead) = (Instant::now(), 0.0);
    let mut say = |ahead: f64, fields: &str| {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let stamp = now.as_secs_f64() + ahead;
        writeln!(stdin, r#"{{"stamp":{stamp},{fields}}}"#).unwrap();
    };
    say(ahead, r#""kind":"robot","name":"r1","state":"idle""#);
    for i in 0..60 {
        let now = match i {
            20..35 => -5.0,
            35..45 => 100.0,
            _ => 0.0,
        };
        if now != ahead {
            ahead = now;
            set(ahead);
        }
        let position = 0.05 * began.elapsed().as_secs_f64();
        say(
            ahead,
            &format!(r#""kind":"belt","speed":0.05,"position":{position}"#),
        );
        let text = format!(
            r#""kind":"detection","id":"i{i}","x":{},"y":{}"#,
            -0.04 * f64::from(i % 20),
            0.15 * f64::from(i / 20) - 0.1
        );
        say(ahead, &text);
        // Until it is in the figures.
        let seen = format!("\"seen\":{},", i + 1);
        wait_for(&seen, || {
            lines
                .lock()
                .unwrap()
                .iter()
                .any(|line| line.contains(&seen))
        });
    }
    drop(stdin);
    reader.join().unwrap();
    let lines = std::mem::take(&mut *lines.lock().unwrap());
    let output = node.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{errors}");
    let last = lines.last().unwrap();
    assert!(last.contains(r#""clock_step":3"#), "{last}");
    assert!(last.contains(r#""rejected":{}"#), "{last}");
    assert!(
        errors.contains("the machine's clock was set back by 5 s"),
        "{errors}"
    );
    let replay = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--replay"])
        .arg(&recording)
        .output()
        .unwrap();
    let told = String::from_utf8(replay.stderr).unwrap();
    assert!(
        told.contains(&format!("all {} messages are as recorded", lines.len())),
        "{told}"
    );
}

/// Nobody has seen a clock being set that was off from the first message on.
#[test]
fn a_clock_that_is_off_from_the_first_message_on_was_not_set() {
    for (ahead, words) in [
        (100.0, "s ahead of the node's"),
        (-100.0, "s behind the node's"),
    ] {
        let mut world = World::new(Config::default());
        world.camera = Whose::Own(ahead);
        world.play(5.0, &[]);
        let of_camera = |world: &World| {
            let remarks = world.remarks.iter();
            let remarks = remarks.filter(|remark| remark.starts_with("camera `camera`: its clock"));
            remarks.cloned().collect::<Vec<String>>()
        };
        let remarks = of_camera(&world);
        assert_eq!(remarks.len(), 1, "{:?}", world.remarks);
        assert!(
            remarks[0].contains("its clock is ") && remarks[0].contains(words),
            "{remarks:?}"
        );
        world.camera = Whose::Own(ahead + 50.0);
        world.play(10.0, &[]);
        let remarks = of_camera(&world);
        assert!(remarks[1].contains("was set forward by "), "{remarks:?}");
    }
}

/// What a controller by the system's clock says to a message of `delta-1` that came at
/// `received`.
fn hear(line: &mut Three, stamp: f64, received: f64, fields: &str) -> Result<(), String> {
    line.controller.advance(received);
    let message = Three::message(&format!(r#""stamp":{stamp},{fields}"#));
    let heard = line.controller.hear(message, received);
    line.said.extend(line.controller.take_output());
    heard.map(|_| ()).map_err(|rejected| rejected.message)
}

const IDLE: &str = r#""kind":"robot","name":"delta-1","state":"idle""#;
const BUSY: &str = r#""kind":"robot","name":"delta-1","state":"busy""#;

/// A robot reads the stamps of its task by its own clock, so when that is set they are wrong:
/// the task is sent again with stamps of the clock as it is now.
#[test]
fn an_open_task_is_sent_again_when_the_clock_of_its_robot_is_set() {
    for by in [7.0, 1000.0] {
        let mut line =
            Three::of(Controller::new(station(), strategy(), Config::default()).unwrap());
        hear(&mut line, START, START, IDLE).unwrap();
        line.see(START, "a", 1.0, 0.0);
        line.controller.advance(START);
        line.said.extend(line.controller.take_output());
        let first = line.task();
        let ack = r#""kind":"ack","task":1"#;
        hear(&mut line, START + 0.01, START + 0.01, ack).unwrap();
        assert_eq!(line.said().0.len(), 0);
        // Two stamps of the future may be mistakes, three that agree are none.
        for (at, is_taken) in [(0.03, false), (0.05, false), (0.07, true)] {
            let heard = hear(&mut line, START + at + by, START + at, BUSY);
            assert_eq!(heard.is_ok(), is_taken, "{heard:?}");
        }
        let (mut tasks, _) = line.said();
        assert_eq!(tasks.len(), 1, "{by}: {tasks:?}");
        let again = tasks.remove(0);
        assert_eq!((again.id, again.revision), (first.id, first.revision + 1));
        assert!((again.meet_at - first.meet_at - by).abs() < 1e-3, "{by}");
        assert!((again.meet.x - first.meet.x).abs() < 1e-3, "{by}");
    }
}

/// A refused stamp is told with the time that the machine's clock shows, however it was set.
#[test]
fn a_refused_stamp_is_reported_with_the_machines_time() {
    for ahead in [0.0, 100.0, -3600.0] {
        let mut line =
            Three::of(Controller::new(station(), strategy(), Config::default()).unwrap());
        hear(&mut line, START, START, IDLE).unwrap();
        line.controller.set_clock_ahead(ahead);
        let now = START + 0.5 + ahead;
        let refused = hear(&mut line, now + 7.0, START + 0.5, BUSY).unwrap_err();
        let expected = format!("stamp = {}, but the time is {now}; expected", now + 7.0);
        assert!(refused.starts_with(&expected), "{refused}");
    }
}
