//! What goes into a network: the shape of a decision, and batches of observations.

use crate::decision::observation::Layout;
use serde::{Deserialize, Serialize};

/// Input and output of one decision. An observation is `globals` numbers followed by `slots`
/// times `slot_features` numbers; actions are the slots and, with `wait`, one more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Numbers that do not belong to a slot.
    pub globals: usize,
    /// Number of slots, K.
    pub slots: usize,
    /// Number of features per slot.
    pub slot_features: usize,
    /// Whether waiting is an action.
    pub wait: bool,
}

impl Shape {
    /// Input and output of a network that reads observations of this layout.
    pub fn of(layout: &Layout) -> Self {
        Self {
            globals: layout.globals(),
            slots: layout.slots,
            slot_features: layout.slot_features(),
            wait: layout.wait,
        }
    }

    /// Number of features in an observation.
    pub fn observation(&self) -> usize {
        self.globals + self.slots * self.slot_features
    }

    /// Number of actions: the slots, and waiting if it is allowed.
    pub fn actions(&self) -> usize {
        self.slots + usize::from(self.wait)
    }
}

/// Observations that go through a network together.
#[derive(Clone, Copy)]
pub struct ObservationBatch<'a> {
    /// Observations [rows, observation].
    pub observations: &'a [f32],
    /// Allowed actions [rows, actions].
    pub masks: &'a [bool],
    /// Number of observations.
    pub rows: usize,
}
