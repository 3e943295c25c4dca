//! A picture of the station: belt, items, robots, workspaces, bins.

use super::charts::short;
use super::palette::ROBOT_COLOURS;
use pickline::error::counted;
use pickline::pattern::Pattern;
use pickline::station::{Robot, Station};
use svg::Document;
use svg::node::element::{
    Circle, ClipPath, Definitions, Group, Line, Path, Rectangle, Style, Text, Title, Use,
};

/// Width of the drawing area [px], and its maximum height in one row and in total.
const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 560.0;
/// Space left and right of the drawing area, for the axis across and the belt's width [px].
const LEFT: f64 = 56.0;
const RIGHT: f64 = 58.0;
/// From the belt down to the end of the camera's label [px].
const CAMERA: f64 = 22.0;
/// Space for the axis below a row and the header above all rows [px].
const AXIS: f64 = 46.0;
const HEAD: f64 = 46.0;
/// Height of a robot's name and reach, and their distance from the base [px].
const LABEL: f64 = 30.0;
const TO_LABEL: f64 = 12.0;
/// Levels of labels for robots that stand close to each other.
const LEVELS: usize = 3;
/// Share of the line's length kept free before and after it.
const ROOM: f64 = 0.04;
/// A line lower than this [px] is broken into rows, at most this many, which overlap by this
/// much [px].
const LOWEST: f64 = 110.0;
const MOST_ROWS: f64 = 6.0;
const OVERLAP: f64 = 36.0;
/// Maximum number of characters of a robot's name.
const NAME: usize = 20;

const STYLE: &str = "
text { font: 13px system-ui, sans-serif; fill: #24292f; }
.small { font-size: 11px; fill: #57606a; }
.paper { fill: #ffffff; }
.belt { fill: #e6e9ed; stroke: #8c959f; }
.item { fill: #424a53; }
.line { stroke: #57606a; stroke-width: 1; fill: none; }
.camera { stroke: #424a53; stroke-width: 2; stroke-dasharray: 2 4; fill: none; }
@media (prefers-color-scheme: dark) {
  text { fill: #e6edf3; }
  .small { fill: #9198a1; }
  .paper { fill: #0d1117; }
  .belt { fill: #262c36; stroke: #656c76; }
  .camera { stroke: #d1d7e0; }
  .item { fill: #d1d7e0; }
  .line { stroke: #9198a1; }
}";

/// The station as an SVG that follows the reader's light or dark scheme. Items are drawn where
/// they are when the first one is about to leave the belt. `camera` is where a camera looks at
/// the belt [m], if there is one. A line that is long for its width is broken into rows.
pub fn station_picture(station: &Station, pattern: &Pattern, camera: Option<f64>) -> String {
    let frame = Frame::around(station, camera);
    let (width, height) = frame.size();
    let mut document = Document::new()
        .set("viewBox", (0, 0, width.ceil(), height.ceil()))
        .set("role", "img")
        .add(Title::new(title(station)))
        .add(Style::new(STYLE))
        .add(rectangle(0.0, 0.0, width, height).set("class", "paper"));
    let line = drawn(&frame, station, pattern, camera);
    let mut definitions = Definitions::new().add(
        ClipPath::new()
            .set("id", "on-belt")
            .add(belt_rectangle(&frame, station)),
    );
    if frame.rows == 1 {
        document = document.add(definitions).add(line);
        document = document.add(names(&frame, station, 0)).add(axes(&frame, 0));
    } else {
        definitions = definitions.add(line.set("id", "line"));
        let mut rows = Vec::new();
        for row in 0..frame.rows {
            let top = frame.row_top(row);
            let end = if row + 1 == frame.rows { RIGHT } else { 0.0 };
            let inside = rectangle(LEFT, top, WIDTH + end, frame.row_height());
            let clip = format!("row-{row}");
            definitions = definitions.add(ClipPath::new().set("id", clip.as_str()).add(inside));
            let shown = Use::new()
                .set("href", "#line")
                .set("x", px(-frame.shift(row)))
                .set("y", px(top - frame.row_top(0)));
            let shown = Group::new()
                .set("clip-path", format!("url(#{clip})"))
                .add(shown);
            rows.push(shown);
            rows.push(names(&frame, station, row));
            rows.push(axes(&frame, row));
        }
        document = document.add(definitions);
        for row in rows {
            document = document.add(row);
        }
    }
    let document = document.add(head(station, camera.is_some()));
    format!("{document}\n")
}

fn title(station: &Station) -> String {
    let belt = station.belt();
    let robots = counted(station.robots().len(), "robot");
    format!(
        "{robots} along a belt of {} m by {} m at {} m/s",
        rounded(belt.length),
        rounded(belt.width),
        belt.speed
    )
}

/// Everything that belongs to the line itself.
fn drawn(frame: &Frame, station: &Station, pattern: &Pattern, camera: Option<f64>) -> Group {
    let coloured = || station.robots().iter().zip(ROBOT_COLOURS.iter().cycle());
    let mut group = Group::new().add(belt(frame, station));
    for (robot, colour) in coloured() {
        group = group.add(workspace(frame, robot, colour));
    }
    group = group.add(items(frame, station, pattern));
    if let Some(x) = camera {
        group = group.add(camera_line(frame, station, x));
    }
    for (robot, colour) in coloured() {
        group = group.add(arm(frame, robot, colour));
    }
    group
}

/// The labels of the robots that a row names. Labels are not cut where the row ends: if two
/// rows show a base, the first with room for the label names it.
fn names(frame: &Frame, station: &Station, row: usize) -> Group {
    let mut group = Group::new();
    for (robot, (middle, y)) in station.robots().iter().zip(&frame.labels) {
        if frame.row_of_label(*middle, label_width(robot)) == row {
            let down = frame.row_top(row) - frame.row_top(0);
            group = group.add(name(robot, (middle - frame.shift(row), y + down)));
        }
    }
    group
}

/// From the belt frame [m] to the picture [px]: x to the right, y upwards. If the line is
/// broken into rows, this is the first row, as long as the whole line.
struct Frame {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    scale: f64,
    rows: usize,
    /// Space for labels above and below the line [px].
    room: [f64; 2],
    /// Position of each robot's label: middle and upper baseline [px].
    labels: Vec<(f64, f64)>,
}

impl Frame {
    fn around(station: &Station, camera: Option<f64>) -> Self {
        let belt = station.belt();
        let places = || station.robots().iter().flat_map(|r| [r.base, r.bin]);
        let with_camera = camera.is_some();
        let camera = camera.unwrap_or(0.0);
        let low = places().map(|p| p.x).fold(camera.min(0.0), f64::min);
        let high = places()
            .map(|p| p.x)
            .fold(camera.max(belt.length), f64::max);
        let room = ROOM * (high - low);
        let (left, right) = (low - room, high + room);
        let half = 0.5 * belt.width;
        let bottom = places().map(|p| p.y).fold(-half, f64::min);
        let top = places().map(|p| p.y).fold(half, f64::max);
        let (length, height) = (right - left, top - bottom);
        let one = (WIDTH / length).min(HEIGHT / height);
        let rows = (LOWEST / (one * height)).ceil().clamp(1.0, MOST_ROWS);
        let scale = match rows as usize {
            1 => one,
            _ => ((rows * WIDTH - (rows - 1.0) * 2.0 * OVERLAP) / length).min(HEIGHT / height),
        };
        let mut frame = Self {
            left,
            right,
            bottom,
            top,
            scale,
            rows: rows as usize,
            room: [0.0; 2],
            labels: Vec::new(),
        };
        frame.place_labels(station, with_camera);
        frame
    }

    /// Places names beyond the bases, on as many levels as needed to keep them apart.
    fn place_labels(&mut self, station: &Station, with_camera: bool) {
        // Ends of the labels on each level, above and below.
        let mut ends = [[f64::NEG_INFINITY; LEVELS]; 2];
        let mut places = Vec::new();
        for robot in station.robots() {
            let side = usize::from(robot.base.y < 0.0);
            let half = 0.5 * label_width(robot);
            let middle = self.x(robot.base.x);
            let free = ends[side].iter().position(|end| *end + 8.0 < middle - half);
            let level = free.unwrap_or(LEVELS - 1);
            ends[side][level] = middle + half;
            self.room[side] = self.room[side].max((level + 1) as f64 * LABEL + TO_LABEL);
            places.push((middle, side, level));
        }
        // The arrow of travel is always above the belt.
        self.room[0] = self.room[0].max(LABEL);
        // The camera's label is below the belt.
        let below = if with_camera { CAMERA } else { TO_LABEL };
        self.room[1] = self.room[1].max(below);
        let (upper, lower) = (self.y(self.top), self.y(self.bottom));
        self.labels = places
            .into_iter()
            .map(|(middle, side, level)| {
                let away = TO_LABEL + level as f64 * LABEL;
                let y = match side {
                    0 => upper - away - LABEL + 13.0,
                    _ => lower + away + 13.0,
                };
                (middle, y)
            })
            .collect();
    }

    fn row_height(&self) -> f64 {
        (self.top - self.bottom) * self.scale + self.room[0] + self.room[1]
    }

    fn row_top(&self, row: usize) -> f64 {
        HEAD + row as f64 * (self.row_height() + AXIS)
    }

    /// Shift of a row to the left, relative to the first [px].
    fn shift(&self, row: usize) -> f64 {
        row as f64 * (WIDTH - 2.0 * OVERLAP)
    }

    /// The row that names a robot. `middle` is the middle of its label in the first row (as
    /// long as the whole line) and `width` the label's width [px].
    fn row_of_label(&self, middle: f64, width: f64) -> usize {
        let inside = |row: &usize, room: f64| {
            let x = middle - self.shift(*row);
            (LEFT + room..=LEFT + WIDTH - room).contains(&x)
        };
        let mut rows = (0..self.rows).filter(|row| inside(row, 0.0));
        let first = rows.next().unwrap_or(0);
        let fits = inside(&first, 0.5 * width);
        rows.find(|row| !fits && inside(row, 0.5 * width))
            .unwrap_or(first)
    }

    /// The part of the line that a row shows [m].
    fn span(&self, row: usize) -> [f64; 2] {
        let left = self.left + self.shift(row) / self.scale;
        [left, (left + WIDTH / self.scale).min(self.right)]
    }

    fn size(&self) -> (f64, f64) {
        (LEFT + WIDTH + RIGHT, self.row_top(self.rows))
    }

    fn x(&self, x: f64) -> f64 {
        // A short line is centred.
        let free = match self.rows {
            1 => 0.5 * (WIDTH - (self.right - self.left) * self.scale),
            _ => 0.0,
        };
        LEFT + free + (x - self.left) * self.scale
    }

    fn y(&self, y: f64) -> f64 {
        HEAD + self.room[0] + (self.top - y) * self.scale
    }
}

/// Approximate width of a robot's label [px].
fn label_width(robot: &Robot) -> f64 {
    let name = short(&robot.name, NAME).chars().count() as f64;
    (7.5 * name).max(6.0 * reach_words(robot).chars().count() as f64)
}

fn reach_words(robot: &Robot) -> String {
    format!("reach {} m", rounded(robot.reach))
}

fn name(robot: &Robot, (x, y): (f64, f64)) -> Group {
    Group::new()
        .add(label(x, y, &short(&robot.name, NAME)).set("text-anchor", "middle"))
        .add(
            label(x, y + 13.0, &reach_words(robot))
                .set("text-anchor", "middle")
                .set("class", "small"),
        )
}

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Rectangle {
    Rectangle::new()
        .set("x", px(x))
        .set("y", px(y))
        .set("width", px(width))
        .set("height", px(height))
}

/// A length without rounding errors after its sixth decimal [m].
fn rounded(length: f64) -> f64 {
    (length * 1e6).round() / 1e6
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

fn belt(frame: &Frame, station: &Station) -> Group {
    let belt = station.belt();
    // Beside the belt, where no item can be below it.
    let (x, y) = (frame.x(0.0), frame.y(belt.width / 2.0) - 12.0);
    let arrow = format!("M{0} {1}h44m-8 -5l8 5l-8 5", px(x), px(y));
    // The belt's width, after its end.
    let (end, upper) = (frame.x(belt.length) + 10.0, frame.y(belt.width / 2.0));
    let width = belt.width * frame.scale;
    let measure = format!("M{0} {1}h8m-4 0v{2}m-4 0h8", px(end), px(upper), px(width));
    Group::new()
        .add(belt_rectangle(frame, station).set("class", "belt"))
        .add(
            Path::new()
                .set("d", arrow)
                .set("class", "line")
                .set("stroke-width", 2),
        )
        .add(label(x + 52.0, y + 4.0, &format!("{} m/s", belt.speed)).set("class", "small"))
        .add(Path::new().set("d", measure).set("class", "line"))
        .add(
            label(
                end + 10.0,
                upper + 0.5 * width + 4.0,
                &format!("{} m", rounded(belt.width)),
            )
            .set("class", "small"),
        )
}

/// Where the camera looks at the belt.
fn camera_line(frame: &Frame, station: &Station, x: f64) -> Group {
    let half = 0.5 * station.belt().width;
    let x = frame.x(x);
    let (upper, lower) = (frame.y(half) - 6.0, frame.y(-half) + 6.0);
    let line = Line::new()
        .set("x1", px(x))
        .set("x2", px(x))
        .set("y1", px(upper))
        .set("y2", px(lower));
    Group::new().add(line.set("class", "camera")).add(
        label(x, lower + 12.0, "camera")
            .set("text-anchor", "middle")
            .set("class", "small"),
    )
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
                .set("clip-path", "url(#on-belt)"),
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
}

/// The axes of a row: x below it, y to the left.
fn axes(frame: &Frame, row: usize) -> Group {
    let line = |x1: f64, y1: f64, x2: f64, y2: f64| {
        let line = Line::new().set("x1", px(x1)).set("x2", px(x2));
        line.set("y1", px(y1))
            .set("y2", px(y2))
            .set("class", "line")
    };
    let number = |x: f64, y: f64, value: f64, anchor: &str| {
        label(x, y, &rounded(value).to_string())
            .set("text-anchor", anchor)
            .set("class", "small")
    };
    let top = frame.row_top(row);
    let floor = top + frame.row_height() + 6.0;
    let [low, high] = frame.span(row);
    let across = |x: f64| frame.x(x) - frame.shift(row);
    let mut group = Group::new().add(line(across(low), floor, across(high), floor));
    for at in ticks(low, high, 12.0) {
        let x = across(at);
        group =
            group
                .add(line(x, floor, x, floor + 5.0))
                .add(number(x, floor + 18.0, at, "middle"));
    }
    let middle = across(f64::midpoint(low, high));
    group = group.add(
        label(middle, floor + 34.0, "x along the travel [m]")
            .set("text-anchor", "middle")
            .set("class", "small"),
    );
    let up = |y: f64| frame.y(y) + top - frame.row_top(0);
    let edge = LEFT - 8.0;
    group = group.add(line(edge, up(frame.bottom), edge, up(frame.top)));
    // As many as have room for their numbers.
    let most = ((frame.top - frame.bottom) * frame.scale / 22.0).clamp(2.0, 8.0);
    for at in ticks(frame.bottom, frame.top, most) {
        let y = up(at);
        group = group
            .add(line(edge - 5.0, y, edge, y))
            .add(number(edge - 8.0, y + 4.0, at, "end"));
    }
    let turned = format!(
        "rotate(-90 12 {0})",
        px(up(f64::midpoint(frame.bottom, frame.top)))
    );
    group.add(
        label(
            12.0,
            up(f64::midpoint(frame.bottom, frame.top)),
            "y across [m]",
        )
        .set("text-anchor", "middle")
        .set("class", "small")
        .set("transform", turned),
    )
}

/// Round values from `low` to `high`, at most `most` of them.
fn ticks(low: f64, high: f64, most: f64) -> impl Iterator<Item = f64> {
    let least = (high - low) / most;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = step.into_iter().find(|step| *step >= least * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * power);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    (first as i64..=last as i64).map(move |tick| tick as f64 * step)
}

/// A summary of the line, and the legend.
fn head(station: &Station, camera: bool) -> Group {
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

#[cfg(test)]
mod tests {
    use super::*;
    use pickline::pattern::grid;
    use pickline::station::{Belt, built_in};

    #[test]
    fn labels_and_axes_stay_inside_whatever_the_size() {
        let paper = |robots| built_in("paper").unwrap().station(Some(robots)).unwrap();
        let small = paper(1).robots()[0].clone();
        let small = Station::new(
            Belt {
                speed: 0.05,
                length: 0.1,
                width: 0.05,
            },
            vec![Robot {
                base: nalgebra::Point2::new(0.05, -0.06),
                bin: nalgebra::Point2::new(0.02, -0.05),
                reach: 0.1,
                ..small
            }],
        );
        for (station, rows) in [
            (small.unwrap(), 1),
            (paper(2), 1),
            (paper(12), 3),
            (paper(40), 6),
        ] {
            let frame = Frame::around(&station, Some(-0.5));
            assert_eq!(frame.rows, rows, "{} robots", station.robots().len());
            let (width, height) = frame.size();
            assert!(width < 1100.0 && height < 2000.0);
            // The rows show the whole line.
            assert!(frame.span(rows - 1)[1] >= frame.right - 1e-9);
            let picture = station_picture(&station, &grid(0.05, 0.02, 9).unwrap(), Some(-0.5));
            assert!(!picture.contains("NaN") && !picture.contains("inf"));
            assert!(picture.contains("y across [m]") && picture.contains("camera"));
            // Every robot is named once, with its whole label in its row.
            let named = picture.matches("\nreach ").count();
            assert_eq!(named, station.robots().len());
        }
    }
}
