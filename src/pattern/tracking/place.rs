//! Converts objects to items: their attributes, and the belt frame.

use super::median::median_of;
use super::object::Object;
use super::options::ImportOptions;
use super::report::ImportReport;
use super::track::BoxSighting;
use crate::pattern::Item;

/// An object slower than this share of the belt speed does not ride on the belt. One whose speed is
/// off by more than this share does, but some given value may be wrong.
pub(super) const ODD_SHARE: f64 = 0.25;
/// Objects beyond this distance [m] or area [cm^2] come from a wrong option. Two such positions are
/// still less than 1e6 m apart, the maximum length of a pattern.
const FURTHEST: f64 = 4e5;
const LARGEST_AREA: f64 = 1e10;

pub(super) const STILL: &str = "stands still";
pub(super) const BACKWARDS: &str = "moves backwards";
/// Start of the reason for dropping a track that was seen too rarely.
pub(super) const FEWER: &str = "fewer than";

/// What is known about an object before the frame is fixed.
pub(super) struct Found {
    pub item: Item,
    /// Position across the travel, as the image counts it [px].
    pub across: f64,
    /// Speed measured along the travel [m/s].
    pub speed: Option<f64>,
    /// Middle of the time during which it was seen [s].
    pub time: f64,
}

impl Found {
    pub(super) fn new(object: &Object, speed: Option<f64>, options: &ImportOptions) -> Self {
        let seen = &object.track.sightings;
        let scale = options.scale_m_per_px;
        let sure: Vec<f64> = seen
            .iter()
            .filter_map(|s| s.confidence)
            .filter(|p| (0.0..=1.0).contains(p))
            .collect();
        let mut item = Item::at(object.track.name.clone(), object.track.x0(options), 0.0);
        item.area_cm2 =
            median_of(seen.iter().filter_map(BoxSighting::area)).map(|a| a * scale * scale * 1e4);
        // Rounding may push the mean of ones above 1.
        let mean = |p: &[f64]| (p.iter().sum::<f64>() / p.len() as f64).clamp(0.0, 1.0);
        item.p_detection = (!sure.is_empty()).then(|| mean(&sure));
        item.class = most_frequent(seen);
        Self {
            item,
            across: object.track.across(),
            speed,
            time: median_of(seen.iter().map(|s| f64::from(s.frame))).unwrap_or_default()
                / options.fps,
        }
    }

    /// Whether it can only result from a wrong option.
    pub(super) fn is_absurd(&self, options: &ImportOptions) -> bool {
        let aside = self.across * options.scale_m_per_px;
        let area = self.item.area_cm2.unwrap_or_default();
        self.item.x0.abs() > FURTHEST || aside.abs() > FURTHEST || area > LARGEST_AREA
    }
}

/// The class of most boxes; on a tie, the one seen first.
fn most_frequent(seen: &[BoxSighting]) -> Option<String> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for class in seen.iter().filter_map(|s| s.class.as_deref()) {
        match counts.iter_mut().find(|(known, _)| *known == class) {
            Some((_, count)) => *count += 1,
            None => counts.push((class, 1)),
        }
    }
    let most = counts.iter().map(|(_, count)| *count).max()?;
    let found = counts.iter().find(|(_, count)| *count == most);
    found.map(|(class, _)| (*class).trim().replace(['\n', '\r'], " "))
}

/// Why an object with this speed does not ride on the belt. A slight backward motion still counts
/// as standing still, since a measurement is never exactly 0.
pub(super) fn not_riding(speed: Option<f64>, options: &ImportOptions) -> Option<&'static str> {
    let least = ODD_SHARE * options.belt_speed;
    match speed? {
        v if v <= -least => Some(BACKWARDS),
        v if v < least => Some(STILL),
        _ => None,
    }
}

/// Fixes the belt frame: y from the centre line, and x0 from the item furthest downstream.
pub(super) fn place(
    found: Vec<Found>,
    report: &mut ImportReport,
    options: &ImportOptions,
) -> Vec<Item> {
    let across = found.iter().map(|f| f.across);
    let (least, most) = (
        across.clone().fold(f64::INFINITY, f64::min),
        across.fold(f64::NEG_INFINITY, f64::max),
    );
    report.centre_px = options
        .centre_px
        .unwrap_or_else(|| f64::midpoint(least, most));
    let furthest = found
        .iter()
        .map(|f| f.item.x0)
        .fold(f64::NEG_INFINITY, f64::max);
    // Adding 0 turns negative zero into zero.
    report.shift_m = -furthest + 0.0;
    let finish = |mut found: Found| {
        found.item.x0 -= furthest;
        let left = options.left() * (found.across - report.centre_px);
        found.item.y = left * options.scale_m_per_px + 0.0;
        found.item
    };
    found.into_iter().map(finish).collect()
}

#[cfg(test)]
mod tests {
    use super::super::import::import_text as import;
    use super::super::{ImageAxis, Import, ImportOptions};
    use proptest::prelude::*;
    use std::fmt::Write;

    /// 10 frames per second, 1 mm per pixel: the belt moves 10 px per frame.
    fn options() -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1)
    }

    fn ids(import: &Import) -> Vec<&str> {
        let items = import.pattern.items();
        items.iter().map(|item| item.id.as_str()).collect()
    }

    fn has(lines: &[String], words: &str) -> bool {
        lines.iter().any(|line| line.contains(words))
    }

    #[test]
    fn a_clean_file_gives_places_areas_and_probabilities() {
        let mut text = String::new();
        for frame in 1..=20 {
            let left = 280 + 10 * frame;
            let _ = writeln!(text, "{frame},1,{left},90,40,20,0.8,-1,-1,-1");
            let (frame, left) = (frame + 4, left - 110);
            let _ = writeln!(text, "{frame},2,{left},170,40,20,0.8,-1,-1,-1");
        }
        let result = import(&text, "t.txt", &options()).unwrap();
        let items = result.pattern.items();
        assert_eq!(ids(&result), ["1", "2"]);
        assert_eq!(items[0].x0, 0.0);
        assert!((items[1].x0 + 0.15).abs() < 1e-12);
        assert!((items[0].y - 0.04).abs() < 1e-12 && (items[1].y + 0.04).abs() < 1e-12);
        assert!((items[0].area_cm2.unwrap() - 8.0).abs() < 1e-12);
        assert!((items[0].p_detection.unwrap() - 0.8).abs() < 1e-12);
        let report = &result.report;
        assert_eq!((report.lines, report.tracks, report.items), (40, 2, 2));
        assert_eq!((report.centre_px, report.centre_given), (140.0, false));
        // At frame 1, which is time 0, the first one was at pixel 310.
        assert!((report.shift_m + 0.31).abs() < 1e-12);
        assert!((report.measured_speed.unwrap() - 0.1).abs() < 1e-12);
        assert!(report.warnings.is_empty() && report.dropped.is_empty());
        assert!(has(&report.lines(), "pixel 140.00, the middle between"));
    }

    #[test]
    fn every_direction_gives_the_same_pattern_turned() {
        // On the screen, item 1 leads by 100 px and lies 30 px to the left of item 2.
        for (axis, reverse, travel, left) in [
            (ImageAxis::X, false, (1.0, 0.0), (0.0, -1.0)),
            (ImageAxis::X, true, (-1.0, 0.0), (0.0, 1.0)),
            (ImageAxis::Y, false, (0.0, 1.0), (1.0, 0.0)),
            (ImageAxis::Y, true, (0.0, -1.0), (-1.0, 0.0)),
        ] {
            let mut text = String::new();
            for frame in 1..=10 {
                for (id, ahead, beside) in [(1, 100.0, 30.0), (2, 0.0, 0.0)] {
                    let ahead = ahead + 10.0 * f64::from(frame);
                    let x = 500.0 + ahead * travel.0 + beside * left.0;
                    let y = 500.0 + ahead * travel.1 + beside * left.1;
                    let _ = writeln!(text, "{frame},{id},{x},{y},-1,-1,1");
                }
            }
            let mut options = options();
            options.axis = axis;
            options.reverse = reverse;
            options.centre_px = Some(500.0);
            let result = import(&text, "t", &options).unwrap();
            let places: Vec<_> = result.pattern.items().iter().map(|i| (i.x0, i.y)).collect();
            let expected = [(0.0, 0.03), (-0.1, 0.0)];
            for ((x0, y), (x, across)) in places.into_iter().zip(expected) {
                assert!((x0 - x).abs() < 1e-12, "{axis:?} {reverse}: x {x0}");
                assert!((y - across).abs() < 1e-12, "{axis:?} {reverse}: y {y}");
            }
            assert_eq!(ids(&result), ["1", "2"]);
            assert!(has(&result.report.lines(), "pixel 500.00, as given"));
            // With the opposite direction, everything moves backwards.
            options.reverse = !reverse;
            let message = import(&text, "t", &options).unwrap_err().to_string();
            assert!(message.contains("'reverse'"), "{message}");
        }
    }

    #[test]
    fn confidences_outside_0_to_1_are_left_out() {
        let text = "1,1,0,50,-1,-1,-1\n2,1,10,50,-1,-1,37.5\n3,1,20,50,-1,-1\n\
                    1,2,0,90,4,4,0\n2,2,10,90,4,4,0.5\n3,2,20,90,4,4,7\n";
        let result = import(text, "t.txt", &options()).unwrap();
        let item = |id: &str| result.pattern.items().iter().find(|i| i.id == id).unwrap();
        assert_eq!((item("1").p_detection, item("1").area_cm2), (None, None));
        assert_eq!(item("2").p_detection, Some(0.25));
        let report = &result.report;
        assert_eq!((report.points, report.no_confidence), (3, 4));
        assert_eq!(report.zero_confidence, 1);
        assert!(has(&report.lines(), "1 box with confidence 0: kept"));
    }

    /// A classifier is wrong now and then, so a single box says little.
    #[test]
    fn the_class_is_the_one_of_most_boxes_and_of_equals_the_first() {
        let mut text = "frame,tracker_id,x_min,y_min,x_max,y_max,class_name\n".to_owned();
        for (id, classes) in [
            (1, &["PE", "PET", "PET"][..]),
            (2, &["PE", "PET", "PET", "PE"]),
            (3, &["glass", "", "PET", "PET", "glass", "glass"]),
        ] {
            for (frame, class) in classes.iter().enumerate() {
                let (left, top) = (400 - 100 * id + 10 * frame, 100 * id);
                let (right, bottom) = (left + 20, top + 20);
                let _ = writeln!(text, "{frame},{id},{left},{top},{right},{bottom},{class}");
            }
        }
        let result = import(&text, "t.csv", &options()).unwrap();
        let items = result.pattern.items().iter();
        let found: Vec<_> = items.map(|item| item.class.as_deref()).collect();
        assert_eq!(found, [Some("PET"), Some("PE"), Some("glass")]);
    }

    proptest! {
        #[test]
        fn a_clean_file_gives_its_items_back(
            spots in prop::collection::vec((0.0..3.0f64, -0.4..0.4f64, 2u32..30), 1..25),
            fps in 1.0..60.0f64,
            speed in 0.01..1.0f64,
            scale in 2e-4..5e-3f64,
            axis in prop::sample::select(vec![ImageAxis::X, ImageAxis::Y]),
            reverse: bool,
        ) {
            let mut options = ImportOptions::new(fps, scale, axis, speed);
            options.reverse = reverse;
            options.centre_px = Some(250.0);
            // One item each 6 m, moved by less than 3 m: further apart than anything that merges
            // or splits, and than what is taken for one thing under two ids.
            let spots = spots.into_iter().enumerate();
            let items: Vec<_> = spots.map(|(i, (x, y, n))| (-6.0 * i as f64 - x, y, n)).collect();
            let sign = if reverse { -1.0 } else { 1.0 };
            let mut text = String::new();
            for (id, &(x0, y, frames)) in items.iter().enumerate() {
                for frame in 1..=frames {
                    let time = f64::from(frame - 1) / fps;
                    let along = sign * (x0 + speed * time) / scale;
                    let across = 250.0 + options.left() * y / scale;
                    let (x, y) = if axis == ImageAxis::X { (along, across) } else { (across, along) };
                    let _ = writeln!(text, "{frame},{id},{},{},30,20,1,-1,-1,-1", x - 15.0, y - 10.0);
                }
            }
            let result = import(&text, "t", &options).unwrap();
            prop_assert_eq!(result.pattern.len(), items.len());
            let first = items[0].0;
            for (item, (x0, y, _)) in result.pattern.items().iter().zip(&items) {
                prop_assert!((item.x0 - (x0 - first)).abs() < 1e-9);
                prop_assert!((item.y - y).abs() < 1e-9);
                prop_assert!((item.area_cm2.unwrap() - 600.0 * scale * scale * 1e4).abs() < 1e-9);
            }
            prop_assert!(result.report.warnings.is_empty(), "{:?}", result.report.warnings);
        }
    }
}
