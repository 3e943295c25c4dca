//! What pages that draw the station share: the replay and the dashboard. The sources are in
//! `drawing/`. They share one scope with a page's own scripts and come first:
//!
//! | file | what it is |
//! |---|---|
//! | `elements.js` | building blocks of pages: figures, tables, lines of text |
//! | `canvas.js` | canvases, colours and basic shapes |
//! | `scene.js` | draws a state of the station; knows nothing of runs or controls |
//! | `arm.js` | an arm's position during a trip |
//! | `legend.js` | the legend of the scene |

use crate::palette::ROBOT_COLOURS;
use pickline::station::{Robot, Station};
use serde::Serialize;

pub use crate::page::BASE_STYLE;

/// The style sheet for what `SCRIPTS` draw.
pub const STYLE: &str = include_str!("drawing/drawing.css");
/// The scripts, in the order in which they must appear.
pub const SCRIPTS: [&str; 5] = [
    include_str!("drawing/elements.js"),
    include_str!("drawing/canvas.js"),
    include_str!("drawing/scene.js"),
    include_str!("drawing/arm.js"),
    include_str!("drawing/legend.js"),
];

/// A robot as the scripts know it; positions in m, times in s.
#[derive(Serialize)]
pub struct RobotData<'a> {
    name: &'a str,
    base: [f64; 2],
    bin: [f64; 2],
    reach: f64,
    grasp_time: f64,
    release_time: f64,
    colour: &'static str,
    /// The bins of a robot that has several, or one with a name; `bin` is where it rests.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bins: Vec<BinData<'a>>,
}

/// A bin as the scripts know it.
#[derive(Serialize)]
struct BinData<'a> {
    name: &'a str,
    at: [f64; 2],
    release_time: f64,
}

/// The bins of `robot`, unless it has one for everything.
fn bins_data(robot: &Robot) -> Vec<BinData<'_>> {
    let bins = robot.bins.iter().filter(|_| !robot.has_only_bin());
    bins.map(|bin| BinData {
        name: &bin.name,
        at: [bin.at.x, bin.at.y],
        release_time: bin.release_time,
    })
    .collect()
}

/// The robots of `station`, upstream first.
pub fn robots_data(station: &Station) -> Vec<RobotData<'_>> {
    let robots = station.robots().iter();
    robots
        .zip(ROBOT_COLOURS.iter().cycle())
        .map(|(robot, colour)| RobotData {
            name: &robot.name,
            base: [robot.base.x, robot.base.y],
            bin: [robot.rest.x, robot.rest.y],
            reach: robot.reach,
            grasp_time: robot.grasp_time,
            release_time: robot.bins[0].release_time,
            colour,
            bins: bins_data(robot),
        })
        .collect()
}
