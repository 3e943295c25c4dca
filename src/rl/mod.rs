//! The station as a decision process: environment, networks, training.

mod batch;
pub mod domain;
mod environment;
mod evaluation;
pub mod nn;
mod plan;
mod player;
pub mod ppo;
mod reward;
mod trainer;

pub use batch::Batch;
pub use domain::{Course, Domain};
pub use environment::{Environment, Step};
pub use evaluation::Trial;
pub use plan::{PRESETS, Plan, shape};
pub use player::Player;
pub use reward::Reward;
pub use trainer::{Checkpoint, Phase, Trainer};
