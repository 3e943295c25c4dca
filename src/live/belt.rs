//! Where the belt is: its travel over time, measured and as it is planned with.

use super::protocol::BeltState;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Slower than this [m/s] the belt stands: a station's belt cannot be slower.
const STANDING: f64 = 1e-6;
/// Plans are made anew when the belt is further than this from where they put it [m].
const DRIFT: f64 = 1e-3;
/// Or when its speed differs by more than this share of theirs.
const SPEED_CHANGE: f64 = 0.01;
/// An encoder that is further than this from the travel that the speed makes [m] has been
/// set to another zero.
const JUMP: f64 = 0.1;
/// Measurements kept for detections that come late.
const KEPT: usize = 1024;

/// From `from` on the belt has travelled `travel + speed (t - from)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Stretch {
    from: f64,
    travel: f64,
    speed: f64,
}

impl Stretch {
    fn travel(&self, time: f64) -> f64 {
        self.travel + self.speed * (time - self.from)
    }
}

/// What a belt message changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Nothing that matters: plans hold.
    None,
    /// The belt is not where plans put it.
    Plan,
    /// The message is older than one already heeded.
    Late,
}

/// The motion of the belt. Times are those of the controller, 0 at its first message.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// As measured, the newest last; never empty.
    measured: VecDeque<Stretch>,
    /// Everything else.
    plan: Plan,
}

/// What is known of the belt besides the stretches that it has travelled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// How many stretches have ever been measured.
    measured: u64,
    /// As planned with.
    planned: Stretch,
    /// What the encoder shows when the travel is 0 [m].
    encoder_zero: Option<f64>,
    /// When the last message was measured [s]; none before the first.
    last: Option<f64>,
    /// How often the encoder's zero has changed.
    encoder_resets: u64,
}

/// How the motion differs from what it was when it had an earlier [`Plan`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotionChange {
    /// Stretches measured since.
    new: Vec<Stretch>,
    /// How many there are now, the newest.
    kept: usize,
    plan: Plan,
}

impl Motion {
    /// A belt that moves at `speed` [m/s] until it says otherwise.
    pub fn new(speed: f64) -> Self {
        let stretch = Stretch {
            from: 0.0,
            travel: 0.0,
            speed,
        };
        Self {
            measured: VecDeque::from([stretch]),
            plan: Plan {
                measured: 1,
                planned: stretch,
                encoder_zero: None,
                last: None,
                encoder_resets: 0,
            },
        }
    }

    /// What to compare with later, to find what has changed.
    pub fn plan(&self) -> Plan {
        self.plan
    }

    /// What has changed since the plan was `before`; all of it when there was none.
    pub fn change(&self, before: Option<Plan>) -> Option<MotionChange> {
        if before == Some(self.plan) {
            return None;
        }
        let kept = self.measured.len();
        let new = self.plan.measured - before.map_or(0, |plan| plan.measured);
        // More may have been measured than is kept.
        let old = kept.saturating_sub(usize::try_from(new).unwrap_or(kept));
        Some(MotionChange {
            new: self.measured.range(old..).copied().collect(),
            kept,
            plan: self.plan,
        })
    }

    /// Changes as another motion has.
    pub fn apply(&mut self, change: MotionChange) {
        self.measured.extend(change.new);
        let surplus = self.measured.len().saturating_sub(change.kept.max(1));
        self.measured.drain(..surplus);
        self.plan = change.plan;
    }

    /// Whether the belt has ever been heard.
    pub fn is_heard(&self) -> bool {
        self.plan.last.is_some()
    }

    /// How often the encoder's zero has changed.
    pub fn encoder_resets(&self) -> u64 {
        self.plan.encoder_resets
    }

    /// Takes note of `belt`, measured at `time` [s].
    pub fn heed(&mut self, time: f64, belt: &BeltState) -> Change {
        let heard = self.plan.last;
        if heard.is_some_and(|last| time < last) {
            return Change::Late;
        }
        self.plan.last = Some(time);
        let before = self.newest();
        let expected = before.travel(time);
        let mut travel = expected;
        if let Some(position) = belt.position {
            let zero = *self.plan.encoder_zero.get_or_insert(position - expected);
            let moved = (expected - before.travel).abs();
            travel = position - zero;
            // Less travel than expected may be a stop that nobody told of.
            let stood = heard.map_or(expected, |last| before.travel(last));
            let slack = JUMP.max(JUMP * moved);
            let (low, high) = (stood.min(expected), stood.max(expected));
            if travel < low - slack || travel > high + slack {
                self.plan.encoder_zero = Some(position - expected);
                self.plan.encoder_resets += 1;
                travel = expected;
            }
        }
        // Where nothing has changed the first stretch stays, so that positions do not
        // collect roundings.
        let same = before.speed == belt.speed && (travel - expected).abs() < 1e-9;
        if !same {
            if self.measured.len() == KEPT {
                self.measured.pop_front();
            }
            self.measured.push_back(Stretch {
                from: time,
                travel,
                speed: belt.speed,
            });
            self.plan.measured += 1;
            if heard.is_none() {
                // What the station file says about the time before is no measurement.
                self.measured.pop_front();
            }
        }
        if self.is_off(time) {
            Change::Plan
        } else {
            Change::None
        }
    }

    fn newest(&self) -> Stretch {
        // There is always one.
        self.measured[self.measured.len() - 1]
    }

    /// Whether the belt at `time` [s] is not where plans put it.
    pub fn is_off(&self, time: f64) -> bool {
        let (real, planned) = (self.newest(), self.plan.planned);
        let off = (real.travel(time) - planned.travel(time)).abs() > DRIFT;
        let faster = (real.speed.max(STANDING) - planned.speed).abs();
        off || faster > SPEED_CHANGE * planned.speed
    }

    /// Plans from `time` [s] on with what was measured last.
    pub fn plan_anew(&mut self, time: f64) {
        let real = self.newest();
        self.plan.planned = Stretch {
            from: time,
            travel: real.travel(time),
            speed: real.speed.max(STANDING),
        };
    }

    /// Travel since time 0 at `time` [s], by the measurement that held then [m].
    pub fn travel(&self, time: f64) -> f64 {
        let held = self.measured.iter().rev().find(|s| s.from <= time);
        held.unwrap_or(&self.measured[0]).travel(time)
    }

    /// Speed as measured last [m/s].
    pub fn speed(&self) -> f64 {
        self.newest().speed
    }

    /// Speed that is planned with [m/s], above 0.
    pub fn planned_speed(&self) -> f64 {
        self.plan.planned.speed
    }

    /// What turns an item's place on the belt into its x at time 0 if the belt had always
    /// moved at the planned speed [m].
    pub fn planned_offset(&self) -> f64 {
        let planned = self.plan.planned;
        planned.travel - planned.speed * planned.from
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn belt(speed: f64, position: Option<f64>) -> BeltState {
        BeltState {
            stamp: 0.0,
            speed,
            position,
        }
    }

    #[test]
    fn a_steady_belt_changes_no_bit() {
        let mut motion = Motion::new(0.05);
        for i in 1..1000 {
            let time = 0.37 * f64::from(i);
            assert_eq!(
                motion.heed(time, &belt(0.05, Some(3.0 + 0.05 * time))),
                Change::None
            );
            assert_eq!(motion.travel(time), 0.05 * time);
        }
        assert_eq!(motion.planned_offset(), 0.0);
    }

    #[test]
    fn stops_and_other_speeds_are_followed_back_in_time() {
        let mut motion = Motion::new(0.1);
        motion.heed(1.0, &belt(0.1, None));
        assert_eq!(motion.heed(10.0, &belt(0.0, None)), Change::Plan);
        motion.plan_anew(10.0);
        assert_eq!(motion.heed(20.0, &belt(0.2, None)), Change::Plan);
        motion.plan_anew(20.0);
        for (time, travel) in [(5.0, 0.5), (10.0, 1.0), (15.0, 1.0), (25.0, 2.0)] {
            assert!((motion.travel(time) - travel).abs() < 1e-12, "{time}");
        }
        let planned = motion.planned_offset() + 0.2 * 25.0;
        assert!((planned - 2.0).abs() < 1e-12);
        assert_eq!(motion.heed(19.0, &belt(0.1, None)), Change::Late);
    }

    #[test]
    fn the_encoder_corrects_the_travel_and_may_be_reset() {
        let mut motion = Motion::new(0.1);
        motion.heed(0.0, &belt(0.1, Some(100.0)));
        assert_eq!(motion.heed(10.0, &belt(0.1, Some(101.004))), Change::Plan);
        assert!((motion.travel(10.0) - 1.004).abs() < 1e-12);
        motion.heed(20.0, &belt(0.1, Some(0.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(20.0) - 2.004).abs() < 1e-12);
        motion.heed(30.0, &belt(0.1, Some(1.0)));
        assert!((motion.travel(30.0) - 3.004).abs() < 1e-12);
        // It stood for a minute, and nobody said so.
        motion.heed(100.0, &belt(0.1, Some(2.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(100.0) - 4.004).abs() < 1e-12);
    }

    #[test]
    fn changes_add_up_to_the_motion() {
        let mut motion = Motion::new(0.1);
        let mut copy = Motion::new(7.0);
        copy.apply(motion.change(None).unwrap());
        assert_eq!(copy, motion);
        for i in 1..3 * KEPT {
            let before = motion.plan();
            // Often several between two looks, once more than are kept.
            let several = if i == KEPT { 2 * KEPT } else { i % 4 };
            for j in 0..several {
                let time = i as f64 + j as f64 / 1e4;
                motion.heed(time, &belt(0.1 + 0.01 * ((i + j) % 5) as f64, None));
            }
            if i % 3 == 0 {
                motion.plan_anew(i as f64);
            }
            if let Some(change) = motion.change(Some(before)) {
                copy.apply(change);
            }
            assert_eq!(copy, motion);
        }
        assert_eq!(motion.change(Some(motion.plan())), None);
    }
}
