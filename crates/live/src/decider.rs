//! The strategy, the durations of its decisions, and its invalid answers.

use super::latency::{DecisionTimes, DurationHistogram};
use super::protocol::Latency;
use pickline::decision::{Action, BeltItem, Candidate, Odds, Snapshot, Strategy};
use pickline::error::{counted, shown};
use pickline::station::Station;

/// Reads a stopwatch [s]. It is passed in because the controller has no clock.
pub type Stopwatch = Box<dyn FnMut() -> f64 + Send>;

/// The strategy, with reusable buffers for its snapshots.
pub(crate) struct Decider {
    strategy: Box<dyn Strategy>,
    name: String,
    stopwatch: Option<Stopwatch>,
    latency: DurationHistogram,
    /// The complaint about the strategy's first invalid answer, until it is taken.
    complaint: Option<String>,
    has_complained: bool,
    /// The candidates of a decision; a buffer that is filled again each time.
    pub candidates: Vec<Candidate>,
    /// What can go wrong with each of them.
    pub candidate_odds: Vec<Odds>,
    /// The free items in view, for strategies that use them.
    pub view: Vec<BeltItem>,
    /// When each robot can set out next [s].
    pub free_at: Vec<f64>,
    /// Buffer: where each robot's arm is then.
    pub places: Vec<u16>,
}

impl Decider {
    /// A decider that uses `strategy`.
    pub(crate) fn new(strategy: Box<dyn Strategy>) -> Self {
        Self {
            name: strategy.name(),
            strategy,
            stopwatch: None,
            latency: DurationHistogram::default(),
            complaint: None,
            has_complained: false,
            candidates: Vec::new(),
            candidate_odds: Vec::new(),
            view: Vec::new(),
            free_at: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Times the decisions from now on with `stopwatch`.
    pub(crate) fn time_with(&mut self, stopwatch: Stopwatch) {
        self.stopwatch = Some(stopwatch);
    }

    /// The strategy's name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Whether the strategy uses the items in view.
    pub(crate) fn needs_view(&self) -> bool {
        self.strategy.needs_view()
    }

    /// Decides the action of `robot` at `time` [s], with the buffers filled in.
    pub(crate) fn decide(&mut self, station: &Station, time: f64, robot: usize) -> Action {
        let snapshot = Snapshot {
            station,
            time,
            robot,
            candidates: &self.candidates,
            free_at: &self.free_at,
            places: &self.places,
            candidate_odds: &self.candidate_odds,
            in_view: &self.view,
        };
        let began = self.stopwatch.as_mut().map(|read| read());
        let action = self.strategy.decide(&snapshot);
        if let (Some(began), Some(read)) = (began, &mut self.stopwatch) {
            self.latency.note(read() - began);
        }
        action
    }

    /// Records that the answer `action` for `robot` at `time` [s] is invalid, if it is the first
    /// such answer.
    pub(crate) fn complain(&mut self, action: Action, robot: &str, time: f64) {
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
            "the strategy {} gave no valid answer for robot `{}` at t = {time} s: {problem}\n  the \
             robot gets no task and waits; further cases are only counted, as illegal_action in \
             the status",
            self.strategy.name(),
            shown(robot),
        ));
    }

    /// Takes the complaint about the first invalid answer.
    pub(crate) fn take_complaint(&mut self) -> Option<String> {
        self.complaint.take()
    }

    /// Durations of the decisions so far.
    pub(crate) fn latency(&self) -> Latency {
        self.latency.latency()
    }

    /// The same durations, as counts within fixed limits.
    pub(crate) fn decision_times(&self) -> DecisionTimes {
        self.latency.decision_times()
    }
}
