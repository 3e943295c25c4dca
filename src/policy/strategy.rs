//! A policy that decides.

use super::model::{Policy, PolicyState};
use crate::decision::observation::Encoder;
use crate::decision::{Action, Snapshot, Strategy};
use crate::error::Result;

/// Takes the allowed action of the largest logit; the mask is applied here as well, as a
/// graph need not have one.
#[derive(Debug)]
pub struct PolicyStrategy {
    name: String,
    /// None if tract has no room for it, which it had when the policy was loaded.
    state: Option<PolicyState>,
    encoder: Encoder,
    observation: Vec<f32>,
    mask: Vec<bool>,
    logits: Vec<f32>,
}

impl PolicyStrategy {
    /// A strategy that is written `name`.
    pub fn new(name: String, policy: &Policy) -> Self {
        let layout = policy.layout();
        Self {
            name,
            state: policy.state().ok(),
            encoder: Encoder::new(layout),
            observation: vec![0.0; layout.observation()],
            mask: vec![false; layout.actions()],
            logits: vec![0.0; layout.actions()],
        }
    }
}

impl Strategy for PolicyStrategy {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.encoder
            .encode(snapshot, &mut self.observation, &mut self.mask);
        // A network that ran when it was loaded runs; if it should not, its robot takes
        // the item furthest downstream rather than nothing.
        let ran = self.state.as_mut().is_some_and(|state| {
            let (observation, mask) = (&self.observation, &self.mask);
            state.logits(observation, mask, &mut self.logits).is_ok()
        });
        if !ran {
            return Action::Pick(0);
        }
        let mut best: Option<usize> = None;
        for action in (0..self.mask.len()).filter(|action| self.mask[*action]) {
            if best.is_none_or(|best| self.logits[action] > self.logits[best]) {
                best = Some(action);
            }
        }
        let action = best.map(|best| self.encoder.action(snapshot, best));
        // Allowed actions are legal.
        action.and_then(Result::ok).unwrap_or(Action::Pick(0))
    }

    fn name(&self) -> String {
        self.name.clone()
    }
}
