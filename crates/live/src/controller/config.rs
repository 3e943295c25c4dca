//! The settings of the controller.

use crate::clock::ClockKind;
use crate::sources::Timeouts;

/// Settings of the controller beyond the model. [`Config::check`] has their ranges.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Config {
    /// Where the time comes from.
    pub clock: ClockKind,
    /// Detections within this distance of an item show that item, unless something else is known
    /// [m].
    pub tolerance: f64,
    /// An unacknowledged task is sent again after this time [s].
    pub ack_timeout: f64,
    /// A result that is overdue by this time is no longer waited for [s].
    pub result_timeout: f64,
    /// Number of attempts at an item before it is given up.
    pub most_attempts: u32,
    /// Maximum number of items on the belt; further ones are refused.
    pub most_items: usize,
    /// With message time, the interval of statuses [s]; 0 is never. With the system clock the
    /// caller requests them.
    pub status_every: f64,
    /// Items that are real with a smaller probability, as the camera says it, are left on the belt;
    /// those of which it says nothing are certain.
    pub min_detection: f64,
    /// The strategy sees items from this x on [m]; a robot may leave for an item before that.
    pub view_from: f64,
    /// Times of silence after which the belt or a robot is no longer relied on.
    pub timeouts: Timeouts,
    /// By how much the timestamps of pictures are late [s].
    pub camera_delay: f64,
    /// How long before its start a task is decided, for each robot [s]: the time that it takes to
    /// reach the arm. Robots beyond the list have 0.
    pub lead: Vec<f64>,
    /// Whether the drive may be requested to stop the belt while no robot takes tasks, and before
    /// an item would be lost.
    pub may_stop_belt: bool,
    /// How long before an item would be lost the belt is requested to stop [s].
    pub stop_margin: f64,
}

impl Default for Config {
    /// The system clock, with the values that `docs/protocol.md` names; the belt is never stopped.
    fn default() -> Self {
        Self {
            clock: ClockKind::System,
            tolerance: 0.015,
            ack_timeout: 1.0,
            result_timeout: 5.0,
            most_attempts: 3,
            most_items: 100_000,
            status_every: 0.0,
            min_detection: 0.0,
            view_from: 0.0,
            timeouts: Timeouts::default(),
            camera_delay: 0.0,
            lead: Vec::new(),
            may_stop_belt: false,
            stop_margin: 0.5,
        }
    }
}

impl Config {
    /// With the time from this clock.
    #[must_use]
    pub fn with_clock(mut self, clock: ClockKind) -> Self {
        self.clock = clock;
        self
    }

    /// With detections that show an item within this distance of it [m].
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// With unacknowledged tasks sent again after this time [s].
    #[must_use]
    pub fn with_ack_timeout(mut self, ack_timeout: f64) -> Self {
        self.ack_timeout = ack_timeout;
        self
    }

    /// With results waited for until they are overdue by this time [s].
    #[must_use]
    pub fn with_result_timeout(mut self, result_timeout: f64) -> Self {
        self.result_timeout = result_timeout;
        self
    }

    /// With this number of attempts at an item.
    #[must_use]
    pub fn with_most_attempts(mut self, most_attempts: u32) -> Self {
        self.most_attempts = most_attempts;
        self
    }

    /// With at most this number of items on the belt.
    #[must_use]
    pub fn with_most_items(mut self, most_items: usize) -> Self {
        self.most_items = most_items;
        self
    }

    /// With a status every so often, with message time [s]; 0 is never.
    #[must_use]
    pub fn with_status_every(mut self, status_every: f64) -> Self {
        self.status_every = status_every;
        self
    }

    /// With items left on the belt that are real with a smaller probability.
    #[must_use]
    pub fn with_min_detection(mut self, min_detection: f64) -> Self {
        self.min_detection = min_detection;
        self
    }

    /// With a strategy that sees items from this x on [m].
    #[must_use]
    pub fn with_view_from(mut self, view_from: f64) -> Self {
        self.view_from = view_from;
        self
    }

    /// With these times of silence after which a source is not relied on.
    #[must_use]
    pub fn with_timeouts(mut self, timeouts: Timeouts) -> Self {
        self.timeouts = timeouts;
        self
    }

    /// With pictures whose timestamps are late by this time [s].
    #[must_use]
    pub fn with_camera_delay(mut self, camera_delay: f64) -> Self {
        self.camera_delay = camera_delay;
        self
    }

    /// With tasks decided this long before their start, for each robot [s].
    #[must_use]
    pub fn with_lead(mut self, lead: Vec<f64>) -> Self {
        self.lead = lead;
        self
    }

    /// With requests to stop the belt, or without them.
    #[must_use]
    pub fn with_may_stop_belt(mut self, may_stop_belt: bool) -> Self {
        self.may_stop_belt = may_stop_belt;
        self
    }

    /// With the belt requested to stop this long before an item would be lost [s].
    #[must_use]
    pub fn with_stop_margin(mut self, stop_margin: f64) -> Self {
        self.stop_margin = stop_margin;
        self
    }

    /// How long before its start a task of this robot is decided [s].
    pub(crate) fn lead_of(&self, robot: usize) -> f64 {
        self.lead.get(robot).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The settings that hold where nothing else is said, as docs/protocol.md names them.
    #[test]
    fn the_settings_are_as_documented() {
        let expected = Config {
            clock: ClockKind::System,
            tolerance: 0.015,
            ack_timeout: 1.0,
            result_timeout: 5.0,
            most_attempts: 3,
            most_items: 100_000,
            status_every: 0.0,
            min_detection: 0.0,
            view_from: 0.0,
            timeouts: Timeouts {
                belt: None,
                robot: None,
            },
            camera_delay: 0.0,
            lead: Vec::new(),
            may_stop_belt: false,
            stop_margin: 0.5,
        };
        assert_eq!(Config::default(), expected);
        let two = expected.with_lead(vec![0.1, 0.2]);
        assert_eq!([0, 1, 2].map(|robot| two.lead_of(robot)), [0.1, 0.2, 0.0]);
    }
}
