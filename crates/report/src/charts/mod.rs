//! Charts as data, and how they are drawn. What the charts of a report show is said beside the
//! report.
//!
//! | file | what it is |
//! |---|---|
//! | `chart.rs`, `axis.rs` | a chart as data: axes, layers, marks, legend |
//! | `kind.rs` | the kinds of charts of a report, by name |
//! | `curve.rs`, `curves.rs` | the chart of a training run, and of several |
//! | `draw.rs` | a chart as SVG |
//! | `layers.rs`, `marks.rs`, `legend.rs` | what is inside, above and below the axes |
//! | `labels.rs`, `signs.rs` | text and markers |
//! | `look.rs` | colours and fonts, for a paper and for a page |

mod axis;
mod chart;
#[cfg(feature = "onnx")]
mod curve;
mod curves;
mod draw;
mod kind;
mod labels;
mod layers;
mod legend;
mod look;
mod marks;
mod signs;

pub use curves::{LearningCurve, learning_curves_svg};
pub use kind::ChartKind;

pub(crate) use axis::{ChartAxis, percent};
pub(crate) use chart::{
    Chart, ChartBar, ChartMark, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch, beside,
};
#[cfg(feature = "onnx")]
pub(crate) use curve::curve_chart;
pub(crate) use draw::for_page;
pub(crate) use labels::short;
