//! What a trained network sees of a [`Snapshot`], and what its answer means: the same
//! code in training, comparison and live control.
//!
//! An observation is a row of f32: the globals, then the slots one after the other, each
//! with as many features. A slot holds one candidate or nothing; empty slots are zeros
//! and masked. The last action, if the layout has it, is to wait.
//!
//! [`VERSION`] counts the changes of meaning; it is written into every trained policy,
//! and a policy of another version is refused.

mod full;
mod paper;
mod slots;

pub use slots::SlotChoice;

use super::snapshot::Snapshot;
use super::strategy::Action;
use crate::error::{Error, Result, known_names, shown};
use std::fmt;
use std::str::FromStr;

/// The version of what the features mean.
pub const VERSION: u32 = 1;

/// How long the action `wait` lasts, as a share of the time [s] that the robot needs for
/// a straight way as long as its reach: short enough to meet an item where it is
/// nearest, long enough to get somewhere.
const WAIT: f64 = 0.25;

/// Which features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// The paper's (Jermann et al.): x, y, processing time and reward of every slot,
    /// busy and time until free of every robot.
    Paper,
    /// Everything that helps; see `full.rs` for the table.
    Full,
}

impl View {
    /// All views.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Full];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Full => "full",
        }
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
        Self::ALL
            .into_iter()
            .find(|view| view.name() == text)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name);
                Error::input(
                    "observation",
                    format!("`{}` is not a known view", shown(text)),
                    known_names(text, &names),
                )
            })
    }
}

/// Shape of observations and actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Which features.
    pub view: View,
    /// Slots, K.
    pub slots: usize,
    /// Whether waiting is an action.
    pub wait: bool,
}

impl Layout {
    /// The paper's: ten slots.
    pub const PAPER: Self = Self {
        view: View::Paper,
        slots: 10,
        wait: false,
    };

    /// More slots than this are refused: no layer is meant for them.
    pub const MOST_SLOTS: usize = 256;

    /// Numbers that belong to no slot.
    pub fn globals(&self) -> usize {
        match self.view {
            View::Paper => paper::GLOBALS,
            View::Full => full::GLOBALS,
        }
    }

    /// Numbers of each slot.
    pub fn slot_features(&self) -> usize {
        match self.view {
            View::Paper => paper::FEATURES,
            View::Full => full::FEATURES,
        }
    }

    /// Numbers in an observation.
    pub fn observation(&self) -> usize {
        self.globals() + self.slots * self.slot_features()
    }

    /// Number of actions.
    pub fn actions(&self) -> usize {
        self.slots + usize::from(self.wait)
    }
}

/// Encodes snapshots; keeps its buffers, so that nothing is allocated per decision.
#[derive(Debug, Clone)]
pub struct Encoder {
    layout: Layout,
    choice: SlotChoice,
}

impl Encoder {
    /// An encoder of this layout.
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            choice: SlotChoice::new(layout.slots),
        }
    }

    /// Its layout.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Writes the observation [`Layout::observation`] and the mask of allowed actions
    /// [`Layout::actions`] of `snapshot`.
    ///
    /// # Panics
    /// Slices of another length.
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
            View::Full => full::encode(snapshot, chosen, globals, &mut slots[..used]),
        }
        for (slot, allowed) in mask.iter_mut().enumerate() {
            *allowed = slot < chosen.len() || slot == self.layout.slots;
        }
    }

    /// What action `index` means after [`Encoder::encode`] of the same snapshot.
    ///
    /// # Errors
    /// A slot that is empty, or no action at all.
    pub fn action(&self, snapshot: &Snapshot, index: usize) -> Result<Action> {
        if self.layout.wait && index == self.layout.slots {
            let robot = &snapshot.station.robots()[snapshot.robot];
            let pause = WAIT * robot.reach / robot.speed;
            return Ok(Action::WaitUntil(snapshot.time + pause));
        }
        match self.choice.chosen().get(index) {
            Some(place) => Ok(Action::Pick(*place)),
            None => Err(Error::IllegalAction {
                time: snapshot.time,
                robot: snapshot.station.robots()[snapshot.robot].name.clone(),
                problem: format!(
                    "action {index} where {} of {} slots hold an item",
                    self.choice.chosen().len(),
                    self.layout.slots
                ),
            }),
        }
    }

    /// Which action index stands for `action`; none when its candidate got no slot.
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
