//! The events of a run, in order of time.

use super::snapshot::Snapshot;
use super::strategy::Action;

/// An event of a run.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A robot decided.
    Decision {
        /// What the robot saw.
        snapshot: &'a Snapshot<'a>,
        /// What the robot does.
        action: Action,
    },
    /// A robot takes its item off the belt.
    Grasp {
        /// When the item leaves the belt [s].
        time: f64,
        /// Index of the robot.
        robot: usize,
        /// Index of the item in its pattern.
        item: u32,
    },
    /// A robot has dropped its item into the bin and is free.
    Release {
        /// When the item is in the bin [s].
        time: f64,
        /// Index of the robot.
        robot: usize,
        /// Index of the item in its pattern.
        item: u32,
    },
    /// A grasp has failed: the item stays on the belt and may be claimed again.
    GraspFailed {
        /// End of the failed grasp [s].
        time: f64,
        /// Index of the robot.
        robot: usize,
        /// Index of the item in its pattern.
        item: u32,
        /// When the robot has returned and is free [s].
        free: f64,
    },
    /// An item leaves the belt unpicked.
    LeftBelt {
        /// When the item leaves the belt [s].
        time: f64,
        /// Index of the item in its pattern.
        item: u32,
    },
}

impl Event<'_> {
    /// Time of the event [s].
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

/// Receives every event of a run, in order of time.
pub trait Observer {
    /// Called with each event.
    fn observe(&mut self, event: &Event);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station::built_in;

    #[test]
    fn every_event_has_its_time() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let snapshot = Snapshot {
            station: &station,
            time: 2.0,
            robot: 0,
            candidates: &[],
            free_at: &[0.0, 0.0],
            places: &[0, 0],
            candidate_odds: &[],
            in_view: &[],
        };
        let (robot, item) = (0, 5);
        for (event, time) in [
            (
                Event::Decision {
                    snapshot: &snapshot,
                    action: Action::WaitUntil(7.0),
                },
                2.0,
            ),
            (
                Event::Grasp {
                    time: 3.0,
                    robot,
                    item,
                },
                3.0,
            ),
            (
                Event::Release {
                    time: 4.0,
                    robot,
                    item,
                },
                4.0,
            ),
            (
                Event::GraspFailed {
                    time: 5.0,
                    robot,
                    item,
                    free: 9.0,
                },
                5.0,
            ),
            (Event::LeftBelt { time: 6.0, item }, 6.0),
        ] {
            assert_eq!(event.time(), time, "{event:?}");
        }
    }
}
