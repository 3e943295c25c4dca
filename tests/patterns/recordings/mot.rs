//! MOTChallenge lines and their many habits.

use super::{apart, classes, load, options, read, rows};
use std::fmt::Write as _;

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
            !classed && remarks.contains("column 8 is not a class"),
            "{remarks}"
        );
    }
}

#[test]
fn mot_files_in_other_forms_are_read_or_refused_with_the_reason() {
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
        assert!(message.contains("'image_size'"), "{message}");
    }
}
