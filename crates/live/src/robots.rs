//! The state of each robot.

use super::protocol::{RobotCounts, Verdict};
use pickline::station::Robot;
use serde::{Deserialize, Serialize};

/// Number of tasks in a row that a robot drops before it is paused.
const MOST_DROPPED: u32 = 3;
/// The first rest [s]; each further one is twice as long,
const FIRST_REST: f64 = 0.5;
/// up to this [s].
const LONGEST_REST: f64 = 10.0;

/// Whether a robot takes tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Service {
    /// It has not been heard yet.
    Unknown,
    /// It takes tasks from `free_at` on.
    Ready,
    /// It is busy for an unknown time.
    Working,
    /// It has reported a fault.
    Fault,
    /// Its result is overdue. It gets no task until it is heard again.
    Silent,
}

/// Why a robot that could decide waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Wait {
    /// It does not wait.
    No,
    /// Until the time given by its strategy.
    Until,
    /// Until the next window of an item opens.
    Window,
}

/// The state of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RobotInfo {
    /// Whether it takes tasks.
    pub service: Service,
    /// When it can set out next [s]; infinite if unknown.
    #[serde(with = "never")]
    pub free_at: f64,
    /// Why it does not decide earlier.
    pub wait: Wait,
    /// Where its arm is then, an index for [`Robot::place`]; none while it is where it rests, which
    /// a robot with only one place always is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<u16>,
    /// The number of its open task.
    pub task: Option<u64>,
    /// Number of items that it has picked.
    pub picked: u64,
    /// Number of its grasps that failed.
    pub failed: u64,
    /// Its tasks for which it came too late or did not find the item.
    pub missed: u64,
    /// Number of tasks in a row that it has dropped unasked.
    pub dropped: u32,
    /// It gets no task before this time [s], because it has dropped tasks.
    pub rests_until: f64,
    /// Whether it has reported `idle` during its current task. It may not have known of the task;
    /// the `idle` counts from `free_at` on.
    pub idle_said: bool,
    /// While it is out of service: the timestamp [s] that a state must exceed to end the fault.
    pub fault_at: Option<f64>,
    /// Newest timestamp of its states [s].
    pub said_at: Option<f64>,
    /// Newest timestamp of a result or state that says when it is free [s].
    pub told_at: Option<f64>,
}

impl Default for RobotInfo {
    fn default() -> Self {
        Self {
            service: Service::Unknown,
            free_at: f64::INFINITY,
            wait: Wait::No,
            place: None,
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
    /// Where the arm of `robot`, which this is the state of, is when it is free.
    pub(crate) fn place_of(&self, robot: &Robot) -> u16 {
        // A robot has at most 100 bins and its rest.
        self.place.unwrap_or(robot.start() as u16)
    }

    /// Whether it can get a task, now or at a known time.
    pub(crate) fn is_ready(&self) -> bool {
        self.service == Service::Ready && (self.task.is_none() || self.idle_said)
    }

    /// When it can get a task, `now` [s] or later.
    pub(crate) fn available_from(&self, now: f64) -> f64 {
        self.free_at.max(self.rests_until).max(now)
    }

    /// Counts the result of a task; `before` is the result reported earlier, if any.
    pub(crate) fn count(&mut self, before: Option<Verdict>, verdict: Verdict) {
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

    /// Notes that it has dropped a task unasked at `now` [s]. The third in a row, and each further
    /// one, leads to a pause. Returns whether this is the third.
    pub(crate) fn drops_task(&mut self, now: f64) -> bool {
        self.dropped += 1;
        if self.dropped >= MOST_DROPPED {
            let further = (self.dropped - MOST_DROPPED).min(16);
            let pause = FIRST_REST * f64::from(2u32.pow(further));
            self.rests_until = now + pause.min(LONGEST_REST);
        }
        self.dropped == MOST_DROPPED
    }

    /// Sets it free from `time` [s] on.
    pub(crate) fn free_from(&mut self, time: f64) {
        self.service = Service::Ready;
        self.free_at = time;
        self.wait = Wait::No;
        self.task = None;
        self.idle_said = false;
    }

    /// Notes its report at `told` [s] that it is free from `time` [s] on.
    pub(crate) fn tells_free(&mut self, told: f64, time: f64) {
        self.free_from(time);
        self.told_at = Some(told);
    }

    /// Whether a report at `time` [s] is newer than its last one of when it is free.
    pub(crate) fn is_news(&self, time: f64) -> bool {
        self.told_at.is_none_or(|told| time > told)
    }

    /// Its `state` in a status at `now` [s].
    pub(crate) fn state(&self, now: f64) -> &'static str {
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

    /// The robot's entry in a status at `now` [s].
    pub(crate) fn report(&self, name: &str, now: f64) -> RobotCounts {
        RobotCounts {
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
pub(crate) struct Fleet {
    robots: Vec<RobotInfo>,
}

impl Fleet {
    /// A fleet of `robots` robots that have not been heard yet.
    pub(crate) fn new(robots: usize) -> Self {
        Self {
            robots: vec![RobotInfo::default(); robots],
        }
    }

    /// Number of robots.
    pub(crate) fn len(&self) -> usize {
        self.robots.len()
    }

    /// The robots with their indices.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &RobotInfo)> {
        self.robots.iter().enumerate()
    }

    /// The robot with this index.
    pub(crate) fn get(&self, robot: usize) -> &RobotInfo {
        &self.robots[robot]
    }

    /// The robot with this index, to be changed.
    pub(crate) fn get_mut(&mut self, robot: usize) -> &mut RobotInfo {
        &mut self.robots[robot]
    }

    /// A window of `robot` opens at `open` [s]; if it waits for a window, it waits until then.
    pub(crate) fn window_opens(&mut self, robot: usize, open: f64) {
        let info = &mut self.robots[robot];
        if info.service == Service::Ready && info.wait == Wait::Window {
            info.free_at = info.free_at.min(open);
        }
    }

    /// Makes all waiting robots decide again, from `now` [s] on.
    pub(crate) fn wake_all(&mut self, now: f64) {
        for robot in &mut self.robots {
            if robot.service == Service::Ready && robot.wait != Wait::No {
                robot.free_at = now;
                robot.wait = Wait::No;
            }
        }
    }

    /// Fills in when each robot can set out next [s]; infinite for those out of service.
    pub(crate) fn free_at(&self, into: &mut Vec<f64>) {
        into.clear();
        into.extend(self.robots.iter().map(|robot| match robot.service {
            Service::Ready => robot.free_at.max(robot.rests_until),
            _ => f64::INFINITY,
        }));
    }
}

/// Serializes a time that may be infinite, for which JSON has no number.
mod never {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub(super) fn serialize<S: Serializer>(time: &f64, to: S) -> Result<S::Ok, S::Error> {
        time.is_finite().then_some(time).serialize(to)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<f64, D::Error> {
        Option::<f64>::deserialize(from).map(|time| time.unwrap_or(f64::INFINITY))
    }
}
