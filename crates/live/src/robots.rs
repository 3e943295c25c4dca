//! What is known of each robot.

use super::protocol::{RobotReport, Verdict};
use serde::{Deserialize, Serialize};

/// After so many tasks in a row that a robot has dropped it rests.
const MOST_DROPPED: u32 = 3;
/// Its first rest [s]; each further one is twice as long,
const FIRST_REST: f64 = 0.5;
/// up to this [s].
const LONGEST_REST: f64 = 10.0;

/// Whether a robot takes tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Service {
    /// Nothing was heard of it yet.
    Unknown,
    /// It takes tasks from `free_at` on.
    Ready,
    /// It is at work, for how long is not known.
    Working,
    /// It has reported a fault.
    Fault,
    /// It owes a result for too long. It gets no task until it is heard again.
    Silent,
}

/// Why a robot that could decide does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wait {
    /// It does not wait.
    No,
    /// Until the time that its strategy named.
    Until,
    /// Until the next window of an item opens.
    Window,
}

/// One robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotInfo {
    /// Whether it takes tasks.
    pub service: Service,
    /// When it can set out next [s]; infinite where that is not known.
    #[serde(with = "never")]
    pub free_at: f64,
    /// Why it does not decide before.
    pub wait: Wait,
    /// The task that it is at.
    pub task: Option<u64>,
    /// Its picks.
    pub picked: u64,
    /// Its grasps that failed.
    pub failed: u64,
    /// Its tasks for which it came too late or did not find the item.
    pub missed: u64,
    /// Tasks in a row that it has dropped of its own accord.
    pub dropped: u32,
    /// It gets no task before this time [s], because it drops them.
    pub rests_until: f64,
    /// Whether it has said, of a task that it is thought to be at, that it is idle. It may
    /// not have known of the task then; from `free_at` on it is believed.
    pub idle_said: bool,
    /// While it is out of service: only what it says with a newer stamp ends that [s].
    pub fault_at: Option<f64>,
    /// The newest time of which it has said how it is [s].
    pub said_at: Option<f64>,
    /// The newest time at which it has said, by a result or of itself, when it is free [s].
    pub told_at: Option<f64>,
}

impl Default for RobotInfo {
    fn default() -> Self {
        Self {
            service: Service::Unknown,
            free_at: f64::INFINITY,
            wait: Wait::No,
            task: None,
            picked: 0,
            failed: 0,
            missed: 0,
            dropped: 0,
            rests_until: 0.0,
            idle_said: false,
            fault_at: None,
            said_at: None,
            told_at: None,
        }
    }
}

impl RobotInfo {
    /// Whether it can be given a task, now or at a time that is known.
    pub fn is_ready(&self) -> bool {
        self.service == Service::Ready && (self.task.is_none() || self.idle_said)
    }

    /// When it can be given a task, at `now` [s] or later.
    pub fn available_from(&self, now: f64) -> f64 {
        self.free_at.max(self.rests_until).max(now)
    }

    /// A task ends with `verdict`, which it may have reported otherwise before.
    pub fn count(&mut self, before: Option<Verdict>, verdict: Verdict) {
        if let Some(count) = before.and_then(|verdict| self.counter(verdict)) {
            *count = count.saturating_sub(1);
        }
        if let Some(count) = self.counter(verdict) {
            *count += 1;
        }
    }

    fn counter(&mut self, verdict: Verdict) -> Option<&mut u64> {
        match verdict {
            Verdict::Picked => Some(&mut self.picked),
            Verdict::GraspFail => Some(&mut self.failed),
            Verdict::Missed => Some(&mut self.missed),
            Verdict::Rejected | Verdict::Cancelled => None,
        }
    }

    /// It has dropped a task of its own accord at `now` [s]. The third in a row, and each
    /// further one, costs it a pause; whether this is the third.
    pub fn drops_task(&mut self, now: f64) -> bool {
        self.dropped += 1;
        if self.dropped >= MOST_DROPPED {
            let further = (self.dropped - MOST_DROPPED).min(16);
            let pause = FIRST_REST * f64::from(2u32.pow(further));
            self.rests_until = now + pause.min(LONGEST_REST);
        }
        self.dropped == MOST_DROPPED
    }

    /// It is free from `time` [s] on.
    pub fn free_from(&mut self, time: f64) {
        self.service = Service::Ready;
        self.free_at = time;
        self.wait = Wait::No;
        self.task = None;
        self.idle_said = false;
    }

    /// It has said, at `told` [s], that it is free from `time` [s] on.
    pub fn tells_free(&mut self, told: f64, time: f64) {
        self.free_from(time);
        self.told_at = Some(told);
    }

    /// Whether it has said nothing newer than `time` [s] of when it is free.
    pub fn is_news(&self, time: f64) -> bool {
        self.told_at.is_none_or(|told| time > told)
    }

    /// What it is doing at `now` [s], as a status names it.
    pub fn state(&self, now: f64) -> &'static str {
        match self.service {
            Service::Unknown => "unknown",
            Service::Ready if self.task.is_some() => "busy",
            Service::Ready if self.wait == Wait::No && self.free_at > now => "busy",
            Service::Ready => "idle",
            Service::Working => "busy",
            Service::Fault => "fault",
            Service::Silent => "silent",
        }
    }

    /// The robot as a status shows it at `now` [s].
    pub fn report(&self, name: &str, now: f64) -> RobotReport {
        RobotReport {
            name: name.to_owned(),
            state: self.state(now).to_owned(),
            picked: self.picked,
            failed: self.failed,
            missed: self.missed,
        }
    }
}

/// All robots, upstream first.
#[derive(Debug, Clone, PartialEq)]
pub struct Fleet {
    robots: Vec<RobotInfo>,
}

impl Fleet {
    /// So many robots of which nothing was heard yet.
    pub fn new(robots: usize) -> Self {
        Self {
            robots: vec![RobotInfo::default(); robots],
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.robots.len()
    }

    /// Each with its index.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &RobotInfo)> {
        self.robots.iter().enumerate()
    }

    /// The robot of this index.
    pub fn get(&self, robot: usize) -> &RobotInfo {
        &self.robots[robot]
    }

    /// The robot of this index, to be changed.
    pub fn get_mut(&mut self, robot: usize) -> &mut RobotInfo {
        &mut self.robots[robot]
    }

    /// A window of `robot` opens at `open` [s]: if it waits for one, it waits until then.
    pub fn window_opens(&mut self, robot: usize, open: f64) {
        let info = &mut self.robots[robot];
        if info.service == Service::Ready && info.wait == Wait::Window {
            info.free_at = info.free_at.min(open);
        }
    }

    /// Whoever waits decides again, from `now` [s] on.
    pub fn wake_all(&mut self, now: f64) {
        for robot in &mut self.robots {
            if robot.service == Service::Ready && robot.wait != Wait::No {
                robot.free_at = now;
                robot.wait = Wait::No;
            }
        }
    }

    /// When each can set out next [s]; infinite for those that do not work.
    pub fn free_at(&self, into: &mut Vec<f64>) {
        into.clear();
        into.extend(self.robots.iter().map(|robot| match robot.service {
            Service::Ready => robot.free_at.max(robot.rests_until),
            _ => f64::INFINITY,
        }));
    }
}

/// A time that may be infinite, which JSON has no number for.
mod never {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub fn serialize<S: Serializer>(time: &f64, to: S) -> Result<S::Ok, S::Error> {
        time.is_finite().then_some(time).serialize(to)
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
        Option::<f64>::deserialize(from).map(|time| time.unwrap_or(f64::INFINITY))
    }
}
