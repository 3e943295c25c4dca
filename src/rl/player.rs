//! A network as a strategy, without a file in between.

use super::ppo::likeliest;
use crate::decision::observation::{Encoder, Layout};
use crate::decision::{Action, Snapshot, Strategy};
use crate::nn::{Network, ObservationBatch, Workspace};

/// Chooses the most likely action of a network.
#[derive(Debug)]
pub struct NetworkPlayer<'a> {
    network: &'a Network,
    parameters: &'a [f32],
    encoder: Encoder,
    observation: Vec<f32>,
    mask: Vec<bool>,
    work: Workspace,
}

impl<'a> NetworkPlayer<'a> {
    /// A player with this network.
    pub fn new(network: &'a Network, parameters: &'a [f32], layout: Layout) -> Self {
        Self {
            network,
            parameters,
            encoder: Encoder::new(layout),
            observation: vec![0.0; layout.observation()],
            mask: vec![false; layout.actions()],
            work: Workspace::default(),
        }
    }
}

impl Strategy for NetworkPlayer<'_> {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.encoder
            .encode(snapshot, &mut self.observation, &mut self.mask);
        let batch = ObservationBatch {
            observations: &self.observation,
            masks: &self.mask,
            rows: 1,
        };
        self.network.decide(self.parameters, batch, &mut self.work);
        let best = likeliest(&self.work.logits[..self.mask.len()], &self.mask);
        // The most likely allowed action is always legal.
        self.encoder
            .action(snapshot, best)
            .unwrap_or(Action::Pick(0))
    }

    fn name(&self) -> String {
        "network".into()
    }
}
