//! Charts of results. Each report's file says what its charts show; `draw.rs` draws them and is
//! the only file that uses the drawing library.
//!
//! | file | what it is |
//! |---|---|
//! | `chart.rs` | a chart as data: axes, layers, marks, legend |
//! | `comparison.rs`, `sweep.rs`, `optimum.rs`, `curve.rs` | the charts of each report |
//! | `draw.rs` | a chart as SVG |
//! | `legend.rs`, `marks.rs` | what is below and above a chart |
//! | `look.rs` | colours and fonts, for a paper and for a page |

mod chart;
mod comparison;
#[cfg(feature = "onnx")]
mod curve;
mod draw;
mod legend;
mod look;
mod marks;
mod optimum;
mod sweep;

pub use chart::ChartKind;
pub use comparison::COMPARISON_CHARTS;
#[cfg(feature = "onnx")]
pub use curve::curve_chart;
pub use optimum::OPTIMUM_CHARTS;
pub use sweep::SWEEP_CHARTS;

pub(super) use chart::{Chart, short};
pub(super) use draw::for_page;
pub(super) use sweep::method_words;
