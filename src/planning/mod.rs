//! Looking ahead: strategies that simulate forward from the situation they see.

mod horizon;
mod lookahead;
mod meter;
mod options;
mod plan;
mod rollout;
mod search;

pub use lookahead::Lookahead;
pub use meter::Budget;
pub use options::{Goal, KEYS, Options};
