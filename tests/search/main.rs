//! The search for robust strategies, and the game of a line.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod budgets;
#[path = "../common/mod.rs"]
mod common;
mod exact;
mod game;
mod game_payoffs;
mod optimize;
mod optimize_verb;
mod race;
mod ranking;
#[path = "../common/real_lines.rs"]
mod real_lines;
mod saved_strategy;
mod scores;
