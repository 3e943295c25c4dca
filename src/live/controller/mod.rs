//! The controller: messages in, messages out, and the time.
//!
//! It has no clock, thread or socket of its own and prints nothing: whoever drives it
//! hands it messages and the time, and sends what it has to say. What it decides with is
//! the same code that a simulation runs.

mod decide;
mod due;
mod figures;
mod hearing;
mod items;
mod plans;
mod recovery;
mod tasks;
mod watch;

use super::belt::Motion;
use super::claims::Claim;
use super::clock::{Clock, ClockKind};
use super::items::Items;
use super::latency::Histogram;
use super::protocol::{Incoming, MissedCounts, Outgoing, Rejected, Rejection};
use super::robots::RobotInfo;
use super::windows::Windows;
use crate::decision::{BeltItem, Candidate, Strategy};
use crate::live::layout::layout_hash;
use crate::station::Station;
use recovery::Told;
use std::borrow::Cow;
use std::collections::BTreeMap;

pub use hearing::Taken;

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
    /// Hash of its layout.
    layout: String,
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
    /// With message time, a message whose stamp the next one has to confirm.
    held_back: Option<Incoming>,
    /// Why such a message was refused, until somebody asks.
    dropped: Option<Rejected>,
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
    /// What is wrong with the strategy's answers, until somebody asks.
    complaint: Option<String>,
    has_complained: bool,
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
            layout: layout_hash(&station),
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
            held_back: None,
            dropped: None,
            held: false,
            stopping: false,
            awaits_belt: false,
            told: None,
            seen: 0,
            picked: 0,
            missed: MissedCounts::default(),
            rejected: BTreeMap::new(),
            noted: BTreeMap::new(),
            complaint: None,
            has_complained: false,
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

    /// The station as its file says.
    pub fn station(&self) -> &Station {
        &self.nominal
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

    /// From now on no task is given, and no message comes.
    pub fn stop(&mut self) {
        self.stopping = true;
        self.resolve_last();
    }

    /// Counts a line that was refused before it became a message.
    pub fn count_rejected(&mut self, reason: Rejection) {
        *self.rejected.entry(reason.name().into()).or_default() += 1;
    }

    fn note(&mut self, what: &'static str) {
        *self.noted.entry(what.into()).or_default() += 1;
    }
}
