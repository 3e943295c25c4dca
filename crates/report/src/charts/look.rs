//! The colours, markers and dashes of inks, for a paper and for a page.

use super::chart::Ink;
use crate::palette::{PAPER, SERIES, mixed};
use kuva::plot::scatter::MarkerShape;
use kuva::render::theme::Theme;

/// Where a chart is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// In print: black on white.
    Paper,
    /// On a page whose style sheet defines the colours and follows the reader's light or dark
    /// scheme.
    Page,
}

/// Share of the colour in its light tint.
const TINT: f64 = 0.5;

impl Look {
    /// The colour of `ink`.
    pub(super) fn colour(self, ink: Ink) -> String {
        match (self, ink) {
            (Self::Paper, Ink::Series(i)) => SERIES[0][i % SERIES[0].len()].into(),
            (Self::Page, Ink::Series(i)) => format!("var(--series-{})", i % SERIES[1].len()),
            (Self::Paper, Ink::Text) => "#000000".into(),
            (Self::Page, Ink::Text) => "var(--ink)".into(),
            (Self::Paper, Ink::Faint) => "#666666".into(),
            (Self::Page, Ink::Faint) => "var(--faint)".into(),
        }
    }

    /// The colour of a bar of `ink`. If there are more series than colours, the second round
    /// has lighter tints, because bars have no shape to distinguish them.
    pub(super) fn bar_colour(self, ink: Ink) -> String {
        let colour = self.colour(ink);
        match (self, ink) {
            (Self::Paper, Ink::Series(i)) if tinted(i) => mixed(&colour, self.ground(), TINT),
            (Self::Page, Ink::Series(i)) if tinted(i) => {
                let percent = 100.0 * TINT;
                format!("color-mix(in srgb, {colour} {percent}%, {})", self.ground())
            }
            _ => colour,
        }
    }

    /// The background colour.
    pub(super) fn ground(self) -> &'static str {
        match self {
            Self::Paper => PAPER[0],
            Self::Page => "var(--paper)",
        }
    }

    /// Colours of axes, grid, text and background.
    pub(super) fn theme(self) -> Theme {
        let of = |paper: &str, page: &str| match self {
            Self::Paper => paper.to_owned(),
            Self::Page => page.to_owned(),
        };
        Theme {
            background: of(self.ground(), "none"),
            axis_color: of("#000000", "var(--ink)"),
            grid_color: of("#dddddd", "var(--rule)"),
            tick_color: of("#000000", "var(--ink)"),
            text_color: of("#000000", "var(--ink)"),
            font_family: Some(of(
                "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif",
                "system-ui, sans-serif",
            )),
            ..Theme::light()
        }
    }
}

/// Rules that make a chart for a paper follow a dark scheme on a screen. They override the
/// colours of the elements. Programs without style sheets, and printers, ignore them.
pub(super) fn dark_style() -> String {
    let [light, dark] = SERIES;
    let [paper, night] = PAPER;
    let mut pairs: Vec<(String, String)> = [
        (paper, night),
        ("#000000", "#e6edf3"),
        ("#dddddd", "#3d444d"),
        ("#666666", "#9198a1"),
    ]
    .map(|(from, to)| (from.into(), to.into()))
    .into();
    for (from, to) in light.iter().zip(dark) {
        pairs.push(((*from).into(), to.into()));
        pairs.push((mixed(from, paper, TINT), mixed(to, night, TINT)));
    }
    let rule = |(from, to): &(String, String)| {
        format!("[fill=\"{from}\"]{{fill:{to}}}[stroke=\"{from}\"]{{stroke:{to}}}")
    };
    let rules: String = pairs.iter().map(rule).collect();
    format!("\n<style>@media screen and (prefers-color-scheme: dark) {{ {rules} }}</style>")
}

fn tinted(series: usize) -> bool {
    (series / SERIES[0].len()) % 2 == 1
}

/// The marker of `ink`. The number of markers and the number of colours have no common factor,
/// so no two of 56 series look alike.
pub(super) fn marker(ink: Ink) -> MarkerShape {
    const SHAPES: [MarkerShape; 8] = [
        MarkerShape::Circle,
        MarkerShape::Square,
        MarkerShape::Triangle,
        MarkerShape::Diamond,
        MarkerShape::TriangleDown,
        MarkerShape::Star,
        MarkerShape::Pentagon,
        MarkerShape::Plus,
    ];
    match ink {
        Ink::Series(i) => SHAPES[i % SHAPES.len()],
        Ink::Faint => MarkerShape::Circle,
        Ink::Text => MarkerShape::Cross,
    }
}

/// The dashes of a line of `ink`, so that lines which coincide both remain visible.
pub(super) fn dashes(ink: Ink) -> Option<&'static str> {
    const DASHES: [Option<&str>; 4] = [None, Some("7 4"), Some("2 3"), Some("9 3 2 3")];
    match ink {
        Ink::Series(i) => DASHES[i % DASHES.len()],
        Ink::Text | Ink::Faint => None,
    }
}
