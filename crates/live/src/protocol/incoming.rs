//! Messages to the node: what the camera, the belt and the robots tell.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A message to the node.
// Messages are handed on one at a time: a box would cost more than the room it saves.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Incoming {
    /// The camera has seen an item.
    Detection(Detection),
    /// How the belt moves.
    Belt(BeltState),
    /// What a robot is doing.
    Robot(RobotStatus),
    /// A robot has understood a task and sets out.
    Ack(Ack),
    /// What came of a task.
    Result(Report),
    /// The operator wants no new task to be given, on the line or to one robot.
    Pause(Order),
    /// The operator wants the line, or one robot, to go on.
    Resume(Order),
    /// The operator wants the items that are known to be picked, and no others.
    Drain(Order),
    /// The operator wants no new task to be given, and the open ones to be cancelled.
    Stop(Order),
    /// Time has come this far. With `--clock messages` the node decides what is due up to
    /// then and answers `due`.
    Tick {
        /// The time [s].
        stamp: f64,
    },
}

/// An item where the camera saw it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Detection {
    /// When the picture was taken [s].
    pub stamp: f64,
    /// The tracker's id; a detection without one is associated by distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// Position along the travel at the stamp [m]; negative is upstream of the belt's start.
    pub x: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Area seen from above [cm^2].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_cm2: Option<f64>,
    /// Probability that this is a real item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_detection: Option<f64>,
    /// Probability that a grasp succeeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_grasp: Option<f64>,
    /// Explicit weight; wins over the one that follows from the three above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// What it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// How it lies: angle of its long side, from x towards y [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Height of its top above the belt [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// How long it is and how wide [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Whatever else the robot should know of it. The node does not look at it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<serde_json::Map<String, serde_json::Value>>,
    /// Covariance of the position, `[xx, xy, yy]` [m^2]; widens the association.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[f64; 3]>,
    /// Name of the camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// How the belt moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BeltState {
    /// When [s].
    pub stamp: f64,
    /// Speed along +x [m/s]; 0 is a stop, a negative speed runs backwards.
    pub speed: f64,
    /// How far the belt has travelled, from any zero [m]: the encoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<f64>,
    /// Name of the encoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// What a robot can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotState {
    /// It rests at its bin and takes tasks.
    Idle,
    /// It is at work.
    Busy,
    /// It does not work until it reports another state.
    Fault,
}

/// What a robot is doing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotStatus {
    /// When [s].
    pub stamp: f64,
    /// Its name in the station file.
    pub name: String,
    /// What it is doing.
    pub state: RobotState,
    /// When it can set out next [s]; with `idle` the stamp when not given, with `busy`
    /// unknown when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub available_at: Option<f64>,
    /// Id of the last task that it has received. With it an `idle` is known to be of after
    /// that task, or of before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<u64>,
}

/// A robot has understood a task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ack {
    /// When [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
}

/// What came of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Verdict {
    /// The item is in the bin.
    Picked,
    /// The gripper did not get hold of it; it is still on the belt.
    GraspFail,
    /// The robot came too late or did not find it.
    Missed,
    /// The robot does not take this task; the item is not offered to it again.
    Rejected,
    /// The robot has dropped the task, as it was told or for reasons of its own.
    Cancelled,
}

/// A place in the belt frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Along the travel [m].
    pub x: f64,
    /// Across the belt [m].
    pub y: f64,
}

/// What came of a task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// When this was known [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
    /// The result.
    pub result: Verdict,
    /// When the robot can set out next [s]; the stamp when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub available_at: Option<f64>,
    /// Where the robot found the item, had it stayed on the belt, at the `meet_at` of the task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<Place>,
}

/// What the operator wants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// When [s].
    pub stamp: f64,
    /// The robot that it is about; all of the line when not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
}

impl Incoming {
    /// All kinds, as they are written.
    pub const KINDS: [&str; 10] = [
        "detection",
        "belt",
        "robot",
        "ack",
        "result",
        "pause",
        "resume",
        "drain",
        "stop",
        "tick",
    ];

    /// Its kind, as it is written.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Detection(_) => "detection",
            Self::Belt(_) => "belt",
            Self::Robot(_) => "robot",
            Self::Ack(_) => "ack",
            Self::Result(_) => "result",
            Self::Pause(_) => "pause",
            Self::Resume(_) => "resume",
            Self::Drain(_) => "drain",
            Self::Stop(_) => "stop",
            Self::Tick { .. } => "tick",
        }
    }

    /// Moves its times by `shift` [s].
    pub fn shift(&mut self, shift: f64) {
        let available = match self {
            Self::Robot(message) => message.available_at.as_mut(),
            Self::Result(message) => message.available_at.as_mut(),
            _ => None,
        };
        if let Some(available) = available {
            *available += shift;
        }
        *match self {
            Self::Detection(message) => &mut message.stamp,
            Self::Belt(message) => &mut message.stamp,
            Self::Robot(message) => &mut message.stamp,
            Self::Ack(message) => &mut message.stamp,
            Self::Result(message) => &mut message.stamp,
            Self::Pause(order) | Self::Resume(order) | Self::Drain(order) | Self::Stop(order) => {
                &mut order.stamp
            }
            Self::Tick { stamp } => stamp,
        } += shift;
    }

    /// Names the source of what is seen of items and belt, where it does not name itself.
    pub fn name_source(&mut self, name: Option<&str>) {
        let source = match self {
            Self::Detection(message) => &mut message.source,
            Self::Belt(message) => &mut message.source,
            _ => return,
        };
        if source.is_none() {
            *source = name.map(str::to_owned);
        }
    }

    /// What the operator wants, if it is that.
    pub fn order(&self) -> Option<&Order> {
        match self {
            Self::Pause(order) | Self::Resume(order) | Self::Drain(order) | Self::Stop(order) => {
                Some(order)
            }
            _ => None,
        }
    }

    /// When it happened [s].
    pub fn stamp(&self) -> f64 {
        match self {
            Self::Detection(message) => message.stamp,
            Self::Belt(message) => message.stamp,
            Self::Robot(message) => message.stamp,
            Self::Ack(message) => message.stamp,
            Self::Result(message) => message.stamp,
            Self::Pause(order) | Self::Resume(order) | Self::Drain(order) | Self::Stop(order) => {
                order.stamp
            }
            Self::Tick { stamp } => *stamp,
        }
    }
}
