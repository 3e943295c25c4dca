//! Where the belt is: its travel over time, as measured and as planned.

mod encoder;
mod history;
mod speed;

use super::protocol::BeltState;
use encoder::{BeltEncoder, EncoderFinding, EncoderReading, Slip, SpeedCheck};
use history::{History, SpeedSegment};
use pickline::error::{rounded, shown_number};
use serde::{Deserialize, Serialize};
use speed::{FRESH, SpeedMean};

/// Planned speed of a stationary belt [m/s]: a station's belt cannot be slower.
const STANDING: f64 = 1e-6;
/// Up to this share of the station file's speed, and at most [`MOST_DEAD`] [m/s], the belt is
/// stationary: the reading is noise.
const DEAD_SHARE: f64 = 0.01;
const MOST_DEAD: f64 = 5e-3;
/// Plans are renewed when the belt is further from its planned position than this [m] and than
/// noise explains. Noise explains at most the second value [m].
const DRIFT: f64 = 1e-3;
const MOST_DRIFT: f64 = 5e-3;
/// Plans are also renewed when the speed differs from the planned one by more than this share and
/// than noise explains.
const SPEED_CHANGE: f64 = 0.01;
/// Noise explains deviations up to this many standard deviations.
const DEVIATIONS: f64 = 3.0;
/// Noise of the speed adds up over this time [s]: about the life of a task.
const HORIZON: f64 = 1.0;
/// An encoder that differs from the speed by more than this share, for [`TOLD_AFTER`] [s], is
/// reported; and again when the share has changed by as much.
const TOLD: f64 = 0.02;
const TOLD_AFTER: f64 = 2.0;
/// Rounding error of that share over the sums of many messages.
const ROUNDING: f64 = 1e-6;
/// An encoder reset after which items may be off by more than this [m] is reported.
const UNSURE: f64 = 0.01;

/// What a belt message has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BeltChange {
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
pub struct BeltMotion {
    /// The measured stretches before the newest one.
    history: History,
    /// Everything else that survives a restart.
    plan: BeltPlan,
    /// What is learned again after a restart.
    learned: Learned,
}

/// What is known of the belt besides its history.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeltPlan {
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

/// The noise of the belt messages. It is learned within about ten messages.
#[derive(Debug, Clone)]
struct Learned {
    speed: SpeedMean,
    comparison: SpeedCheck,
    /// Beyond this deviation [m] the belt is not at its planned position.
    drift: f64,
    /// Since when the encoder differs from the speed [s], and the share that was reported.
    differs: Option<f64>,
    told: Option<f64>,
    remarks: Vec<String>,
}

impl Learned {
    fn new(mean: f64, nominal: f64) -> Self {
        Self {
            speed: SpeedMean::new(mean, dead_band(nominal)),
            comparison: SpeedCheck::default(),
            drift: DRIFT,
            differs: None,
            told: None,
            remarks: Vec::new(),
        }
    }
}

/// How the motion differs from an earlier one, identified by its [`BeltPlan`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MotionChange {
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
    pub fn new(speed: f64) -> Self {
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
            learned: Learned::new(speed, speed),
        }
    }

    /// The present state, for a later comparison with [`BeltMotion::change`].
    pub fn plan(&self) -> BeltPlan {
        self.plan
    }

    /// What has changed since the plan was `before`; everything if there was none.
    pub fn change(&self, before: Option<BeltPlan>) -> Option<MotionChange> {
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

    /// Takes the warnings about the belt since the last call.
    pub fn take_remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.learned.remarks)
    }

    /// Handles the message `belt`, measured at `time` [s].
    pub fn hear(&mut self, time: f64, belt: &BeltState) -> BeltChange {
        let heard = self.plan.last;
        if heard.is_some_and(|(last, _)| time < last) {
            return BeltChange::Late;
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
            let reading = EncoderReading {
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
        // If nothing has changed, the first stretch stays, so that rounding errors do not add up.
        let same = before.speed == speed && (travel - expected).abs() < 1e-9;
        if !same {
            let next = SpeedSegment {
                from: time,
                travel,
                speed,
            };
            // The station file's speed before the first message is not a measurement.
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
            BeltChange::Plan
        } else {
            BeltChange::None
        }
    }

    fn read(&mut self, reading: &EncoderReading) -> EncoderFinding {
        let zeroed = self.plan.encoder.read(reading);
        let is_reset = matches!(zeroed, EncoderFinding::Reset(..));
        let (last, said) = reading.heard.unwrap_or((reading.time, reading.speed));
        let gap = rounded(reading.time - last, 3);
        let (from, to) = (rounded(said, 3), rounded(reading.speed, 3));
        if self.learned.comparison.contradicts(is_reset) {
            let since = reading.since.map_or(last, |since| since.time);
            let gap = rounded(reading.time - since, 3);
            self.learned.remarks.push(format!(
                "the encoder keeps contradicting the belt's speed: at {to} m/s it shows {} m after \
                 {gap} s, which is not possible; positions follow from the speed\n  check its \
                 sign, its unit (m) and its range",
                shown_number(reading.position),
            ));
        }
        if let EncoderFinding::Reset(_, unsure) = zeroed
            && unsure > UNSURE
        {
            let unsure = rounded(unsure, 2);
            self.learned.remarks.push(format!(
                "the encoder was set to another zero while the belt went from {from} to {to} m/s, \
                 in {gap} s without a message: items seen before may be off by {unsure} m\n  have \
                 the encoder keep its count, or send belt messages more often"
            ));
        }
        zeroed
    }

    /// Reports an encoder that has differed from the speed for some time.
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
            "the belt reports {set} m/s but its encoder shows {shown} m/s ({percent}): plans use \
             the encoder\n  check the drive's speed and the encoder's scale"
        ));
    }

    /// How far noise may put the belt from its planned position [m], if messages come every `gap`
    /// [s].
    fn noise(&self, gap: Option<f64>, has_encoder: bool) -> f64 {
        let noise = if has_encoder {
            2.0 * self.learned.comparison.noise()
        } else {
            // A random walk: the travel is the sum over the speeds.
            let steps = gap.unwrap_or(0.0).min(FRESH) * HORIZON;
            DEVIATIONS * self.learned.speed.noise() * steps.sqrt()
        };
        noise.clamp(DRIFT, MOST_DRIFT)
    }

    /// The speed at `time` [s]: the mean while messages come, the last reported speed afterwards.
    fn estimate(&self, time: f64) -> f64 {
        match self.plan.last {
            Some((last, _)) if time - last > FRESH => self.plan.newest.speed,
            _ => self.plan.mean,
        }
    }

    /// Whether the belt at `time` [s] is not at its planned position.
    pub fn is_off(&self, time: f64) -> bool {
        let (real, planned) = (self.plan.newest, self.plan.planned);
        let speed = self.estimate(time);
        let off = (real.travel(time) - planned.travel(time)).abs() > self.learned.drift;
        let faster = (speed.max(STANDING) - planned.speed).abs();
        let noise = DEVIATIONS * self.learned.speed.doubt();
        off || faster > noise.max(SPEED_CHANGE * planned.speed)
            || (speed < 0.0) != self.plan.backwards
    }

    /// Renews the plan from `time` [s] on with the newest measurement.
    pub fn plan_again(&mut self, time: f64) {
        let speed = self.estimate(time);
        self.plan.backwards = speed < 0.0;
        self.plan.planned = SpeedSegment {
            from: time,
            travel: self.plan.newest.travel(time),
            speed: speed.max(STANDING),
        };
    }

    /// Travel from time 0 to `time` [s], by the measurements around it [m].
    pub fn travel(&self, time: f64) -> f64 {
        let newest = &self.plan.newest;
        if time >= newest.from {
            newest.travel(time)
        } else {
            self.history.travel(time, newest)
        }
    }

    /// Whether the belt is stationary, by the newest measurement.
    pub fn stands(&self) -> bool {
        self.speed() == 0.0
    }

    /// The measured speed [m/s]; 0 within the dead band.
    pub fn speed(&self) -> f64 {
        self.plan.mean
    }

    /// The planned speed [m/s], above 0.
    pub fn planned_speed(&self) -> f64 {
        self.plan.planned.speed
    }

    /// Offset from an item's place on the belt to its x at time 0, if the belt had always moved at
    /// the planned speed [m].
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
    fn after_a_silence_plans_go_by_the_last_word() {
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
