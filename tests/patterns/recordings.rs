//! Recordings of cameras: every form of file, and films of which the truth is known.

use crate::common;
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

/// The film as MOT lines: the id or the frame first, the box by `box_of`, then `more`.
fn mot(
    swapped: bool,
    box_of: impl Fn([f64; 4]) -> String,
    more: impl Fn(usize, u32) -> String,
) -> String {
    let mut text = String::new();
    for (index, (frame, id, class, [x1, y1, x2, y2])) in rows().into_iter().enumerate() {
        let (one, two) = if swapped { (id, frame) } else { (frame, id) };
        let figures = box_of([x1, y1, x2 - x1, y2 - y1]);
        let _ = writeln!(text, "{one},{two},{figures},0.9{}", more(index, class));
    }
    text
}

fn sizes([left, top, width, height]: [f64; 4]) -> String {
    format!("{left:.2},{top:.2},{width:.2},{height:.2}")
}

#[test]
fn column_8_is_a_class_by_the_form_that_most_lines_have() {
    let some = |form: &dyn Fn(usize, u32) -> String| {
        let made = read(&mot(false, sizes, form), &options()).unwrap();
        let classed = !classes(&made.pattern)[0].is_empty();
        (classed, made.report.remarks.concat())
    };
    let names = ["PET", "PE", "can"];
    let forms: [&dyn Fn(usize, u32) -> String; 5] = [
        &|index, class| match index {
            7 => ",-1".to_owned(),
            _ => format!(",{class}"),
        },
        &|_, class| format!(",{}", names[class as usize]),
        &|_, class| format!(",{class},1,extra"),
        &|_, class| format!(",{class},0.8,12"),
        &|index, class| match index {
            7 => ",0.5".to_owned(),
            _ => format!(",{class},-1,-1"),
        },
    ];
    for form in forms {
        let (classed, remarks) = some(form);
        assert!(
            classed && remarks.contains("classes from column 8"),
            "{remarks}"
        );
    }
    let (classed, remarks) = some(&|_, _| ",-1,-1,-1".to_owned());
    assert!(!classed && !remarks.contains("column 8"), "{remarks}");
    for form in [&|_, class| format!(",{class},4.5,3"), &|_, class| {
        format!(",{class}.25,0.5,3")
    }] as [&dyn Fn(usize, u32) -> String; 2]
    {
        let (classed, remarks) = some(form);
        assert!(
            !classed && remarks.contains("column 8 is not read as a class"),
            "{remarks}"
        );
    }
}

#[test]
fn mot_files_of_other_habits_are_read_or_refused_by_what_they_are() {
    let nothing = |_: usize, _: u32| ",-1,-1,-1".to_owned();
    let plain = read(&mot(false, sizes, nothing), &options())
        .unwrap()
        .pattern;
    let semicolons = mot(false, sizes, nothing)
        .replace(',', ";")
        .replace('.', ",");
    let read_so = read(&semicolons, &options()).unwrap();
    assert_eq!(read_so.pattern, plain);
    let tabs = semicolons.replace(';', "\t");
    assert_eq!(read(&tabs, &options()).unwrap().pattern, plain);

    let message = read(&mot(true, sizes, nothing), &options()).unwrap_err();
    assert!(
        message.contains("id and frame, not frame and id"),
        "{message}"
    );

    for (text, words) in [
        (
            "<?xml version=\"1.0\"?>\n<annotations></annotations>",
            "CVAT's XML",
        ),
        ("<annotation><object/></annotation>", "Pascal VOC's XML"),
        (
            "0 1 Car 0 0 -10 1.4 248.1 33.4 268.1 -1 -1 -1 -1000 -1000 -1000 -10 0.6\n",
            "KITTI's tracking labels",
        ),
        (
            "Car 0 0 -10 1.4 248.1 33.4 268.1 -1 -1 -1 -1000 -1000 -1000 -10\n",
            "KITTI's object",
        ),
    ] {
        let message = read(text, &options()).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn shares_of_the_picture_are_scaled_whatever_the_form() {
    let tracked = load("supervision.csv", &options()).unwrap().pattern;
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    let shares = |[x, y, w, h]: [f64; 4]| {
        let [x, w] = [x / 1280.0, w / 1280.0];
        let [y, h] = [y / 400.0, h / 400.0];
        format!("{x:.7},{y:.7},{w:.7},{h:.7}")
    };
    let plain = mot(false, shares, |_, _| String::new());
    let table = format!("frame,id,bb_left,bb_top,bb_width,bb_height,conf\n{plain}");
    let coco: Vec<serde_json::Value> = rows()
        .into_iter()
        .map(|(frame, id, _, [x1, y1, x2, y2])| {
            let figures = [
                x1 / 1280.0,
                y1 / 400.0,
                (x2 - x1) / 1280.0,
                (y2 - y1) / 400.0,
            ];
            serde_json::json!({"image_id": frame, "track_id": id, "bbox": figures, "score": 0.9})
        })
        .collect();
    for text in [plain, table, serde_json::Value::from(coco).to_string()] {
        let made = read(&text, &sized).unwrap();
        assert!(apart(&made.pattern, &tracked) < 1e-3, "{:#?}", made.report);
        let message = read(&text, &options()).unwrap_err();
        assert!(message.contains("--image-size"), "{message}");
    }
}

#[test]
fn json_of_other_habits_is_read() {
    let tracked = load("supervision.csv", &options()).unwrap();
    let sink: Vec<serde_json::Value> = rows()
        .into_iter()
        .map(|(frame, id, _, [x1, y1, x2, y2])| {
            serde_json::json!({
                "x_min": x1.to_string(), "y_min": y1.to_string(), "x_max": x2.to_string(),
                "y_max": y2.to_string(), "class_id": "0", "confidence": "0.9",
                "tracker_id": id.to_string(), "frame": frame
            })
        })
        .collect();
    let made = read(&serde_json::Value::from(sink).to_string(), &options()).unwrap();
    assert!(apart(&made.pattern, &tracked.pattern) < 1e-9);

    // Ids against the film, whose order the names have.
    let frames: std::collections::BTreeSet<u32> = rows().iter().map(|row| row.0).collect();
    let images: Vec<serde_json::Value> = frames
        .iter()
        .map(|frame| serde_json::json!({"id": 5000 - frame, "file_name": format!("a/f_{frame:05}_v2.png")}))
        .collect();
    let boxes: Vec<serde_json::Value> = rows()
        .into_iter()
        .map(|(frame, _, _, [x1, y1, x2, y2])| {
            serde_json::json!({"image_id": 5000 - frame, "bbox": [x1, y1, x2 - x1, y2 - y1]})
        })
        .collect();
    let data = serde_json::json!({"images": images, "annotations": boxes}).to_string();
    let made = read(&data, &options()).unwrap();
    assert!(
        apart(&made.pattern, &tracked.pattern) < 1e-3,
        "{:#?}",
        made.report
    );
    assert!(
        made.report.remarks.concat().contains("file_name"),
        "{:?}",
        made.report.remarks
    );
}

#[test]
fn labels_are_known_by_the_number_that_differs_and_confidences_of_1_are_no_ids() {
    let tracked = load("supervision.csv", &options()).unwrap().pattern;
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    let import_as = |name: &dyn Fn(u32) -> String, sixth: &str| {
        let folder = tempfile::tempdir().unwrap();
        let mut texts = std::collections::BTreeMap::<u32, String>::new();
        for (frame, _, class, [x1, y1, x2, y2]) in rows() {
            let text = texts.entry(frame).or_default();
            let [x, w] = [(x1 + x2) / 2560.0, (x2 - x1) / 1280.0];
            let [y, h] = [(y1 + y2) / 800.0, (y2 - y1) / 400.0];
            let _ = writeln!(text, "{class} {x:.7} {y:.7} {w:.7} {h:.7}{sixth}");
        }
        for (frame, text) in texts {
            std::fs::write(folder.path().join(name(frame)), text).unwrap();
        }
        let recording = Recording::load(folder.path()).map_err(|error| error.to_string())?;
        import(&recording, "labels", &sized).map_err(|error| error.to_string())
    };
    let names: [&dyn Fn(u32) -> String; 4] = [
        &|frame| format!("shot_{frame}_v2.txt"),
        &|frame| format!("cam2-{frame:06}_2024.txt"),
        &|frame| format!("img-{}.txt", 1_700_000_000_000_u64 + 40 * u64::from(frame)),
        &|frame| format!("f{frame}_jpg.rf.{}.txt", ["a1b", "77c"][frame as usize % 2]),
    ];
    for name in names {
        let made = import_as(name, "").unwrap();
        let first = tracked.items()[0].x0 - made.pattern.items()[0].x0;
        assert!(
            first.abs() < 1e-9 && apart(&made.pattern, &tracked) < 1e-3,
            "{}",
            name(1)
        );
    }
    let made = import_as(&|frame| format!("f_{frame}.txt"), " 1").unwrap();
    assert!(apart(&made.pattern, &tracked) < 1e-3, "{:#?}", made.report);
    assert_eq!(made.pattern.items()[0].p_detection, Some(1.0));
    let made = import_as(&|frame| format!("f_{frame}.txt"), " 7").unwrap();
    assert!(
        made.report.remarks.concat().contains("is not read"),
        "{:#?}",
        made.report
    );
    let uneven = |frame: u32| {
        format!(
            "{}.txt",
            1_700_000_000_000_u64 + 1013 * u64::from(frame).pow(2) + 7 * u64::from(frame)
        )
    };
    assert!(
        import_as(&uneven, "")
            .unwrap_err()
            .contains("stamps of time")
    );
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
fn a_turned_camera_is_not_taken_for_a_wrong_scale() {
    for angle in [-30.0, 45.0, 60.0] {
        let (text, _) = Film { angle, ..STRAIGHT }.shoot();
        let message = read(&text, &options()).unwrap_err();
        assert!(
            message.contains("give --angle ") && !message.contains("--scale"),
            "{message}"
        );
    }
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
    assert!(message.contains("--scale 0.002"), "{message}");
    assert!(
        message.contains("60 of 60 items are more than 25 % off"),
        "{message}"
    );
    // Places add up over the film: 4 % are a wrong pattern, well below 1 % are warned of.
    let mut nearly = options();
    nearly.fps = 24.0;
    let message = read(&text, &nearly).unwrap_err();
    for words in ["--fps 25 ", "puts items up to 0.19", "--belt-speed 0.24"] {
        assert!(message.contains(words), "{words} not in {message}");
    }
    let mut slow = options();
    slow.belt_speed = 0.248;
    let found = read(&text, &slow).unwrap();
    assert!(
        warned(&found, "items move at 0.25") && warned(&found, " m off"),
        "{:?}",
        found.report.warnings
    );
    // What is said to agree does.
    slow.belt_speed = 0.24;
    let message = read(&text, &slow).unwrap_err();
    let said = message.split("--belt-speed ").nth(1).unwrap();
    slow.belt_speed = said.split(' ').next().unwrap().parse().unwrap();
    let found = read(&text, &slow).unwrap();
    assert!(
        found.report.warnings.is_empty(),
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
    corners.boxes = Some(Boxes::Corners);
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
    corners.boxes = Some(Boxes::Centres);
    let message = read(&text, &corners).unwrap_err();
    assert!(message.contains("--boxes corners"), "{message}");
    corners.boxes = Some(Boxes::Corners);
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

/// COCO's detections, without ids, of 30 items on a belt at 0.2 m/s, 20 frames a second, 1 mm
/// a pixel, whose travel is turned by quarter turns; `sparse` keeps every third item.
fn detections(turns: usize, sparse: bool, corners: bool) -> String {
    let mut rng = random_stream(3, 0);
    let mut boxes = Vec::new();
    for item in 0..30 {
        let x0 = -0.12 * f64::from(item) - 0.1 * rng.random::<f64>();
        let y = 0.4 * (rng.random::<f64>() - 0.5);
        for frame in 1..600 {
            let along = (x0 + 0.01 * f64::from(frame)) / 0.001;
            if !(20.0..980.0).contains(&along) || (sparse && item % 3 > 0) {
                continue;
            }
            let across = 500.0 + y / 0.001;
            let (x, y) = match turns {
                0 => (along, across),
                1 => (across, along),
                2 => (1000.0 - along, across),
                _ => (across, 1000.0 - along),
            };
            let (left, top) = (x - 20.0, y - 15.0);
            let (w, h) = match corners {
                true => (x + 20.0, y + 15.0),
                false => (40.0, 30.0),
            };
            boxes.push(serde_json::json!({
                "image_id": frame, "category_id": 0, "bbox": [left, top, w, h], "score": 0.9
            }));
        }
    }
    serde_json::Value::from(boxes).to_string()
}

#[test]
fn boxes_without_tracks_that_travel_another_way_are_refused_with_the_way() {
    let ways = [
        (Axis::X, false, "--axis x without --reverse"),
        (Axis::Y, false, "--axis y without --reverse"),
        (Axis::X, true, "--axis x with --reverse"),
        (Axis::Y, true, "--axis y with --reverse"),
    ];
    for sparse in [false, true] {
        for (turns, (.., cure)) in ways.iter().enumerate() {
            let text = detections(turns, sparse, false);
            for (given, (axis, reverse, _)) in ways.iter().enumerate() {
                let mut options = Options::new(20.0, 0.001, *axis, 0.2);
                options.reverse = *reverse;
                let found = read(&text, &options);
                if given == turns {
                    let items = found.unwrap().pattern.len();
                    assert_eq!(items, if sparse { 10 } else { 30 }, "{turns}");
                    continue;
                }
                let message = found.unwrap_err();
                assert!(message.contains(cure), "{turns} {given}: {message}");
                options.accept_mismatch = true;
                if let Ok(found) = read(&text, &options) {
                    assert!(warned(&found, cure), "{:?}", found.report.warnings);
                }
            }
        }
    }
}

#[test]
fn more_tracks_backwards_than_forwards_are_refused() {
    let (text, _) = STRAIGHT.shoot();
    // One thing that moves the way given must not make a pattern of the rest.
    let mut film: Vec<String> = text.lines().map(str::to_owned).collect();
    for frame in 1..60 {
        let left = 1100 - 5 * frame;
        film.push(format!("{frame},999,{left},900,40,30,0.9,-1,-1,-1"));
    }
    let mut reverse = options();
    reverse.reverse = true;
    let message = read(&film.join("\n"), &reverse).unwrap_err();
    for words in [
        "60 tracks travel backwards, and 1 item",
        "leave out --reverse",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
}

#[test]
fn corners_in_coco_are_noticed_and_read() {
    let text = detections(0, false, true);
    let mut options = Options::new(20.0, 0.001, Axis::X, 0.2);
    let message = read(&text, &options).unwrap_err();
    assert!(message.contains("give --boxes corners"), "{message}");
    options.boxes = Some(Boxes::Corners);
    let found = read(&text, &options).unwrap();
    assert_eq!(found.pattern.len(), 30);
    assert!((found.pattern.items()[0].area_cm2.unwrap() - 12.0).abs() < 1e-6);
    // Sizes are not taken for corners, and messages hold no noise of the last digits.
    let message = read(&detections(0, false, false), &options).unwrap_err();
    assert!(message.contains("leave out --boxes"), "{message}");
    assert!(!message.contains("0000000"), "{message}");
}

#[test]
fn boxes_that_the_form_says_cannot_be_others() {
    let mut sized = options();
    sized.image_size = Some((1280.0, 400.0));
    for (name, own) in [
        ("supervision.csv", Boxes::Corners),
        ("mot-with-header.csv", Boxes::Sizes),
        ("ultralytics-labels", Boxes::Centres),
    ] {
        for boxes in [Boxes::Sizes, Boxes::Corners, Boxes::Centres] {
            sized.boxes = Some(boxes);
            let found = load(name, &sized);
            if boxes == own {
                assert!(found.is_ok(), "{name}: {found:?}");
            } else {
                let message = found.unwrap_err();
                assert!(message.starts_with("--boxes"), "{message}");
            }
        }
    }
}

/// A tracker's text of `items` on a belt that has moved by `moved` metres at a time [s], at
/// 0.2 m/s and 20 frames a second, 1 mm a pixel.
fn moving_film(items: u32, moved: impl Fn(f64) -> f64) -> String {
    let mut rng = random_stream(5, 0);
    let mut text = String::new();
    for id in 1..=items {
        let x0 = -0.1 * f64::from(id) - 0.05 * rng.random::<f64>();
        let top = 800.0 * rng.random::<f64>();
        for frame in 1..2000u32 {
            let along = (x0 + moved(f64::from(frame - 1) / 20.0)) / 0.001;
            let mut noise = || rng.random::<f64>() - 0.5;
            let (left, top) = (along + noise(), top + noise());
            if (0.0..1500.0).contains(&left) {
                let _ = writeln!(text, "{frame},{id},{left:.2},{top:.2},40,30,0.9,-1,-1,-1");
            }
        }
    }
    text
}

#[test]
fn a_belt_that_changes_its_speed_is_named_and_refused() {
    let options = Options::new(20.0, 0.001, Axis::X, 0.2);
    let steady = moving_film(80, |t| 0.2 * t);
    let found = read(&steady, &options).unwrap();
    let motion = found.report.motion.unwrap();
    assert_eq!(motion.unsteady_off_m, 0.0, "{motion:?}");
    let stops = |t: f64| 0.2 * (t - (t - 20.0).clamp(0.0, 5.0));
    let speeds_up = |t: f64| 0.2 * t + 0.005 * t * t / 2.0;
    let slower = |t: f64| 0.2 * t - 0.05 * (t - 25.0).max(0.0);
    let sways = |t: f64| 0.2 * t + 0.1 * (0.6 * t).sin();
    let films: [&dyn Fn(f64) -> f64; 4] = [&stops, &speeds_up, &slower, &sways];
    for (number, moved) in films.into_iter().enumerate() {
        let text = moving_film(80, moved);
        let message = read(&text, &options).unwrap_err();
        for words in [
            "changes its speed during the recording",
            "cut out of the film",
        ] {
            assert!(
                message.contains(words),
                "{number}: {words} not in {message}"
            );
        }
        for words in ["lens", "tilted", "--belt-speed"] {
            assert!(!message.contains(words), "{number}: {words} in {message}");
        }
    }
}

#[test]
fn angles_are_those_in_the_picture() {
    let film = Film {
        angle: 2.0,
        ..STRAIGHT
    };
    let (text, _) = film.shoot();
    let mut turned = options();
    turned.angle_deg = 2.0;
    let lines = read(&text, &turned).unwrap().report.lines();
    let said = |words: &str| lines.iter().any(|line| line.contains(words));
    assert!(said("travels at 2.0") && !said("-0.00"), "{lines:?}");
    turned.angle_deg = -2.0;
    let message = read(&text, &turned).unwrap_err();
    for words in [
        "travels 2.0",
        "not at -2 as given by --angle",
        "give --angle 2.0",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
}

#[test]
fn strict_and_quiet_do_not_pass_over_a_pattern_that_is_off() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (text, _) = Film {
        angle: 0.6,
        ..STRAIGHT
    }
    .shoot();
    std::fs::write(path("film.txt"), text).unwrap();
    let run = |more: &[&str]| {
        let (film, out) = (path("film.txt"), path("p.csv"));
        let words = [
            "pattern",
            "import",
            "tracks",
            &film,
            "--fps",
            "25",
            "--scale",
            "0.002",
            "--axis",
            "x",
            "--belt-speed",
            "0.25",
            "-o",
            &out,
        ];
        let output = common::pickline(&[&words[..], more].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    };
    let (code, said) = run(&["--strict"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("--angle 0.6"), "{said}");
    assert!(!Path::new(&path("p.csv")).exists());
    let (code, said) = run(&["-q"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.starts_with("warning: ") && said.contains("--angle 0.6"),
        "{said}"
    );
    assert!(!said.contains("centre line"), "{said}");
    for (flag, metres) in [("--split-distance", "100"), ("--merge-distance", "20")] {
        let (code, said) = run(&["--strict", flag, metres]);
        assert_eq!(code, Some(2), "{said}");
        assert!(
            said.contains(flag) && said.contains("millimetres"),
            "{said}"
        );
    }
}

#[test]
fn no_output_goes_into_the_folder_of_labels() {
    let folder = tempfile::tempdir().unwrap();
    let labels = folder.path().join("labels");
    std::fs::create_dir(&labels).unwrap();
    let from = format!("{DATA}ultralytics-labels");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), labels.join(entry.file_name())).unwrap();
        names.push(entry.file_name());
    }
    names.sort();
    let film = labels.display().to_string();
    for name in [names[0].to_str().unwrap(), "new_7.txt"] {
        let before = std::fs::read(labels.join(name)).ok();
        let out = labels.join(name).display().to_string();
        let output = common::pickline(&[
            "pattern",
            "import",
            "tracks",
            &film,
            "--image-size",
            "1280x400",
            "--fps",
            "25",
            "--scale",
            "0.002",
            "--axis",
            "x",
            "--belt-speed",
            "0.25",
            "-o",
            &out,
            "--force",
        ]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("folder of the recording"), "{said}");
        assert_eq!(std::fs::read(labels.join(name)).ok(), before);
    }
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
