//! The markers of series and the dashes of marks, in the chart and in its legend.

use super::chart::Ink;
use super::labels::TEXT;
use super::look::{Look, marker};
use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::render::render::{Primitive, Scene, render_legend_at};

/// Dash and gap of a mark [px].
const ON: f64 = 5.0;
const OFF: f64 = 3.0;

/// The dashes of a standalone mark.
pub(super) fn dash() -> String {
    format!("{ON} {OFF}")
}

/// The marker of `ink` around a position. kuva's legends draw the same markers, one shape after
/// another, but not with a line through them.
pub(super) fn sign(ink: Ink, look: Look, x: f64, y: f64) -> Vec<Primitive> {
    // kuva centres a marker here in its legend.
    const MIDDLE: (f64, f64) = (10.0, 6.0);
    let only = LegendEntry {
        label: String::new(),
        color: look.colour(ink),
        shape: LegendShape::Marker(marker(ink)),
        dasharray: None,
    };
    let mut scene = Scene::new(0.0, 0.0);
    let (x, y) = (x - MIDDLE.0, y - MIDDLE.1);
    let theme = look.theme();
    render_legend_at(
        &[only],
        None,
        None,
        false,
        &mut scene,
        x,
        y,
        0.0,
        TEXT,
        &theme,
    );
    let shapes = scene.elements.into_iter();
    shapes
        .filter(|element| !matches!(element, Primitive::Text { .. }))
        .collect()
}
