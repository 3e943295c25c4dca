//! What a trained network sees of a [`Snapshot`], and the meaning of its answer. Training,
//! comparison and live control share this code.
//!
//! An observation is a row of f32 values: the globals, then the slots in order, each with the same
//! number of features. A slot holds one candidate or is empty; empty slots are zero and masked. The
//! last action, if the layout has it, is to wait.
//!
//! [`VERSION`] increases with every change of meaning. It is stored in every trained policy, and
//! policies with a different version are rejected.

mod bounds;
mod full;
mod paper;
mod real;
mod slots;

use slots::SlotChoice;

use super::snapshot::Snapshot;
use super::strategy::Action;
use crate::error::{Error, Result, known_names, shown};
use crate::station::Station;
use std::fmt;
use std::str::FromStr;
use strum::VariantArray as _;

/// Version of the meaning of the features.
pub const VERSION: u32 = 1;

/// Duration of the action `wait`, as a share of the time [s] that the robot needs to travel its
/// reach in a straight line: short enough to meet an item where it is nearest, long enough to make
/// progress.
const WAIT: f64 = 0.25;

/// Which features an observation has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum View {
    /// The paper's features (Jermann et al.): x, y, processing time and reward of every slot, and
    /// busy and time until free of every robot.
    Paper,
    /// All useful features of the paper's line; see the table in `full.rs`.
    Full,
    /// The same, and what only real lines have: several bins, arms that accelerate, and the
    /// probabilities of failing; see the table in `real.rs`.
    Real,
}

impl View {
    /// All feature sets.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// The name used in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for View {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut all = Self::ALL.iter().copied();
        all.find(|view| view.name() == text).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|view| view.name()).collect();
            Error::usage(
                "observation",
                format!("`{}` is not a known view", shown(text)),
                known_names(text, &names),
            )
        })
    }
}

/// The shape of observations and actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Which features an observation has.
    pub view: View,
    /// Number of slots, K.
    pub slots: usize,
    /// Whether waiting is an action.
    pub wait: bool,
}

impl Layout {
    /// The layout of the paper: ten slots.
    pub const PAPER: Self = Self {
        view: View::Paper,
        slots: 10,
        wait: false,
    };

    /// Maximum number of slots.
    pub(crate) const MOST_SLOTS: usize = 256;

    /// The layout of `view` with this number of slots, with waiting as an action or without it.
    ///
    /// # Errors
    /// No slots, or too many.
    pub fn new(view: View, slots: usize, wait: bool) -> Result<Self> {
        if !(1..=Self::MOST_SLOTS).contains(&slots) {
            return Err(Error::usage(
                "slots",
                format!("{slots} slots"),
                format!("give 1 to {}", Self::MOST_SLOTS),
            ));
        }
        Ok(Self { view, slots, wait })
    }

    /// Number of global features.
    pub fn globals(&self) -> usize {
        match self.view {
            View::Paper => paper::GLOBALS,
            View::Full => full::GLOBALS,
            View::Real => real::GLOBALS,
        }
    }

    /// Number of features per slot.
    pub fn slot_features(&self) -> usize {
        match self.view {
            View::Paper => paper::FEATURES,
            View::Full => full::FEATURES,
            View::Real => real::FEATURES,
        }
    }

    /// Length of an observation.
    pub fn observation(&self) -> usize {
        self.globals() + self.slots * self.slot_features()
    }

    /// The least and the greatest value of each feature on `station`, as many as
    /// [`Layout::observation`]: all are finite, and 0 is in between. With a camera at `camera_x` [m]; no
    /// item has a reward above `most_weight`. The patterns do not matter otherwise.
    pub fn bounds(
        &self,
        station: &Station,
        camera_x: Option<f64>,
        most_weight: f64,
    ) -> Vec<(f32, f32)> {
        let line = bounds::Line {
            station,
            camera_x,
            most_weight,
        };
        let (mut bounds, slot) = match self.view {
            View::Paper => line.paper(),
            View::Full => line.full(),
            View::Real => line.real(),
        };
        for _ in 0..self.slots {
            bounds.extend(&slot);
        }
        bounds
    }

    /// Number of actions, including waiting.
    pub fn actions(&self) -> usize {
        self.slots + usize::from(self.wait)
    }
}

/// Encodes snapshots. Its buffers are reused, so that a decision does not allocate.
#[derive(Debug, Clone)]
pub struct Encoder {
    layout: Layout,
    choice: SlotChoice,
}

impl Encoder {
    /// Creates an encoder with this layout.
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            choice: SlotChoice::new(layout.slots),
        }
    }

    /// The layout of this encoder.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Writes the observation of `snapshot`, of length [`Layout::observation`], and the mask of
    /// allowed actions, of length [`Layout::actions`].
    ///
    /// # Panics
    /// If a slice has a different length.
    pub fn encode(&mut self, snapshot: &Snapshot, observation: &mut [f32], mask: &mut [bool]) {
        assert_eq!(observation.len(), self.layout.observation());
        assert_eq!(mask.len(), self.layout.actions());
        self.choice.choose(snapshot);
        let chosen = self.choice.chosen();
        let (globals, slots) = observation.split_at_mut(self.layout.globals());
        let used = chosen.len() * self.layout.slot_features();
        slots[used..].fill(0.0);
        match self.layout.view {
            View::Paper => paper::encode(snapshot, chosen, globals, &mut slots[..used]),
            View::Full => {
                let slots = (&mut slots[..used], full::FEATURES);
                full::encode(snapshot, chosen, globals, slots);
            }
            View::Real => real::encode(snapshot, chosen, globals, &mut slots[..used]),
        }
        for (slot, allowed) in mask.iter_mut().enumerate() {
            *allowed = slot < chosen.len() || slot == self.layout.slots;
        }
    }

    /// The action with the given index, after [`Encoder::encode`] of the same snapshot.
    ///
    /// # Errors
    /// If the slot is empty, or there is no such action.
    pub fn action(&self, snapshot: &Snapshot, index: usize) -> Result<Action> {
        if self.layout.wait && index == self.layout.slots {
            let robot = &snapshot.station.robots()[snapshot.robot];
            let pause = WAIT * robot.reach / robot.cruising_speed();
            return Ok(Action::WaitUntil(snapshot.time + pause));
        }
        match self.choice.chosen().get(index) {
            Some(place) => Ok(Action::Pick(*place)),
            None => {
                let robot = &snapshot.station.robots()[snapshot.robot];
                let (filled, slots) = (self.choice.chosen().len(), self.layout.slots);
                let problem =
                    format!("action {index}, but only {filled} of {slots} slots hold an item");
                let cure = "choose an action that the mask allows";
                Err(Error::illegal_action(
                    (snapshot.time, &robot.name),
                    problem,
                    cure,
                ))
            }
        }
    }

    /// The candidates in the slots, after [`Encoder::encode`]: indices into the snapshot's candidates.
    pub fn slots(&self) -> &[usize] {
        self.choice.chosen()
    }

    /// The index of `action`; `None` if its candidate has no slot.
    pub fn index_of(&self, action: Action) -> Option<usize> {
        match action {
            Action::Pick(place) => self.choice.chosen().iter().position(|c| *c == place),
            Action::WaitUntil(_) | Action::WaitForNextWindow => {
                self.layout.wait.then_some(self.layout.slots)
            }
            Action::NoAnswer => None,
        }
    }
}
