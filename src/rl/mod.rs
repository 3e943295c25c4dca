//! The station as a decision process: environment, networks, training.

mod batch;
mod courses;
mod demonstration;
pub mod domain;
mod environment;
mod evaluation;
mod imitation;

mod plan;
mod plan_file;
mod player;
pub mod ppo;
mod reward;
#[cfg(feature = "onnx")]
mod score;
mod trainer;

pub use batch::Batch;
pub use courses::Courses;
pub use demonstration::Demonstration;
#[cfg(feature = "onnx")]
pub(crate) use domain::check_drawn_classes;
pub use domain::{Course, Domain};
pub use environment::{DispatchEnvironment, Step};
pub use evaluation::{Trial, TrialName};
pub use imitation::Imitation;
pub use plan::{Keep, PRESETS, Plan};
pub use player::NetworkPlayer;
pub use reward::Reward;
#[cfg(feature = "onnx")]
pub use score::{
    Curve, CurvePoint, Judged, Kept, Record, ShareOfGreedy, TrainingEvaluation, TrainingResults,
    TrialRecord,
};
pub use trainer::{Checkpoint, Phase, Round, Trainer};
