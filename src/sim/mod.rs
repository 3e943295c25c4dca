//! Two engines with identical results: the general event loop supports any strategy; the cascade
//! supports only rules and shares work between assignments.

mod announcer;
mod attempt;
mod buffers;
mod cascade;
mod claims;
mod class_run;
mod conditions;
mod disturbances;
mod downtimes;
mod event_loop;
mod outages;
mod prefixes;
mod queue;
mod run;
mod scene;
mod trace;
mod truth;
mod tree;
mod updates;
mod view;
mod windows;

pub use buffers::RunBuffers;
pub use cascade::Cascade;
pub(crate) use cascade::LineState;
pub use class_run::{ClassRun, class_runs};
pub use conditions::Conditions;
pub use disturbances::Disturbances;
pub use event_loop::{simulate, simulate_observed, simulate_rules, simulate_while};
pub use outages::{Outage, RandomOutages};
pub use prefixes::PrefixGraph;
pub use run::Run;
pub use scene::Scene;
pub(crate) use scene::check_offered;
pub use trace::Trace;
pub use tree::AssignmentTree;
pub use truth::TrueClass;
