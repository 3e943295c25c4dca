//! A run that is stepped from decision to decision by its caller.

use super::attempt::{make_pick, try_pick};
use super::buffers::RunBuffers;
use super::claims::Claims;
use super::queue::QueuedItems;
use super::scene::Scene;
use crate::decision::{
    Action, Failure, Figures, Miss, MissReason, Moment, Outcome, Pick, RobotFigures, Snapshot,
    Strategy, answer,
};
use crate::error::{Error, Result};
use crate::station::Robot;

/// A run on a scene, stepped by its caller: [`Run::next_decision`] returns the next decision, and
/// [`Run::act`] takes the answer.
///
/// The buffers can be reused after the run ([`Run::into_buffers`]). A step does not allocate, nor
/// does a whole run once the buffers have grown to the size of the scenes.
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

impl<'a> Run<'a> {
    /// Starts a run of `scene`.
    pub fn new(scene: &'a Scene<'a>) -> Self {
        Self::with_buffers(scene, RunBuffers::default())
    }

    /// Like [`Run::new`], with the buffers of an earlier run of any scene.
    pub fn with_buffers(scene: &'a Scene<'a>, buffers: RunBuffers) -> Self {
        let mut state = buffers;
        state.reset(scene);
        Self { scene, state }
    }

    /// Returns the buffers, for the next run.
    pub fn into_buffers(self) -> RunBuffers {
        self.state
    }

    /// Returns to the beginning; the setting of [`Run::look`] is kept.
    pub fn reset(&mut self) {
        let looks = self.state.looks;
        self.state.reset(self.scene);
        self.state.looks = looks;
    }

    /// Sets whether [`Snapshot::in_view`] is filled, which costs time per decision. It is filled by
    /// default.
    pub fn look(&mut self, looks: bool) {
        self.state.looks = looks;
    }

    /// The scene that is simulated.
    pub fn scene(&self) -> &'a Scene<'a> {
        self.scene
    }

    /// The state at the next decision, which is the earliest over all robots; on a tie, the robot
    /// listed first decides. `None` if the run is over. Repeated calls before [`Run::act`] return
    /// the same state.
    pub fn next_decision(&mut self) -> Option<Snapshot<'_>> {
        if !self.state.undecided {
            self.state.at = self.find_next()?;
            self.state.undecided = true;
            self.look_around();
        }
        Some(self.seen())
    }

    /// The robot that decides next, and when [s].
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
            if let Some(place) = state.first_ending(first.map(|(_, time)| time)) {
                let (time, item) = state.ending.remove(place);
                state.give_back(self.scene, item, time);
                continue;
            }
            let (robot, time) = first?;
            let claimed = |item| state.claims.contains(item);
            let items = QueuedItems::of(self.scene, robot);
            let now = state.queues[robot].next_decision(self.scene, &items, claimed, claimed);
            state.decisions[robot] = now;
            if now == Some(time) {
                return first;
            }
        }
    }

    /// Fills the buffers for the snapshot of the current decision.
    fn look_around(&mut self) {
        let state = &mut self.state;
        let (robot, time) = state.at;
        let disturbances = &self.scene.conditions().disturbances;
        let active = &mut state.queues[robot].active;
        // Sorted in place, so that next time only newly opened items are unsorted.
        if disturbances.position_noise > 0.0 {
            active.sort_unstable_by(|a, b| b.x0.total_cmp(&a.x0).then(a.item.cmp(&b.item)));
        } else {
            active.sort_unstable_by_key(|c| c.item);
        }
        state.candidates.clone_from(active);
        if self.scene.windows(robot).is_some() {
            // Some can only be met from another place, or later.
            state
                .candidates
                .retain(|c| (c.open..=c.close).contains(&time));
        } else if disturbances.may_fail() {
            // Items that were given back may open later.
            state.candidates.retain(|c| c.open <= time);
        }
        for candidate in &state.candidates {
            state.offered.insert(candidate.item);
        }
        for (index, free_at) in state.free_at.iter_mut().enumerate() {
            let queue = &state.queues[index];
            // Nobody knows how long an outage lasts.
            *free_at = match self.scene.is_down(index, time) {
                true => f64::INFINITY,
                false => queue.free,
            };
            // A robot has at most 100 bins and its rest.
            state.places[index] = queue.place as u16;
        }
        if state.looks {
            state.candidate_odds.clear();
            if !self.scene.is_sure() {
                let odds = state.candidates.iter().map(|c| self.scene.odds(c.item));
                state.candidate_odds.extend(odds);
            }
            state.view.update(self.scene, &state.claims, time);
        }
    }

    /// What the robot saw at the latest decision, whether or not it has been made.
    pub(super) fn seen(&self) -> Snapshot<'_> {
        let (robot, time) = self.state.at;
        Snapshot {
            station: self.scene.station(),
            time,
            robot,
            candidates: &self.state.candidates,
            free_at: &self.state.free_at,
            places: &self.state.places,
            candidate_odds: &self.state.candidate_odds,
            in_view: &self.state.view.items,
        }
    }

    /// Makes the decision that [`Run::next_decision`] returned. Returns the pick if there is one; a
    /// failed attempt returns `None` and is the last entry of [`Run::failures`].
    ///
    /// # Errors
    /// If the model forbids the action, or no decision is due. The run is then unchanged, and
    /// another action may be tried.
    pub fn act(&mut self, action: Action) -> Result<Option<Pick>> {
        let before = self.state.picks.len();
        self.take(action)?;
        Ok(self.state.picks.get(before).copied())
    }

    /// Like [`Run::act`], but does not copy the pick.
    fn take(&mut self, action: Action) -> Result<()> {
        let state = &mut self.state;
        let (robot, time) = state.at;
        let illegal = |problem: String| {
            let robot = &self.scene.station().robots()[robot];
            let cure = "pick a candidate of the decision that is due, or wait until later";
            Err(Error::illegal_action((time, &robot.name), problem, cure))
        };
        if !state.undecided {
            return illegal("no decision is due".into());
        }
        let free = match action {
            Action::Pick(choice) => {
                let Some(candidate) = state.candidates.get(choice) else {
                    let count = state.candidates.len();
                    return illegal(format!("candidate {choice} of {count}"));
                };
                let place = state.queues[robot].place;
                let at = Moment::new(self.scene.station(), robot, place, time);
                state.claims.insert(candidate.item);
                // Even a failed attempt ends at the bin.
                state.queues[robot].place = usize::from(candidate.bin);
                let made = if state.attempts.is_empty() {
                    Ok(make_pick(&at, robot, candidate))
                } else {
                    let attempt = &mut state.attempts[candidate.item as usize];
                    *attempt += 1;
                    try_pick(self.scene, &at, (robot, place), candidate, *attempt - 1)
                };
                let did = &mut state.robots[robot];
                let (release, free) = match made {
                    Ok(pick) => {
                        did.picked += 1;
                        did.weight += candidate.weight;
                        state.picks.push(pick);
                        (pick.release, pick.release)
                    }
                    Err(failure) => {
                        did.failed += 1;
                        let ends = failure.claim_ends(at.robot.grasp_time);
                        state.ending.push((ends, candidate.item));
                        state.failures.push(failure);
                        let release = failure.attempt.release;
                        // An attempt that takes no time must not be repeated forever.
                        (release, release.max(time.next_up()))
                    }
                };
                did.busy += release - time;
                state.last_release = state.last_release.max(release);
                free
            }
            Action::WaitUntil(until) if until > time => until,
            Action::WaitUntil(until) => {
                return illegal(format!("a wait until {until} s, which is not later"));
            }
            Action::NoAnswer => return illegal("no answer".into()),
            Action::WaitForNextWindow => state.queues[robot]
                .next_opening_after(time, &QueuedItems::of(self.scene, robot), &|item| {
                    state.claims.contains(item)
                })
                .unwrap_or(f64::INFINITY),
        };
        let queue = &mut state.queues[robot];
        queue.free = free;
        queue.waits = action == Action::WaitForNextWindow;
        state.decisions[robot] = Some(free);
        state.undecided = false;
        Ok(())
    }

    /// Lets `strategy` make all remaining decisions.
    ///
    /// # Errors
    /// If the strategy is for another number of robots, or takes an action that the model forbids.
    pub fn play(&mut self, strategy: &mut dyn Strategy) -> Result<()> {
        self.play_while(strategy, || true)
    }

    /// Like [`Run::play`], but looks before every decision whether to `go_on`.
    ///
    /// # Errors
    /// See [`Run::play`]; [`Interrupted`](crate::error::ErrorKind::Interrupted) if it is not to go on.
    pub(super) fn play_while(
        &mut self,
        strategy: &mut dyn Strategy,
        go_on: impl Fn() -> bool,
    ) -> Result<()> {
        strategy.check_station(self.scene.station())?;
        self.play_on(strategy, go_on)
    }

    /// Like [`Run::play_while`], also for a strategy that leaves the last robots idle.
    pub(super) fn play_on(
        &mut self,
        strategy: &mut dyn Strategy,
        go_on: impl Fn() -> bool,
    ) -> Result<()> {
        self.look(strategy.needs_view());
        while let Some(snapshot) = self.next_decision() {
            if !go_on() {
                return Err(Error::interrupted());
            }
            let action = answer(strategy, &snapshot)?;
            self.take(action)?;
        }
        Ok(())
    }

    /// The figures if nothing more were picked.
    pub fn figures(&self) -> Figures {
        let state = &self.state;
        let weight = state.robots.iter().map(|robot| robot.weight).sum();
        let unclaimed = state.claims.last_missing(self.scene.pattern().len());
        let given_back = state.ending.iter().map(|(_, item)| *item as usize).max();
        let last_missing = unclaimed.max(given_back);
        let picked = state.picks.len();
        self.scene
            .figures(picked, weight, state.last_release, last_missing)
    }

    /// The figures of each robot so far, upstream first.
    pub fn robots(&self) -> &[RobotFigures] {
        &self.state.robots
    }

    /// The picks so far, in order of decision, ties in robot order.
    pub fn picks(&self) -> &[Pick] {
        &self.state.picks
    }

    /// The failed attempts so far, in the same order.
    pub fn failures(&self) -> &[Failure] {
        &self.state.failures
    }

    /// Whether the item has been picked, or a robot is on its way that will pick it.
    pub(super) fn is_picked(&self, item: u32) -> bool {
        let state = &self.state;
        let claimed = state.claims.contains(item) && !self.scene.not_offered().contains(item);
        claimed && state.ending.iter().all(|(_, other)| *other != item)
    }

    /// The outcome if nothing more were picked.
    pub fn outcome(&self) -> Outcome {
        self.clone().into_outcome()
    }

    /// Like [`Run::outcome`], but does not copy.
    pub fn into_outcome(self) -> Outcome {
        let lost = self.scene.lost_windows();
        let missed = (0..self.scene.pattern().len() as u32)
            .filter(|&item| !self.scene.not_offered().contains(item) && !self.is_picked(item))
            .map(|item| Miss {
                item,
                reason: self.reason(item, &lost),
            })
            .collect();
        let figures = self.figures();
        Outcome {
            figures,
            missed,
            downtimes: self.scene.downtimes().before(figures.end),
            left: self.scene.left().to_vec(),
            robots: self.state.robots,
            picks: self.state.picks,
            failures: self.state.failures,
        }
    }

    /// The first reason that applies; `lost` are the items for which some robot is down during its
    /// window.
    fn reason(&self, item: u32, lost: &Claims) -> MissReason {
        let station = self.scene.station();
        let it = &self.scene.pattern().items()[item as usize];
        let class = it.class_on(station);
        let reachable = |(index, robot): (usize, &Robot)| {
            station.has_bin_for(index, class)
                && robot.widest_window(station.belt(), it.x0, it.y).is_some()
        };
        // Without noise the item is where it was reported, so a window says it, and costs nothing.
        let noise = self.scene.conditions().disturbances.position_noise;
        let surely = noise == 0.0 && self.scene.has_window(item);
        if !surely && !station.robots().iter().enumerate().any(reachable) {
            MissReason::Unreachable
        } else if self.state.attempts.get(item as usize) > Some(&0) {
            MissReason::GraspFailed
        } else if self.state.offered.contains(item) {
            MissReason::PassedOver
        } else if !self.scene.has_window(item) {
            MissReason::Unseen
        } else if lost.contains(item) {
            MissReason::RobotDown
        } else {
            MissReason::Busy
        }
    }
}
