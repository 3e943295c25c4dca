//! Simulates base assignments forward over the items in view.
//!
//! Rollout (Bertsekas, Tsitsiklis and Wu 1997, DOI 10.1023/A:1009635226865): a partial plan is
//! worth its completion by a base strategy. Parallel rollout (Chang, Givan and Chong 2004, DOI
//! 10.1023/B:DISC.0000028199.78776.c4) takes the best of several bases.

use super::horizon::Horizon;
use super::meter::Meter;
use super::plan::{NOBODY, PickPlan, PlanScore};
use crate::decision::{Candidate, Moment};
use crate::dispatch::{Rule, RuleAssignment};
use crate::station::Station;

/// Reusable buffers of rollouts.
#[derive(Debug, Default)]
pub(super) struct Rollout {
    robots: Vec<RobotProgress>,
    trial: PickPlan,
}

/// The state of one robot during a rollout.
#[derive(Debug, Default)]
struct RobotProgress {
    /// Index in its queue of the first item whose window has not opened yet.
    next: usize,
    /// Items with open windows that may still be picked.
    active: Vec<Candidate>,
    /// Those of them that the robot can leave for at its next decision, if it has several places.
    ready: Vec<Candidate>,
    free: f64,
    /// Where its arm is then.
    place: u16,
    /// Lower bound of its next decision [s]; `None` if it is done.
    decision: Option<f64>,
}

/// The input of a rollout: the line and the bases.
#[derive(Clone, Copy)]
pub(super) struct Bases<'a> {
    pub station: &'a Station,
    pub horizon: &'a Horizon,
    pub assignments: &'a [RuleAssignment],
}

/// The size of a search over first decisions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Number of decisions.
    pub depth: usize,
    /// Number of partial plans that are kept from one decision to the next.
    pub width: usize,
}

/// The best plan so far.
#[derive(Debug)]
pub(super) struct BestPlan<'p> {
    pub plan: &'p mut PickPlan,
    pub score: PlanScore,
}

impl Rollout {
    /// Completes `start` with every base; a completion better than `best` replaces it. Returns
    /// the best completion's score; `None` if time was up before.
    pub(super) fn complete(
        &mut self,
        bases: Bases,
        start: &PickPlan,
        best: &mut BestPlan,
        meter: &mut Meter,
    ) -> Option<PlanScore> {
        let mut trial = std::mem::take(&mut self.trial);
        let mut highest: Option<PlanScore> = None;
        for base in bases.assignments {
            trial.copy_from(start);
            if !self.extend(bases, base.rules(), &mut trial, meter) {
                highest = None;
                break;
            }
            let score = trial.score(bases.horizon);
            if highest.is_none_or(|other| score.beats(&other)) {
                highest = Some(score);
            }
            if score.beats(&best.score) {
                best.score = score;
                std::mem::swap(best.plan, &mut trial);
            }
        }
        self.trial = trial;
        highest
    }

    /// Tries every candidate for the first decisions of `beam` and keeps the best partial plans
    /// from one to the next; a depth of 1 is the classical rollout.
    pub(super) fn search(
        &mut self,
        bases: Bases,
        beam: Beam,
        best: &mut BestPlan,
        meter: &mut Meter,
    ) {
        let mut beginnings = vec![PickPlan::default()];
        beginnings[0].clear(bases.horizon);
        for _ in 0..beam.depth {
            let mut tried: Vec<(PlanScore, PickPlan)> = Vec::new();
            for beginning in &beginnings {
                let Some((robot, time, places)) = self.choices(bases.horizon, beginning) else {
                    continue;
                };
                for place in places {
                    if meter.share() >= 1.0 {
                        return;
                    }
                    let mut next = beginning.clone();
                    next.push(bases.horizon, robot, place, time);
                    let Some(score) = self.complete(bases, &next, best, meter) else {
                        return;
                    };
                    tried.push((score, next));
                }
            }
            // The sort is stable, so equal plans stay in order.
            tried.sort_by(|(a, _), (b, _)| a.compare(b).reverse());
            tried.truncate(beam.width);
            beginnings = tried.into_iter().map(|(_, plan)| plan).collect();
        }
    }

    /// Continues `plan` as if every robot followed its rule after its planned stops, with the
    /// model's order of decisions (`docs/model.md`): the earliest first, ties to the robot
    /// listed first. Returns whether it was completed in time.
    fn extend(
        &mut self,
        bases: Bases,
        rules: &[Rule],
        plan: &mut PickPlan,
        meter: &mut Meter,
    ) -> bool {
        let horizon = bases.horizon;
        self.begin(horizon, plan);
        while let Some((robot, time)) = self.next_decision(horizon, &plan.owner) {
            let arm = &mut self.robots[robot];
            let at = Moment::new(bases.station, robot, usize::from(arm.place), time);
            let choice = if horizon.has_places(robot) {
                let chosen = arm.ready[rules[robot].choose(&at, &arm.ready)].item;
                // These are some of the active ones.
                let mut active = arm.active.iter();
                active.position(|c| c.item == chosen).unwrap_or(0)
            } else {
                rules[robot].choose(&at, &arm.active)
            };
            let candidate = arm.active.swap_remove(choice);
            arm.free = plan.push(horizon, robot, candidate.item, time);
            arm.place = candidate.bin;
            arm.decision = Some(arm.free);
            meter.spend(1);
            if meter.is_late() {
                return false;
            }
        }
        true
    }

    fn begin(&mut self, horizon: &Horizon, plan: &PickPlan) {
        self.robots
            .resize_with(horizon.robots(), RobotProgress::default);
        for (robot, arm) in self.robots.iter_mut().enumerate() {
            arm.next = 0;
            arm.active.clear();
            arm.free = plan.done(horizon, robot);
            arm.place = plan.place(horizon, robot);
            arm.decision = arm.free.is_finite().then_some(arm.free);
        }
    }

    /// The first decision after `plan`: robot, time [s] and its candidates, downstream first.
    fn choices(&mut self, horizon: &Horizon, plan: &PickPlan) -> Option<(usize, f64, Vec<u32>)> {
        self.begin(horizon, plan);
        let (robot, time) = self.next_decision(horizon, &plan.owner)?;
        let arm = &self.robots[robot];
        let ready = match horizon.has_places(robot) {
            true => &arm.ready,
            false => &arm.active,
        };
        let mut places: Vec<u32> = ready.iter().map(|candidate| candidate.item).collect();
        places.sort_unstable();
        Some((robot, time, places))
    }

    fn next_decision(&mut self, horizon: &Horizon, owner: &[u16]) -> Option<(usize, f64)> {
        loop {
            let mut first: Option<(usize, f64)> = None;
            for (robot, arm) in self.robots.iter().enumerate() {
                if let Some(time) = arm.decision
                    && first.is_none_or(|(_, earliest)| time < earliest)
                {
                    first = Some((robot, time));
                }
            }
            let (robot, time) = first?;
            let arm = &mut self.robots[robot];
            let decision = if horizon.has_places(robot) {
                arm.find_decision_from_place(horizon, robot, owner)
            } else {
                arm.find_decision(&horizon.queues[robot], owner)
            };
            self.robots[robot].decision = decision;
            if decision == Some(time) {
                return first;
            }
        }
    }
}

impl RobotProgress {
    /// When the robot decides next [s]; `active` then holds its candidates.
    fn find_decision(&mut self, queue: &[Candidate], owner: &[u16]) -> Option<f64> {
        let taken = |candidate: &Candidate| owner[candidate.item as usize] != NOBODY;
        self.open_until(queue, self.free, owner);
        let mut opened = f64::INFINITY;
        self.active.retain(|c| {
            let stays = c.close >= self.free && !taken(c);
            if stays {
                opened = opened.min(c.open);
            }
            stays
        });
        if self.active.is_empty() {
            while taken(queue.get(self.next)?) {
                self.next += 1;
            }
            opened = queue[self.next].open;
        }
        let time = self.free.max(opened);
        self.open_until(queue, time, owner);
        Some(time)
    }

    /// The same for a robot with several places; `ready` then holds its candidates.
    fn find_decision_from_place(
        &mut self,
        horizon: &Horizon,
        robot: usize,
        owner: &[u16],
    ) -> Option<f64> {
        let queue = &horizon.queues[robot];
        let (from, place) = (self.free, self.place);
        let last_close = |item: u32| horizon.reach(robot, item).close;
        self.active
            .retain(|c| owner[c.item as usize] == NOBODY && last_close(c.item) >= from);
        for candidate in &mut self.active {
            (candidate.open, candidate.close) = horizon.window(robot, place, candidate.item);
        }
        let leaves = |c: &Candidate| match c.open <= c.close && c.close >= from {
            true => c.open.max(from),
            false => f64::INFINITY,
        };
        let mut time = self.active.iter().map(leaves).fold(f64::INFINITY, f64::min);
        // From here, an item opens no earlier than its first opening from anywhere.
        while let Some(&candidate) = queue.get(self.next)
            && candidate.open <= time
        {
            self.next += 1;
            if owner[candidate.item as usize] == NOBODY && candidate.close >= from {
                let (open, close) = horizon.window(robot, place, candidate.item);
                let candidate = Candidate {
                    open,
                    close,
                    ..candidate
                };
                time = time.min(leaves(&candidate));
                self.active.push(candidate);
            }
        }
        self.ready.clear();
        let can_leave = |c: &&Candidate| (c.open..=c.close).contains(&time);
        self.ready.extend(self.active.iter().filter(can_leave));
        (time < f64::INFINITY).then_some(time)
    }

    fn open_until(&mut self, queue: &[Candidate], time: f64, owner: &[u16]) {
        while let Some(candidate) = queue.get(self.next)
            && candidate.open <= time
        {
            if owner[candidate.item as usize] == NOBODY && candidate.close >= time {
                self.active.push(*candidate);
            }
            self.next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Pattern, grid};
    use crate::planning::meter::Budget;
    use crate::planning::options::Goal;
    use crate::sim::{Conditions, Scene, simulate_rules};
    use crate::station::built_in;

    /// What completing nothing with `bases` returns, and the best plan and its score then.
    fn complete(
        (station, pattern): (&Station, &Pattern),
        bases: &[RuleAssignment],
        meter: &mut Meter,
    ) -> (Option<PlanScore>, PickPlan, PlanScore) {
        let horizon = Horizon::of_all(station, pattern, &[0.0, 0.0], Goal::Picks);
        let bases = Bases {
            station,
            horizon: &horizon,
            assignments: bases,
        };
        let mut nothing = PickPlan::default();
        nothing.clear(&horizon);
        let mut plan = nothing.clone();
        let score = plan.score(&horizon);
        let mut best = BestPlan {
            plan: &mut plan,
            score,
        };
        let returned = Rollout::default().complete(bases, &nothing, &mut best, meter);
        let score = best.score;
        (returned, plan, score)
    }

    fn dense() -> (Station, Pattern) {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let pattern = grid(station.belt().width, 0.15, 60).unwrap();
        (station, pattern)
    }

    /// With all items in view, a completion is the run of its base.
    #[test]
    fn a_partial_plan_is_valued_by_its_best_base() {
        let (station, pattern) = dense();
        let conditions = Conditions {
            camera_x: Some(-1e6),
            ..Conditions::default()
        };
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let bases: [RuleAssignment; 3] =
            ["FIFO,FIFO", "SPT,FIFO", "SPT,SPT"].map(|text| text.parse().unwrap());
        let picked = bases.each_ref().map(|base| {
            let picked = simulate_rules(&scene, base).unwrap().figures.picked;
            picked as f64
        });
        let most = picked.iter().copied().fold(0.0, f64::max);
        assert!(picked.iter().any(|few| *few < most), "{picked:?}");
        for turn in 0..3 {
            let mut bases = bases.to_vec();
            bases.rotate_left(turn);
            let meter = &mut Meter::new(Budget::Decisions(1));
            let (returned, plan, score) = complete((&station, &pattern), &bases, meter);
            assert_eq!(returned, Some(score));
            assert_eq!((score.value, plan.value), (most, most));
        }
    }

    #[test]
    fn a_completion_that_time_cuts_short_counts_nothing() {
        let (station, pattern) = dense();
        let bases = ["SPT,FIFO".parse().unwrap()];
        let mut late = Meter::of_a_minute(Budget::Time(std::time::Duration::from_secs(30)));
        let (returned, plan, score) = complete((&station, &pattern), &bases, &mut late);
        assert_eq!((returned, score.value), (None, 0.0));
        assert!(plan.routes.iter().all(Vec::is_empty));
    }
}
