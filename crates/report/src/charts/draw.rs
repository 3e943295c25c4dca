//! A chart as SVG, drawn with kuva, which draws axes, bars, lines, areas, markers and
//! intervals. What kuva lacks is added to its scene: a legend of dashed lines with markers, a
//! grid behind horizontal bars, marks that avoid each other.

use super::chart::{Bar, Chart, GROUP, Ink, Layer, Point, Scale, Style, beside, short};
use super::legend;
use super::look::{Look, dark_style, dashes, marker};
use super::marks;
use crate::page::escape;
use crate::provenance::Provenance;
use kuva::backend::svg::SvgBackend;
use kuva::plot::band::BandPlot;
use kuva::plot::bar::BarPlot;
use kuva::plot::line::{LinePlot, LineStyle};
use kuva::plot::scatter::ScatterPlot;
use kuva::render::color::Color;
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

/// Width of every chart [px]: shown across a printed page of 170 mm its text is 9 point.
pub(super) const WIDTH: f64 = 720.0;
/// Height between the axes if y is a number [px].
const HEIGHT: f64 = 330.0;
/// Height of one bar or one row of points, and of the space between two names [px].
const ROW: f64 = 15.0;
const GAP: f64 = 12.0;
/// Size of all text [px].
pub(super) const TEXT: u32 = 13;
/// Radius of markers [px].
const MARKER: f64 = 3.6;
/// Maximum number of characters of a name beside the axis.
const NAME: usize = 44;
/// Height of a chart's own title [px], and its maximum number of characters.
const TITLE: f64 = 24.0;
const TITLE_CHARACTERS: usize = 84;
/// Distance between the axes and the bars' numbers to the right of them [px].
const TO_NUMBERS: f64 = 8.0;

/// The chart as a standalone SVG file that states how it was made.
pub(crate) fn for_paper(chart: &Chart, made: &Provenance) -> String {
    let about = format!("{} {}", chart.note(), made.one_line());
    svg(chart, Look::Paper, &about)
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

/// Removes kuva's clip path. It would cut markers on the edges in half. Besides, kuva numbers
/// its paths throughout the process, but equal charts must give equal bytes. The axes contain
/// everything that is drawn anyway.
fn unclip(scene: &mut Scene) {
    let clip =
        |element: &Primitive| matches!(element, Primitive::ClipStart { .. } | Primitive::ClipEnd);
    scene.elements.retain(|element| !clip(element));
    scene.defs.retain(|text| !text.starts_with("<clipPath"));
}

/// Text that an XML file can contain: names come from users' files.
fn clean(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// Text that kuva does not interpret as mathematics between dollar signs.
pub(super) fn label(text: &str) -> String {
    clean(text).replace('$', "\\$")
}

fn scene(chart: &Chart, look: Look) -> Scene {
    let names = match &chart.y {
        Scale::Names(names) => names.len(),
        Scale::Numbers { .. } => 0,
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
    // The data start where kuva starts to clip.
    let data = scene
        .elements
        .iter()
        .position(|element| matches!(element, Primitive::ClipStart { .. }));
    let at = data.unwrap_or(scene.elements.len());
    scene.elements.splice(at..at, behind);
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

fn bars(chart: &Chart) -> impl Iterator<Item = (usize, usize, usize, &Bar)> {
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
        .map(|(.., bar)| legend::width(&bar.words))
        .fold(0.0, f64::max)
}

/// The value of each bar, in a column to the right of the axes where nothing is drawn.
fn bar_numbers(chart: &Chart, computed: &ComputedLayout) -> Vec<Primitive> {
    let Scale::Names(names) = &chart.y else {
        return Vec::new();
    };
    let right = WIDTH - 4.0;
    let number = |(i, j, count, bar): (usize, usize, usize, &Bar)| {
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
    let range = |scale: &Scale| match scale {
        Scale::Numbers { low, high, .. } => (*low, *high),
        Scale::Names(names) => (0.5, names.len() as f64 + 0.5),
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
    if let Scale::Numbers { title, step, .. } = &chart.x {
        layout = layout
            .with_x_label(label(title))
            // Closer to its ticks than to the legend.
            .with_x_label_offset(0.0, -7.0)
            .with_x_tick_step(*step)
            .with_x_tick_format(TickFormat::Fixed(decimals(*step)));
    }
    match &chart.y {
        Scale::Numbers { title, step, .. } => layout
            .with_y_label(label(title))
            .with_y_tick_step(*step)
            .with_y_tick_format(TickFormat::Fixed(decimals(*step))),
        Scale::Names(names) => {
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
    let Scale::Numbers {
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
    if let Scale::Names(names) = &chart.y
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
                style: Style::Line | Style::Area,
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

/// How the layer is drawn. A line below others is wider and its markers are larger, so that
/// lines which coincide all remain visible.
fn plots(layer: &Layer, names: usize, look: Look, under: usize) -> Vec<Plot> {
    match layer {
        Layer::Bars(groups) => {
            let mut plot = BarPlot::new().with_horizontal(true).with_width(GROUP);
            let mut tips = Vec::new();
            // kuva counts upwards.
            for group in groups.iter().rev() {
                let bars = group.iter().rev();
                tips.extend(bars.clone().map(|bar| clean(&bar.tip)));
                plot = plot.with_group("", bars.map(|bar| (bar.value, look.bar_colour(bar.ink))));
            }
            if look == Look::Page {
                plot = plot.with_tooltip_labels(tips);
            }
            vec![Plot::Bar(plot)]
        }
        Layer::Points { ink, style, points } => {
            points_plots(*ink, *style, points, names, look, under)
        }
    }
}

fn points_plots(
    ink: Ink,
    style: Style,
    points: &[Point],
    names: usize,
    look: Look,
    under: usize,
) -> Vec<Plot> {
    /// How much wider a line and its markers become for each line over it [px].
    const WIDER: f64 = 1.4;
    const LARGER: f64 = 1.2;
    let under = under as f64;
    let colour = look.colour(ink);
    // Names are counted downwards from 0; kuva counts them upwards to their number.
    let y = |point: &Point| match names {
        0 => point.y,
        _ => names as f64 - point.y,
    };
    let place = |point: &Point| (point.x, y(point));
    let joined = matches!(style, Style::Line | Style::Area | Style::Bare);
    let area = style == Style::Area;
    let mut plots = Vec::new();
    if area && points.len() > 1 {
        let end = |point: &Point, upper: bool| {
            let (low, high) = point.along.unwrap_or((point.y, point.y));
            if upper { high } else { low }
        };
        let band = BandPlot::new(
            points.iter().map(|point| point.x),
            points.iter().map(|point| end(point, false)),
            points.iter().map(|point| end(point, true)),
        );
        plots.push(Plot::Band(
            band.with_color(colour.clone()).with_opacity(0.18),
        ));
    }
    if joined {
        let style = dashes(ink).map_or(LineStyle::Solid, |dash| LineStyle::Custom(dash.into()));
        let line = LinePlot::new()
            .with_data(points.iter().map(place))
            .with_color(colour.clone())
            .with_stroke_width(1.6 + WIDER * under)
            .with_line_style(style);
        plots.push(Plot::Line(line));
    }
    if style == Style::Bare {
        return plots;
    }
    let mut dots = ScatterPlot::new()
        .with_data(points.iter().map(place))
        .with_color(colour)
        .with_marker(marker(ink))
        .with_size(match style {
            Style::Dots => MARKER,
            Style::Intervals => 0.0,
            // Points on a line are close to each other.
            Style::Line | Style::Area | Style::Bare => MARKER - 0.9 + LARGER * under,
        });
    for (dot, point) in dots.data.iter_mut().zip(points) {
        let about = |centre: f64, interval: Option<(f64, f64)>| {
            interval
                .filter(|(low, high)| low < high)
                .map(|(low, high)| (centre - low, high - centre))
        };
        dot.x_err = about(point.x, point.across);
        dot.y_err = about(point.y, point.along.filter(|_| !area));
    }
    if look == Look::Page && points.iter().any(|point| !point.tip.is_empty()) {
        dots = dots.with_tooltip_labels(points.iter().map(|point| clean(&point.tip)));
    }
    plots.push(Plot::Scatter(dots));
    plots
}
