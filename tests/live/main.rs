//! Live control: the controller message by message, the node as a program among others.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod aim;
#[cfg(unix)]
#[path = "../common/authority.rs"]
mod authority;
mod behaviour;
mod belt;
mod belt_waits;
mod camera_news;
mod claims;
mod claims_random;
mod clock;
#[path = "../common/mod.rs"]
mod common;
#[cfg(unix)]
mod csv;
#[cfg(feature = "dashboard")]
mod dashboard;
mod deadlines;
mod decisions;
#[cfg(unix)]
mod emulated;
#[cfg(unix)]
mod examples;
#[cfg(all(unix, feature = "mcap"))]
mod fit;
#[cfg(feature = "dashboard")]
mod host_header;
mod identity;
#[cfg(unix)]
mod journal;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod log;
mod messages;
mod operator;
mod orders;
#[cfg(unix)]
mod peers;
#[cfg(unix)]
#[path = "../common/programs.rs"]
mod programs;
#[cfg(all(unix, feature = "mcap"))]
mod recording;
mod recalls;
mod recovery;
mod redirects;
#[cfg(unix)]
mod remarks;
mod restarts;
mod robots_say;
#[cfg(unix)]
mod service;
mod simulated;
mod stamps;
#[cfg(unix)]
mod stdout;
mod support;
#[path = "../common/trouble.rs"]
mod trouble;
#[cfg(unix)]
mod unwanted;
mod values;
mod views;
#[cfg(unix)]
mod world;
