//! A robot: it moves as its task says, and picks what is there.

use super::truth::{Fate, Found, Truth};
use pickline::station;
use pickline_live::protocol::{
    Ack, Incoming, Outgoing, ResultMessage, RobotState, RobotStatus, Task, Verdict,
};
use rand::{Rng, RngExt as _};
use std::collections::BTreeMap;

/// Arms are quicker than their station file says, by what an integrator leaves as a margin.
const MARGIN: f64 = 1.05;
/// Time from a robot to the node [s].
const WAY: f64 = 0.003;

/// How a robot says what it is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tells {
    /// When somebody connects, and after a fault.
    Changes,
    /// Also when it sets out, with the time at which it is back.
    Work,
    /// Every 0.25 s what it did 60 ms ago, with the last task that it knew of then.
    Cycle,
}

/// What goes wrong with a robot.
#[derive(Debug, Clone, Copy)]
pub struct Habits {
    pub tells: Tells,
    /// Share of acknowledgements that nobody hears.
    pub lost_acks: f64,
    /// Share of grasps that fail.
    pub failing: f64,
    /// Share of results that come up to 3 s late.
    pub late: f64,
    /// Share of results that come 6 s to 20 s late, when nobody waits any more.
    pub very_late: f64,
}

/// What a robot is doing.
#[derive(Debug, Clone, Copy)]
enum Phase {
    Waits {
        leaves: f64,
    },
    Out {
        from: [f64; 2],
        left: f64,
        arrives: f64,
    },
    Back {
        item: Option<usize>,
        verdict: Verdict,
        done: f64,
    },
}

#[derive(Debug, Clone)]
struct Work {
    task: Task,
    phase: Phase,
}

/// What robots have found, and what should not have been asked of them.
#[derive(Debug, Clone, Default)]
pub struct Finds {
    pub grasped: usize,
    pub failed: usize,
    /// Distances of items that were beside the gripper [m].
    pub beside: Vec<f64>,
    pub taken: usize,
    pub nothing: usize,
    /// Tasks that came while there was another one.
    pub second: usize,
    /// Tasks that came too late.
    pub refused: usize,
}

/// A robot.
pub struct Robot<R> {
    index: usize,
    plan: station::Robot,
    habits: Habits,
    /// When it has faults: from, to [s].
    faults: Vec<(f64, f64)>,
    is_down: bool,
    work: Option<Work>,
    /// When it is at its bin again [s].
    rests_from: f64,
    /// Results that it has given.
    done: BTreeMap<u64, ResultMessage>,
    last_task: Option<u64>,
    /// What it did and knew of, for its state word: since when, state, task.
    words: Vec<(f64, RobotState, Option<u64>)>,
    next_word: f64,
    rng: R,
    pub finds: Finds,
}

/// Messages with the time at which they arrive.
pub type Sent = Vec<(f64, Incoming)>;

fn way(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

impl<R: Rng> Robot<R> {
    pub fn new(
        index: usize,
        plan: station::Robot,
        habits: Habits,
        faults: Vec<(f64, f64)>,
        start: f64,
        rng: R,
    ) -> Self {
        Self {
            index,
            plan,
            habits,
            faults,
            is_down: false,
            work: None,
            rests_from: start,
            done: BTreeMap::new(),
            last_task: None,
            words: vec![(f64::NEG_INFINITY, RobotState::Idle, None)],
            next_word: start,
            rng,
            finds: Finds::default(),
        }
    }

    pub fn name(&self) -> &str {
        &self.plan.name
    }

    pub fn is_working(&self) -> bool {
        self.work.is_some() || self.is_down
    }

    fn happens(&mut self, share: f64) -> bool {
        self.rng.random::<f64>() < share
    }

    fn bin(&self) -> [f64; 2] {
        [self.plan.bins[0].at.x, self.plan.bins[0].at.y]
    }

    fn state(&self) -> RobotState {
        match (self.is_down, &self.work) {
            (true, _) => RobotState::Fault,
            (false, Some(_)) => RobotState::Busy,
            (false, None) => RobotState::Idle,
        }
    }

    /// Keeps what it does now for its state word.
    fn note(&mut self, now: f64) {
        let (state, task) = (self.state(), self.last_task);
        self.words.push((now, state, task));
        let old = self.words.len().saturating_sub(20);
        self.words.drain(..old);
    }

    fn says(&self, now: f64, state: RobotState, available_at: Option<f64>) -> Incoming {
        let task = self.last_task.filter(|_| self.habits.tells == Tells::Cycle);
        Incoming::Robot(RobotStatus {
            stamp: now,
            name: self.plan.name.clone(),
            state,
            available_at,
            task,
        })
    }

    /// What it says to whom it has connected.
    pub fn introduce(&self, now: f64) -> Incoming {
        self.says(now, self.state(), None)
    }

    /// When it does something next [s].
    pub fn next(&self) -> f64 {
        let fault =
            self.faults.first().map_or(
                f64::INFINITY,
                |fault| {
                    if self.is_down { fault.1 } else { fault.0 }
                },
            );
        let work = match &self.work {
            _ if self.is_down => f64::INFINITY,
            None => f64::INFINITY,
            Some(work) => match work.phase {
                Phase::Waits { leaves } => leaves,
                Phase::Out { arrives, .. } => arrives,
                Phase::Back { done, .. } => done,
            },
        };
        let word = match self.habits.tells {
            Tells::Cycle => self.next_word,
            _ => f64::INFINITY,
        };
        fault.min(work).min(word)
    }

    fn result(
        &mut self,
        now: f64,
        task: u64,
        verdict: Verdict,
        available_at: Option<f64>,
    ) -> Incoming {
        let report = ResultMessage {
            stamp: now,
            task,
            result: verdict,
            available_at,
            found: None,
        };
        self.done.insert(task, report);
        Incoming::Result(report)
    }

    /// Takes a message from the node.
    pub fn hear(&mut self, now: f64, message: &Outgoing) -> Sent {
        let mut sent = Sent::new();
        match message {
            _ if self.is_down => {}
            Outgoing::Task(task) => self.hear_task(now, task, &mut sent),
            Outgoing::Cancel(cancel) => {
                let here = self
                    .work
                    .as_ref()
                    .filter(|work| work.task.id == cancel.task);
                match here.map(|work| work.phase) {
                    Some(Phase::Back { .. }) => {}
                    Some(phase) => {
                        let back = way(self.place(phase, now), self.bin())
                            / self.plan.arm.constant_speed().unwrap();
                        self.rests_from = now + back;
                        self.work = None;
                        let free = Some(self.rests_from);
                        let answer = self.result(now, cancel.task, Verdict::Cancelled, free);
                        sent.push((now + WAY, answer));
                        self.note(now);
                    }
                    None => sent.push((now + WAY, self.say_again(now, cancel.task))),
                }
            }
            Outgoing::Status(_) | Outgoing::Due(_) | Outgoing::BeltRequest(_) => {}
        }
        sent
    }

    /// What came of a task that is not at work.
    fn say_again(&mut self, now: f64, task: u64) -> Incoming {
        match self.done.get(&task) {
            Some(report) => Incoming::Result(ResultMessage {
                stamp: now,
                available_at: None,
                ..*report
            }),
            None => self.result(now, task, Verdict::Cancelled, None),
        }
    }

    fn hear_task(&mut self, now: f64, task: &Task, sent: &mut Sent) {
        if self.done.contains_key(&task.id) {
            let again = self.say_again(now, task.id);
            sent.push((now + WAY, again));
            return;
        }
        if let Some(work) = &self.work
            && work.task.id != task.id
        {
            self.finds.second += 1;
            let no = self.result(now, task.id, Verdict::Rejected, None);
            sent.push((now + WAY, no));
            return;
        }
        let phase = match &self.work {
            Some(work) => match work.phase {
                Phase::Waits { .. } => None,
                Phase::Back { .. } => Some(work.phase),
                // The arm goes on to the new place.
                phase @ Phase::Out { .. } => {
                    let from = self.place(phase, now);
                    let takes = way(from, [task.meet.x, task.meet.y])
                        / (MARGIN * self.plan.arm.constant_speed().unwrap());
                    Some(Phase::Out {
                        from,
                        left: now,
                        arrives: task.meet_at.max(now + takes),
                    })
                }
            },
            None if now > task.latest_start + 1e-3 => {
                self.finds.refused += 1;
                let no = self.result(now, task.id, Verdict::Rejected, None);
                sent.push((now + WAY, no));
                return;
            }
            None => None,
        };
        let phase = phase.unwrap_or(Phase::Waits {
            leaves: task.start.max(self.rests_from).max(now),
        });
        self.work = Some(Work {
            task: task.clone(),
            phase,
        });
        self.last_task = Some(task.id);
        self.note(now);
        if !self.happens(self.habits.lost_acks) {
            let ack = Ack {
                stamp: now,
                task: task.id,
            };
            sent.push((now + WAY, Incoming::Ack(ack)));
        }
    }

    /// Where its gripper is.
    fn place(&self, phase: Phase, now: f64) -> [f64; 2] {
        let Some(work) = &self.work else {
            return self.bin();
        };
        match phase {
            Phase::Out {
                from,
                left,
                arrives,
            } => {
                let to = [work.task.meet.x, work.task.meet.y];
                let share = ((now - left) / (arrives - left).max(1e-9)).clamp(0.0, 1.0);
                [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
            }
            Phase::Waits { .. } | Phase::Back { .. } => self.bin(),
        }
    }

    /// Does what is to be done by `now`.
    pub fn advance(&mut self, now: f64, truth: &mut Truth) -> Sent {
        let mut sent = Sent::new();
        if let Some((from, to)) = self.faults.first().copied() {
            if !self.is_down && now >= from {
                self.break_down(now, to, truth);
                sent.push((now + WAY, self.says(now, RobotState::Fault, None)));
            } else if self.is_down && now >= to {
                self.is_down = false;
                self.faults.remove(0);
                self.note(now);
                sent.push((now + WAY, self.says(now, self.state(), None)));
            }
        }
        if !self.is_down {
            self.work_on(now, truth, &mut sent);
        }
        if self.habits.tells == Tells::Cycle && now >= self.next_word {
            self.next_word = now + 0.25;
            let word = self.words.iter().rev().find(|word| word.0 <= now - 0.06);
            if let Some((_, state, task)) = word.copied() {
                sent.push((
                    now + WAY,
                    Incoming::Robot(RobotStatus {
                        // Its controller stamps what it reads.
                        stamp: now - 0.06,
                        name: self.plan.name.clone(),
                        state,
                        available_at: None,
                        task,
                    }),
                ));
            }
        }
        sent
    }

    /// A fault: what it is on its way to is given up; what it holds it keeps or drops.
    fn break_down(&mut self, now: f64, to: f64, truth: &mut Truth) {
        self.is_down = true;
        self.note(now);
        let Some(work) = self.work.take() else {
            return;
        };
        if let Phase::Back {
            item,
            verdict,
            done,
        } = work.phase
        {
            let drops = self.happens(0.5);
            match item {
                Some(item) if drops => truth.fates[item] = Fate::Dropped,
                _ => {
                    let phase = Phase::Back {
                        item,
                        verdict,
                        done: done.max(to + 0.5),
                    };
                    self.work = Some(Work { phase, ..work });
                }
            }
        }
        self.rests_from = to;
    }

    fn work_on(&mut self, now: f64, truth: &mut Truth, sent: &mut Sent) {
        let Some(work) = &self.work else {
            return;
        };
        let (task, meet) = (work.task.id, [work.task.meet.x, work.task.meet.y]);
        match work.phase {
            Phase::Waits { leaves } if now >= leaves => {
                let from = self.bin();
                let takes = way(from, meet) / (MARGIN * self.plan.arm.constant_speed().unwrap());
                let arrives = work.task.meet_at.max(now + takes);
                let free_at = work.task.free_at;
                self.set(Phase::Out {
                    from,
                    left: now,
                    arrives,
                });
                if self.habits.tells == Tells::Work {
                    sent.push((now + WAY, self.says(now, RobotState::Busy, Some(free_at))));
                }
            }
            Phase::Out { arrives, .. } if now >= arrives => {
                let found = truth.find(meet, now);
                let fails = self.happens(self.habits.failing);
                let (item, verdict) = match found {
                    Found::Item(_) if fails => {
                        self.finds.failed += 1;
                        (None, Verdict::GraspFail)
                    }
                    Found::Item(item) => {
                        self.finds.grasped += 1;
                        truth.fates[item] = Fate::Held;
                        (Some(item), Verdict::Picked)
                    }
                    Found::Beside(way) => {
                        self.finds.beside.push(way);
                        (None, Verdict::Missed)
                    }
                    Found::Taken => {
                        self.finds.taken += 1;
                        (None, Verdict::Missed)
                    }
                    Found::Nothing => {
                        self.finds.nothing += 1;
                        (None, Verdict::Missed)
                    }
                };
                let back = way(meet, self.bin()) / self.plan.arm.constant_speed().unwrap();
                let done = now + self.plan.grasp_time + back + self.plan.bins[0].release_time;
                self.set(Phase::Back {
                    item,
                    verdict,
                    done,
                });
            }
            Phase::Back {
                item,
                verdict,
                done,
            } if now >= done => {
                self.work = None;
                self.rests_from = now;
                if let Some(item) = item {
                    truth.fates[item] = Fate::InBin(self.index);
                }
                let late = if self.happens(self.habits.very_late) {
                    self.rng.random_range(6.0..20.0)
                } else if self.happens(self.habits.late) {
                    self.rng.random_range(0.1..3.0)
                } else {
                    0.0
                };
                let result = self.result(now, task, verdict, None);
                sent.push((now + WAY + late, result));
                self.note(now);
            }
            _ => {}
        }
    }

    fn set(&mut self, phase: Phase) {
        if let Some(work) = &mut self.work {
            work.phase = phase;
        }
    }
}
