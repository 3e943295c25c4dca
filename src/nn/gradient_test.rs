//! Compares gradients with finite differences and tests what the architectures promise.

use super::activation::Activation;
use super::network::{Architecture, Network, Workspace};
use super::shape::{ObservationBatch, Shape};
use crate::pattern::random_stream;
use rand::RngExt;

const ROWS: usize = 5;

fn shape(wait: bool) -> Shape {
    Shape {
        globals: 3,
        slots: 4,
        slot_features: 2,
        wait,
    }
}

fn architectures() -> [Architecture; 2] {
    let activation = Activation::Tanh;
    [
        Architecture::Mlp {
            hidden: vec![6, 5],
            activation,
        },
        Architecture::Scorer {
            width: 6,
            activation,
        },
    ]
}

struct GradientCase {
    shape: Shape,
    observations: Vec<f32>,
    masks: Vec<bool>,
}

impl GradientCase {
    fn new(wait: bool) -> Self {
        let shape = shape(wait);
        let mut rng = random_stream(3, 0);
        let observations = (0..ROWS * shape.observation()).map(|_| rng.random::<f32>() - 0.5);
        let observations = observations.collect();
        let masks = (0..ROWS * shape.actions()).map(|i| i % shape.actions() == 0 || rng.random());
        let masks = masks.collect();
        Self {
            shape,
            observations,
            masks,
        }
    }

    fn batch(&self) -> ObservationBatch<'_> {
        ObservationBatch {
            observations: &self.observations,
            masks: &self.masks,
            rows: ROWS,
        }
    }

    /// A loss that weights every allowed logit and every value differently, with its
    /// derivatives.
    fn loss(&self, work: &Workspace) -> (f64, Vec<f32>, Vec<f32>) {
        let mut loss = 0.0;
        let mut logits = vec![0.0; self.masks.len()];
        for (i, mask) in self.masks.iter().enumerate().filter(|(_, mask)| **mask) {
            assert!(mask);
            let weight = (i as f32 * 0.7).sin();
            loss += f64::from(weight * work.logits[i]);
            logits[i] = weight;
        }
        let mut values = vec![0.0; ROWS];
        for (i, slope) in values.iter_mut().enumerate() {
            loss += 0.5 * f64::from(work.values[i]).powi(2);
            *slope = work.values[i];
        }
        (loss, logits, values)
    }
}

#[test]
fn gradients_are_those_of_finite_differences() {
    for architecture in architectures() {
        for wait in [false, true] {
            let case = GradientCase::new(wait);
            let net = Network::new(&architecture, case.shape);
            let mut parameters = net.initial(&mut random_stream(1, 1));
            // The small output layers would hide errors in the layers below.
            let mut rng = random_stream(2, 1);
            parameters
                .iter_mut()
                .for_each(|p| *p += 0.6 * (rng.random::<f32>() - 0.5));
            let mut work = Workspace::default();
            net.forward(&parameters, case.batch(), &mut work);
            let (_, logits, values) = case.loss(&work);
            let mut gradient = vec![0.0; net.parameters()];
            net.backward(
                &parameters,
                case.batch(),
                (&logits, &values),
                &mut work,
                &mut gradient,
            );
            for i in 0..parameters.len() {
                let step = 1e-2;
                let mut at = |offset: f32| {
                    let mut moved = parameters.clone();
                    moved[i] += offset;
                    net.forward(&moved, case.batch(), &mut work);
                    case.loss(&work).0
                };
                // Fourth order, so that f32 has enough digits for this step.
                let slope = (8.0 * (at(step) - at(-step)) - at(2.0 * step) + at(-2.0 * step))
                    / (12.0 * f64::from(step));
                let error = (slope - f64::from(gradient[i])).abs();
                assert!(
                    error < 1e-3 * (1.0 + slope.abs()),
                    "{architecture:?} {i}: {slope} and {}",
                    gradient[i]
                );
            }
        }
    }
}

#[test]
fn reordering_the_slots_reorders_the_scorers_logits() {
    let case = GradientCase::new(true);
    let shape = case.shape;
    let [_, architecture] = architectures();
    let net = Network::new(&architecture, shape);
    let parameters = net.initial(&mut random_stream(1, 1));
    let mut work = Workspace::default();
    net.forward(&parameters, case.batch(), &mut work);
    let (logits, values) = (work.logits.clone(), work.values.clone());
    // Slots in reverse order, and masked slots with other content.
    let mut other = GradientCase::new(true);
    for row in 0..ROWS {
        for slot in 0..shape.slots {
            let from = shape.slots - 1 - slot;
            let present = case.masks[row * shape.actions() + from];
            other.masks[row * shape.actions() + slot] = present;
            for f in 0..shape.slot_features {
                let at = |slot| {
                    row * shape.observation() + shape.globals + slot * shape.slot_features + f
                };
                other.observations[at(slot)] = if present {
                    case.observations[at(from)]
                } else {
                    1e9
                };
            }
        }
    }
    net.forward(&parameters, other.batch(), &mut work);
    let pairs = values.iter().zip(&work.values);
    assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-5));
    for row in 0..ROWS {
        for slot in 0..shape.slots {
            let from = row * shape.actions() + shape.slots - 1 - slot;
            if case.masks[from] {
                let to = row * shape.actions() + slot;
                assert!((logits[from] - work.logits[to]).abs() < 1e-5);
            }
        }
    }
}
