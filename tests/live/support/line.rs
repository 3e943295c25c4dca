//! A live line, message by message.
#![allow(dead_code)]

use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::protocol::{Incoming, Outgoing, Rejection, Status, Task, decode};
use pickline_live::{ClockKind, Config, Controller};

/// A line of two robots, both idle at time 0: r1 reaches y < 0 around x = 1.3, r2 y > 0
/// around x = 2.9; the belt moves at 0.05 m/s and ends at x = 4.2.
pub struct Line(pub Controller);

impl Line {
    /// A line that has heard nothing.
    pub fn silent(status_every: f64) -> Self {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
        let config = Config::default()
            .with_clock(ClockKind::Messages)
            .with_status_every(status_every);
        Self(Controller::new(station, strategy, config).unwrap())
    }

    pub fn new() -> Self {
        let mut line = Self::silent(0.0);
        line.say(r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#);
        line.say(r#""kind":"robot","stamp":0,"name":"r2","state":"idle""#);
        line
    }

    pub fn message(fields: &str) -> Incoming {
        decode(format!("{{{fields}}}").as_bytes()).unwrap()
    }

    pub fn say(&mut self, fields: &str) {
        self.0.handle(Self::message(fields)).unwrap();
    }

    pub fn refused(&mut self, fields: &str) -> Rejection {
        self.0.handle(Self::message(fields)).unwrap_err().reason
    }

    pub fn see(&mut self, stamp: f64, id: &str, x: f64, y: f64) {
        self.say(&format!(
            r#""kind":"detection","stamp":{stamp},"id":"{id}","x":{x},"y":{y}"#
        ));
    }

    pub fn ack(&mut self, stamp: f64, task: u64) {
        self.say(&format!(r#""kind":"ack","stamp":{stamp},"task":{task}"#));
    }

    pub fn result(&mut self, stamp: f64, task: u64, result: &str) {
        self.say(&format!(
            r#""kind":"result","stamp":{stamp},"task":{task},"result":"{result}""#
        ));
    }

    /// Lets time pass; returns tasks and the tasks that are cancelled.
    pub fn tick(&mut self, stamp: f64) -> (Vec<Task>, Vec<u64>) {
        self.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
        let (mut tasks, mut cancelled) = (Vec::new(), Vec::new());
        for message in self.0.take_output() {
            match message {
                Outgoing::Task(task) => tasks.push(task),
                Outgoing::Cancel(cancel) => cancelled.push(cancel.task),
                Outgoing::BeltRequest(_) | Outgoing::Status(_) | Outgoing::Due(_) => {}
            }
        }
        (tasks, cancelled)
    }

    /// The one task that is given by `stamp`.
    pub fn task(&mut self, stamp: f64) -> Task {
        let (mut tasks, cancelled) = self.tick(stamp);
        assert!(
            tasks.len() == 1 && cancelled.is_empty(),
            "{tasks:?} {cancelled:?}"
        );
        tasks.remove(0)
    }

    pub fn idle(&mut self, stamp: f64) {
        assert_eq!(self.tick(stamp), (vec![], vec![]));
    }

    pub fn status(&mut self) -> Status {
        self.0.close_picture();
        let status = self.0.status(false, 0);
        let sum = status.picked + status.missed.total() + status.on_belt + status.claimed;
        let sum = sum + status.unwanted.unwrap_or(0);
        assert_eq!(status.seen, sum, "{status:?}");
        status
    }
}
