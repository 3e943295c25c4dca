//! What happens in the world, and what the node says to it.

use super::{CAMERA, ENCODER, Event, FIRST_ROBOT, Line, Pace};
use crate::programs::let_pass;
use crate::support::tracker::PERIOD;
use pickline_live::protocol::{BeltState, Incoming, Outgoing, Status, Task};
use rand::RngExt as _;
use std::time::Duration;

/// Time between two messages of the encoder [s].
const ENCODER_PERIOD: f64 = 0.02;
/// Time from the node to a robot [s].
const WAY: f64 = 0.003;

impl Line {
    pub(super) fn send(&mut self, robot: usize, sent: Vec<(f64, Incoming)>) {
        for (at, message) in sent {
            self.at(at, Event::ToNode(FIRST_ROBOT + robot, message));
        }
    }

    pub(super) fn happen(&mut self, event: Event, spoke: &mut [bool], is_killed: &mut bool) {
        let now = self.now;
        match event {
            Event::Picture => {
                self.at(now + PERIOD, Event::Picture);
                let picture = self.tracker.picture(&self.truth.world, now);
                let delay = match self.rng.random_range(0..100) {
                    0 => return,
                    1 => 0.3,
                    _ => self.rng.random_range(0.03..0.05),
                };
                for message in picture {
                    self.at(now + delay, Event::ToNode(CAMERA, message));
                }
            }
            Event::Encoder => {
                self.at(now + ENCODER_PERIOD, Event::Encoder);
                let speed = self.truth.world.speed(now);
                let noise = self.rng.random_range(-1.0..1.0);
                let belt = Incoming::Belt(BeltState {
                    stamp: now,
                    speed: speed + noise * (0.005 * speed).max(1e-5),
                    position: Some((1e4 * self.truth.world.travel(now)).round() / 1e4),
                    source: None,
                });
                self.at(now + 0.002, Event::ToNode(ENCODER, belt));
            }
            Event::ToNode(peer, message) => {
                if self.node.is_up() && self.node.is_connected(peer) {
                    self.node.say(peer, &message);
                    spoke[peer] = true;
                } else if let Incoming::Result(_) = message {
                    self.unsent[peer - FIRST_ROBOT].push(message);
                }
            }
            Event::ToRobot(robot, message) => {
                let sent = self.robots[robot].hear(now, &message);
                self.send(robot, sent);
                if !self.robots[robot].is_working() {
                    self.targets[robot] = None;
                }
            }
            Event::Kill if !self.node.is_up() => {}
            Event::Kill if self.settings.pace == Pace::Messages => *is_killed = true,
            Event::Kill => self.kill(),
            Event::Restart => {
                while self.figures.kills > 0 && self.rng.random_range(0..5) == 0 {
                    let after = Duration::from_micros(self.rng.random_range(0..30_000));
                    self.node.start_in_vain(after);
                    self.figures.kills += 1;
                }
                self.node.start();
                for peer in 0..self.is_cut_off.len() {
                    if !self.is_cut_off[peer] {
                        self.connect(peer);
                    }
                }
            }
            Event::HangUp(peer) => {
                self.node.hang_up(peer);
                self.is_cut_off[peer] = true;
                self.figures.breaks += 1;
                let lasts = self.rng.random_range(0.5..3.0);
                self.at(now + lasts, Event::Reconnect(peer));
            }
            Event::Reconnect(peer) => {
                self.is_cut_off[peer] = false;
                if self.node.is_up() {
                    self.connect(peer);
                }
            }
        }
    }

    /// A peer connects; a robot says how it is, and what it could not say.
    pub(super) fn connect(&mut self, peer: usize) {
        self.node.connect(peer);
        let Some(robot) = peer.checked_sub(FIRST_ROBOT) else {
            return;
        };
        let introduction = self.robots[robot].introduce(self.now);
        self.at(self.now, Event::ToNode(peer, introduction));
        for message in std::mem::take(&mut self.unsent[robot]) {
            self.at(self.now, Event::ToNode(peer, message));
        }
    }

    /// The node is killed, soon after it was last spoken to; and comes back.
    pub(super) fn kill(&mut self) {
        let_pass(Duration::from_micros(self.rng.random_range(0..500)));
        let said = self.node.kill();
        self.figures.kills += 1;
        self.hear(said);
        self.due = f64::INFINITY;
        let back = self.now + self.rng.random_range(0.1..0.8);
        self.at(back, Event::Restart);
    }

    pub(super) fn hear(&mut self, said: Vec<(usize, Outgoing)>) {
        for (peer, message) in said {
            match message {
                Outgoing::Due(due) => self.due = due.next.unwrap_or(f64::INFINITY),
                Outgoing::Status(status) if peer == ENCODER => self.check(*status),
                Outgoing::Task(_) | Outgoing::Cancel(_) => {
                    let Some(robot) = peer.checked_sub(FIRST_ROBOT) else {
                        continue;
                    };
                    if message.robot() != Some(self.robots[robot].name()) {
                        continue;
                    }
                    if let Outgoing::Task(task) = &message {
                        let known = self.tasks.insert(task.id, robot);
                        assert!(known.is_none_or(|known| known == robot), "{task:?}");
                        if known.is_none() {
                            self.aim(robot, task);
                        }
                    }
                    self.at(self.now + WAY, Event::ToRobot(robot, message));
                }
                Outgoing::Status(_) | Outgoing::BeltRequest(_) => {}
            }
        }
    }

    /// A robot gets a new task; is another one after the same item?
    pub(super) fn aim(&mut self, robot: usize, task: &Task) {
        let speed = self.truth.world.speed(self.now);
        let x = task.meet.x - speed * (task.meet_at - self.now);
        let travel = self.truth.world.travel(self.now);
        let items = self.truth.world.items.iter().enumerate();
        let near = items
            .map(|(i, at)| (i, (at[0] + travel - x).hypot(at[1] - task.meet.y)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|near| near.1 < 0.015);
        let target = near.map(|near| near.0);
        if target.is_some() && self.targets.contains(&target) {
            self.figures.two_after_one += 1;
        }
        self.targets[robot] = target;
    }

    /// The figures of a moment against each other and against the world.
    pub(super) fn check(&mut self, status: Status) {
        self.figures.statuses += 1;
        let sum = status.picked + status.missed.total() + status.on_belt + status.claimed;
        assert_eq!(status.seen, sum, "{status:?}");
        let by_robots: u64 = status.robots.iter().map(|robot| robot.picked).sum();
        assert_eq!(by_robots, status.picked, "{status:?}");
        for (index, robot) in status.robots.iter().enumerate() {
            let in_bin = self.truth.in_bin(index) as u64;
            assert!(robot.picked <= in_bin, "{in_bin} in the bin: {robot:?}");
        }
        if let Some(before) = &self.status {
            assert!(status.picked >= before.picked, "{before:?} {status:?}");
        }
        self.status = Some(status);
    }
}
