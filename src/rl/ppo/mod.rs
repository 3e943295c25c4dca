//! Masked proximal policy optimisation with the meaning that Stable-Baselines3 gives
//! every hyper-parameter.

mod advantage;
mod loss;
mod masked;
mod rollout;
mod settings;
mod update;

pub use advantage::advantages;
pub use loss::{Sample, Terms, sample_loss};
pub use masked::{likeliest, log_softmax, sample};
pub use rollout::{GROUP, Group};
pub use settings::Settings;
pub use update::{Learner, Rows};
