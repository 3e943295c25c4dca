//! What happens in a run, in order of time.

use super::snapshot::Snapshot;
use super::strategy::Action;

/// One thing that happens.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A robot decided.
    Decision {
        /// What it saw.
        snapshot: &'a Snapshot<'a>,
        /// What it does.
        action: Action,
    },
    /// A robot takes its item off the belt.
    Grasp {
        /// When [s].
        time: f64,
        /// Which robot.
        robot: usize,
        /// Which item.
        item: u32,
    },
    /// A robot has dropped its item into the bin and is free.
    Release {
        /// When [s].
        time: f64,
        /// Which robot.
        robot: usize,
        /// Which item.
        item: u32,
    },
    /// A grasp has failed: the item stays on the belt and may be claimed again.
    GraspFailed {
        /// When the failed grasp is over [s].
        time: f64,
        /// Which robot.
        robot: usize,
        /// Which item.
        item: u32,
        /// When the robot is back and free [s].
        free: f64,
    },
    /// An item leaves the belt unpicked.
    LeftBelt {
        /// When [s].
        time: f64,
        /// Which item.
        item: u32,
    },
}

impl Event<'_> {
    /// When it happens [s].
    pub fn time(&self) -> f64 {
        match *self {
            Self::Decision { snapshot, .. } => snapshot.time,
            Self::Grasp { time, .. }
            | Self::Release { time, .. }
            | Self::GraspFailed { time, .. }
            | Self::LeftBelt { time, .. } => time,
        }
    }
}

/// Is told every event of a run, in order of time.
pub trait Observer {
    /// Takes note of one event.
    fn observe(&mut self, event: &Event);
}
