//! The sources of messages (cameras, the belt, robots), and whether they are silent.
//!
//! Invariants: the time at which a source was last heard never goes back; only a source that
//! repeats itself regularly has a period; at most [`MOST`] sources are tracked separately.

mod offset;
mod period;

use super::protocol::{SourceKind, SourceReport};
use crate::RemarkSetting;
use offset::{Offset, StampJudgement};
use period::Period;
use std::collections::BTreeMap;

/// Maximum number of sources tracked separately, because names come from outside.
const MOST: usize = 64;
/// A source is reported if all its messages come this much later than their timestamps [s].
const LATE: f64 = 0.5;
/// The common name of all further sources.
const OTHERS: &str = "others";

/// By default a source is overdue after this many of its periods, and not before [`LEAST`] [s].
const PERIODS: f64 = 10.0;
const LEAST: f64 = 1.0;
/// Minimum for a camera [s], which has nothing to report over an empty belt.
const LEAST_OF_CAMERA: f64 = 10.0;

/// A source repeats itself if its value differs by at most this, or by this share, because a
/// measured speed is never exactly the same twice.
const SAME: f64 = 5e-3;
const SAME_SHARE: f64 = 0.1;

/// The kind and the name of a source.
pub(crate) type SourceKey = (SourceKind, String);

/// Times of silence after which sources are overdue [s]. 0 is never; without a value it follows
/// from their periods.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Timeouts {
    /// For the belt [s].
    pub belt: Option<f64>,
    /// For a robot [s].
    pub robot: Option<f64>,
}

impl Timeouts {
    /// With this time for the belt [s].
    #[must_use]
    pub fn with_belt(mut self, belt: impl Into<Option<f64>>) -> Self {
        self.belt = belt.into();
        self
    }

    /// With this time for a robot [s].
    #[must_use]
    pub fn with_robot(mut self, robot: impl Into<Option<f64>>) -> Self {
        self.robot = robot.into();
        self
    }
}

/// The state of a source.
#[derive(Debug, Clone)]
struct Source {
    /// When it was last heard [s].
    heard: f64,
    /// Time [s] and value of its last reported state.
    said: Option<(f64, f64)>,
    period: Period,
    offset: Offset,
    /// Whether it was reported as overdue, and as late.
    told: bool,
    told_late: bool,
}

/// The states of all sources.
#[derive(Debug, Clone)]
pub(crate) struct Sources {
    table: BTreeMap<SourceKey, Source>,
    timeouts: Timeouts,
    /// By how much the machine's clock is ahead of the node's time because it was set [s].
    ahead: f64,
    /// Whether offsets are estimated. With message time there is nothing to compare with.
    has_offsets: bool,
}

/// How a timestamp is mapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MappedStamp {
    /// What is added to it [s].
    pub shift: f64,
    /// The step of the source's clock since its last message, if there was one.
    pub stepped: Option<ClockStep>,
}

/// A step of a source's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClockStep {
    /// By how much the clock is ahead of what was expected [s].
    pub by: f64,
    /// Whether this is the first message of the source, so that it is not known whether the clock
    /// was set.
    pub is_first: bool,
}

impl Sources {
    /// No sources yet.
    pub(crate) fn new(timeouts: Timeouts, has_offsets: bool) -> Self {
        Self {
            table: BTreeMap::new(),
            timeouts,
            ahead: 0.0,
            has_offsets,
        }
    }

    /// By how much the machine's clock is ahead of the node's time because it was set [s].
    pub(crate) fn ahead(&self) -> f64 {
        self.ahead
    }

    /// Sets by how much the machine's clock is ahead [s]. Returns by how much it was set, if it
    /// was.
    pub(crate) fn set_ahead(&mut self, ahead: f64) -> Option<f64> {
        let step = ahead - self.ahead;
        if step == 0.0 {
            return None;
        }
        self.ahead = ahead;
        for source in self.table.values_mut() {
            source.offset.follow(step);
        }
        Some(step)
    }

    fn entry(&mut self, key: &SourceKey, now: f64) -> &mut Source {
        let is_known = self.table.contains_key(key) || self.table.len() < MOST;
        let key = if is_known {
            key.clone()
        } else {
            (key.0, OTHERS.to_owned())
        };
        let ahead = self.ahead;
        self.table.entry(key).or_insert_with(|| Source {
            heard: now,
            said: None,
            period: Period::default(),
            offset: Offset::new(ahead),
            told: false,
            told_late: false,
        })
    }

    /// Maps the timestamp `stamp` [s] of a message that arrived at `received` [s], both since 1970.
    /// None if it is in the future or too old, and no other messages confirm it.
    pub(crate) fn map(
        &mut self,
        key: &SourceKey,
        stamp: f64,
        received: f64,
    ) -> Option<MappedStamp> {
        // The time at which it was heard is noted once the message is accepted.
        let source = self.entry(key, f64::NEG_INFINITY);
        let stepped = match source.offset.judge(stamp, received) {
            StampJudgement::Fits => None,
            StampJudgement::Stepped(by) => Some(ClockStep {
                by,
                is_first: false,
            }),
            StampJudgement::Off(by) => Some(ClockStep { by, is_first: true }),
            StampJudgement::Wild => return None,
        };
        Some(MappedStamp {
            shift: source.offset.shift(),
            stepped,
        })
    }

    /// What is subtracted from the node's time for a timestamp by the clock of `key` [s].
    pub(crate) fn shift(&self, key: &SourceKey) -> f64 {
        let source = self.table.get(key);
        source.map_or(-self.ahead, |source| source.offset.shift())
    }

    /// Notes that a source was heard at `time` [s]. `says` is the state that it reported, as a
    /// number; none for an answer. It repeats itself if it reports the same state again; a source
    /// that only reports changes has no period.
    pub(crate) fn hear(&mut self, key: &SourceKey, time: f64, says: Option<f64>) {
        let source = self.entry(key, time);
        source.heard = source.heard.max(time);
        let Some(value) = says else {
            return;
        };
        if let Some((before, last)) = source.said.filter(|(before, _)| *before <= time) {
            let same = (value - last).abs() <= SAME + SAME_SHARE * value.abs().max(last.abs());
            source.period.note(time - before, same);
        }
        source.said = Some((time, value));
    }

    /// Silence after which a source is overdue [s].
    fn limit(&self, kind: SourceKind, source: &Source) -> f64 {
        let set = match kind {
            SourceKind::Belt => self.timeouts.belt,
            SourceKind::Robot => self.timeouts.robot,
            SourceKind::Camera => None,
        };
        let least = match kind {
            SourceKind::Camera => LEAST_OF_CAMERA,
            SourceKind::Belt | SourceKind::Robot => LEAST,
        };
        let learned = || source.period.get().map(|p| (PERIODS * p).max(least));
        match set {
            Some(0.0) => f64::INFINITY,
            Some(set) => source.heard + set,
            None => learned().map_or(f64::INFINITY, |silence| source.heard + silence),
        }
    }

    /// When the belt will be overdue if it stays silent [s].
    pub(crate) fn belt_until(&self) -> f64 {
        let belts = self.table.iter();
        let belts = belts.filter(|((kind, _), _)| *kind == SourceKind::Belt);
        let limits = belts.map(|(_, source)| self.limit(SourceKind::Belt, source));
        limits.reduce(f64::max).unwrap_or(f64::INFINITY)
    }

    /// When a robot will be overdue if it stays silent [s].
    pub(crate) fn robot_until(&self, key: &SourceKey) -> f64 {
        let source = self.table.get(key);
        source.map_or(f64::INFINITY, |source| {
            self.limit(SourceKind::Robot, source)
        })
    }

    /// Smallest time from the timestamps of pictures to their arrival [s]; none if it is unknown or
    /// there is more than one camera.
    pub(crate) fn camera_offset(&self) -> Option<f64> {
        let cameras = self.table.iter();
        let mut cameras = cameras.filter(|((kind, _), _)| *kind == SourceKind::Camera);
        let (_, camera) = cameras.next()?;
        let is_alone = cameras.next().is_none() && self.has_offsets;
        camera.offset.delay().filter(|_| is_alone)
    }

    /// The remarks due at `now` [s]: sources that are overdue, and sources heard again.
    pub(crate) fn remarks(&mut self, now: f64) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut table = std::mem::take(&mut self.table);
        for ((kind, name), source) in &mut table {
            let named = format!("{} `{}`", kind.name(), pickline::error::shown(name));
            let delay = source.offset.settled_delay().unwrap_or(0.0);
            let is_late = self.has_offsets && delay > LATE;
            if is_late && !source.told_late {
                let delay = pickline::error::rounded(delay, 2);
                remarks.push(format!(
                    "{named}: its messages come at least {delay} s after their timestamps: its \
                     clock is behind, or it is slow; the timestamps are accepted, because the two \
                     look the same\n  set its clock by NTP or PTP, and check how long it takes"
                ));
            }
            source.told_late |= is_late;
            let overdue = now > self.limit(*kind, source);
            // Later silences of a camera over an empty belt are not reported.
            if overdue == source.told || (*kind == SourceKind::Camera && source.told) {
                continue;
            }
            source.told = overdue;
            if !overdue {
                remarks.push(format!("{named} is heard again"));
                continue;
            }
            let silence = pickline::error::rounded(now - source.heard, 2);
            let usual = source.period.get().map_or(String::new(), |period| {
                format!(
                    " (it usually sends every {} s)",
                    pickline::error::rounded(period, 2)
                )
            });
            let sets = |setting: RemarkSetting| {
                format!("{setting} S sets how long it may be silent, 0 for ever")
            };
            let what = match kind {
                SourceKind::Belt => format!(
                    "no task is given until it is heard\n  check that the belt reports; {}",
                    sets(RemarkSetting::BeltTimeout)
                ),
                SourceKind::Robot => format!(
                    "it gets no task until it is heard\n  check that it reports; {}",
                    sets(RemarkSetting::RobotTimeout)
                ),
                SourceKind::Camera => "normal if no items pass it".to_owned(),
            };
            remarks.push(format!(
                "{named} has been silent for {silence} s{usual}: {what}"
            ));
        }
        self.table = table;
        remarks
    }

    /// The `sources` of a status at `now` [s].
    pub(crate) fn report(&self, now: f64) -> Vec<SourceReport> {
        let heard = self.table.iter();
        let heard = heard.filter(|(_, source)| source.heard > f64::NEG_INFINITY);
        let report = |((kind, name), source): (&SourceKey, &Source)| {
            let delay = source.offset.delay().filter(|_| self.has_offsets);
            let mapped = source.offset.shift() + self.ahead;
            SourceReport {
                name: name.clone(),
                kind: *kind,
                age: (now - source.heard).max(0.0),
                period: source.period.get(),
                offset: delay.map(|delay| delay + mapped),
                mapped: Some(mapped).filter(|by| self.has_offsets && *by != 0.0),
                overdue: now > self.limit(*kind, source),
            }
        };
        heard.map(report).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(kind: SourceKind) -> SourceKey {
        (kind, "x".to_owned())
    }

    #[test]
    fn a_periodic_source_is_overdue_after_ten_periods() {
        let mut sources = Sources::new(Timeouts::default(), true);
        let belt = key(SourceKind::Belt);
        for i in 0..100 {
            sources.hear(&belt, 0.05 * f64::from(i), Some(0.3));
        }
        let report = &sources.report(5.0)[0];
        assert!((report.period.unwrap() - 0.05).abs() < 1e-9 && !report.overdue);
        assert!((report.age - 0.05).abs() < 1e-9);
        let until = sources.belt_until();
        assert!((until - 5.95).abs() < 1e-9, "{until}");
        assert!(sources.remarks(until).is_empty());
        let remarks = sources.remarks(6.2);
        assert!(remarks[0].contains("silent for 1.2 s (it usually sends every 0.05 s)"));
        assert!(sources.remarks(7.0).is_empty() && sources.report(7.0)[0].overdue);
        sources.hear(&belt, 20.0, Some(0.3));
        assert_eq!(sources.remarks(20.0), ["belt `x` is heard again"]);
    }

    #[test]
    fn a_source_that_reports_changes_only_may_be_silent() {
        let mut sources = Sources::new(Timeouts::default(), true);
        for i in 0..100 {
            sources.hear(
                &key(SourceKind::Robot),
                0.5 * f64::from(i),
                Some(f64::from(i % 2)),
            );
        }
        let robot = key(SourceKind::Robot);
        assert_eq!(sources.robot_until(&robot), f64::INFINITY);
        let timeouts = Timeouts {
            belt: Some(0.0),
            robot: Some(3.0),
        };
        let mut sources = Sources::new(timeouts, true);
        sources.hear(&key(SourceKind::Robot), 7.0, None);
        assert_eq!(sources.robot_until(&robot), 10.0);
        for i in 0..100 {
            sources.hear(&key(SourceKind::Belt), 0.05 * f64::from(i), Some(0.3));
        }
        assert_eq!(sources.belt_until(), f64::INFINITY);
    }

    #[test]
    fn names_from_peers_do_not_fill_memory() {
        let mut sources = Sources::new(Timeouts::default(), true);
        for i in 0..1000 {
            let key = (SourceKind::Camera, format!("c{i}"));
            sources.map(&key, 5.0, 5.0);
            sources.hear(&key, 5.0, Some(0.0));
        }
        assert!(sources.report(5.0).len() <= MOST + 1);
    }
}
