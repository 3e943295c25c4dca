//! The search for robust strategies, and the game of a line.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod budgets;
#[path = "../common/mod.rs"]
mod common;
mod game;
mod game_payoffs;
mod optimize;
mod optimize_verb;
mod ranking;
mod saved_strategy;
mod scores;
