//! What is learned of the belt's noise, and what is reported about the belt.

use super::encoder::{EncoderFinding, EncoderReading, Slip, SpeedCheck};
use super::speed::{FRESH, SpeedMean};
use pickline::error::{rounded, shown_number};

/// Plans are renewed when the belt is further from its planned position than this [m] and than
/// noise explains. Noise explains at most the second value [m].
const DRIFT: f64 = 1e-3;
const MOST_DRIFT: f64 = 5e-3;
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

/// The noise of the belt messages. It is learned within about ten messages, and again after a
/// restart.
#[derive(Debug, Clone)]
pub(super) struct Learned {
    /// The mean of the reported speed.
    pub speed: SpeedMean,
    /// The encoder beside the reported speed.
    pub comparison: SpeedCheck,
    /// Beyond this deviation [m] the belt is not at its planned position.
    drift: f64,
    /// Since when the encoder differs from the speed [s], and the share that was reported.
    differs: Option<f64>,
    told: Option<f64>,
    remarks: Vec<String>,
}

impl Learned {
    /// Nothing but the mean speed [m/s]; up to `dead` [m/s] a speed is noise.
    pub(super) fn new(mean: f64, dead: f64) -> Self {
        Self {
            speed: SpeedMean::new(mean, dead),
            comparison: SpeedCheck::default(),
            drift: DRIFT,
            differs: None,
            told: None,
            remarks: Vec::new(),
        }
    }

    /// Takes the warnings about the belt since the last call.
    pub(super) fn take_remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }

    /// Beyond this deviation [m] the belt is not at its planned position.
    pub(super) fn drift(&self) -> f64 {
        self.drift
    }

    /// Up to this deviation [m/s] the mean speed may be noise.
    pub(super) fn speed_noise(&self) -> f64 {
        DEVIATIONS * self.speed.doubt()
    }

    /// Learns how far noise may put the belt from its planned position, if messages come every
    /// `gap` [s].
    pub(super) fn learn_drift(&mut self, gap: Option<f64>, has_encoder: bool) {
        let noise = if has_encoder {
            2.0 * self.comparison.noise()
        } else {
            // A random walk: the travel is the sum over the speeds.
            let steps = gap.unwrap_or(0.0).min(FRESH) * HORIZON;
            DEVIATIONS * self.speed.noise() * steps.sqrt()
        };
        self.drift = noise.clamp(DRIFT, MOST_DRIFT);
    }

    /// Reports a reading that contradicts the speed, or after which positions are uncertain.
    pub(super) fn note_reading(&mut self, reading: &EncoderReading, found: EncoderFinding) {
        let is_reset = matches!(found, EncoderFinding::Reset(..));
        let (last, said) = reading.heard.unwrap_or((reading.time, reading.speed));
        let (from, to) = (rounded(said, 3), rounded(reading.speed, 3));
        if self.comparison.contradicts(is_reset) {
            let since = reading.since.map_or(last, |since| since.time);
            let gap = rounded(reading.time - since, 3);
            self.remarks.push(format!(
                "the encoder keeps contradicting the belt's speed: at {to} m/s it shows {} m after \
                 {gap} s, which is not possible; positions follow from the speed\n  check its \
                 sign, its unit (m) and its range",
                shown_number(reading.position),
            ));
        }
        if let EncoderFinding::Reset(_, unsure) = found
            && unsure > UNSURE
        {
            let (gap, unsure) = (rounded(reading.time - last, 3), rounded(unsure, 2));
            self.remarks.push(format!(
                "the encoder was set to another zero while the belt went from {from} to {to} m/s, \
                 in {gap} s without a message: items seen before may be off by {unsure} m\n  have \
                 the encoder keep its count, or send belt messages more often"
            ));
        }
    }

    /// Reports an encoder that has differed from the speed for some time. At `time` [s] the mean
    /// reported speed is `mean` [m/s].
    pub(super) fn compare(&mut self, slip: Option<Slip>, time: f64, mean: f64) {
        let measured = match slip {
            None => {
                (self.differs, self.told) = (None, None);
                return;
            }
            Some(Slip::Ratio(ratio)) => ratio * mean,
            Some(Slip::Speed(speed)) => speed,
        };
        let since = *self.differs.get_or_insert(time);
        let share = if mean == 0.0 {
            1.0
        } else {
            measured / mean - 1.0
        };
        let is_news = self.told.is_none_or(|told| (share - told).abs() > TOLD);
        if time - since < TOLD_AFTER || share.abs() < TOLD - ROUNDING || !is_news {
            return;
        }
        self.told = Some(share);
        let (set, shown) = (rounded(mean, 3), rounded(measured, 3));
        let percent = format!("{:+.1} %", 100.0 * share);
        self.remarks.push(format!(
            "the belt reports {set} m/s but its encoder shows {shown} m/s ({percent}): plans use \
             the encoder\n  check the drive's speed and the encoder's scale"
        ));
    }
}
