//! The moves of the robots in a recording, from which their travel-time laws are fitted.
//!
//! A task says when and from where a robot leaves and where its item then is, and the result when the
//! item was in the bin, or when a grasp had failed. When the grasp began is not reported: the item has
//! moved on until then.

use super::{RecordingEntry, RecordingReader};
use crate::protocol::{
    Incoming, Outgoing, ResultMessage, RobotState, Task, Verdict, decode_outgoing,
};
use nalgebra::Point2;
use pickline::error::{Error, Result, listed, shown};
use pickline::fit::{Chased, TimedMove};
use pickline::station::Station;
use std::collections::{BTreeSet, HashMap};

/// Relative change of the belt's speed during a move from which on it is not used.
const BELT_CHANGE: f64 = 0.01;

/// The moves of a recording.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct RecordedMoves {
    /// The moves in the order of their results. Their lines are the ids of the tasks.
    pub moves: Vec<TimedMove>,
    /// Number of tasks that were picked or whose grasp failed but that are not used: it is not known
    /// from where the robot left, the belt changed its speed, or the station has no such robot.
    pub unused: usize,
}

/// A task that has no result yet.
struct OpenTask {
    task: Task,
    /// When the robot acknowledged it [s].
    acknowledged: Option<f64>,
    /// Slowest and fastest belt since it was given [m/s].
    belt: (f64, f64),
}

/// What is known while a recording is read.
struct MovesInMaking<'s> {
    station: &'s Station,
    belt_speed: f64,
    /// Where each arm is when it is free, if that is known [m].
    places: Vec<Option<Point2<f64>>>,
    open: HashMap<u64, OpenTask>,
    /// The robots of tasks that the station does not have.
    strangers: BTreeSet<String>,
    read: RecordedMoves,
}

/// Reads the moves of the robots of `station` from a recording.
///
/// # Errors
/// As for [`RecordingReader::next_entry`]; no move that can be used.
pub fn read_recorded_moves(
    reader: &mut RecordingReader,
    station: &Station,
) -> Result<RecordedMoves> {
    // After a restart the arms may be anywhere.
    let is_fresh = reader.state.is_none();
    let rests = station
        .robots()
        .iter()
        .map(|robot| is_fresh.then_some(robot.rest));
    let mut making = MovesInMaking {
        station,
        belt_speed: station.belt().speed,
        places: rests.collect(),
        open: HashMap::new(),
        strangers: BTreeSet::new(),
        read: RecordedMoves::default(),
    };
    while let Some(entry) = reader.next_entry()? {
        match entry {
            RecordingEntry::In(message, _) => making.hear(&message),
            RecordingEntry::Out(line) => making.say(&line),
            RecordingEntry::Event(_) => {}
        }
    }
    making.check()?;
    Ok(making.read)
}

impl MovesInMaking<'_> {
    /// Checks that there is a move.
    fn check(&self) -> Result<()> {
        if !self.read.moves.is_empty() {
            return Ok(());
        }
        let quoted = |name: &str| format!("`{}`", shown(name));
        let (problem, cure) = match (self.strangers.is_empty(), self.read.unused) {
            (false, _) => {
                let theirs: Vec<String> = self.strangers.iter().map(|name| quoted(name)).collect();
                let own = self.station.robots().iter();
                let own: Vec<String> = own.map(|robot| quoted(&robot.name)).collect();
                (
                    format!(
                        "they are of {}, but the station has {}",
                        listed(&theirs),
                        listed(&own)
                    ),
                    "leave 'station' out, so that the recording's own is used, or give one with these \
                     robots",
                )
            }
            (true, 0) => (
                "no task has a result".to_owned(),
                "record a line that picks",
            ),
            (true, unused) => (
                format!(
                    "none of the {unused} that have a result can be used: it is not known from where \
                     the robot left, or the belt changed its speed"
                ),
                "record longer, from the start of the run, with a steady belt",
            ),
        };
        Err(Error::input("its tasks", problem, cure))
    }

    fn say(&mut self, line: &str) {
        if let Ok(Outgoing::Task(task)) = decode_outgoing(line.as_bytes()) {
            let before = self.open.remove(&task.id);
            let open = OpenTask {
                acknowledged: before.as_ref().and_then(|open| open.acknowledged),
                belt: before.map_or((self.belt_speed, self.belt_speed), |open| open.belt),
                task,
            };
            self.open.insert(open.task.id, open);
        }
    }

    fn hear(&mut self, message: &Incoming) {
        match message {
            Incoming::Belt(belt) => {
                self.belt_speed = belt.speed;
                for open in self.open.values_mut() {
                    open.belt = (open.belt.0.min(belt.speed), open.belt.1.max(belt.speed));
                }
            }
            Incoming::Ack(ack) => {
                if let Some(open) = self.open.get_mut(&ack.task) {
                    open.acknowledged.get_or_insert(ack.stamp);
                }
            }
            Incoming::Robot(status) if status.state == RobotState::Fault => {
                if let Some(robot) = self.index_of(&status.name) {
                    self.places[robot] = None;
                }
            }
            Incoming::Result(result) => self.conclude(result),
            _ => {}
        }
    }

    fn index_of(&self, name: &str) -> Option<usize> {
        let mut robots = self.station.robots().iter();
        robots.position(|robot| robot.name == name)
    }

    /// Enters the move of a task that is over.
    fn conclude(&mut self, result: &ResultMessage) {
        let Some(open) = self.open.remove(&result.task) else {
            return;
        };
        let Some(robot) = self.index_of(&open.task.robot) else {
            self.read.unused += 1;
            self.strangers.insert(open.task.robot);
            return;
        };
        let bin = Point2::new(open.task.bin.x, open.task.bin.y);
        let from = self.places[robot];
        match result.result {
            Verdict::Picked | Verdict::GraspFail | Verdict::Missed => {
                self.places[robot] = Some(bin);
            }
            // It has not set out, or has returned to where it was.
            Verdict::Rejected | Verdict::Cancelled => return,
        }
        if result.result == Verdict::Missed {
            return;
        }
        let (slow, fast) = open.belt;
        let is_steady = slow > 0.0 && fast - slow <= BELT_CHANGE * fast;
        match from.filter(|_| is_steady) {
            Some(from) => {
                let belt = Chased::new(fast, self.station.belt().length);
                let row = recorded_move(robot, &open, from, belt, result);
                self.read.moves.push(row);
            }
            None => self.read.unused += 1,
        }
    }
}

/// The move of a task with this result, by the robot with this index and from this place [m].
fn recorded_move(
    robot: usize,
    open: &OpenTask,
    from: Point2<f64>,
    belt: Chased,
    result: &ResultMessage,
) -> TimedMove {
    let task = &open.task;
    // A robot that hears of a task too late leaves when it acknowledges it.
    let depart = open
        .acknowledged
        .map_or(task.start, |stamp| stamp.max(task.start));
    let x = task.meet.x - belt.belt_speed * (task.meet_at - depart);
    let mut row = TimedMove::new(robot, task.id, from, Point2::new(x, task.meet.y));
    row.depart = Some(depart);
    row.bin = Some(Point2::new(task.bin.x, task.bin.y));
    row.chased = Some(belt);
    match result.result {
        Verdict::Picked => row.release = Some(result.stamp),
        _ => row.failed = Some(result.stamp),
    }
    row
}
