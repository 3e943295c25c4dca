//! Lines across a chart, with their labels above it in as many rows as needed to keep them
//! apart.

use super::chart::{ChartMark, Ink};
use super::labels::{TEXT, WIDTH, label, width};
use super::look::Look;
use super::signs::{dash, sign};
use kuva::render::color::Color;
use kuva::render::layout::ComputedLayout;
use kuva::render::render::{Primitive, TextAnchor};

/// Height of a row of labels, and space kept free above the chart [px].
const ROW: f64 = 16.0;
const TOP: f64 = 14.0;
/// Distance between the lowest row and the chart, whose markers may touch its upper edge [px].
const ABOVE: f64 = 9.0;
/// Distance between two labels [px].
const APART: f64 = 8.0;
/// Distance between lines at the same position, and the maximum spread [px].
const BESIDE: f64 = 3.0;
const SPREAD: f64 = 18.0;
/// Width of a series' marker before a label shared by several [px].
const SIGN: f64 = 13.0;

/// Position of a mark's label [px]; `None` without a label, or if another mark shows the same
/// label at the same position.
pub(super) type LabelPlace = Option<(f64, usize)>;

/// Places the labels from left to right, each in the lowest row with room.
pub(super) fn rows(marks: &[ChartMark], x: impl Fn(f64) -> f64) -> Vec<LabelPlace> {
    let alike = |a: &ChartMark, b: &ChartMark| a.at == b.at && a.label == b.label;
    let mut order: Vec<usize> = (0..marks.len())
        .filter(|&i| marks[i].upright && !marks[i].label.is_empty())
        .filter(|&i| !marks[..i].iter().any(|before| alike(before, &marks[i])))
        .collect();
    order.sort_by(|&a, &b| marks[a].at.total_cmp(&marks[b].at));
    let mut places = vec![None; marks.len()];
    let mut ends: Vec<f64> = Vec::new();
    for i in order {
        let half = half_width(marks, i);
        let middle = x(marks[i].at).clamp(half + 2.0, (WIDTH - half - 2.0).max(half + 2.0));
        let free = ends.iter().position(|end| end + APART <= middle - half);
        let row = free.unwrap_or(ends.len());
        if row == ends.len() {
            ends.push(0.0);
        }
        ends[row] = middle + half;
        places[i] = Some((middle, row));
    }
    places
}

/// The series whose marks share the position and label of the `i`-th; if there are several,
/// their markers are drawn before the label.
fn sharing(marks: &[ChartMark], i: usize) -> Vec<Ink> {
    let alike = marks
        .iter()
        .filter(|m| m.at == marks[i].at && m.label == marks[i].label);
    let inks: Vec<Ink> = alike.map(|mark| mark.ink).collect();
    match inks.len() {
        1 => Vec::new(),
        _ => inks,
    }
}

/// Half the width of the `i`-th mark's label and the markers before it [px].
fn half_width(marks: &[ChartMark], i: usize) -> f64 {
    0.5 * (width(&marks[i].label) + SIGN * sharing(marks, i).len() as f64)
}

/// How far the `i`-th mark is moved aside [px]: marks at the same position are drawn side by
/// side, so that all of them are visible.
fn aside(marks: &[ChartMark], i: usize) -> f64 {
    let same = |mark: &&ChartMark| mark.at == marks[i].at && mark.upright == marks[i].upright;
    let before = marks[..i].iter().filter(same).count() as f64;
    let others = marks.iter().filter(same).count() as f64 - 1.0;
    BESIDE.min(SPREAD / others.max(1.0)) * (before - 0.5 * others)
}

/// Space that the labels need above the chart [px].
pub(super) fn room(places: &[LabelPlace]) -> f64 {
    let rows = places.iter().flatten().map(|(_, row)| row + 1).max();
    TOP + rows.map_or(0.0, |rows| ABOVE + ROW * (rows - 1) as f64)
}

/// The marks and their labels.
pub(super) fn drawn(
    marks: &[ChartMark],
    places: &[LabelPlace],
    look: Look,
    computed: &ComputedLayout,
) -> Vec<Primitive> {
    let top = computed.margin_top;
    let bottom = computed.height - computed.margin_bottom;
    let (left, right) = (computed.margin_left, computed.width - computed.margin_right);
    let mut drawn = Vec::new();
    let mut labels = Vec::new();
    for (i, (mark, place)) in marks.iter().zip(places).enumerate() {
        let colour = Color::from(look.colour(mark.ink));
        let above = place.map_or(0.0, |(_, row)| ABOVE + ROW * row as f64);
        let ends = if mark.upright {
            let x = computed.map_x(mark.at) + aside(marks, i);
            (x, top - above, x, bottom)
        } else {
            let y = computed.map_y(mark.at) + aside(marks, i);
            (left, y, right, y)
        };
        if let Some(to) = mark.shade_to {
            let to = computed.map_x(to).min(right);
            drawn.push(Primitive::Rect {
                x: ends.0,
                y: top,
                width: (to - ends.0).max(0.0),
                height: bottom - top,
                fill: colour.clone(),
                stroke: None,
                stroke_width: None,
                opacity: Some(0.16),
            });
        }
        drawn.push(Primitive::Line {
            x1: ends.0,
            y1: ends.1,
            x2: ends.2,
            y2: ends.3,
            stroke: colour,
            stroke_width: 1.3,
            stroke_dasharray: Some(dash()),
        });
        if let Some((x, row)) = place {
            let base = top - ABOVE - ROW * *row as f64;
            labels.extend(mark_label(marks, i, look, (*x, base)));
        }
    }
    drawn.extend(labels);
    drawn
}

/// The label of the `i`-th mark around a position, with the markers of all that share it.
fn mark_label(marks: &[ChartMark], i: usize, look: Look, (x, base): (f64, f64)) -> Vec<Primitive> {
    let half = half_width(marks, i);
    let sharing = sharing(marks, i);
    // No line of another mark runs through the words.
    let mut drawn = vec![Primitive::Rect {
        x: x - half,
        y: base - ROW + 4.0,
        width: 2.0 * half,
        height: ROW - 1.0,
        fill: Color::from(look.ground()),
        stroke: None,
        stroke_width: None,
        opacity: None,
    }];
    for (place, ink) in sharing.iter().enumerate() {
        let at = x - half + SIGN * (place as f64 + 0.5) - 2.0;
        drawn.extend(sign(*ink, look, at, base - 4.5));
    }
    drawn.push(Primitive::Text {
        x: x + 0.5 * SIGN * sharing.len() as f64,
        y: base,
        content: label(&marks[i].label),
        size: TEXT,
        anchor: TextAnchor::Middle,
        rotate: None,
        bold: false,
        color: None,
    });
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_make_way_for_each_other() {
        let mark = |at| ChartMark {
            at,
            upright: true,
            ink: Ink::Text,
            shade_to: None,
            label: "0.042".into(),
        };
        let places = rows(&[mark(0.5), mark(0.51), mark(0.7), mark(0.52)], |x| {
            700.0 * x
        });
        let row = |i: usize| places[i].unwrap().1;
        assert_eq!([row(0), row(1), row(2), row(3)], [0, 1, 0, 2]);
        assert_eq!(room(&places), TOP + ABOVE + 2.0 * ROW);
        assert_eq!(room(&[]), TOP);
        // Equal labels are shown once, with the marker of each, and the lines side by side.
        let twice = [mark(0.5), mark(0.5)];
        assert_eq!(rows(&twice, |x| x)[1], None);
        assert_eq!((aside(&twice, 0), aside(&twice, 1)), (-1.5, 1.5));
        assert_eq!((sharing(&twice, 0).len(), aside(&twice[..1], 0)), (2, 0.0));
        // At the very edge, a label stays inside the picture.
        let (middle, _) = rows(&[mark(1.1)], |x| 700.0 * x)[0].unwrap();
        assert!(middle + 0.5 * width("0.042") <= WIDTH);
    }
}
