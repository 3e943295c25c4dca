//! Strategies: how each is written, and how it is created for a line and for every run.

mod blueprint;
mod registry;
mod spec;

pub use blueprint::Blueprint;
pub(crate) use blueprint::Setup;
pub(crate) use registry::HAS_POLICY;
pub use registry::{
    POLICY, STRATEGIES, StrategyKind, default_strategy, forms, help, is_policy, parse, policy_file,
    read_alone, weight_files,
};
pub use spec::{StrategySpec, default_assignment};
