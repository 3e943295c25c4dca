//! Forms of files: CSV with a header, JSON, folders of labels, and what is none of them.

use super::{DATA, apart, classes, load, options, read, rows};
use crate::common;
use pickline::pattern::tracking::{Recording, import};
use std::fmt::Write as _;

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
    assert!(labels.pattern.len() <= plain.pattern.len());
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
fn json_in_other_forms_is_read() {
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
        made.report.remarks.concat().contains("is ignored"),
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
            .contains("evenly spaced timestamps")
    );
}

#[test]
fn ambiguous_columns_are_refused_by_name() {
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
    assert!(message.contains("'image_size'"), "{message}");
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
        ("{\"info\": 1}", &["neither a list of detections"]),
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
