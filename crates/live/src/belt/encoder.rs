//! The encoder: its zero, which may change, and how far it bears out the speed.

use super::history::Stretch;
use super::speed::Spread;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// An encoder may differ by this much [m] from what the speeds make, and by a tenth of it:
/// beyond it has been set to another zero.
const JUMP: f64 = 5e-3;
const SHARE: f64 = 0.1;
/// No belt is so many times faster than it says and than its station file says.
const FASTEST: f64 = 10.0;
/// So many readings in a row that contradict the speed are told of.
const CONTRADICTIONS: u32 = 5;
/// An encoder bears the speed out if the travel of a second, or whatever was heard of it,
/// is within this [m] or this share of what the speed makes.
const AGREED: f64 = 2e-3;
const AGREED_SHARE: f64 = 0.005;
/// And contradicts it from here on.
const DIFFERENT: f64 = 3e-3;
const DIFFERENT_SHARE: f64 = 0.01;
/// The two are compared over so long [s], and not before there is so much [s].
const COMPARED: f64 = 1.0;
const ENOUGH: f64 = 0.3;
/// The last of a window, to see whether it is like the whole [s].
const LATEST: f64 = 0.02;

/// How the belt moves, as the encoder shows it, where the speed says something else.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Slip {
    /// So many times as fast.
    Ratio(f64),
    /// So fast [m/s], while it is said to stand.
    Speed(f64),
}

/// The zero before one that may have changed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Doubt {
    zero: f64,
    /// How fast the belt would have been [m/s] if the zero had not changed.
    speed: f64,
}

/// What the belt has said since the encoder was last read. Belt messages without a position
/// may come in between: an encoder's travel is compared with what they add up to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Since {
    /// When the encoder was last read [s].
    pub time: f64,
    /// The travel then [m].
    travel: f64,
    /// Travel since, by the speeds that were said [m].
    driven: f64,
    /// Travel since, by the speeds as they were taken to be [m].
    expected: f64,
    /// The lowest and the highest speed since, or 0 [m/s].
    low: f64,
    high: f64,
}

/// What is known of the encoder, and outlives the process.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Encoder {
    /// What it shows when the travel is 0 [m].
    zero: Option<f64>,
    /// How often that has changed.
    resets: u64,
    /// The last reading was of another zero, or of a belt that is faster than it says: the
    /// next one shows which.
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<Doubt>,
    /// How the belt moves where the speed says something else.
    #[serde(skip_serializing_if = "Option::is_none")]
    slip: Option<Slip>,
    /// Its last reading, and what was said since.
    #[serde(skip_serializing_if = "Option::is_none")]
    since: Option<Since>,
}

/// One reading, with what it is compared with.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    /// What the encoder shows [m].
    pub position: f64,
    /// When [s].
    pub time: f64,
    /// When the belt was heard before [s], and how fast it has said to be then [m/s].
    pub heard: Option<(f64, f64)>,
    /// The encoder's last reading, and what was said since.
    pub since: Option<Since>,
    /// The belt as it was known.
    pub before: Stretch,
    /// The speed in the same message [m/s].
    pub speed: f64,
    /// The speed in the station file [m/s].
    pub nominal: f64,
}

/// What a reading was found to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Found {
    /// Travel since time 0 [m].
    Travel(f64),
    /// The same; the encoder counts from another zero, and the travel since the last message
    /// is known to within this [m] only.
    Reset(f64, f64),
}

impl Found {
    /// Travel since time 0 [m].
    pub fn travel(&self) -> f64 {
        match self {
            Self::Travel(travel) | Self::Reset(travel, _) => *travel,
        }
    }
}

impl Encoder {
    /// How often its zero has changed.
    pub fn resets(&self) -> u64 {
        self.resets
    }

    /// How the belt moves where the speed says something else.
    pub fn slip(&self) -> Option<Slip> {
        self.slip
    }

    /// Its last reading, and what the belt has said since.
    pub fn since(&self) -> Option<Since> {
        self.since
    }

    /// It was read at `time` [s], and the belt had travelled `travel` [m].
    pub fn mark(&mut self, time: f64, travel: f64) {
        self.since = Some(Since {
            time,
            travel,
            driven: 0.0,
            expected: 0.0,
            low: 0.0,
            high: 0.0,
        });
    }

    /// The next belt message, with a position or without, is `gap` [s] after the one before.
    /// Over that time the belt said that it moves at `said`, and was taken to move at
    /// `taken` [m/s].
    pub fn pass(&mut self, gap: f64, said: f64, taken: f64) {
        if let Some(since) = &mut self.since {
            since.driven += said * gap;
            since.expected += taken * gap;
            since.low = since.low.min(said).min(taken);
            since.high = since.high.max(said).max(taken);
        }
    }

    /// What `reading` shows.
    pub fn read(&mut self, reading: &Reading) -> Found {
        let Reading {
            position,
            time,
            before,
            ..
        } = *reading;
        let expected = before.travel(time);
        let Some(zero) = self.zero else {
            self.zero = Some(position - expected);
            return Found::Travel(expected);
        };
        // Of a state that was kept without the last reading, the last message has to do.
        let (last, said) = reading.heard.unwrap_or((time, before.speed));
        let (from, stood, slowest, fastest) = match reading.since {
            Some(since) => (since.time, since.travel, since.low, since.high),
            None => (
                last,
                before.travel(last),
                said.min(before.speed),
                said.max(before.speed),
            ),
        };
        let gap = time - from;
        // It may have stood, been as fast as it has ever said since it was last read, as it
        // says now or as the station file says.
        let speed = reading.speed;
        let usual = reading.nominal.copysign(speed);
        let low = slowest.min(speed).min(usual).min(0.0) * gap;
        let high = fastest.max(speed).max(usual).max(0.0) * gap;
        let moved = position - zero - stood;
        if (low * (1.0 + SHARE) - JUMP..=high * (1.0 + SHARE) + JUMP).contains(&moved) {
            self.doubt = None;
            return Found::Travel(position - zero);
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
            // The second reading in a row that is too far on: if the zero had changed, this
            // one would show what the speed makes.
            let alike = shown / doubt.speed;
            if (0.5..=2.0).contains(&alike) {
                (self.zero, self.doubt) = (Some(doubt.zero), None);
                self.resets = self.resets.saturating_sub(1);
                return Found::Travel(position - doubt.zero);
            }
        }
        // Whether it stopped at once or at the last moment nobody knows; up to the last
        // message it is known.
        let (change, unknown) = (speed - said, time - last);
        let travel = if change.abs() <= SHARE * said.abs() {
            expected
        } else {
            expected + 0.5 * change * unknown
        };
        self.doubt = is_possible.then_some(Doubt { zero, speed: shown });
        self.zero = Some(position - travel);
        self.resets += 1;
        Found::Reset(travel, (0.5 * change * unknown).abs())
    }
}

/// A moment that was compared: sums over what was read before, without the resets.
#[derive(Debug, Clone, Copy, Default)]
struct Mark {
    /// Time [s].
    time: f64,
    /// Travel by the encoder [m].
    travel: f64,
    /// Travel by the speeds [m].
    driven: f64,
}

/// What is remembered of the last second, to compare the encoder with the speeds.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    marks: VecDeque<Mark>,
    /// By how much single readings were off what was expected [m].
    steps: Spread,
    /// Resets in a row.
    contradictions: u32,
    /// The speed has changed since the last reading.
    changed: bool,
}

impl Comparison {
    /// By how much single readings are off [m], as a rule.
    pub fn noise(&self) -> f64 {
        self.steps.level()
    }

    /// Counts readings in a row that contradict the speed; whether that is to be told now.
    pub fn contradicts(&mut self, is_reset: bool) -> bool {
        self.contradictions = if is_reset {
            self.contradictions.saturating_add(1)
        } else {
            0
        };
        self.contradictions == CONTRADICTIONS
    }

    /// The speed has changed in a message without a position.
    pub fn change(&mut self, encoder: &mut Encoder) {
        self.changed = true;
        if matches!(encoder.slip, Some(Slip::Speed(_))) {
            encoder.slip = None;
        }
    }

    /// Compares what was read with the speeds, of which the mean is now `mean` [m/s], after a
    /// change or not, and nothing up to `dead` [m/s].
    pub fn note(
        &mut self,
        encoder: &mut Encoder,
        reading: &Reading,
        found: Found,
        (mean, changed, dead): (f64, bool, f64),
    ) {
        let changed = std::mem::take(&mut self.changed) || changed;
        let mut now = self.marks.back().copied().unwrap_or_default();
        match (reading.since, found) {
            (Some(since), Found::Travel(travel)) => {
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
            // What was before says nothing of the new speed, but the ratio may.
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

    fn compare(&mut self, encoder: &mut Encoder, mean: f64, dead: f64) {
        let (Some(first), Some(now)) = (self.marks.front(), self.marks.back()) else {
            return;
        };
        let since = |mark: &Mark| {
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
            // The whole window differs alike, or the belt has just changed.
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
