//! Two engines, one answer: the general event loop takes any strategy, the cascade
//! takes rules only and shares work between assignments.

mod cascade;
mod claims;
mod event_loop;
mod queue;
mod scene;
mod trace;
mod tree;

pub use cascade::Cascade;
pub use event_loop::{simulate, simulate_observed, simulate_rules};
pub use scene::Scene;
pub use trace::Trace;
pub use tree::AssignmentTree;
