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
