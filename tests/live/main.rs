//! Live control: the controller message by message, the node as a program among others.

mod aim;
#[cfg(unix)]
#[path = "../common/authority.rs"]
mod authority;
mod behaviour;
mod belt;
mod claims;
mod claims_random;
mod clock;
#[path = "../common/mod.rs"]
mod common;
#[cfg(unix)]
mod csv;
#[cfg(feature = "dashboard")]
mod dashboard;
#[cfg(unix)]
mod emulated;
mod identity;
#[cfg(unix)]
mod journal;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod log;
mod operator;
#[cfg(unix)]
mod peers;
#[cfg(unix)]
#[path = "../common/programs.rs"]
mod programs;
#[cfg(all(unix, feature = "mcap"))]
mod recording;
mod recovery;
#[cfg(unix)]
mod remarks;
#[cfg(unix)]
mod service;
mod simulated;
mod stamps;
#[cfg(unix)]
mod stdout;
mod support;
#[cfg(unix)]
#[path = "../common/trouble.rs"]
mod trouble;
#[cfg(unix)]
mod values;
#[cfg(unix)]
mod world;
