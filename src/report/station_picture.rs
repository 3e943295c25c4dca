//! The station as a picture: belt, items, robots, workspaces, bins.

use super::palette::ROBOT_COLOURS;
use crate::pattern::Pattern;
use crate::station::{Robot, Station};
use svg::Document;
use svg::node::element::{
    Circle, ClipPath, Definitions, Group, Line, Path, Rectangle, Style, Text, Title,
};

/// Width of the drawing area [px].
const WIDTH: f64 = 900.0;
/// Around the drawing area [px].
const MARGIN: f64 = 20.0;
/// For the axis below it and the legend above it [px].
const AXIS: f64 = 46.0;
const LEGEND: f64 = 28.0;
/// Height of a robot's name with its distance from the base [px].
const LABEL: f64 = 34.0;
/// Kept free around bases, bins and belt edges [m].
const ROOM: f64 = 0.22;

const STYLE: &str = "
text { font: 13px system-ui, sans-serif; fill: #24292f; }
.small { font-size: 11px; fill: #57606a; }
.paper { fill: #ffffff; }
.belt { fill: #e6e9ed; stroke: #8c959f; }
.item { fill: #424a53; }
.line { stroke: #57606a; stroke-width: 1; fill: none; }
@media (prefers-color-scheme: dark) {
  text { fill: #e6edf3; }
  .small { fill: #9198a1; }
  .paper { fill: #0d1117; }
  .belt { fill: #262c36; stroke: #656c76; }
  .item { fill: #d1d7e0; }
  .line { stroke: #9198a1; }
}";

/// The station as an SVG that follows the reader's light or dark scheme. The items
/// are drawn where they are when the first one is about to leave the belt.
pub fn station_picture(station: &Station, pattern: &Pattern) -> String {
    let frame = Frame::around(station);
    let (width, height) = frame.size();
    let title = format!(
        "Station of {} robots along a belt of {} m by {} m",
        station.robots().len(),
        station.belt().length,
        station.belt().width
    );
    let mut document = Document::new()
        .set("viewBox", (0, 0, width.ceil(), height.ceil()))
        .set("role", "img")
        .add(Title::new(title))
        .add(Style::new(STYLE))
        .add(rectangle(0.0, 0.0, width, height).set("class", "paper"))
        .add(definitions(&frame, station))
        .add(belt(&frame, station));
    for (robot, colour) in station.robots().iter().zip(ROBOT_COLOURS.iter().cycle()) {
        document = document.add(workspace(&frame, robot, colour));
    }
    document = document.add(items(&frame, station, pattern));
    for (robot, colour) in station.robots().iter().zip(ROBOT_COLOURS.iter().cycle()) {
        document = document.add(arm(&frame, robot, colour));
    }
    let document = document.add(axis(&frame)).add(legend());
    format!("{document}\n")
}

/// Belt frame [m] to picture [px]: x to the right, y upwards.
struct Frame {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    scale: f64,
}

impl Frame {
    fn around(station: &Station) -> Self {
        let belt = station.belt();
        let places = || station.robots().iter().flat_map(|r| [r.base, r.bin]);
        let low = |a: f64, b: f64| a.min(b);
        let left = places().map(|p| p.x).fold(0.0, low) - ROOM;
        let right = places().map(|p| p.x).fold(belt.length, f64::max) + ROOM;
        let scale = WIDTH / (right - left);
        // However small the scale, a name has to fit beside its base.
        let room = ROOM.max(LABEL / scale);
        let bottom = places().map(|p| p.y).fold(-belt.width / 2.0, low) - room;
        let top = places().map(|p| p.y).fold(belt.width / 2.0, f64::max) + room;
        Self {
            left,
            right,
            bottom,
            top,
            scale,
        }
    }

    fn size(&self) -> (f64, f64) {
        let height = (self.top - self.bottom) * self.scale;
        (WIDTH + 2.0 * MARGIN, height + AXIS + LEGEND)
    }

    fn x(&self, x: f64) -> f64 {
        MARGIN + (x - self.left) * self.scale
    }

    fn y(&self, y: f64) -> f64 {
        LEGEND + (self.top - y) * self.scale
    }
}

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Rectangle {
    Rectangle::new()
        .set("x", px(x))
        .set("y", px(y))
        .set("width", px(width))
        .set("height", px(height))
}

/// A pixel value short enough to read.
fn px(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn label(x: f64, y: f64, text: &str) -> Text {
    Text::new(text).set("x", px(x)).set("y", px(y))
}

fn belt_rectangle(frame: &Frame, station: &Station) -> Rectangle {
    let belt = station.belt();
    rectangle(
        frame.x(0.0),
        frame.y(belt.width / 2.0),
        belt.length * frame.scale,
        belt.width * frame.scale,
    )
}

fn definitions(frame: &Frame, station: &Station) -> Definitions {
    let (width, height) = frame.size();
    let inside = rectangle(0.0, LEGEND, width, height - AXIS - LEGEND);
    Definitions::new()
        .add(
            ClipPath::new()
                .set("id", "on-belt")
                .add(belt_rectangle(frame, station)),
        )
        .add(ClipPath::new().set("id", "inside").add(inside))
}

fn belt(frame: &Frame, station: &Station) -> Group {
    let belt = station.belt();
    // Beside the belt, where no item can lie under it.
    let (x, y) = (frame.x(0.0), frame.y(belt.width / 2.0) - 12.0);
    let arrow = format!("M{0} {1}h44m-8 -5l8 5l-8 5", px(x), px(y));
    Group::new()
        .add(belt_rectangle(frame, station).set("class", "belt"))
        .add(
            Path::new()
                .set("d", arrow)
                .set("class", "line")
                .set("stroke-width", 2),
        )
        .add(label(x + 52.0, y + 4.0, &format!("{} m/s", belt.speed)).set("class", "small"))
}

fn workspace(frame: &Frame, robot: &Robot, colour: &str) -> Group {
    let circle = || {
        Circle::new()
            .set("cx", px(frame.x(robot.base.x)))
            .set("cy", px(frame.y(robot.base.y)))
            .set("r", px(robot.reach * frame.scale))
    };
    Group::new()
        .add(
            circle()
                .set("fill", colour)
                .set("fill-opacity", 0.22)
                .set("clip-path", "url(#on-belt)"),
        )
        .add(
            circle()
                .set("fill", "none")
                .set("stroke", colour)
                .set("stroke-dasharray", "5 4")
                .set("clip-path", "url(#inside)"),
        )
}

fn items(frame: &Frame, station: &Station, pattern: &Pattern) -> Group {
    let belt = station.belt();
    let items = pattern.items();
    // The first item is about to leave, so the belt is covered.
    let shift = belt.length - items[0].x0;
    let radius = (0.018 * frame.scale).clamp(1.5, 5.0);
    items
        .iter()
        .map(|item| (item.x0 + shift, item.y))
        .filter(|(x, _)| (0.0..=belt.length).contains(x))
        .fold(Group::new().set("class", "item"), |group, (x, y)| {
            group.add(
                Circle::new()
                    .set("cx", px(frame.x(x)))
                    .set("cy", px(frame.y(y)))
                    .set("r", px(radius)),
            )
        })
}

fn arm(frame: &Frame, robot: &Robot, colour: &str) -> Group {
    let (x, y) = (frame.x(robot.base.x), frame.y(robot.base.y));
    let (bin_x, bin_y) = (frame.x(robot.bin.x), frame.y(robot.bin.y));
    let outward = if robot.base.y < 0.0 { 22.0 } else { -13.0 };
    Group::new()
        .add(
            Line::new()
                .set("x1", px(x))
                .set("y1", px(y))
                .set("x2", px(bin_x))
                .set("y2", px(bin_y))
                .set("stroke", colour)
                .set("stroke-width", 3),
        )
        .add(
            rectangle(bin_x - 8.0, bin_y - 5.0, 16.0, 10.0)
                .set("class", "paper")
                .set("stroke", colour)
                .set("stroke-width", 2),
        )
        .add(
            Circle::new()
                .set("cx", px(x))
                .set("cy", px(y))
                .set("r", 8)
                .set("fill", colour),
        )
        .add(label(x, y + outward, &robot.name).set("text-anchor", "middle"))
}

fn axis(frame: &Frame) -> Group {
    let y = frame.y(frame.bottom) + 6.0;
    // Ticks at a round distance, at most a dozen of them.
    let span = frame.right - frame.left;
    let step = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]
        .into_iter()
        .find(|step| span / step <= 12.0)
        .unwrap_or(span / 10.0);
    let mut group = Group::new().add(
        Line::new()
            .set("x1", px(frame.x(frame.left)))
            .set("x2", px(frame.x(frame.right)))
            .set("y1", px(y))
            .set("y2", px(y))
            .set("class", "line"),
    );
    let first = (frame.left / step).ceil() as i64;
    let last = (frame.right / step).floor() as i64;
    for tick in first..=last {
        let at = tick as f64 * step;
        let x = frame.x(at);
        group = group
            .add(
                Line::new()
                    .set("x1", px(x))
                    .set("x2", px(x))
                    .set("y1", px(y))
                    .set("y2", px(y + 5.0))
                    .set("class", "line"),
            )
            .add(
                label(x, y + 18.0, &format!("{}", (at * 1e6).round() / 1e6))
                    .set("text-anchor", "middle")
                    .set("class", "small"),
            );
    }
    let middle = frame.x(f64::midpoint(frame.left, frame.right));
    group.add(
        label(middle, y + 34.0, "x along the travel [m]")
            .set("text-anchor", "middle")
            .set("class", "small"),
    )
}

fn legend() -> Group {
    let y = 17.0;
    let entry = |x: f64, text: &str| label(x + 14.0, y, text).set("class", "small");
    let at = |i: usize| MARGIN + 8.0 + [0.0, 105.0, 265.0, 325.0][i];
    Group::new()
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
        .add(entry(at(3), "workspace; shaded where it covers the belt"))
}
