//! Messages from the node: tasks for the robots, and figures.

use super::VERSION;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A message from the node.
// Messages are passed on one at a time: a box would cost more than the space it saves.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Outgoing {
    /// Pick this item.
    Task(Task),
    /// Drop a task.
    Cancel(Cancel),
    /// The belt should move at another speed.
    BeltRequest(BeltRequest),
    /// The figures of the line.
    Status(Box<Status>),
    /// Everything up to the tick is decided.
    Due(Due),
}

impl Outgoing {
    /// All values of `kind`.
    pub(crate) const KINDS: [&str; 5] = ["task", "cancel", "belt_request", "status", "due"];

    /// The robot that the message is for; none if it is for all peers.
    pub fn robot(&self) -> Option<&str> {
        match self {
            Self::Task(task) => Some(&task.robot),
            Self::Cancel(cancel) => Some(&cancel.robot),
            Self::BeltRequest(_) | Self::Status(_) | Self::Due(_) => None,
        }
    }

    /// Its value of `kind`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Task(_) => "task",
            Self::Cancel(_) => "cancel",
            Self::BeltRequest(_) => "belt_request",
            Self::Status(_) => "status",
            Self::Due(_) => "due",
        }
    }

    /// Its timestamp [s]; for a task the time of the decision.
    pub fn stamp(&self) -> f64 {
        match self {
            Self::Task(message) => message.decided_at,
            Self::Cancel(message) => message.stamp,
            Self::BeltRequest(message) => message.stamp,
            Self::Status(message) => message.stamp,
            Self::Due(message) => message.stamp,
        }
    }
}

/// A place in the belt frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Point")]
pub struct BeltPoint {
    /// Along the travel [m].
    pub x: f64,
    /// Across the belt [m].
    pub y: f64,
}

/// Pick one item and bring it to the bin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Task {
    /// Number of the task; never reused.
    pub id: u64,
    /// Increases each time that the task is sent again, with its present times and meeting point.
    pub revision: u32,
    /// Name of the robot.
    pub robot: String,
    /// Id of the item.
    pub item: String,
    /// When this was decided [s].
    pub decided_at: f64,
    /// When the robot must leave its bin [s].
    pub start: f64,
    /// First start with which the robot meets the item in its workspace [s].
    pub earliest_start: f64,
    /// Last such start [s]: after this the robot must not set out.
    pub latest_start: f64,
    /// When the robot meets the item [s].
    pub meet_at: f64,
    /// Where the robot meets the item.
    pub meet: BeltPoint,
    /// The bin for the item.
    pub bin: BeltPoint,
    /// The bin's name, if the robot has several bins or this one has a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bin_name: Option<String>,
    /// When the robot is expected to be free again [s].
    pub free_at: f64,
    /// Object-specific reward of the item.
    pub priority: f64,
    /// Strategy that chose it.
    pub strategy: String,
    /// Class of the item, by the camera's last report, as are the fields below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Angle of its long side, from x towards y [rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Height of its top above the belt [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Length and width [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Any other data from the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<serde_json::Map<String, serde_json::Value>>,
}

/// Drop a task: the robot answers with the result `CANCELLED`, or with the actual result if it was
/// too late.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cancel {
    /// Timestamp [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
    /// Name of the robot.
    pub robot: String,
    /// The reason.
    pub reason: String,
}

/// A request for a belt speed. The drive need not follow it; the belt's own messages report what it
/// does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeltRequest {
    /// Timestamp [s].
    pub stamp: f64,
    /// Speed along +x [m/s]; 0 is a stop.
    pub speed: f64,
    /// The reason.
    pub reason: String,
}

/// Everything up to a tick is decided; answers `tick` with message time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Due {
    /// Timestamp of the tick [s].
    pub stamp: f64,
    /// When the next decision is due if no further message comes [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next: Option<f64>,
}

/// The figures of the line. `seen` is always `picked` + all of `missed` + `on_belt` + `claimed` +
/// `unwanted`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Status {
    /// Timestamp [s].
    pub stamp: f64,
    /// Whether this is the last one.
    pub last: bool,
    /// Hash of the node's station, independent of the belt's speed. Absent over ROS 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// `running`, `paused`, `draining`, `drained` or `stopped`, by the operator's orders.
    #[serde(default)]
    pub mode: String,
    /// Items seen.
    pub seen: u64,
    /// Items picked.
    pub picked: u64,
    /// `picked` / (`seen` - `unwanted`); 0 if nothing that is wanted was seen.
    pub picked_share: f64,
    /// Picks per minute since the first message [1/min].
    pub picks_per_min: f64,
    /// Items that were not picked, by reason.
    pub missed: MissedCounts,
    /// Items that may still be picked.
    pub on_belt: u64,
    /// Items that are assigned to a robot.
    pub claimed: u64,
    /// Items that are left on the belt on purpose: their class is not wanted, or no robot has a bin
    /// for it. Absent on a line that takes every item.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unwanted: Option<u64>,
    /// Ids of the tasks without a result yet.
    pub open_tasks: Vec<u64>,
    /// Messages waiting to be sent.
    pub queued: u64,
    /// Messages that were refused, by reason.
    pub rejected: BTreeMap<String, u64>,
    /// Unusual events by kind, such as repeated detections and late results.
    pub noted: BTreeMap<String, u64>,
    /// Each robot, upstream first.
    pub robots: Vec<RobotCounts>,
    /// The sources that were heard, by kind and name; absent over ROS 2.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<SourceReport>,
    /// Durations of decisions; absent with message time, whose output depends only on the
    /// messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
}

impl Status {
    /// Number of items seen that were to be picked.
    pub fn wanted(&self) -> u64 {
        self.seen.saturating_sub(self.unwanted.unwrap_or(0))
    }

    /// The number of unwanted items in words, to be appended to other counts; empty on a line that
    /// takes every item.
    pub fn unwanted_words(&self) -> String {
        let unwanted = self.unwanted;
        unwanted.map_or(String::new(), |count| format!(", {count} unwanted"))
    }
}

/// Items that were not picked, by the first reason that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct MissedCounts {
    /// No robot had a departure window for it.
    pub unreachable: u64,
    /// It was attempted, and no grasp succeeded.
    pub grasp_failed: u64,
    /// Each robot that was sent came too late or did not find it.
    #[serde(default)]
    pub not_found: u64,
    /// A robot was sent but never reported a result.
    pub no_result: u64,
    /// A robot could have picked it at a decision, but another action was chosen.
    pub passed_over: u64,
    /// Whenever it was in a robot's window, the robot was busy or out of service.
    pub busy: u64,
}

impl MissedCounts {
    /// Items missed for any reason.
    pub fn total(&self) -> u64 {
        self.unreachable
            + self.grasp_failed
            + self.not_found
            + self.no_result
            + self.passed_over
            + self.busy
    }
}

/// One robot in a status.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "RobotReport")]
pub struct RobotCounts {
    /// Its name.
    pub name: String,
    /// `idle`, `busy`, `fault`, `silent` (its result is overdue), or `unknown` before its first
    /// message; `paused` or `stopped` if it is idle by order of the operator.
    pub state: String,
    /// Its picks.
    pub picked: u64,
    /// Its failed grasps.
    pub failed: u64,
    /// Its tasks for which it came too late or did not find the item.
    #[serde(default)]
    pub missed: u64,
}

/// The kind of a source of messages.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum SourceKind {
    /// It sends `detection`.
    Camera,
    /// It sends `belt`.
    Belt,
    /// It sends `robot`, `ack` and `result`.
    Robot,
}

impl SourceKind {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Belt => "belt",
            Self::Robot => "robot",
        }
    }
}

/// One source in a status.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SourceReport {
    /// Its `source`, or its kind if it gives none; for a robot its name.
    pub name: String,
    /// Its kind.
    pub kind: SourceKind,
    /// Time since its last message [s].
    pub age: f64,
    /// Typical interval of its messages [s]; absent if it reports only changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// Smallest time from the timestamp of a message to its arrival over the last half minute, by
    /// the machine's clock [s]. It is the sum of transmission delay and clock offset, which cannot
    /// be told apart. Absent with message time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// What is added to its timestamps [s], if its clock certainly differs from the machine's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mapped: Option<f64>,
    /// Whether it has been silent for longer than expected.
    pub overdue: bool,
}

/// Durations of decisions [ms]. Quantiles come from a histogram with classes 1 % wide.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Latency {
    /// Number of decisions.
    pub decisions: u64,
    /// Median [ms].
    pub p50_ms: f64,
    /// 99th percentile [ms].
    pub p99_ms: f64,
    /// Maximum [ms].
    pub max_ms: f64,
}

/// `message` as a line, with its line ending.
pub fn encode<M: Serialize>(message: &M) -> String {
    #[derive(Serialize)]
    struct VersionedMessage<'a, M> {
        v: u64,
        #[serde(flatten)]
        message: &'a M,
    }
    // The messages are plain structures with string keys, which always serialize.
    let line = VersionedMessage {
        v: VERSION,
        message,
    };
    serde_json::to_string(&line).unwrap_or_default() + "\n"
}
