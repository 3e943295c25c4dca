//! Planning: strategies that simulate forward from the situation they see, and what no
//! strategy can do better.

pub mod bound;
mod horizon;
mod lookahead;
mod meter;
mod options;
mod plan;
mod rollout;
mod search;

pub use lookahead::Lookahead;
pub use meter::{Allowance, Budget};
pub use options::{Goal, KEYS, Options};
