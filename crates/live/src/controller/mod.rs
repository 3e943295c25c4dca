//! The controller: messages in, messages out, and the time.
//!
//! It has no clock, thread or socket of its own and prints nothing: whoever drives it
//! hands it messages and the time, and sends what it has to say. What it decides with is
//! the same code that a simulation runs.

mod decide;
mod drive;
mod due;
mod figures;
mod hearing;
mod identity;
mod peers;
mod operation;
mod pictures;
mod plans;
mod recovery;
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
use super::sources::{Key, Sources, Timeouts};
use super::stamps::Stamps;
use super::tally::Tally;
use super::tasks::Tasks;
use super::world::World;
use pickline::decision::Strategy;
use crate::layout::layout_hash;
use pickline::plausible::Warning;
use pickline::station::Station;
use pictures::Picture;
use recovery::Told;

pub use hearing::Taken;

/// How the controller behaves where the model is silent.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Where the time comes from.
    pub clock: ClockKind,
    /// Detections within this distance of an item are of that item, as far as nothing else
    /// is known [m].
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
    /// After how long a silence the belt and a robot are not relied on.
    pub timeouts: Timeouts,
    /// Pictures are stamped so late [s].
    pub camera_delay: f64,
    /// How long before its start a task is decided, for each robot [s]: as long as it takes
    /// to the arm. Robots beyond the list have none.
    pub lead: Vec<f64>,
    /// Whether the drive is asked to stop the belt while no robot takes tasks, and before
    /// an item would be lost.
    pub may_stop_belt: bool,
    /// How long before an item would be lost the belt is asked to stop [s].
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

/// The state of a live line: its parts, and what is to be said.
///
/// Each part holds what belongs together and keeps it consistent; what is done with news,
/// and when, is here, as methods that call the parts.
pub struct Controller {
    config: Config,
    /// Hash of the station's layout.
    layout: String,
    /// What is known of the belt and its items.
    world: World,
    /// What is known of the robots.
    fleet: Fleet,
    /// The tasks that were given.
    tasks: Tasks,
    /// The time, and which stamps are believed.
    stamps: Stamps,
    /// Who speaks, and whether it still does.
    sources: Sources,
    /// Each robot as a source.
    robot_keys: Vec<Key>,
    /// When the message that is taken came [s since 1970], by the steady clock.
    received: Option<f64>,
    /// How far from where they were sent robots find items.
    aim: Aim,
    /// What is counted.
    tally: Tally,
    /// Which values are most likely wrong.
    doubts: Doubts,
    /// Who decides.
    decider: Decider,
    /// Detections of a picture that may not be whole.
    picture: Picture,
    /// What the operator wants.
    operation: Operation,
    /// What is asked of the belt's drive.
    drive: Drive,
    /// When the next status is due [s]; never without message time.
    next_status: f64,
    output: Vec<Outgoing>,
    /// What is strange about the line, until somebody asks.
    remarks: Vec<String>,
    /// Robots that get no task for now.
    held: Vec<usize>,
    stopping: bool,
    /// What was last told of the state; none while nobody asks for its changes.
    told: Option<Told>,
}

impl Controller {
    /// A line of which nothing is known yet.
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
            told: None,
        }
    }

    /// The same controller, which times its decisions.
    pub fn with_stopwatch(mut self, stopwatch: Stopwatch) -> Self {
        self.decider.time_with(stopwatch);
        self
    }

    /// The station as its file says.
    pub fn station(&self) -> &Station {
        self.world.station()
    }

    /// What is to be sent, in order.
    pub fn take_output(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.output)
    }

    /// From now on no task is given, and no message comes.
    pub fn stop(&mut self) {
        self.stopping = true;
        self.resolve_last();
        self.close_picture();
    }

    /// Counts a line that was refused before it became a message.
    pub fn count_rejected(&mut self, reason: Rejection) {
        self.tally.reject(reason);
    }

    /// Why the message that was held back was refused, if it was since this was last asked.
    pub fn take_dropped(&mut self) -> Option<Rejected> {
        self.stamps.take_dropped()
    }

    /// What of the last message is most likely wrong, if that was not asked before.
    pub fn take_doubt(&mut self) -> Option<Warning> {
        self.doubts.take()
    }

    /// What the user should know and has not been told yet.
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
