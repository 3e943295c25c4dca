//! Where the belt is: its travel over time, measured and as it is planned with.

mod encoder;
mod history;
mod speed;

use super::protocol::BeltState;
use crate::error::{rounded, shown_number};
use encoder::{Comparison, Encoder, Found, Reading, Slip};
use history::{History, Stretch};
use serde::{Deserialize, Serialize};
use speed::{FRESH, SpeedMean};

/// A standing belt is planned with this speed [m/s]: a station's belt cannot be slower.
const STANDING: f64 = 1e-6;
/// Up to this share of the speed in the station file, and never above so much [m/s], the
/// belt stands: what is measured is noise.
const DEAD_SHARE: f64 = 0.01;
const MOST_DEAD: f64 = 5e-3;
/// Plans are made again when the belt is further than this from where they put it [m], or
/// than its noise explains, which is never more than the second [m].
const DRIFT: f64 = 1e-3;
const MOST_DRIFT: f64 = 5e-3;
/// Or when its speed differs by more than this share of theirs, and than noise explains.
const SPEED_CHANGE: f64 = 0.01;
/// What noise does not explain is beyond so many standard deviations.
const DEVIATIONS: f64 = 3.0;
/// Noise of the speed adds up over so long [s]: about the life of a task.
const HORIZON: f64 = 1.0;
/// An encoder that differs from the speed by more than this share, for so long [s], is told
/// of; and again when the share has changed by as much.
const TOLD: f64 = 0.02;
const TOLD_AFTER: f64 = 2.0;
/// What the sums of many messages may lose of that share.
const ROUNDING: f64 = 1e-6;
/// Items may be further off than this [m] after the encoder was set to another zero: told of.
const UNSURE: f64 = 0.01;

/// What a belt message changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Nothing that matters: plans hold.
    None,
    /// The belt is not where plans put it.
    Plan,
    /// The message is older than one heard already.
    Late,
}

/// The motion of the belt. Times are those of the controller, 0 at its first message.
///
/// Invariants: stretches follow each other in time, and so do their ends and beginnings in
/// travel; the travel at any time of the last minute is within a fraction of a millimetre of
/// what was measured; a speed within the dead band is 0.
#[derive(Debug, Clone)]
pub struct Motion {
    /// As measured, before the newest stretch.
    history: History,
    /// Everything else that outlives the process.
    plan: Plan,
    /// What is learned again.
    learned: Learned,
}

/// What is known of the belt besides the stretches that it has travelled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// How many stretches have ever been taken into the history.
    measured: u64,
    /// The speed in the station file [m/s].
    nominal: f64,
    /// As measured last.
    newest: Stretch,
    /// The mean of the speed since it last changed [m/s].
    mean: f64,
    /// As planned with.
    planned: Stretch,
    /// Whether the belt ran backwards when it was planned.
    backwards: bool,
    /// Its encoder.
    encoder: Encoder,
    /// The last message: when it was measured [s], and its speed [m/s]; none before the first.
    last: Option<(f64, f64)>,
}

/// What is known of noise. It is learned within some ten messages.
#[derive(Debug, Clone)]
struct Learned {
    speed: SpeedMean,
    comparison: Comparison,
    /// Further off than this [m] the belt is elsewhere.
    drift: f64,
    /// Since when the encoder differs from the speed [s], and what share was told of.
    differs: Option<f64>,
    told: Option<f64>,
    remarks: Vec<String>,
}

impl Learned {
    fn new(mean: f64, nominal: f64) -> Self {
        Self {
            speed: SpeedMean::new(mean, dead_band(nominal)),
            comparison: Comparison::default(),
            drift: DRIFT,
            differs: None,
            told: None,
            remarks: Vec::new(),
        }
    }
}

/// How the motion differs from what it was when it had an earlier [`Plan`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotionChange {
    /// Stretches taken into the history since.
    new: Vec<Stretch>,
    /// How many there are now, the newest.
    kept: usize,
    plan: Plan,
}

/// What is learned again is no part of what a motion is.
impl PartialEq for Motion {
    fn eq(&self, other: &Self) -> bool {
        self.plan == other.plan && self.history.is_same(&other.history)
    }
}

/// Up to which speed [m/s] a belt stands that runs at `nominal` [m/s] as a rule.
fn dead_band(nominal: f64) -> f64 {
    (DEAD_SHARE * nominal.abs()).min(MOST_DEAD)
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
            history: History::default(),
            plan: Plan {
                measured: 0,
                nominal: speed,
                newest: stretch,
                mean: speed,
                planned: stretch,
                backwards: speed < 0.0,
                encoder: Encoder::default(),
                last: None,
            },
            learned: Learned::new(speed, speed),
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
        let kept = self.history.len();
        let new = self.plan.measured - before.map_or(0, |plan| plan.measured);
        Some(MotionChange {
            // More may have been measured than is kept.
            new: self.history.newest(usize::try_from(new).unwrap_or(kept)),
            kept,
            plan: self.plan,
        })
    }

    /// Changes as another motion has.
    pub fn apply(&mut self, change: MotionChange) {
        self.history.extend(change.new, change.kept);
        self.plan = change.plan;
        self.learned = Learned::new(self.plan.mean, self.plan.nominal);
    }

    /// Whether the belt has ever been heard.
    pub fn is_heard(&self) -> bool {
        self.plan.last.is_some()
    }

    /// How often the encoder's zero has changed.
    pub fn encoder_resets(&self) -> u64 {
        self.plan.encoder.resets()
    }

    /// What is strange about the belt, since this was last asked.
    pub fn take_remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.learned.remarks)
    }

    /// Takes note of `belt`, measured at `time` [s].
    pub fn hear(&mut self, time: f64, belt: &BeltState) -> Change {
        let heard = self.plan.last;
        if heard.is_some_and(|(last, _)| time < last) {
            return Change::Late;
        }
        self.plan.last = Some((time, belt.speed));
        let dead = dead_band(self.plan.nominal);
        let gap = heard.map(|(last, _)| time - last);
        let changed = self.learned.speed.note(belt.speed, gap);
        let mean = self.learned.speed.mean();
        let before = self.plan.newest;
        let expected = before.travel(time);
        let mut travel = expected;
        if let Some((last, said)) = heard {
            self.plan.encoder.pass(time - last, said, before.speed);
        }
        if let Some(position) = belt.position {
            let reading = Reading {
                position,
                time,
                heard,
                since: self.plan.encoder.since(),
                before,
                speed: belt.speed,
                nominal: self.plan.nominal,
            };
            let found = self.read(&reading);
            travel = found.travel();
            let means = (mean, changed, dead);
            let encoder = &mut self.plan.encoder;
            self.learned
                .comparison
                .note(encoder, &reading, found, means);
            self.compare(time, mean);
        } else if changed {
            self.learned.comparison.change(&mut self.plan.encoder);
        }
        let stands = |speed: f64| speed.abs() <= dead;
        let (speed, mean) = match self.plan.encoder.slip() {
            Some(Slip::Ratio(ratio)) => (ratio * mean, ratio * mean),
            Some(Slip::Speed(speed)) => (speed, speed),
            None if stands(mean) => (0.0, 0.0),
            None => (belt.speed, mean),
        };
        self.plan.mean = if stands(mean) { 0.0 } else { mean };
        let speed = if stands(speed) { 0.0 } else { speed };
        self.learned.drift = self.noise(gap, belt.position.is_some());
        // Where nothing has changed the first stretch stays, so that positions do not
        // collect roundings.
        let same = before.speed == speed && (travel - expected).abs() < 1e-9;
        if !same {
            let next = Stretch {
                from: time,
                travel,
                speed,
            };
            // What the station file says about the time before the first message is no
            // measurement.
            if heard.is_some() && self.history.push(before, &next) {
                self.plan.measured += 1;
            }
            self.plan.newest = next;
            self.history.forget(time);
        }
        if belt.position.is_some() {
            let travel = self.plan.newest.travel(time);
            self.plan.encoder.mark(time, travel);
        }
        if self.is_off(time) {
            Change::Plan
        } else {
            Change::None
        }
    }

    fn read(&mut self, reading: &Reading) -> Found {
        let zeroed = self.plan.encoder.read(reading);
        let is_reset = matches!(zeroed, Found::Reset(..));
        let (last, said) = reading.heard.unwrap_or((reading.time, reading.speed));
        let gap = rounded(reading.time - last, 3);
        let (from, to) = (rounded(said, 3), rounded(reading.speed, 3));
        if self.learned.comparison.contradicts(is_reset) {
            let since = reading.since.map_or(last, |since| since.time);
            let gap = rounded(reading.time - since, 3);
            self.learned.remarks.push(format!(
                "the encoder contradicts the belt's speed again and again: at {to} m/s it shows {} m \
                 after {gap} s, which is not where it can be; positions follow from the speed\n  check \
                 its sign, its unit (m) and how far it counts",
                shown_number(reading.position),
            ));
        }
        if let Found::Reset(_, unsure) = zeroed
            && unsure > UNSURE
        {
            let unsure = rounded(unsure, 2);
            self.learned.remarks.push(format!(
                "the encoder was set to another zero while the belt went from {from} to {to} m/s, \
                 in {gap} s without a message: what was seen before may be {unsure} m from where \
                 it is thought to be\n  have the encoder keep its count, or send belt messages \
                 more often"
            ));
        }
        zeroed
    }

    /// Tells of an encoder that differs from the speed for some time.
    fn compare(&mut self, time: f64, mean: f64) {
        let measured = match self.plan.encoder.slip() {
            None => {
                (self.learned.differs, self.learned.told) = (None, None);
                return;
            }
            Some(Slip::Ratio(ratio)) => ratio * mean,
            Some(Slip::Speed(speed)) => speed,
        };
        let since = *self.learned.differs.get_or_insert(time);
        let share = if mean == 0.0 {
            1.0
        } else {
            measured / mean - 1.0
        };
        let is_news = self
            .learned
            .told
            .is_none_or(|told| (share - told).abs() > TOLD);
        if time - since < TOLD_AFTER || share.abs() < TOLD - ROUNDING || !is_news {
            return;
        }
        self.learned.told = Some(share);
        let (set, shown) = (rounded(mean, 3), rounded(measured, 3));
        let percent = format!("{:+.1} %", 100.0 * share);
        self.learned.remarks.push(format!(
            "the belt says {set} m/s and its encoder shows {shown} m/s ({percent}): planned with the \
             encoder\n  check the drive's speed and the encoder's scale"
        ));
    }

    /// How far the belt may be from where plans put it [m] without being elsewhere, when
    /// messages come every `gap` [s].
    fn noise(&self, gap: Option<f64>, has_encoder: bool) -> f64 {
        let noise = if has_encoder {
            2.0 * self.learned.comparison.noise()
        } else {
            // A random walk: the travel is the sum of what the speeds make.
            let steps = gap.unwrap_or(0.0).min(FRESH) * HORIZON;
            DEVIATIONS * self.learned.speed.noise() * steps.sqrt()
        };
        noise.clamp(DRIFT, MOST_DRIFT)
    }

    /// The speed at `time` [s]: the mean while messages come, and their last word after.
    fn estimate(&self, time: f64) -> f64 {
        match self.plan.last {
            Some((last, _)) if time - last > FRESH => self.plan.newest.speed,
            _ => self.plan.mean,
        }
    }

    /// Whether the belt at `time` [s] is not where plans put it.
    pub fn is_off(&self, time: f64) -> bool {
        let (real, planned) = (self.plan.newest, self.plan.planned);
        let speed = self.estimate(time);
        let off = (real.travel(time) - planned.travel(time)).abs() > self.learned.drift;
        let faster = (speed.max(STANDING) - planned.speed).abs();
        let noise = DEVIATIONS * self.learned.speed.doubt();
        off || faster > noise.max(SPEED_CHANGE * planned.speed)
            || (speed < 0.0) != self.plan.backwards
    }

    /// Plans from `time` [s] on with what was measured last.
    pub fn plan_again(&mut self, time: f64) {
        let speed = self.estimate(time);
        self.plan.backwards = speed < 0.0;
        self.plan.planned = Stretch {
            from: time,
            travel: self.plan.newest.travel(time),
            speed: speed.max(STANDING),
        };
    }

    /// Travel since time 0 at `time` [s], by the measurements around it [m].
    pub fn travel(&self, time: f64) -> f64 {
        let newest = &self.plan.newest;
        if time >= newest.from {
            newest.travel(time)
        } else {
            self.history.travel(time, newest)
        }
    }

    /// Whether it stands, by what was measured last.
    pub fn stands(&self) -> bool {
        self.speed() == 0.0
    }

    /// Speed as it is known [m/s]; 0 within the dead band.
    pub fn speed(&self) -> f64 {
        self.plan.mean
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
            source: None,
        }
    }

    #[test]
    fn a_steady_belt_changes_no_bit() {
        let mut motion = Motion::new(0.05);
        for i in 1..1000 {
            let time = 0.37 * f64::from(i);
            assert_eq!(
                motion.hear(time, &belt(0.05, Some(3.0 + 0.05 * time))),
                Change::None
            );
            assert_eq!(motion.travel(time), 0.05 * time);
        }
        assert_eq!(motion.planned_offset(), 0.0);
    }

    #[test]
    fn stops_and_other_speeds_are_followed_back_in_time() {
        let mut motion = Motion::new(0.1);
        motion.hear(1.0, &belt(0.1, None));
        assert_eq!(motion.hear(10.0, &belt(0.0, None)), Change::Plan);
        motion.plan_again(10.0);
        assert_eq!(motion.hear(20.0, &belt(0.2, None)), Change::Plan);
        motion.plan_again(20.0);
        for (time, travel) in [(5.0, 0.5), (10.0, 1.0), (15.0, 1.0), (25.0, 2.0)] {
            assert!((motion.travel(time) - travel).abs() < 1e-12, "{time}");
        }
        let planned = motion.planned_offset() + 0.2 * 25.0;
        assert!((planned - 2.0).abs() < 1e-12);
        assert_eq!(motion.hear(19.0, &belt(0.1, None)), Change::Late);
    }

    #[test]
    fn the_encoder_corrects_the_travel_and_may_be_reset() {
        let mut motion = Motion::new(0.1);
        motion.hear(0.0, &belt(0.1, Some(100.0)));
        assert_eq!(motion.hear(10.0, &belt(0.1, Some(101.004))), Change::Plan);
        assert!((motion.travel(10.0) - 1.004).abs() < 1e-12);
        motion.hear(20.0, &belt(0.1, Some(0.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(20.0) - 2.004).abs() < 1e-12);
        motion.hear(30.0, &belt(0.1, Some(1.0)));
        assert!((motion.travel(30.0) - 3.004).abs() < 1e-12);
        // It stood for a minute, and nobody said so.
        motion.hear(100.0, &belt(0.1, Some(2.0)));
        assert_eq!(motion.encoder_resets(), 1);
        assert!((motion.travel(100.0) - 4.004).abs() < 1e-12);
    }

    #[test]
    fn changes_add_up_to_the_motion() {
        let mut motion = Motion::new(0.1);
        let mut copy = Motion::new(7.0);
        copy.apply(motion.change(None).unwrap());
        assert_eq!(copy, motion);
        for i in 1..3 * 1000 {
            let before = motion.plan();
            // Often several between two looks, once more than are kept.
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
    fn after_a_silence_plans_go_by_the_last_word() {
        let mut motion = Motion::new(0.3);
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
