//! `pickline run`.

use super::args::{Common, Format, RunArgs, TransportArgs};
use super::dashboard::Screen;
use super::kept::Kept;
use super::live::{GLANCE, PATIENCE, check_range, stop_flag, unix_now, until};
use super::progress::Bar;
use super::session::Session;
use super::settings::json;
use super::training::{Line, budget};
use crate::error::Result;
use crate::live::protocol::{Outgoing, Rejected, decode, schema};
use crate::live::recording::Event;
use crate::live::transport::{Heard, Hub, Side};
use crate::live::{ClockKind, Config, Controller};
use crate::optimize::Environment;
use crate::planning::{Allowance, Budget};
use crate::station::Station;
use crate::strategies::{self, Blueprint};
use std::cell::OnceCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Messages heeded before what is due is looked at again.
const AT_ONCE: usize = 64;

pub fn run(args: &RunArgs, session: &Session) -> Result<()> {
    if args.schema {
        return session.print(json(&schema())?.as_bytes());
    }
    #[cfg(feature = "mcap")]
    if let Some(file) = &args.kept.replay {
        return super::replay::replay(args, file, session);
    }
    check_range("--tolerance", args.tolerance, 0.0, 1.0, "m")?;
    check_range("--ack-timeout", args.ack_timeout, 1e-3, 1e3, "s")?;
    check_range("--result-timeout", args.result_timeout, 1e-3, 1e4, "s")?;
    if args.status_every != 0.0 {
        let least = match args.transport.clock() {
            ClockKind::System => 0.01,
            // An hour may pass at once, and all its statuses with it.
            ClockKind::Messages => 0.1,
        };
        let unit = "s, or 0 for the last one only";
        check_range("--status-every", args.status_every, least, 1e6, unit)?;
    }
    let allowance = allowance(args.budget_ms, args.transport.clock())?;
    let station = args.station.load()?;
    let text = match &args.strategy {
        Some(text) => text.clone(),
        None => strategies::default_strategy(station.robots().len()),
    };
    let quiet = args.transport.quiet;
    let strategy = blueprint(&text, args.seed, quiet, &station, session, allowance)?;
    let config = Config {
        clock: args.transport.clock(),
        tolerance: args.tolerance,
        ack_timeout: args.ack_timeout,
        result_timeout: args.result_timeout,
        status_every: args.status_every,
        ..Config::default()
    };
    let made = strategy.make();
    args.transport.remark(&format!(
        "running {}, station {}",
        made.name(),
        args.station.station
    ));
    let screen = Screen::open(args, &station, &made.name())?;
    let began = Instant::now();
    let (controller, kept) = Kept::open(args, session, station, (&text, made), config)?;
    let stopwatch = Box::new(move || began.elapsed().as_secs_f64());
    let mut node = Node {
        controller: controller.with_stopwatch(stopwatch),
        hub: args.transport.open(Side::Node)?,
        kept,
        screen,
        transport: &args.transport,
        // Stdin and stdout are there from the start.
        talking: 0,
        status_every: args.status_every,
    };
    node.talking = usize::from(node.hub.is_stdio());
    if node.talking > 0 {
        // What a journal tells of may not have reached it.
        node.controller.send_again();
        node.kept.happened(&Event::Joined {});
    }
    let stop = stop_flag();
    let mut gone = match config.clock {
        ClockKind::System => node.go_by_the_clock(&stop),
        ClockKind::Messages => node.go_by_the_messages(&stop),
    };
    if gone.is_ok() {
        gone = node.end(stop.load(Ordering::Relaxed));
    }
    // What was said so far is in the journal and leaves, whatever went wrong since.
    node.hub.close(PATIENCE);
    node.screen.close(&node.controller);
    gone.and(node.kept.finish())
}

/// What a decision of a live line may cost.
///
/// # Errors
/// A time that is none.
pub fn allowance(ms: Option<f64>, clock: ClockKind) -> Result<Allowance> {
    Ok(Allowance {
        asked: budget(ms)?,
        otherwise: match clock {
            // The belt does not wait.
            ClockKind::System => Budget::LIVE,
            // So that a stream gives the same output on every machine.
            ClockKind::Messages => Budget::EXPERIMENT,
        },
    })
}

/// The strategy of a live line, as it is written in `text`.
///
/// # Errors
/// A text that is none.
pub fn blueprint(
    text: &str,
    seed: u64,
    quiet: bool,
    station: &Station,
    session: &Session,
    allowance: Allowance,
) -> Result<Blueprint> {
    let common = Common {
        seed,
        update_hz: 0.0,
        threads: None,
        format: Format::Table,
        out: None,
        quiet,
    };
    let bar = Bar::new(common.quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
    };
    let line = Line::new(&common, station, &environment);
    common.on_threads(|| line.read(text, &OnceCell::new(), allowance))
}

/// The controller with its peers.
struct Node<'a> {
    controller: Controller,
    hub: Hub,
    kept: Kept,
    screen: Screen,
    transport: &'a TransportArgs,
    /// Peers that may still say something.
    talking: usize,
    status_every: f64,
}

impl Node<'_> {
    /// Takes messages as they come and does what is due when it is, until told to stop or
    /// stdin ends.
    fn go_by_the_clock(&mut self, stop: &AtomicBool) -> Result<()> {
        let mut next_status = unix_now() + self.status_every;
        while !stop.load(Ordering::Relaxed) {
            let now = unix_now();
            let held = self.hub.is_stalled();
            self.controller.hold(held);
            self.controller.advance(now);
            self.kept.happened(&Event::Step { stamp: now, held });
            if self.status_every > 0.0 && now >= next_status {
                next_status = now + self.status_every;
                self.report(false, self.hub.queued() as u64);
            }
            self.speak()?;
            self.screen.show(&self.controller, &self.hub);
            let due = self.controller.next_stamp();
            let due = due.map_or(next_status, |due| due.min(next_status));
            let mut patience = until(Some(due));
            // Whatever was heard is in the journal before the next wait.
            self.kept.rest(&mut self.controller)?;
            for _ in 0..AT_ONCE {
                let Some(heard) = self.hub.hear(patience) else {
                    break;
                };
                patience = Duration::ZERO;
                match heard {
                    Heard::Left(0) => return Ok(()),
                    Heard::Left(number) => self.hub.leave(number),
                    // What is to be said waits until somebody is there again.
                    Heard::Down(_) => {}
                    // Whoever has ended waits for a last word.
                    Heard::Ended(_) => self.report(false, self.hub.queued() as u64),
                    heard => self.heed(heard)?,
                }
            }
        }
        Ok(())
    }

    /// Takes messages until the peers have no more, or told to stop.
    fn go_by_the_messages(&mut self, stop: &AtomicBool) -> Result<()> {
        while !stop.load(Ordering::Relaxed) {
            self.screen.show(&self.controller, &self.hub);
            match self.hub.hear(GLANCE) {
                None => {
                    self.kept.rest(&mut self.controller)?;
                    continue;
                }
                Some(Heard::Left(_) | Heard::Down(_) | Heard::Ended(_)) => {
                    self.talking = self.talking.saturating_sub(1);
                    if self.talking == 0 {
                        self.controller.finish();
                        self.kept.happened(&Event::Finished {});
                        break;
                    }
                }
                Some(heard) => self.heed(heard)?,
            }
            self.speak()?;
        }
        Ok(())
    }

    fn heed(&mut self, heard: Heard) -> Result<()> {
        let result = match heard {
            Heard::Line(_, line) => match decode(&line) {
                Ok(message) => {
                    self.kept.heard(&message);
                    self.controller.handle(message)
                }
                Err(rejected) => Err(self.refuse(rejected)),
            },
            Heard::Refused(_, rejected) => Err(self.refuse(rejected)),
            Heard::Joined(stream) => {
                match self.hub.join(stream) {
                    Ok(()) => self.welcome(),
                    Err(error) => self.transport.remark(&format!("a peer is gone: {error}")),
                }
                Ok(())
            }
            Heard::Up(_) => {
                self.welcome();
                Ok(())
            }
            Heard::Remark(text) => {
                self.transport.remark(&text);
                Ok(())
            }
            Heard::Failed(error) => return Err(error),
            Heard::Left(_) | Heard::Down(_) | Heard::Ended(_) => Ok(()),
        };
        if let Err(rejected) = result {
            let (reason, message) = (rejected.reason.name(), rejected.message);
            self.transport
                .remark(&format!("refused ({reason}): {message}"));
        }
        Ok(())
    }

    /// Somebody is there who may not have heard what was said.
    fn welcome(&mut self) {
        self.talking += 1;
        self.controller.send_again();
        self.kept.happened(&Event::Joined {});
    }

    /// A line that is no message is counted.
    fn refuse(&mut self, rejected: Rejected) -> Rejected {
        self.controller.count_rejected(rejected.reason);
        let reason = rejected.reason.name().to_owned();
        self.kept.happened(&Event::Refused { reason });
        rejected
    }

    fn report(&mut self, last: bool, queued: u64) {
        self.controller.report(last, queued);
        self.kept.happened(&Event::Report { last, queued });
    }

    /// Sends what the controller has to say, once the journal has what it follows from.
    fn speak(&mut self) -> Result<()> {
        let output = self.controller.take_output();
        self.kept.keep(&mut self.controller, !output.is_empty())?;
        for message in output {
            self.kept.said(&message);
            if self.transport.clock() == ClockKind::Messages {
                self.hub.send(message);
                continue;
            }
            let matters = match &message {
                Outgoing::Status(status) => status.last,
                _ => true,
            };
            for number in self.hub.try_send(message, matters) {
                self.hub.leave(number);
                self.transport
                    .remark("a peer did not keep up and was disconnected");
            }
        }
        Ok(())
    }

    /// Says where things stand.
    fn end(&mut self, stopped: bool) -> Result<()> {
        self.controller.stop();
        self.kept.happened(&Event::Stopped {});
        // With message time the output depends on the messages only.
        let queued = match self.transport.clock() {
            ClockKind::System => self.hub.queued() as u64,
            ClockKind::Messages => 0,
        };
        self.report(true, queued);
        self.speak()?;
        let status = self.controller.status(true, 0);
        let latency = self.controller.latency();
        if stopped && !status.open_tasks.is_empty() {
            let open: Vec<String> = status.open_tasks.iter().map(u64::to_string).collect();
            self.transport
                .remark(&format!("stopped with open tasks {}", open.join(", ")));
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
        Ok(())
    }
}
