//! The main loop of `pickline run`: peers, controller, journal, recording and dashboard.

use super::args::TransportArgs;
use super::dashboard::Screen;
use super::kept::Kept;
use super::live::{BREATH, GLANCE, NodeClock, until};
use super::log::Level;
use super::notify::Notify;
use pickline::error::Result;
use pickline::plausible::Warning;
use pickline_live::layout;
use pickline_live::protocol::{
    Hello, Incoming, Message, Outgoing, PeerMessage, Rejected, Rejection, decode_said,
};
use pickline_live::recording::{RecordedEvent, whole_microseconds};
use pickline_live::transport::{HelloOutcome, Hub, Origin, TransportEvent};
use pickline_live::{ClockKind, ClockReading, Controller, HandledAs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Maximum number of messages handled before checking again what is due.
const AT_ONCE: usize = 64;

/// The controller with its peers, journal, recording and dashboard.
pub struct Node<'a> {
    /// Makes the decisions.
    pub controller: Controller,
    /// The connections to the peers.
    pub hub: Hub,
    /// The clock of the line.
    pub clock: NodeClock,
    /// How far the machine's clock was ahead of `clock` at the last step, after being set [s].
    pub ahead: f64,
    /// The journal and the recording.
    pub kept: Kept,
    /// The service manager, which expects keep-alives.
    pub notify: Notify,
    /// The dashboard.
    pub screen: Screen,
    /// The transport settings, which also decide about remarks.
    pub transport: &'a TransportArgs,
    /// Number of peers that may still send messages.
    pub talking: usize,
    /// The origin of the message that the controller is holding back, if any.
    pub held_back: Option<Origin>,
    /// Time between two statuses with the system clock [s]; 0 means none.
    pub status_every: f64,
}

impl Node<'_> {
    /// Runs the line until `stop` is set or no peer has more to send, then reports the final
    /// status.
    ///
    /// # Errors
    /// A peer or journal error after which the line cannot continue.
    pub fn go(&mut self, stop: &AtomicBool) -> Result<()> {
        self.notify.ready();
        if self.hub.is_stdio() {
            // Stdin and stdout are open from the start, but tasks in the journal may not have
            // been sent.
            self.welcome();
        }
        match self.transport.clock() {
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
            self.notify.alive();
            let now = self.step();
            if self.status_every > 0.0 && now >= next_status {
                next_status = now + self.status_every;
                self.report(false, self.hub.queued() as u64);
            }
            self.speak()?;
            self.screen.show(&self.controller, &self.hub);
            let due = self.controller.next_stamp();
            let due = due.map_or(next_status, |due| due.min(next_status));
            let mut patience = until(Some(due), self.clock.read().stamp);
            // Write everything received so far to the journal before waiting.
            self.kept.rest(&mut self.controller)?;
            for _ in 0..AT_ONCE {
                let Some(heard) = self.hub.next_event(patience) else {
                    break;
                };
                patience = Duration::ZERO;
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
            self.notify.alive();
            self.screen.show(&self.controller, &self.hub);
            match self.hub.next_event(GLANCE) {
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
                        self.transport.warn(remark);
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
                self.notify.alive();
                thread::sleep(BREATH);
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
                self.transport.warn(&text);
            }
            TransportEvent::Stalled(number) => {
                if let Some(text) = self.hub.stalled(number) {
                    self.transport.warn(&text);
                }
            }
            TransportEvent::Up(_) => self.welcome(),
            TransportEvent::Remark(text) => self.transport.remark(&text),
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
        let taken = match self.transport.clock() {
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
                self.transport.warn(&text);
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
    fn question(&self, origin: &Origin, doubt: &Warning) {
        let (place, problem, cure) = (&doubt.place, &doubt.problem, &doubt.cure);
        let kind = format!("{} {place}", origin.sender());
        let text = format!("{origin}: {place}: {problem}; {cure}");
        self.transport.say(Level::Warning, &kind, &text);
    }

    fn tell(&self, origin: &Origin, rejected: &Rejected) {
        let (reason, message) = (rejected.reason.name(), &rejected.message);
        let text = format!("{origin}: refused ({reason}): {message}");
        let kind = format!("{} {reason}", origin.sender());
        self.transport.say(Level::Warning, &kind, &text);
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
            self.transport.warn(&text);
        }
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
            self.transport.warn(&remark);
        }
        let output = self.controller.take_output();
        self.kept.keep(&mut self.controller, !output.is_empty())?;
        for message in output {
            self.kept.said(&message);
            if self.transport.clock() == ClockKind::Messages {
                self.hub.send(message);
                continue;
            }
            let matters = match &message {
                Outgoing::Status(status) => {
                    let (picked, seen) = (status.picked, status.seen);
                    self.notify
                        .status(&format!("{picked} of {seen} items picked"));
                    status.last
                }
                _ => true,
            };
            for title in self.hub.try_send(message, matters) {
                let text = format!("{title} did not keep up and was disconnected");
                self.transport.warn(&text);
            }
        }
        Ok(())
    }

    /// Reports the final status.
    fn end(&mut self, stopped: bool) -> Result<()> {
        self.notify.stopping();
        self.controller.stop();
        self.kept.happened(&RecordedEvent::Stopped {});
        self.tell_dropped();
        // With message time, the output depends only on the messages.
        let queued = match self.transport.clock() {
            ClockKind::System => self.hub.queued() as u64,
            ClockKind::Messages => 0,
        };
        self.report(true, queued);
        self.speak()?;
        let status = self.controller.status(true, 0);
        // Print pending summaries before the final statistics.
        self.transport.log().sum_up();
        let latency = self.controller.latency();
        if stopped && !status.open_tasks.is_empty() {
            let open: Vec<String> = status.open_tasks.iter().map(u64::to_string).collect();
            self.transport
                .remark(&format!("stopped; open tasks: {}", open.join(", ")));
        }
        self.transport.remark(&format!(
            "{} of {} items picked, {} missed, {} on the belt, {} claimed; {} decisions, \
             p50 {:.3} ms, p99 {:.3} ms, max {:.3} ms",
            status.picked,
            status.seen,
            status.missed.total(),
            status.on_belt,
            status.claimed,
            latency.decisions,
            latency.p50_ms,
            latency.p99_ms,
            latency.max_ms,
        ));
        layout::check_heard(self.controller.station(), &status)
    }
}
