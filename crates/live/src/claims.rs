//! A robot's claim on an item: the task, and its stage.

use super::lifecycle::Stage;
use nalgebra::Point2;
use pickline::decision::{Candidate, Moment};
use pickline::kinematics::{Encounter, distance, meeting_range};
use pickline::station::{Belt, ClassId, Robot};
use serde::{Deserialize, Serialize};

/// Longest interval between two cancels of a task [s].
const LONGEST_PAUSE: f64 = 30.0;

/// Why a task is cancelled; the `reason` of its `cancel`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reason {
    /// The belt has stopped before the item was within reach.
    BeltStopped,
    /// The belt runs backwards.
    BeltBackwards,
    /// The belt is as fast as an arm of the line.
    BeltTooFast,
    /// At the belt's new speed the robot would meet the item outside its reach.
    BeltSpeed,
    /// The item has moved on the belt, out of the robot's reach.
    ItemMoved,
    /// No acknowledgement came before the last start.
    NoAck,
    /// The robot has reported a fault.
    Fault,
    /// Another robot has picked the item.
    TakenByOther,
    /// The same robot has picked the item, in an earlier task.
    PickedBefore,
    /// The operator has stopped the line or the robot.
    Stopped,
}

impl Reason {
    /// The text of the `reason` in a `cancel`.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::BeltStopped => "the belt has stopped before the item came within reach",
            Self::BeltBackwards => "the belt runs backwards",
            Self::BeltTooFast => "the belt is as fast as an arm of the line, or faster",
            Self::BeltSpeed => "the belt's speed has changed: the item is met outside the reach",
            Self::ItemMoved => "the item has moved on the belt: it is met outside the reach",
            Self::NoAck => "no acknowledgement has come before the last start",
            Self::Fault => "the robot has reported a fault",
            Self::Stopped => "the operator has stopped it",
            Self::PickedBefore => "the item is picked, by an earlier task of this robot",
            Self::TakenByOther => "another robot has picked the item",
        }
    }
}

/// A task without a result yet. Times are in controller time [s].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Claim {
    /// Number of the task.
    pub task: u64,
    /// Index of the robot.
    pub robot: usize,
    /// Number of the item.
    pub item: u32,
    /// Where the arm is when it leaves, an index for [`Robot::place`].
    #[serde(default, skip_serializing_if = "is_first")]
    pub from: u16,
    /// Index of the robot's bin that the item goes into.
    #[serde(default, skip_serializing_if = "is_first")]
    pub bin: u16,
    /// When the task was decided.
    pub decided: f64,
    /// When the robot leaves its bin.
    pub start: f64,
    /// First and last start with which the robot meets the item in its workspace.
    pub window: (f64, f64),
    /// When the robot meets the item.
    pub meet_at: f64,
    /// Where the robot meets the item [m].
    #[serde(with = "point")]
    pub meet: Point2<f64>,
    /// When the robot is expected to be free again.
    pub free_at: f64,
    /// The stage of the task.
    pub stage: Stage,
    /// Timestamp of the robot's first acknowledgement.
    pub acknowledged: Option<f64>,
    /// Why the task was cancelled, if it was.
    pub reason: Option<Reason>,
    /// Unacknowledged transmissions since a peer was there to receive them.
    pub unheard: u32,
    /// How often the cancel has been sent.
    pub cancels: u32,
    /// When the cancel will be sent again.
    pub repeat_at: Option<f64>,
    /// How often the task was sent before.
    pub revision: u32,
    /// When to act if nothing is heard until then.
    pub deadline: f64,
}

/// Whether a place is the first one, the only one of most robots.
fn is_first(place: &u16) -> bool {
    *place == 0
}

impl Claim {
    /// The claim of robot `index`, whose arm is at its place `from` and leaves at `moment.time` for
    /// `candidate`.
    pub(crate) fn new(
        task: u64,
        (index, from): (usize, u16),
        moment: &Moment,
        candidate: &Candidate,
    ) -> Self {
        let travel = moment.travel_time(candidate);
        let time = moment.time;
        Self {
            task,
            robot: index,
            item: candidate.item,
            from,
            bin: candidate.bin,
            decided: time,
            start: time,
            window: (candidate.open, candidate.close),
            meet_at: time + travel,
            meet: Point2::new(
                moment.x(candidate) + moment.belt_speed * travel,
                candidate.y,
            ),
            free_at: time + moment.pick_time(candidate, travel),
            stage: Stage::Sent,
            acknowledged: None,
            reason: None,
            unheard: 0,
            cancels: 0,
            repeat_at: None,
            revision: 0,
            deadline: f64::INFINITY,
        }
    }

    /// Replans the task from `now` on for a robot that has not left yet; the item was at (`x0`,
    /// `y`) [m] at time 0. Returns whether the task can still be done with a start by `latest` [s].
    /// So no robot waits for an item that a nearly stationary belt brings in an hour.
    pub(crate) fn plan_again(
        &mut self,
        robot: &Robot,
        belt: &Belt,
        (now, latest): (f64, f64),
        (x0, y): (f64, f64),
    ) -> bool {
        let window = robot.departure_window(belt, usize::from(self.from), x0, y);
        let Some((open, close)) = window else {
            return false;
        };
        let candidate = Candidate {
            item: self.item,
            bin: self.bin,
            class: ClassId::OTHER,
            x0,
            y,
            weight: 0.0,
            open,
            close,
        };
        let moment = Moment::at(robot, belt, usize::from(self.from), now.max(open));
        let fresh = Self::new(self.task, (self.robot, self.from), &moment, &candidate);
        let possible = now <= close && open <= latest;
        if possible {
            *self = Self {
                decided: self.decided,
                stage: self.stage,
                acknowledged: self.acknowledged,
                reason: self.reason,
                unheard: self.unheard,
                cancels: self.cancels,
                repeat_at: self.repeat_at,
                revision: self.revision + 1,
                deadline: self.deadline,
                ..fresh
            };
        }
        possible
    }

    /// Replans the task for a robot on its way, if the item is not where it was expected: the robot
    /// turns to the new meeting point from its present position. Returns whether the task can still
    /// be done.
    pub(crate) fn redirect(
        &mut self,
        robot: &Robot,
        belt: &Belt,
        now: f64,
        (x0, y): (f64, f64),
    ) -> bool {
        let from = robot.place(usize::from(self.from));
        let way = self.meet - from;
        let whole = self.meet_at - self.start;
        let gone = if whole > 0.0 {
            ((now - self.start) / whole).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let gone = match robot.arm.constant_speed() {
            Some(_) => gone,
            None => robot.arm.progress(way.norm(), gone * whole, whole),
        };
        let arm = from + way * gone;
        let leaves = now.max(self.start);
        let x = x0 + belt.speed * leaves;
        // From there it moves as if it began at rest.
        let travel = robot.arm.travel_time(&Encounter {
            dx: x - arm.x,
            dy: y - arm.y,
            belt_speed: belt.speed,
            upstream: -x,
            downstream: belt.length - x,
        });
        let meet = Point2::new(x + belt.speed * travel, y);
        let range = meeting_range(robot.base.x, robot.base.y, robot.reach, y, belt.length);
        let possible = range.is_some_and(|(low, high)| (low..=high).contains(&meet.x));
        if possible {
            self.meet = meet;
            self.meet_at = leaves + travel;
            let bin = &robot.bins[usize::from(self.bin)];
            let back = robot
                .arm
                .time(distance(meet.x - bin.at.x, meet.y - bin.at.y));
            self.free_at = self.meet_at + robot.grasp_time + back + bin.release_time;
            let window = robot.departure_window(belt, usize::from(self.from), x0, y);
            self.window = window.unwrap_or(self.window);
            self.revision += 1;
        }
        possible
    }
}

impl Claim {
    /// The next time to act on the task. While its robot is `unreachable` nothing is sent, so only
    /// the consequences of its silence are due.
    pub(crate) fn due(&self, unreachable: bool) -> Option<f64> {
        match (self.stage, self.repeat_at) {
            (Stage::Sent, _) if unreachable => None,
            (stage, Some(at)) if stage.is_cancelled() && !unreachable => {
                Some(self.deadline.min(at))
            }
            _ => Some(self.deadline),
        }
    }

    /// When the task becomes moot: `result_timeout` [s] after both the last start and the robot's
    /// expected return.
    pub(crate) fn moot_from(&self, result_timeout: f64) -> f64 {
        self.window.1.max(self.free_at) + result_timeout
    }

    /// Notes a cancel sent at `now`. The next one follows after `pause` [s], which doubles each
    /// time.
    pub(crate) fn note_cancel(&mut self, now: f64, pause: f64) {
        let doubled = pause * f64::from(2u32.saturating_pow(self.cancels.min(16)));
        self.cancels += 1;
        self.repeat_at = Some(now + doubled.min(LONGEST_PAUSE.max(pause)));
    }
}

/// Serializes a point as its two coordinates.
mod point {
    use nalgebra::Point2;
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub(super) fn serialize<S: Serializer>(point: &Point2<f64>, to: S) -> Result<S::Ok, S::Error> {
        [point.x, point.y].serialize(to)
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Point2<f64>, D::Error> {
        <[f64; 2]>::deserialize(from).map(Point2::from)
    }
}
