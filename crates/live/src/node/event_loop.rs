//! The main loop of a node: peers, controller, journal and recording.

use super::clock::{CLOSE_TIMEOUT, NodeClock, POLL_INTERVAL, ROOM_INTERVAL, until};
use super::kept::KeptFiles;
use super::monitor::{NodeMonitor, NodeSummary, Severity};
use super::options::NodeOptions;
use crate::layout;
use crate::protocol::{
    Hello, Incoming, Message, Outgoing, PeerMessage, Rejected, Rejection, decode_said,
};
use crate::recording::{RecordedEvent, whole_microseconds};
use crate::transport::{HelloOutcome, Hub, Origin, TransportEvent};
use crate::{ClockKind, ClockReading, Controller, HandledAs};
use pickline::error::Result;
use pickline::plausible::Warning;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Maximum number of messages handled before checking again what is due.
const AT_ONCE: usize = 64;

/// The controller with its peers, files and monitor.
pub(super) struct EventLoop<'a> {
    controller: Controller,
    hub: Hub,
    clock: NodeClock,
    /// How far the machine's clock was ahead of `clock` at the last step, after being set [s].
    ahead: f64,
    kept: KeptFiles,
    monitor: &'a mut dyn NodeMonitor,
    clock_kind: ClockKind,
    /// Time between two statuses with the system clock [s]; 0 means none.
    status_every: f64,
    /// Number of peers that may still send messages.
    talking: usize,
    /// The origin of the message that the controller is holding back, if any.
    held_back: Option<Origin>,
}

impl<'a> EventLoop<'a> {
    /// A loop that has not begun.
    pub(super) fn new(
        controller: Controller,
        hub: Hub,
        kept: KeptFiles,
        monitor: &'a mut dyn NodeMonitor,
        options: &NodeOptions,
    ) -> Self {
        Self {
            controller,
            hub,
            clock: NodeClock::start(),
            ahead: 0.0,
            kept,
            monitor,
            clock_kind: options.config.clock,
            status_every: options.config.status_every,
            talking: 0,
            held_back: None,
        }
    }

    /// Runs the line until `stop` is set or no peer has more to send, reports the final status
    /// and closes everything.
    ///
    /// # Errors
    /// A peer or file error after which the line cannot continue.
    pub(super) fn run(mut self, stop: &AtomicBool) -> Result<NodeSummary> {
        let summary = self.serve(stop);
        // Messages already in the journal are still sent, even after an error.
        self.hub.close(CLOSE_TIMEOUT)?;
        self.monitor.closed(&self.controller);
        let summary = summary?;
        self.kept.finish()?;
        Ok(summary)
    }

    /// Runs the line, and then reports the final status.
    fn serve(&mut self, stop: &AtomicBool) -> Result<NodeSummary> {
        self.monitor.ready();
        if self.hub.is_stdio() {
            // Stdin and stdout are open from the start, but tasks in the journal may not have
            // been sent.
            self.welcome();
        }
        match self.clock_kind {
            ClockKind::System => self.go_by_the_clock(stop),
            ClockKind::Messages => self.go_by_the_messages(stop),
        }?;
        self.end(stop.load(Ordering::Relaxed))
    }

    /// Handles messages as they arrive and actions when they are due, until `stop` is set or
    /// stdin ends.
    fn go_by_the_clock(&mut self, stop: &AtomicBool) -> Result<()> {
        let mut next_status = self.clock.read().stamp + self.status_every;
        while !stop.load(Ordering::Relaxed) {
            self.monitor.alive();
            let now = self.step();
            if self.status_every > 0.0 && now >= next_status {
                next_status = now + self.status_every;
                self.report(false, self.hub.queued() as u64);
            }
            self.speak()?;
            self.monitor.line(&self.controller, &self.hub);
            let due = self.controller.next_stamp();
            let due = due.map_or(next_status, |due| due.min(next_status));
            let mut timeout = until(Some(due), self.clock.read().stamp);
            // Write everything received so far to the journal before waiting.
            self.kept.rest(&mut self.controller)?;
            for _ in 0..AT_ONCE {
                let Some(heard) = self.hub.next_event(timeout) else {
                    break;
                };
                timeout = Duration::ZERO;
                match heard {
                    TransportEvent::Left(0) => return Ok(()),
                    TransportEvent::Left(number) => {
                        self.hub.leave(number);
                    }
                    // Output waits until a peer reconnects.
                    TransportEvent::Down(_) => {}
                    // A peer that has closed its side waits for a last status.
                    TransportEvent::Ended(_) => self.report(false, self.hub.queued() as u64),
                    heard => self.handle(heard)?,
                }
            }
        }
        Ok(())
    }

    /// With the system clock: reads the time, does what is due, and returns the time.
    fn step(&mut self) -> f64 {
        let ClockReading { stamp, ahead } = self.clock.read();
        let mut held_robots = self.hub.held();
        self.ahead = ahead;
        self.controller.set_clock_ahead(ahead);
        self.controller.hold(&held_robots);
        self.controller.advance(stamp);
        let held = held_robots.len() == self.controller.station().robots().len();
        if held {
            held_robots.clear();
        }
        self.kept.happened(&RecordedEvent::Step {
            stamp,
            held,
            held_robots,
            ahead,
        });
        stamp
    }

    /// Handles messages until the peers have no more or `stop` is set.
    fn go_by_the_messages(&mut self, stop: &AtomicBool) -> Result<()> {
        while !stop.load(Ordering::Relaxed) {
            self.monitor.alive();
            self.monitor.line(&self.controller, &self.hub);
            match self.hub.next_event(POLL_INTERVAL) {
                None => {
                    self.kept.rest(&mut self.controller)?;
                    continue;
                }
                // A peer that was disconnected had no say in the line.
                Some(TransportEvent::Left(number)) if !self.hub.is_active(number) => {
                    self.hub.leave(number);
                    self.talking = self.talking.saturating_sub(1);
                }
                Some(
                    heard @ (TransportEvent::Left(_)
                    | TransportEvent::Down(_)
                    | TransportEvent::Ended(_)),
                ) => {
                    if matches!(heard, TransportEvent::Down(_)) {
                        let remark = "all peers have gone, which ends the run with message time";
                        self.warn(remark);
                    }
                    self.talking = self.talking.saturating_sub(1);
                    if self.talking == 0 {
                        self.controller.finish();
                        self.kept.happened(&RecordedEvent::Finished {});
                        break;
                    }
                }
                Some(heard) => self.handle(heard)?,
            }
            // Wait for a slow reader, but not once `stop` is set.
            while self.hub.is_half_full() && self.hub.peers() > 0 && !stop.load(Ordering::Relaxed) {
                self.monitor.alive();
                thread::sleep(ROOM_INTERVAL);
                self.hub.run_timers();
            }
            self.speak()?;
        }
        Ok(())
    }

    fn handle(&mut self, heard: TransportEvent) -> Result<()> {
        match heard {
            // Ignore messages from a peer that is being disconnected.
            TransportEvent::Line(origin, _)
            | TransportEvent::Message(origin, _)
            | TransportEvent::Refused(origin, _)
                if !self.hub.counts(&origin) => {}
            TransportEvent::Line(origin, line) => match decode_said(&line) {
                Ok(PeerMessage::Message(message)) => self.take(origin, message),
                Ok(PeerMessage::Hello(hello)) => self.greet(&origin, hello),
                Err(rejected) => self.refuse(&origin, &rejected),
            },
            TransportEvent::Message(origin, message) => {
                // A transport delivers to a node only what is for a node.
                if let Message::ToNode(message) = *message {
                    self.take(origin, message);
                }
            }
            TransportEvent::Refused(origin, rejected) => self.refuse(&origin, &rejected),
            TransportEvent::Joined(connection) => {
                if let Some(number) = self.hub.join(connection) {
                    self.talking += 1;
                    if self.hub.connects() {
                        self.controller.repeat();
                        self.kept.happened(&RecordedEvent::Connected {});
                    } else {
                        self.tell_open(number)?;
                    }
                }
            }
            TransportEvent::Foreign(number, start) => {
                let text = self.hub.foreign(number, &start);
                self.count(Rejection::Syntax);
                self.warn(&text);
            }
            TransportEvent::Stalled(number) => {
                if let Some(text) = self.hub.stalled(number) {
                    self.warn(&text);
                }
            }
            TransportEvent::Up(_) => self.welcome(),
            TransportEvent::Remark(text) => self.monitor.remark(Severity::Info, None, &text),
            TransportEvent::Failed(error) => return Err(error),
            TransportEvent::Left(_) | TransportEvent::Down(_) | TransportEvent::Ended(_) => {}
        }
        Ok(())
    }

    /// Passes a message to the controller, if its sender is allowed to send it.
    fn take(&mut self, origin: Origin, mut message: Incoming) {
        let robot = self.controller.robot_of(&message);
        match self.hub.admit(&origin, &message, robot) {
            Ok(true) => self.speak_for(robot),
            Ok(false) => {}
            Err(rejected) => return self.refuse(&origin, &rejected),
        }
        message.name_source(self.hub.name(&origin));
        let ClockReading { stamp, ahead } = self.clock.read();
        let received = whole_microseconds(stamp);
        let taken = match self.clock_kind {
            ClockKind::System => {
                if ahead != self.ahead {
                    // The clock was set, and this message may use its new time.
                    self.step();
                }
                self.kept.heard(&message, received);
                self.controller.hear(message, received)
            }
            ClockKind::Messages => {
                self.kept.heard(&message, received);
                self.controller.handle(message)
            }
        };
        self.tell_dropped();
        if let Some(doubt) = self.controller.take_doubt() {
            self.question(&origin, &doubt);
        }
        match taken {
            Ok(HandledAs::Accepted) => {}
            Ok(HandledAs::Held) => self.held_back = Some(origin),
            Err(rejected) => self.tell(&origin, &rejected),
        }
    }

    /// Handles a peer's hello.
    fn greet(&mut self, origin: &Origin, hello: Hello) {
        let Some(number) = Hub::connection(origin) else {
            let problem = "`hello` is only valid over TCP or stdin; a broker or a ROS graph has \
                           its own permissions";
            let rejected = Rejected::new(Rejection::NotAllowed, problem);
            return self.refuse(origin, &rejected);
        };
        match self.hub.handle_hello(number, hello) {
            HelloOutcome::Accepted(robots) => {
                for robot in robots {
                    self.speak_for(Some(robot));
                }
            }
            HelloOutcome::Refused(reason) => {
                self.count(Rejection::NotAllowed);
                let text = format!("{origin}: the hello was refused: {reason}");
                self.warn(&text);
            }
        }
    }

    /// A peer now speaks for a robot, which may not have received its open tasks.
    fn speak_for(&mut self, robot: Option<usize>) {
        if let Some(robot) = robot {
            self.controller.send_again_to(robot);
            self.kept.happened(&RecordedEvent::Spoken { robot });
        }
    }

    /// Sends the current state of the open tasks to a newly connected peer only.
    fn tell_open(&mut self, number: u64) -> Result<()> {
        self.speak()?;
        self.controller.send_open_tasks();
        self.kept.happened(&RecordedEvent::Welcomed {});
        let output = self.controller.take_output();
        self.kept.keep(&mut self.controller, !output.is_empty())?;
        for message in output {
            self.kept.said(&message);
            self.hub.send_to(number, message);
        }
        Ok(())
    }

    /// Reports a message that was held back and then refused.
    fn tell_dropped(&mut self) {
        if let Some(rejected) = self.controller.take_dropped()
            && let Some(origin) = self.held_back.take()
        {
            self.tell(&origin, &rejected);
        }
    }

    /// Warns about a value that is most likely wrong.
    fn question(&mut self, origin: &Origin, doubt: &Warning) {
        let (place, problem, cure) = (&doubt.place, &doubt.problem, &doubt.cure);
        let kind = format!("{} {place}", origin.sender());
        let text = format!("{origin}: {place}: {problem}; {cure}");
        self.monitor.remark(Severity::Warning, Some(&kind), &text);
    }

    fn tell(&mut self, origin: &Origin, rejected: &Rejected) {
        let (reason, message) = (rejected.reason.name(), &rejected.message);
        let text = format!("{origin}: refused ({reason}): {message}");
        let kind = format!("{} {reason}", origin.sender());
        self.monitor.remark(Severity::Warning, Some(&kind), &text);
    }

    /// Handles a peer that may have missed earlier output.
    fn welcome(&mut self) {
        self.talking += 1;
        self.controller.send_again();
        self.kept.happened(&RecordedEvent::Joined {});
    }

    /// Counts a line that is not a message or that its sender may not send. A peer that sends
    /// too many is disconnected.
    fn refuse(&mut self, origin: &Origin, rejected: &Rejected) {
        self.count(rejected.reason);
        self.tell(origin, rejected);
        if let Some(text) = self.hub.refuse(origin, rejected) {
            self.warn(&text);
        }
    }

    fn warn(&mut self, text: &str) {
        self.monitor.remark(Severity::Warning, None, text);
    }

    fn count(&mut self, rejection: Rejection) {
        self.controller.count_rejected(rejection);
        let reason = rejection.name().to_owned();
        self.kept.happened(&RecordedEvent::Refused { reason });
    }

    fn report(&mut self, last: bool, queued: u64) {
        self.controller.report(last, queued);
        self.kept.happened(&RecordedEvent::Report { last, queued });
    }

    /// Sends the controller's output, after the changes behind it are in the journal.
    fn speak(&mut self) -> Result<()> {
        for remark in self.controller.take_remarks() {
            self.warn(&remark);
        }
        if let Some(text) = self.kept.take_remark() {
            self.monitor.remark(Severity::Error, None, &text);
        }
        let output = self.controller.take_output();
        self.kept.keep(&mut self.controller, !output.is_empty())?;
        for message in output {
            self.kept.said(&message);
            if self.clock_kind == ClockKind::Messages {
                self.hub.send(message);
                continue;
            }
            let matters = match &message {
                Outgoing::Status(status) => {
                    self.monitor.status(status);
                    status.last
                }
                _ => true,
            };
            for title in self.hub.try_send(message, matters) {
                let text = format!("{title} did not keep up and was disconnected");
                self.warn(&text);
            }
        }
        Ok(())
    }

    /// Reports the final status.
    fn end(&mut self, stopped: bool) -> Result<NodeSummary> {
        self.monitor.stopping();
        self.controller.stop();
        self.kept.happened(&RecordedEvent::Stopped {});
        self.tell_dropped();
        // With message time, the output depends only on the messages.
        let queued = match self.clock_kind {
            ClockKind::System => self.hub.queued() as u64,
            ClockKind::Messages => 0,
        };
        self.report(true, queued);
        self.speak()?;
        let status = self.controller.status(true, 0);
        let summary = NodeSummary {
            latency: self.controller.latency(),
            status,
            stopped,
        };
        self.monitor.finished(&summary);
        layout::check_heard(self.controller.station(), &summary.status)?;
        Ok(summary)
    }
}
