//! `pickline emulate`.

use super::args::{EmulateArgs, StationChoice, TroubleArgs};
use super::live::{announce, stop_flag};
use super::remarks::Remarks;
use super::session::Session;
use super::settings::load_pattern;
use pickline::error::{Error, Result, shown};
use pickline::sim::Scene;
use pickline_live::ClockKind;
use pickline_live::emulator::{Emulator, InjectedFaults};
use pickline_live::layout;
use pickline_live::node::{
    CLOSE_TIMEOUT, Connections, POLL_INTERVAL, ROOM_INTERVAL, unix_now, until,
};
use pickline_live::protocol::{
    Incoming, Message, Outgoing, Status, decode_answer, decode_outgoing,
};
use pickline_live::transport::{Dialect, Hub, Side, TransportEvent};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

pub(crate) fn run(args: EmulateArgs, session: &Session) -> Result<()> {
    args.resolve(session)?.run()
}

/// A resolved call.
struct EmulatePlan {
    emulator: Emulator,
    /// Number of items in the pattern, and how many of them are to be picked.
    items: (usize, usize),
    connections: Connections,
    clock: ClockKind,
    remarks: Remarks,
}

impl EmulateArgs {
    fn resolve(self, session: &Session) -> Result<EmulatePlan> {
        let transport = &self.transport;
        let remarks = transport.remarks();
        session.log_into(remarks.log());
        let station = self.station.load()?;
        let file = self.pattern.as_ref().map(|file| file.to_string_lossy());
        if file.as_deref() == Some("-") {
            let problem = "stdin is used for the tasks";
            return Err(Error::usage(
                "--pattern",
                problem,
                "write the pattern to a file",
            ));
        }
        let (pattern, name) = load_pattern(file.as_deref(), station.belt().width)?;
        let named = file.as_deref().unwrap_or(&name);
        self.station
            .check_pattern(named, &pattern, Some(&station))?;
        let faults = self.trouble.resolve()?;
        let items = (pattern.len(), Scene::new(&station, &pattern)?.offered());
        transport
            .access
            .check(Side::Station, transport.addresses())?;
        let mut emulator = Emulator::new(station, pattern, faults)?;
        if let Some(file) = &self.true_station {
            let choice = StationChoice {
                station: file.clone(),
                ..self.station.clone()
            };
            let real = choice.load().map_err(|error| match error.place() {
                Some("'station'") => error.at("'true_station'"),
                _ => error,
            })?;
            emulator = emulator.with_true_station(&real)?;
        }
        remarks.remark(&format!(
            "playing {name} on station {}",
            self.station.station
        ));
        let station = emulator.station();
        let connections = transport.connections(Side::Station, station, Dialect::Json)?;
        Ok(EmulatePlan {
            emulator,
            items,
            connections,
            clock: transport.clock(),
            remarks,
        })
    }
}

impl EmulatePlan {
    fn run(self) -> Result<()> {
        let Connections { place, terms, .. } = self.connections;
        let is_closed = terms.access.is_closed();
        let hub = Hub::open(&place, terms)?;
        announce(&self.remarks, &place, &hub, is_closed);
        let mut play = EmulatorLoop {
            emulator: self.emulator,
            hub,
            remarks: &self.remarks,
            clock: self.clock,
            answers: true,
            deserted: false,
            status: None,
            unread: 0,
        };
        play.run(&stop_flag())?;
        self.remarks.log().sum_up();
        let (items, wanted) = self.items;
        self.remarks.remark(&play.summary(wanted));
        play.close(items)
    }
}

impl TroubleArgs {
    fn resolve(&self) -> Result<InjectedFaults> {
        let down = numbers("--robot-down", self.robot_down.as_deref())?;
        let robot_down = match down {
            Some([robot, from, time]) if robot >= 1.0 && robot.fract() == 0.0 => {
                Some((robot as usize - 1, from, time))
            }
            Some(_) => {
                let cure = "count robots from 1, upstream first";
                return Err(Error::usage("--robot-down", "there is no such robot", cure));
            }
            None => None,
        };
        let stop = numbers("--belt-stop", self.belt_stop.as_deref())?;
        Ok(InjectedFaults::default()
            .with_grasp_failures(self.failing_grasps)
            .with_lost_acks(self.lost_acks)
            .with_duplicates(self.duplicates)
            .with_out_of_order(self.out_of_order)
            .with_jitter(self.jitter_ms / 1e3)
            .with_robot_down(robot_down)
            .with_belt_stop(stop.map(|[from, time]| (from, time)))
            .with_time_noise(self.time_noise)
            .with_seed(self.seed))
    }
}

/// The `COUNT` numbers that `text`, the value of `flag`, lists.
///
/// # Errors
/// Another number of numbers, or something else.
fn numbers<const COUNT: usize>(flag: &str, text: Option<&str>) -> Result<Option<[f64; COUNT]>> {
    let Some(text) = text else {
        return Ok(None);
    };
    let parts: std::result::Result<Vec<f64>, _> =
        text.split(',').map(|part| part.trim().parse()).collect();
    let found = parts.ok().and_then(|parts| parts.try_into().ok());
    found.map(Some).ok_or_else(|| {
        Error::usage(
            flag,
            format!("`{}` is not {COUNT} numbers", shown(text)),
            "separate numbers by commas, as in --help",
        )
    })
}

/// The emulated station and its connection to the node.
struct EmulatorLoop<'a> {
    emulator: Emulator,
    hub: Hub,
    remarks: &'a Remarks,
    clock: ClockKind,
    /// Whether any peer may still answer.
    answers: bool,
    /// With message time, whether the node has gone and no longer takes its turn.
    deserted: bool,
    status: Option<Status>,
    /// Number of lines that were not messages from a node.
    unread: u64,
}

impl EmulatorLoop<'_> {
    /// Plays the whole pattern.
    fn run(&mut self, stop: &AtomicBool) -> Result<()> {
        self.wait_for_a_peer(stop)?;
        match self.clock {
            ClockKind::System => self.go_by_the_clock(stop)?,
            ClockKind::Messages => self.go_in_turns(stop)?,
        }
        self.listen_to_the_end(stop)
    }

    /// Closes the connections, and checks what the node did with the `items` of the pattern.
    ///
    /// # Errors
    /// A promise that the node broke, or no item that it saw.
    fn close(self, items: usize) -> Result<()> {
        let broken = self.emulator.broken_promises().first().cloned();
        self.hub.close(CLOSE_TIMEOUT)?;
        if let Some(promise) = broken {
            return Err(Error::refuted(promise));
        }
        match self.status {
            Some(status) if status.last && status.seen == 0 => Err(Error::usage(
                "--station",
                format!("the node saw none of the {items} items"),
                "its stderr says why it refused the detections",
            )),
            _ => Ok(()),
        }
    }

    fn wait_for_a_peer(&mut self, stop: &AtomicBool) -> Result<()> {
        while self.hub.peers() == 0 && !stop.load(Ordering::Relaxed) {
            if let Some(heard) = self.hub.next_event(POLL_INTERVAL) {
                self.handle(heard)?;
            }
        }
        Ok(())
    }

    /// Takes turns with the node, as fast as both can run.
    fn go_in_turns(&mut self, stop: &AtomicBool) -> Result<()> {
        let mut due = None;
        while !self.deserted && !stop.load(Ordering::Relaxed) {
            let messages = self.emulator.round(due);
            if messages.is_empty() {
                break;
            }
            self.say(messages, stop)?;
            due = None;
            while self.answers && !stop.load(Ordering::Relaxed) {
                let Some(heard) = self.hub.next_event(POLL_INTERVAL) else {
                    continue;
                };
                if let Some(Outgoing::Due(answer)) = self.handle(heard)? {
                    due = answer.next;
                    break;
                }
            }
        }
        Ok(())
    }

    /// Makes events happen when they are due.
    fn go_by_the_clock(&mut self, stop: &AtomicBool) -> Result<()> {
        self.emulator.start_at(unix_now());
        while !stop.load(Ordering::Relaxed) {
            let messages = self.emulator.advance(unix_now());
            self.say(messages, stop)?;
            let Some(next) = self.emulator.next_stamp() else {
                break;
            };
            let mut patience = until(Some(next), unix_now());
            while let Some(heard) = self.hub.next_event(patience) {
                patience = Duration::ZERO;
                let messages = self.emulator.advance(unix_now());
                self.say(messages, stop)?;
                self.handle(heard)?;
            }
        }
        Ok(())
    }

    /// Sends messages. If too many are waiting, the station pauses until there is room, so
    /// that no message is dropped.
    fn say(&mut self, messages: Vec<Incoming>, stop: &AtomicBool) -> Result<()> {
        for message in messages {
            while self.hub.is_full() && !self.deserted && !stop.load(Ordering::Relaxed) {
                if let Some(heard) = self.hub.next_event(ROOM_INTERVAL) {
                    self.handle(heard)?;
                }
            }
            self.hub.try_send(message, true);
        }
        Ok(())
    }

    /// Handles what is received; returns it if it is a message.
    fn handle(&mut self, heard: TransportEvent) -> Result<Option<Outgoing>> {
        match heard {
            TransportEvent::Line(_, line) => {
                let Ok(message) = decode_outgoing(&line) else {
                    self.hear_answer(&line)?;
                    return Ok(None);
                };
                return self.receive(message).map(Some);
            }
            TransportEvent::Message(_, message) => {
                // A transport delivers to a station only what is from the node.
                if let Message::FromNode(message) = *message {
                    return self.receive(message).map(Some);
                }
            }
            TransportEvent::Refused(..) => self.unread += 1,
            TransportEvent::Joined(connection) => {
                self.answers |= self.hub.join(connection).is_some();
            }
            TransportEvent::Foreign(number, start) => {
                let text = self.hub.foreign(number, &start);
                self.remarks.warn(&text);
            }
            // Only a node disconnects peers that do not keep up.
            TransportEvent::Stalled(_) => {}
            TransportEvent::Up(_) => self.answers = true,
            // With the system clock, the station continues and reports a reconnect.
            TransportEvent::Down(_) if self.clock == ClockKind::System => {}
            TransportEvent::Left(0) => self.answers = false,
            TransportEvent::Ended(_) => {
                self.answers = false;
                self.deserted = self.clock == ClockKind::Messages;
            }
            TransportEvent::Left(number) | TransportEvent::Down(number) => {
                self.hub.leave(number);
                self.answers = self.hub.peers() > 0;
            }
            TransportEvent::Remark(text) => self.remarks.remark(&text),
            TransportEvent::Failed(error) => return Err(error),
        }
        Ok(None)
    }

    /// Handles a message from the node, and returns it.
    fn receive(&mut self, message: Outgoing) -> Result<Outgoing> {
        match &message {
            Outgoing::Status(status) => {
                layout::check_status(self.emulator.station(), status)?;
                self.status = Some((**status).clone());
            }
            Outgoing::Task(task) => layout::check_task(self.emulator.station(), task)?,
            Outgoing::Cancel(_) | Outgoing::BeltRequest(_) | Outgoing::Due(_) => {}
        }
        self.emulator.receive(message.clone());
        Ok(message)
    }

    /// Handles the node's answer to the hello, if the line is one.
    fn hear_answer(&mut self, line: &[u8]) -> Result<()> {
        match decode_answer(line) {
            Some(answer) if answer.accepted => {}
            Some(answer) => {
                let reason = answer.reason.unwrap_or_default();
                let cure = "give the same --token and --station as for the node";
                let problem = format!("the node refused this station: {}", shown(&reason));
                return Err(Error::usage("--connect", problem, cure));
            }
            None => self.unread += 1,
        }
        Ok(())
    }

    /// Waits for the node's last status, which it sends after the stream to it has ended; a
    /// node that keeps running sends one stamped after the end. Stdout closes only when the
    /// program exits, so with pipes this status cannot be awaited.
    fn listen_to_the_end(&mut self, stop: &AtomicBool) -> Result<()> {
        if self.hub.is_stdio() {
            return Ok(());
        }
        let end = match self.clock {
            ClockKind::System => unix_now(),
            ClockKind::Messages => f64::INFINITY,
        };
        self.hub.finish_writing();
        while self.answers && !stop.load(Ordering::Relaxed) {
            if let Some(heard) = self.hub.next_event(POLL_INTERVAL) {
                self.handle(heard)?;
            }
            let status = self.status.as_ref();
            if status.is_some_and(|status| status.last || status.stamp >= end) {
                break;
            }
        }
        Ok(())
    }

    /// What came of it; `wanted` items of the pattern are to be picked.
    fn summary(&self, wanted: usize) -> String {
        let bins = self.emulator.picked().len();
        let mut text = format!("{bins} of {wanted} items in the bins");
        let stranded = self.emulator.stranded();
        if stranded > 0 {
            text += &format!(", {stranded} in the grippers of robots that broke down");
        }
        if let Some(status) = &self.status {
            text += &format!(
                "; the node reports {} of {} picked, {} missed{}",
                status.picked,
                status.wanted(),
                status.missed.total(),
                status.unwanted_words()
            );
            let unknown = status.missed.no_result;
            if unknown > 0 {
                text += &format!(", {unknown} of them without a result (some may be in the bins)");
            }
        }
        if self.deserted {
            text += "; the node left before the end";
        }
        if self.unread > 0 {
            text += &format!("; {} lines were not messages from a node", self.unread);
        }
        text
    }
}
