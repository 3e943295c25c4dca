//! Experiments: strategies compared on the same patterns. They return data and print nothing.

mod bounds;
mod case;
mod case_file;
mod class_result;
mod compare;
mod comparison;
mod draws;
mod method;
pub mod paper;
mod range;
mod robots_down;
mod sweep;
mod sweep_result;
mod threshold;
mod training;

pub use bounds::add_bounds;
pub use case::{Case, CaseSource, with_attributes};
pub use case_file::load_cases;
pub use class_result::{ClassBound, ClassResult, class_bounds};
pub use compare::{compare_in_shard, compare_methods};
pub use comparison::{CaseBound, CaseResult, Comparison, MethodResult};
pub use draws::Draws;
pub use method::{Method, MethodRun, policy_title};
pub(crate) use range::{Range, round_step, step_between};
pub use range::{ValueLimit, find_limits};
pub use robots_down::{HaltedPoint, HaltedRobot, ROBOTS_DOWN, RobotsDown, halt_each_robot};
pub use sweep::{Axis, Setting, sweep_in_shard, sweep_settings};
pub use sweep_result::{AS_GOOD, Limit, Sweep, SweepBound, SweepPoint, SweepValue, SweptMethod};
pub use threshold::{ChosenThreshold, ThresholdChoice, ThresholdChoices, choose_thresholds};
pub use training::training_set;
