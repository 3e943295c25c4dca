//! The permutation-equivariant scorer: one small network computes every slot's logit from the
//! slot's own features, the globals and pooled context. Reordering the slots reorders the
//! logits and changes nothing else. Masked slots have no influence.

use super::activation::Activation;
use super::init::orthogonal;
use super::linear::Linear;
use super::matrix::reserve;
use super::set_encoder::{Encoded, SetEncoder, SlotRows};
use super::shape::{ObservationBatch, Shape};
use rand::Rng;

/// Policy: `h_i = f(s_i, g)`, `c = (mean h, max h)`, `u_i = f(h_i, c)`, logit `w u_i`; waiting:
/// `w f(c, g)`. Value: a separate encoder, then `w f(c, g)`.
#[derive(Debug, Clone)]
pub struct Scorer {
    shape: Shape,
    activation: Activation,
    /// Policy: slots and globals to `h`.
    pub(crate) encoder: SetEncoder,
    /// `h_i` to `u_i`, without bias.
    pub(crate) slot: Linear,
    /// Context to `u`, with the bias.
    pub(crate) context: Linear,
    /// `u_i` to the logit.
    pub(crate) logit: Linear,
    /// Context and globals to the logit of waiting.
    pub(crate) wait: Option<Head>,
    /// Value: slots and globals to `h`.
    pub(crate) value_encoder: SetEncoder,
    /// Context and globals to the value.
    pub(crate) value: Head,
    parameters: usize,
}

/// `y = w f(c, g)`: one number from context and globals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Head {
    /// Context to hidden, without bias.
    pub context: Linear,
    /// Globals to hidden, with the bias.
    pub global: Linear,
    /// Hidden to the number.
    pub out: Linear,
}

/// Intermediate values of both passes.
#[derive(Debug, Default)]
pub(crate) struct ScorerBuffers {
    rows: SlotRows,
    policy: Encoded,
    value: Encoded,
    context: Vec<f32>,
    second: Vec<f32>,
    scores: Vec<f32>,
    second_gradient: Vec<f32>,
    scores_gradient: Vec<f32>,
    wait: HeadBuffers,
    value_head: HeadBuffers,
}

#[derive(Debug, Default)]
struct HeadBuffers {
    hidden: Vec<f32>,
    gradient: Vec<f32>,
    out: Vec<f32>,
}

impl Scorer {
    /// A scorer whose layers are all `width` wide.
    pub(crate) fn new(shape: Shape, width: usize, activation: Activation) -> Self {
        let mut next = 0;
        let head = |next: &mut usize| Head {
            context: Linear::new(2 * width, width, false, next),
            global: Linear::new(shape.globals, width, true, next),
            out: Linear::new(width, 1, true, next),
        };
        let encoder = SetEncoder::new(&shape, width, activation, &mut next);
        let slot = Linear::new(width, width, false, &mut next);
        let context = Linear::new(2 * width, width, true, &mut next);
        let logit = Linear::new(width, 1, false, &mut next);
        let wait = shape.wait.then(|| head(&mut next));
        let value_encoder = SetEncoder::new(&shape, width, activation, &mut next);
        let value = head(&mut next);
        Self {
            shape,
            activation,
            encoder,
            slot,
            context,
            logit,
            wait,
            value_encoder,
            value,
            parameters: next,
        }
    }

    /// Number of parameters of all layers.
    pub(crate) fn parameters(&self) -> usize {
        self.parameters
    }

    /// The activation between the layers.
    #[cfg(feature = "onnx")]
    pub(crate) fn activation(&self) -> Activation {
        self.activation
    }

    /// Sets orthogonal weights and zero biases.
    pub(crate) fn initialise(&self, parameters: &mut [f32], rng: &mut impl Rng) {
        let gain = 2f32.sqrt();
        self.encoder.initialise(parameters, rng);
        orthogonal(&self.slot, gain, parameters, rng);
        orthogonal(&self.context, 1.0, parameters, rng);
        orthogonal(&self.logit, 0.01, parameters, rng);
        self.value_encoder.initialise(parameters, rng);
        for (head, last) in self
            .wait
            .iter()
            .map(|w| (w, 0.01))
            .chain([(&self.value, 1.0)])
        {
            orthogonal(&head.context, gain, parameters, rng);
            orthogonal(&head.global, 1.0, parameters, rng);
            orthogonal(&head.out, last, parameters, rng);
        }
    }

    /// Computes `logits` [rows, actions] and `values` [rows] of the batch.
    pub(crate) fn forward(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        buffers: &mut ScorerBuffers,
        (logits, values): (&mut Vec<f32>, &mut Vec<f32>),
    ) {
        self.decide(parameters, batch, buffers, logits);
        let globals = (batch.observations, self.shape.observation());
        self.forward_value(parameters, globals, batch.rows, buffers, values);
    }

    /// Computes `logits` [rows, actions] of the batch.
    pub(crate) fn decide(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        buffers: &mut ScorerBuffers,
        logits: &mut Vec<f32>,
    ) {
        let observations = &batch.observations[..batch.rows * self.shape.observation()];
        let globals = (observations, self.shape.observation());
        buffers.rows.gather(&self.shape, observations, batch.masks);
        self.forward_policy(parameters, globals, batch.rows, buffers, logits);
    }

    /// Computes `logits` [count, actions].
    fn forward_policy(
        &self,
        parameters: &[f32],
        globals: (&[f32], usize),
        count: usize,
        b: &mut ScorerBuffers,
        logits: &mut Vec<f32>,
    ) {
        let (places, width) = (b.rows.places.len(), self.slot.outputs);
        self.encoder
            .forward(parameters, &b.rows, globals, &mut b.policy);
        reserve(&mut b.context, count * width);
        self.context.forward(
            parameters,
            &b.policy.pooled,
            2 * width,
            count,
            &mut b.context,
        );
        reserve(&mut b.second, places * width);
        for (range, context) in b.rows.ranges().zip(b.context.chunks_exact(width)) {
            for row in b.second[range.start * width..range.end * width].chunks_exact_mut(width) {
                row.copy_from_slice(context);
            }
        }
        self.slot
            .forward_add(parameters, &b.policy.slots, places, &mut b.second);
        self.activation.apply(&mut b.second[..places * width]);
        reserve(&mut b.scores, places);
        self.logit
            .forward(parameters, &b.second, width, places, &mut b.scores);
        let actions = self.shape.actions();
        reserve(logits, count * actions);
        for (place, score) in b.rows.places.iter().zip(&b.scores) {
            logits[place / self.shape.slots * actions + place % self.shape.slots] = *score;
        }
        if let Some(head) = &self.wait {
            head.forward(
                parameters,
                self.activation,
                &b.policy.pooled,
                globals,
                count,
                &mut b.wait,
            );
            for (row, wait) in logits.chunks_exact_mut(actions).zip(&b.wait.out[..count]) {
                row[actions - 1] = *wait;
            }
        }
    }

    /// Computes `values` [count].
    fn forward_value(
        &self,
        parameters: &[f32],
        globals: (&[f32], usize),
        count: usize,
        b: &mut ScorerBuffers,
        values: &mut Vec<f32>,
    ) {
        self.value_encoder
            .forward(parameters, &b.rows, globals, &mut b.value);
        let head = &mut b.value_head;
        self.value.forward(
            parameters,
            self.activation,
            &b.value.pooled,
            globals,
            count,
            head,
        );
        reserve(values, count);
        values[..count].copy_from_slice(&head.out[..count]);
    }

    /// Adds the gradient; see `Network::backward`.
    pub(crate) fn backward(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        (logits, values): (&[f32], &[f32]),
        buffers: &mut ScorerBuffers,
        gradient: &mut [f32],
    ) {
        let observations = &batch.observations[..batch.rows * self.shape.observation()];
        let globals = (observations, self.shape.observation());
        self.backward_value(parameters, globals, values, buffers, gradient);
        self.backward_policy(parameters, globals, batch.rows, logits, buffers, gradient);
    }

    /// Adds the gradient of the values.
    fn backward_value(
        &self,
        parameters: &[f32],
        globals: (&[f32], usize),
        values: &[f32],
        b: &mut ScorerBuffers,
        gradient: &mut [f32],
    ) {
        let (places, width) = (b.rows.places.len(), self.slot.outputs);
        reserve(&mut b.value.slots_gradient, places * width);
        b.value.slots_gradient[..places * width].fill(0.0);
        let (head, pooled) = (&mut b.value_head, &b.value.pooled);
        let to = &mut b.value.pooled_gradient;
        self.value.backward(
            parameters,
            self.activation,
            pooled,
            globals,
            values,
            head,
            (to, 0.0),
            gradient,
        );
        self.value_encoder
            .backward(&b.rows, globals, &mut b.value, gradient);
    }

    /// Adds the gradient of the logits.
    fn backward_policy(
        &self,
        parameters: &[f32],
        globals: (&[f32], usize),
        count: usize,
        logits: &[f32],
        b: &mut ScorerBuffers,
        gradient: &mut [f32],
    ) {
        let (places, width) = (b.rows.places.len(), self.slot.outputs);
        let actions = self.shape.actions();
        b.scores_gradient.clear();
        let slots = self.shape.slots;
        let of_place = |place: &usize| logits[place / slots * actions + place % slots];
        b.scores_gradient.extend(b.rows.places.iter().map(of_place));
        self.logit
            .backward(&b.second, width, places, &b.scores_gradient, gradient);
        reserve(&mut b.second_gradient, places * width);
        let second = &mut b.second_gradient[..places * width];
        self.logit
            .backward_input(parameters, &b.scores_gradient, places, 0.0, second);
        self.activation
            .backward(&b.second[..places * width], second);
        self.slot
            .backward(&b.policy.slots, width, places, second, gradient);
        reserve(&mut b.policy.slots_gradient, places * width);
        self.slot.backward_input(
            parameters,
            second,
            places,
            0.0,
            &mut b.policy.slots_gradient,
        );
        // The forward pass added the context to every slot of its row.
        for (range, context) in b.rows.ranges().zip(b.context.chunks_exact_mut(width)) {
            context.fill(0.0);
            for row in second[range.start * width..range.end * width].chunks_exact(width) {
                context.iter_mut().zip(row).for_each(|(c, s)| *c += s);
            }
        }
        self.context
            .backward(&b.policy.pooled, 2 * width, count, &b.context, gradient);
        let to = &mut b.policy.pooled_gradient;
        reserve(to, count * 2 * width);
        self.context
            .backward_input(parameters, &b.context, count, 0.0, to);
        if let Some(head) = &self.wait {
            let waits: Vec<f32> = logits
                .chunks_exact(actions)
                .take(count)
                .map(|l| l[actions - 1])
                .collect();
            head.backward(
                parameters,
                self.activation,
                &b.policy.pooled,
                globals,
                &waits,
                &mut b.wait,
                (to, 1.0),
                gradient,
            );
        }
        self.encoder
            .backward(&b.rows, globals, &mut b.policy, gradient);
    }
}

impl Head {
    fn forward(
        &self,
        parameters: &[f32],
        activation: Activation,
        pooled: &[f32],
        (globals, stride): (&[f32], usize),
        count: usize,
        buffers: &mut HeadBuffers,
    ) {
        let width = self.context.outputs;
        reserve(&mut buffers.hidden, count * width);
        reserve(&mut buffers.out, count);
        self.global
            .forward(parameters, globals, stride, count, &mut buffers.hidden);
        self.context
            .forward_add(parameters, pooled, count, &mut buffers.hidden);
        activation.apply(&mut buffers.hidden[..count * width]);
        self.out
            .forward(parameters, &buffers.hidden, width, count, &mut buffers.out);
    }

    /// Sets each `to` to the gradient of the pooled vectors plus its old content times the
    /// factor beside it.
    #[allow(clippy::too_many_arguments)]
    fn backward(
        &self,
        parameters: &[f32],
        activation: Activation,
        pooled: &[f32],
        (globals, stride): (&[f32], usize),
        out: &[f32],
        buffers: &mut HeadBuffers,
        (to, keep): (&mut Vec<f32>, f32),
        gradient: &mut [f32],
    ) {
        let (count, width) = (out.len(), self.context.outputs);
        self.out
            .backward(&buffers.hidden, width, count, out, gradient);
        reserve(&mut buffers.gradient, count * width);
        let hidden = &mut buffers.gradient[..count * width];
        self.out.backward_input(parameters, out, count, 0.0, hidden);
        activation.backward(&buffers.hidden[..count * width], hidden);
        self.context
            .backward(pooled, 2 * width, count, hidden, gradient);
        self.global
            .backward(globals, stride, count, hidden, gradient);
        reserve(to, count * 2 * width);
        self.context
            .backward_input(parameters, hidden, count, keep, to);
    }
}
