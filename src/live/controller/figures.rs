//! Where things stand.

use super::Controller;
use super::items::Fate;
use crate::live::clock::ClockKind;
use crate::live::protocol::{Outgoing, Status};
use std::borrow::Cow;
use std::collections::BTreeMap;

impl Controller {
    /// The figures as they are now. `queued` is how many messages wait to be sent.
    pub fn status(&self, last: bool, queued: u64) -> Status {
        let now = self.clock.now;
        let travel = self.motion.travel(now);
        let (mut picked, mut missed) = (self.picked, self.missed);
        let (mut on_belt, mut claimed) = (0, 0);
        for (_, tracked) in self.items.iter() {
            match self.fate(tracked, tracked.place + travel) {
                Fate::Picked => picked += 1,
                Fate::Claimed => claimed += 1,
                Fate::OnBelt => on_belt += 1,
                fate => {
                    fate.count(&mut missed);
                }
            }
        }
        let counts = |counts: &BTreeMap<Cow<'static, str>, u64>| {
            let counts = counts.iter();
            counts
                .map(|(name, count)| (name.to_string(), *count))
                .collect()
        };
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let robots = self.nominal.robots().iter().zip(&self.robots);
        Status {
            stamp: self.clock.stamp(now),
            last,
            layout: Some(self.layout.clone()),
            seen: self.seen,
            picked,
            picked_share: share(picked as f64, self.seen as f64),
            picks_per_min: share(60.0 * picked as f64, now),
            missed,
            on_belt,
            claimed,
            open_tasks: self.claims.keys().copied().collect(),
            queued,
            rejected: counts(&self.rejected),
            noted: counts(&self.noted),
            robots: robots
                .map(|(robot, info)| info.report(&robot.name, now))
                .collect(),
            latency: (self.clock.kind == ClockKind::System).then(|| self.latency.latency()),
        }
    }

    /// Sends the figures as they are now.
    pub fn report(&mut self, last: bool, queued: u64) {
        let status = self.status(last, queued);
        self.output.push(Outgoing::Status(Box::new(status)));
    }

    /// How long decisions took so far.
    pub fn latency(&self) -> crate::live::protocol::Latency {
        self.latency.latency()
    }
}
