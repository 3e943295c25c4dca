//! A run that goes on from decision to decision, as its caller says.

use super::claims::Claims;
use super::queue::Queue;
use super::scene::Scene;
use super::view::View;
use crate::decision::{
    Action, Candidate, Figures, Miss, MissReason, Moment, Outcome, Pick, RobotFigures, Snapshot,
    Strategy,
};
use crate::error::{Error, Result};
use crate::kinematics;
use nalgebra::Point2;

/// One run on a scene, stepped from outside: [`Run::next_decision`] says who has to
/// decide on what, [`Run::act`] takes the answer.
///
/// The buffers outlive the run ([`Run::into_buffers`]), so that neither a step nor, once
/// they have grown to the size of the scenes, a whole run allocates anything.
///
/// ```
/// use pickline::{decision::Action, pattern::grid, sim, station};
///
/// let station = station::built_in("paper")?.station(Some(2))?;
/// let pattern = grid(station.belt().width, 0.15, 50)?;
/// let scene = sim::Scene::new(&station, &pattern)?;
/// let mut run = sim::Run::new(&scene);
/// while run.next_decision().is_some() {
///     run.act(Action::Pick(0))?;
/// }
/// assert_eq!(run.figures(), sim::simulate_rules(&scene, &"FIFO,FIFO".parse()?)?.figures);
/// # Ok::<(), pickline::error::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Run<'a> {
    scene: &'a Scene<'a>,
    state: RunBuffers,
}

/// What a run keeps between decisions, detached from any scene.
#[derive(Debug, Clone, Default)]
pub struct RunBuffers {
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
    /// Whether the view is filled before every decision.
    looks: bool,
    /// Robot and time [s] of the last decision come to.
    at: (usize, f64),
    /// Whether that decision is still to be taken.
    undecided: bool,
    robots: Vec<RobotFigures>,
    picks: Vec<Pick>,
    last_release: f64,
}

impl RunBuffers {
    fn reset(&mut self, scene: &Scene) {
        let robots = scene.station().robots().len();
        let items = scene.pattern().len();
        // Queues past the last robot stay, with what they have grown to.
        self.queues
            .resize_with(robots.max(self.queues.len()), Queue::default);
        self.queues.iter_mut().for_each(Queue::reset);
        refill(&mut self.decisions, robots, Some(0.0));
        self.claims.reset(items);
        self.offered.reset(items);
        refill(&mut self.free_at, robots, 0.0);
        self.candidates.clear();
        self.view.reset();
        self.looks = true;
        self.at = (0, 0.0);
        self.undecided = false;
        refill(&mut self.robots, robots, RobotFigures::default());
        self.picks.clear();
        self.last_release = 0.0;
    }
}

fn refill<T: Clone>(list: &mut Vec<T>, count: usize, value: T) {
    list.clear();
    list.resize(count, value);
}

impl<'a> Run<'a> {
    /// A run of `scene` from its beginning.
    pub fn new(scene: &'a Scene<'a>) -> Self {
        Self::with_buffers(scene, RunBuffers::default())
    }

    /// As [`Run::new`], in the buffers of an earlier run of any scene.
    pub fn with_buffers(scene: &'a Scene<'a>, buffers: RunBuffers) -> Self {
        let mut state = buffers;
        state.reset(scene);
        Self { scene, state }
    }

    /// The buffers, for the next run.
    pub fn into_buffers(self) -> RunBuffers {
        self.state
    }

    /// Back to the beginning; what [`Run::look`] was told stays.
    pub fn reset(&mut self) {
        let looks = self.state.looks;
        self.state.reset(self.scene);
        self.state.looks = looks;
    }

    /// Whether [`Snapshot::in_view`] is filled, as it is at first; costs time per
    /// decision.
    pub fn look(&mut self, looks: bool) {
        self.state.looks = looks;
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene<'a> {
        self.scene
    }

    /// The state at the next decision, the earliest of all robots', ties to the one
    /// listed first; none when the run is over. Asked again before [`Run::act`] it
    /// gives the same.
    pub fn next_decision(&mut self) -> Option<Snapshot<'_>> {
        if !self.state.undecided {
            self.state.at = self.find_next()?;
            self.state.undecided = true;
            self.look_around();
        }
        Some(self.seen())
    }

    /// The robot that decides next and when [s].
    fn find_next(&mut self) -> Option<(usize, f64)> {
        let state = &mut self.state;
        loop {
            let mut first: Option<(usize, f64)> = None;
            for (robot, time) in state.decisions.iter().enumerate() {
                if let Some(time) = *time
                    && first.is_none_or(|(_, earliest)| time < earliest)
                {
                    first = Some((robot, time));
                }
            }
            let (robot, time) = first?;
            let claimed = |item| state.claims.contains(item);
            let queue = self.scene.queue(robot);
            let now = state.queues[robot].next_decision(self.scene, queue, claimed, claimed);
            state.decisions[robot] = now;
            if now == Some(time) {
                return first;
            }
        }
    }

    /// Fills the buffers that the snapshot of the decision at hand shows.
    fn look_around(&mut self) {
        let state = &mut self.state;
        let (robot, time) = state.at;
        state.candidates.clone_from(&state.queues[robot].active);
        state.candidates.sort_unstable_by_key(|c| c.item);
        for candidate in &state.candidates {
            state.offered.insert(candidate.item);
        }
        for (free_at, queue) in state.free_at.iter_mut().zip(&state.queues) {
            *free_at = queue.free;
        }
        if state.looks {
            state.view.update(self.scene, &state.claims, time);
        }
    }

    /// What the robot saw at the decision last come to, taken or not.
    pub(super) fn seen(&self) -> Snapshot<'_> {
        let (robot, time) = self.state.at;
        Snapshot {
            station: self.scene.station(),
            time,
            robot,
            candidates: &self.state.candidates,
            free_at: &self.state.free_at,
            in_view: &self.state.view.items,
        }
    }

    /// Takes the decision that [`Run::next_decision`] came to. Returns the pick, if it
    /// is one.
    ///
    /// # Errors
    /// An action that the model forbids, or no decision to take: nothing has changed
    /// then, another action may be tried.
    pub fn act(&mut self, action: Action) -> Result<Option<Pick>> {
        let state = &mut self.state;
        let (robot, time) = state.at;
        let illegal = |problem: String| Error::IllegalAction {
            time,
            robot,
            problem,
        };
        if !state.undecided {
            return Err(illegal("no decision is due".into()));
        }
        let mut made = None;
        let free = match action {
            Action::Pick(place) => {
                let candidate = state.candidates.get(place).ok_or_else(|| {
                    let count = state.candidates.len();
                    illegal(format!("candidate {place} of {count}"))
                })?;
                let at = Moment::new(self.scene.station(), robot, time);
                let pick = make_pick(&at, robot, candidate);
                state.claims.insert(pick.item);
                state.robots[robot].picked += 1;
                state.robots[robot].weight += candidate.weight;
                state.robots[robot].busy += pick.release - time;
                state.last_release = state.last_release.max(pick.release);
                state.picks.push(pick);
                made = Some(pick);
                pick.release
            }
            Action::WaitUntil(until) if until > time => until,
            Action::WaitUntil(until) => {
                return Err(illegal(format!(
                    "a wait until {until} s, which is not later"
                )));
            }
            Action::WaitForNextWindow => state.queues[robot]
                .next_opening(self.scene.queue(robot), &|item| state.claims.contains(item))
                .unwrap_or(f64::INFINITY),
        };
        state.queues[robot].free = free;
        state.decisions[robot] = Some(free);
        state.undecided = false;
        Ok(made)
    }

    /// Lets `strategy` take every decision that is left.
    ///
    /// # Errors
    /// An action that the model forbids.
    pub fn play(&mut self, strategy: &mut dyn Strategy) -> Result<()> {
        self.look(strategy.needs_view());
        while let Some(snapshot) = self.next_decision() {
            let action = strategy.decide(&snapshot);
            self.act(action)?;
        }
        Ok(())
    }

    /// The figures, as if nothing further were picked.
    pub fn figures(&self) -> Figures {
        let state = &self.state;
        let weight = state.robots.iter().map(|robot| robot.weight).sum();
        let last_missing = state.claims.last_missing(self.scene.pattern().len());
        let picked = state.picks.len();
        self.scene
            .figures(picked, weight, state.last_release, last_missing)
    }

    /// What each robot did so far, upstream first.
    pub fn robots(&self) -> &[RobotFigures] {
        &self.state.robots
    }

    /// The picks so far, in order of decision, ties in robot order.
    pub fn picks(&self) -> &[Pick] {
        &self.state.picks
    }

    /// The run, as if nothing further were picked.
    pub fn outcome(&self) -> Outcome {
        self.clone().into_outcome()
    }

    /// As [`Run::outcome`], without a copy.
    pub fn into_outcome(self) -> Outcome {
        let missed = (0..self.scene.pattern().len() as u32)
            .filter(|&item| !self.state.claims.contains(item))
            .map(|item| Miss {
                item,
                reason: self.reason(item),
            })
            .collect();
        Outcome {
            figures: self.figures(),
            missed,
            robots: self.state.robots,
            picks: self.state.picks,
        }
    }

    fn reason(&self, item: u32) -> MissReason {
        if self.state.offered.contains(item) {
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

    /// What is claimed.
    pub(super) fn claims(&self) -> &Claims {
        &self.state.claims
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
