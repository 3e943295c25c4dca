//! `pickline emulate`.

use super::args::{EmulateArgs, TroubleArgs};
use super::live::{GLANCE, PATIENCE, stop_flag, unix_now, until};
use super::session::Session;
use super::settings::load_pattern;
use crate::error::{Error, Result, shown};
use crate::live::ClockKind;
use crate::live::emulator::{Emulator, Trouble};
use crate::live::protocol::{Outgoing, Status, decode_outgoing, encode};
use crate::live::transport::{Heard, Hub};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

pub fn run(args: &EmulateArgs, _session: &Session) -> Result<()> {
    let station = args.station.load()?;
    let width = station.belt().width;
    let file = args.pattern.as_ref().map(|file| file.to_string_lossy());
    if file.as_deref() == Some("-") {
        let cure = "write the pattern into a file";
        return Err(Error::input("--pattern", "stdin carries the tasks", cure));
    }
    let (pattern, name) = load_pattern(file.as_deref(), width)?;
    let trouble = args.trouble.resolve()?;
    let items = pattern.len();
    let emulator = Emulator::new(station, pattern, trouble)?;
    args.transport.remark(&format!(
        "playing {name} on station {}",
        args.station.station
    ));
    let mut play = Play {
        emulator,
        hub: args.transport.open()?,
        answers: true,
        status: None,
        unread: 0,
    };
    let stop = stop_flag();
    play.wait_for_a_peer(&stop);
    match args.transport.clock() {
        ClockKind::System => play.go_by_the_clock(&stop),
        ClockKind::Messages => play.go_in_turns(&stop),
    }
    play.listen_to_the_end(&stop);
    args.transport.remark(&play.summary(items));
    let broken = play.emulator.broken_promises().first().cloned();
    play.hub.close(PATIENCE);
    match broken {
        Some(promise) => Err(Error::Refuted(promise)),
        None => Ok(()),
    }
}

impl TroubleArgs {
    fn resolve(&self) -> Result<Trouble> {
        let numbers =
            |flag: &str, text: &Option<String>, count: usize| -> Result<Option<Vec<f64>>> {
                let Some(text) = text else {
                    return Ok(None);
                };
                let parts: Vec<f64> = text
                    .split(',')
                    .filter_map(|part| part.trim().parse().ok())
                    .collect();
                if parts.len() == count && text.split(',').count() == count {
                    return Ok(Some(parts));
                }
                let problem = format!("`{}` is not {count} numbers", shown(text));
                Err(Error::input(
                    flag,
                    problem,
                    "separate numbers by commas, as in --help",
                ))
            };
        let down = numbers("--robot-down", &self.robot_down, 3)?;
        let robot_down = match down.as_deref() {
            Some([robot, from, time]) if *robot >= 1.0 && robot.fract() == 0.0 => {
                Some((*robot as usize - 1, *from, *time))
            }
            Some(_) => {
                let cure = "count robots from 1, upstream first";
                return Err(Error::input("--robot-down", "there is no such robot", cure));
            }
            None => None,
        };
        let stop = numbers("--belt-stop", &self.belt_stop, 2)?;
        Ok(Trouble {
            grasp_failures: self.failing_grasps,
            lost_acks: self.lost_acks,
            duplicates: self.duplicates,
            out_of_order: self.out_of_order,
            jitter: self.jitter_ms / 1e3,
            robot_down,
            belt_stop: stop.map(|stop| (stop[0], stop[1])),
            seed: self.seed,
        })
    }
}

/// The emulated station with whoever controls it.
struct Play {
    emulator: Emulator,
    hub: Hub,
    /// Whether anybody may still answer.
    answers: bool,
    status: Option<Status>,
    /// Lines that are no messages from a node.
    unread: u64,
}

impl Play {
    fn wait_for_a_peer(&mut self, stop: &AtomicBool) {
        while self.hub.peers() == 0 && !stop.load(Ordering::Relaxed) {
            if let Some(Heard::Joined(stream)) = self.hub.hear(GLANCE) {
                // One that has gone already is noticed when it is read.
                let _ = self.hub.join(stream);
            }
        }
    }

    /// Takes turns with the node, as fast as both can.
    fn go_in_turns(&mut self, stop: &AtomicBool) {
        let mut due = None;
        while !stop.load(Ordering::Relaxed) {
            let messages = self.emulator.round(due);
            if messages.is_empty() {
                return;
            }
            for message in &messages {
                self.hub.send(&encode(message));
            }
            due = None;
            while self.answers && !stop.load(Ordering::Relaxed) {
                let Some(heard) = self.hub.hear(GLANCE) else {
                    continue;
                };
                if let Some(Outgoing::Due(answer)) = self.heed(heard) {
                    due = answer.next;
                    break;
                }
            }
        }
    }

    /// Lets things happen when they are due.
    fn go_by_the_clock(&mut self, stop: &AtomicBool) {
        self.emulator.start_at(unix_now());
        while !stop.load(Ordering::Relaxed) {
            for message in self.emulator.advance(unix_now()) {
                self.hub.send(&encode(&message));
            }
            let Some(next) = self.emulator.next_stamp() else {
                return;
            };
            let mut patience = until(Some(next));
            while let Some(heard) = self.hub.hear(patience) {
                patience = Duration::ZERO;
                for message in self.emulator.advance(unix_now()) {
                    self.hub.send(&encode(&message));
                }
                self.heed(heard);
            }
        }
    }

    /// Takes in what is heard; returns the message, if it is one.
    fn heed(&mut self, heard: Heard) -> Option<Outgoing> {
        match heard {
            Heard::Line(_, line) => {
                let Ok(message) = decode_outgoing(&line) else {
                    self.unread += 1;
                    return None;
                };
                if let Outgoing::Status(status) = &message {
                    self.status = Some((**status).clone());
                }
                self.emulator.receive(message.clone());
                return Some(message);
            }
            Heard::TooLong(_) => self.unread += 1,
            Heard::Joined(stream) => {
                let _ = self.hub.join(stream);
                self.answers = true;
            }
            Heard::Left(0) => self.answers = false,
            Heard::Left(number) => {
                self.hub.leave(number);
                self.answers = self.hub.peers() > 0;
            }
        }
        None
    }

    /// The node's last status comes after the stream to it has ended. Stdout ends with the
    /// program only, so through pipes it goes unheard.
    fn listen_to_the_end(&mut self, stop: &AtomicBool) {
        if self.hub.is_stdio() {
            return;
        }
        self.hub.finish_writing();
        while self.answers && !stop.load(Ordering::Relaxed) {
            if let Some(heard) = self.hub.hear(GLANCE) {
                self.heed(heard);
            }
            if self.status.as_ref().is_some_and(|status| status.last) {
                return;
            }
        }
    }

    fn summary(&self, items: usize) -> String {
        let bins = self.emulator.picked().len();
        let mut text = format!("{bins} of {items} items in the bins");
        if let Some(status) = &self.status {
            text += &format!(
                "; the node says: {} of {} picked, {} missed",
                status.picked,
                status.seen,
                status.missed.total()
            );
        }
        if self.unread > 0 {
            text += &format!("; {} lines were no messages of a node", self.unread);
        }
        text
    }
}
