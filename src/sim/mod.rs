//! Two engines, one answer: the general event loop takes any strategy, the cascade
//! takes rules only and shares work between assignments.

mod announcer;
mod cascade;
mod claims;
mod event_loop;
mod queue;
mod run;
mod scene;
mod trace;
mod tree;
mod view;

pub use cascade::Cascade;
pub use event_loop::{simulate, simulate_observed, simulate_rules};
pub use run::{Run, RunBuffers};
pub use scene::Scene;
pub use trace::Trace;
pub use tree::AssignmentTree;
