//! When to request the drive to stop or restart the belt.

use super::Controller;
use crate::drive::StopCause;
use crate::protocol::{BeltRequest, Outgoing};
use crate::robots::Service;

impl Controller {
    /// Time of the next possible request to the drive, if nothing is heard until then [s].
    pub(super) fn next_drive(&self) -> Option<f64> {
        if !self.config.may_stop_belt || self.world.awaits_belt() {
            return None;
        }
        let (now, speed) = (self.stamps.now(), self.world.motion().speed());
        let lost = (self.drive.running().is_none() && speed > 0.0)
            .then(|| self.first_loss(speed))
            .flatten();
        // A robot that falls silent no longer takes tasks, and one that has met its item does not
        // need the belt to wait.
        let robots = 0..self.fleet.len();
        let silent = robots.map(|robot| self.sources.robot_until(&self.robot_keys[robot]));
        let silent = silent.filter(|until| until.is_finite()).map(f64::next_up);
        let met = self.tasks.holding().map(|claim| claim.meet_at);
        let all = self.drive.repeat_at().into_iter().chain(lost);
        // Anything due earlier was requested when the step began.
        let all = all.chain(silent).chain(met).filter(|time| *time > now);
        all.reduce(f64::min)
    }

    /// Requests the drive to stop or restart the belt if there is a reason to.
    pub(super) fn request_drive(&mut self) {
        if !self.config.may_stop_belt || self.world.awaits_belt() {
            return;
        }
        let (now, speed) = (self.stamps.now(), self.world.motion().speed());
        let running = self.drive.running().unwrap_or(speed);
        let reason = if self.is_nobody_at_work() {
            Some(StopCause::NoRobot)
        } else if self.first_loss(running).is_some_and(|at| at <= now) {
            Some(StopCause::ItemLost)
        } else {
            None
        };
        if let Some(request) = self.drive.ask(now, speed, reason) {
            self.output.push(Outgoing::BeltRequest(BeltRequest {
                stamp: self.stamp_of(now),
                speed: request.speed,
                reason: request.cause.text().to_owned(),
            }));
        }
    }

    fn is_at_work(&self, robot: usize) -> bool {
        let service = self.fleet.get(robot).service;
        let is_there = self.stamps.now() <= self.sources.robot_until(&self.robot_keys[robot]);
        let works = matches!(service, Service::Ready | Service::Working);
        is_there && works && self.operation.allows(robot)
    }

    /// Whether robots were heard and none of them takes tasks.
    fn is_nobody_at_work(&self) -> bool {
        let mut robots = self.fleet.iter();
        let is_heard = robots.any(|(_, info)| info.service != Service::Unknown);
        is_heard && (0..self.fleet.len()).all(|robot| !self.is_at_work(robot))
    }

    /// When the belt must be requested to stop [s], because the first free item is about to leave
    /// the reach of the last robot that could take it, if the belt moves at `speed` [m/s]. Items
    /// that have already left do not count. While the belt waits for an item, the item is not safe
    /// until its robot has met it.
    fn first_loss(&self, speed: f64) -> Option<f64> {
        let now = self.stamps.now();
        let station = self.station().with_belt_speed(speed).ok()?;
        let travelled = self.world.motion().travel(now) - speed * now;
        let waits = self.drive.running().is_some();
        let losses = self.world.items().iter().filter_map(|(_, tracked)| {
            let its = tracked.claimed_by().and_then(|task| self.tasks.get(task));
            let its = its.filter(|claim| waits && now < claim.meet_at);
            let robots = station.robots().iter().enumerate();
            let robots = robots.filter(|(index, _)| match its {
                Some(claim) => claim.robot == *index,
                None => tracked.is_open_to(*index) && self.is_at_work(*index),
            });
            let closes = robots.filter_map(|(index, robot)| {
                let place = tracked.place + travelled;
                let from = match its {
                    Some(claim) => claim.from,
                    None => self.fleet.get(index).place_of(robot),
                };
                let from = usize::from(from);
                let window = robot.departure_window(station.belt(), from, place, tracked.y);
                let (_, close) = window?;
                // A task is decided one lead time before the robot sets out.
                let margin = self.config.stop_margin + self.config.lead_of(index);
                (close >= now).then_some(close - margin)
            });
            closes.reduce(f64::max)
        });
        losses.reduce(f64::min)
    }
}
