//! What is above the line: a summary of it, and the legend.

use super::frame::LEFT;
use super::labels::{label, rectangle, rounded};
use pickline::error::counted;
use pickline::station::Station;
use svg::node::element::{Circle, Group, Line};

pub(super) fn title(station: &Station) -> String {
    let belt = station.belt();
    let robots = counted(station.robots().len(), "robot");
    format!(
        "{robots} along a belt of {} m by {} m at {} m/s",
        rounded(belt.length),
        rounded(belt.width),
        belt.speed
    )
}

/// A summary of the line, and the legend.
pub(super) fn head(station: &Station, camera: bool) -> Group {
    let y = 37.0;
    let entry = |x: f64, text: &str| label(x + 14.0, y, text).set("class", "small");
    let at = |i: usize| LEFT + 8.0 + [0.0, 105.0, 265.0, 325.0, 640.0][i];
    let group = Group::new()
        .add(label(LEFT, 16.0, &title(station)))
        .add(
            Circle::new()
                .set("cx", at(0))
                .set("cy", y - 4.0)
                .set("r", 7)
                .set("class", "line"),
        )
        .add(entry(at(0), "robot base"))
        .add(rectangle(at(1) - 8.0, y - 9.0, 16.0, 10.0).set("class", "line"))
        .add(entry(at(1), "bin, resting position"))
        .add(
            Circle::new()
                .set("cx", at(2))
                .set("cy", y - 4.0)
                .set("r", 4)
                .set("class", "item"),
        )
        .add(entry(at(2), "item"))
        .add(
            Circle::new()
                .set("cx", at(3))
                .set("cy", y - 4.0)
                .set("r", 7)
                .set("class", "line")
                .set("stroke-dasharray", "5 4"),
        )
        .add(entry(at(3), "workspace; shaded where it covers the belt"));
    if !camera {
        return group;
    }
    let line = Line::new().set("x1", at(4)).set("x2", at(4));
    let line = line
        .set("y1", y - 12.0)
        .set("y2", y + 3.0)
        .set("class", "camera");
    group.add(line).add(entry(at(4), "where the camera looks"))
}
