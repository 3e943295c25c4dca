//! Patterns of items: feeds, files, recordings.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

#[path = "../common/mod.rs"]
mod common;
mod feeds;
mod parsers;
mod recordings;
mod spreadsheets;
