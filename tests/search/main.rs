//! The search for robust strategies, and the game of a line.

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
