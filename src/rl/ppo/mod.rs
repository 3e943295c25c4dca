//! Masked proximal policy optimisation. Every hyper-parameter has the same meaning as in
//! Stable-Baselines3.

mod advantage;
mod loss;
mod masked;
mod rollout;
mod settings;
mod update;

pub use advantage::advantages;
pub use loss::{Sample, Terms};
pub(crate) use masked::{likeliest, log_softmax};
pub use rollout::{GROUP, Group};
pub use settings::PpoSettings;
pub use update::{Learner, Minibatch};
