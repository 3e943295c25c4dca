//! The controller, sans-IO: it takes messages and the time, and returns messages.
//!
//! It has no clock, thread or socket and prints nothing: its caller hands it messages and the time,
//! and sends its output. It decides with the same code that a simulation runs.

mod decide;
mod drive;
mod due;
mod figures;
mod hearing;
mod identity;
mod peers;
mod operation;
mod picture;
mod pictures;
mod plans;
mod recovery;
mod reported;
mod results;
mod sources;
mod states;
mod tasks;
mod watch;

use super::aim::Aim;
use super::clock::{Clock, ClockKind};
use super::decider::{Decider, Stopwatch};
use super::doubts::Doubts;
use super::drive::Drive;
use super::operation::Operation;
use super::protocol::{Outgoing, Rejected, Rejection, SourceKind};
use super::robots::Fleet;
use super::sources::{SourceKey, Sources, Timeouts};
use super::stamps::Stamps;
use super::tally::Tally;
use super::tasks::Tasks;
use super::world::World;
use crate::layout::layout_hash;
use pickline::decision::Strategy;
use pickline::plausible::Warning;
use pickline::station::Station;
use picture::Picture;
use reported::Reported;

pub use hearing::HandledAs;

/// Settings of the controller beyond the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Where the time comes from.
    pub clock: ClockKind,
    /// Detections within this distance of an item show that item, unless something else is known
    /// [m].
    pub tolerance: f64,
    /// An unacknowledged task is sent again after this time [s].
    pub ack_timeout: f64,
    /// A result that is overdue by this time is no longer waited for [s].
    pub result_timeout: f64,
    /// Number of attempts at an item before it is given up.
    pub most_attempts: u32,
    /// Maximum number of items on the belt; further ones are refused.
    pub most_items: usize,
    /// With message time, the interval of statuses [s]; 0 is never. With the system clock the
    /// caller requests them.
    pub status_every: f64,
    /// The strategy sees items from this x on [m]; a robot may leave for an item before that.
    pub view_from: f64,
    /// Times of silence after which the belt or a robot is no longer relied on.
    pub timeouts: Timeouts,
    /// By how much the timestamps of pictures are late [s].
    pub camera_delay: f64,
    /// How long before its start a task is decided, for each robot [s]: the time that it takes to
    /// reach the arm. Robots beyond the list have 0.
    pub lead: Vec<f64>,
    /// Whether the drive may be requested to stop the belt while no robot takes tasks, and before
    /// an item would be lost.
    pub may_stop_belt: bool,
    /// How long before an item would be lost the belt is requested to stop [s].
    pub stop_margin: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            clock: ClockKind::System,
            tolerance: 0.015,
            ack_timeout: 1.0,
            result_timeout: 5.0,
            most_attempts: 3,
            most_items: 100_000,
            status_every: 0.0,
            view_from: 0.0,
            timeouts: Timeouts::default(),
            camera_delay: 0.0,
            lead: Vec::new(),
            may_stop_belt: false,
            stop_margin: 0.5,
        }
    }
}

impl Config {
    /// How long before its start a task of this robot is decided [s].
    pub fn lead_of(&self, robot: usize) -> f64 {
        self.lead.get(robot).copied().unwrap_or(0.0)
    }
}

/// The state of a live line, and the output that is not yet taken.
///
/// Each part holds related data and keeps it consistent. The methods here call the parts and decide
/// what happens when.
pub struct Controller {
    config: Config,
    /// Hash of the station's layout.
    layout: String,
    /// The belt and its items.
    world: World,
    /// The robots.
    fleet: Fleet,
    /// The tasks given so far.
    tasks: Tasks,
    /// The time, and which timestamps are accepted.
    stamps: Stamps,
    /// The sources of messages, and whether they are silent.
    sources: Sources,
    /// The source of each robot.
    robot_keys: Vec<SourceKey>,
    /// Arrival time of the message in progress [s since 1970], by the steady clock.
    received: Option<f64>,
    /// How far from the expected positions robots find items.
    aim: Aim,
    /// The counted events.
    tally: Tally,
    /// Checks for values that are most likely wrong.
    doubts: Doubts,
    /// The strategy.
    decider: Decider,
    /// Detections of the picture that may still be incomplete.
    picture: Picture,
    /// The operator's orders.
    operation: Operation,
    /// The requests to the belt's drive.
    drive: Drive,
    /// When the next status is due [s]; never with the system clock.
    next_status: f64,
    output: Vec<Outgoing>,
    /// Remarks about the line that are not yet taken.
    remarks: Vec<String>,
    /// Robots that get no task at the moment.
    held: Vec<usize>,
    stopping: bool,
    /// The state reported last; none while no changes are requested.
    reported: Option<Reported>,
}

impl Controller {
    /// A line about which nothing is known yet.
    pub fn new(station: Station, strategy: Box<dyn Strategy>, config: Config) -> Self {
        let robots = station.robots().iter();
        let robot_keys = robots.map(|robot| (SourceKind::Robot, robot.name.clone()));
        let robot_keys = robot_keys.collect();
        let tells = config.clock == ClockKind::Messages && config.status_every > 0.0;
        Self {
            next_status: if tells {
                config.status_every
            } else {
                f64::INFINITY
            },
            layout: layout_hash(&station),
            fleet: Fleet::new(station.robots().len()),
            doubts: Doubts::new(&station),
            world: World::new(station),
            tasks: Tasks::default(),
            stamps: Stamps::new(Clock::new(config.clock)),
            tally: Tally::default(),
            sources: Sources::new(config.timeouts, config.clock == ClockKind::System),
            robot_keys,
            received: None,
            aim: Aim::default(),
            decider: Decider::new(strategy),
            operation: Operation::default(),
            drive: Drive::default(),
            config,
            picture: Picture::default(),
            output: Vec::new(),
            remarks: Vec::new(),
            held: Vec::new(),
            stopping: false,
            reported: None,
        }
    }

    /// The same controller, with a stopwatch to time its decisions.
    pub fn with_stopwatch(mut self, stopwatch: Stopwatch) -> Self {
        self.decider.time_with(stopwatch);
        self
    }

    /// The station as given in its file.
    pub fn station(&self) -> &Station {
        self.world.station()
    }

    /// Takes the messages to be sent, in order.
    pub fn take_output(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.output)
    }

    /// Ends the line: from now on no task is given, and no message comes.
    pub fn stop(&mut self) {
        self.stopping = true;
        self.resolve_last();
        self.close_picture();
    }

    /// Counts a line that was refused before it was decoded.
    pub fn count_rejected(&mut self, reason: Rejection) {
        self.tally.reject(reason);
    }

    /// Takes the refusal of a message that was held back, if there was one since the last call.
    pub fn take_dropped(&mut self) -> Option<Rejected> {
        self.stamps.take_dropped()
    }

    /// Takes the warning about a doubtful value in the last message, if any.
    pub fn take_doubt(&mut self) -> Option<Warning> {
        self.doubts.take()
    }

    /// Takes the remarks for the user since the last call.
    pub fn take_remarks(&mut self) -> Vec<String> {
        self.remarks.extend(self.decider.take_complaint());
        std::mem::take(&mut self.remarks)
    }

    /// The time now [s], 0 at the first message.
    pub fn now(&self) -> f64 {
        self.stamps.now()
    }

    fn note(&mut self, what: &'static str) {
        self.tally.note(what);
    }
}
