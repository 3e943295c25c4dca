//! Collects samples: every group of environments plays on its own under a fixed policy, so that
//! threads never wait for each other between two steps.

use super::advantage::advantages;
use super::masked::{log_softmax, sample};
use super::settings::PpoSettings;
use crate::decision::Figures;
use crate::decision::observation::Layout;
use crate::error::Result;
use crate::nn::{Network, ObservationBatch, Workspace};
use crate::pattern::random_stream;
use crate::rl::environment::DispatchEnvironment;
use crate::rl::reward::Reward;
use crate::sim::Scene;
use rand::rngs::ChaCha8Rng;

/// Environments in a group: enough for fast matrix products, few enough that every thread has
/// groups to play.
pub const GROUP: usize = 8;

/// The samples of one group: rows in order of time, environments side by side.
#[derive(Debug)]
pub struct Group<'a> {
    environments: Vec<DispatchEnvironment<'a>>,
    rng: ChaCha8Rng,
    work: Workspace,
    /// The row after the last: observation and mask of the next decision.
    next: (Vec<f32>, Vec<bool>),
    /// Observations [steps, environments, observation].
    pub observations: Vec<f32>,
    /// Masks [steps, environments, actions].
    pub masks: Vec<bool>,
    /// Actions [steps, environments].
    pub actions: Vec<u32>,
    /// Log-probabilities of the actions [steps, environments].
    pub log_probabilities: Vec<f32>,
    /// Advantages [steps, environments].
    pub advantages: Vec<f32>,
    /// Values [steps, environments].
    pub values: Vec<f32>,
    rewards: Vec<f32>,
    ended: Vec<bool>,
    /// Figures of the completed episodes.
    pub episodes: Vec<Figures>,
}

impl<'a> Group<'a> {
    /// Environments `first`, `first + 1`, ... of those under `seed`.
    ///
    /// # Errors
    /// As for [`DispatchEnvironment::new`].
    pub fn new(
        scenes: &'a [Scene<'a>],
        layout: Layout,
        reward: Reward,
        (first, count): (usize, usize),
        seed: u64,
    ) -> Result<Self> {
        let indices = first as u64..(first + count) as u64;
        let make = |index| DispatchEnvironment::new(scenes, layout, reward, (seed, index));
        let mut environments: Vec<_> = indices.map(make).collect::<Result<_>>()?;
        let (size, actions) = (layout.observation(), layout.actions());
        let mut next = (vec![0.0; count * size], vec![false; count * actions]);
        let rows = next
            .0
            .chunks_exact_mut(size)
            .zip(next.1.chunks_exact_mut(actions));
        for (environment, (observation, mask)) in environments.iter_mut().zip(rows) {
            environment.reset(observation, mask);
        }
        Ok(Self {
            environments,
            // Streams beyond those of the environments.
            rng: random_stream(seed, (1 << 32) + first as u64),
            work: Workspace::default(),
            next,
            observations: Vec::new(),
            masks: Vec::new(),
            actions: Vec::new(),
            log_probabilities: Vec::new(),
            advantages: Vec::new(),
            values: Vec::new(),
            rewards: Vec::new(),
            ended: Vec::new(),
            episodes: Vec::new(),
        })
    }

    /// Number of samples collected.
    pub fn len(&self) -> usize {
        self.actions.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.actions.is_empty()
    }

    /// Plays `settings.n_steps` steps and computes the advantages.
    ///
    /// # Errors
    /// Never under this policy; the environments return a `Result`.
    pub fn collect(
        &mut self,
        network: &Network,
        parameters: &[f32],
        settings: &PpoSettings,
    ) -> Result<()> {
        let count = self.environments.len();
        self.observations.clear();
        self.masks.clear();
        self.actions.clear();
        self.log_probabilities.clear();
        self.values.clear();
        self.rewards.clear();
        self.ended.clear();
        self.episodes.clear();
        for _ in 0..settings.n_steps {
            self.forward(network, parameters);
            self.observations.extend_from_slice(&self.next.0);
            self.masks.extend_from_slice(&self.next.1);
            self.values.extend_from_slice(&self.work.values[..count]);
            let size = self.next.0.len() / count;
            let wide = self.next.1.len() / count;
            for (index, environment) in self.environments.iter_mut().enumerate() {
                let logits = &mut self.work.logits[index * wide..][..wide];
                let mask = &mut self.next.1[index * wide..][..wide];
                log_softmax(logits, mask);
                let action = sample(logits, &mut self.rng);
                self.log_probabilities.push(logits[action]);
                let observation = &mut self.next.0[index * size..][..size];
                let step = environment.step(action, observation, mask)?;
                self.actions.push(action as u32);
                self.rewards.push(step.reward as f32);
                self.ended.push(step.ended.is_some());
                self.episodes.extend(step.ended);
            }
        }
        self.forward(network, parameters);
        self.estimate(settings);
        Ok(())
    }

    fn forward(&mut self, network: &Network, parameters: &[f32]) {
        let batch = ObservationBatch {
            observations: &self.next.0,
            masks: &self.next.1,
            rows: self.environments.len(),
        };
        network.forward(parameters, batch, &mut self.work);
    }

    fn estimate(&mut self, settings: &PpoSettings) {
        let count = self.environments.len();
        let steps = settings.n_steps;
        self.advantages.resize(count * steps, 0.0);
        let column = |from: &[f32], index: usize| -> Vec<f32> {
            from.iter().skip(index).step_by(count).copied().collect()
        };
        let mut advantage = vec![0.0; steps];
        for index in 0..count {
            let rewards = column(&self.rewards, index);
            let values = column(&self.values, index);
            let ended: Vec<bool> = self
                .ended
                .iter()
                .skip(index)
                .step_by(count)
                .copied()
                .collect();
            let discount = (settings.gamma, settings.gae_lambda);
            let after = self.work.values[index];
            advantages((&rewards, &values, &ended), after, discount, &mut advantage);
            for (step, advantage) in advantage.iter().enumerate() {
                self.advantages[step * count + index] = *advantage;
            }
        }
    }
}
