//! A run as a table with one line per event.

use crate::decision::{Action, Event, Observer};
use crate::pattern::Pattern;
use crate::station::Station;

/// Collects every event of a run, in order of time.
#[derive(Debug)]
pub struct Trace<'a> {
    station: &'a Station,
    pattern: &'a Pattern,
    rows: Vec<[String; 6]>,
}

impl<'a> Trace<'a> {
    /// The columns of the table. Times are in s and positions in m. `candidates` is the number of
    /// items that the robot could choose from. `until_s` is the time until which it waits or
    /// returns from a failed grasp.
    pub const COLUMNS: [&'static str; 6] =
        ["time_s", "event", "robot", "item", "candidates", "until_s"];

    /// An empty trace of a run of `pattern` on `station`.
    pub fn new(station: &'a Station, pattern: &'a Pattern) -> Self {
        Self {
            station,
            pattern,
            rows: Vec::new(),
        }
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let header = std::iter::once(Self::COLUMNS.map(str::to_owned));
        crate::files::csv_text(header.chain(self.rows.iter().cloned()))
    }

    fn push(&mut self, time: f64, event: &str, robot: Option<usize>, item: Option<u32>) {
        let robot = robot.map(|r| self.station.robots()[r].name.clone());
        let item = item.map(|i| self.pattern.items()[i as usize].id.clone());
        self.rows.push([
            time.to_string(),
            event.to_owned(),
            robot.unwrap_or_default(),
            item.unwrap_or_default(),
            String::new(),
            String::new(),
        ]);
    }
}

impl Observer for Trace<'_> {
    fn observe(&mut self, event: &Event) {
        match *event {
            Event::Decision { snapshot, action } => {
                let (name, item, until) = match action {
                    Action::Pick(place) => ("decide", Some(snapshot.candidates[place].item), None),
                    Action::WaitUntil(time) => ("wait", None, Some(time)),
                    Action::WaitForNextWindow | Action::NoAnswer => ("wait", None, None),
                };
                self.push(snapshot.time, name, Some(snapshot.robot), item);
                if let Some(row) = self.rows.last_mut() {
                    row[4] = snapshot.candidates.len().to_string();
                    row[5] = until.map(|time| time.to_string()).unwrap_or_default();
                }
            }
            Event::Grasp { time, robot, item } => {
                self.push(time, "grasp", Some(robot), Some(item));
            }
            Event::Release { time, robot, item } => {
                self.push(time, "release", Some(robot), Some(item));
            }
            Event::GraspFailed {
                time,
                robot,
                item,
                free,
            } => {
                self.push(time, "grasp_failed", Some(robot), Some(item));
                if let Some(row) = self.rows.last_mut() {
                    row[5] = free.to_string();
                }
            }
            Event::RobotDown { time, robot } => self.push(time, "robot_down", Some(robot), None),
            Event::RobotUp { time, robot } => self.push(time, "robot_up", Some(robot), None),
            Event::LeftBelt { time, item } => self.push(time, "left_belt", None, Some(item)),
        }
    }
}
