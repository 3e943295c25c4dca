//! The encoder: its zero, which may change, and whether it confirms the speed.

use super::history::SpeedSegment;
use super::speed::Spread;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::ops::RangeInclusive;

/// An encoder may differ by this much [m] plus this share from the travel that the speeds give.
/// Beyond that it was set to another zero.
const JUMP: f64 = 5e-3;
const SHARE: f64 = 0.1;
/// No belt is this many times as fast as it reports and as its station file says.
const FASTEST: f64 = 10.0;
/// This many readings in a row that contradict the speed are reported.
const CONTRADICTIONS: u32 = 5;
/// An encoder confirms the speed if its travel over a second (or the time heard so far) is within
/// this [m] or this share of what the speed gives.
const AGREED: f64 = 2e-3;
const AGREED_SHARE: f64 = 0.005;
/// The encoder contradicts the speed beyond both of these [m, share].
const DIFFERENT: f64 = 3e-3;
const DIFFERENT_SHARE: f64 = 0.01;
/// Encoder and speed are compared over this time [s], and not before there is at least [`ENOUGH`]
/// [s].
const COMPARED: f64 = 1.0;
const ENOUGH: f64 = 0.3;
/// The last part of a window [s], which must look like the whole.
const LATEST: f64 = 0.02;

/// How the belt moves according to the encoder, if the reported speed differs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Slip {
    /// Faster than the reported speed by this factor.
    Ratio(f64),
    /// At this speed [m/s], while it is reported as stationary.
    Speed(f64),
}

/// The previous zero, while it is not certain that the zero has changed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Doubt {
    zero: f64,
    /// Speed that the belt would have had [m/s] if the zero had not changed.
    speed: f64,
}

/// What the belt has reported since the last encoder reading. Belt messages without a position may
/// come in between; the encoder's travel is compared with their sum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Since {
    /// When the encoder was last read [s].
    pub time: f64,
    /// The travel at that time [m].
    travel: f64,
    /// Travel since then by the reported speeds [m].
    driven: f64,
    /// Travel since then by the estimated speeds [m].
    expected: f64,
    /// The lowest and the highest speed since then, or 0 [m/s].
    low: f64,
    high: f64,
}

/// What is known of the encoder. It survives a restart.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct BeltEncoder {
    /// What it shows when the travel is 0 [m].
    zero: Option<f64>,
    /// How often the zero has changed.
    resets: u64,
    /// Set if the last reading shows either another zero or a belt that is faster than reported;
    /// the next reading shows which.
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<Doubt>,
    /// How the belt moves if the reported speed differs.
    #[serde(skip_serializing_if = "Option::is_none")]
    slip: Option<Slip>,
    /// Its last reading, and the reports since.
    #[serde(skip_serializing_if = "Option::is_none")]
    since: Option<Since>,
}

/// One reading, and what it is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct EncoderReading {
    /// What the encoder shows [m].
    pub position: f64,
    /// When it was read [s].
    pub time: f64,
    /// When the belt was last heard before [s], and the speed reported then [m/s].
    pub heard: Option<(f64, f64)>,
    /// The encoder's last reading, and the reports since.
    pub since: Option<Since>,
    /// The belt's motion as known before this reading.
    pub before: SpeedSegment,
    /// The speed in the same message [m/s].
    pub speed: f64,
    /// The speed in the station file [m/s].
    pub nominal: f64,
}

/// How a reading was interpreted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EncoderFinding {
    /// Travel since time 0 [m].
    Travel(f64),
    /// Travel since time 0 [m], but the encoder counts from another zero; the travel since the last
    /// message is only known to within the second value [m].
    Reset(f64, f64),
}

impl EncoderFinding {
    /// Travel since time 0 [m].
    pub(super) fn travel(&self) -> f64 {
        match self {
            Self::Travel(travel) | Self::Reset(travel, _) => *travel,
        }
    }
}

impl BeltEncoder {
    /// How often its zero has changed.
    pub(super) fn resets(&self) -> u64 {
        self.resets
    }

    /// How the belt moves if the reported speed differs.
    pub(super) fn slip(&self) -> Option<Slip> {
        self.slip
    }

    /// Its last reading, and what the belt has reported since.
    pub(super) fn since(&self) -> Option<Since> {
        self.since
    }

    /// Notes a reading at `time` [s], when the belt had travelled `travel` [m].
    pub(super) fn mark(&mut self, time: f64, travel: f64) {
        self.since = Some(Since {
            time,
            travel,
            driven: 0.0,
            expected: 0.0,
            low: 0.0,
            high: 0.0,
        });
    }

    /// Notes a belt message, with or without a position, `gap` [s] after the previous one. In that
    /// time the reported speed was `said` and the estimated one `taken` [m/s].
    pub(super) fn pass(&mut self, gap: f64, said: f64, taken: f64) {
        if let Some(since) = &mut self.since {
            since.driven += said * gap;
            since.expected += taken * gap;
            since.low = since.low.min(said).min(taken);
            since.high = since.high.max(said).max(taken);
        }
    }

    /// Interprets `reading`.
    pub(super) fn read(&mut self, reading: &EncoderReading) -> EncoderFinding {
        let (position, speed) = (reading.position, reading.speed);
        let Some(zero) = self.zero else {
            let expected = reading.before.travel(reading.time);
            self.zero = Some(position - expected);
            return EncoderFinding::Travel(expected);
        };
        let (stood, gap, plausible) = plausible_travel(reading);
        let moved = position - zero - stood;
        if plausible.contains(&moved) {
            self.doubt = None;
            return EncoderFinding::Travel(position - zero);
        }
        let shown = if gap > 0.0 {
            moved / gap
        } else {
            f64::INFINITY
        };
        let is_possible =
            shown * speed >= 0.0 && shown.abs() <= FASTEST * speed.abs().max(reading.nominal);
        if let Some(doubt) = self.doubt
            && is_possible
        {
            // The second reading in a row that shows too much travel. If the zero had changed, this
            // one would agree with the speed.
            let alike = shown / doubt.speed;
            if (0.5..=2.0).contains(&alike) {
                (self.zero, self.doubt) = (Some(doubt.zero), None);
                self.resets = self.resets.saturating_sub(1);
                return EncoderFinding::Travel(position - doubt.zero);
            }
        }
        self.doubt = is_possible.then_some(Doubt { zero, speed: shown });
        self.reset(reading)
    }

    /// Takes another zero, such that the travel is what the speeds say.
    fn reset(&mut self, reading: &EncoderReading) -> EncoderFinding {
        let (last, said) = last_message(reading);
        let expected = reading.before.travel(reading.time);
        // The speed may have changed at any moment since the last message; the travel up to that
        // message is known.
        let (change, unknown) = (reading.speed - said, reading.time - last);
        let travel = if change.abs() <= SHARE * said.abs() {
            expected
        } else {
            expected + 0.5 * change * unknown
        };
        self.zero = Some(reading.position - travel);
        self.resets += 1;
        EncoderFinding::Reset(travel, (0.5 * change * unknown).abs())
    }
}

/// Time [s] and speed [m/s] of the last message. A restored state may lack it.
fn last_message(reading: &EncoderReading) -> (f64, f64) {
    reading
        .heard
        .unwrap_or((reading.time, reading.before.speed))
}

/// The travel at the last reading [m], the time since then [s], and the travel in that time that
/// the reported speeds allow [m].
fn plausible_travel(reading: &EncoderReading) -> (f64, f64, RangeInclusive<f64>) {
    let before = reading.before;
    let (from, stood, slowest, fastest) = match reading.since {
        Some(since) => (since.time, since.travel, since.low, since.high),
        // A restored state may lack the last reading; then use the last message.
        None => {
            let (last, said) = last_message(reading);
            let (low, high) = (said.min(before.speed), said.max(before.speed));
            (last, before.travel(last), low, high)
        }
    };
    let gap = reading.time - from;
    // The belt may have stood, or moved at any speed reported since the last reading, at the
    // present one, or at the station file's.
    let speed = reading.speed;
    let usual = reading.nominal.copysign(speed);
    let low = slowest.min(speed).min(usual).min(0.0) * gap;
    let high = fastest.max(speed).max(usual).max(0.0) * gap;
    let plausible = low * (1.0 + SHARE) - JUMP..=high * (1.0 + SHARE) + JUMP;
    (stood, gap, plausible)
}

/// A moment to compare with: sums over all previous readings, without the resets.
#[derive(Debug, Clone, Copy, Default)]
struct EncoderMark {
    /// Time [s].
    time: f64,
    /// Travel by the encoder [m].
    travel: f64,
    /// Travel by the speeds [m].
    driven: f64,
}

/// The readings of the last second, to compare the encoder with the speeds.
#[derive(Debug, Clone, Default)]
pub(super) struct SpeedCheck {
    marks: VecDeque<EncoderMark>,
    /// Deviations of single readings from the expected travel [m].
    steps: Spread,
    /// Resets in a row.
    contradictions: u32,
    /// The speed has changed since the last reading.
    changed: bool,
}

impl SpeedCheck {
    /// Typical deviation of a single reading [m].
    pub(super) fn noise(&self) -> f64 {
        self.steps.level()
    }

    /// Counts readings in a row that contradict the speed. Returns whether to report that now.
    pub(super) fn contradicts(&mut self, is_reset: bool) -> bool {
        self.contradictions = if is_reset {
            self.contradictions.saturating_add(1)
        } else {
            0
        };
        self.contradictions == CONTRADICTIONS
    }

    /// Notes that the speed has changed in a message without a position.
    pub(super) fn change(&mut self, encoder: &mut BeltEncoder) {
        self.changed = true;
        if matches!(encoder.slip, Some(Slip::Speed(_))) {
            encoder.slip = None;
        }
    }

    /// Compares a reading with the speeds. Their mean is `mean` [m/s], after a change or not; up to
    /// `dead` [m/s] the belt is stationary.
    pub(super) fn note(
        &mut self,
        encoder: &mut BeltEncoder,
        reading: &EncoderReading,
        found: EncoderFinding,
        (mean, changed, dead): (f64, bool, f64),
    ) {
        let changed = std::mem::take(&mut self.changed) || changed;
        let mut now = self.marks.back().copied().unwrap_or_default();
        match (reading.since, found) {
            (Some(since), EncoderFinding::Travel(travel)) => {
                let moved = travel - since.travel;
                now.time += reading.time - since.time;
                now.travel += moved;
                now.driven += since.driven;
                self.steps.note(moved - since.expected);
            }
            // Nothing was measured.
            _ if !self.marks.is_empty() && !changed => return,
            _ => {}
        }
        if changed {
            // Earlier readings say nothing about the new speed, but the ratio may still hold.
            self.marks.clear();
            if matches!(encoder.slip, Some(Slip::Speed(_))) {
                encoder.slip = None;
            }
        }
        self.marks.push_back(now);
        while self.marks.len() > 2 && self.marks[1].time <= now.time - COMPARED {
            self.marks.pop_front();
        }
        self.compare(encoder, mean, dead);
    }

    fn compare(&mut self, encoder: &mut BeltEncoder, mean: f64, dead: f64) {
        let (Some(first), Some(now)) = (self.marks.front(), self.marks.back()) else {
            return;
        };
        let since = |mark: &EncoderMark| {
            let span = now.time - mark.time;
            (span, now.travel - mark.travel, now.driven - mark.driven)
        };
        let (mut span, mut travel, mut driven) = since(first);
        if span <= 0.0 {
            return;
        }
        let noise = 2.0 * self.steps.level();
        let predicted = match encoder.slip {
            None => driven,
            Some(Slip::Ratio(ratio)) => ratio * driven,
            Some(Slip::Speed(speed)) => speed * span,
        };
        let far = |off: f64, whole: f64, least: f64, share: f64| {
            off.abs() > least.max(share * whole.abs()).max(noise)
        };
        let is_off = far(travel - predicted, predicted, DIFFERENT, DIFFERENT_SHARE);
        if !is_off && span < ENOUGH {
            return;
        }
        if is_off {
            // Either the whole window differs equally, or the belt has just changed its speed.
            let late = self.marks.iter().rev();
            let late = late.skip(1).find(|mark| now.time - mark.time >= LATEST);
            let late = late.unwrap_or(first);
            let (last_span, last_travel, last_driven) = since(late);
            let even = travel / span * last_span;
            if far(last_travel - even, even, 0.5 * DIFFERENT, SHARE) {
                (span, travel, driven) = (last_span, last_travel, last_driven);
                let from = late.time;
                self.marks.retain(|mark| mark.time >= from);
            }
        }
        let off = travel - driven;
        let agrees = match encoder.slip {
            None => !far(off, driven, DIFFERENT, DIFFERENT_SHARE),
            Some(_) => !far(off, driven, AGREED, AGREED_SHARE),
        };
        encoder.slip = if agrees {
            None
        } else if mean.abs() > dead && driven != 0.0 {
            Some(Slip::Ratio(travel / driven))
        } else {
            Some(Slip::Speed(travel / span))
        };
    }
}
