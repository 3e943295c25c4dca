//! Experiments: strategies side by side on the same patterns. They return data and
//! print nothing.

mod case;
mod compare;
mod method;
pub mod paper;

pub use case::{Case, CaseSource, DENSE, PAPER, load_cases};
pub use compare::{CaseResult, Comparison, MethodResult, compare};
pub use method::Method;
