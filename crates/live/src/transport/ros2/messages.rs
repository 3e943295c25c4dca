//! The ROS messages, field by field as in `ros2/pickline_interfaces/msg` and in the common packages
//! of ROS 2; `tests/ros2` compares them with those files.

use serde::{Deserialize, Serialize};

/// A type of a field in a ROS message.
pub trait RosType {
    /// Its name in a .msg file.
    fn name() -> String;
}

/// A ROS message: its package, its type, its fields in order.
pub trait RosMessage {
    /// The package that defines it, for example `std_msgs`.
    const PACKAGE: &str;
    /// Its name within the package, for example `Header`.
    const TYPE: &str;

    /// Type and name of each field, in order.
    fn fields() -> Vec<(String, &'static str)>;
}

macro_rules! plain {
    ($($rust:ty = $ros:literal),* $(,)?) => {$(
        impl RosType for $rust {
            fn name() -> String {
                $ros.into()
            }
        }
    )*};
}

plain!(
    bool = "bool",
    u8 = "uint8",
    u32 = "uint32",
    i32 = "int32",
    u64 = "uint64",
    f64 = "float64"
);
plain!(String = "string");
// Nested arrays of constant length are stored flat.
plain!([[f64; 6]; 6] = "float64[36]");

impl<T: RosType> RosType for Vec<T> {
    fn name() -> String {
        T::name() + "[]"
    }
}

macro_rules! messages {
    ($($(#[$about:meta])* $package:literal $name:ident { $($(#[$doc:meta])* $field:ident: $kind:ty,)* })*) => {
        $(
            $(#[$about])*
            #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
            pub struct $name {
                $($(#[$doc])* pub $field: $kind,)*
            }

            impl RosMessage for $name {
                const PACKAGE: &str = $package;
                const TYPE: &str = stringify!($name);

                fn fields() -> Vec<(String, &'static str)> {
                    vec![$((<$kind as RosType>::name(), stringify!($field)),)*]
                }
            }

            impl RosType for $name {
                fn name() -> String {
                    format!("{}/{}", Self::PACKAGE, Self::TYPE)
                }
            }
        )*

        /// All messages: package, type and fields.
        pub fn all() -> Vec<Definition> {
            vec![$(Definition {
                package: $name::PACKAGE,
                name: $name::TYPE,
                fields: $name::fields(),
            },)*]
        }
    };
}

/// The definition of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// The package that defines it.
    pub package: &'static str,
    /// Its name within the package.
    pub name: &'static str,
    /// Type and name of each field, in order.
    pub fields: Vec<(String, &'static str)>,
}

messages! {
    /// A point in time.
    "builtin_interfaces" Time {
        /// Seconds since 1970.
        sec: i32,
        /// Nanoseconds in addition [ns].
        nanosec: u32,
    }
    /// Timestamp and frame of a message.
    "std_msgs" Header {
        /// When the content was measured or decided.
        stamp: Time,
        /// The frame of all positions in the message; must be the belt's.
        frame_id: String,
    }
    /// A position [m].
    "geometry_msgs" Point {
        /// Along the travel [m].
        x: f64,
        /// Across the belt [m].
        y: f64,
        /// Up [m].
        z: f64,
    }
    /// An orientation, as a unit quaternion.
    "geometry_msgs" Quaternion {
        /// Imaginary part along x.
        x: f64,
        /// Imaginary part along y.
        y: f64,
        /// Imaginary part along z.
        z: f64,
        /// Real part.
        w: f64,
    }
    /// A position and an orientation.
    "geometry_msgs" Pose {
        /// Centre of the item [m].
        position: Point,
        /// Rotation of the item's axes against the frame's.
        orientation: Quaternion,
    }
    /// A pose with its uncertainty.
    "geometry_msgs" PoseWithCovariance {
        /// The most likely pose.
        pose: Pose,
        /// Row by row, for x, y, z [m^2] and the rotations about them [rad^2]; all 0 if unknown.
        covariance: [[f64; 6]; 6],
    }
    /// Extents [m].
    "geometry_msgs" Vector3 {
        /// Along x [m].
        x: f64,
        /// Along y [m].
        y: f64,
        /// Along z [m].
        z: f64,
    }
    /// A box around an object, in any orientation.
    "vision_msgs" BoundingBox3D {
        /// Pose of its centre.
        center: Pose,
        /// Lengths of its sides [m].
        size: Vector3,
    }
    /// A possible class of an object.
    "vision_msgs" ObjectHypothesis {
        /// Name or number of the class.
        class_id: String,
        /// Confidence that the object is of this class, 0 to 1.
        score: f64,
    }
    /// A possible class of an object, with its pose.
    "vision_msgs" ObjectHypothesisWithPose {
        /// The class and its confidence.
        hypothesis: ObjectHypothesis,
        /// Where the object is if it is of this class.
        pose: PoseWithCovariance,
    }
    /// A detection of an item.
    "vision_msgs" Detection3D {
        /// Timestamp and frame.
        header: Header,
        /// The possible classes of the item, in any order.
        results: Vec<ObjectHypothesisWithPose>,
        /// The box around the item, with its length, width and height.
        bbox: BoundingBox3D,
        /// The tracker's id; empty if there is none.
        id: String,
    }
    /// The detections of a picture.
    "vision_msgs" Detection3DArray {
        /// Time of the picture, and frame.
        header: Header,
        /// One detection for each item in the picture.
        detections: Vec<Detection3D>,
    }
    /// How the belt moves.
    "pickline_interfaces" BeltState {
        /// Timestamp and frame.
        header: Header,
        /// Speed along x [m/s].
        speed: f64,
        /// Whether there is an encoder.
        has_position: bool,
        /// The belt's travel by the encoder [m].
        position: f64,
    }
    /// What a robot is doing.
    "pickline_interfaces" RobotState {
        /// Timestamp and frame.
        header: Header,
        /// Its name in the station file.
        name: String,
        /// 0 idle, 1 busy, 2 fault.
        state: u8,
        /// Whether `available_at` is known.
        has_available_at: bool,
        /// When it can set out next.
        available_at: Time,
        /// Whether `task` is known.
        has_task: bool,
        /// The last task that it has received.
        task: u64,
    }
    /// A robot has understood a task.
    "pickline_interfaces" TaskAck {
        /// Timestamp and frame.
        header: Header,
        /// Number of the task.
        task: u64,
    }
    /// The result of a task.
    "pickline_interfaces" TaskResult {
        /// Timestamp and frame.
        header: Header,
        /// Number of the task.
        task: u64,
        /// 0 picked, 1 grasp failed, 2 missed, 3 rejected, 4 cancelled.
        result: u8,
        /// Whether `available_at` is known.
        has_available_at: bool,
        /// When the robot can set out next.
        available_at: Time,
    }
    /// Pick one item and bring it to the bin.
    "pickline_interfaces" Task {
        /// Time of the decision, and frame of the positions.
        header: Header,
        /// Number of the task.
        id: u64,
        /// Increases each time that the task is sent.
        revision: u32,
        /// Name of the robot.
        robot: String,
        /// Id of the item.
        item: String,
        /// When to leave the bin.
        start: Time,
        /// First possible start.
        earliest_start: Time,
        /// Last possible start.
        latest_start: Time,
        /// When the robot meets the item.
        meet_at: Time,
        /// Where the robot meets the item.
        meet: Point,
        /// The bin for the item.
        bin: Point,
        /// Name of the bin; empty if the robot has one bin for everything.
        bin_name: String,
        /// When the robot is expected to be free again.
        free_at: Time,
        /// Reward of the item.
        priority: f64,
        /// Strategy that chose it.
        strategy: String,
        /// Class of the item; empty if unknown.
        item_class: String,
        /// Whether `angle` is known.
        has_angle: bool,
        /// Angle of the item's long side, from x towards y [rad].
        angle: f64,
        /// Height of the item's top above the belt [m]; 0 if unknown.
        height: f64,
        /// Length of the item [m]; 0 if unknown.
        length: f64,
        /// Width of the item [m]; 0 if unknown.
        width: f64,
        /// Any other data from the camera, as a JSON object; empty if there is none.
        data: String,
    }
    /// Drop a task.
    "pickline_interfaces" TaskCancel {
        /// Timestamp and frame.
        header: Header,
        /// Number of the task.
        task: u64,
        /// Name of the robot.
        robot: String,
        /// Why the task is dropped, in words.
        reason: String,
    }
    /// The end of the station's turn.
    "pickline_interfaces" Tick {
        /// The time up to which to decide.
        header: Header,
        /// Number of messages published in this turn.
        messages: u32,
        /// Whether this is the last turn.
        last: bool,
    }
    /// The end of the node's turn.
    "pickline_interfaces" Due {
        /// The time up to which everything is decided.
        header: Header,
        /// Whether another decision is due.
        has_next: bool,
        /// When it is due.
        next: Time,
        /// Number of messages published in this turn.
        messages: u32,
        /// Whether this is the last turn.
        last: bool,
    }
    /// A count of an event.
    "pickline_interfaces" Count {
        /// Name of the event, as in docs/protocol.md.
        what: String,
        /// How often it has happened.
        count: u64,
    }
    /// One robot in a status.
    "pickline_interfaces" RobotFigures {
        /// Its name in the station file.
        name: String,
        /// `idle`, `busy`, `fault`, or the mode that the operator ordered.
        state: String,
        /// Number of items that it has picked.
        picked: u64,
        /// Number of its grasps that failed.
        failed: u64,
        /// Its tasks for which it came too late or did not find the item.
        missed: u64,
    }
    /// The figures of the line.
    "pickline_interfaces" LineStatus {
        /// Timestamp and frame.
        header: Header,
        /// Whether this is the last one.
        last: bool,
        /// `running`, `paused`, `draining`, `drained` or `stopped`.
        mode: String,
        /// Items seen.
        seen: u64,
        /// Items picked.
        picked: u64,
        /// Items picked, as a share of those seen.
        picked_share: f64,
        /// Picks [1/min].
        picks_per_min: f64,
        /// Missed: no robot could reach it.
        missed_unreachable: u64,
        /// Missed: no grasp succeeded.
        missed_grasp_failed: u64,
        /// Missed: no robot found it.
        missed_not_found: u64,
        /// Missed: the robot never reported a result.
        missed_no_result: u64,
        /// Missed: another action was chosen.
        missed_passed_over: u64,
        /// Missed: the robots were busy.
        missed_busy: u64,
        /// Items that may still be picked.
        on_belt: u64,
        /// Items that are assigned to a robot.
        claimed: u64,
        /// Items that are left on the belt on purpose.
        unwanted: u64,
        /// Ids of the tasks without a result yet.
        open_tasks: Vec<u64>,
        /// Messages waiting to be sent.
        queued: u64,
        /// Messages that were refused.
        rejected: Vec<Count>,
        /// Unusual events so far.
        noted: Vec<Count>,
        /// The figures of each robot, upstream first.
        robots: Vec<RobotFigures>,
        /// Number of decisions so far.
        decisions: u64,
        /// Median duration of decisions [s].
        latency_p50: f64,
        /// 99th percentile of the duration of decisions [s].
        latency_p99: f64,
        /// Longest duration of a decision [s].
        latency_max: f64,
    }
}

/// The latest timestamp that ROS can represent [s].
const LAST: f64 = i32::MAX as f64;

impl Time {
    /// A timestamp [s since 1970], to the nearest nanosecond.
    pub fn from_stamp(stamp: f64) -> Self {
        let stamp = stamp.clamp(0.0, LAST);
        let mut sec = stamp.floor();
        let mut nanosec = ((stamp - sec) * 1e9).round();
        if nanosec >= 1e9 {
            (sec, nanosec) = (sec + 1.0, 0.0);
        }
        Self {
            sec: sec as i32,
            nanosec: nanosec as u32,
        }
    }

    /// The first nanosecond that is not before a timestamp [s since 1970], so that what is due at
    /// the timestamp is due then.
    pub fn not_before(stamp: f64) -> Self {
        let time = Self::from_stamp(stamp);
        if time.stamp() >= stamp {
            return time;
        }
        Self::from_stamp(stamp + 1e-9)
    }

    /// The timestamp [s since 1970].
    pub fn stamp(&self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}
