//! Messages to the node, from the camera, the belt, the robots and the operator.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A message to the node.
// Messages are passed on one at a time: a box would cost more than the space it saves.
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
    /// The result of a task.
    Result(ResultMessage),
    /// The operator orders that no new task is given, on the line or to one robot.
    Pause(Order),
    /// The operator orders the line, or one robot, to resume.
    Resume(Order),
    /// The operator orders that only known items are picked; later ones pass.
    Drain(Order),
    /// The operator orders that no new task is given and open ones are cancelled.
    Stop(Order),
    /// Time has come this far. With message time the node decides what is due up to this time
    /// and answers with `due`.
    Tick {
        /// Timestamp [s].
        stamp: f64,
    },
}

/// A detection of an item by a camera.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Detection {
    /// When the picture was taken [s].
    pub stamp: f64,
    /// The tracker's id; a detection without one is associated by distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// Position along the travel at the timestamp [m]; negative is upstream of the belt's start.
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
    /// Explicit weight; overrides the weight that follows from the three fields above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Class of the item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Angle of its long side, from x towards y [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Height of its top above the belt [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Length and width [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Any other data for the robot. The node passes it on unread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<serde_json::Map<String, serde_json::Value>>,
    /// Covariance of the position, `[xx, xy, yy]` [m^2]; widens the gate for matching.
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
    /// Timestamp [s].
    pub stamp: f64,
    /// Speed along +x [m/s]; 0 is a stop, negative is backwards.
    pub speed: f64,
    /// Travel of the belt by the encoder, from any zero [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<f64>,
    /// Name of the encoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// The state of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotState {
    /// It waits at its bin and takes tasks.
    Idle,
    /// It is busy.
    Busy,
    /// It is out of service until it reports another state.
    Fault,
}

/// What a robot is doing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotStatus {
    /// Timestamp [s].
    pub stamp: f64,
    /// Its name in the station file.
    pub name: String,
    /// Its state.
    pub state: RobotState,
    /// When it can set out next [s]; if omitted, with `idle` the timestamp, with `busy` unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub available_at: Option<f64>,
    /// Id of the last task that it has received. It shows whether an `idle` was sent before or
    /// after that task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<u64>,
}

/// A robot has understood a task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ack {
    /// Timestamp [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
}

/// The result of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Verdict {
    /// The item is in the bin.
    Picked,
    /// The grasp failed; the item is still on the belt.
    GraspFail,
    /// The robot came too late or did not find the item.
    Missed,
    /// The robot refuses this task; the item is not offered to it again.
    Rejected,
    /// The robot has dropped the task, either because of a `cancel` or for its own reasons.
    Cancelled,
}

/// A place in the belt frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with x and y")]
#[schemars(rename = "Place")]
pub struct FoundPlace {
    /// Along the travel [m].
    pub x: f64,
    /// Across the belt [m].
    pub y: f64,
}

/// The result of a task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Report")]
pub struct ResultMessage {
    /// Timestamp of the result [s].
    pub stamp: f64,
    /// Id of the task.
    pub task: u64,
    /// The result.
    pub result: Verdict,
    /// When the robot can set out next [s]; the timestamp if omitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub available_at: Option<f64>,
    /// Where the item would have been at the task's `meet_at` if it had stayed on the belt,
    /// according to the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<FoundPlace>,
}

/// An order of the operator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// Timestamp [s].
    pub stamp: f64,
    /// Name of the robot; the whole line if omitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
}

impl Incoming {
    /// All values of `kind`.
    pub(crate) const KINDS: [&str; 10] = [
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

    /// Its value of `kind`.
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

    /// Adds `shift` [s] to its times.
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

    /// Sets the source of a detection or belt message that gives none.
    pub(crate) fn name_source(&mut self, name: Option<&str>) {
        let source = match self {
            Self::Detection(message) => &mut message.source,
            Self::Belt(message) => &mut message.source,
            _ => return,
        };
        if source.is_none() {
            *source = name.map(str::to_owned);
        }
    }

    /// The operator's order, if it is one.
    pub fn order(&self) -> Option<&Order> {
        match self {
            Self::Pause(order) | Self::Resume(order) | Self::Drain(order) | Self::Stop(order) => {
                Some(order)
            }
            _ => None,
        }
    }

    /// Its timestamp [s].
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
