//! What happens when at an emulated station.

use super::trouble::{FaultDraw, InjectedFaults};
use crate::protocol::Incoming;
use crate::windows::TimeKey;
use std::collections::BTreeMap;

/// An event at the station.
// Events are passed on one at a time.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub(super) enum EmulatorEvent {
    /// A message arrives at the node.
    Arrives(Incoming),
    /// The next belt message is due.
    Belt,
    /// The belt stops or restarts.
    BeltTurns,
    /// A robot (index) breaks down (true) or returns to service.
    Down(usize, bool),
    /// A robot meets the item of a task (id), by this revision of it.
    Meets(u64, u32),
    /// A robot (index) is back at its bin after a task (id).
    Back(usize, u64),
    /// The last item has left the belt.
    End,
}

/// The time and the events to come. Events at equal times happen in the order in which they were
/// scheduled.
#[derive(Debug)]
pub(super) struct EmulatorSchedule {
    /// How long messages are delayed.
    faults: InjectedFaults,
    now: f64,
    events: BTreeMap<TimeKey, EmulatorEvent>,
    /// Number of events so far.
    sequence: u32,
    /// Number of messages so far.
    sent: u64,
}

impl EmulatorSchedule {
    /// An empty schedule at time 0.
    pub(super) fn new(faults: InjectedFaults) -> Self {
        Self {
            faults,
            now: 0.0,
            events: BTreeMap::new(),
            sequence: 0,
            sent: 0,
        }
    }

    /// The present time [s].
    pub(super) fn now(&self) -> f64 {
        self.now
    }

    /// Schedules an event at `time` [s].
    pub(super) fn add(&mut self, time: f64, event: EmulatorEvent) {
        self.sequence += 1;
        self.events.insert(TimeKey(time, self.sequence), event);
    }

    /// Schedules the arrival of a message that is sent to the node at `time` [s].
    pub(super) fn send_at(&mut self, time: f64, message: Incoming) {
        let arrives = time + self.jitter();
        self.add(arrives, EmulatorEvent::Arrives(message));
    }

    /// Sends a message to the node now.
    pub(super) fn send(&mut self, message: Incoming) {
        self.send_at(self.now, message);
    }

    /// Delay of the next message [s].
    fn jitter(&mut self) -> f64 {
        self.sent += 1;
        if self.faults.jitter == 0.0 {
            return 0.0;
        }
        self.faults.jitter * self.faults.draw(FaultDraw::Jitter, self.sent)
    }

    /// Time of the first event that `counts` [s].
    pub(super) fn first(&self, counts: impl Fn(&EmulatorEvent) -> bool) -> Option<f64> {
        let mut events = self.events.iter();
        let found = events.find(|(_, event)| counts(event));
        found.map(|(key, _)| key.0)
    }

    /// Takes the next event up to `until` [s] and sets the time to it. If there is none, the time
    /// is `until`.
    pub(super) fn take_until(&mut self, until: f64) -> Option<EmulatorEvent> {
        let first = self.events.first_entry();
        let Some(first) = first.filter(|first| first.key().0 <= until) else {
            self.now = self.now.max(until);
            return None;
        };
        let (key, event) = first.remove_entry();
        self.now = self.now.max(key.0);
        Some(event)
    }
}
