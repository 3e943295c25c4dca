//! The line itself: belt, items, robots, camera.

use super::frame::Frame;
use super::labels::{label, px, rectangle, rounded};
use crate::palette::ROBOT_COLOURS;
use pickline::pattern::Pattern;
use pickline::station::{Robot, Station};
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Title};

/// Everything that belongs to the line itself.
pub(super) fn drawn(
    frame: &Frame,
    station: &Station,
    pattern: &Pattern,
    camera: Option<f64>,
) -> Group {
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

pub(super) fn belt_rectangle(frame: &Frame, station: &Station) -> Rectangle {
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
    let (rest_x, rest_y) = (frame.x(robot.rest.x), frame.y(robot.rest.y));
    let group = Group::new().add(
        Line::new()
            .set("x1", px(x))
            .set("y1", px(y))
            .set("x2", px(rest_x))
            .set("y2", px(rest_y))
            .set("stroke", colour)
            .set("stroke-width", 3),
    );
    let bins = robot.bins.iter().fold(group, |group, bin| {
        let (bin_x, bin_y) = (frame.x(bin.at.x), frame.y(bin.at.y));
        let title = Title::new(format!("bin {}", bin.name));
        let bin = rectangle(bin_x - 8.0, bin_y - 5.0, 16.0, 10.0)
            .set("class", "paper")
            .set("stroke", colour)
            .set("stroke-width", 2);
        group.add(match robot.has_only_bin() {
            true => bin,
            false => bin.add(title),
        })
    });
    bins.add(
        Circle::new()
            .set("cx", px(x))
            .set("cy", px(y))
            .set("r", 8)
            .set("fill", colour),
    )
}
