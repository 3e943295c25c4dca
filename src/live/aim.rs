//! How far from where it was sent each robot finds its items, and what that tells.
//!
//! A camera that stamps its pictures late, or whose place is not what it is thought to be,
//! moves all items alike, and every grasp goes beside them. Nothing in the stream of messages
//! shows it but what the robots find.
//!
//! Invariant: what is remembered is of the last [`KEPT`] results.

use super::protocol::Verdict;
use crate::error::{rounded, shown};
use std::collections::{BTreeMap, VecDeque};

/// Results that are remembered.
const KEPT: usize = 48;
/// From so few on they tell something.
const ENOUGH: usize = 8;
/// Offsets up to this [m] are how robots are.
const LEAST: f64 = 3e-3;
/// A mean is no chance beyond so many of its standard errors.
const ERRORS: f64 = 4.0;
/// Speeds that differ by more than this share tell a delay from a place.
const SPREAD: f64 = 0.1;
/// It is told again when it has changed by this share.
const CHANGED: f64 = 0.25;
/// Of the last results without a place so many found nothing, all but one.
const RUN: usize = 10;

/// What a robot has found.
#[derive(Debug, Clone, Copy)]
struct Found {
    robot: usize,
    /// From where it was sent to where it found the item, along and across [m].
    off: (f64, f64),
    /// Speed of the belt [m/s].
    speed: f64,
}

/// What was found lately.
#[derive(Debug, Clone, Default)]
pub struct Aim {
    found: VecDeque<Found>,
    /// Whether each of the last grasps found nothing; those that say where are not among them.
    missed: VecDeque<bool>,
    /// What was told of last [m].
    told: Option<(f64, f64)>,
    has_told_of_run: bool,
}

/// Mean of some values, and its standard error.
fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares = values.map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (squares / (count - 1.0).max(1.0) / count).sqrt())
}

/// Whether a mean is more than chance and than what robots bear.
fn is_systematic((mean, error): (f64, f64)) -> bool {
    mean.abs() > LEAST.max(ERRORS * error)
}

fn millimetres(off: f64) -> String {
    format!("{} mm", rounded(1e3 * off.abs(), 3))
}

impl Aim {
    /// `robot` has found its item `off` [m] from where it was sent, with the belt at `speed`
    /// [m/s].
    pub fn find(&mut self, robot: usize, off: (f64, f64), speed: f64) {
        if self.found.len() == KEPT {
            self.found.pop_front();
        }
        self.found.push_back(Found { robot, off, speed });
    }

    /// A robot has said what came of a task, and not where the item was.
    pub fn conclude(&mut self, verdict: Verdict) {
        let missed = match verdict {
            Verdict::Missed => true,
            Verdict::Picked | Verdict::GraspFail => false,
            Verdict::Rejected | Verdict::Cancelled => return,
        };
        if self.missed.len() == RUN {
            self.missed.pop_front();
        }
        self.missed.push_back(missed);
        let misses = self.missed.iter().filter(|missed| **missed).count();
        self.has_told_of_run &= 2 * misses > self.missed.len();
    }

    /// What the results show, if it is news. Pictures are taken to be stamped `delay` [s] late
    /// already; `camera` says when the pictures come; the belt moves at `speed` [m/s].
    pub fn remark(
        &mut self,
        delay: f64,
        camera: Option<f64>,
        speed: f64,
        names: &[&str],
    ) -> Option<String> {
        self.offset(delay, names)
            .or_else(|| self.run(delay, camera, speed))
    }

    fn offset(&mut self, delay: f64, names: &[&str]) -> Option<String> {
        if self.found.len() < ENOUGH {
            return None;
        }
        let along = mean(self.found.iter().map(|found| found.off.0));
        let across = mean(self.found.iter().map(|found| found.off.1));
        if !is_systematic(along) && !is_systematic(across) {
            self.told = None;
            return None;
        }
        let off = (along.0, across.0);
        let is_same = |told: (f64, f64)| {
            (told.0 - off.0).hypot(told.1 - off.1) <= CHANGED * told.0.hypot(told.1)
        };
        if self.told.is_some_and(is_same) {
            return None;
        }
        self.told = Some(off);
        let count = self.found.len();
        let mut text = format!("of the last {count} items that robots found,");
        if let Some(robot) = self.odd_one() {
            let name = names.get(robot).copied().unwrap_or_default();
            text += &format!(
                " those of robot `{}` alone were beside where they were sent: {}\n  its base and \
                 its own frame are to be measured again",
                shown(name),
                offsets(off)
            );
            return Some(text);
        }
        text += &format!(" on average {} from where they were sent", offsets(off));
        if is_systematic(along) {
            text += &format!("\n  {}", self.cause(off.0, delay));
        }
        if is_systematic(across) {
            text += &format!(
                "\n  {} across the belt: the camera's y, or the robots' frames, are off by that",
                millimetres(off.1)
            );
        }
        Some(text)
    }

    /// What shifts items along the belt by `off` [m], most likely.
    fn cause(&self, off: f64, delay: f64) -> String {
        let speeds = self.found.iter().map(|found| found.speed);
        let count = self.found.len() as f64;
        let mean_speed = speeds.clone().sum::<f64>() / count;
        let variance = speeds
            .clone()
            .map(|v| (v - mean_speed).powi(2))
            .sum::<f64>();
        let squares = speeds.map(|v| v * v).sum::<f64>();
        if squares == 0.0 {
            return format!(
                "the belt stood, so the camera's x is off by {}",
                millimetres(off)
            );
        }
        // Least squares: through 0, or with a constant where the speeds tell the two apart.
        let tells = (variance / count).sqrt() > SPREAD * mean_speed.abs();
        let found = self.found.iter();
        let (late, place) = if tells {
            let products = found.map(|f| (f.speed - mean_speed) * (f.off.0 - off));
            let late = products.sum::<f64>() / variance;
            (late, off - late * mean_speed)
        } else {
            let products = found.map(|f| f.speed * f.off.0);
            (products.sum::<f64>() / squares, 0.0)
        };
        let (way, ms) = (if late < 0.0 { "early" } else { "late" }, 1e3 * late);
        let flag = format!("--camera-delay {:.0}", 1e3 * delay + ms);
        let ms = format!("{:.0} ms", ms.abs());
        let stamped = format!("as if pictures were stamped {ms} {way}: {flag} cures that");
        match tells {
            false => format!(
                "{stamped}, unless the camera's x is off by {}; other belt speeds would tell",
                millimetres(off)
            ),
            true if place.abs() > 2.0 * LEAST => format!(
                "{stamped}; and the camera's x is off by {}",
                millimetres(place)
            ),
            true => stamped,
        }
    }

    /// The one robot whose items are beside where it was sent, if those of the others are not.
    fn odd_one(&self) -> Option<usize> {
        let means = |is_its: &dyn Fn(usize) -> bool| {
            let of = |side: fn(&Found) -> f64| {
                let its = self.found.iter().filter(|found| is_its(found.robot));
                mean(its.map(side).collect::<Vec<_>>().into_iter())
            };
            [of(|found| found.off.0), of(|found| found.off.1)]
        };
        let mut counts = BTreeMap::new();
        for found in &self.found {
            *counts.entry(found.robot).or_insert(0) += 1;
        }
        let is_odd = |robot: usize| {
            let (its, others) = (means(&|r| r == robot), means(&|r| r != robot));
            let differs = its.iter().zip(&others).any(|(one, other)| {
                is_systematic((one.0 - other.0, one.1.hypot(other.1))) && is_systematic(*one)
            });
            differs && !others.iter().any(|other| is_systematic(*other))
        };
        let count = self.found.len();
        let mut robots = counts.into_iter().filter(|(robot, its)| {
            *its >= ENOUGH / 2 && count - its >= ENOUGH / 2 && is_odd(*robot)
        });
        robots.next().map(|(robot, _)| robot)
    }

    fn run(&mut self, delay: f64, camera: Option<f64>, speed: f64) -> Option<String> {
        let missed = self.missed.iter().filter(|missed| **missed).count();
        if self.has_told_of_run || self.missed.len() < RUN || missed + 1 < RUN {
            return None;
        }
        self.has_told_of_run = true;
        let way = rounded(0.1 * speed.abs() * 1e3, 3);
        let delay = rounded(1e3 * delay, 4);
        let comes = camera.map_or(String::new(), |offset| {
            let ms = rounded(1e3 * offset, 2);
            format!(
                " Pictures come {ms} ms after their stamps: if taking and reading one needs \
                 longer, they are stamped too late by the rest."
            )
        });
        Some(format!(
            "{missed} of the last {RUN} grasps found nothing: items are not where they are thought \
             to be\n  most likely pictures are stamped late: 100 ms are {way} mm at this speed, and \
             --camera-delay MS, now {delay}, takes them off.{comes}\n  `found {{x, y}}` in \
             results tells how many; or look at the camera's place and the belt's speed"
        ))
    }
}

fn offsets((along, across): (f64, f64)) -> String {
    let side = |off: f64, plus: &str, minus: &str| {
        format!(
            "{} {}",
            millimetres(off),
            if off < 0.0 { minus } else { plus }
        )
    };
    format!(
        "{} and {}",
        side(along, "downstream", "upstream"),
        side(across, "towards +y", "towards -y")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 2] = ["a", "b"];

    fn told(finds: impl IntoIterator<Item = (usize, f64, f64, f64)>) -> Vec<String> {
        let mut aim = Aim::default();
        let finds = finds.into_iter().filter_map(|(robot, x, y, speed)| {
            aim.find(robot, (x, y), speed);
            aim.remark(0.02, None, speed, &NAMES)
        });
        finds.collect()
    }

    fn jitter(i: usize) -> f64 {
        0.002 * ((i * 37 % 11) as f64 / 5.0 - 1.0)
    }

    #[test]
    fn a_late_stamp_is_told_of_with_what_cures_it() {
        let remarks = told((0..100).map(|i| (i % 2, 0.045 + jitter(i), jitter(i + 3), 0.3)));
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        let cure = remarks[0].contains("stamped 149 ms late: --camera-delay 169 cures");
        assert!(cure && remarks[0].contains("mm downstream"), "{remarks:?}");
        assert!(remarks[0].contains("unless the camera's x is off by 44.8 mm"));
        let remarks = told((0..100).map(|i| (i % 2, -0.03 + jitter(i), 0.0, 0.3)));
        assert!(
            remarks[0].contains("101 ms early: --camera-delay -81"),
            "{remarks:?}"
        );
    }

    #[test]
    fn speeds_tell_a_delay_from_a_place() {
        let speed = |i: usize| 0.1 + 0.1 * (i % 3) as f64;
        let late = |place: f64| {
            let finds = (0..24).map(|i| (i % 2, place + 0.2 * speed(i) + jitter(i), 0.0, speed(i)));
            told(finds).pop().unwrap()
        };
        assert!(late(0.0).contains("stamped 2"), "{}", late(0.0));
        assert!(!late(0.0).contains("camera's x"));
        assert!(
            late(0.03).contains("and the camera's x is off by"),
            "{}",
            late(0.03)
        );
    }

    #[test]
    fn one_robot_alone_is_named_and_chance_is_not() {
        let remarks = told((0..40).map(|i| (i % 2, 0.02 * (i % 2) as f64 + jitter(i), 0.0, 0.3)));
        let last = remarks.last().unwrap();
        assert!(last.contains("robot `b` alone"), "{remarks:?}");
        let remarks = told((0..100).map(|i| (i % 2, 4.0 * jitter(i), 3.0 * jitter(i + 1), 0.3)));
        assert!(remarks.is_empty(), "{remarks:?}");
    }

    #[test]
    fn a_run_of_misses_is_told_of_once() {
        let mut aim = Aim::default();
        let mut remarks = Vec::new();
        for _ in 0..225 {
            aim.conclude(Verdict::Missed);
            remarks.extend(aim.remark(0.0, Some(0.004), 0.3, &NAMES));
        }
        assert_eq!(remarks.len(), 1);
        assert!(remarks[0].contains("--camera-delay") && remarks[0].contains("30 mm"));
        assert!(remarks[0].contains("come 4 ms after"), "{remarks:?}");
        // Again after it was better.
        for _ in 0..RUN / 2 {
            aim.conclude(Verdict::Picked);
        }
        assert_eq!(aim.remark(0.0, None, 0.3, &NAMES), None);
        for _ in 0..RUN {
            aim.conclude(Verdict::Missed);
        }
        assert!(aim.remark(0.0, None, 0.3, &NAMES).is_some());
    }
}
