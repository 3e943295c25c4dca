//! What the belt's drive is asked for: to stop while nobody can pick, or before an item
//! would be lost, and to go on.
//!
//! Invariant: while a stop is asked for, the speed to go on with is known and above 0.

use serde::{Deserialize, Serialize};

/// A request that was not followed is made again after [s].
const REPEAT: f64 = 1.0;

/// Why the belt is asked to stop or to go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// No robot takes tasks.
    NoRobot,
    /// An item would leave the last robot's reach.
    ItemLost,
    /// Neither holds any more.
    Clear,
}

impl Cause {
    /// As it is written in a request.
    pub fn text(self) -> &'static str {
        match self {
            Self::NoRobot => "no robot takes tasks",
            Self::ItemLost => "an item would leave the last robot's reach",
            Self::Clear => "robots take tasks, and no item would be lost",
        }
    }
}

/// The request that stands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Speed that is asked for [m/s].
    pub speed: f64,
    /// Why.
    pub cause: Cause,
    /// When it was made last [s].
    at: f64,
}

impl Request {
    /// Whether a belt at `speed` [m/s] does what is asked for, or is about to.
    fn is_followed(&self, speed: f64) -> bool {
        if self.speed == 0.0 {
            speed == 0.0
        } else {
            // However it gets there: it moves.
            speed > 0.0
        }
    }
}

/// What is asked of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Drive {
    /// Speed before the belt was asked to stop [m/s]; none while it is not.
    running: Option<f64>,
    request: Option<Request>,
}

impl Drive {
    /// Speed that the belt had before it was asked to stop [m/s]; none while it is not.
    pub fn running(&self) -> Option<f64> {
        self.running
    }

    /// When the standing request has to be made again [s], as the belt moves at `speed`
    /// [m/s] and does not follow it.
    pub fn repeat_at(&self, speed: f64) -> Option<f64> {
        let request = self.request?;
        (!request.is_followed(speed)).then_some(request.at + REPEAT)
    }

    /// What is asked for at `now` [s], as the belt moves at `speed` [m/s] and there is a
    /// `reason` to stop it, or none; nothing where it was asked for already.
    pub fn ask(&mut self, now: f64, speed: f64, reason: Option<Cause>) -> Option<Request> {
        let wanted = match (reason, self.running) {
            (Some(cause), None) if speed > 0.0 => {
                self.running = Some(speed);
                (0.0, cause)
            }
            (Some(_), _) => return self.again(now, speed),
            (None, Some(running)) => {
                self.running = None;
                self.request = None;
                if speed > 0.0 {
                    // Somebody has set it going already.
                    return None;
                }
                (running, Cause::Clear)
            }
            (None, None) => return self.again(now, speed),
        };
        self.request = Some(Request {
            speed: wanted.0,
            cause: wanted.1,
            at: now,
        });
        self.request
    }

    fn again(&mut self, now: f64, speed: f64) -> Option<Request> {
        let request = self.request.as_mut()?;
        if request.is_followed(speed) {
            // Whoever moves or stops the belt from now on means it.
            self.request = None;
            return None;
        }
        if now < request.at + REPEAT {
            return None;
        }
        request.at = now;
        self.request
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stops_once_goes_on_once_and_repeats_what_is_not_followed() {
        let mut drive = Drive::default();
        assert_eq!(drive.ask(0.0, 0.3, None), None);
        let stop = drive.ask(1.0, 0.3, Some(Cause::ItemLost)).unwrap();
        assert_eq!((stop.speed, drive.running()), (0.0, Some(0.3)));
        assert_eq!(drive.ask(1.5, 0.3, Some(Cause::ItemLost)), None);
        assert_eq!(drive.repeat_at(0.3), Some(2.0));
        assert_eq!(
            drive.ask(2.0, 0.2, Some(Cause::NoRobot)).unwrap().speed,
            0.0
        );
        assert_eq!(drive.repeat_at(0.0), None);
        let go = drive.ask(5.0, 0.0, None).unwrap();
        assert_eq!((go.speed, go.cause), (0.3, Cause::Clear));
        assert_eq!(drive.ask(6.0, 0.0, None).unwrap().speed, 0.3);
        assert_eq!(drive.ask(7.0, 0.1, None), None);
        // A belt that the operator has stopped is none of its business.
        assert_eq!(drive.ask(8.0, 0.0, Some(Cause::NoRobot)), None);
        assert_eq!(drive.running(), None);
    }
}
