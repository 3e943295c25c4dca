//! Where the belt is: its travel over time, as measured and as planned.

mod encoder;
mod history;
mod learned;
mod speed;

use super::protocol::BeltState;
use encoder::{BeltEncoder, EncoderReading, Slip};
use history::{History, SpeedSegment};
use learned::Learned;
use serde::{Deserialize, Serialize};
use speed::FRESH;

/// Planned speed of a stationary belt [m/s]: a station's belt cannot be slower.
const STANDING: f64 = 1e-6;
/// Up to this share of the station file's speed, and at most [`MOST_DEAD`] [m/s], the belt is
/// stationary: the reading is noise.
const DEAD_SHARE: f64 = 0.01;
const MOST_DEAD: f64 = 5e-3;
/// Plans are also renewed when the speed differs from the planned one by more than this share and
/// than noise explains.
const SPEED_CHANGE: f64 = 0.01;
/// What a belt message has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BeltChange {
    /// Nothing that matters: plans remain valid.
    None,
    /// The belt is not at its planned position.
    Plan,
    /// The message is older than one that was heard before.
    Late,
}

/// The motion of the belt. Times are in controller time, which is 0 at the first message.
///
/// Invariants: stretches follow each other without gaps in time or travel; the travel at any time
/// of the last minute is within a fraction of a millimetre of the measurement; a speed within the
/// dead band is 0.
#[derive(Debug, Clone)]
pub(crate) struct BeltMotion {
    /// The measured stretches before the newest one.
    history: History,
    /// Everything else that survives a restart.
    plan: BeltPlan,
    /// What is learned again after a restart.
    learned: Learned,
}

/// What is known of the belt besides its history.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct BeltPlan {
    /// Number of stretches ever added to the history.
    measured: u64,
    /// The speed in the station file [m/s].
    nominal: f64,
    /// The newest measured stretch.
    newest: SpeedSegment,
    /// Mean of the speed since it last changed [m/s].
    mean: f64,
    /// The stretch that plans are based on.
    planned: SpeedSegment,
    /// Whether the belt ran backwards when plans were made.
    backwards: bool,
    /// Its encoder.
    encoder: BeltEncoder,
    /// Time [s] and speed [m/s] of the last message; none before the first.
    last: Option<(f64, f64)>,
}

/// How the motion differs from an earlier one, identified by its [`BeltPlan`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct MotionChange {
    /// Stretches added to the history since then.
    new: Vec<SpeedSegment>,
    /// Number of newest stretches that are kept now.
    kept: usize,
    plan: BeltPlan,
}

/// What is learned again does not count when motions are compared.
impl PartialEq for BeltMotion {
    fn eq(&self, other: &Self) -> bool {
        self.plan == other.plan && self.history.is_same(&other.history)
    }
}

/// Speed [m/s] up to which a belt counts as stationary, for a station file's speed `nominal` [m/s].
fn dead_band(nominal: f64) -> f64 {
    (DEAD_SHARE * nominal.abs()).min(MOST_DEAD)
}

impl BeltMotion {
    /// A belt that moves at `speed` [m/s] until it reports otherwise.
    pub(crate) fn new(speed: f64) -> Self {
        let stretch = SpeedSegment {
            from: 0.0,
            travel: 0.0,
            speed,
        };
        Self {
            history: History::default(),
            plan: BeltPlan {
                measured: 0,
                nominal: speed,
                newest: stretch,
                mean: speed,
                planned: stretch,
                backwards: speed < 0.0,
                encoder: BeltEncoder::default(),
                last: None,
            },
            learned: Learned::new(speed, dead_band(speed)),
        }
    }

    /// The present state, for a later comparison with [`BeltMotion::change`].
    pub(crate) fn plan(&self) -> BeltPlan {
        self.plan
    }

    /// What has changed since the plan was `before`; everything if there was none.
    pub(crate) fn change(&self, before: Option<BeltPlan>) -> Option<MotionChange> {
        if before == Some(self.plan) {
            return None;
        }
        let kept = self.history.len();
        let new = self.plan.measured - before.map_or(0, |plan| plan.measured);
        Some(MotionChange {
            // More stretches may have been measured than are kept.
            new: self.history.newest(usize::try_from(new).unwrap_or(kept)),
            kept,
            plan: self.plan,
        })
    }

    /// Applies the change of another motion.
    pub(crate) fn apply(&mut self, change: MotionChange) {
        self.history.extend(change.new, change.kept);
        self.plan = change.plan;
        self.learned = Learned::new(self.plan.mean, dead_band(self.plan.nominal));
    }

    /// Whether the belt has ever been heard.
    pub(crate) fn is_heard(&self) -> bool {
        self.plan.last.is_some()
    }

    /// How often the encoder's zero has changed.
    pub(crate) fn encoder_resets(&self) -> u64 {
        self.plan.encoder.resets()
    }

    /// Takes the warnings about the belt since the last call.
    pub(crate) fn take_remarks(&mut self) -> Vec<String> {
        self.learned.take_remarks()
    }

    /// Handles the message `belt`, measured at `time` [s].
    pub(crate) fn hear(&mut self, time: f64, belt: &BeltState) -> BeltChange {
        let heard = self.plan.last;
        if heard.is_some_and(|(last, _)| time < last) {
            return BeltChange::Late;
        }
        self.plan.last = Some((time, belt.speed));
        let gap = heard.map(|(last, _)| time - last);
        let changed = self.learned.speed.note(belt.speed, gap);
        let before = self.plan.newest;
        if let Some((last, said)) = heard {
            self.plan.encoder.pass(time - last, said, before.speed);
        }
        let mut travel = before.travel(time);
        if let Some(position) = belt.position {
            let reading = EncoderReading {
                position,
                time,
                heard,
                since: self.plan.encoder.since(),
                before,
                speed: belt.speed,
                nominal: self.plan.nominal,
            };
            travel = self.read(&reading, changed);
        } else if changed {
            self.learned.comparison.change(&mut self.plan.encoder);
        }
        let speed = self.take_speed(belt.speed);
        self.learned.learn_drift(gap, belt.position.is_some());
        let next = SpeedSegment {
            from: time,
            travel,
            speed,
        };
        self.add(next, heard.is_some());
        if belt.position.is_some() {
            let travel = self.plan.newest.travel(time);
            self.plan.encoder.mark(time, travel);
        }
        if self.is_off(time) {
            BeltChange::Plan
        } else {
            BeltChange::None
        }
    }

    /// Reads the encoder; `changed` says whether the reported speed has changed. Returns the travel
    /// since time 0 [m].
    fn read(&mut self, reading: &EncoderReading, changed: bool) -> f64 {
        let encoder = &mut self.plan.encoder;
        let found = encoder.read(reading);
        self.learned.note_reading(reading, found);
        let mean = self.learned.speed.mean();
        let means = (mean, changed, dead_band(self.plan.nominal));
        self.learned.comparison.note(encoder, reading, found, means);
        self.learned.compare(encoder.slip(), reading.time, mean);
        found.travel()
    }

    /// Takes the mean speed from the reported speed and the encoder. Returns the speed now [m/s],
    /// of which `reported` was the last report.
    fn take_speed(&mut self, reported: f64) -> f64 {
        let dead = dead_band(self.plan.nominal);
        let moving = |speed: f64| if speed.abs() <= dead { 0.0 } else { speed };
        let mean = self.learned.speed.mean();
        let (speed, mean) = match self.plan.encoder.slip() {
            Some(Slip::Ratio(ratio)) => (ratio * mean, ratio * mean),
            Some(Slip::Speed(speed)) => (speed, speed),
            None if mean.abs() <= dead => (0.0, 0.0),
            None => (reported, mean),
        };
        self.plan.mean = moving(mean);
        moving(speed)
    }

    /// Adds a measured stretch. The one before the first message is not a measurement but the
    /// station file's speed: `was_heard` says whether there was a message before.
    fn add(&mut self, next: SpeedSegment, was_heard: bool) {
        let before = self.plan.newest;
        let expected = before.travel(next.from);
        // If nothing has changed, the first stretch stays, so that rounding errors do not add up.
        if before.speed == next.speed && (next.travel - expected).abs() < 1e-9 {
            return;
        }
        if was_heard && self.history.push(before, &next) {
            self.plan.measured += 1;
        }
        self.plan.newest = next;
        self.history.forget(next.from);
    }

    /// The speed at `time` [s]: the mean while messages come, the last reported speed afterwards.
    fn estimate(&self, time: f64) -> f64 {
        match self.plan.last {
            Some((last, _)) if time - last > FRESH => self.plan.newest.speed,
            _ => self.plan.mean,
        }
    }

    /// Whether the belt at `time` [s] is not at its planned position.
    pub(crate) fn is_off(&self, time: f64) -> bool {
        let (real, planned) = (self.plan.newest, self.plan.planned);
        let speed = self.estimate(time);
        let off = (real.travel(time) - planned.travel(time)).abs() > self.learned.drift();
        let faster = (speed.max(STANDING) - planned.speed).abs();
        let noise = self.learned.speed_noise();
        off || faster > noise.max(SPEED_CHANGE * planned.speed)
            || (speed < 0.0) != self.plan.backwards
    }

    /// Renews the plan from `time` [s] on with the newest measurement.
    pub(crate) fn plan_again(&mut self, time: f64) {
        let speed = self.estimate(time);
        self.plan.backwards = speed < 0.0;
        self.plan.planned = SpeedSegment {
            from: time,
            travel: self.plan.newest.travel(time),
            speed: speed.max(STANDING),
        };
    }

    /// Travel from time 0 to `time` [s], by the measurements around it [m].
    pub(crate) fn travel(&self, time: f64) -> f64 {
        let newest = &self.plan.newest;
        if time >= newest.from {
            newest.travel(time)
        } else {
            self.history.travel(time, newest)
        }
    }

    /// Whether the belt is stationary, by the newest measurement.
    pub(crate) fn stands(&self) -> bool {
        self.speed() == 0.0
    }

    /// The measured speed [m/s]; 0 within the dead band.
    pub(crate) fn speed(&self) -> f64 {
        self.plan.mean
    }

    /// The planned speed [m/s], above 0.
    pub(crate) fn planned_speed(&self) -> f64 {
        self.plan.planned.speed
    }

    /// Offset from an item's place on the belt to its x at time 0, if the belt had always moved at
    /// the planned speed [m].
    pub(crate) fn planned_offset(&self) -> f64 {
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
            source: None,
        }
    }

    #[test]
    fn a_steady_belt_changes_no_bit() {
        let mut motion = BeltMotion::new(0.05);
        for i in 1..1000 {
            let time = 0.37 * f64::from(i);
            assert_eq!(
                motion.hear(time, &belt(0.05, Some(3.0 + 0.05 * time))),
                BeltChange::None
            );
            assert_eq!(motion.travel(time), 0.05 * time);
        }
        assert_eq!(motion.planned_offset(), 0.0);
    }

    #[test]
    fn stops_and_other_speeds_are_followed_back_in_time() {
        let mut motion = BeltMotion::new(0.1);
        motion.hear(1.0, &belt(0.1, None));
        assert_eq!(motion.hear(10.0, &belt(0.0, None)), BeltChange::Plan);
        motion.plan_again(10.0);
        assert_eq!(motion.hear(20.0, &belt(0.2, None)), BeltChange::Plan);
        motion.plan_again(20.0);
        for (time, travel) in [(5.0, 0.5), (10.0, 1.0), (15.0, 1.0), (25.0, 2.0)] {
            assert!((motion.travel(time) - travel).abs() < 1e-12, "{time}");
        }
        let planned = motion.planned_offset() + 0.2 * 25.0;
        assert!((planned - 2.0).abs() < 1e-12);
        assert_eq!(motion.hear(19.0, &belt(0.1, None)), BeltChange::Late);
    }

    #[test]
    fn the_encoder_corrects_the_travel_and_may_be_reset() {
        let mut motion = BeltMotion::new(0.1);
        motion.hear(0.0, &belt(0.1, Some(100.0)));
        assert_eq!(
            motion.hear(10.0, &belt(0.1, Some(101.004))),
            BeltChange::Plan
        );
        assert!((motion.travel(10.0) - 1.004).abs() < 1e-12);
        motion.hear(20.0, &belt(0.1, Some(0.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(20.0) - 2.004).abs() < 1e-12);
        motion.hear(30.0, &belt(0.1, Some(1.0)));
        assert!((motion.travel(30.0) - 3.004).abs() < 1e-12);
        // The belt stood for a minute without reporting it.
        motion.hear(100.0, &belt(0.1, Some(2.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(100.0) - 4.004).abs() < 1e-12);
    }

    #[test]
    fn changes_add_up_to_the_motion() {
        let mut motion = BeltMotion::new(0.1);
        let mut copy = BeltMotion::new(7.0);
        copy.apply(motion.change(None).unwrap());
        assert_eq!(copy, motion);
        for i in 1..3 * 1000 {
            let before = motion.plan();
            // Often several changes between two comparisons, once more than are kept.
            let several = if i == 1000 { 2 * 1000 } else { i % 4 };
            for j in 0..several {
                let time = i as f64 + j as f64 / 1e4;
                motion.hear(time, &belt(0.1 + 0.01 * ((i + j) % 5) as f64, None));
            }
            if i % 3 == 0 {
                motion.plan_again(i as f64);
            }
            if let Some(change) = motion.change(Some(before)) {
                copy.apply(change);
            }
            assert_eq!(copy, motion);
        }
        assert_eq!(motion.change(Some(motion.plan())), None);
    }

    /// While messages come one of them is noise, and after a second without any the last one is
    /// all that is known.
    #[test]
    fn after_a_silence_plans_use_the_last_message() {
        let mut motion = BeltMotion::new(0.3);
        for i in 1..=200 {
            let speed = if i % 2 == 0 { 0.303 } else { 0.297 };
            motion.hear(0.1 * f64::from(i), &belt(speed, None));
        }
        motion.plan_again(20.9);
        let planned = motion.planned_speed();
        assert!((planned - 0.3).abs() < 1e-3, "{planned}");
        motion.plan_again(21.1);
        assert_eq!(motion.planned_speed(), 0.303);
    }
}
