//! What the rest of a line can still do with a pattern, however it decides.
//!
//! A relaxation that costs a fraction of a robot's pass. Each robot may take any item that is left and
//! that it has a window for, at any time between its first opening and its last closing, each in the least
//! time that the pick can take. Robots do not compete, but no item counts twice.

use crate::decision::{Candidate, Figures};
use crate::kinematics::{distance, meeting_range};
use crate::sim::{LineState, Scene};
use crate::station::{Robot, Station};

/// Share by which times are taken as shorter, and sums of rewards as larger, than computed: far more than
/// rounding can make of them.
const ROUNDING: f64 = 1e-9;

/// The ceilings of one scene, for every number of robots that have already passed.
pub(super) struct Ceilings {
    /// Of every robot, what its picks cost.
    robots: Vec<RobotWork>,
    /// For each number of robots that have passed, when the remaining ones can have released each item at
    /// the earliest [s]; infinite if none has a window for it.
    earliest: Vec<Vec<f64>>,
    /// When each item leaves the belt [s].
    leaves: Vec<f64>,
}

/// What the items cost one robot.
struct RobotWork {
    /// The items that it has windows for, those with the shortest picks first.
    shortest: Vec<Work>,
    /// The same, those with the most reward per second first; empty if rewards do not count.
    richest: Vec<Work>,
    /// From its first opening to its last closing [s].
    horizon: f64,
}

/// The pick of one item by one robot.
#[derive(Clone)]
struct Work {
    item: u32,
    /// Least time of the pick [s].
    least: f64,
    /// Reward of the item.
    weight: f64,
}

impl Ceilings {
    /// The ceilings of `scene`; with `rewards`, of the sum of rewards, too.
    pub(super) fn new(scene: &Scene, rewards: bool) -> Self {
        let count = scene.pattern().len();
        let station = scene.station();
        let robots = station.robots();
        let mut earliest = vec![vec![f64::INFINITY; count]; robots.len() + 1];
        let mut work = Vec::with_capacity(robots.len());
        for (index, robot) in robots.iter().enumerate().rev() {
            earliest[index] = earliest[index + 1].clone();
            let queue = scene.queue(index);
            let mut items = Vec::with_capacity(queue.len());
            for candidate in queue {
                let least = least_processing_time(station, robot, candidate);
                let first = &mut earliest[index][candidate.item as usize];
                *first = first.min((1.0 - ROUNDING) * (candidate.open + least));
                items.push(Work {
                    item: candidate.item,
                    least,
                    weight: candidate.weight,
                });
            }
            items.sort_by(|a, b| a.least.total_cmp(&b.least).then(a.item.cmp(&b.item)));
            let opens = queue.iter().map(|c| c.open).fold(f64::INFINITY, f64::min);
            let closes = queue.iter().map(|c| c.close).fold(0.0, f64::max);
            let horizon = (closes - opens).max(0.0) * (1.0 + ROUNDING);
            let mut richest = if rewards { items.clone() } else { Vec::new() };
            richest.sort_by(|a, b| {
                b.density()
                    .total_cmp(&a.density())
                    .then(a.item.cmp(&b.item))
            });
            work.push(RobotWork {
                shortest: items,
                richest,
                horizon,
            });
        }
        work.reverse();
        Self {
            robots: work,
            earliest,
            leaves: (0..count).map(|item| scene.leaves_belt(item)).collect(),
        }
    }

    /// Figures that no run exceeds in which the first `passed` robots did `line`: as many picks and as
    /// much reward, and an end as early. `None` if the remaining robots can reach nothing that is left, so
    /// that the figures are those of `line`.
    pub(super) fn figures(&self, passed: usize, line: &LineState, items: usize) -> Option<Figures> {
        let earliest = &self.earliest[passed];
        let left = || {
            (0..earliest.len())
                .rev()
                .filter(|&item| line.leaves(item as u32))
        };
        let (mut picks, mut weight) = (0, 0.0);
        for robot in &self.robots[passed..] {
            picks += robot.most_picks(line);
            weight += robot.most_reward(line);
        }
        if picks == 0 {
            return None;
        }
        let reachable = left().filter(|&item| earliest[item].is_finite()).count();
        picks = picks.min(reachable);
        // The last items to leave the belt are the ones whose picks let the run end sooner.
        let mut spare = picks;
        let mut end = line.last_release;
        for item in left() {
            if earliest[item].is_finite() && spare > 0 {
                spare -= 1;
                end = end.max(earliest[item].min(self.leaves[item]));
            } else {
                end = end.max(self.leaves[item]);
                break;
            }
        }
        Some(Figures {
            items,
            picked: line.picked + picks,
            weight: (line.weight + weight) * (1.0 + ROUNDING),
            end,
        })
    }
}

impl Ceilings {
    /// When a run ends at the earliest [s] in which the first `passed` robots did `line`.
    pub(super) fn least_end(&self, passed: usize, line: &LineState) -> f64 {
        let items = self.earliest[passed].iter().zip(&self.leaves).enumerate();
        let left = items.filter(|(item, _)| line.leaves(*item as u32));
        left.map(|(_, (earliest, leaves))| earliest.min(*leaves))
            .fold(line.last_release, f64::max)
    }
}

impl Work {
    /// Reward per second of the pick.
    fn density(&self) -> f64 {
        if self.least > 0.0 {
            self.weight / self.least
        } else {
            f64::INFINITY
        }
    }
}

impl RobotWork {
    /// At most this many of the items that are left.
    fn most_picks(&self, line: &LineState) -> usize {
        // Every pick but the last is over before the last departure.
        let (mut spent, mut picks) = (0.0, 0);
        for work in &self.shortest {
            if line.leaves(work.item) {
                if spent > self.horizon {
                    break;
                }
                spent += work.least;
                picks += 1;
            }
        }
        picks
    }

    /// At most this sum of rewards: of what fits by reward per second, and of the last pick.
    fn most_reward(&self, line: &LineState) -> f64 {
        let (mut spent, mut reward, mut last) = (0.0, 0.0, 0.0f64);
        for work in &self.richest {
            if line.leaves(work.item) {
                last = last.max(work.weight);
                if spent <= self.horizon {
                    spent += work.least;
                    reward += work.weight;
                }
            }
        }
        reward + last
    }
}

/// A time [s] that no pick of `candidate` by `robot` is below, from any of the robot's places at any
/// departure: the way to and from the nearest point of the item's track in the workspace.
fn least_processing_time(station: &Station, robot: &Robot, candidate: &Candidate) -> f64 {
    let belt = station.belt();
    let base = robot.base;
    let range = meeting_range(base.x, base.y, robot.reach, candidate.y, belt.length);
    let (from, to) = range.unwrap_or((0.0, belt.length));
    // An item that is met where the windows were rounded is met within this of the workspace.
    let slack = ROUNDING * (1.0 + robot.reach);
    let nearest = |x: f64, y: f64| {
        let off = (from - slack - x).max(x - to - slack).max(0.0);
        distance(off, candidate.y - y)
    };
    let bin = &robot.bins[usize::from(candidate.bin)];
    let back = robot.arm.time(nearest(bin.at.x, bin.at.y));
    let places = (0..robot.places()).map(|index| robot.place(index));
    let out = places
        .map(|at| robot.arm.time(nearest(at.x, at.y)))
        .fold(f64::INFINITY, f64::min);
    (1.0 - ROUNDING) * (out + robot.grasp_time + back + bin.release_time)
}
