//! The belt's travel over the last minute, thinned out.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// How long the past is kept [s]: slightly longer than the age of the oldest accepted timestamp.
const KEPT: f64 = crate::clock::OLDEST + 5.0;
/// Omitted points lie within this of the line between the kept ones [m].
const OFF: f64 = 2e-4;
/// Minimum time between points [s], so that their number is bounded at any rate of the encoder.
const APART: f64 = 4e-3;
/// A stretch that ends within this of the start of the next one [m] has the speed that it states.
const SAME: f64 = 1e-9;

/// A stretch of constant speed: from `from` on, the belt's travel is `travel + speed (t - from)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct SpeedSegment {
    /// Start time [s].
    pub from: f64,
    /// Travel at the start [m].
    pub travel: f64,
    /// Speed from then on [m/s].
    pub speed: f64,
}

impl SpeedSegment {
    /// Travel at `time` [m].
    pub(super) fn travel(&self, time: f64) -> f64 {
        self.travel + self.speed * (time - self.from)
    }
}

/// The stretches before the newest one, oldest first.
///
/// With a noisy encoder nearly every message starts another stretch. Only the corners of a line
/// that passes all of them within [`OFF`] are kept: the swinging door of E. H. Bristol (Swinging
/// door trending: adaptive trend recording?, ISA National Conference, 1990, pp. 749-754).
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    points: VecDeque<SpeedSegment>,
    /// Range of slopes [m/s] from the last point that pass all points omitted since.
    door: Option<(f64, f64)>,
}

impl History {
    /// Adds `previous`, which `next` follows, unless it can be omitted. Returns whether it was
    /// added.
    pub(super) fn push(&mut self, previous: SpeedSegment, next: &SpeedSegment) -> bool {
        let Some(last) = self.points.back() else {
            self.add(previous);
            return true;
        };
        let gap = previous.from - last.from;
        if gap < APART {
            return false;
        }
        let (low, high) = self.door.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let slope = |travel: f64| (travel - last.travel) / gap;
        let low = low.max(slope(previous.travel - OFF));
        let high = high.min(slope(previous.travel + OFF));
        let whole = (next.travel - last.travel) / (next.from - last.from);
        if (low..=high).contains(&whole) {
            self.door = Some((low, high));
            return false;
        }
        self.add(previous);
        true
    }

    fn add(&mut self, point: SpeedSegment) {
        self.points.push_back(point);
        self.door = None;
    }

    /// Adds the points of another history, and keeps the newest `kept` points.
    pub(super) fn extend(&mut self, new: Vec<SpeedSegment>, kept: usize) {
        self.points.extend(new);
        let surplus = self.points.len().saturating_sub(kept);
        self.points.drain(..surplus);
        self.door = None;
    }

    /// Forgets the points that are too old at `time` [s].
    pub(super) fn forget(&mut self, time: f64) {
        // The point before the oldest time that can be requested is still needed.
        while self.points.get(1).is_some_and(|p| p.from < time - KEPT) {
            self.points.pop_front();
        }
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The newest `count` points.
    pub(super) fn newest(&self, count: usize) -> Vec<SpeedSegment> {
        let old = self.points.len().saturating_sub(count);
        self.points.range(old..).copied().collect()
    }

    /// Whether both have the same points.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.points == other.points
    }

    /// Travel at `time` [m], before `newest` began.
    pub(super) fn travel(&self, time: f64, newest: &SpeedSegment) -> f64 {
        let after = self.points.partition_point(|point| point.from <= time);
        let Some(held) = after.checked_sub(1).map(|held| self.points[held]) else {
            return self.points.front().unwrap_or(newest).travel(time);
        };
        let next = self.points.get(after).unwrap_or(newest);
        let (end, span) = (held.travel(next.from), next.from - held.from);
        if (end - next.travel).abs() < SAME || span <= 0.0 {
            return held.travel(time);
        }
        held.travel + (next.travel - held.travel) * ((time - held.from) / span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(hz: f64, seconds: f64, travel: impl Fn(f64) -> f64) -> (History, SpeedSegment) {
        let mut history = History::default();
        let at = |time: f64| SpeedSegment {
            from: time,
            travel: travel(time),
            speed: 0.0,
        };
        let mut newest = at(0.0);
        for i in 1..=(hz * seconds) as u32 {
            let next = at(f64::from(i) / hz);
            history.push(newest, &next);
            history.forget(next.from);
            newest = next;
        }
        (history, newest)
    }

    #[test]
    fn a_minute_is_kept_at_any_rate_and_few_points_of_it() {
        // Moves, stops at 30 s, moves again at 50 s; with noise of 0.01 mm.
        let travel = |t: f64| {
            let noise = 1e-5 * (1e4 * t).sin();
            0.3 * t.min(30.0) + 0.3 * (t - 50.0).max(0.0) + noise
        };
        for hz in [1.0, 20.0, 1000.0, 10_000.0] {
            let (history, newest) = drive(hz, 90.0, travel);
            assert!(history.len() < 100, "{hz} Hz: {} points", history.len());
            for i in 0..=600 {
                let time = 30.0 + f64::from(i) / 10.0;
                let off = (history.travel(time, &newest) - travel(time)).abs();
                let allowed = if hz < 2.0 { 0.3 } else { 2.0 * OFF + 0.3 / hz };
                assert!(off <= allowed, "{hz} Hz, {time} s: {off} m");
            }
        }
    }

    #[test]
    fn the_number_of_points_is_bounded_under_any_noise() {
        let (history, _) = drive(10_000.0, 70.0, |t| 0.01 * (1e5 * t).sin());
        assert!(history.len() as f64 <= KEPT / APART + 2.0);
    }
}
