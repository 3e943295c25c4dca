//! A policy as a strategy.

use super::model::{Policy, PolicyState};
use crate::decision::observation::Encoder;
use crate::decision::{Action, Snapshot, Strategy};

/// Maximum number of observation values in a message.
const MOST_SHOWN: usize = 40;

/// Chooses the allowed action with the largest logit. The mask is applied here as well, because
/// a graph need not have one. If the logit of an allowed action is not finite, there is no
/// answer.
#[derive(Debug)]
pub struct PolicyStrategy {
    name: String,
    /// `None` if tract fails to create it, which it did not when the policy was loaded.
    state: Option<PolicyState>,
    encoder: Encoder,
    observation: Vec<f32>,
    mask: Vec<bool>,
    logits: Vec<f32>,
    /// Decisions so far.
    decisions: u64,
    trouble: Option<String>,
}

impl PolicyStrategy {
    /// A strategy that is called `name`.
    pub fn new(name: String, policy: &Policy) -> Self {
        let layout = policy.layout();
        Self {
            name,
            state: policy.state().ok(),
            encoder: Encoder::new(layout),
            observation: vec![0.0; layout.observation()],
            mask: vec![false; layout.actions()],
            logits: vec![0.0; layout.actions()],
            decisions: 0,
            trouble: None,
        }
    }

    /// The action with the largest logit, or what is wrong with the logits.
    fn answer(&mut self, snapshot: &Snapshot) -> std::result::Result<Action, String> {
        let (observation, mask) = (&self.observation, &self.mask);
        let state = self.state.as_mut().ok_or("the network has no state")?;
        let ran = state.logits(observation, mask, &mut self.logits);
        ran.map_err(|error| error.problem())?;
        let mut best: Option<usize> = None;
        for action in (0..self.mask.len()).filter(|action| self.mask[*action]) {
            let logit = self.logits[action];
            if !logit.is_finite() {
                return Err(format!("its logit for action {action} is {logit}"));
            }
            if best.is_none_or(|best| logit > self.logits[best]) {
                best = Some(action);
            }
        }
        let best = best.ok_or("no action is allowed")?;
        let action = self.encoder.action(snapshot, best);
        action.map_err(|error| error.problem())
    }

    /// `problem`, with the decision and the observation that caused it.
    fn report(&self, problem: &str) -> String {
        let shown = self.observation.iter().take(MOST_SHOWN);
        let shown: Vec<String> = shown.map(f32::to_string).collect();
        let rest = match self.observation.len().saturating_sub(MOST_SHOWN) {
            0 => String::new(),
            rest => format!(", and {rest} more"),
        };
        format!(
            "{problem} in its decision number {}\n  observation: [{}{rest}]",
            self.decisions,
            shown.join(", "),
        )
    }
}

impl Strategy for PolicyStrategy {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.decisions += 1;
        self.encoder
            .encode(snapshot, &mut self.observation, &mut self.mask);
        match self.answer(snapshot) {
            Ok(action) => action,
            Err(problem) => {
                self.trouble = Some(self.report(&problem));
                Action::NoAnswer
            }
        }
    }

    fn name(&self) -> String {
        self.name.clone()
    }

    fn trouble(&self) -> Option<String> {
        self.trouble.clone()
    }

    fn remedy(&self) -> String {
        "train this policy on stations and patterns like these and export it again".into()
    }
}
