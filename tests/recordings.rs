//! Recordings of cameras: every form of file, and films of which the truth is known.

mod common;

use pickline::pattern::tracking::{Axis, Boxes, Import, Options, Recording, import};
use pickline::pattern::{Pattern, random_stream};
use rand::RngExt as _;
use std::fmt::Write as _;
use std::path::Path;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/formats/");

/// The film of the files in [`DATA`]: 25 frames a second, 2 mm a pixel, a belt at 0.25 m/s.
fn options() -> Options {
    Options::new(25.0, 0.002, Axis::X, 0.25)
}

fn load(name: &str, options: &Options) -> Result<Import, String> {
    let recording = Recording::load(Path::new(&format!("{DATA}{name}")));
    let recording = recording.map_err(|error| error.to_string())?;
    import(&recording, name, options).map_err(|error| error.to_string())
}

fn read(text: &str, options: &Options) -> Result<Import, String> {
    import(&Recording::Text(text.to_owned()), "film.txt", options).map_err(|e| e.to_string())
}

/// Places of items by their order along the belt, and the largest distance [m] between those
/// of two patterns; infinite where they differ in number.
fn apart(one: &Pattern, other: &Pattern) -> f64 {
    if one.len() != other.len() {
        return f64::INFINITY;
    }
    let pairs = one.items().iter().zip(other.items());
    let off = |(a, b): (&pickline::pattern::Item, &pickline::pattern::Item)| {
        (a.x0 - b.x0).abs().max((a.y - b.y).abs())
    };
    pairs.map(off).fold(0.0, f64::max)
}

fn classes(pattern: &Pattern) -> Vec<&str> {
    let items = pattern.items().iter();
    items
        .map(|item| item.class.as_deref().unwrap_or(""))
        .collect()
}

/// The rows of supervision.csv: frame, id, class, and the corners [px].
fn rows() -> Vec<(u32, u32, u32, [f64; 4])> {
    let text = std::fs::read_to_string(format!("{DATA}supervision.csv")).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let corner = |place: usize| fields[place].parse::<f64>().unwrap();
        (
            fields[8].parse().unwrap(),
            fields[6].parse().unwrap(),
            fields[4].parse().unwrap(),
            [0, 1, 2, 3].map(corner),
        )
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn every_form_gives_the_same_items() {
    let plain = load("mot-with-header.csv", &options()).unwrap();
    assert!(plain.pattern.len() >= 5);
    assert!(
        plain.report.warnings.is_empty(),
        "{:?}",
        plain.report.warnings
    );
    assert!(classes(&plain.pattern).iter().all(|class| class.is_empty()));
    let classed = load("class-in-column-8.txt", &options()).unwrap();
    // Whole pixels.
    assert!(apart(&plain.pattern, &classed.pattern) < 0.002);
    assert!(
        classes(&classed.pattern).starts_with(&["0", "1", "0"]),
        "{classed:?}"
    );
    let from_0 = load("frames-from-0.txt", &options()).unwrap();
    assert!(apart(&plain.pattern, &from_0.pattern) < 1e-9);
    assert_eq!(from_0.report.malformed_lines, 0);
    assert!(
        from_0
            .report
            .lines()
            .contains(&"frames counted from 0".to_owned())
    );
    let supervision = load("supervision.csv", &options()).unwrap();
    assert!(apart(&plain.pattern, &supervision.pattern) < 0.001);
    assert!(classes(&supervision.pattern).starts_with(&["PET", "PE", "PET"]));
    // A folder whose first boxes have no ids yet.
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    let labels = load("ultralytics-labels", &sized).unwrap();
    assert!(labels.pattern.len() >= 4);
    assert!(labels.report.malformed_lines > 0);
    assert!(classes(&labels.pattern).starts_with(&["0", "1", "0"]));
    for (a, b) in labels.pattern.items().iter().zip(plain.pattern.items()) {
        assert!((a.x0 - b.x0).abs() < 0.003, "{a:?} {b:?}");
    }
}

#[test]
fn boxes_without_tracks_are_linked_by_the_belts_motion() {
    let tracked = load("supervision.csv", &options()).unwrap().pattern;
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    let mut yolo = String::new();
    let mut coco = Vec::new();
    let mut mot = String::new();
    for (frame, _, class, [x1, y1, x2, y2]) in rows() {
        let (w, h) = (x2 - x1, y2 - y1);
        let _ = writeln!(
            yolo,
            "{frame} {class} {} {} {} {} {} {}",
            x1 / 1280.0,
            y1 / 400.0,
            x2 / 1280.0,
            y2 / 400.0,
            (x1 + x2) / 2560.0,
            (y1 + y2) / 800.0
        );
        let _ = writeln!(mot, "{},-1,{x1},{y1},{w},{h},0.9,-1,-1,-1", frame + 1);
        coco.push(serde_json::json!({
            "image_id": frame, "category_id": class, "bbox": [x1, y1, w, h], "score": 0.9
        }));
    }
    let list = serde_json::Value::from(coco.clone()).to_string();
    let data_set = serde_json::json!({
        "annotations": coco,
        "categories": [{"id": 0, "name": "PET"}, {"id": 1, "name": "PE"}, {"id": 2, "name": "can"}]
    });
    for (text, classed) in [
        (&yolo, "0"),
        (&mot, ""),
        (&list, "0"),
        (&data_set.to_string(), "PET"),
    ] {
        let linked = read(text, &sized).unwrap();
        assert!(
            apart(&linked.pattern, &tracked) < 1e-3,
            "{:#?}",
            linked.report
        );
        assert_eq!(classes(&linked.pattern)[0], classed);
        let said = linked
            .report
            .remarks
            .iter()
            .any(|r| r.contains("linked to"));
        assert!(said, "{:?}", linked.report.remarks);
    }
}

#[test]
fn what_has_no_certain_meaning_is_refused_by_its_name() {
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    for (name, words) in [
        (
            "ultralytics-one-file.txt",
            &["Ultralytics labels", "frames are missing", "save_txt"][..],
        ),
        (
            "yolo-tracker.txt",
            &["yolo-tracker.txt:4", "YOLO", "frames are missing"],
        ),
        ("csv", &["csv", "no .txt file"]),
    ] {
        let message = load(name, &sized).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
    let message = load("ultralytics-labels", &options()).unwrap_err();
    assert!(message.contains("--image-size"), "{message}");
    for (text, words) in [
        (
            "x_min,y_min,x_max,y_max,class_id,confidence,tracker_id\n1,1,2,2,0,0.9,1\n",
            &["film.txt:1", "frames are missing", "custom_data"][..],
        ),
        (
            "frame,id,x,y,w,h\n1,1,1,1,1,1\n",
            &["film.txt:1", "bb_left"],
        ),
        (
            "[{\"image_id\": \"a\", \"bbox\": [1, 2, 3, 4]}]",
            &["image_id", "frames are missing"],
        ),
        ("{\"info\": 1}", &["no list of detections"]),
        ("[{\"image_id\": 1,", &["film.txt:1", "JSON"]),
    ] {
        let message = read(text, &options()).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
    // Where a pattern is wanted, it is said what the file is.
    for name in [
        "supervision.csv",
        "mot-with-header.csv",
        "yolo-tracker.txt",
        "frames-from-0.txt",
    ] {
        let file = format!("{DATA}{name}");
        let output = common::pickline(&["simulate", "-q", "--pattern", &file]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert!(
            message.contains("pickline pattern import tracks"),
            "{name}: {message}"
        );
    }
}

/// A camera above a belt at 0.25 m/s, 25 frames a second, 2 mm a pixel, 1280 x 600 pixels.
#[derive(Clone, Copy)]
struct Film {
    /// How far the travel is turned from image x, clockwise on the screen [degrees].
    angle: f64,
    /// Radial distortion: by this share inward at half the picture's width.
    barrel: f64,
    /// By this share larger at the right edge than in the middle.
    tilt: f64,
    corners: bool,
    /// Whether the tracker sees every other item in the picture's left half only and the
    /// others in the right: over the whole picture the errors of a lens cancel out.
    halves: bool,
}

const STRAIGHT: Film = Film {
    angle: 0.0,
    barrel: 0.0,
    tilt: 0.0,
    corners: false,
    halves: false,
};

impl Film {
    /// What a tracker writes of it, and the true pattern.
    fn shoot(&self) -> (String, Pattern) {
        let mut rng = random_stream(7, 0);
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        let mut text = String::new();
        let mut items = Vec::new();
        for id in 1..=60u32 {
            let x0 = -0.08 * f64::from(id) - 0.05 * rng.random::<f64>();
            let y = 0.8 * (rng.random::<f64>() - 0.5);
            items.push(pickline::pattern::Item::at(id.to_string(), x0, y));
            for frame in 1..=1000u32 {
                // From the middle of the picture, x along the travel, y down.
                let along = (x0 + 0.01 * f64::from(frame - 1)) / 0.002 - 640.0;
                let aside = -y / 0.002;
                let (u, v) = (cosine * along - sine * aside, sine * along + cosine * aside);
                if self.halves && (along < 0.0) != (id % 2 == 0) {
                    continue;
                }
                let near = 1.0 + self.tilt * u / 640.0;
                let (u, v) = (u * near, v * near);
                let shrink = 1.0 - self.barrel * (u * u + v * v) / (640.0 * 640.0);
                let (u, v) = (u * shrink, v * shrink);
                let mut noise = || 0.6 * (rng.random::<f64>() - 0.5);
                let (x, y) = (u + 640.0 + noise(), v + 300.0 + noise());
                if !(20.0..1260.0).contains(&x) || !(-200.0..800.0).contains(&y) {
                    continue;
                }
                let (left, top) = (x - 20.0, y - 15.0);
                let (w, h) = if self.corners {
                    (left + 40.0, top + 30.0)
                } else {
                    (40.0, 30.0)
                };
                let _ = writeln!(
                    text,
                    "{frame},{id},{left:.2},{top:.2},{w:.2},{h:.2},0.9,-1,-1,-1"
                );
            }
        }
        let first = items
            .iter()
            .map(|item| item.x0)
            .fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = items
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), item| {
                (l.min(item.y), h.max(item.y))
            });
        for item in &mut items {
            item.x0 -= first;
            item.y -= f64::midpoint(low, high);
        }
        (text, Pattern::new(items).unwrap())
    }
}

fn warned(import: &Import, words: &str) -> bool {
    import
        .report
        .warnings
        .iter()
        .any(|warning| warning.contains(words))
}

#[test]
fn a_square_camera_gives_the_truth_without_a_word() {
    let (text, truth) = STRAIGHT.shoot();
    let found = read(&text, &options()).unwrap();
    assert!(apart(&found.pattern, &truth) < 0.002, "{:?}", found.report);
    assert!(
        found.report.warnings.is_empty(),
        "{:?}",
        found.report.warnings
    );
    let motion = found.report.motion.unwrap();
    assert!(
        motion.angle_deg.abs() < 0.02 && (motion.speed - 0.25).abs() < 1e-3,
        "{motion:?}"
    );
    assert_eq!(motion.bent_off_m, 0.0);
}

#[test]
fn a_turned_camera_is_noticed_measured_and_put_right() {
    for angle in [4.0, -7.0] {
        let film = Film { angle, ..STRAIGHT };
        let (text, truth) = film.shoot();
        let message = read(&text, &options()).unwrap_err();
        assert!(message.contains("degrees off --axis"), "{message}");
        let said = message.split("--angle ").nth(1).unwrap();
        let said: f64 = said.split([';', ' ']).next().unwrap().parse().unwrap();
        assert!((said - angle).abs() < 0.1, "{message}");
        let mut turned = options();
        turned.angle_deg = said;
        let found = read(&text, &turned).unwrap();
        assert!(
            apart(&found.pattern, &truth) < 0.003,
            "{angle}: {:?}",
            found.report.warnings
        );
        assert!(
            found.report.warnings.is_empty(),
            "{:?}",
            found.report.warnings
        );
        // The other way round it is twice as wrong.
        turned.angle_deg = -said;
        assert!(read(&text, &turned).is_err());
        let mut accepted = options();
        accepted.accept_mismatch = true;
        let found = read(&text, &accepted).unwrap();
        assert!(warned(&found, "--angle"), "{:?}", found.report.warnings);
        assert!(apart(&found.pattern, &truth) > 0.02);
    }
    let (text, _) = Film {
        angle: 0.6,
        ..STRAIGHT
    }
    .shoot();
    let found = read(&text, &options()).unwrap();
    assert!(warned(&found, "--angle 0.6"), "{:?}", found.report.warnings);
}

#[test]
fn a_wrong_frame_rate_scale_or_speed_is_refused_with_what_would_agree() {
    let (text, truth) = STRAIGHT.shoot();
    let mut fast = options();
    fast.fps = 30.0;
    let message = read(&text, &fast).unwrap_err();
    for words in [
        "0.3000 m/s",
        "given as 0.25",
        "--fps 25 ",
        "--scale 0.00166",
        "--belt-speed 0.3",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
    assert!(!message.contains("0 of 60"), "{message}");
    let mut across = options();
    across.axis = Axis::Y;
    let message = read(&text, &across).unwrap_err();
    assert!(message.contains("give --axis x,"), "{message}");
    let mut coarse = options();
    coarse.scale_m_per_px = 0.0026;
    let message = read(&text, &coarse).unwrap_err();
    assert!(message.contains("--scale 0.00200"), "{message}");
    assert!(
        message.contains("60 of 60 items are more than 25 % off"),
        "{message}"
    );
    let mut slow = options();
    slow.belt_speed = 0.235;
    let found = read(&text, &slow).unwrap();
    assert!(
        warned(&found, "items move at 0.25"),
        "{:?}",
        found.report.warnings
    );
    assert!(apart(&read(&text, &options()).unwrap().pattern, &truth) < 0.002);
}

#[test]
fn corners_taken_for_sizes_are_noticed() {
    let (text, truth) = Film {
        corners: true,
        ..STRAIGHT
    }
    .shoot();
    let message = read(&text, &options()).unwrap_err();
    assert!(message.contains("--boxes corners"), "{message}");
    assert!(!message.contains("--scale"), "{message}");
    let mut corners = options();
    corners.boxes = Boxes::Corners;
    let found = read(&text, &corners).unwrap();
    assert!(
        apart(&found.pattern, &truth) < 0.002,
        "{:?}",
        found.report.warnings
    );
    assert!(
        found.report.warnings.is_empty(),
        "{:?}",
        found.report.warnings
    );
    assert!((found.pattern.items()[0].area_cm2.unwrap() - 48.0).abs() < 0.1);
    let (sizes, _) = STRAIGHT.shoot();
    let message = read(&sizes, &corners).unwrap_err();
    assert!(message.contains("by its corners"), "{message}");
}

#[test]
fn lenses_that_bend_and_cameras_that_tilt_are_noticed() {
    for (film, cause) in [
        (
            Film {
                barrel: 0.05,
                halves: true,
                ..STRAIGHT
            },
            "lens",
        ),
        (
            Film {
                barrel: -0.05,
                halves: true,
                ..STRAIGHT
            },
            "lens",
        ),
        (
            Film {
                tilt: 0.06,
                halves: true,
                ..STRAIGHT
            },
            "tilted",
        ),
    ] {
        let (text, truth) = film.shoot();
        let mut accepted = options();
        accepted.accept_mismatch = true;
        let found = read(&text, &accepted).unwrap();
        assert!(warned(&found, cause), "{cause}: {:?}", found.report);
        assert!(warned(&found, "undistort"), "{:?}", found.report.warnings);
        let said = found.report.motion.unwrap().bent_off_m;
        assert!(said > 0.005, "{said}");
        let off = apart(&found.pattern, &truth);
        assert!(off > 0.003, "{off}");
    }
    let (text, _) = Film {
        barrel: 0.3,
        ..STRAIGHT
    }
    .shoot();
    let message = read(&text, &options()).unwrap_err();
    assert!(message.contains("lens"), "{message}");
}

#[test]
fn the_program_imports_films() {
    let file = |name: &str| format!("{DATA}{name}");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.csv");
    let out = out.to_str().unwrap();
    let film = [
        "--fps",
        "25",
        "--scale",
        "0.002",
        "--axis",
        "x",
        "--belt-speed",
        "0.25",
    ];
    let labels = [file("ultralytics-labels")];
    let run = |verb: &str, file: &str, more: &[&str]| {
        let words = [&["pattern", "import", verb, file][..], &film, more].concat();
        let output = common::pickline(&words);
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for verb in ["tracks", "mot"] {
        let (code, said) = run(verb, &file("supervision.csv"), &["-o", out]);
        assert_eq!(code, Some(0), "{said}");
        assert!(said.contains("CSV with a header"), "{said}");
        assert!(std::fs::read_to_string(out).unwrap().contains(",PET"));
        std::fs::remove_file(out).unwrap();
    }
    let (code, said) = run(
        "tracks",
        &labels[0],
        &["--image-size", "1280x400", "-o", out],
    );
    assert_eq!(code, Some(0), "{said}");
    for (flags, word) in [
        (&["--image-size", "1280"][..], "--image-size"),
        (&["--image-size", "0x400"], "--image-size"),
        (&["--as", "mott"], "did you mean `mot`"),
        (&["--angle", "90"], "--angle"),
        (&["--boxes", "middle"], "--boxes"),
    ] {
        let (code, said) = run("tracks", &labels[0], flags);
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains(word), "{word} not in {said}");
    }
}
