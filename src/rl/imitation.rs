//! Learning from a strategy that plans: from its answers in the states that the network itself
//! reaches.
//!
//! Ross, Gordon, Bagnell, "A reduction of imitation learning and structured prediction to
//! no-regret online learning" (DAgger), arXiv 1011.0686. In the first round the expert plays;
//! in later rounds the network plays and the expert says what it would have done.

use super::player::NetworkPlayer;
use super::ppo::{Learner, Minibatch, PpoSettings, Sample, Terms, log_softmax};
use super::reward::Reward;
use crate::decision::observation::{Encoder, Layout};
use crate::decision::{Action, Strategy, answer};
use crate::error::Result;
use crate::nn::Network;
use crate::setters::setters;
use crate::sim::{Run, Scene};
use rand::Rng;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};

/// The expert and the amount of learning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Imitation {
    /// The expert, as [`strategies::parse`](crate::strategies::parse) reads it.
    pub strategy: String,
    /// Number of rounds, at least 1.
    pub rounds: usize,
    /// Number of patterns in each round.
    pub courses: usize,
    /// Passes over all answers so far, after each round.
    pub epochs: usize,
    /// Learning rate, falling linearly to 0 over each round.
    pub learning_rate: f32,
}

setters!(Imitation {
    /// With this number of rounds.
    fn with_rounds(rounds: usize);
    /// With this number of patterns in each round.
    fn with_courses(courses: usize);
    /// With this number of passes over all answers after each round.
    fn with_epochs(epochs: usize);
    /// With this learning rate.
    fn with_learning_rate(learning_rate: f32);
});

impl Imitation {
    /// The default amount of learning from this expert.
    pub fn of(strategy: &str) -> Self {
        Self {
            strategy: strategy.to_owned(),
            rounds: 10,
            courses: 500,
            epochs: 6,
            learning_rate: 1e-3,
        }
    }
}

/// Answers of the expert, one row per decision.
#[derive(Debug, Default)]
pub(crate) struct Answers {
    /// Observations [rows, observation].
    observations: Vec<f32>,
    /// Masks [rows, actions].
    masks: Vec<bool>,
    /// The expert's actions [rows].
    actions: Vec<usize>,
    /// Discounted rewards from the decision to the end of the episode [rows].
    returns: Vec<f32>,
}

/// Who plays while the expert answers.
pub(crate) enum Pupil<'a> {
    /// The expert itself.
    Expert,
    /// This network, with these parameters.
    Network(&'a Network, &'a [f32]),
}

impl Answers {
    /// Number of answers.
    pub(crate) fn len(&self) -> usize {
        self.actions.len()
    }

    /// Whether there are no answers.
    pub(crate) fn is_empty(&self) -> bool {
        self.actions.is_empty()
    }

    /// Appends the answers of another episode.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.observations.append(&mut other.observations);
        self.masks.append(&mut other.masks);
        self.actions.append(&mut other.actions);
        self.returns.append(&mut other.returns);
    }

    /// Plays `scene` to its end and asks `expert` at every decision. Answers without a slot are
    /// ignored. Returns are discounted by `gamma` per decision.
    ///
    /// # Errors
    /// The expert acts illegally.
    pub(crate) fn collect(
        scene: &Scene,
        expert: &mut dyn Strategy,
        pupil: &Pupil,
        layout: Layout,
        reward: Reward,
        gamma: f32,
    ) -> Result<Self> {
        let mut answers = Self::default();
        let mut encoder = Encoder::new(layout);
        let mut observation = vec![0.0; layout.observation()];
        let mut mask = vec![false; layout.actions()];
        let mut player = match pupil {
            Pupil::Expert => None,
            Pupil::Network(network, parameters) => {
                Some(NetworkPlayer::new(network, parameters, layout))
            }
        };
        let mut rewards: Vec<f64> = Vec::new();
        let mut answered = Vec::new();
        let mut run = Run::new(scene);
        while let Some(snapshot) = run.next_decision() {
            let advice = answer(expert, &snapshot)?;
            encoder.encode(&snapshot, &mut observation, &mut mask);
            if let Some(index) = encoder.index_of(advice) {
                answers.observations.extend_from_slice(&observation);
                answers.masks.extend_from_slice(&mask);
                answers.actions.push(index);
                answered.push(rewards.len());
            }
            let action = player
                .as_mut()
                .map_or(advice, |player| player.decide(&snapshot));
            let weight = match action {
                Action::Pick(place) => snapshot.candidates[place].weight,
                Action::WaitUntil(_) | Action::WaitForNextWindow | Action::NoAnswer => 0.0,
            };
            let picked = run.act(action)?.is_some();
            rewards.push(if picked { reward.of_pick(weight) } else { 0.0 });
        }
        if let Some(last) = rewards.last_mut() {
            *last += reward.of_end(&run.figures());
        }
        let mut sum = 0.0;
        for reward in rewards.iter_mut().rev() {
            sum = *reward + f64::from(gamma) * sum;
            *reward = sum;
        }
        answers.returns = answered.iter().map(|step| rewards[*step] as f32).collect();
        Ok(answers)
    }

    /// Trains `learner` on the answers: cross entropy of the actions, squared error of the
    /// values. Of the `settings`, batch size, the weight of the value's loss and the limit of the
    /// gradient apply. Returns the terms of the last pass.
    pub(crate) fn teach(
        &self,
        learner: &mut Learner,
        imitation: &Imitation,
        settings: &PpoSettings,
        rng: &mut impl Rng,
    ) -> Terms {
        if self.is_empty() {
            return Terms::default();
        }
        let batch_size = settings.batch_size;
        let size = self.observations.len() / self.len();
        let wide = self.masks.len() / self.len();
        let mut order: Vec<usize> = (0..self.len()).collect();
        let row = |at: &usize| {
            let sample = Sample {
                action: self.actions[*at],
                log_probability: 0.0,
                advantage: 0.0,
                target: self.returns[*at],
            };
            let observation = &self.observations[at * size..][..size];
            (observation, &self.masks[at * wide..][..wide], sample)
        };
        let mut last = Terms::default();
        let batches = self.len().div_ceil(batch_size) * imitation.epochs;
        let mut done = 0;
        for _ in 0..imitation.epochs {
            order.shuffle(rng);
            let mut sum = Terms::default();
            for part in order.chunks(batch_size) {
                let rows: Minibatch = part.iter().map(row).collect();
                let share = 1.0 / rows.len() as f32;
                let loss = |sample: &Sample, mask: &[bool], logits: &mut [f32], value: &mut f32| {
                    answer_loss(sample, mask, (logits, value), share, settings.vf_coef)
                };
                let rate = imitation.learning_rate * (1.0 - done as f32 / batches as f32);
                let (terms, _) = learner.descend(&rows, &loss, settings.max_grad_norm, rate);
                sum += terms;
                done += 1;
            }
            last = sum.mean(self.len().div_ceil(batch_size));
        }
        last
    }
}

/// Cross entropy and squared error of one row, which is the given `share` of its batch; logits
/// and value become derivatives.
fn answer_loss(
    sample: &Sample,
    mask: &[bool],
    (logits, value): (&mut [f32], &mut f32),
    share: f32,
    vf_coef: f32,
) -> Terms {
    log_softmax(logits, mask);
    let log = logits[sample.action];
    let right = logits.iter().all(|other| *other <= log);
    for (action, log) in logits.iter_mut().enumerate() {
        let taken = if action == sample.action { 1.0 } else { 0.0 };
        *log = share * (log.exp() - taken);
    }
    let error = *value - sample.target;
    *value = share * vf_coef * 2.0 * error;
    Terms {
        policy: -f64::from(log),
        value: f64::from(error * error),
        agreement: f64::from(u8::from(right)),
        ..Terms::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Snapshot;
    use crate::pattern::{Item, Pattern};
    use crate::sim::simulate;
    use crate::station::built_in;

    /// The first item, after a wait of a second at its first decision, for which the network
    /// of [`Layout::PAPER`] has no slot.
    struct Hesitant(bool);

    impl Strategy for Hesitant {
        fn decide(&mut self, snapshot: &Snapshot) -> Action {
            if std::mem::replace(&mut self.0, false) {
                return Action::WaitUntil(snapshot.time + 1.0);
            }
            Action::Pick(0)
        }

        fn name(&self) -> String {
            "hesitant".into()
        }
    }

    /// The value of a state is learned from these: as in [`crate::rl::Environment`], the picks
    /// count when they are made, the rate of the whole run at its end.
    #[test]
    fn returns_are_the_discounted_rewards_of_picks_and_end() {
        let station = built_in("paper").unwrap().station(Some(1)).unwrap();
        let item = |id: &str, x0: f64, weight: f64| Item {
            weight: Some(weight),
            ..Item::at(id, x0, -0.3)
        };
        // A metre apart: each is picked before the next one comes.
        let items = vec![
            item("a", 0.0, 0.5),
            item("b", -1.0, 1.0),
            item("c", -2.0, 0.2),
        ];
        let pattern = Pattern::new(items).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let reward = Reward {
            pick: 2.0,
            rate: 3.0,
        };
        for waits in [false, true] {
            let mut expert = Hesitant(waits);
            let answers = Answers::collect(
                &scene,
                &mut expert,
                &Pupil::Expert,
                Layout::PAPER,
                reward,
                0.5,
            );
            let returns = answers.unwrap().returns;
            let outcome = simulate(&scene, &mut Hesitant(waits)).unwrap();
            let rate = outcome.figures.weighted_rate();
            assert!(rate > 0.0);
            let third = 2.0 * 0.2 + 3.0 * rate;
            let second = 2.0 * 1.0 + 0.5 * third;
            let first = 2.0 * 0.5 + 0.5 * second;
            // A wait that cannot be learned leaves no row.
            assert_eq!(returns.len(), 3, "{waits}");
            for (found, expected) in returns.iter().zip([first, second, third]) {
                assert!((f64::from(*found) - expected).abs() < 1e-5, "{returns:?}");
            }
        }
    }

    #[test]
    fn the_loss_of_an_answer_has_the_slopes_of_its_definition() {
        let mask = [true, false, true, true];
        let (share, vf_coef, target) = (0.25, 0.5, -1.5);
        for (action, logits, value) in [
            (2, [0.3, 9.0, -0.4, 0.9], 0.7),
            (3, [0.3, 9.0, -0.4, 0.9], -2.0),
        ] {
            let parts = |logits: &[f64], value: f64| {
                let allowed = logits.iter().zip(mask).filter(|(_, allowed)| *allowed);
                let sum: f64 = allowed.map(|(logit, _)| logit.exp()).sum();
                (sum.ln() - logits[action], (value - target).powi(2))
            };
            let loss = |logits: &[f64], value: f64| {
                let (policy, error) = parts(logits, value);
                share * (policy + vf_coef * error)
            };
            let sample = Sample {
                action,
                log_probability: 0.0,
                advantage: 0.0,
                target: target as f32,
            };
            let mut slopes = logits.map(|logit| logit as f32);
            let mut slope = value as f32;
            let (share, vf_coef) = (share as f32, vf_coef as f32);
            let terms = answer_loss(&sample, &mask, (&mut slopes, &mut slope), share, vf_coef);
            let (policy, error) = parts(&logits, value);
            assert!((terms.policy - policy).abs() < 1e-6, "{terms:?}");
            assert!((terms.value - error).abs() < 1e-5, "{terms:?}");
            // Only the last of the allowed ones is the likeliest.
            assert_eq!(terms.agreement, if action == 3 { 1.0 } else { 0.0 });
            const STEP: f64 = 1e-5;
            for (place, slope) in slopes.into_iter().enumerate() {
                let moved = |by: f64| {
                    let mut logits = logits;
                    logits[place] += by;
                    loss(&logits, value)
                };
                let expected = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                assert!((f64::from(slope) - expected).abs() < 1e-6, "{place}");
            }
            let moved = |by: f64| loss(&logits, value + by);
            let expected = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            assert!((f64::from(slope) - expected).abs() < 1e-6);
        }
    }
}
