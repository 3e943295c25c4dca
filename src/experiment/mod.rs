//! Experiments: strategies side by side on the same patterns. They return data and
//! print nothing.

mod case;
mod compare;
mod method;
pub mod paper;
mod sweep;

pub use case::{Case, CaseSource, DENSE, PAPER, load_cases};
pub use compare::{CaseResult, Comparison, MethodResult, compare};
pub use method::Method;
pub use sweep::{Axis, Limit, Range, Setting, Sweep, SweepPoint, sweep};
