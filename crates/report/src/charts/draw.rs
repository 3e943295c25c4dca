//! A chart as SVG, drawn with kuva, which draws axes, bars, lines, areas, markers and
//! intervals. What kuva lacks is added to its scene: a legend of dashed lines with markers, a
//! grid behind horizontal bars, marks that avoid each other.

use super::axis::ChartAxis;
use super::chart::{Chart, ChartBar, Ink, Layer, PointStyle, beside};
use super::labels::{TEXT, WIDTH, clean, label, short, width};
use super::layers::plots;
use super::legend;
use super::look::{Look, dark_style};
use super::marks;
use crate::page::escape;
use crate::provenance::Provenance;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

/// Height between the axes if y is a number [px].
const HEIGHT: f64 = 330.0;
/// Height of one bar or one row of points, and of the space between two names [px].
const ROW: f64 = 15.0;
const GAP: f64 = 12.0;
/// Maximum number of characters of a name beside the axis.
const NAME: usize = 44;
/// Height of a chart's own title [px], and its maximum number of characters.
const TITLE: f64 = 24.0;
const TITLE_CHARACTERS: usize = 84;
/// Distance between the axes and the bars' numbers to the right of them [px].
const TO_NUMBERS: f64 = 8.0;

/// The chart as a standalone SVG file that states how it was made.
pub(crate) fn for_paper(mut chart: Chart, made: Option<&Provenance>) -> String {
    let made = made.map_or(String::new(), |made| format!(" {}", made.one_line()));
    let about = chart.note() + &made;
    chart.spell_out_gt();
    svg(&chart, Look::Paper, &about)
}

/// The chart as an element of a page.
pub(crate) fn for_page(chart: &Chart) -> String {
    svg(chart, Look::Page, &chart.note())
}

fn svg(chart: &Chart, look: Look, about: &str) -> String {
    let scene = scene(chart, look);
    let text = SvgBackend::new().with_pretty(true).render_scene(&scene);
    // Scalable, and with a text for readers who cannot see it.
    let head = format!(
        "<svg role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {} {}\" ",
        escape(&clean(&chart.title)),
        scene.width,
        scene.height
    );
    let text = text.replacen("<svg ", &head, 1);
    let (open, rest) = text.split_once('>').unwrap_or((&text, ""));
    // On a page, a title would pop up over the whole chart, and the page prints it above
    // anyway.
    let title = match look {
        Look::Paper => format!("\n<title>{}</title>", escape(&clean(&chart.title))),
        Look::Page => String::new(),
    };
    let style = match look {
        Look::Paper => dark_style(),
        Look::Page => String::new(),
    };
    format!(
        "{open}>{title}\n<desc>{}</desc>{style}{rest}",
        escape(&clean(about))
    )
}

/// Inserts `elements` behind the data.
fn insert_behind(scene: &mut Scene, elements: Vec<Primitive>) {
    // The data start where kuva starts to clip.
    let is_start = |element: &Primitive| matches!(element, Primitive::ClipStart { .. });
    let data = scene.elements.iter().position(is_start);
    let at = data.unwrap_or(scene.elements.len());
    scene.elements.splice(at..at, elements);
}

/// Removes kuva's clip path. It would cut markers on the edges in half. Besides, kuva numbers
/// its paths throughout the process, but equal charts must give equal bytes. The axes contain
/// everything that is drawn anyway.
fn unclip(scene: &mut Scene) {
    let clip =
        |element: &Primitive| matches!(element, Primitive::ClipStart { .. } | Primitive::ClipEnd);
    scene.elements.retain(|element| !clip(element));
    scene.defs.retain(|text| !text.starts_with("<clipPath"));
}

fn scene(chart: &Chart, look: Look) -> Scene {
    let names = match &chart.y {
        ChartAxis::Names(names) => names.len(),
        ChartAxis::Numbers { .. } => 0,
    };
    let inside = match names {
        0 => HEIGHT,
        _ => names as f64 * (ROW * rows_a_name(chart) as f64 + GAP),
    };
    let layout = || axes(chart, look);
    let free = ComputedLayout::from_layout(&layout());
    let numbers = widest_number(chart);
    let layout = || match numbers {
        0.0 => layout(),
        numbers => {
            layout().with_force_margins(free.margin_left, free.margin_right + TO_NUMBERS + numbers)
        }
    };
    let free = ComputedLayout::from_layout(&layout());
    let rows = marks::rows(&chart.marks, |x| free.map_x(x));
    let title = match look {
        Look::Paper => TITLE,
        // On a page, it is a heading.
        Look::Page => 0.0,
    };
    let top = title + marks::room(&rows);
    let height = top + inside + free.margin_bottom;
    let layout = layout()
        .with_force_margins_y(top, free.margin_bottom)
        .with_height(height);
    let computed = ComputedLayout::from_layout(&layout);
    let plots = chart
        .layers
        .iter()
        .zip(under(&chart.layers))
        .flat_map(|(layer, under)| plots(layer, names, look, under))
        .collect();
    let mut scene = render_multiple(plots, layout);
    let mut behind = Vec::new();
    if names > 0 {
        behind.extend(grid(chart, look, &computed));
    }
    behind.extend(marks::drawn(&chart.marks, &rows, look, &computed));
    insert_behind(&mut scene, behind);
    unclip(&mut scene);
    if look == Look::Paper {
        scene.elements.push(heading(&chart.title));
    }
    scene.elements.extend(bar_numbers(chart, &computed));
    scene.elements.extend(breaks(chart, look, &computed));
    let (below, more) = legend::drawn(&chart.legend, look, computed.margin_left, height - 4.0);
    scene.elements.extend(below);
    scene.height += more;
    scene
}

fn words(content: String, (x, y): (f64, f64), anchor: TextAnchor, bold: bool) -> Primitive {
    Primitive::Text {
        x,
        y,
        content,
        size: TEXT,
        anchor,
        rotate: None,
        bold,
        color: None,
    }
}

/// The title of a standalone chart.
fn heading(title: &str) -> Primitive {
    let title = label(&short(title, TITLE_CHARACTERS));
    words(title, (0.5 * WIDTH, 18.0), TextAnchor::Middle, true)
}

fn bars(chart: &Chart) -> impl Iterator<Item = (usize, usize, usize, &ChartBar)> {
    let groups = chart.layers.iter().filter_map(|layer| match layer {
        Layer::Bars(groups) => Some(groups),
        Layer::Points { .. } => None,
    });
    groups.flat_map(|groups| {
        groups.iter().enumerate().flat_map(|(i, group)| {
            let count = group.len();
            let bars = group.iter().enumerate();
            bars.map(move |(j, bar)| (i, j, count, bar))
        })
    })
}

/// Width of the numbers beside the bars [px]; 0 without bars.
fn widest_number(chart: &Chart) -> f64 {
    bars(chart)
        .map(|(.., bar)| width(&bar.words))
        .fold(0.0, f64::max)
}

/// The value of each bar, in a column to the right of the axes where nothing is drawn.
fn bar_numbers(chart: &Chart, computed: &ComputedLayout) -> Vec<Primitive> {
    let ChartAxis::Names(names) = &chart.y else {
        return Vec::new();
    };
    let right = WIDTH - 4.0;
    let number = |(i, j, count, bar): (usize, usize, usize, &ChartBar)| {
        // kuva counts upwards.
        let y = computed.map_y((names.len() - i) as f64 - beside(j, count));
        words(label(&bar.words), (right, y + 4.5), TextAnchor::End, false)
    };
    bars(chart).map(number).collect()
}

/// Two strokes over each axis that does not begin at 0, near its beginning.
fn breaks(chart: &Chart, look: Look, computed: &ComputedLayout) -> Vec<Primitive> {
    /// Distance from the corner of the axes to the middle of the break, half the gap between
    /// the strokes, and half their length across and along [px].
    const AWAY: f64 = 13.0;
    const GAP: f64 = 2.5;
    const ACROSS: f64 = 5.0;
    const SLANT: f64 = 2.5;
    let (left, bottom) = (
        computed.margin_left,
        computed.height - computed.margin_bottom,
    );
    let mut drawn = Vec::new();
    let mut line = |(x1, y1), (x2, y2), stroke: &str, stroke_width| {
        drawn.push(Primitive::Line {
            x1,
            y1,
            x2,
            y2,
            stroke: Color::from(stroke),
            stroke_width,
            stroke_dasharray: None,
        });
    };
    let ink = look.colour(Ink::Text);
    for (scale, upright) in [(&chart.x, false), (&chart.y, true)] {
        if !scale.is_cut() {
            continue;
        }
        // Along the axis and across it, then as positions in the picture.
        let place = |along: f64, across: f64| match upright {
            true => (left + across, bottom - AWAY - along),
            false => (left + AWAY + along, bottom + across),
        };
        line(place(-GAP, 0.0), place(GAP, 0.0), look.ground(), 3.0);
        for at in [-GAP, GAP] {
            line(
                place(at - SLANT, ACROSS),
                place(at + SLANT, -ACROSS),
                &ink,
                1.2,
            );
        }
    }
    drawn
}

/// The largest number of bars or points beside each other for one name.
fn rows_a_name(chart: &Chart) -> usize {
    let layer = |layer: &Layer| match layer {
        Layer::Bars(groups) => groups.iter().map(Vec::len).max().unwrap_or(1),
        Layer::Points { .. } => 1,
    };
    let bars = chart.layers.iter().map(layer).max().unwrap_or(1);
    // Rows of points are layers of their own, each at its own distance from the name.
    let mut distances: Vec<i64> = chart
        .layers
        .iter()
        .filter_map(|layer| match layer {
            Layer::Points { points, .. } => points.first(),
            Layer::Bars(_) => None,
        })
        .map(|point| (1e6 * (point.y - point.y.round())) as i64)
        .collect();
    distances.sort_unstable();
    distances.dedup();
    bars.max(distances.len())
}

fn axes(chart: &Chart, look: Look) -> Layout {
    let range = |scale: &ChartAxis| match scale {
        ChartAxis::Numbers { low, high, .. } => (*low, *high),
        ChartAxis::Names(names) => (0.5, names.len() as f64 + 0.5),
    };
    let (x, y) = (range(&chart.x), range(&chart.y));
    let mut layout = Layout::new(x, y)
        .with_width(WIDTH)
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
        .with_theme(look.theme())
        .with_tick_size(TEXT)
        .with_label_size(TEXT)
        .with_body_size(TEXT);
    if let ChartAxis::Numbers { title, step, .. } = &chart.x {
        layout = layout
            .with_x_label(label(title))
            // Closer to its ticks than to the legend.
            .with_x_label_offset(0.0, -7.0)
            .with_x_tick_step(*step)
            .with_x_tick_format(TickFormat::Fixed(decimals(*step)));
    }
    match &chart.y {
        ChartAxis::Numbers { title, step, .. } => layout
            .with_y_label(label(title))
            .with_y_tick_step(*step)
            .with_y_tick_format(TickFormat::Fixed(decimals(*step))),
        ChartAxis::Names(names) => {
            // kuva counts upwards.
            let upwards = names.iter().rev();
            layout.with_y_categories(upwards.map(|name| label(&short(name, NAME))).collect())
        }
    }
}

/// Number of decimals needed to distinguish ticks.
fn decimals(step: f64) -> usize {
    (-step.log10()).ceil().max(0.0) as usize
}

/// The lines that kuva omits if an axis has names: upright ones at its ticks, and lines between
/// names that have several rows.
fn grid(chart: &Chart, look: Look, computed: &ComputedLayout) -> Vec<Primitive> {
    let ChartAxis::Numbers {
        low, high, step, ..
    } = chart.x
    else {
        return Vec::new();
    };
    let line = |x1, y1, x2, y2, dash: Option<&str>| Primitive::Line {
        x1,
        y1,
        x2,
        y2,
        stroke: Color::from(look.theme().grid_color),
        stroke_width: 1.0,
        stroke_dasharray: dash.map(str::to_owned),
    };
    let (top, bottom) = (
        computed.margin_top,
        computed.height - computed.margin_bottom,
    );
    let (left, right) = (computed.margin_left, computed.width - computed.margin_right);
    let count = ((high - low) / step).round() as u32;
    let mut lines: Vec<Primitive> = (1..=count)
        .map(|i| computed.map_x(low + f64::from(i) * step))
        .map(|x| line(x, top, x, bottom, None))
        .collect();
    if let ChartAxis::Names(names) = &chart.y
        && rows_a_name(chart) > 1
    {
        let between = (1..names.len()).map(|i| computed.map_y(i as f64 + 0.5));
        lines.extend(between.map(|y| line(left, y, right, y, Some("2 3"))));
    }
    lines
}

/// For each layer, how many of the lines drawn over it could hide it, limited by the space
/// available.
fn under(layers: &[Layer]) -> Vec<usize> {
    const MOST: usize = 4;
    let is_line = |layer: &Layer| {
        matches!(
            layer,
            Layer::Points {
                style: PointStyle::Line | PointStyle::Area,
                ..
            }
        )
    };
    let later = |i: usize| {
        layers[i + 1..]
            .iter()
            .filter(|layer| is_line(layer))
            .count()
    };
    let each = layers.iter().enumerate();
    each.map(|(i, layer)| {
        if is_line(layer) {
            later(i).min(MOST)
        } else {
            0
        }
    })
    .collect()
}
