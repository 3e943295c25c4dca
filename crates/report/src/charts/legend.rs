//! The legend below a chart, in columns.

use super::chart::{LegendLine, Swatch};
use super::labels::{TEXT, WIDTH, label, short, width};
use super::look::{Look, dashes};
use super::signs::{dash, sign};
use kuva::render::color::Color;
use kuva::render::render::{Primitive, TextAnchor};

/// Height of a line [px].
const LINE: f64 = 21.0;
/// Width of a line and of a bar or marker, distance from there to the words, and distance
/// between columns [px].
const LONG: f64 = 26.0;
const SHORT: f64 = 14.0;
const TO_WORDS: f64 = 8.0;
const BETWEEN: f64 = 22.0;
/// Maximum number of characters of an entry.
const WORDS: usize = 64;

/// The legend of a chart that ends at `top` and whose axis begins at `left`, and the height it
/// adds to the chart [px].
pub(super) fn drawn(
    entries: &[LegendLine],
    look: Look,
    left: f64,
    top: f64,
) -> (Vec<Primitive>, f64) {
    if entries.is_empty() {
        return (Vec::new(), 0.0);
    }
    let long = |entry: &&LegendLine| matches!(entry.swatch, Swatch::Line | Swatch::Mark);
    let size = match entries.iter().any(|entry| long(&entry)) {
        true => LONG,
        false => SHORT,
    };
    let mut drawn = Vec::new();
    let mut lines = 0;
    // Marks have long labels, which must not widen the columns of the series.
    for marks in [false, true] {
        let part = entries
            .iter()
            .filter(|e| (e.swatch == Swatch::Mark) == marks);
        let part: Vec<(&LegendLine, String)> = part.map(|e| (e, short(&e.label, WORDS))).collect();
        let widest = part
            .iter()
            .map(|(_, words)| width(words))
            .fold(0.0, f64::max);
        let column = size + TO_WORDS + widest + BETWEEN;
        let columns = ((WIDTH - left + BETWEEN) / column).floor().max(1.0) as usize;
        // Long names may begin left of the axis.
        let left = left.min(WIDTH - size - TO_WORDS - widest).max(4.0);
        for (i, (entry, words)) in part.iter().enumerate() {
            let x = left + (i % columns) as f64 * column;
            let y = top + 10.0 + (lines + i / columns) as f64 * LINE;
            drawn.extend(swatch(entry, look, (x, y), size));
            drawn.push(Primitive::Text {
                x: x + size + TO_WORDS,
                y: y + 4.5,
                content: label(words),
                size: TEXT,
                anchor: TextAnchor::Start,
                rotate: None,
                bold: false,
                color: None,
            });
        }
        lines += part.len().div_ceil(columns);
    }
    (drawn, 8.0 + LINE * lines as f64)
}

fn swatch(entry: &LegendLine, look: Look, (x, y): (f64, f64), size: f64) -> Vec<Primitive> {
    let colour = || Color::from(look.colour(entry.ink));
    let line = |dash: Option<&str>, width: f64| Primitive::Line {
        x1: x,
        y1: y,
        x2: x + size,
        y2: y,
        stroke: colour(),
        stroke_width: width,
        stroke_dasharray: dash.map(str::to_owned),
    };
    let dot = || sign(entry.ink, look, x + 0.5 * size, y);
    match entry.swatch {
        Swatch::Bar => vec![Primitive::Rect {
            x: x + 0.5 * (size - SHORT),
            y: y - 6.0,
            width: SHORT,
            height: 12.0,
            fill: Color::from(look.bar_colour(entry.ink)),
            stroke: None,
            stroke_width: None,
            opacity: None,
        }],
        Swatch::Dot => dot(),
        Swatch::Line => {
            let mut both = vec![line(dashes(entry.ink), 1.6)];
            both.extend(dot());
            both
        }
        Swatch::Bare => vec![line(dashes(entry.ink), 1.6)],
        Swatch::Mark => vec![line(Some(&dash()), 1.3)],
    }
}
