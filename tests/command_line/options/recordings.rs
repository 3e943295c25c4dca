//! The import of recordings, of a film whose items are known.

use super::rig::{Rig, assert_near};
use super::{Row, hold, row};
use crate::common::csv_column;

const IMPORT: [&str; 1] = ["pattern import tracks"];
/// What the film was made with.
const TRUE: &str = "--fps 10 --scale 0.001 --axis x --belt-speed 0.1";

pub const ROWS: &[Row] = &[
    row(&IMPORT, "<file>", |rig, _| {
        assert_eq!(ids(&imported(rig, TRUE)), ["1", "2", "6"]);
        rig.write(
            "film.txt",
            &film(|[x, y]| [x, y])
                .lines()
                .take(10)
                .collect::<Vec<_>>()
                .join("\n"),
        );
        assert_eq!(ids(&again(rig, TRUE)), ["1"]);
    }),
    row(&IMPORT, "--as", |rig, _| {
        assert_eq!(
            imported(rig, &format!("{TRUE} --as mot")),
            imported(rig, TRUE)
        );
        refused(rig, &format!("{TRUE} --as coco"), "not valid JSON");
    }),
    row(&IMPORT, "--boxes", |rig, _| {
        // Sizes are 40 and 20 pixels: what were corners are centres half a box further up.
        let centre = |flags: &str| line(rig, &format!("{TRUE} {flags}"), "centre line");
        assert!(centre("").contains("at pixel 400.00"));
        assert!(centre("--boxes sizes").contains("at pixel 400.00"));
        assert!(centre("--boxes centres").contains("at pixel 390.00"));
        refused(rig, &format!("{TRUE} --boxes corners"), "by its corners");
    }),
    row(&IMPORT, "--image-size", |rig, _| {
        let expected = imported(rig, TRUE);
        // The same in shares of a picture of 2000 by 1000 pixels.
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let [x, y, width, height] = [2, 3, 4, 5].map(|place| cells[place]);
            let (x, width) = (x / 2000.0, width / 2000.0);
            let (y, height) = (y / 1000.0, height / 1000.0);
            format!(
                "{},{},{x},{y},{width},{height},{}\n",
                cells[0], cells[1], cells[6]
            )
        };
        let shares: String = rig.read("film.txt").lines().map(row).collect();
        rig.write("film.txt", &shares);
        let found = again(rig, &format!("{TRUE} --image-size 2000x1000"));
        let x = |pattern: &str| {
            csv_column(pattern, "x")
                .iter()
                .map(|x| x.parse().unwrap())
                .collect()
        };
        let (found, expected): (Vec<f64>, Vec<f64>) = (x(&found), x(&expected));
        assert_eq!(found.len(), 3);
        found
            .iter()
            .zip(expected)
            .for_each(|(x, expected)| assert_near(*x, expected));
        let called = rig.call(&format!("pattern import tracks film.txt {TRUE}"));
        assert!(
            called.code == Some(2) && called.stderr.contains("--image-size"),
            "{called:?}"
        );
    }),
    row(&IMPORT, "--fps", |rig, _| {
        refused(
            rig,
            &TRUE.replace("--fps 10", "--fps 20"),
            "move at 0.2000 m/s",
        );
        let quick = TRUE.replace("--fps 10", "--fps 20").replace("0.1", "0.2");
        assert_eq!(imported(rig, &quick), imported(rig, TRUE));
    }),
    row(&IMPORT, "--scale", |rig, _| {
        let large = TRUE.replace("0.001", "0.002").replace("0.1", "0.2");
        let y = csv_column(&imported(rig, &large), "y");
        assert_eq!(y[..2], ["0.2", "-0.2"]);
    }),
    row(&IMPORT, "--axis", |rig, _| {
        let expected = imported(rig, TRUE);
        refused(rig, &TRUE.replace("axis x", "axis y"), "give --axis x");
        rig.write("film.txt", &film(|[x, y]| [y, x]));
        let turned = again(rig, &TRUE.replace("axis x", "axis y"));
        assert_eq!(csv_column(&turned, "x"), csv_column(&expected, "x"));
    }),
    row(&IMPORT, "--reverse", |rig, _| {
        let expected = imported(rig, TRUE);
        refused(rig, &format!("{TRUE} --reverse"), "omit --reverse");
        rig.write("film.txt", &film(|[x, y]| [1000.0 - x, y]));
        let turned = again(rig, &format!("{TRUE} --reverse"));
        assert_eq!(ids(&turned), ids(&expected));
    }),
    row(&IMPORT, "--angle", |rig, _| {
        // Seen askew what lies across is shorter by the cosine.
        let y = csv_column(&imported(rig, &format!("{TRUE} --angle 1")), "y");
        assert_near(y[0].parse().unwrap(), 0.1 * 1f64.to_radians().cos());
    }),
    row(&IMPORT, "--belt-speed", |rig, _| {
        refused(
            rig,
            &TRUE.replace("0.1", "0.2"),
            "the given belt speed is 0.2 m/s",
        );
    }),
    row(&IMPORT, "--centre-px", |rig, _| {
        // The items are at pixels 300 and 500.
        let y = csv_column(&imported(rig, &format!("{TRUE} --centre-px 350")), "y");
        assert_eq!(y[..2], ["0.05", "-0.15"]);
    }),
    row(&IMPORT, "--min-frames", |rig, _| {
        let found = |count: &str| ids(&imported(rig, &format!("{TRUE} --min-frames {count}")));
        assert_eq!(found("1"), ["1", "3", "2", "6"]);
        assert_eq!(found("2"), ["1", "2", "6"]);
    }),
    row(&IMPORT, "--split-distance", |rig, _| {
        let found = imported(rig, &format!("{TRUE} --split-distance 0.05"));
        assert_eq!(ids(&found), ["1", "2", "5", "5.2", "6"]);
    }),
    row(&IMPORT, "--merge-distance", |rig, _| {
        let found = imported(rig, &format!("{TRUE} --merge-distance 0.005"));
        assert_eq!(ids(&found), ["1", "2", "7", "6"]);
    }),
    row(&IMPORT, "--output", |rig, _| {
        let printed = imported(rig, TRUE);
        for (flag, name) in [("--output", "a.csv"), ("-o", "b.csv")] {
            assert_eq!(imported(rig, &format!("{TRUE} {flag} {name}")), "");
            assert!(rig.read(name).ends_with(&printed));
        }
    }),
    row(&IMPORT, "--accept-mismatch", |rig, _| {
        let wrong = TRUE.replace("--fps 10", "--fps 20");
        refused(rig, &wrong, "the pattern would be wrong");
        assert_ne!(
            ids(&imported(rig, &format!("{wrong} --accept-mismatch"))).len(),
            0
        );
    }),
    row(&IMPORT, "--report", |rig, _| {
        imported(rig, &format!("{TRUE} --report report.json"));
        let report: serde_json::Value = serde_json::from_str(&rig.read("report.json")).unwrap();
        assert!(
            report["command"]
                .as_str()
                .unwrap()
                .starts_with("pickline pattern import tracks")
        );
        assert!(report.to_string().contains("stands still"), "{report}");
    }),
    row(&IMPORT, "--class-names", |rig, _| {
        let row = |line: &str| format!("{line},{},1\n", line.split(',').nth(1).unwrap());
        let film = film(|[x, y]| [x, y]).lines().map(row).collect::<String>();
        rig.write("film.txt", &film);
        let classes = |flags: &str| csv_column(&again(rig, &format!("{TRUE} {flags}")), "class");
        assert_eq!(classes(""), ["1", "2", "6"]);
        let names = "1:pet,2:hdpe,3:wood,5:wood,6:pet,7:pet";
        let named = ["pet", "hdpe", "pet"];
        assert_eq!(classes(&format!("--class-names {names}")), named);
        rig.write("names.txt", &names.replace(',', "\n"));
        assert_eq!(classes("--class-names names.txt"), named);
        let call = format!("pattern import tracks film.txt {TRUE}");
        let without = format!("{call} --class-names 1:pet");
        rig.refused(
            &without,
            &["film.txt:", "class id 3 has no name", "--class-names"],
        );
        // The names are not overwritten.
        let over = format!("{call} --class-names names.txt --output names.txt --force");
        rig.refused(&over, &["names.txt"]);
        assert!(rig.read("names.txt").starts_with("1:pet"));
    }),
    row(&IMPORT, "--strict", |rig, verb| {
        rig.write("film.txt", &film(|[x, y]| [x, y]));
        let doubtful = TRUE.replace("0.1", "0.106");
        let call = format!("{verb} film.txt {doubtful}");
        let warned = rig.done(&call).stderr;
        assert!(warned.contains("warning: "), "{warned}");
        let strict = rig.call(&format!("{call} --strict"));
        assert_eq!((strict.code, strict.stdout.as_str()), (Some(2), ""));
        assert!(
            strict.stderr.starts_with("pickline: film.txt: "),
            "{}",
            strict.stderr
        );
    }),
    row(&IMPORT, "--quiet", |rig, verb| {
        rig.write("film.txt", &film(|[x, y]| [x, y]));
        let loud = rig.done(&format!("{verb} film.txt {TRUE}"));
        assert!(loud.stderr.contains("dropped 1 track"));
        for flag in ["-q", "--quiet"] {
            let silent = rig.done(&format!("{verb} film.txt {TRUE} {flag}"));
            assert_eq!((silent.stderr.as_str(), &silent.stdout), ("", &loud.stdout));
        }
    }),
];

#[test]
fn import_options_have_their_effect() {
    hold(ROWS);
}

/// A film of 10 pictures a second, in which the belt takes items 10 pixels further each time;
/// `place` puts the pixels elsewhere.
///
/// 1 and 2 come 2 s after each other. 3 is seen once. 5 jumps back by 60 pixels. 6 and 7 are one
/// item whose place was off by 10 pixels.
fn film(place: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let mut boxes = Vec::new();
    for step in 1..=10u32 {
        let x = 100.0 + 10.0 * f64::from(step);
        let (jump, other, off) = if step > 5 {
            (60.0, 7, 10.0)
        } else {
            (0.0, 6, 0.0)
        };
        boxes.push((step, 1, [x, 300.0]));
        boxes.push((20 + step, 2, [x, 500.0]));
        boxes.push((40 + step, 5, [x - jump, 350.0]));
        boxes.push((60 + step, other, [x + off, 450.0]));
    }
    boxes.push((15, 3, [200.0, 400.0]));
    boxes.sort_by_key(|(frame, ..)| *frame);
    let row = |(frame, id, centre): (u32, u32, [f64; 2])| {
        let [x, y] = place(centre);
        format!("{frame},{id},{},{},40,20,0.9\n", x - 20.0, y - 10.0)
    };
    boxes.into_iter().map(row).collect()
}

fn imported(rig: &Rig, flags: &str) -> String {
    rig.write("film.txt", &film(|[x, y]| [x, y]));
    again(rig, flags)
}

/// The pattern of the film that is there.
fn again(rig: &Rig, flags: &str) -> String {
    rig.text(&format!("pattern import tracks film.txt -q {flags}"))
}

fn ids(pattern: &str) -> Vec<String> {
    csv_column(pattern, "id")
}

fn refused(rig: &Rig, flags: &str, words: &str) {
    rig.write("film.txt", &film(|[x, y]| [x, y]));
    rig.refused(&format!("pattern import tracks film.txt {flags}"), &[words]);
}

/// The line that an import tells with `words`.
fn line(rig: &Rig, flags: &str, words: &str) -> String {
    rig.write("film.txt", &film(|[x, y]| [x, y]));
    let told = rig
        .done(&format!("pattern import tracks film.txt {flags}"))
        .stderr;
    told.lines()
        .find(|line| line.contains(words))
        .unwrap()
        .to_owned()
}
