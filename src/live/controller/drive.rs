//! When the belt's drive is asked to stop the belt, and to go on.

use super::Controller;
use crate::live::drive::Cause;
use crate::live::protocol::{BeltRequest, Outgoing};
use crate::live::robots::Service;

impl Controller {
    /// When the drive is asked for something next, if nothing is heard until then [s].
    pub(super) fn next_drive(&self) -> Option<f64> {
        if !self.config.may_stop_belt || self.world.awaits_belt() {
            return None;
        }
        let speed = self.world.motion().speed();
        let again = self.drive.repeat_at(speed);
        let lost = (self.drive.running().is_none() && speed > 0.0)
            .then(|| self.first_loss(speed))
            .flatten();
        let lost = lost.map(|loss| loss - self.config.stop_margin);
        let next = [again, lost].into_iter().flatten().reduce(f64::min);
        // What was due before was asked for when the last step ended.
        next.filter(|time| *time > self.stamps.now())
    }

    /// Asks the drive to stop the belt, or to go on, where there is reason to.
    pub(super) fn ask_drive(&mut self) {
        if !self.config.may_stop_belt || self.world.awaits_belt() || self.stopping {
            return;
        }
        let now = self.stamps.now();
        let speed = self.world.motion().speed();
        let running = self.drive.running().unwrap_or(speed);
        let loss = self.first_loss(running);
        let reason = if self.is_nobody_at_work() {
            Some(Cause::NoRobot)
        } else if loss.is_some_and(|loss| loss - self.config.stop_margin <= now) {
            Some(Cause::ItemLost)
        } else {
            None
        };
        if let Some(request) = self.drive.ask(now, speed, reason) {
            self.output.push(Outgoing::BeltRequest(BeltRequest {
                stamp: self.stamps.clock.stamp(now),
                speed: request.speed,
                reason: request.cause.text().to_owned(),
            }));
        }
    }

    fn is_at_work(&self, robot: usize) -> bool {
        let service = self.fleet.get(robot).service;
        matches!(service, Service::Ready | Service::Working) && self.operation.allows(robot)
    }

    /// Whether robots were heard and none of them takes tasks.
    fn is_nobody_at_work(&self) -> bool {
        let mut robots = self.fleet.iter();
        let is_heard = robots.any(|(_, info)| info.service != Service::Unknown);
        is_heard && (0..self.fleet.len()).all(|robot| !self.is_at_work(robot))
    }

    /// When the first free item leaves the reach of the last robot that could take it, if
    /// the belt moves at `speed` [m/s]; those that have left it do not count.
    fn first_loss(&self, speed: f64) -> Option<f64> {
        let now = self.stamps.now();
        let station = self.station().with_belt_speed(speed).ok()?;
        let travelled = self.world.motion().travel(now) - speed * now;
        let is_at_work = |robot: usize| self.is_at_work(robot);
        let losses = self.world.items().iter().filter_map(|(_, tracked)| {
            let robots = station.robots().iter().enumerate();
            let robots =
                robots.filter(|(index, _)| tracked.is_open_to(*index) && is_at_work(*index));
            let closes = robots.filter_map(|(_, robot)| {
                let place = tracked.place + travelled;
                let (_, close) = robot.departure_window(station.belt(), place, tracked.y)?;
                Some(close).filter(|close| *close >= now)
            });
            closes.reduce(f64::max)
        });
        losses.reduce(f64::min)
    }
}
