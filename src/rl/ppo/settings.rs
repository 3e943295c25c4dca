//! The hyper-parameters, with the names, meaning and defaults of Stable-Baselines3's
//! `PPO`.

use crate::setters::setters;
use serde::{Deserialize, Serialize};

/// Settings of PPO: Schulman et al., "Proximal policy optimization algorithms", arXiv
/// 1707.06347.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct PpoSettings {
    /// Number of environments stepped in parallel.
    pub n_envs: usize,
    /// Steps of each environment between two updates.
    pub n_steps: usize,
    /// Number of samples in a minibatch.
    pub batch_size: usize,
    /// Passes over the samples of an update.
    pub n_epochs: usize,
    /// Discount factor per decision, from 0 to 1.
    pub gamma: f32,
    /// Lambda of the generalised advantage estimate.
    pub gae_lambda: f32,
    /// How far the probability ratio may move from 1.
    pub clip_range: f32,
    /// Weight of the entropy in the loss.
    pub ent_coef: f32,
    /// Weight of the value loss in the loss.
    pub vf_coef: f32,
    /// The gradient is clipped to this norm.
    pub max_grad_norm: f32,
    /// Learning rate of Adam.
    pub learning_rate: f32,
    /// Whether the learning rate falls linearly to 0 over the training.
    pub anneal: bool,
    /// Whether advantages are normalised over each minibatch.
    pub normalize_advantage: bool,
    /// The update ends early if the divergence exceeds 1.5 times this; `None` to never end
    /// early.
    pub target_kl: Option<f32>,
}

setters!(PpoSettings {
    /// With this number of environments stepped in parallel.
    fn with_n_envs(n_envs: usize);
    /// With this number of steps of each environment between two updates.
    fn with_n_steps(n_steps: usize);
    /// With minibatches of this number of samples.
    fn with_batch_size(batch_size: usize);
    /// With this number of passes over the samples of an update.
    fn with_n_epochs(n_epochs: usize);
    /// With this discount factor per decision.
    fn with_gamma(gamma: f32);
    /// With this lambda of the generalised advantage estimate.
    fn with_gae_lambda(gae_lambda: f32);
    /// With probability ratios that may move this far from 1.
    fn with_clip_range(clip_range: f32);
    /// With this weight of the entropy.
    fn with_ent_coef(ent_coef: f32);
    /// With this weight of the value loss.
    fn with_vf_coef(vf_coef: f32);
    /// With the gradient clipped to this norm.
    fn with_max_grad_norm(max_grad_norm: f32);
    /// With this learning rate.
    fn with_learning_rate(learning_rate: f32);
    /// With a learning rate that falls linearly to 0, or a constant one.
    fn with_anneal(anneal: bool);
    /// With advantages normalised over each minibatch, or as they are.
    fn with_normalize_advantage(normalize_advantage: bool);
    /// With updates that end early beyond 1.5 times this divergence, or never.
    fn with_target_kl(target_kl: impl Into<Option<f32>>);
});

impl PpoSettings {
    /// Stable-Baselines3's defaults with one environment.
    pub const SB3: Self = Self {
        n_envs: 1,
        n_steps: 2048,
        batch_size: 64,
        n_epochs: 10,
        gamma: 0.99,
        gae_lambda: 0.95,
        clip_range: 0.2,
        ent_coef: 0.0,
        vf_coef: 0.5,
        max_grad_norm: 0.5,
        learning_rate: 3e-4,
        anneal: false,
        normalize_advantage: true,
        target_kl: None,
    };

    /// The paper's Table 1: 2048 steps per update, here by eight environments together;
    /// everything else as in Stable-Baselines3.
    pub const PAPER: Self = Self {
        n_envs: 8,
        n_steps: 256,
        gamma: 0.9995,
        ..Self::SB3
    };

    /// Number of samples of an update.
    pub fn samples(&self) -> usize {
        self.n_envs * self.n_steps
    }
}
