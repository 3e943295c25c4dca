//! The controller, sans-IO: it takes messages and the time, and returns messages.
//!
//! It has no clock, thread or socket and prints nothing: its caller hands it messages and the time,
//! and sends its output. It decides with the same code that a simulation runs.

mod config;
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
mod ranges;
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
use super::sources::{SourceKey, Sources};
use super::stamps::Stamps;
use super::tally::Tally;
use super::tasks::Tasks;
use super::world::World;
use crate::layout::layout_hash;
use pickline::decision::Strategy;
use pickline::error::Result;
use pickline::plausible::Warning;
use pickline::station::Station;
use picture::Picture;
use reported::Reported;

pub use config::Config;
pub use hearing::HandledAs;
pub use ranges::lead_times;

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
    /// What is known of each robot.
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
    /// How many items were seen, picked and missed, and how often unusual events happened.
    tally: Tally,
    /// Checks for values that are most likely wrong.
    doubts: Doubts,
    /// The strategy, and how long its decisions take.
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
    ///
    /// # Errors
    /// As for [`Config::check`], or a strategy for another number of robots.
    pub fn new(station: Station, strategy: Box<dyn Strategy>, config: Config) -> Result<Self> {
        config.check(&station)?;
        strategy.check_station(&station)?;
        let robots = station.robots().iter();
        let robot_keys = robots.map(|robot| (SourceKind::Robot, robot.name.clone()));
        let robot_keys = robot_keys.collect();
        let tells = config.clock == ClockKind::Messages && config.status_every > 0.0;
        Ok(Self {
            next_status: if tells {
                config.status_every
            } else {
                f64::INFINITY
            },
            layout: layout_hash(&station),
            fleet: Fleet::new(station.robots().len()),
            doubts: Doubts::new(&station),
            world: World::new(station, config.min_detection),
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
        })
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

    /// From now on these robots get no task, and none of theirs is sent again: no peer is there to
    /// deliver it, or the peer lags behind.
    pub fn hold(&mut self, robots: &[usize]) {
        self.held.clear();
        self.held.extend_from_slice(robots);
    }

    /// Whether a robot is held, so that it gets no task at the moment.
    fn is_held(&self, robot: usize) -> bool {
        self.held.contains(&robot)
    }

    /// The timestamp [s] of a controller time [s] by the clock of `robot`.
    fn stamp_for(&self, robot: usize, time: f64) -> f64 {
        self.stamps.clock.stamp(time) - self.sources.shift(&self.robot_keys[robot])
    }

    /// The timestamp [s] of a controller time [s] by the machine's clock.
    fn stamp_of(&self, time: f64) -> f64 {
        self.stamps.clock.stamp(time) + self.sources.ahead()
    }

    fn note(&mut self, what: &'static str) {
        self.tally.note(what);
    }
}
