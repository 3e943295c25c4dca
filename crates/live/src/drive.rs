//! Requests to the belt's drive: to stop while no robot can pick or before an item would be lost,
//! and to restart.
//!
//! Invariants: while a stop is requested, the speed for the restart is known and above 0. The
//! actions of others are not overruled: a belt that moves after it stood as requested, or stands
//! after it moved as requested, is left alone until the next reason to stop it.

use serde::{Deserialize, Serialize};

/// A request that was not followed is repeated after this time [s],
const REPEAT: f64 = 1.0;
/// at most this many times.
const MOST_REPEATS: u32 = 10;
/// A moving belt has reached the requested speed once it has this share of it.
const NEARLY: f64 = 0.9;
/// It is accelerating once it exceeds its lowest speed by this share of the requested one.
const GAIN: f64 = 0.05;

/// Why the belt is requested to stop or to restart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StopCause {
    /// No robot takes tasks.
    NoRobot,
    /// An item would leave the last robot's reach.
    ItemLost,
    /// Neither of these applies any more.
    Clear,
}

impl StopCause {
    /// The text of the `reason` in a request.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::NoRobot => "no robot takes tasks",
            Self::ItemLost => "an item would leave the last robot's reach",
            Self::Clear => "robots take tasks, and no item would be lost",
        }
    }
}

/// A request to the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Request {
    /// The requested speed [m/s].
    pub speed: f64,
    /// The reason for the request.
    pub cause: StopCause,
}

/// The phase of a request. Speeds [m/s] are those from before the stop.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DrivePhase {
    /// Nothing is requested.
    #[default]
    Idle,
    /// The belt was requested to stop and still moves.
    Stopping(f64),
    /// The belt stands as requested.
    Stopped(f64),
    /// The belt was requested to restart and still stands.
    Starting(f64),
    /// The belt was requested to restart, and moves.
    GainingSpeed(f64),
    /// The belt was started by someone else while it was requested to stand.
    Overruled,
}

/// The state of the requests to the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Drive {
    phase: DrivePhase,
    /// Reason of the last requested stop.
    cause: Option<StopCause>,
    /// Time of the last request [s], and how often it was repeated.
    asked_at: f64,
    repeats: u32,
    /// The lowest speed since the restart was requested [m/s]: the belt may still be braking.
    lowest: f64,
}

impl Drive {
    /// Speed of the belt before the requested stop [m/s]; none while no stop is requested.
    pub(crate) fn running(&self) -> Option<f64> {
        match self.phase {
            DrivePhase::Stopping(speed) | DrivePhase::Stopped(speed) => Some(speed),
            _ => None,
        }
    }

    /// When the open request is repeated if it is not followed [s].
    pub(crate) fn repeat_at(&self) -> Option<f64> {
        let is_open = matches!(
            self.phase,
            DrivePhase::Stopping(_) | DrivePhase::Starting(_)
        );
        (is_open && self.repeats < MOST_REPEATS).then_some(self.asked_at + REPEAT)
    }

    /// The request to make at `now` [s], if the belt moves at `speed` [m/s] and there is a `reason`
    /// to stop it or none. Returns none if it has already been made.
    pub(crate) fn ask(
        &mut self,
        now: f64,
        speed: f64,
        reason: Option<StopCause>,
    ) -> Option<Request> {
        let stands = speed == 0.0;
        self.lowest = self.lowest.min(speed);
        let gains = |running: f64| speed > self.lowest + GAIN * running;
        // What the belt has done since the last call.
        self.phase = match self.phase {
            DrivePhase::Stopping(running) if stands => DrivePhase::Stopped(running),
            DrivePhase::Stopped(_) if !stands => DrivePhase::Overruled,
            DrivePhase::Starting(running) if speed >= NEARLY * running => DrivePhase::Idle,
            DrivePhase::Starting(running) if gains(running) => DrivePhase::GainingSpeed(running),
            DrivePhase::GainingSpeed(running) if stands || speed >= NEARLY * running => {
                DrivePhase::Idle
            }
            phase => phase,
        };
        match (reason, self.phase) {
            (Some(cause), DrivePhase::Idle | DrivePhase::GainingSpeed(_)) if speed > 0.0 => {
                let running = match self.phase {
                    DrivePhase::GainingSpeed(running) => running,
                    _ => speed,
                };
                Some(self.request(now, DrivePhase::Stopping(running), cause))
            }
            // The belt may be about to move.
            (Some(cause), DrivePhase::Starting(running)) => {
                Some(self.request(now, DrivePhase::Stopping(running), cause))
            }
            (None, DrivePhase::Stopping(running) | DrivePhase::Stopped(running)) => {
                self.lowest = speed;
                Some(self.request(now, DrivePhase::Starting(running), StopCause::Clear))
            }
            (None, DrivePhase::Overruled) => {
                self.phase = DrivePhase::Idle;
                None
            }
            _ => self.again(now),
        }
    }

    fn request(&mut self, now: f64, phase: DrivePhase, cause: StopCause) -> Request {
        (self.phase, self.cause) = (phase, Some(cause));
        (self.asked_at, self.repeats) = (now, 0);
        self.standing(cause)
    }

    fn standing(&self, cause: StopCause) -> Request {
        let speed = match self.phase {
            DrivePhase::Starting(running) => running,
            _ => 0.0,
        };
        Request { speed, cause }
    }

    fn again(&mut self, now: f64) -> Option<Request> {
        let at = self.repeat_at()?;
        if now < at {
            return None;
        }
        (self.asked_at, self.repeats) = (now, self.repeats + 1);
        self.cause.map(|cause| self.standing(cause))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOST: Option<StopCause> = Some(StopCause::ItemLost);

    fn speed(request: Option<Request>) -> Option<f64> {
        request.map(|request| request.speed)
    }

    #[test]
    fn it_stops_once_goes_on_once_and_repeats_what_is_not_followed() {
        let mut drive = Drive::default();
        assert_eq!(drive.ask(0.0, 0.3, None), None);
        assert_eq!(speed(drive.ask(1.0, 0.3, LOST)), Some(0.0));
        assert_eq!(drive.running(), Some(0.3));
        assert_eq!(drive.ask(1.5, 0.3, LOST), None);
        assert_eq!(drive.repeat_at(), Some(2.0));
        assert_eq!(
            speed(drive.ask(2.0, 0.2, Some(StopCause::NoRobot))),
            Some(0.0)
        );
        assert_eq!(drive.ask(3.0, 0.0, LOST), None);
        let go = drive.ask(5.0, 0.0, None).unwrap();
        assert_eq!((go.speed, go.cause), (0.3, StopCause::Clear));
        assert_eq!(speed(drive.ask(6.0, 0.0, None)), Some(0.3));
        assert_eq!(drive.ask(7.0, 0.1, None), None);
        assert_eq!(drive.ask(9.0, 0.3, None), None);
        // A belt that the operator stops now is left alone.
        assert_eq!(drive.ask(10.0, 0.0, Some(StopCause::NoRobot)), None);
        assert_eq!(drive.ask(11.0, 0.0, None), None);
    }

    #[test]
    fn a_reason_that_passes_while_the_belt_brakes_does_not_leave_it_standing() {
        let mut drive = Drive::default();
        assert_eq!(speed(drive.ask(1.0, 0.3, LOST)), Some(0.0));
        assert_eq!(speed(drive.ask(1.2, 0.25, None)), Some(0.3));
        // The drive completes its stop first; the request is repeated until the belt moves.
        assert_eq!(drive.ask(1.4, 0.1, None), None);
        assert_eq!(drive.ask(1.6, 0.0, None), None);
        assert_eq!(speed(drive.ask(2.2, 0.0, None)), Some(0.3));
        assert_eq!(drive.ask(3.0, 0.2, None), None);
        assert_eq!(drive.repeat_at(), None);
        let mut drive = Drive::default();
        drive.ask(1.0, 0.3, LOST);
        drive.ask(2.0, 0.0, LOST);
        drive.ask(3.0, 0.0, None);
        // A reason to stop again while the belt accelerates.
        assert_eq!(drive.ask(3.5, 0.05, None), None);
        assert_eq!(speed(drive.ask(3.6, 0.06, LOST)), Some(0.0));
        assert_eq!(drive.ask(4.0, 0.0, LOST), None);
        assert_eq!(speed(drive.ask(5.0, 0.0, None)), Some(0.3));
    }

    #[test]
    fn an_operator_is_not_overruled() {
        let mut drive = Drive::default();
        drive.ask(1.0, 0.3, LOST);
        drive.ask(2.0, 0.0, LOST);
        // Started by hand, and stopped by hand.
        assert_eq!(drive.ask(3.0, 0.15, LOST), None);
        assert_eq!(drive.ask(5.0, 0.0, LOST), None);
        assert_eq!(drive.ask(8.0, 0.0, None), None);
        // The next reason is acted on again.
        drive.ask(9.0, 0.3, None);
        assert_eq!(speed(drive.ask(10.0, 0.3, LOST)), Some(0.0));
    }

    #[test]
    fn a_drive_that_never_follows_is_no_longer_asked() {
        let mut drive = Drive::default();
        drive.ask(0.0, 0.3, LOST);
        let asked = (1..100).filter(|i| drive.ask(f64::from(*i), 0.3, LOST).is_some());
        assert_eq!(asked.count(), MOST_REPEATS as usize);
    }
}
