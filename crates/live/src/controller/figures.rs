//! The figures of a status.

use super::Controller;
use crate::clock::ClockKind;
use crate::fate::Fate;
use crate::operation::Mode;
use crate::protocol::{Outgoing, Status};

impl Controller {
    /// The current figures. `queued` is the number of messages waiting to be sent.
    pub fn status(&self, last: bool, queued: u64) -> Status {
        let now = self.stamps.now();
        let (mut picked, mut missed) = self.tally.forgotten();
        let mut unwanted = self.tally.unwanted();
        let (mut on_belt, mut claimed) = (0, 0);
        let travel = self.world.motion().travel(now);
        for (_, tracked) in self.world.items().iter() {
            match self.world.fate(tracked, tracked.place + travel) {
                Fate::Picked => picked += 1,
                Fate::Claimed => claimed += 1,
                Fate::OnBelt => on_belt += 1,
                Fate::Unwanted => unwanted += 1,
                fate => {
                    if let Some(count) = fate.count(&mut missed) {
                        *count += 1;
                    }
                }
            }
        }
        let seen = self.tally.seen();
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let robots = self.station().robots().iter().zip(self.fleet.iter());
        Status {
            stamp: self.stamp_of(now),
            last,
            layout: Some(self.layout.clone()),
            mode: self.mode().to_owned(),
            seen,
            picked,
            picked_share: share(picked as f64, seen.saturating_sub(unwanted) as f64),
            picks_per_min: share(60.0 * picked as f64, now),
            missed,
            on_belt,
            claimed,
            unwanted: self.world.leaves_items().then_some(unwanted),
            open_tasks: self.tasks.holding().map(|claim| claim.task).collect(),
            queued,
            rejected: self.tally.rejected(),
            noted: self.tally.noted(),
            robots: robots
                .map(|(robot, (index, info))| {
                    let mut report = info.report(&robot.name, now);
                    let mode = self.operation.robot(index);
                    if mode != Mode::Running && report.state == "idle" {
                        mode.name(false).clone_into(&mut report.state);
                    }
                    report
                })
                .collect(),
            sources: self.sources.report(now),
            latency: (self.stamps.clock.kind == ClockKind::System).then(|| self.decider.latency()),
        }
    }

    /// Sends a status with the current figures; see [`Controller::status`].
    pub fn report(&mut self, last: bool, queued: u64) {
        self.close_picture();
        let status = self.status(last, queued);
        self.output.push(Outgoing::Status(Box::new(status)));
    }

    /// Durations of the decisions so far.
    pub fn latency(&self) -> crate::protocol::Latency {
        self.decider.latency()
    }

    /// Picks of each robot so far and whether it is busy, upstream first.
    pub fn workload(&self) -> impl Iterator<Item = (u64, bool)> + '_ {
        let now = self.stamps.now();
        let robots = self.fleet.iter();
        robots.map(move |(_, info)| (info.picked, info.state(now) == "busy"))
    }
}
