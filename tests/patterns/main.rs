//! Patterns of items: feeds, files, recordings.

#[path = "../common/mod.rs"]
mod common;
mod feeds;
mod parsers;
mod recordings;
mod spreadsheets;
