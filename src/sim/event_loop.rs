//! The general engine: any strategy, any station, observers.

use super::claims::Claims;
use super::queue::Queue;
use super::scene::Scene;
use crate::decision::{
    Action, BeltItem, Candidate, Event, Miss, MissReason, Moment, Observer, Outcome, Pick,
    RobotFigures, Snapshot, Strategy,
};
use crate::dispatch::{RuleAssignment, RuleStrategy};
use crate::error::{Error, Result};
use crate::kinematics;
use nalgebra::Point2;

/// Runs `strategy` on `scene`.
///
/// # Errors
/// An action that the model forbids.
pub fn simulate(scene: &Scene, strategy: &mut dyn Strategy) -> Result<Outcome> {
    simulate_observed(scene, strategy, None)
}

/// Runs a rule assignment, which never acts illegally, on `scene`.
///
/// # Errors
/// Another number of rules than robots.
pub fn simulate_rules(scene: &Scene, rules: &RuleAssignment) -> Result<Outcome> {
    let rules = rules.clone().for_robots(scene.station().robots().len())?;
    simulate(scene, &mut RuleStrategy(rules))
}

/// As [`simulate`], telling `observer` every event in order of time.
///
/// # Errors
/// As for [`simulate`].
pub fn simulate_observed(
    scene: &Scene,
    strategy: &mut dyn Strategy,
    observer: Option<&mut dyn Observer>,
) -> Result<Outcome> {
    let mut run = Run::new(scene, observer);
    while let Some((robot, time)) = run.next_decision() {
        run.decide(robot, time, strategy)?;
    }
    Ok(run.finish())
}

struct Run<'a, 'o> {
    scene: &'a Scene<'a>,
    queues: Vec<Queue>,
    /// For each robot a lower bound of its next decision [s]; it can only be late,
    /// as claims by others only take items away.
    decisions: Vec<Option<f64>>,
    claims: Claims,
    /// Items that were a candidate of some robot at some decision.
    offered: Claims,
    free_at: Vec<f64>,
    candidates: Vec<Candidate>,
    view: View,
    robots: Vec<RobotFigures>,
    picks: Vec<Pick>,
    announcer: Option<Announcer<'o>>,
}

impl<'a, 'o> Run<'a, 'o> {
    fn new(scene: &'a Scene<'a>, observer: Option<&'o mut dyn Observer>) -> Self {
        let robots = scene.station().robots().len();
        let items = scene.pattern().len();
        Self {
            scene,
            queues: (0..robots).map(|_| Queue::default()).collect(),
            decisions: vec![Some(0.0); robots],
            claims: Claims::none(items),
            offered: Claims::none(items),
            free_at: vec![0.0; robots],
            candidates: Vec::new(),
            view: View::default(),
            robots: vec![RobotFigures::default(); robots],
            picks: Vec::new(),
            announcer: observer.map(|observer| Announcer {
                observer,
                pending: Vec::new(),
                leaving: 0,
            }),
        }
    }

    /// The robot that decides next and when: the earliest, ties to the one listed
    /// first.
    fn next_decision(&mut self) -> Option<(usize, f64)> {
        loop {
            let mut first: Option<(usize, f64)> = None;
            for (robot, time) in self.decisions.iter().enumerate() {
                if let Some(time) = *time
                    && first.is_none_or(|(_, earliest)| time < earliest)
                {
                    first = Some((robot, time));
                }
            }
            let (robot, time) = first?;
            let claimed = |item| self.claims.contains(item);
            let queue = self.scene.queue(robot);
            let now = self.queues[robot].next_decision(self.scene, queue, claimed, claimed);
            self.decisions[robot] = now;
            if now == Some(time) {
                return first;
            }
        }
    }

    fn decide(&mut self, robot: usize, time: f64, strategy: &mut dyn Strategy) -> Result<()> {
        self.candidates.clone_from(&self.queues[robot].active);
        self.candidates.sort_unstable_by_key(|c| c.item);
        for candidate in &self.candidates {
            self.offered.insert(candidate.item);
        }
        for (free_at, queue) in self.free_at.iter_mut().zip(&self.queues) {
            *free_at = queue.free;
        }
        if strategy.needs_view() {
            self.view.update(self.scene, &self.claims, time);
        }
        let snapshot = Snapshot {
            station: self.scene.station(),
            time,
            robot,
            candidates: &self.candidates,
            free_at: &self.free_at,
            in_view: &self.view.items,
        };
        if let Some(announcer) = &mut self.announcer {
            announcer.advance(self.scene, &self.claims, time);
        }
        let action = strategy.decide(&snapshot);
        let illegal = |problem: String| Error::IllegalAction {
            time,
            robot,
            problem,
        };
        let free = match action {
            Action::Pick(place) => {
                let candidate = self.candidates.get(place).ok_or_else(|| {
                    let count = self.candidates.len();
                    illegal(format!("candidate {place} of {count}"))
                })?;
                let pick = make_pick(&snapshot.moment(), robot, candidate);
                self.claims.insert(pick.item);
                self.robots[robot].picked += 1;
                self.robots[robot].weight += candidate.weight;
                self.robots[robot].busy += pick.release - time;
                self.picks.push(pick);
                pick.release
            }
            Action::WaitUntil(until) if until > time => until,
            Action::WaitUntil(until) => {
                return Err(illegal(format!(
                    "a wait until {until} s, which is not later"
                )));
            }
            Action::WaitForNextWindow => self.queues[robot]
                .next_opening(self.scene.queue(robot), &|item| self.claims.contains(item))
                .unwrap_or(f64::INFINITY),
        };
        if let Some(announcer) = &mut self.announcer {
            announcer.observer.observe(&Event::Decision {
                snapshot: &snapshot,
                action,
            });
            if let (Action::Pick(_), Some(pick)) = (action, self.picks.last()) {
                announcer.pending.push(*pick);
            }
        }
        self.queues[robot].free = free;
        self.decisions[robot] = Some(free);
        Ok(())
    }

    fn finish(mut self) -> Outcome {
        if let Some(announcer) = &mut self.announcer {
            announcer.advance(self.scene, &self.claims, f64::INFINITY);
        }
        let items = self.scene.pattern().len();
        let last_release = self.picks.iter().map(|p| p.release).fold(0.0, f64::max);
        let weight = self.robots.iter().map(|robot| robot.weight).sum();
        let missed = (0..items as u32)
            .filter(|&item| !self.claims.contains(item))
            .map(|item| Miss {
                item,
                reason: self.reason(item),
            })
            .collect();
        Outcome {
            figures: self.scene.figures(
                self.picks.len(),
                weight,
                last_release,
                self.claims.last_missing(items),
            ),
            robots: self.robots,
            picks: self.picks,
            missed,
        }
    }

    fn reason(&self, item: u32) -> MissReason {
        if self.offered.contains(item) {
            return MissReason::PassedOver;
        }
        let station = self.scene.station();
        let Some(it) = self.scene.pattern().items().get(item as usize) else {
            return MissReason::Unreachable;
        };
        let reachable = station.robots().iter().any(|robot| {
            robot
                .departure_window(station.belt(), it.x0, it.y)
                .is_some()
        });
        if reachable {
            MissReason::Busy
        } else {
            MissReason::Unreachable
        }
    }
}

/// The pick of `candidate` by a robot that leaves at `at`.
pub(super) fn make_pick(at: &Moment, robot: usize, candidate: &Candidate) -> Pick {
    let travel = at.travel_time(candidate);
    Pick {
        robot,
        item: candidate.item,
        decide: at.time,
        grasp: at.time + travel,
        release: at.time
            + kinematics::processing_time(travel, at.robot.grasp_time, at.robot.release_time),
        meet: Point2::new(at.x(candidate) + at.belt_speed * travel, candidate.y),
    }
}

/// The unclaimed items on the belt. As patterns are sorted, they lie between two
/// indices that only grow.
#[derive(Default)]
struct View {
    items: Vec<BeltItem>,
    first: usize,
    end: usize,
}

impl View {
    fn update(&mut self, scene: &Scene, claims: &Claims, time: f64) {
        let belt = scene.station().belt();
        let items = scene.pattern().items();
        let x = |index: usize| items[index].x0 + belt.speed * time;
        while self.end < items.len() && x(self.end) >= 0.0 {
            self.end += 1;
        }
        while self.first < self.end && x(self.first) > belt.length {
            self.first += 1;
        }
        self.items.clear();
        let unclaimed = (self.first..self.end).filter(|&i| !claims.contains(i as u32));
        self.items.extend(unclaimed.map(|i| BeltItem {
            item: i as u32,
            x: x(i),
            y: items[i].y,
            weight: items[i].reward(),
        }));
    }
}

/// Tells an observer what happens between decisions, in order of time.
struct Announcer<'o> {
    observer: &'o mut dyn Observer,
    /// Picks whose grasp or release is still to come; a few a robot at most.
    pending: Vec<Pick>,
    /// First item that may still leave the belt.
    leaving: usize,
}

impl Announcer<'_> {
    /// Everything that happens up to `now` [s]. At equal times grasps come before
    /// releases before the item that leaves, each in the order of their decisions.
    fn advance(&mut self, scene: &Scene, claims: &Claims, now: f64) {
        loop {
            while self.leaving < scene.pattern().len() && claims.contains(self.leaving as u32) {
                self.leaving += 1;
            }
            let leave = (self.leaving < scene.pattern().len()).then(|| Event::LeftBelt {
                time: scene.leaves_belt(self.leaving),
                item: self.leaving as u32,
            });
            let releases = self.pending.iter().map(|p| Event::Release {
                time: p.release,
                robot: p.robot,
                item: p.item,
            });
            let grasps = self.pending.iter().filter(|p| p.grasp.is_finite());
            let grasps = grasps.map(|p| Event::Grasp {
                time: p.grasp,
                robot: p.robot,
                item: p.item,
            });
            let mut next: Option<Event> = None;
            for event in grasps.chain(releases).chain(leave) {
                if next.as_ref().is_none_or(|n| event.time() < n.time()) {
                    next = Some(event);
                }
            }
            let Some(event) = next.filter(|event| event.time() <= now) else {
                return;
            };
            self.observer.observe(&event);
            match event {
                Event::Grasp { item, .. } => {
                    // Done with; the release of the same pick is still to come.
                    for pick in self.pending.iter_mut().filter(|p| p.item == item) {
                        pick.grasp = f64::INFINITY;
                    }
                }
                Event::Release { item, .. } => self.pending.retain(|p| p.item != item),
                Event::LeftBelt { .. } => self.leaving += 1,
                Event::Decision { .. } => {}
            }
        }
    }
}
