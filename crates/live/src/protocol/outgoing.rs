//! Messages from the node: tasks for the robots, figures for whoever watches.

use super::VERSION;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A message from the node.
// Messages are handed on one at a time: a box would cost more than the room it saves.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Outgoing {
    /// Pick this item.
    Task(Task),
    /// Do not pick it after all.
    Cancel(Cancel),
    /// The belt should move at another speed.
    BeltRequest(BeltRequest),
    /// Where things stand.
    Status(Box<Status>),
    /// Everything up to the tick is decided.
    Due(Due),
}

impl Outgoing {
    /// All kinds, as they are written.
    pub const KINDS: [&str; 5] = ["task", "cancel", "belt_request", "status", "due"];

    /// The robot that it is for; none when it is for everybody.
    pub fn robot(&self) -> Option<&str> {
        match self {
            Self::Task(task) => Some(&task.robot),
            Self::Cancel(cancel) => Some(&cancel.robot),
            Self::BeltRequest(_) | Self::Status(_) | Self::Due(_) => None,
        }
    }

    /// Its kind, as it is written.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Task(_) => "task",
            Self::Cancel(_) => "cancel",
            Self::BeltRequest(_) => "belt_request",
            Self::Status(_) => "status",
            Self::Due(_) => "due",
        }
    }

    /// When it was decided, or is true [s].
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
pub struct Point {
    /// Along the travel [m].
    pub x: f64,
    /// Across the belt [m].
    pub y: f64,
}

/// Pick one item and bring it to the bin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Task {
    /// Number of the task; never given twice.
    pub id: u64,
    /// Grows with every time that the task is sent: the same task again, with times and
    /// meeting point as they are now.
    pub revision: u32,
    /// Name of the robot.
    pub robot: String,
    /// Id of the item.
    pub item: String,
    /// When this was decided [s].
    pub decided_at: f64,
    /// When the robot has to leave its bin [s].
    pub start: f64,
    /// First start that meets the item in the workspace [s].
    pub earliest_start: f64,
    /// Last such start [s]: later than this the robot must refuse.
    pub latest_start: f64,
    /// When it meets the item [s].
    pub meet_at: f64,
    /// Where it meets it.
    pub meet: Point,
    /// Where the item goes.
    pub bin: Point,
    /// When the robot is expected to be free again [s].
    pub free_at: f64,
    /// Object-specific reward of the item.
    pub priority: f64,
    /// Strategy that chose it.
    pub strategy: String,
    /// What the item is, as the camera has said last; so for the fields below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// How it lies: angle of its long side, from x towards y [rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Height of its top above the belt [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// How long it is and how wide [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Whatever else the camera has said of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<serde_json::Map<String, serde_json::Value>>,
}

/// Drop a task: the robot answers with the result `CANCELLED`, or with what came of the
/// task if it was too late.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cancel {
    /// When [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
    /// Name of the robot.
    pub robot: String,
    /// Why.
    pub reason: String,
}

/// The belt's drive is asked for a speed. It need not follow; the belt's own messages say
/// what it does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeltRequest {
    /// When [s].
    pub stamp: f64,
    /// Speed along +x [m/s]; 0 is a stop.
    pub speed: f64,
    /// Why.
    pub reason: String,
}

/// Everything up to a tick is decided; answers `tick` with `--clock messages`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Due {
    /// Stamp of the tick [s].
    pub stamp: f64,
    /// When something is due next if no further message comes [s].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next: Option<f64>,
}

/// Where things stand. `seen` is always `picked` + all of `missed` + `on_belt` + `claimed`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Status {
    /// When [s].
    pub stamp: f64,
    /// Whether this is the last one.
    pub last: bool,
    /// Hash of the layout that the node runs: of its station file, whatever the belt's
    /// speed. Absent over ROS 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// `running`, `paused`, `draining`, `drained` or `stopped`, as the operator wants it.
    #[serde(default)]
    pub mode: String,
    /// Items seen.
    pub seen: u64,
    /// Items picked.
    pub picked: u64,
    /// `picked` / `seen`; 0 when nothing was seen.
    pub picked_share: f64,
    /// Picks over the time since the first message [1/min].
    pub picks_per_min: f64,
    /// Items that were not picked, by reason.
    pub missed: MissedCounts,
    /// Items that may still be picked.
    pub on_belt: u64,
    /// Items that some robot is after.
    pub claimed: u64,
    /// Tasks whose result is not known, by id.
    pub open_tasks: Vec<u64>,
    /// Messages that wait to be sent.
    pub queued: u64,
    /// Messages that were refused, by reason.
    pub rejected: BTreeMap<String, u64>,
    /// What else was noted, by what it was: repeated detections, late results.
    pub noted: BTreeMap<String, u64>,
    /// Each robot, upstream first.
    pub robots: Vec<RobotReport>,
    /// Who was heard, by kind and name; absent over ROS 2.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<SourceReport>,
    /// How long decisions took; absent with `--clock messages`, whose output depends on the
    /// messages only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
}

/// Items that were not picked, by reason, the first that fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct MissedCounts {
    /// No robot had a departure window for it.
    pub unreachable: u64,
    /// Attempted, and no grasp succeeded.
    pub grasp_failed: u64,
    /// A robot was sent, and came too late or did not find it, each time.
    #[serde(default)]
    pub not_found: u64,
    /// A robot was sent and never said what came of it.
    pub no_result: u64,
    /// Some robot could have picked it at some decision, and another action was chosen.
    pub passed_over: u64,
    /// Whenever it was in a window, the robot was busy or out of service.
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
pub struct RobotReport {
    /// Its name.
    pub name: String,
    /// `idle`, `busy`, `fault`, `silent` (it owes a result), or `unknown` before its
    /// first message; `paused` or `stopped` where the operator wants it and it is idle.
    pub state: String,
    /// Its picks.
    pub picked: u64,
    /// Its grasps that failed.
    pub failed: u64,
    /// Its tasks for which it came too late or did not find the item.
    #[serde(default)]
    pub missed: u64,
}

/// What a source of messages is.
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
    /// Its name, as it is written.
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
    /// Its `source`, or its kind where it gives none; a robot's name.
    pub name: String,
    /// What it is.
    pub kind: SourceKind,
    /// Time since it was heard last [s].
    pub age: f64,
    /// Time between two of its messages as a rule [s]; absent where it speaks of changes only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// Smallest time from the stamp of a message to when it came, of the last half minute, by
    /// the machine's clock [s]: the way of the message and the offset of the clocks, which
    /// nobody can tell apart. Absent with message time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// What is added to its stamps [s], where its clock is certainly another than the machine's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mapped: Option<f64>,
    /// Whether it is silent for longer than expected.
    pub overdue: bool,
}

/// How long decisions took [ms]. Quantiles are read off a histogram of 1 % wide classes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Latency {
    /// Decisions taken.
    pub decisions: u64,
    /// Median.
    pub p50_ms: f64,
    /// 99 % were quicker.
    pub p99_ms: f64,
    /// The slowest.
    pub max_ms: f64,
}

/// `message` as a line, with its line end.
pub fn encode<M: Serialize>(message: &M) -> String {
    #[derive(Serialize)]
    struct Line<'a, M> {
        v: u64,
        #[serde(flatten)]
        message: &'a M,
    }
    // The messages are plain structures with text keys, which always serialise.
    let line = Line {
        v: VERSION,
        message,
    };
    serde_json::to_string(&line).unwrap_or_default() + "\n"
}
