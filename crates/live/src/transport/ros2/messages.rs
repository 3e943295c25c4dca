//! The ROS messages, field for field as in `ros2/pickline_interfaces/msg` and in the common
//! packages of ROS 2; `tests/ros2` holds them to those files.

use serde::{Deserialize, Serialize};

/// A type that can stand in a ROS message.
pub trait RosType {
    /// Its name in a .msg file.
    fn name() -> String;
}

/// A ROS message: its package, its type, its fields in order.
pub trait RosMessage {
    /// Package.
    const PACKAGE: &str;
    /// Type within the package.
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
// Arrays of constant length stand in a row, whatever their nesting.
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

/// A message as it is defined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// Package.
    pub package: &'static str,
    /// Type.
    pub name: &'static str,
    /// Type and name of each field, in order.
    pub fields: Vec<(String, &'static str)>,
}

messages! {
    /// A moment.
    "builtin_interfaces" Time {
        /// Seconds since 1970.
        sec: i32,
        /// The rest [ns].
        nanosec: u32,
    }
    /// When, and in which frame.
    "std_msgs" Header {
        /// When.
        stamp: Time,
        /// In which frame.
        frame_id: String,
    }
    /// A place [m].
    "geometry_msgs" Point {
        /// Along the travel [m].
        x: f64,
        /// Across the belt [m].
        y: f64,
        /// Up [m].
        z: f64,
    }
    /// An orientation.
    "geometry_msgs" Quaternion {
        /// Imaginary part.
        x: f64,
        /// Imaginary part.
        y: f64,
        /// Imaginary part.
        z: f64,
        /// Real part.
        w: f64,
    }
    /// A place and an orientation.
    "geometry_msgs" Pose {
        /// The place.
        position: Point,
        /// The orientation.
        orientation: Quaternion,
    }
    /// A pose that is not known exactly.
    "geometry_msgs" PoseWithCovariance {
        /// The pose.
        pose: Pose,
        /// Row by row, of x, y, z and the rotations about them.
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
    /// A box.
    "vision_msgs" BoundingBox3D {
        /// Its centre.
        center: Pose,
        /// Its extents.
        size: Vector3,
    }
    /// What something may be.
    "vision_msgs" ObjectHypothesis {
        /// The class.
        class_id: String,
        /// How sure that is.
        score: f64,
    }
    /// What something may be, and where it is then.
    "vision_msgs" ObjectHypothesisWithPose {
        /// What.
        hypothesis: ObjectHypothesis,
        /// Where.
        pose: PoseWithCovariance,
    }
    /// One item that was seen.
    "vision_msgs" Detection3D {
        /// When, and in which frame.
        header: Header,
        /// What it may be.
        results: Vec<ObjectHypothesisWithPose>,
        /// Where it is.
        bbox: BoundingBox3D,
        /// Its number with the tracker; empty when there is none.
        id: String,
    }
    /// What one picture shows.
    "vision_msgs" Detection3DArray {
        /// When it was taken, and in which frame.
        header: Header,
        /// What is in it.
        detections: Vec<Detection3D>,
    }
    /// How the belt moves.
    "pickline_interfaces" BeltState {
        /// When, and in which frame.
        header: Header,
        /// Speed along x [m/s].
        speed: f64,
        /// Whether there is an encoder.
        has_position: bool,
        /// How far it has travelled [m].
        position: f64,
    }
    /// What a robot is doing.
    "pickline_interfaces" RobotState {
        /// When.
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
        /// When.
        header: Header,
        /// Number of the task.
        task: u64,
    }
    /// What came of a task.
    "pickline_interfaces" TaskResult {
        /// When.
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
        /// When it was decided, and the frame of the places.
        header: Header,
        /// Number of the task.
        id: u64,
        /// Grows with every time that the task is sent.
        revision: u32,
        /// Name of the robot.
        robot: String,
        /// Id of the item.
        item: String,
        /// When to leave the bin.
        start: Time,
        /// First such moment.
        earliest_start: Time,
        /// Last such moment.
        latest_start: Time,
        /// When the item is met.
        meet_at: Time,
        /// Where.
        meet: Point,
        /// Where the item goes.
        bin: Point,
        /// When the robot is expected to be free again.
        free_at: Time,
        /// Reward of the item.
        priority: f64,
        /// Strategy that chose it.
        strategy: String,
        /// What the item is; empty where nobody has said so.
        item_class: String,
        /// Whether `angle` is known.
        has_angle: bool,
        /// Angle of the item's long side, from x towards y [rad].
        angle: f64,
        /// Height of the item's top above the belt [m]; 0 where it is not known.
        height: f64,
        /// How long the item is [m]; 0 where that is not known.
        length: f64,
        /// How wide it is [m]; 0 where that is not known.
        width: f64,
        /// Whatever else the camera has said of it, as a JSON object; empty for nothing.
        data: String,
    }
    /// Drop a task.
    "pickline_interfaces" TaskCancel {
        /// When.
        header: Header,
        /// Number of the task.
        task: u64,
        /// Name of the robot.
        robot: String,
        /// Why.
        reason: String,
    }
    /// The station's turn is over.
    "pickline_interfaces" Tick {
        /// Up to when things are to be decided.
        header: Header,
        /// Messages published since the last turn.
        messages: u32,
        /// Whether nothing more comes.
        last: bool,
    }
    /// The node's turn is over.
    "pickline_interfaces" Due {
        /// Up to when things are decided.
        header: Header,
        /// Whether something is due later.
        has_next: bool,
        /// When.
        next: Time,
        /// Messages published since the last turn.
        messages: u32,
        /// Whether nothing more comes.
        last: bool,
    }
    /// How often something happened.
    "pickline_interfaces" Count {
        /// What.
        what: String,
        /// How often.
        count: u64,
    }
    /// One robot in a status.
    "pickline_interfaces" RobotFigures {
        /// Its name.
        name: String,
        /// What it is doing.
        state: String,
        /// Its picks.
        picked: u64,
        /// Its grasps that failed.
        failed: u64,
        /// Its tasks for which it came too late or did not find the item.
        missed: u64,
    }
    /// Where things stand.
    "pickline_interfaces" LineStatus {
        /// When.
        header: Header,
        /// Whether this is the last one.
        last: bool,
        /// `running`, `paused`, `draining`, `drained` or `stopped`.
        mode: String,
        /// Items seen.
        seen: u64,
        /// Items picked.
        picked: u64,
        /// The share of it.
        picked_share: f64,
        /// Picks [1/min].
        picks_per_min: f64,
        /// Missed: no robot could reach it.
        missed_unreachable: u64,
        /// Missed: no grasp succeeded.
        missed_grasp_failed: u64,
        /// Missed: no robot found it.
        missed_not_found: u64,
        /// Missed: nobody said what came of it.
        missed_no_result: u64,
        /// Missed: others were preferred.
        missed_passed_over: u64,
        /// Missed: the robots were busy.
        missed_busy: u64,
        /// Items that may still be picked.
        on_belt: u64,
        /// Items that some robot is after.
        claimed: u64,
        /// Tasks whose result is not known.
        open_tasks: Vec<u64>,
        /// Messages that wait to be sent.
        queued: u64,
        /// Messages that were refused.
        rejected: Vec<Count>,
        /// What else was noted.
        noted: Vec<Count>,
        /// Each robot.
        robots: Vec<RobotFigures>,
        /// Decisions taken.
        decisions: u64,
        /// Their median [s].
        latency_p50: f64,
        /// 99 % were quicker [s].
        latency_p99: f64,
        /// The slowest [s].
        latency_max: f64,
    }
}

/// The latest stamp that ROS can carry [s].
const LAST: f64 = i32::MAX as f64;

impl Time {
    /// A stamp [s since 1970], to the nearest nanosecond.
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

    /// The first nanosecond that is not before a stamp [s since 1970]: what is due at the
    /// stamp is due then.
    pub fn not_before(stamp: f64) -> Self {
        let time = Self::from_stamp(stamp);
        if time.stamp() >= stamp {
            return time;
        }
        Self::from_stamp(stamp + 1e-9)
    }

    /// The stamp [s since 1970].
    pub fn stamp(&self) -> f64 {
        f64::from(self.sec) + f64::from(self.nanosec) * 1e-9
    }
}
