//! Planning over a horizon, and the certified bound.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod bound;
mod bound_effort;
mod bound_limits;
mod bound_verb;
mod brute_force;
#[path = "../common/mod.rs"]
mod common;
mod foresight;
mod lookahead;
mod real_lines;
