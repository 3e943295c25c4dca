//! Learns from collected samples.

use super::loss::{Sample, Terms, sample_loss};
use super::rollout::Group;
use super::settings::PpoSettings;
use crate::nn::{Adam, Network, ObservationBatch, Workspace, clip_gradient};
use rand::Rng;
use rand::seq::SliceRandom;
use rayon::prelude::*;

/// Number of samples that one thread processes at once. It is fixed because the order in which
/// gradients are added must not depend on the number of threads.
const CHUNK: usize = 128;

/// The learner: network, parameters, optimiser and buffers.
#[derive(Debug)]
pub struct Learner {
    /// The network, without its parameters.
    pub network: Network,
    /// The parameters of the network, flat.
    pub parameters: Vec<f32>,
    /// The state of the optimiser Adam.
    pub adam: Adam,
    chunks: Vec<Chunk>,
    gradient: Vec<f32>,
}

#[derive(Debug, Default)]
struct Chunk {
    observations: Vec<f32>,
    masks: Vec<bool>,
    samples: Vec<Sample>,
    work: Workspace,
    logits: Vec<f32>,
    values: Vec<f32>,
    gradient: Vec<f32>,
    terms: Terms,
}

/// A minibatch, row by row: observation, mask, sample.
pub type Minibatch<'a> = Vec<(&'a [f32], &'a [bool], Sample)>;

impl Learner {
    /// A learner that starts with these parameters.
    pub fn new(network: Network, parameters: Vec<f32>) -> Self {
        let adam = network.adam(1e-5);
        Self {
            gradient: vec![0.0; network.parameters()],
            network,
            parameters,
            adam,
            chunks: Vec::new(),
        }
    }

    /// Makes one step of Adam on one minibatch. Returns the means of the terms and the norm of
    /// the gradient before clipping.
    pub fn minibatch(
        &mut self,
        rows: &Minibatch,
        settings: &PpoSettings,
        learning_rate: f32,
    ) -> (Terms, f32) {
        let normal = normaliser(rows, settings);
        let loss = |sample: &Sample, mask: &[bool], logits: &mut [f32], value: &mut f32| {
            let sample = Sample {
                advantage: (sample.advantage - normal.0) * normal.1,
                ..*sample
            };
            sample_loss(&sample, mask, (logits, value), settings, rows.len())
        };
        self.descend(rows, &loss, settings.max_grad_norm, learning_rate)
    }

    /// Makes one step of Adam against the gradient of any loss. `loss` turns the logits and the
    /// value of a row into their derivatives and returns the terms.
    pub(crate) fn descend<L>(
        &mut self,
        rows: &Minibatch,
        loss: &L,
        max_grad_norm: f32,
        learning_rate: f32,
    ) -> (Terms, f32)
    where
        L: Fn(&Sample, &[bool], &mut [f32], &mut f32) -> Terms + Sync,
    {
        let parts: Vec<_> = rows.chunks(CHUNK).collect();
        if self.chunks.len() < parts.len() {
            self.chunks.resize_with(parts.len(), Chunk::default);
        }
        let (network, parameters) = (&self.network, &self.parameters);
        self.chunks
            .par_iter_mut()
            .zip(&parts)
            .for_each(|(chunk, part)| chunk.learn(network, parameters, part, loss));
        self.gradient.fill(0.0);
        let mut terms = Terms::default();
        for chunk in &self.chunks[..parts.len()] {
            terms += chunk.terms;
            self.gradient
                .iter_mut()
                .zip(&chunk.gradient)
                .for_each(|(g, c)| *g += c);
        }
        let norm = clip_gradient(&mut self.gradient, max_grad_norm);
        self.adam
            .step(learning_rate, &self.gradient, &mut self.parameters);
        (terms.mean(rows.len()), norm)
    }

    /// Makes all passes over the samples of `groups`; returns the terms of the last pass.
    pub fn update(
        &mut self,
        groups: &[Group],
        settings: &PpoSettings,
        learning_rate: f32,
        rng: &mut impl Rng,
    ) -> Terms {
        let (size, wide) = match groups.first() {
            Some(group) if !group.is_empty() => (
                group.observations.len() / group.len(),
                group.masks.len() / group.len(),
            ),
            _ => return Terms::default(),
        };
        let each = groups[0].len();
        let mut order: Vec<usize> = (0..groups.iter().map(Group::len).sum()).collect();
        let row = |place: &usize| {
            let (group, at) = (&groups[place / each], place % each);
            let sample = Sample {
                action: group.actions[at] as usize,
                log_probability: group.log_probabilities[at],
                advantage: group.advantages[at],
                target: group.advantages[at] + group.values[at],
            };
            let observation = &group.observations[at * size..][..size];
            (observation, &group.masks[at * wide..][..wide], sample)
        };
        let mut last = Terms::default();
        for _ in 0..settings.n_epochs {
            order.shuffle(rng);
            let (mut sum, mut batches) = (Terms::default(), 0);
            for part in order.chunks(settings.batch_size) {
                let rows: Minibatch = part.iter().map(row).collect();
                let (terms, _) = self.minibatch(&rows, settings, learning_rate);
                sum += terms;
                batches += 1;
                let too_far = |most: f32| terms.divergence > 1.5 * f64::from(most);
                if settings.target_kl.is_some_and(too_far) {
                    return sum.mean(batches);
                }
            }
            last = sum.mean(batches);
        }
        last
    }
}

/// Mean of the advantages and the reciprocal of their standard deviation, computed as by
/// torch's `std`.
fn normaliser(rows: &Minibatch, settings: &PpoSettings) -> (f32, f32) {
    if !settings.normalize_advantage || rows.len() < 2 {
        return (0.0, 1.0);
    }
    let advantages = || rows.iter().map(|row| f64::from(row.2.advantage));
    let mean = advantages().sum::<f64>() / rows.len() as f64;
    let squares: f64 = advantages().map(|a| (a - mean) * (a - mean)).sum();
    let deviation = (squares / (rows.len() - 1) as f64).sqrt();
    (mean as f32, (1.0 / (deviation + 1e-8)) as f32)
}

impl Chunk {
    fn learn<L>(
        &mut self,
        network: &Network,
        parameters: &[f32],
        part: &[(&[f32], &[bool], Sample)],
        loss: &L,
    ) where
        L: Fn(&Sample, &[bool], &mut [f32], &mut f32) -> Terms,
    {
        self.observations.clear();
        self.masks.clear();
        self.samples.clear();
        for (observation, mask, sample) in part {
            self.observations.extend_from_slice(observation);
            self.masks.extend_from_slice(mask);
            self.samples.push(*sample);
        }
        let batch = ObservationBatch {
            observations: &self.observations,
            masks: &self.masks,
            rows: part.len(),
        };
        network.forward(parameters, batch, &mut self.work);
        self.terms = Terms::default();
        let wide = self.masks.len() / part.len();
        self.logits.clear();
        self.logits
            .extend_from_slice(&self.work.logits[..part.len() * wide]);
        self.values.clear();
        self.values
            .extend_from_slice(&self.work.values[..part.len()]);
        let outputs = self.logits.chunks_exact_mut(wide).zip(&mut self.values);
        let inputs = self.samples.iter().zip(self.masks.chunks_exact(wide));
        for ((sample, mask), (logits, value)) in inputs.zip(outputs) {
            self.terms += loss(sample, mask, logits, value);
        }
        self.gradient.resize(network.parameters(), 0.0);
        self.gradient.fill(0.0);
        let outputs = (self.logits.as_slice(), self.values.as_slice());
        network.backward(
            parameters,
            batch,
            outputs,
            &mut self.work,
            &mut self.gradient,
        );
    }
}
