//! Planning: strategies that simulate forward from the current situation, and the bound for
//! every strategy.

pub mod bound;
mod horizon;
mod lookahead;
mod meter;
mod options;
mod plan;
mod rollout;
mod search;
mod timing;

pub use lookahead::Lookahead;
pub use meter::{Allowance, Budget};
pub use options::{Goal, LookaheadOptions};
pub(crate) use options::{KEYS, WrittenOptions};
