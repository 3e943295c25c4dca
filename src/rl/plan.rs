//! Everything that a training is made from, and the presets.

use super::domain::Domain;
use super::imitation::Imitation;
use super::nn::{Activation, Architecture, Shape};
use super::ppo::Settings;
use super::reward::Reward;
use crate::decision::observation::{Layout, View};
use crate::error::{Error, Result, known_names, shown};
use serde::{Deserialize, Serialize};

/// A training, but for its seed and the stations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the preset that it began as.
    pub preset: String,
    /// Name of the observation's view.
    pub view: String,
    /// Slots, K.
    pub slots: usize,
    /// Whether waiting is an action.
    pub wait: bool,
    /// The network.
    pub architecture: Architecture,
    /// What an episode is worth.
    pub reward: Reward,
    /// What is trained on.
    pub domain: Domain,
    /// Hyper-parameters.
    pub ppo: Settings,
    /// Whom the network imitates before it plays on its own.
    pub imitation: Option<Imitation>,
    /// Decisions to learn from.
    pub steps: u64,
    /// Patterns drawn for a phase.
    pub courses: usize,
    /// Updates of a phase, after which patterns are drawn anew.
    pub updates: usize,
}

/// The presets by name, with a line for help texts.
pub const PRESETS: [(&str, &str); 2] = [
    (
        "default",
        "the best found for PPO: permutation-equivariant scorer, full observation",
    ),
    (
        "paper",
        "Table 1 of the paper: MLP 64-64 tanh on its own observation",
    ),
];

impl Plan {
    /// The preset of that name.
    ///
    /// # Errors
    /// An unknown name.
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
                ppo: Settings {
                    n_envs: 64,
                    n_steps: 128,
                    batch_size: 1024,
                    n_epochs: 4,
                    gamma: 0.9995,
                    ent_coef: 0.005,
                    learning_rate: 1e-3,
                    anneal: true,
                    ..Settings::SB3
                },
                imitation: None,
                steps: 12_000_000,
                courses: 256,
                updates: 24,
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
                ppo: Settings::PAPER,
                imitation: None,
                steps: 3_000_000,
                courses: 256,
                updates: 96,
            }),
            _ => Err(Error::input(
                "--preset",
                format!("unknown preset `{}`", shown(name)),
                known_names(name, &names),
            )),
        }
    }

    /// Shape of observations and actions.
    ///
    /// # Errors
    /// An unknown view, no slots or too many.
    pub fn layout(&self) -> Result<Layout> {
        if !(1..=Layout::MOST_SLOTS).contains(&self.slots) {
            return Err(Error::input(
                "slots",
                format!("{} slots", self.slots),
                format!("give 1 to {}", Layout::MOST_SLOTS),
            ));
        }
        Ok(Layout {
            view: self.view.parse()?,
            slots: self.slots,
            wait: self.wait,
        })
    }
}

/// The network's shape for a layout.
pub fn shape(layout: &Layout) -> Shape {
    Shape {
        globals: layout.globals(),
        slots: layout.slots,
        slot_features: layout.slot_features(),
        wait: layout.wait,
    }
}
