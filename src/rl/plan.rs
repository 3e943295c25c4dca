//! All settings of a training, and the presets.

use super::domain::{ClosedInterval, Domain};
use super::imitation::Imitation;
use super::ppo::{GROUP, PpoSettings};
use super::reward::Reward;
use crate::decision::observation::{Layout, View};
use crate::error::{Error, Result, known_names, shown};
use crate::nn::{Activation, Architecture};
use crate::setters::setters;
use serde::{Deserialize, Serialize};

/// Maximum number of samples of an update, which take some gigabytes of memory.
const MOST_SAMPLES: usize = 10_000_000;
/// A cure that several checks share.
const ABOVE: &str = "give a number above 0";

/// Which network of a training becomes the policy.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Keep {
    /// The one with the best score on the built-in cases.
    #[default]
    Best,
    /// The one at the end. Nothing is chosen by the cases then, so that it can be judged on them.
    Last,
}

/// All settings of a training except its seed and stations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Plan {
    /// Name of the preset on which it is based.
    pub preset: String,
    /// Name of the observation's view.
    pub view: String,
    /// Number of slots, K.
    pub slots: usize,
    /// Whether waiting is an action.
    pub wait: bool,
    /// Layers and activation of the network.
    pub architecture: Architecture,
    /// The reward of an episode.
    pub reward: Reward,
    /// How stations and patterns are drawn.
    pub domain: Domain,
    /// Hyper-parameters of proximal policy optimisation (PPO).
    pub ppo: PpoSettings,
    /// The expert to imitate before the network plays on its own.
    pub imitation: Option<Imitation>,
    /// Number of decisions to learn from.
    pub steps: u64,
    /// Number of patterns drawn for a phase.
    pub courses: usize,
    /// Updates per phase, after which new patterns are drawn; fewer if the training would have
    /// fewer than seven phases.
    pub updates: usize,
    /// Which network becomes the policy.
    #[serde(default)]
    pub keep: Keep,
}

setters!(Plan {
    /// With the observation's view of this name.
    fn with_view(view: &str);
    /// With this number of slots.
    fn with_slots(slots: usize);
    /// With waiting as an action, or without it.
    fn with_wait(wait: bool);
    /// With this network.
    fn with_architecture(architecture: Architecture);
    /// With this reward of an episode.
    fn with_reward(reward: Reward);
    /// With this training domain.
    fn with_domain(domain: Domain);
    /// With these hyper-parameters of PPO.
    fn with_ppo(ppo: PpoSettings);
    /// With this expert imitated first, or none.
    fn with_imitation(imitation: impl Into<Option<Imitation>>);
    /// With this number of decisions to learn from.
    fn with_steps(steps: u64);
    /// With this number of patterns drawn for a phase.
    fn with_courses(courses: usize);
    /// With this maximum number of updates per phase.
    fn with_updates(updates: usize);
    /// With this network as the policy.
    fn with_keep(keep: Keep);
});

/// The presets by name, with one line each for help texts.
pub const PRESETS: [(&str, &str); 2] = [
    (
        "default",
        "the best settings found for PPO: permutation-equivariant scorer, full observation",
    ),
    (
        "paper",
        "Table 1 of the paper: MLP 64-64 tanh on its own observation",
    ),
];

impl Plan {
    /// The preset with this name.
    ///
    /// # Errors
    /// The name is unknown.
    pub fn preset(name: &str) -> Result<Self> {
        let names = PRESETS.map(|preset| preset.0);
        match name {
            "default" => Ok(Self {
                preset: name.into(),
                view: View::Full.name().into(),
                slots: 16,
                wait: false,
                architecture: Architecture::Scorer {
                    width: 64,
                    activation: Activation::Relu,
                },
                reward: Reward {
                    pick: 0.05,
                    rate: 0.2,
                },
                domain: Domain::BROAD,
                ppo: PpoSettings {
                    n_envs: 64,
                    n_steps: 128,
                    batch_size: 1024,
                    n_epochs: 4,
                    gamma: 0.9995,
                    ent_coef: 0.005,
                    learning_rate: 1e-3,
                    anneal: true,
                    ..PpoSettings::SB3
                },
                imitation: None,
                steps: 12_000_000,
                courses: 256,
                updates: 24,
                keep: Keep::Best,
            }),
            "paper" => Ok(Self {
                preset: name.into(),
                view: View::Paper.name().into(),
                slots: Layout::PAPER.slots,
                wait: Layout::PAPER.wait,
                architecture: Architecture::Mlp {
                    hidden: vec![64, 64],
                    activation: Activation::Tanh,
                },
                reward: Reward::PAPER,
                domain: Domain::BROAD,
                ppo: PpoSettings::PAPER,
                imitation: None,
                steps: 3_000_000,
                courses: 256,
                updates: 96,
                keep: Keep::Best,
            }),
            _ => Err(Error::usage(
                "'preset'",
                format!("unknown preset `{}`", shown(name)),
                known_names(name, &names),
            )),
        }
    }

    /// Checks that the plan is valid.
    ///
    /// # Errors
    /// Names the key of an invalid value.
    pub fn check(&self) -> Result<()> {
        self.layout()?;
        self.architecture.check()?;
        let (ppo, domain) = (&self.ppo, &self.domain);
        let samples = ppo.n_envs.saturating_mul(ppo.n_steps);
        let ordered = |(low, high): ClosedInterval| low > 0.0 && low <= high && high.is_finite();
        let (least, most) = domain.items;
        let drawn = domain.source()?.is_none();
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let unit = |x: f32| (0.0..=1.0).contains(&x);
        let positive = |x: f32| x > 0.0 && x.is_finite();
        let weight = |x: f32| x >= 0.0 && x.is_finite();
        let count = |n: usize| (1..=1_000_000).contains(&n);
        let passes = |n: usize| (1..=1_000).contains(&n);
        let mut checks = vec![
            (
                "ppo.n_envs and ppo.n_steps",
                (1..=MOST_SAMPLES).contains(&samples) && ppo.n_envs.is_multiple_of(GROUP),
                "give environments in multiples of 8, and at most 10 million samples per update",
            ),
            ("ppo.batch_size", ppo.batch_size > 0, "give 1 or more"),
            ("ppo.n_epochs", passes(ppo.n_epochs), "give 1 to 1000"),
            ("ppo.gamma", unit(ppo.gamma), "give 0 to 1"),
            ("ppo.gae_lambda", unit(ppo.gae_lambda), "give 0 to 1"),
            ("ppo.clip_range", positive(ppo.clip_range), ABOVE),
            ("ppo.ent_coef", weight(ppo.ent_coef), "give 0 or more"),
            ("ppo.vf_coef", weight(ppo.vf_coef), "give 0 or more"),
            ("ppo.max_grad_norm", positive(ppo.max_grad_norm), ABOVE),
            ("ppo.learning_rate", positive(ppo.learning_rate), ABOVE),
            ("ppo.target_kl", ppo.target_kl.is_none_or(positive), ABOVE),
            ("reward.pick", self.reward.pick.is_finite(), "give a number"),
            ("reward.rate", self.reward.rate.is_finite(), "give a number"),
            (
                "domain.spacing",
                ordered(domain.spacing),
                "give two numbers [m] above 0, the lower first",
            ),
            (
                "domain.speed",
                ordered(domain.speed),
                "give two factors above 0, the lower first",
            ),
            (
                "domain.items",
                1 <= least && least <= most && most <= 100_000,
                "give two counts from 1 to 100,000, the lower first",
            ),
            ("domain.grids", share(domain.grids), "give 0 to 1"),
            ("domain.failing", share(domain.failing), "give 0 to 1"),
            (
                "domain.grasp_success",
                share(domain.grasp_success.0)
                    && share(domain.grasp_success.1)
                    && domain.grasp_success.0 <= domain.grasp_success.1,
                "give two probabilities, the lower first",
            ),
            ("domain.curriculum", share(domain.curriculum), "give 0 to 1"),
            (
                "domain.curriculum",
                drawn || domain.curriculum == 0.0,
                "give 0: all patterns of a set ('domain.patterns') are played from the beginning",
            ),
            (
                "domain.items",
                drawn || least == most,
                "give the same count twice: the patterns of a set ('domain.patterns') have as many items",
            ),
            (
                "domain.update_hz",
                domain.update_hz == 0.0 || (1.0..=1e6).contains(&domain.update_hz),
                "give 0 for exact, or 1 to 1,000,000 Hz",
            ),
            ("courses", count(self.courses), "give 1 to 1,000,000"),
            ("updates", count(self.updates), "give 1 to 1,000,000"),
        ];
        if let Some(imitation) = &self.imitation {
            checks.extend([
                (
                    "imitation.rounds",
                    passes(imitation.rounds),
                    "give 1 to 1000",
                ),
                (
                    "imitation.courses",
                    count(imitation.courses),
                    "give 1 to 1,000,000",
                ),
                (
                    "imitation.epochs",
                    passes(imitation.epochs),
                    "give 1 to 1000",
                ),
                (
                    "imitation.learning_rate",
                    positive(imitation.learning_rate),
                    ABOVE,
                ),
            ]);
        }
        match checks.into_iter().find(|(_, fits, _)| !fits) {
            None => Ok(()),
            Some((key, _, cure)) => {
                let problem = "the value is not valid";
                Err(Error::usage(
                    format!("the training plan: {key}"),
                    problem,
                    cure,
                ))
            }
        }
    }

    /// Shape of observations and actions.
    ///
    /// # Errors
    /// An unknown view, no slots or too many slots.
    pub fn layout(&self) -> Result<Layout> {
        Layout::new(self.view.parse()?, self.slots, self.wait)
    }
}
