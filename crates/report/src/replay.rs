//! A page that replays a run: one HTML file that needs no network and no build step. The page's
//! sources are in `replay/`. Its scripts share one scope with those of `drawing/`, which come
//! first, in this order:
//!
//! | file | what it is |
//! |---|---|
//! | `timeline.js` | the run as a function of time: data in, state out |
//! | `strips.js` | draws the robots' strips and the running picking rate |
//! | `story.js` | the story of an item |
//! | `figures.js` | the figures, tables and legends |
//! | `replay.js` | time, controls, pointer and keyboard |

use super::clearance::ClearanceReport;
use super::drawing::{self, RobotData, robots_data};
use super::origin::with_page_origin;
use super::page::{BASE_STYLE, fill, inert};
use super::run::RunReport;
use pickline::error::{Error, Result};
use pickline::pattern::Pattern;
use pickline::sim::Scene;
use serde::Serialize;

/// With more items, browsers become slow.
const MOST_ITEMS: usize = 100_000;

const PAGE: &str = include_str!("replay/page.html");
const STYLE: &str = include_str!("replay/style.css");
const SCRIPTS: [&str; 5] = [
    include_str!("replay/timeline.js"),
    include_str!("replay/strips.js"),
    include_str!("replay/story.js"),
    include_str!("replay/figures.js"),
    include_str!("replay/replay.js"),
];

/// The page's data; positions in m, times in s.
#[derive(Serialize)]
struct Data<'a> {
    report: &'a RunReport,
    /// The smallest distance between two arms; `None` for a single robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    clearance: Option<&'a ClearanceReport>,
    /// The user's name for the station.
    station: &'a str,
    /// Where the camera looks at the belt, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    camera: Option<f64>,
    belt: ReplayBelt,
    robots: Vec<RobotData<'a>>,
    items: Vec<ItemData<'a>>,
}

#[derive(Serialize)]
struct ReplayBelt {
    speed: f64,
    length: f64,
    width: f64,
}

#[derive(Serialize)]
struct ItemData<'a> {
    id: &'a str,
    x0: f64,
    y: f64,
    weight: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    class: Option<&'a str>,
    /// The item's departure windows, upstream first.
    windows: Vec<WindowData>,
}

#[derive(Serialize)]
struct WindowData {
    robot: usize,
    open: f64,
    close: f64,
}

/// Checks that a replay can show `pattern`.
///
/// # Errors
/// The pattern has more items than a page can show.
pub fn check_replay(pattern: &Pattern) -> Result<()> {
    if pattern.len() <= MOST_ITEMS {
        return Ok(());
    }
    Err(Error::usage(
        "the page",
        format!("{} items are too many for a page", pattern.len()),
        format!("replay a pattern of at most {MOST_ITEMS} items"),
    ))
}

/// The page that replays the run of `report`, simulated on `scene`. `station` is the user's
/// name for the station.
pub fn replay_page(
    scene: &Scene,
    station: &str,
    report: &RunReport,
    clearance: Option<&ClearanceReport>,
) -> String {
    // The report and the station can always be serialised as JSON.
    let data = serde_json::to_string(&Data {
        clearance,
        ..data(scene, station, report)
    })
    .unwrap_or_default();
    let page = fill(
        PAGE,
        &[
            ("/*style*/", &[BASE_STYLE, drawing::STYLE, STYLE].concat()),
            ("/*data*/", &inert(&data)),
            (
                "/*scripts*/",
                &[drawing::SCRIPTS.concat(), SCRIPTS.concat()].concat(),
            ),
        ],
    );
    with_page_origin(&page, &report.made.command)
}

fn data<'a>(scene: &Scene<'a>, name: &'a str, report: &'a RunReport) -> Data<'a> {
    let station = scene.station();
    let belt = station.belt();
    let mut windows: Vec<Vec<WindowData>> = Vec::new();
    windows.resize_with(scene.pattern().len(), Vec::new);
    for robot in 0..station.robots().len() {
        for candidate in scene.queue(robot) {
            windows[candidate.item as usize].push(WindowData {
                robot,
                open: candidate.open,
                close: candidate.close,
            });
        }
    }
    let items = scene.pattern().items().iter();
    Data {
        report,
        clearance: None,
        station: name,
        camera: scene.conditions().camera_x,
        belt: ReplayBelt {
            speed: belt.speed,
            length: belt.length,
            width: belt.width,
        },
        robots: robots_data(station),
        items: items
            .zip(windows)
            .map(|(item, windows)| ItemData {
                id: &item.id,
                x0: item.x0,
                y: item.y,
                weight: item.weight_on(station),
                class: item.class.as_deref(),
                windows,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_marker_once_and_in_order() {
        let mut last = 0;
        for marker in ["/*style*/", "/*data*/", "/*scripts*/"] {
            assert_eq!(PAGE.matches(marker).count(), 1, "{marker}");
            let place = PAGE.find(marker).unwrap();
            assert!(place > last);
            last = place;
        }
        // Nothing that would close the element that contains a source.
        assert!(!STYLE.contains("</") && !drawing::STYLE.contains("</"));
        let mut scripts = drawing::SCRIPTS.iter().chain(&SCRIPTS);
        assert!(scripts.all(|script| !script.contains("</")));
    }

    #[test]
    fn too_many_items_are_refused() {
        let pattern = |items| pickline::pattern::grid(1.0, 0.1, items).unwrap();
        assert!(check_replay(&pattern(MOST_ITEMS)).is_ok());
        let message = check_replay(&pattern(MOST_ITEMS + 1))
            .unwrap_err()
            .to_string();
        assert!(message.contains("the page"), "{message}");
    }
}
