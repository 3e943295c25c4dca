//! How far from the expected position each robot finds its items, and what that shows.
//!
//! If a camera's timestamps are late, or its position is not the configured one, all items are
//! shifted alike and every grasp misses. Only the robots' results show this.
//!
//! Invariant: only the last [`KEPT`] results are kept.

use super::protocol::Verdict;
use crate::RemarkSetting;
use pickline::error::{rounded, shown};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Number of results that are kept.
const KEPT: usize = 48;
/// Fewer results than this show nothing.
const ENOUGH: usize = 8;
/// Offsets up to this [m] are normal for a robot.
const LEAST: f64 = 3e-3;
/// A mean beyond this many of its standard errors is not chance.
const ERRORS: f64 = 4.0;
/// If the speeds vary by more than this share, a delay can be told from a wrong position.
const SPREAD: f64 = 0.1;
/// A finding is reported again once it has changed by this share.
const CHANGED: f64 = 0.25;
/// Length of a run of results without `found` of which all but one are `MISSED`, or none is
/// `PICKED`.
const RUN: usize = 10;

/// One `found` of a robot.
#[derive(Debug, Clone, Copy)]
struct FoundOffset {
    robot: usize,
    /// From the place where it was sent to the place where it found the item, along and across [m].
    off: (f64, f64),
    /// Speed of the belt when the picture was taken [m/s].
    speed: f64,
}

/// The last grasps of one robot, or of all, that do not report where the item was.
#[derive(Debug, Clone, Default)]
struct Grasps {
    /// Number and result of each grasp.
    last: VecDeque<(u64, Verdict)>,
    has_told: bool,
}

impl Grasps {
    fn conclude(&mut self, number: u64, verdict: Verdict) {
        if self.last.len() == RUN {
            self.last.pop_front();
        }
        self.last.push_back((number, verdict));
        let failed = self.last.len() - self.count(Verdict::Picked);
        self.has_told &= 2 * failed > self.last.len();
    }

    fn count(&self, verdict: Verdict) -> usize {
        self.last.iter().filter(|last| last.1 == verdict).count()
    }

    /// Reports that nearly all grasps found nothing or that all failed, unless already reported.
    fn run(&self) -> Option<String> {
        if self.has_told || self.last.len() < RUN {
            return None;
        }
        let missed = self.count(Verdict::Missed);
        if missed + 1 >= RUN {
            return Some(format!("{missed} of the last {RUN} grasps found nothing"));
        }
        let failed = self.count(Verdict::GraspFail);
        (missed + failed == RUN).then(|| {
            format!(
                "none of the last {RUN} grasps picked its item ({failed} GRASP_FAIL, {missed} MISSED)"
            )
        })
    }
}

/// The recent results of all robots.
#[derive(Debug, Clone, Default)]
pub(crate) struct Aim {
    found: VecDeque<FoundOffset>,
    /// The last grasps of all robots, and of each.
    grasps: Grasps,
    by_robot: BTreeMap<usize, Grasps>,
    /// Number of grasps so far.
    number: u64,
    /// The offset reported last [m], and its robot if it was a single one.
    told: Option<(Option<usize>, (f64, f64))>,
    /// Robots that have reported an impossible `found`.
    elsewhere: BTreeSet<usize>,
}

/// Mean of the values, and its standard error.
fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares = values.map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (squares / (count - 1.0).max(1.0) / count).sqrt())
}

/// Whether a mean is larger than chance and than what is normal for a robot.
fn is_systematic((mean, error): (f64, f64)) -> bool {
    mean.abs() > LEAST.max(ERRORS * error)
}

fn millimetres(off: f64) -> String {
    format!("{} mm", rounded(1e3 * off.abs(), 3))
}

impl Aim {
    /// `robot` has found its item `off` [m] from where it was sent; the belt moved at `speed` [m/s]
    /// when the picture was taken.
    pub(crate) fn find(&mut self, robot: usize, off: (f64, f64), speed: f64) {
        if self.found.len() == KEPT {
            self.found.pop_front();
        }
        self.found.push_back(FoundOffset { robot, off, speed });
    }

    /// Notes an impossible `found` of `robot`. Returns whether it is its first.
    pub(crate) fn find_elsewhere(&mut self, robot: usize) -> bool {
        self.elsewhere.insert(robot)
    }

    /// `robot` has reported a result without `found`.
    pub(crate) fn conclude(&mut self, robot: usize, verdict: Verdict) {
        if matches!(verdict, Verdict::Rejected | Verdict::Cancelled) {
            return;
        }
        self.number += 1;
        self.grasps.conclude(self.number, verdict);
        let its = self.by_robot.entry(robot).or_default();
        its.conclude(self.number, verdict);
    }

    /// What the results show, if it is new. `delay` [s] is already subtracted from the timestamps
    /// of pictures; `camera` is the time from a picture's timestamp to its arrival [s]; the belt
    /// moved at `speed` [m/s] last.
    pub(crate) fn remark(
        &mut self,
        delay: f64,
        camera: Option<f64>,
        speed: f64,
        names: &[&str],
    ) -> Option<String> {
        self.offset(delay, names)
            .or_else(|| self.run_of_one(names))
            .or_else(|| self.run(delay, camera, speed))
    }

    fn offset(&mut self, delay: f64, names: &[&str]) -> Option<String> {
        if self.found.len() < ENOUGH {
            return None;
        }
        let along = mean(self.found.iter().map(|found| found.off.0));
        let across = mean(self.found.iter().map(|found| found.off.1));
        let is_shifted = is_systematic(along) || is_systematic(across);
        // If the mean of all robots shows nothing, a single robot needs more results as evidence.
        let odd = self.odd_one(if is_shifted { ENOUGH / 2 } else { ENOUGH });
        if !is_shifted && odd.is_none() {
            self.told = None;
            return None;
        }
        let off = odd.map_or((along.0, across.0), |(_, off)| off);
        let odd = odd.map(|(robot, _)| robot);
        let is_same = |(robot, told): (Option<usize>, (f64, f64))| {
            robot == odd && (told.0 - off.0).hypot(told.1 - off.1) <= CHANGED * told.0.hypot(told.1)
        };
        if self.told.is_some_and(is_same) {
            return None;
        }
        self.told = Some((odd, off));
        let count = self.found.len();
        let mut text = format!("of the last {count} items that robots found,");
        if let Some(robot) = odd {
            let name = names.get(robot).copied().unwrap_or_default();
            text += &format!(
                " only those of robot `{}` were off: on average {} from where it was sent\n  \
                 measure its base and its own frame again",
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
                "\n  {} across the belt: the camera's y or the robots' frames are off by that much",
                millimetres(off.1)
            );
        }
        Some(text)
    }

    /// The most likely cause of a shift of items along the belt by `off` [m].
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
                "the belt was stationary, so the camera's x is off by {}",
                millimetres(off)
            );
        }
        // Least squares: through 0, or with a constant if the speeds vary enough to separate the
        // two.
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
        let setting = format!("{} {:.0}", RemarkSetting::CameraDelay, 1e3 * delay + ms);
        let ms = format!("{:.0} ms", ms.abs());
        let stamped =
            format!("as if timestamps of pictures were {ms} {way}: {setting} corrects that");
        match tells {
            false => format!(
                "{stamped}, unless the camera's x is off by {}; results at another belt speed \
                 would show which",
                millimetres(off)
            ),
            true if place.abs() > 2.0 * LEAST => format!(
                "{stamped}; and the camera's x is off by {}",
                millimetres(place)
            ),
            true => stamped,
        }
    }

    /// The one robot that finds its items off, if the others do not, and by how much [m]. It must
    /// have found at least `enough` items.
    fn odd_one(&self, enough: usize) -> Option<(usize, (f64, f64))> {
        let means = |is_its: &dyn Fn(usize) -> bool| {
            let of = |side: fn(&FoundOffset) -> f64| {
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
        let mut robots = counts
            .into_iter()
            .filter(|(robot, its)| *its >= enough && count - its >= ENOUGH / 2 && is_odd(*robot));
        let (robot, _) = robots.next()?;
        let [along, across] = means(&|r| r == robot);
        Some((robot, (along.0, across.0)))
    }

    /// A single robot that keeps failing while the others pick.
    fn run_of_one(&mut self, names: &[&str]) -> Option<String> {
        let (robot, what) = self.by_robot.iter().find_map(|(robot, its)| {
            let what = its.run()?;
            let since = its.last.front()?.0;
            let others = self.by_robot.iter().filter(|(other, _)| *other != robot);
            let others = others.flat_map(|(_, grasps)| &grasps.last);
            let others: Vec<_> = others.filter(|(number, _)| *number > since).collect();
            let picked = others.iter().filter(|last| last.1 == Verdict::Picked);
            let picks = others.len() >= RUN / 2 && 2 * picked.count() > others.len();
            picks.then_some((*robot, what))
        })?;
        self.by_robot.get_mut(&robot)?.has_told = true;
        let name = names.get(robot).copied().unwrap_or_default();
        Some(format!(
            "robot `{}`: {what}, while the other robots pick\n  check its gripper, and measure its \
             base and its own frame again",
            shown(name)
        ))
    }

    fn run(&mut self, delay: f64, camera: Option<f64>, speed: f64) -> Option<String> {
        let what = self.grasps.run()?;
        let since = self.grasps.last.front()?.0;
        // A robot that was already reported may account for nearly all of these.
        let is_known = self.by_robot.values().any(|its| {
            let recent = its.last.iter().filter(|last| last.0 >= since).count();
            its.has_told && recent + 1 >= RUN
        });
        if is_known {
            return None;
        }
        self.grasps.has_told = true;
        let gripper = if self.grasps.count(Verdict::Missed) + 1 >= RUN {
            ""
        } else {
            ", or the grippers do not hold items"
        };
        let way = rounded(0.1 * speed.abs() * 1e3, 3);
        let (setting, delay) = (RemarkSetting::CameraDelay, rounded(1e3 * delay, 4));
        let comes = camera.map_or(String::new(), |offset| {
            let ms = rounded(1e3 * offset, 2);
            format!(
                " Pictures come {ms} ms after their timestamps: if taking and processing one needs \
                 longer, the timestamps are late by the difference."
            )
        });
        Some(format!(
            "{what}: items are not where they are expected{gripper}\n  most likely the timestamps \
             of pictures are late: 100 ms correspond to {way} mm at this speed, and {setting} MS, now \
             {delay}, subtracts them.{comes}\n  `found {{x, y}}` in results would show how many; \
             also check the camera's position and the belt's speed"
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
    fn a_late_stamp_is_reported_with_its_cure() {
        let remarks = told((0..100).map(|i| (i % 2, 0.045 + jitter(i), jitter(i + 3), 0.3)));
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        let cure = remarks[0].contains("were 149 ms late: 'camera_delay' 169 corrects");
        assert!(cure && remarks[0].contains("mm downstream"), "{remarks:?}");
        assert!(remarks[0].contains("unless the camera's x is off by 44.8 mm"));
        let remarks = told((0..100).map(|i| (i % 2, -0.03 + jitter(i), 0.0, 0.3)));
        assert!(
            remarks[0].contains("101 ms early: 'camera_delay' -81"),
            "{remarks:?}"
        );
    }

    #[test]
    fn different_speeds_distinguish_a_delay_from_a_wrong_position() {
        let speed = |i: usize| 0.1 + 0.1 * (i % 3) as f64;
        let late = |place: f64| {
            let finds = (0..24).map(|i| (i % 2, place + 0.2 * speed(i) + jitter(i), 0.0, speed(i)));
            told(finds).pop().unwrap()
        };
        assert!(late(0.0).contains("were 2"), "{}", late(0.0));
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
        assert!(last.contains("only those of robot `b`"), "{remarks:?}");
        let remarks = told((0..100).map(|i| (i % 2, 4.0 * jitter(i), 3.0 * jitter(i + 1), 0.3)));
        assert!(remarks.is_empty(), "{remarks:?}");
    }

    #[test]
    fn the_odd_robot_is_told_of_with_its_own_offset() {
        for robots in [2, 4] {
            let off = |i: usize| if i % robots == 1 { 0.02 } else { 0.0 };
            let finds = (0..48).map(|i| (i % robots, off(i) + jitter(i), 0.0, 0.3));
            let last = told(finds).pop().unwrap();
            let is_its = last.contains("average 20") || last.contains("average 19");
            assert!(
                is_its && last.contains("only those of robot `b`"),
                "{robots}: {last}"
            );
        }
    }

    #[test]
    fn a_robot_that_fails_alone_is_named_and_not_the_camera() {
        for (verdict, said) in [
            (Verdict::Missed, "10 of the last 10 grasps found nothing"),
            (Verdict::GraspFail, "(10 GRASP_FAIL, 0 MISSED)"),
        ] {
            // Many robots between its tasks, and several of its results in a row.
            for of in [2, 8] {
                let (mut aim, mut remarks) = (Aim::default(), Vec::new());
                for i in 0..30 * of {
                    let its = i % of == 1 || i > 25 * of;
                    let what = if its { verdict } else { Verdict::Picked };
                    aim.conclude(if its { 1 } else { i % of }, what);
                    remarks.extend(aim.remark(0.0, None, 0.3, &NAMES));
                }
                assert_eq!(remarks.len(), 1, "{remarks:?}");
                assert!(remarks[0].starts_with("robot `b`: "), "{remarks:?}");
                assert!(remarks[0].contains(said), "{remarks:?}");
                assert!(!remarks[0].contains("camera"), "{remarks:?}");
            }
        }
    }

    #[test]
    fn grasps_that_all_fail_are_reported_with_both_causes() {
        let (mut aim, mut remarks) = (Aim::default(), Vec::new());
        for i in 0..40 {
            let failed = [Verdict::GraspFail, Verdict::Missed][usize::from(i % 5 == 0)];
            aim.conclude(i % 2, failed);
            remarks.extend(aim.remark(0.0, None, 0.3, &NAMES));
        }
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        let none = remarks[0].contains("none of the last 10 grasps");
        assert!(none && remarks[0].contains("'camera_delay'"), "{remarks:?}");
        assert!(remarks[0].contains("or the grippers"), "{remarks:?}");
        // One pick in ten: nothing is reported.
        let mut aim = Aim::default();
        for i in 0..100 {
            let verdict = [Verdict::GraspFail, Verdict::Picked][usize::from(i % 10 == 0)];
            aim.conclude(i % 2, verdict);
            assert_eq!(aim.remark(0.0, None, 0.3, &NAMES), None, "{i}");
        }
    }

    #[test]
    fn a_series_of_misses_is_reported_once() {
        let mut aim = Aim::default();
        let mut remarks = Vec::new();
        for _ in 0..225 {
            aim.conclude(0, Verdict::Missed);
            remarks.extend(aim.remark(0.0, Some(0.004), 0.3, &NAMES));
        }
        assert_eq!(remarks.len(), 1);
        assert!(remarks[0].contains("'camera_delay'") && remarks[0].contains("30 mm"));
        assert!(remarks[0].contains("come 4 ms after"), "{remarks:?}");
        // Reported again after an improvement.
        for _ in 0..RUN / 2 {
            aim.conclude(0, Verdict::Picked);
        }
        assert_eq!(aim.remark(0.0, None, 0.3, &NAMES), None);
        for _ in 0..RUN {
            aim.conclude(0, Verdict::Missed);
        }
        assert!(aim.remark(0.0, None, 0.3, &NAMES).is_some());
    }

    /// An offset that was cured is reported again when it returns.
    #[test]
    fn an_offset_that_returns_is_reported_again() {
        let off = |i: usize| if i / KEPT == 1 { 0.0 } else { 0.0037 };
        let remarks = told((0..3 * KEPT).map(|i| (i % 2, off(i), 0.0, 0.3)));
        assert_eq!(remarks.len(), 2, "{remarks:?}");
        assert!(
            remarks[0].contains("average 3.7 mm downstream"),
            "{remarks:?}"
        );
    }
}
