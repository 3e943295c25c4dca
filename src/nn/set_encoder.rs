//! The first layer of the scorer: encodes every slot that holds an item separately, with the
//! globals added, and computes mean and maximum of the results over the slots.
//!
//! Zaheer et al., "Deep sets", arXiv 1703.06114: the slots are combined only by pooling, so the
//! order of the items cannot matter.

use super::activation::Activation;
use super::init::orthogonal;
use super::linear::Linear;
use super::matrix::reserve;
use super::shape::Shape;
use rand::Rng;

/// The slots of a batch that hold an item, one after the other.
#[derive(Debug, Default)]
pub(crate) struct SlotRows {
    /// The position of each in the [rows, slots] table.
    pub places: Vec<usize>,
    /// The first entry of each row of the batch, then the end.
    pub starts: Vec<usize>,
    /// Their features [places, slot_features].
    pub features: Vec<f32>,
}

impl SlotRows {
    /// Gathers the slots that `masks` [rows, actions] allows.
    pub(crate) fn gather(&mut self, shape: &Shape, observations: &[f32], masks: &[bool]) {
        self.places.clear();
        self.starts.clear();
        self.features.clear();
        let observations = observations.chunks_exact(shape.observation());
        for (row, (observation, mask)) in observations
            .zip(masks.chunks_exact(shape.actions()))
            .enumerate()
        {
            self.starts.push(self.places.len());
            let slots = observation[shape.globals..].chunks_exact(shape.slot_features);
            for (slot, (features, present)) in slots.zip(mask).enumerate() {
                if *present {
                    self.places.push(row * shape.slots + slot);
                    self.features.extend_from_slice(features);
                }
            }
        }
        self.starts.push(self.places.len());
    }

    /// The range of entries of each row of the batch.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.starts.windows(2).map(|pair| pair[0]..pair[1])
    }
}

/// Results of a forward pass that the backward pass needs.
#[derive(Debug, Default)]
pub(crate) struct Encoded {
    /// Each slot's vector [places, width].
    pub slots: Vec<f32>,
    /// Mean, then maximum, over the slots of a row [rows, 2 width].
    pub pooled: Vec<f32>,
    /// The entry of each maximum [rows, width].
    largest: Vec<usize>,
    /// The contribution of the globals [rows, width].
    context: Vec<f32>,
    /// Gradient of `slots`.
    pub slots_gradient: Vec<f32>,
    /// Gradient of `pooled`.
    pub pooled_gradient: Vec<f32>,
}

/// The first layer of the scorer; see the module.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SetEncoder {
    /// Slot features to width, without bias.
    pub slot: Linear,
    /// Globals to width, with the bias.
    pub global: Linear,
    activation: Activation,
}

impl SetEncoder {
    /// The encoder whose parameters begin at `*next`.
    pub(crate) fn new(
        shape: &Shape,
        width: usize,
        activation: Activation,
        next: &mut usize,
    ) -> Self {
        Self {
            slot: Linear::new(shape.slot_features, width, false, next),
            global: Linear::new(shape.globals, width, true, next),
            activation,
        }
    }

    /// Sets orthogonal weights.
    pub(crate) fn initialise(&self, parameters: &mut [f32], rng: &mut impl Rng) {
        orthogonal(&self.slot, 2f32.sqrt(), parameters, rng);
        orthogonal(&self.global, 1.0, parameters, rng);
    }

    /// Computes `to` from the gathered slots and the globals, which come first in rows of
    /// `stride`.
    pub(crate) fn forward(
        &self,
        parameters: &[f32],
        rows: &SlotRows,
        (globals, stride): (&[f32], usize),
        to: &mut Encoded,
    ) {
        let (width, count) = (self.slot.outputs, rows.starts.len() - 1);
        reserve(&mut to.context, count * width);
        self.global
            .forward(parameters, globals, stride, count, &mut to.context);
        reserve(&mut to.slots, rows.places.len() * width);
        reserve(&mut to.pooled, count * 2 * width);
        to.largest.resize(count * width, 0);
        let slots = &mut to.slots[..rows.places.len() * width];
        for (range, context) in rows.ranges().zip(to.context.chunks_exact(width)) {
            for slot in slots[range.start * width..range.end * width].chunks_exact_mut(width) {
                slot.copy_from_slice(context);
            }
        }
        self.slot
            .forward_add(parameters, &rows.features, rows.places.len(), slots);
        self.activation.apply(slots);
        let pooled = to.pooled.chunks_exact_mut(2 * width);
        let largest = to.largest.chunks_exact_mut(width);
        for ((range, pooled), largest) in rows.ranges().zip(pooled).zip(largest) {
            let (mean, most) = pooled.split_at_mut(width);
            mean.fill(0.0);
            most.fill(if range.is_empty() {
                0.0
            } else {
                f32::NEG_INFINITY
            });
            for place in range.clone() {
                let slot = &slots[place * width..][..width];
                for j in 0..width {
                    mean[j] += slot[j];
                    if slot[j] > most[j] {
                        most[j] = slot[j];
                        largest[j] = place;
                    }
                }
            }
            let share = 1.0 / range.len().max(1) as f32;
            mean.iter_mut().for_each(|m| *m *= share);
        }
    }

    /// Adds the parameters' gradient, given the gradients of slots and pooled vectors in
    /// `from`.
    pub(crate) fn backward(
        &self,
        rows: &SlotRows,
        (globals, stride): (&[f32], usize),
        from: &mut Encoded,
        gradient: &mut [f32],
    ) {
        let (width, count) = (self.slot.outputs, rows.starts.len() - 1);
        let size = rows.places.len() * width;
        let pooled = from.pooled_gradient.chunks_exact(2 * width);
        let largest = from.largest.chunks_exact(width);
        let slots = &mut from.slots_gradient[..size];
        for ((range, pooled), largest) in rows.ranges().zip(pooled).zip(largest) {
            if range.is_empty() {
                continue;
            }
            let (mean, most) = pooled.split_at(width);
            let share = 1.0 / range.len() as f32;
            for place in range.clone() {
                let slot = &mut slots[place * width..][..width];
                slot.iter_mut().zip(mean).for_each(|(s, m)| *s += share * m);
            }
            for j in 0..width {
                slots[largest[j] * width + j] += most[j];
            }
        }
        self.activation.backward(&from.slots[..size], slots);
        self.slot.backward(
            &rows.features,
            self.slot.inputs,
            rows.places.len(),
            slots,
            gradient,
        );
        // The globals were added to every slot of a row.
        for (range, context) in rows.ranges().zip(from.context.chunks_exact_mut(width)) {
            context.fill(0.0);
            for slot in slots[range.start * width..range.end * width].chunks_exact(width) {
                context.iter_mut().zip(slot).for_each(|(c, s)| *c += s);
            }
        }
        self.global
            .backward(globals, stride, count, &from.context, gradient);
    }
}
