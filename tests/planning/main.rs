//! Planning over a horizon, and the certified bound.

mod bound;
mod bound_verb;
#[path = "../common/mod.rs"]
mod common;
mod lookahead;
