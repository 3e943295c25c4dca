//! The strategy, how long it takes, and what is wrong with its answers.

use super::latency::{DecisionTimes, Histogram};
use super::protocol::Latency;
use pickline::decision::{Action, BeltItem, Candidate, Snapshot, Strategy};
use pickline::error::{counted, shown};
use pickline::station::Station;

/// Reads a stopwatch [s]; passed in, as the controller has no clock of its own.
pub type Stopwatch = Box<dyn FnMut() -> f64 + Send>;

/// The strategy with the room that its snapshots need.
pub struct Decider {
    strategy: Box<dyn Strategy>,
    name: String,
    stopwatch: Option<Stopwatch>,
    latency: Histogram,
    /// What is wrong with the strategy's first unusable answer, until somebody asks.
    complaint: Option<String>,
    has_complained: bool,
    /// What a decision is made on, kept to be filled again.
    pub candidates: Vec<Candidate>,
    /// The free items in view, for strategies that need them.
    pub view: Vec<BeltItem>,
    /// When each robot can set out next [s].
    pub free_at: Vec<f64>,
}

impl Decider {
    /// Decides with `strategy`.
    pub fn new(strategy: Box<dyn Strategy>) -> Self {
        Self {
            name: strategy.name(),
            strategy,
            stopwatch: None,
            latency: Histogram::default(),
            complaint: None,
            has_complained: false,
            candidates: Vec::new(),
            view: Vec::new(),
            free_at: Vec::new(),
        }
    }

    /// Times the decisions from now on.
    pub fn time_with(&mut self, stopwatch: Stopwatch) {
        self.stopwatch = Some(stopwatch);
    }

    /// The strategy's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the strategy looks at the items in view.
    pub fn needs_view(&self) -> bool {
        self.strategy.needs_view()
    }

    /// What `robot` does at `time` [s] with the candidates as they are filled in.
    pub fn decide(&mut self, station: &Station, time: f64, robot: usize) -> Action {
        let snapshot = Snapshot {
            station,
            time,
            robot,
            candidates: &self.candidates,
            free_at: &self.free_at,
            in_view: &self.view,
        };
        let began = self.stopwatch.as_mut().map(|read| read());
        let action = self.strategy.decide(&snapshot);
        if let (Some(began), Some(read)) = (began, &mut self.stopwatch) {
            self.latency.note(read() - began);
        }
        action
    }

    /// Keeps what is wrong with the answer `action` for the robot of this name at `time`
    /// [s], if it is the first that is wrong.
    pub fn complain(&mut self, action: Action, robot: &str, time: f64) {
        if std::mem::replace(&mut self.has_complained, true) {
            return;
        }
        let problem = match action {
            Action::NoAnswer => self.strategy.trouble().unwrap_or_default(),
            other => {
                let count = counted(self.candidates.len(), "candidate");
                format!("{other:?} among {count}")
            }
        };
        self.complaint = Some(format!(
            "the strategy {} has no usable answer for robot `{}` at t = {time} s: {problem}\n  the \
             robot gets no task and waits; further ones are only counted, as illegal_action in \
             the status",
            self.strategy.name(),
            shown(robot),
        ));
    }

    /// What is wrong with the first answer that cannot be used, once.
    pub fn take_complaint(&mut self) -> Option<String> {
        self.complaint.take()
    }

    /// How long decisions took so far.
    pub fn latency(&self) -> Latency {
        self.latency.latency()
    }

    /// The same as counts within fixed limits.
    pub fn decision_times(&self) -> DecisionTimes {
        self.latency.decision_times()
    }
}
