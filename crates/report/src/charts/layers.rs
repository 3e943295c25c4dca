//! The layers of a chart as plots of kuva.

use super::chart::{ChartPoint, GROUP, Ink, Layer, PointStyle};
use super::labels::clean;
use super::look::{Look, dashes, marker};
use kuva::plot::band::BandPlot;
use kuva::plot::bar::BarPlot;
use kuva::plot::line::{LinePlot, LineStyle};
use kuva::plot::scatter::ScatterPlot;
use kuva::render::plots::Plot;
use pickline::stats::Interval;

/// Radius of markers [px].
const MARKER: f64 = 3.6;

/// How the layer is drawn. A line below others is wider and its markers are larger, so that
/// lines which coincide all remain visible.
pub(super) fn plots(layer: &Layer, names: usize, look: Look, under: usize) -> Vec<Plot> {
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
    style: PointStyle,
    points: &[ChartPoint],
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
    let y = |point: &ChartPoint| match names {
        0 => point.y,
        _ => names as f64 - point.y,
    };
    let place = |point: &ChartPoint| (point.x, y(point));
    let joined = matches!(
        style,
        PointStyle::Line | PointStyle::Area | PointStyle::Bare
    );
    let area = style == PointStyle::Area;
    let mut plots = Vec::new();
    if area && points.len() > 1 {
        plots.push(band(points, &colour));
    }
    if joined {
        let places = points.iter().map(place).collect();
        plots.push(line(places, ink, &colour, 1.6 + WIDER * under));
    }
    if style == PointStyle::Bare {
        return plots;
    }
    let mut dots = ScatterPlot::new()
        .with_data(points.iter().map(place))
        .with_color(colour)
        .with_marker(marker(ink))
        .with_size(match style {
            PointStyle::Dots => MARKER,
            PointStyle::Intervals => 0.0,
            // Points on a line are close to each other.
            PointStyle::Line | PointStyle::Area | PointStyle::Bare => MARKER - 0.9 + LARGER * under,
        });
    for (dot, point) in dots.data.iter_mut().zip(points) {
        let about = |centre: f64, interval: Option<Interval>| {
            interval
                .filter(Interval::is_wide)
                .map(|interval| (centre - interval.low, interval.high - centre))
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

/// A line through `places` in the dashes of `ink`, so wide [px].
fn line(places: Vec<(f64, f64)>, ink: Ink, colour: &str, width: f64) -> Plot {
    let style = dashes(ink).map_or(LineStyle::Solid, |dash| LineStyle::Custom(dash.into()));
    let line = LinePlot::new().with_data(places).with_color(colour);
    Plot::Line(line.with_stroke_width(width).with_line_style(style))
}

/// The intervals of `points` along y as one area.
fn band(points: &[ChartPoint], colour: &str) -> Plot {
    let ends = |point: &ChartPoint| point.along.unwrap_or(Interval::point(point.y));
    let band = BandPlot::new(
        points.iter().map(|point| point.x),
        points.iter().map(|point| ends(point).low),
        points.iter().map(|point| ends(point).high),
    );
    Plot::Band(band.with_color(colour).with_opacity(0.18))
}
