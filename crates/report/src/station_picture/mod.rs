//! A picture of the station: belt, items, robots, workspaces, bins.
//!
//! | file | what it is |
//! |---|---|
//! | `frame.rs` | where everything is |
//! | `line.rs` | belt, items, robots, camera |
//! | `head.rs`, `axes.rs`, `labels.rs` | what is written around them |

mod axes;
mod frame;
mod head;
mod labels;
mod line;

use axes::axes;
use frame::{Frame, LEFT, RIGHT, WIDTH};
use head::{head, title};
use labels::{label_width, name, px, rectangle};
use line::{belt_rectangle, drawn};
use pickline::pattern::Pattern;
use pickline::station::Station;
use svg::Document;
use svg::node::element::{ClipPath, Definitions, Group, Style, Title, Use};

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

#[cfg(test)]
mod tests {
    use super::*;
    use pickline::pattern::grid;
    use pickline::station::{Belt, Robot, built_in};

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
            vec![
                Robot {
                    base: nalgebra::Point2::new(0.05, -0.06),
                    reach: 0.1,
                    ..small
                }
                .with_only_bin(nalgebra::Point2::new(0.02, -0.05)),
            ],
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
