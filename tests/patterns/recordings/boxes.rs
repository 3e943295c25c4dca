//! What the four figures of a box are.

use super::film::{Film, STRAIGHT, detections};
use super::{apart, load, options, read};
use pickline::pattern::tracking::{Boxes, ImageAxis, ImportOptions};

#[test]
fn corners_taken_for_sizes_are_noticed() {
    let (text, truth) = Film {
        corners: true,
        ..STRAIGHT
    }
    .shoot();
    let message = read(&text, &options()).unwrap_err();
    assert!(message.contains("'boxes' corners"), "{message}");
    assert!(!message.contains("'scale_m_per_px'"), "{message}");
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
    assert!(message.contains("'boxes' corners"), "{message}");
    corners.boxes = Some(Boxes::Corners);
    let (sizes, _) = STRAIGHT.shoot();
    let message = read(&sizes, &corners).unwrap_err();
    assert!(message.contains("by its corners"), "{message}");
}

#[test]
fn corners_in_coco_are_noticed_and_read() {
    let text = detections(0, false, true);
    let mut options = ImportOptions::new(20.0, 0.001, ImageAxis::X, 0.2);
    let message = read(&text, &options).unwrap_err();
    assert!(message.contains("give 'boxes' corners"), "{message}");
    options.boxes = Some(Boxes::Corners);
    let found = read(&text, &options).unwrap();
    assert_eq!(found.pattern.len(), 30);
    assert!((found.pattern.items()[0].area_cm2.unwrap() - 12.0).abs() < 1e-6);
    // Sizes are not taken for corners, and messages hold no noise of the last digits.
    let message = read(&detections(0, false, false), &options).unwrap_err();
    assert!(message.contains("omit 'boxes'"), "{message}");
    assert!(!message.contains("0000000"), "{message}");
}

/// A box said to grow with its travel shrinks where items travel towards smaller pixels.
#[test]
fn corners_are_noticed_whichever_way_the_belt_travels() {
    let (text, _) = Film {
        angle: 180.0,
        corners: true,
        ..STRAIGHT
    }
    .shoot();
    let mut reverse = options();
    reverse.reverse = true;
    let message = read(&text, &reverse).unwrap_err();
    assert!(message.contains("'boxes' corners"), "{message}");
    let ways = [
        (ImageAxis::X, false),
        (ImageAxis::Y, false),
        (ImageAxis::X, true),
        (ImageAxis::Y, true),
    ];
    for (turns, (axis, reverse)) in ways.into_iter().enumerate() {
        let text = detections(turns, false, true);
        let mut options = ImportOptions::new(20.0, 0.001, axis, 0.2);
        options.reverse = reverse;
        let message = read(&text, &options).unwrap_err();
        assert!(message.contains("'boxes' corners"), "{turns}: {message}");
        options.boxes = Some(Boxes::Corners);
        assert_eq!(read(&text, &options).unwrap().pattern.len(), 30, "{turns}");
    }
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
                assert!(message.starts_with("'boxes'"), "{message}");
            }
        }
    }
}
