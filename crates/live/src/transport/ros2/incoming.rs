//! Conversion of messages to the node from and to ROS messages.

use super::messages::{
    BeltState, BoundingBox3D, Detection3D, Detection3DArray, Header, ObjectHypothesis,
    ObjectHypothesisWithPose, Point, Pose, PoseWithCovariance, Quaternion, RobotState, TaskAck,
    TaskResult, Tick, Time, Vector3,
};
use crate::protocol::{
    self, Detection, Incoming, Rejected, Rejection, ResultMessage, Verdict, check_values,
};
use pickline::error::shown;

/// A message that was read, or its refusal.
type Read = Result<Incoming, Rejected>;

/// The states of a robot, by their number.
const STATES: [protocol::RobotState; 3] = [
    protocol::RobotState::Idle,
    protocol::RobotState::Busy,
    protocol::RobotState::Fault,
];

/// The results of a task, by their number.
const VERDICTS: [Verdict; 5] = [
    Verdict::Picked,
    Verdict::GraspFail,
    Verdict::Missed,
    Verdict::Rejected,
    Verdict::Cancelled,
];

/// Square metres per square centimetre.
const CM2: f64 = 1e-4;

/// A header for `frame` and `stamp` [s].
pub(crate) fn header(frame: &str, stamp: f64) -> Header {
    Header {
        stamp: Time::from_stamp(stamp),
        frame_id: frame.to_owned(),
    }
}

/// The index in `table` of one of its entries.
fn number<T: PartialEq>(table: &[T], entry: &T) -> u8 {
    table.iter().position(|known| known == entry).unwrap_or(0) as u8
}

fn entry<T: Copy>(table: &[T], number: u8, field: &str) -> Result<T, Rejected> {
    table.get(usize::from(number)).copied().ok_or_else(|| {
        let most = table.len() - 1;
        let problem = format!("{field} = {number}; expected 0 to {most}");
        Rejected::new(Rejection::Field, problem)
    })
}

/// `value`, which must be a number.
///
/// # Errors
/// It is infinite or NaN, for which JSON has no number either.
pub(crate) fn finite(field: &str, value: f64) -> Result<f64, Rejected> {
    if value.is_finite() {
        return Ok(value);
    }
    let problem = format!("{field} = {value}; expected a number");
    Err(Rejected::new(Rejection::Field, problem))
}

/// An optional value; one that is infinite or NaN counts as not given.
fn if_finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

fn checked(message: Incoming) -> Read {
    check_values(&message)?;
    Ok(message)
}

fn known(has: bool, time: &Time) -> Option<f64> {
    has.then(|| time.stamp())
}

fn check_frame(header: &Header, frame: &str) -> Result<(), Rejected> {
    if header.frame_id == frame {
        return Ok(());
    }
    let problem = format!("frame_id `{}`; expected `{frame}`", shown(&header.frame_id));
    Err(Rejected::new(Rejection::Field, problem))
}

/// Reads the detections of a picture, which must be in the belt frame `frame`.
pub(crate) fn read_detections(array: &Detection3DArray, frame: &str) -> Vec<Read> {
    let detections = array.detections.iter();
    detections
        .map(|detection| read_detection(detection, &array.header, frame))
        .collect()
}

fn read_detection(detection: &Detection3D, picture: &Header, frame: &str) -> Read {
    // A detection without its own header uses that of the picture.
    let own = &detection.header;
    let framed = if own.frame_id.is_empty() {
        picture
    } else {
        own
    };
    check_frame(framed, frame)?;
    let stamp = if own.stamp == Time::default() {
        picture.stamp.stamp()
    } else {
        own.stamp.stamp()
    };
    let results = detection.results.iter();
    let best = results.max_by(|a, b| a.hypothesis.score.total_cmp(&b.hypothesis.score));
    let covariance = best.map(|best| best.pose.covariance);
    let covariance = covariance.map(|rows| [rows[0][0], rows[0][1], rows[1][1]]);
    for value in covariance.into_iter().flatten() {
        finite("covariance", value)?;
    }
    let text = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    let BoundingBox3D { center, size } = &detection.bbox;
    let area = if_finite(size.x * size.y / CM2);
    let height = if_finite(center.position.z + 0.5 * size.z);
    let sides = Some([size.x, size.y]).filter(|sides| sides.iter().all(|side| *side > 0.0));
    for side in sides.into_iter().flatten() {
        finite("size", side)?;
    }
    checked(Incoming::Detection(Detection {
        stamp,
        id: text(&detection.id),
        x: finite("x", center.position.x)?,
        y: finite("y", center.position.y)?,
        area_cm2: area.filter(|area| *area > 0.0),
        p_detection: best.and_then(|best| if_finite(best.hypothesis.score)),
        p_grasp: None,
        weight: None,
        class: best.and_then(|best| text(&best.hypothesis.class_id)),
        angle: yaw(&center.orientation).and_then(if_finite),
        height: height.filter(|height| *height > 0.0),
        size: sides,
        data: None,
        covariance: covariance.filter(|covariance| *covariance != [0.0; 3]),
        source: None,
    }))
}

/// The angle about the vertical [rad]; none if no orientation is given.
fn yaw(orientation: &Quaternion) -> Option<f64> {
    let Quaternion { x, y, z, w } = *orientation;
    let is_given = x != 0.0 || y != 0.0 || z != 0.0;
    is_given.then(|| (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)))
}

/// A picture with one detection.
pub(crate) fn detections(detection: &Detection, frame: &str) -> Detection3DArray {
    let half = 0.5 * detection.angle.unwrap_or(0.0);
    let pose = Pose {
        position: Point {
            x: detection.x,
            y: detection.y,
            z: 0.5 * detection.height.unwrap_or(0.0),
        },
        orientation: Quaternion {
            z: half.sin(),
            w: half.cos(),
            ..Quaternion::default()
        },
    };
    let mut covariance = [[0.0; 6]; 6];
    if let Some([xx, xy, yy]) = detection.covariance {
        (covariance[0][0], covariance[0][1]) = (xx, xy);
        (covariance[1][0], covariance[1][1]) = (xy, yy);
    }
    let header = header(frame, detection.stamp);
    let side = (detection.area_cm2.unwrap_or(0.0) * CM2).sqrt();
    let [length, width] = detection.size.unwrap_or([side; 2]);
    let seen = Detection3D {
        header: header.clone(),
        results: vec![ObjectHypothesisWithPose {
            hypothesis: ObjectHypothesis {
                class_id: detection.class.clone().unwrap_or_default(),
                score: detection.p_detection.unwrap_or(1.0),
            },
            pose: PoseWithCovariance {
                pose: pose.clone(),
                covariance,
            },
        }],
        bbox: BoundingBox3D {
            center: pose,
            size: Vector3 {
                x: length,
                y: width,
                z: detection.height.unwrap_or(0.0),
            },
        },
        id: detection.id.clone().unwrap_or_default(),
    };
    Detection3DArray {
        header,
        detections: vec![seen],
    }
}

/// Reads the belt's motion, along the x of `frame`.
pub(crate) fn read_belt(belt: &BeltState, frame: &str) -> Read {
    check_frame(&belt.header, frame)?;
    checked(Incoming::Belt(protocol::BeltState {
        stamp: belt.header.stamp.stamp(),
        speed: finite("speed", belt.speed)?,
        position: if_finite(belt.position).filter(|_| belt.has_position),
        source: None,
    }))
}

/// The belt's motion as a ROS message.
pub(crate) fn belt(belt: &protocol::BeltState, frame: &str) -> BeltState {
    BeltState {
        header: header(frame, belt.stamp),
        speed: belt.speed,
        has_position: belt.position.is_some(),
        position: belt.position.unwrap_or(0.0),
    }
}

/// Reads a robot's state.
pub(crate) fn read_robot(robot: &RobotState) -> Read {
    checked(Incoming::Robot(protocol::RobotStatus {
        stamp: robot.header.stamp.stamp(),
        name: robot.name.clone(),
        state: entry(&STATES, robot.state, "state")?,
        available_at: known(robot.has_available_at, &robot.available_at),
        task: robot.has_task.then_some(robot.task),
    }))
}

/// A robot's state as a ROS message.
pub(crate) fn robot(robot: &protocol::RobotStatus, frame: &str) -> RobotState {
    RobotState {
        header: header(frame, robot.stamp),
        name: robot.name.clone(),
        state: number(&STATES, &robot.state),
        has_available_at: robot.available_at.is_some(),
        available_at: Time::from_stamp(robot.available_at.unwrap_or(0.0)),
        has_task: robot.task.is_some(),
        task: robot.task.unwrap_or(0),
    }
}

/// Reads an acknowledgement of a task.
pub(crate) fn read_ack(ack: &TaskAck) -> Read {
    checked(Incoming::Ack(protocol::Ack {
        stamp: ack.header.stamp.stamp(),
        task: ack.task,
    }))
}

/// An acknowledgement of a task as a ROS message.
pub(crate) fn ack(ack: &protocol::Ack, frame: &str) -> TaskAck {
    TaskAck {
        header: header(frame, ack.stamp),
        task: ack.task,
    }
}

/// Reads the result of a task.
pub(crate) fn read_result(result: &TaskResult) -> Read {
    checked(Incoming::Result(ResultMessage {
        stamp: result.header.stamp.stamp(),
        task: result.task,
        result: entry(&VERDICTS, result.result, "result")?,
        available_at: known(result.has_available_at, &result.available_at),
        found: None,
    }))
}

/// The result of a task as a ROS message.
pub(crate) fn result(report: &ResultMessage, frame: &str) -> TaskResult {
    TaskResult {
        header: header(frame, report.stamp),
        task: report.task,
        result: number(&VERDICTS, &report.result),
        has_available_at: report.available_at.is_some(),
        available_at: Time::from_stamp(report.available_at.unwrap_or(0.0)),
    }
}

/// Reads the end of the station's turn.
pub(crate) fn read_tick(tick: &Tick) -> Read {
    let stamp = tick.header.stamp.stamp();
    checked(Incoming::Tick { stamp })
}

/// The end of the station's turn of `messages` messages; without a `stamp` [s] it is the last turn.
pub(crate) fn tick(stamp: Option<f64>, messages: u32, frame: &str) -> Tick {
    Tick {
        header: Header {
            stamp: Time::not_before(stamp.unwrap_or(0.0)),
            frame_id: frame.to_owned(),
        },
        messages,
        last: stamp.is_none(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::{RobotStatus, decode, encode};

    const STAMP: f64 = 1_795_000_000.25;

    fn seen(change: impl FnOnce(&mut Detection3D)) -> Read {
        let detection = Detection {
            stamp: STAMP,
            id: Some("a".into()),
            x: 0.5,
            y: -0.1,
            p_detection: Some(0.9),
            class: Some("PET".into()),
            size: Some([0.25, 0.5]),
            height: Some(0.125),
            covariance: Some([1e-4, 0.0, 1e-4]),
            ..Detection::default()
        };
        let mut array = detections(&detection, "belt");
        change(&mut array.detections[0]);
        read_detections(&array, "belt").remove(0)
    }

    fn place(x: f64) -> Read {
        seen(|detection| detection.bbox.center.position.x = x)
    }

    /// The same values as a line of JSON.
    fn as_line(message: &Incoming) -> Read {
        decode(encode(message).trim_end().as_bytes())
    }

    #[test]
    fn values_are_refused_as_in_a_line() {
        let belt_at = |speed: f64| protocol::BeltState {
            stamp: STAMP,
            speed,
            position: None,
            source: None,
        };
        let robot_named = |name: &str| RobotStatus {
            stamp: STAMP,
            name: name.into(),
            state: protocol::RobotState::Idle,
            available_at: None,
            task: None,
        };
        // Millimetres, millimetres per second, and a name that is too long.
        let far = Detection {
            stamp: STAMP,
            x: -1300.0,
            ..Detection::default()
        };
        let (fast, long) = (belt_at(250.0), robot_named(&"r".repeat(201)));
        let pairs = [
            (
                read_detections(&detections(&far, "belt"), "belt").remove(0),
                as_line(&Incoming::Detection(far)),
            ),
            (
                read_belt(&belt(&fast, "belt"), "belt"),
                as_line(&Incoming::Belt(fast)),
            ),
            (
                read_robot(&robot(&long, "belt")),
                as_line(&Incoming::Robot(long)),
            ),
        ];
        for (read, line) in pairs {
            assert_eq!(line.as_ref().unwrap_err().reason, Rejection::Value);
            assert_eq!(read, line);
        }
    }

    #[test]
    fn what_is_valid_is_the_same_as_in_a_line() {
        let read = place(0.5).unwrap();
        assert_eq!(as_line(&read), Ok(read.clone()));
        let Incoming::Detection(detection) = read else {
            panic!("{read:?}");
        };
        assert_eq!((detection.x, detection.height), (0.5, Some(0.125)));
        assert_eq!(detection.covariance, Some([1e-4, 0.0, 1e-4]));
    }

    #[test]
    fn a_number_must_be_finite_where_it_is_needed() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let rejected = place(x).unwrap_err();
            assert_eq!(rejected.reason, Rejection::Field);
            assert_eq!(rejected.message, format!("x = {x}; expected a number"));
        }
        let uncertain = seen(|detection| {
            detection.results[0].hypothesis.score = f64::NAN;
            detection.bbox.size.x = f64::NAN;
        });
        let Ok(Incoming::Detection(uncertain)) = uncertain else {
            panic!("{uncertain:?}");
        };
        assert_eq!((uncertain.p_detection, uncertain.size), (None, None));
    }

    #[test]
    fn states_and_frames_are_named() {
        let rejected = read_robot(&RobotState {
            state: 9,
            ..RobotState::default()
        });
        let expected = "state = 9; expected 0 to 2";
        assert_eq!(rejected.unwrap_err().message, expected);
        let elsewhere = seen(|detection| detection.header.frame_id = "camera".into());
        let expected = "frame_id `camera`; expected `belt`";
        assert_eq!(elsewhere.unwrap_err().message, expected);
    }
}
