//! The controller: messages in, messages out, and the time.
//!
//! It has no clock, thread or socket of its own and prints nothing: whoever drives it
//! hands it messages and the time, and sends what it has to say. What it decides with is
//! the same code that a simulation runs.

mod decide;
mod figures;
mod items;
mod recovery;
mod tasks;
mod watch;

use super::belt::{Change, Motion};
use super::claims::Claim;
use super::clock::{Clock, ClockKind};
use super::items::Items;
use super::latency::Histogram;
use super::protocol::{BeltState, Due, Incoming, MissedCounts, Outgoing, Rejected, Rejection};
use super::robots::{RobotInfo, Service, Wait};
use super::windows::Windows;
use crate::decision::{BeltItem, Candidate, Strategy};
use crate::station::Station;
use recovery::Told;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// How the controller behaves where the model is silent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Where the time comes from.
    pub clock: ClockKind,
    /// Detections without id within this distance of an item are of that item [m].
    pub tolerance: f64,
    /// A task that is not acknowledged for so long is sent again [s].
    pub ack_timeout: f64,
    /// A result that is overdue for so long is not waited for [s].
    pub result_timeout: f64,
    /// Attempts at one item before it is given up.
    pub most_attempts: u32,
    /// Items on the belt that are kept; more are refused.
    pub most_items: usize,
    /// With message time, a status every so many seconds [s]; 0 is never. With the system
    /// clock whoever drives the controller asks for them.
    pub status_every: f64,
    /// From this x on the strategy sees items [m]; a robot may leave for one before.
    pub view_from: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            clock: ClockKind::System,
            tolerance: 0.02,
            ack_timeout: 1.0,
            result_timeout: 5.0,
            most_attempts: 3,
            most_items: 100_000,
            status_every: 0.0,
            view_from: 0.0,
        }
    }
}

/// Reads a stopwatch [s]; passed in, as the controller has no clock of its own.
pub type Stopwatch = Box<dyn FnMut() -> f64 + Send>;

/// The state of a live line.
pub struct Controller {
    config: Config,
    /// The station as its file says.
    nominal: Station,
    /// The station with the belt as fast as it is planned with; none while no robot can
    /// work: the belt runs backwards or outruns an arm.
    planning: Option<Station>,
    strategy: Box<dyn Strategy>,
    name: String,
    stopwatch: Option<Stopwatch>,
    latency: Histogram,
    clock: Clock,
    motion: Motion,
    items: Items,
    robots: Vec<RobotInfo>,
    windows: Vec<Windows>,
    /// Tasks whose result is not known.
    claims: BTreeMap<u64, Claim>,
    /// Tasks that are over, with their item, until that is forgotten.
    closed: BTreeMap<u64, u32>,
    next_task: u64,
    /// When the next status is due [s]; never without message time.
    next_status: f64,
    output: Vec<Outgoing>,
    held: bool,
    stopping: bool,
    /// Whether the belt has to be heard before anything is done: it may have stopped
    /// while nobody listened.
    awaits_belt: bool,
    /// What was last told of the state; none while nobody asks for its changes.
    told: Option<Told>,
    seen: u64,
    /// Fates of items that are forgotten.
    picked: u64,
    missed: MissedCounts,
    rejected: BTreeMap<Cow<'static, str>, u64>,
    noted: BTreeMap<Cow<'static, str>, u64>,
    /// What a decision is made on, kept to be filled again.
    candidates: Vec<Candidate>,
    view: Vec<BeltItem>,
    free_at: Vec<f64>,
}

impl Controller {
    /// A line of which nothing is known yet.
    pub fn new(station: Station, strategy: Box<dyn Strategy>, config: Config) -> Self {
        let robots = station.robots().len();
        let speed = station.belt().speed;
        let tells = config.clock == ClockKind::Messages && config.status_every > 0.0;
        Self {
            next_status: if tells {
                config.status_every
            } else {
                f64::INFINITY
            },
            config,
            planning: Some(station.clone()),
            nominal: station,
            name: strategy.name(),
            strategy,
            stopwatch: None,
            latency: Histogram::default(),
            clock: Clock::new(config.clock),
            motion: Motion::new(speed),
            items: Items::default(),
            robots: vec![RobotInfo::default(); robots],
            windows: vec![Windows::default(); robots],
            claims: BTreeMap::new(),
            closed: BTreeMap::new(),
            next_task: 1,
            output: Vec::new(),
            held: false,
            stopping: false,
            awaits_belt: false,
            told: None,
            seen: 0,
            picked: 0,
            missed: MissedCounts::default(),
            rejected: BTreeMap::new(),
            noted: BTreeMap::new(),
            candidates: Vec::new(),
            view: Vec::new(),
            free_at: Vec::new(),
        }
    }

    /// The same controller, which times its decisions.
    pub fn with_stopwatch(mut self, stopwatch: Stopwatch) -> Self {
        self.stopwatch = Some(stopwatch);
        self
    }

    /// What is to be sent, in order.
    pub fn take_output(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.output)
    }

    /// While held, no task is given and none is sent again: whoever sends cannot keep up,
    /// or there is nobody to send to.
    pub fn hold(&mut self, held: bool) {
        self.held = held;
    }

    /// From now on no task is given.
    pub fn stop(&mut self) {
        self.stopping = true;
    }

    /// Counts a line that was refused before it became a message.
    pub fn count_rejected(&mut self, reason: Rejection) {
        *self.rejected.entry(reason.name().into()).or_default() += 1;
    }

    fn note(&mut self, what: &'static str) {
        *self.noted.entry(what.into()).or_default() += 1;
    }

    /// Takes a message.
    ///
    /// # Errors
    /// A message that cannot be heeded; it is counted, and nothing has changed.
    pub fn handle(&mut self, message: Incoming) -> Result<(), Rejected> {
        let result = self.heed(message);
        if let Err(rejected) = &result {
            self.count_rejected(rejected.reason);
        }
        result
    }

    fn heed(&mut self, message: Incoming) -> Result<(), Rejected> {
        let time = self.clock.believe(message.stamp())?;
        if self.clock.kind == ClockKind::Messages && time > self.clock.now {
            // What was due before this came is decided without it.
            self.settle(time, false);
        }
        match message {
            Incoming::Detection(detection) => self.detect(time, detection),
            Incoming::Belt(belt) => {
                self.heed_belt(time, &belt);
                Ok(())
            }
            Incoming::Robot(robot) => self.heed_robot(time, &robot),
            Incoming::Ack(ack) => self.heed_ack(ack.task),
            Incoming::Result(report) => self.heed_result(time, &report),
            Incoming::Tick { stamp } => {
                if self.clock.kind == ClockKind::Messages {
                    self.settle(time, true);
                    let next = self.next_due().map(|time| self.clock.stamp(time));
                    self.output.push(Outgoing::Due(Due { stamp, next }));
                }
                Ok(())
            }
        }
    }

    /// With the system clock: the time is `stamp` [s since 1970], and what is due is done.
    pub fn advance(&mut self, stamp: f64) {
        if self.clock.kind == ClockKind::System {
            let time = self.clock.time(stamp);
            // Decisions are never made in the past: the robots could not leave then.
            self.clock.now = self.clock.now.max(time);
            self.settle(self.clock.now, true);
        }
    }

    /// With message time: no further message comes.
    pub fn finish(&mut self) {
        if self.clock.kind == ClockKind::Messages {
            self.settle(self.clock.now, true);
        }
    }

    /// Stamp at which something is due if no message comes [s].
    pub fn next_stamp(&mut self) -> Option<f64> {
        self.next_due().map(|time| self.clock.stamp(time))
    }

    fn next_due(&mut self) -> Option<f64> {
        let decision = self.next_decision().map(|(time, _)| time);
        let deadline = self.next_deadline().map(|(time, _)| time);
        decision.into_iter().chain(deadline).reduce(f64::min)
    }

    /// Does what is due up to `until` [s], that moment included or not, in order of time.
    fn settle(&mut self, until: f64, included: bool) {
        let is_due = |time: f64| time < until || (included && time == until);
        loop {
            if !self.awaits_belt && self.motion.is_off(self.clock.now) {
                self.plan_anew();
            }
            let deadline = self.next_deadline().filter(|(time, _)| is_due(*time));
            let decision = self.next_decision().filter(|(time, _)| is_due(*time));
            let first = [
                deadline.map(|(time, _)| time),
                decision.map(|(time, _)| time),
            ];
            let first = first.into_iter().flatten().fold(f64::INFINITY, f64::min);
            if is_due(self.next_status) && self.next_status < first {
                // As things are then: what is due at the same time is done before.
                self.clock.now = self.clock.now.max(self.next_status);
                self.next_status += self.config.status_every;
                self.forget_gone();
                self.report(false, 0);
                continue;
            }
            match (deadline, decision) {
                (Some((at, task)), decision) if decision.is_none_or(|(time, _)| at <= time) => {
                    self.clock.now = self.clock.now.max(at);
                    self.overdue(task);
                }
                (_, Some((time, robot))) => {
                    self.clock.now = self.clock.now.max(time);
                    self.decide(robot);
                }
                _ => break,
            }
        }
        self.clock.now = self.clock.now.max(until);
        self.forget_gone();
    }

    fn heed_belt(&mut self, time: f64, belt: &BeltState) {
        let resets = self.motion.encoder_resets();
        match self.motion.heed(time, belt) {
            Change::Late => self.note("late_belt"),
            Change::None | Change::Plan if self.awaits_belt => {
                self.awaits_belt = false;
                self.be_patient();
                self.plan_anew();
            }
            Change::None => {}
            Change::Plan => self.plan_anew(),
        }
        if self.motion.encoder_resets() > resets {
            self.note("encoder_reset");
        }
    }

    /// The belt is not where plans put it: windows, tasks and waits are made anew.
    fn plan_anew(&mut self) {
        self.motion.plan_anew(self.clock.now);
        self.plan_station();
        let tasks: Vec<u64> = self.claims.keys().copied().collect();
        for task in tasks {
            self.follow(task);
        }
        self.rebuild_windows();
    }

    fn plan_station(&mut self) {
        let backwards = self.motion.speed() < 0.0;
        let station = self.nominal.with_belt_speed(self.motion.planned_speed());
        self.planning = station.ok().filter(|_| !backwards);
    }

    /// Makes all windows anew and wakes whoever waits: the plans they waited by are void.
    fn rebuild_windows(&mut self) {
        self.windows.iter_mut().for_each(Windows::clear);
        let free: Vec<u32> = self.items.iter().map(|(item, _)| item).collect();
        for item in free {
            self.open_windows(item);
        }
        for robot in &mut self.robots {
            if robot.service == Service::Ready && robot.wait != Wait::No {
                robot.free_at = self.clock.now;
                robot.wait = Wait::No;
            }
        }
    }
}
