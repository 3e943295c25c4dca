//! Conversion of messages from the node to and from ROS messages.

use super::incoming::{finite, header};
use super::messages::{Count, Due, LineStatus, Point, RobotFigures, Task, TaskCancel, Time};
use crate::protocol::{
    self, Cancel, Latency, MissedCounts, Outgoing, Rejected, RobotCounts, Status,
};
use std::collections::BTreeMap;

/// Milliseconds per second.
const MS: f64 = 1e3;

fn point(place: protocol::BeltPoint) -> Point {
    Point {
        x: place.x,
        y: place.y,
        z: 0.0,
    }
}

fn read_point(field: &str, place: &Point) -> Result<protocol::BeltPoint, Rejected> {
    Ok(protocol::BeltPoint {
        x: finite(field, place.x)?,
        y: finite(field, place.y)?,
    })
}

/// A task as a ROS message.
pub(crate) fn task(task: &protocol::Task, frame: &str) -> Task {
    Task {
        header: header(frame, task.decided_at),
        id: task.id,
        revision: task.revision,
        robot: task.robot.clone(),
        item: task.item.clone(),
        start: Time::from_stamp(task.start),
        earliest_start: Time::from_stamp(task.earliest_start),
        latest_start: Time::from_stamp(task.latest_start),
        meet_at: Time::from_stamp(task.meet_at),
        meet: point(task.meet),
        bin: point(task.bin),
        bin_name: task.bin_name.clone().unwrap_or_default(),
        free_at: Time::from_stamp(task.free_at),
        priority: task.priority,
        strategy: task.strategy.clone(),
        item_class: task.class.clone().unwrap_or_default(),
        has_angle: task.angle.is_some(),
        angle: task.angle.unwrap_or(0.0),
        height: task.height.unwrap_or(0.0),
        length: task.size.map_or(0.0, |[length, _]| length),
        width: task.size.map_or(0.0, |[_, width]| width),
        // Values that were parsed can be serialized.
        data: task.data.as_ref().map_or(String::new(), |data| {
            serde_json::to_string(data).unwrap_or_default()
        }),
    }
}

/// Reads a task.
///
/// # Errors
/// A value that must be a number is infinite or NaN.
pub(crate) fn read_task(task: &Task) -> Result<Outgoing, Rejected> {
    let size = Some([task.length, task.width]).filter(|size| *size != [0.0; 2]);
    for side in size.into_iter().flatten() {
        finite("size", side)?;
    }
    Ok(Outgoing::Task(protocol::Task {
        id: task.id,
        revision: task.revision,
        robot: task.robot.clone(),
        item: task.item.clone(),
        decided_at: task.header.stamp.stamp(),
        start: task.start.stamp(),
        earliest_start: task.earliest_start.stamp(),
        latest_start: task.latest_start.stamp(),
        meet_at: task.meet_at.stamp(),
        meet: read_point("meet", &task.meet)?,
        bin: read_point("bin", &task.bin)?,
        bin_name: Some(task.bin_name.clone()).filter(|name| !name.is_empty()),
        free_at: task.free_at.stamp(),
        priority: finite("priority", task.priority)?,
        strategy: task.strategy.clone(),
        class: Some(task.item_class.clone()).filter(|class| !class.is_empty()),
        angle: Some(task.angle).filter(|angle| task.has_angle && angle.is_finite()),
        height: Some(task.height).filter(|height| *height > 0.0 && height.is_finite()),
        size,
        data: serde_json::from_str(&task.data).ok(),
    }))
}

/// A cancel as a ROS message.
pub(crate) fn cancel(cancel: &Cancel, frame: &str) -> TaskCancel {
    TaskCancel {
        header: header(frame, cancel.stamp),
        task: cancel.task,
        robot: cancel.robot.clone(),
        reason: cancel.reason.clone(),
    }
}

/// Reads a cancel.
pub(crate) fn read_cancel(cancel: &TaskCancel) -> Outgoing {
    Outgoing::Cancel(Cancel {
        stamp: cancel.header.stamp.stamp(),
        task: cancel.task,
        robot: cancel.robot.clone(),
        reason: cancel.reason.clone(),
    })
}

fn counts(counts: &BTreeMap<String, u64>) -> Vec<Count> {
    let counts = counts.iter();
    counts
        .map(|(what, count)| Count {
            what: what.clone(),
            count: *count,
        })
        .collect()
}

fn read_counts(counts: &[Count]) -> BTreeMap<String, u64> {
    let counts = counts.iter();
    counts
        .map(|count| (count.what.clone(), count.count))
        .collect()
}

/// A status as a ROS message.
pub(crate) fn status(status: &Status, frame: &str) -> LineStatus {
    let robots = status.robots.iter();
    let latency = status.latency;
    let quantile = |of: fn(&Latency) -> f64| latency.as_ref().map_or(0.0, of) / MS;
    LineStatus {
        header: header(frame, status.stamp),
        last: status.last,
        mode: status.mode.clone(),
        seen: status.seen,
        picked: status.picked,
        picked_share: status.picked_share,
        picks_per_min: status.picks_per_min,
        missed_unreachable: status.missed.unreachable,
        missed_grasp_failed: status.missed.grasp_failed,
        missed_not_found: status.missed.not_found,
        missed_no_result: status.missed.no_result,
        missed_passed_over: status.missed.passed_over,
        missed_busy: status.missed.busy,
        on_belt: status.on_belt,
        claimed: status.claimed,
        unwanted: status.unwanted.unwrap_or(0),
        open_tasks: status.open_tasks.clone(),
        queued: status.queued,
        rejected: counts(&status.rejected),
        noted: counts(&status.noted),
        robots: robots
            .map(|robot| RobotFigures {
                name: robot.name.clone(),
                state: robot.state.clone(),
                picked: robot.picked,
                failed: robot.failed,
                missed: robot.missed,
            })
            .collect(),
        decisions: latency.map_or(0, |latency| latency.decisions),
        latency_p50: quantile(|latency| latency.p50_ms),
        latency_p99: quantile(|latency| latency.p99_ms),
        latency_max: quantile(|latency| latency.max_ms),
    }
}

/// Reads a status.
///
/// # Errors
/// A value that must be a number is infinite or NaN.
pub(crate) fn read_status(status: &LineStatus) -> Result<Outgoing, Rejected> {
    let robots = status.robots.iter();
    let latency = Latency {
        decisions: status.decisions,
        p50_ms: finite("latency_p50", status.latency_p50)? * MS,
        p99_ms: finite("latency_p99", status.latency_p99)? * MS,
        max_ms: finite("latency_max", status.latency_max)? * MS,
    };
    Ok(Outgoing::Status(Box::new(Status {
        stamp: status.header.stamp.stamp(),
        last: status.last,
        layout: None,
        mode: status.mode.clone(),
        seen: status.seen,
        picked: status.picked,
        picked_share: finite("picked_share", status.picked_share)?,
        picks_per_min: finite("picks_per_min", status.picks_per_min)?,
        missed: MissedCounts {
            unreachable: status.missed_unreachable,
            grasp_failed: status.missed_grasp_failed,
            not_found: status.missed_not_found,
            no_result: status.missed_no_result,
            passed_over: status.missed_passed_over,
            busy: status.missed_busy,
        },
        on_belt: status.on_belt,
        claimed: status.claimed,
        unwanted: Some(status.unwanted).filter(|unwanted| *unwanted > 0),
        open_tasks: status.open_tasks.clone(),
        queued: status.queued,
        rejected: read_counts(&status.rejected),
        noted: read_counts(&status.noted),
        robots: robots
            .map(|robot| RobotCounts {
                name: robot.name.clone(),
                state: robot.state.clone(),
                picked: robot.picked,
                failed: robot.failed,
                missed: robot.missed,
            })
            .collect(),
        sources: Vec::new(),
        latency: Some(latency),
    })))
}

/// The end of the node's turn of `messages` messages; without a `due` it is the last turn.
pub(crate) fn due(due: Option<&protocol::Due>, messages: u32, frame: &str) -> Due {
    let next = due.and_then(|due| due.next);
    Due {
        header: header(frame, due.map_or(0.0, |due| due.stamp)),
        has_next: next.is_some(),
        next: Time::not_before(next.unwrap_or(0.0)),
        messages,
        last: due.is_none(),
    }
}

/// Reads the end of the node's turn.
pub(crate) fn read_due(due: &Due) -> Outgoing {
    Outgoing::Due(protocol::Due {
        stamp: due.header.stamp.stamp(),
        next: due.has_next.then(|| due.next.stamp()),
    })
}
