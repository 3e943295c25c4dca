//! Text in the picture, and lengths as shown.

use crate::charts::short;
use pickline::station::Robot;
use svg::node::element::{Group, Rectangle, Text};

/// Maximum number of characters of a robot's name.
const NAME: usize = 20;

/// Approximate width of a robot's label [px].
pub(super) fn label_width(robot: &Robot) -> f64 {
    let name = short(&robot.name, NAME).chars().count() as f64;
    (7.5 * name).max(6.0 * reach_words(robot).chars().count() as f64)
}

fn reach_words(robot: &Robot) -> String {
    format!("reach {} m", rounded(robot.reach))
}

pub(super) fn name(robot: &Robot, (x, y): (f64, f64)) -> Group {
    Group::new()
        .add(label(x, y, &short(&robot.name, NAME)).set("text-anchor", "middle"))
        .add(
            label(x, y + 13.0, &reach_words(robot))
                .set("text-anchor", "middle")
                .set("class", "small"),
        )
}

pub(super) fn label(x: f64, y: f64, text: &str) -> Text {
    Text::new(text).set("x", px(x)).set("y", px(y))
}

pub(super) fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Rectangle {
    Rectangle::new()
        .set("x", px(x))
        .set("y", px(y))
        .set("width", px(width))
        .set("height", px(height))
}

/// A length without rounding errors after its sixth decimal [m].
pub(super) fn rounded(length: f64) -> f64 {
    (length * 1e6).round() / 1e6
}

/// A pixel value short enough to read.
pub(super) fn px(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
