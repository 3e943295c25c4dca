//! What is done with detections besides telling items apart: which are refused, where the belt
//! ends, what an item's news do, and what is remarked.

use crate::support::three::{Three, config};

fn detection(stamp: f64, rest: &str) -> String {
    format!(r#""kind":"detection","stamp":{stamp},{rest}"#)
}

/// Why a detection is refused, if it is: the reason and the message.
fn refused(line: &mut Three, fields: &str) -> Option<(&'static str, String)> {
    let taken = line.controller.handle(Three::message(fields));
    taken
        .err()
        .map(|refused| (refused.reason.name(), refused.message))
}

/// A belt 0.6 m wide and 4 m long: 50 mm beside it are believed, nothing past its end.
#[test]
fn where_a_detection_may_lie() {
    // Place, speed of the belt, how late the picture comes [s], and which axis is wrong.
    for (x, y, speed, late, wrong) in [
        (1.0, 0.35, 0.0, 0.0, None),
        (1.0, -0.35, 0.0, 0.0, None),
        (1.0, 0.3501, 0.0, 0.0, Some("y")),
        (1.0, -0.3501, 0.0, 0.0, Some("y")),
        (4.0, 0.0, 0.0, 0.0, None),
        (4.0001, 0.0, 0.0, 0.0, Some("x")),
        (-3.0, 0.0, 0.0, 0.0, None),
        // It is past the end by now, or not.
        (3.6, 0.0, 0.3, 1.5, Some("x")),
        (3.5, 0.0, 0.3, 1.5, None),
    ] {
        let mut line = Three::new(speed);
        line.tick(100.0 + late);
        let case = format!("{x} {y} {speed} {late}");
        let found = refused(&mut line, &detection(100.0, &format!(r#""x":{x},"y":{y}"#)));
        line.tick(100.0 + late);
        let status = line.status();
        assert_eq!(status.seen, u64::from(wrong.is_none()), "{case}");
        let Some(axis) = wrong else {
            assert_eq!(found, None, "{case}");
            continue;
        };
        let (reason, message) = found.unwrap();
        assert_eq!(
            (reason, status.rejected["off_belt"]),
            ("off_belt", 1),
            "{case}"
        );
        let expected = match axis {
            "y" => format!("the item is at y = {y} m; expected |y| up to the belt's edge at 0.3 m"),
            _ => {
                let x = x + speed * late;
                // Above 1 m it may be another unit.
                assert!(
                    message.contains("; millimetres or centimetres? ("),
                    "{message}"
                );
                format!("the item is at x = {x} m; expected x up to the belt's end at 4 m, now")
            }
        };
        assert_eq!(
            message.split("; milli").next(),
            Some(&expected[..]),
            "{case}"
        );
    }
    // A place that would be on the belt in another unit is asked about; one that would not is not.
    for (x, unit) in [(1200.0, true), (9000.0, false)] {
        let mut line = Three::new(0.0);
        let (_, message) =
            refused(&mut line, &detection(100.0, &format!(r#""x":{x},"y":0"#))).unwrap();
        assert_eq!(message.contains("mm"), unit, "{message}");
    }
}

/// A known item is seen again past the end of the belt; another one is not seen there.
#[test]
fn a_known_item_may_be_seen_past_the_end() {
    let mut line = Three::new(0.3);
    line.see(100.0, "a", 3.99, 0.0);
    line.tick(100.0);
    line.tick(101.0);
    // At 4.29 m by now, under its id and by its place; 3 times 15 mm beside it, and more.
    for (fields, is_known) in [
        (r#""id":"a","x":4.29,"y":0"#, true),
        (r#""x":4.285,"y":0"#, true),
        (r#""id":"a","x":4.333,"y":0"#, true),
        (r#""id":"a","x":4.50,"y":0"#, false),
        (r#""x":4.40,"y":0"#, false),
    ] {
        let found = refused(&mut line, &detection(101.0, fields));
        assert_eq!(found.is_none(), is_known, "{fields}");
        line.tick(101.0);
    }
    assert_eq!(line.status().seen, 1);
}

/// An item is forgotten half a metre past the end of the belt, unless a robot is after it.
#[test]
fn when_an_item_is_forgotten() {
    // 1 m to 4.5 m at 0.3 m/s.
    let gone = 100.0 + 3.5 / 0.3;
    let mut line = Three::new(0.3);
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(gone - 0.001);
    assert_eq!(line.controller.load(), (1, 0));
    line.tick(gone + 0.001);
    assert_eq!(line.controller.load(), (0, 0));
    assert_eq!(line.status().seen, 1);
    let patient = config().with_result_timeout(30.0);
    let mut line = Three::with(patient, 0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    line.ack(100.0, 1);
    line.tick(gone + 5.0);
    assert_eq!(line.controller.load(), (1, 1));
    line.result(gone + 5.0, 1, "PICKED");
    line.tick(gone + 5.0);
    assert_eq!(line.controller.load(), (0, 0));
    assert_eq!(line.status().picked, 1);
}

#[test]
fn there_is_room_for_so_many_items() {
    let few = config().with_most_items(3);
    let mut line = Three::with(few, 0.0);
    for (id, x) in [("a", 1.0), ("b", 1.2)] {
        line.see(100.0, id, x, 0.0);
    }
    // In one picture with them, and in one of its own.
    assert_eq!(
        refused(&mut line, &detection(100.0, r#""id":"c","x":1.4,"y":0"#)),
        None
    );
    let full = refused(&mut line, &detection(100.0, r#""id":"d","x":1.6,"y":0"#));
    let expected = "d exceeds the limit of 3 items; expected fewer at a time";
    assert_eq!(full, Some(("too_many_items", expected.to_owned())));
    line.tick(100.1);
    let full = refused(&mut line, &detection(100.1, r#""x":1.6,"y":0"#));
    let expected = "without id exceeds the limit of 3 items; expected fewer at a time";
    assert_eq!(full, Some(("too_many_items", expected.to_owned())));
    // One that is known needs no room.
    assert_eq!(
        refused(&mut line, &detection(100.2, r#""id":"a","x":1.0,"y":0"#)),
        None
    );
    line.tick(100.2);
    let status = line.status();
    assert_eq!((status.seen, status.rejected["too_many_items"]), (3, 2));
}

/// Pictures that are stamped late were taken before: the item has gone further.
#[test]
fn the_camera_delay_is_taken_off_its_stamps() {
    for (delay, x) in [(0.0, 1.0), (0.15, 1.045)] {
        let config = config().with_camera_delay(delay);
        let mut line = Three::with(config, 0.3);
        line.tick(101.0);
        line.see(101.0, "a", 1.0, 0.0);
        line.tick(101.0);
        let item = &line.controller.view(0).items[0];
        assert!((item.x - x).abs() < 1e-9, "{delay}: {}", item.x);
    }
}

/// When a picture was taken, and what it shows: ids and places.
type Picture<'a> = (f64, &'a [(&'a str, f64, f64)]);

/// Each kind of news of what an item is: counted, and remarked the first time in so many words.
#[test]
fn what_is_reported_about_items() {
    let rest = |what: &str| format!("\n  further ones are only counted, as {what} in the status");
    let play = |pictures: &[Picture]| {
        let mut line = Three::new(0.0);
        for (stamp, shown) in pictures {
            for (id, x, y) in *shown {
                let id = if id.is_empty() {
                    String::new()
                } else {
                    format!(r#""id":"{id}","#)
                };
                line.say(&detection(*stamp, &format!(r#"{id}"x":{x},"y":{y}"#)));
            }
        }
        line.tick(110.0);
        let remarks = line.controller.take_remarks();
        (line.status(), remarks)
    };
    let (status, remarks) = play(&[
        (100.0, &[("a", 1.0, 0.0)]),
        (100.1, &[("b", 1.0, 0.0)]),
        (100.2, &[("c", 1.0, 0.0)]),
    ]);
    assert_eq!(
        (
            status.seen,
            status.noted["renumbered"],
            status.noted["repeated_detection"]
        ),
        (1, 2, 2)
    );
    let told = "the tracker has a new id for item `a`, `b`: by its position it is the same item";
    assert_eq!(remarks, [format!("{told}{}", rest("renumbered"))]);

    let (status, remarks) = play(&[(100.0, &[("a", 1.0, 0.0)]), (100.1, &[("a", 1.25, 0.0)])]);
    assert_eq!((status.seen, status.noted["id_reused"]), (2, 1));
    let told = "the tracker uses the id `a` 0.250 m from its item: this is treated as another \
                item, `a`; the earlier one is now called `a~1`";
    assert_eq!(remarks, [format!("{told}{}", rest("id_reused"))]);

    let (status, remarks) = play(&[(100.0, &[("a", 1.0, 0.0), ("b", 1.003, 0.0)])]);
    assert_eq!((status.seen, status.noted["doubled"]), (1, 1));
    let told = "a picture shows item `a` twice, 3.0 mm apart: the second detection is treated as a \
                second box around it";
    assert_eq!(remarks, [format!("{told}{}", rest("doubled"))]);

    // The same one again in a picture is a correction, and a late one moves nothing.
    let (status, remarks) = play(&[
        (100.0, &[("a", 1.0, 0.0), ("a", 1.001, 0.0)]),
        (101.0, &[("a", 1.0, 0.0)]),
        (100.5, &[("a", 1.004, 0.0)]),
    ]);
    assert_eq!((status.seen, remarks.len()), (1, 0));
    assert_eq!(
        (
            status.noted["repeated_detection"],
            status.noted["late_detection"]
        ),
        (2, 1)
    );

    // Two ids of one item turn out to be two.
    let (status, remarks) = play(&[
        (100.0, &[("a", 1.0, 0.0)]),
        (100.1, &[("b", 1.0, 0.0)]),
        (100.2, &[("a", 1.0, 0.0), ("b", 1.012, 0.0)]),
    ]);
    assert_eq!((status.seen, status.noted["split"]), (2, 1));
    let told = "a picture shows two items 12.0 mm apart, `a` and `b`, which had been treated as \
                one";
    assert!(
        remarks.contains(&format!("{told}{}", rest("split"))),
        "{remarks:?}"
    );
}

/// Two cameras may have ids for one item; two items that are never seen beside each other are one.
#[test]
fn what_is_fused() {
    let mut line = Three::new(0.0);
    line.say(&detection(
        100.0,
        r#""id":"a","x":1.0,"y":0,"source":"north""#,
    ));
    line.say(&detection(
        100.0,
        r#""id":"7","x":1.0,"y":0,"source":"south""#,
    ));
    line.tick(100.1);
    assert_eq!((line.status().seen, line.noted("fused")), (1, 1));
    assert_eq!(
        line.controller.take_remarks(),
        [
            "another camera has an id for item `a`, `7`: by its position it is the same item\n  \
             further ones are only counted, as fused in the status"
        ]
    );
    // Seen beside each other, 6 mm apart, and then only the one again and again.
    let mut line = Three::new(0.0);
    line.see(100.0, "a", 1.0, 0.0);
    line.see(100.0, "b", 1.006, 0.0);
    line.tick(100.0);
    line.see(100.05, "a", 1.0, 0.0);
    line.see(100.05, "b", 1.006, 0.0);
    line.tick(100.05);
    assert_eq!(line.status().seen, 2);
    let mut pictures = 0;
    while line.status().seen == 2 {
        pictures += 1;
        assert!(pictures < 20);
        let stamp = 100.0 + 0.1 * f64::from(pictures);
        line.see(stamp, "a", 1.0, 0.0);
        line.tick(stamp);
    }
    // Four more than three for the picture that showed them both again.
    assert_eq!((pictures, line.noted("fused")), (4 + 3, 1));
    assert_eq!(
        line.controller.take_remarks(),
        [
            "items `b` and `a` are so near that they may be one, and pictures show only one: they \
             are merged\n  further ones are only counted, as fused in the status"
        ]
    );
    let status = line.status();
    assert_eq!((status.on_belt, status.seen), (1, 1));
}

/// News of an item reach a robot that waits, and an item of a robot that it is sent to.
#[test]
fn a_moved_item_opens_its_windows_again() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    // Out of its reach by a little, until it is seen further upstream under its id.
    line.see(100.0, "a", 1.61, 0.0);
    line.tick(100.1);
    assert_eq!(line.told(), [""; 0]);
    line.see(100.2, "a", 1.595, 0.0);
    line.tick(100.2);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
}

/// An item that moves out of a reach is not left for.
#[test]
fn a_moved_item_loses_its_windows() {
    for (x, is_given) in [(1.599, true), (1.605, false)] {
        let mut line = Three::new(0.0);
        line.robot(100.0, "delta-1", "idle");
        line.controller.hold(&[0]);
        line.see(100.0, "a", 1.595, 0.0);
        line.tick(100.1);
        line.see(100.2, "a", x, 0.0);
        line.tick(100.2);
        line.controller.hold(&[]);
        line.tick(100.3);
        assert_eq!(line.told().len(), usize::from(is_given), "{x}");
    }
}

/// An item that is seen first where no robot reaches it any more was never within reach.
#[test]
fn an_item_that_is_seen_too_late_was_never_within_reach() {
    let mut line = Three::new(0.3);
    line.tick(110.0);
    line.see(110.0, "a", 3.3, 0.0);
    line.tick(130.0);
    assert_eq!(line.status().missed.unreachable, 1);
}

/// A place that differs by less than 0.1 mm is the same; what is as old as what is known of an
/// item is not late, and what is older stays so.
#[test]
fn what_moves_an_item() {
    let place = |line: &Three| line.controller.view(0).items[0].x;
    let mut line = Three::new(0.0);
    line.see(100.0, "a", 1.0, 0.0);
    line.see(100.1, "a", 1.000_09, 0.0);
    line.tick(100.1);
    assert_eq!(place(&line), 1.0);
    line.see(100.2, "a", 1.000_11, 0.0);
    line.tick(100.2);
    assert_eq!(place(&line), 1.000_11);
    // The same stamp again is no late news.
    line.see(100.2, "a", 1.002, 0.0);
    line.tick(100.2);
    assert_eq!(place(&line), 1.002);
    assert_eq!(line.noted("late_detection"), 0);
    for (number, stamp) in [100.05, 100.15].into_iter().enumerate() {
        line.see(stamp, "a", 1.0, 0.0);
        line.tick(100.2);
        assert_eq!(line.noted("late_detection"), number as u64 + 1);
    }
    assert_eq!(place(&line), 1.002);
    assert_eq!(line.noted("repeated_detection"), 3);
}

/// Two items that turn out to be one: the younger is forgotten, whichever is shown, and nobody
/// is sent to it. One that a robot was sent to stays.
#[test]
fn which_of_two_items_stays() {
    // Which one is shown, which of them a robot was sent to, and what is known in the end.
    for (shown, sent, stays) in [
        ("a", None, &["a"][..]),
        ("b", None, &["a"]),
        ("b", Some("b"), &["b"]),
        ("b", Some("a"), &["a", "b"]),
        ("a", Some("b"), &["a", "b"]),
        ("a", Some("a"), &["a"]),
    ] {
        let case = format!("{shown} {sent:?}");
        let mut line = Three::new(0.0);
        // delta-1 takes the one that is nearer to its bin, and does not find it.
        let (a, b) = if sent == Some("b") {
            (1.006, 1.0)
        } else {
            (1.0, 1.006)
        };
        line.see(100.0, "a", a, 0.0);
        line.see(100.0, "b", b, 0.0);
        line.tick(100.0);
        if let Some(sent) = sent {
            line.robot(100.0, "delta-1", "idle");
            line.tick(100.0);
            let task = line.task();
            assert_eq!(task.item, sent, "{case}");
            line.result(100.0, task.id, "MISSED");
            line.robot(100.01, "delta-1", "fault");
        }
        for step in 1..8 {
            let stamp = 100.0 + 0.1 * f64::from(step);
            let x = if shown == "a" { a } else { b };
            line.see(stamp, shown, x, 0.0);
            line.tick(stamp);
        }
        line.said.clear();
        let mut known: Vec<String> = line
            .controller
            .view(0)
            .items
            .into_iter()
            .map(|item| item.id)
            .filter(|id| id != "c")
            .collect();
        known.sort();
        assert_eq!(known, stays, "{case}");
        if sent.is_none() {
            // It is one to the robots.
            line.robot(101.0, "delta-1", "idle");
            line.tick(101.0);
            let task = line.task();
            line.ack(101.0, task.id);
            line.result(102.0, task.id, "PICKED");
            line.tick(103.0);
            assert_eq!((line.told(), line.status().picked), (vec![], 1), "{case}");
        }
    }
}

/// An item that was often seen beside its neighbour can be missing for 30 pictures longer.
#[test]
fn how_long_an_item_may_be_missing() {
    for (beside, missing) in [(0, 4), (1, 7), (9, 31), (12, 34), (40, 34)] {
        let mut line = Three::new(0.0);
        for step in 0..=beside {
            let stamp = 100.0 + 0.01 * f64::from(step);
            line.see(stamp, "a", 1.0, 0.0);
            line.see(stamp, "b", 1.006, 0.0);
            line.tick(stamp);
        }
        let mut pictures = 0;
        while line.status().seen == 2 && pictures < 60 {
            pictures += 1;
            let stamp = 101.0 + 0.01 * f64::from(pictures);
            line.see(stamp, "a", 1.0, 0.0);
            line.tick(stamp);
        }
        assert_eq!(pictures, missing, "{beside}");
    }
}

/// A second item beside one that has passed the end is past it too, which shows when the
/// picture is whole.
#[test]
fn what_turns_out_to_be_past_the_end_is_refused() {
    let mut line = Three::new(0.3);
    line.see(100.0, "a", 3.99, 0.0);
    line.tick(101.0);
    line.see(101.0, "a", 4.29, 0.0);
    line.see(101.0, "b", 4.30, 0.0);
    line.tick(101.0);
    let status = line.status();
    assert_eq!((status.seen, status.rejected["off_belt"]), (1, 1));
}
