//! The axes of a row, in metres.

use super::frame::{Frame, LEFT};
use super::labels::{label, px, rounded};
use svg::node::element::{Group, Line};

/// The axes of a row: x below it, y to the left.
pub(super) fn axes(frame: &Frame, row: usize) -> Group {
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
