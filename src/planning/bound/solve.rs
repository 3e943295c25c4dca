//! From a scene to its bound.

use super::options::{BoundObjective, BoundOptions, Chosen, choose_slots};
use super::schedule::schedule;
use super::search::{Effort, SlotSearch};
use crate::decision::{Figures, Outcome};
use crate::error::Result;
use crate::sim::{Disturbances, Scene};
use std::collections::HashSet;

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum BoundStop {
    /// A known schedule reaches the bound, so it is optimal.
    Optimal,
    /// All steps were done, or further steps could change nothing.
    Done,
    /// The search was asked to stop.
    Interrupted,
    /// There are too many items for useful slots; the bound is the trivial one.
    TooManyItems,
}

impl BoundStop {
    /// The name in files: the variant's in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A bound for every strategy.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Bound {
    /// The quantity that is bounded.
    pub objective: BoundObjective,
    /// Upper bound on what any run earns: picks (a whole number) or weight.
    pub value: f64,
    /// The same bound before picks were rounded down to a whole number.
    pub relaxed: f64,
    /// Upper bound on the rate of any run [1/min], weighted for [`BoundObjective::Weight`]; `None`
    /// if no finite bound was found.
    pub rate: Option<f64>,
    /// Lower bound on the end of any run [s].
    pub end: f64,
    /// Lower bound on the end of any run that picks everything [s]; `None` if there is no such
    /// run.
    pub all_end: Option<f64>,
    /// Number of items within reach of at least one robot.
    pub reachable: usize,
    /// The final price of each item: what leaving it to the others is worth.
    pub prices: Vec<f64>,
    /// The best schedule found during the search, with the highest of their rates.
    pub schedule: Option<Outcome>,
    /// Length of the slots [s]; 0 if there were none.
    pub slot_s: f64,
    /// Whether limits on time or memory make the slots so long that shorter ones would prove
    /// clearly more.
    pub coarse: bool,
    /// Number of picks in slots, the size of the networks.
    pub arcs: usize,
    /// Number of steps of the prices.
    pub iterations: usize,
    /// Why the search ended.
    pub stop: BoundStop,
}

impl Bound {
    /// What `figures` earn in terms of the bound's objective.
    pub fn earned(&self, figures: &Figures) -> f64 {
        earned(self.objective, figures)
    }
}

fn earned(objective: BoundObjective, figures: &Figures) -> f64 {
    match objective {
        BoundObjective::Picks => figures.picked as f64,
        BoundObjective::Weight => figures.weight,
    }
}

/// The proven share of `bound` that `earned` reaches [%]: rounded down to a tenth, and 100 only
/// if it reaches the bound.
pub fn certified_percent(earned: f64, bound: f64) -> f64 {
    if bound <= 0.0 {
        // Nothing can be earned, and nothing was earned.
        return 100.0;
    }
    // Sums of weights may be off by rounding errors, but by no more than this.
    let share = (1000.0 * earned / bound * (1.0 + 1e-12)).floor() / 10.0;
    share.clamp(0.0, 100.0)
}

/// Shares of the prices at which schedules are made; which of them is best differs.
const SHARES: [f64; 5] = [0.9, 0.95, 0.98, 0.99, 1.0];
/// Bounds what any strategy can earn on `scene`. `go_on` gets the number of completed steps and
/// the approximate total. If it returns false, the bound so far is returned, which is valid as
/// well.
///
/// # Errors
/// The slots are not possible.
pub fn upper_bound(
    scene: &Scene,
    options: &BoundOptions,
    go_on: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<Bound> {
    let may_fail = scene.conditions().disturbances.may_fail();
    let undisturbed;
    let scene = if scene.conditions().can_go_wrong() {
        undisturbed = without_disturbances(scene)?;
        &undisturbed
    } else {
        scene
    };
    let Some(Chosen { levels, coarse }) = choose_slots(scene, options)? else {
        return Ok(trivial(scene, options));
    };
    let mut effort = Effort {
        steps: 0,
        expected: options.iterations * if options.ends { 1 + levels.len() } else { 1 },
        stopped: false,
        go_on,
    };
    let mut found = Found::new();
    let mut search = SlotSearch::new(scene, may_fail, options, levels[0], None);
    let mut left = options.iterations;
    for level in 0..levels.len() {
        if level > 0 {
            let prices = Some(search.prices());
            search = SlotSearch::new(scene, may_fail, options, levels[level], prices);
        }
        let last = level + 1 == levels.len();
        let steps = if last { left } else { left / 2 };
        left -= steps;
        found.enter(&search);
        if !found.reached_by(options.known) {
            search.earn(steps, options.known, &mut effort);
        }
        let mut others = Vec::new();
        if options.ends {
            others = search.tighten(options.iterations, &mut effort);
        }
        found.enter(&search);
        let settled = !options.ends && found.reached_by(options.known);
        if last || effort.stopped || settled {
            // The figures of a schedule count all of its picks.
            if options.schedule && options.counted.is_none() && !effort.stopped {
                found.make_schedules(scene, options.objective, &search, &others)?;
            }
            break;
        }
    }
    Ok(found.finish(options, coarse, &search, &effort))
}

/// The scene without failures and outages, in which every pick that succeeds on `scene` is a pick:
/// failures and outages only cost time, and failures take an arm to another bin. With noisy positions, a
/// pick succeeds within the window of the true position, whatever the camera reported when.
fn without_disturbances<'a>(scene: &Scene<'a>) -> Result<Scene<'a>> {
    let mut conditions = scene.conditions().clone();
    if conditions.disturbances.position_noise > 0.0 {
        conditions.camera_x = None;
    }
    conditions.disturbances = Disturbances::default();
    conditions.given_outages.clear();
    conditions.random_outages = None;
    Scene::under(scene.station(), scene.pattern(), conditions)
}

/// Bounds that are known without slots.
fn trivial(scene: &Scene, options: &BoundOptions) -> Bound {
    let objective = options.objective;
    let counts = |item: usize| {
        let counted = options.counted.as_ref();
        counted.is_none_or(|counted| counted.get(item).is_none_or(|counts| *counts))
    };
    let mut reachable = vec![None; scene.pattern().len()];
    for robot in 0..scene.station().robots().len() {
        for candidate in scene.queue(robot) {
            let item = candidate.item as usize;
            reachable[item] = Some(match objective {
                _ if !counts(item) => 0.0,
                BoundObjective::Picks => 1.0,
                BoundObjective::Weight => candidate.weight,
            });
        }
    }
    let left: HashSet<u32> = scene.left().iter().map(|left| left.item).collect();
    let mut reaches = (0..).zip(&reachable);
    let all_reachable = reaches.all(|(item, reach)| reach.is_some() || left.contains(&item));
    let sum: f64 = reachable.iter().flatten().sum();
    let value = match objective {
        BoundObjective::Picks => sum,
        // More than a different order of the sum can change.
        BoundObjective::Weight => sum * (1.0 + 1e-9),
    };
    Bound {
        objective,
        value,
        relaxed: value,
        rate: None,
        end: 0.0,
        all_end: all_reachable.then_some(0.0),
        reachable: reachable.iter().flatten().count(),
        prices: reachable.iter().map(|w| w.unwrap_or(0.0)).collect(),
        schedule: None,
        slot_s: 0.0,
        coarse: true,
        arcs: 0,
        iterations: 0,
        stop: BoundStop::TooManyItems,
    }
}

/// The best bounds with slots of any length.
struct Found {
    /// What can be earned, rounded to what picks can be.
    value: f64,
    /// The same before it is rounded.
    relaxed: f64,
    /// The rate [1/min]; infinite if none is known.
    rate: f64,
    /// The end of any run [s].
    end: f64,
    /// The end of a run that picks everything [s]; infinite if there is no such run.
    all_end: f64,
    schedule: Option<Outcome>,
    /// What the schedule earns.
    earned: f64,
}

impl Found {
    /// Nothing yet.
    fn new() -> Self {
        Self {
            value: f64::INFINITY,
            relaxed: f64::INFINITY,
            rate: f64::INFINITY,
            end: 0.0,
            all_end: 0.0,
            schedule: None,
            earned: 0.0,
        }
    }

    /// Whether a schedule that earns `known` is as good as the bound allows.
    fn reached_by(&self, known: f64) -> bool {
        known >= self.value
    }

    /// Enters what `search` has found.
    fn enter(&mut self, search: &SlotSearch) {
        let (dual, ends) = (&search.dual, search.ends());
        let units = search.ascent.best;
        self.value = self.value.min(dual.weight(dual.whole(units)));
        self.relaxed = self.relaxed.min(dual.weight(units));
        let infinite = |bound: Option<(f64, usize)>| bound.map_or(f64::INFINITY, |(at, _)| at);
        self.rate = self.rate.min(infinite(ends.rate));
        self.end = self.end.max(ends.end.map_or(0.0, |(end, _)| end));
        self.all_end = self.all_end.max(infinite(ends.all));
    }

    /// Looks for a schedule close to the bound, with the prices of `search` and `others`.
    fn make_schedules(
        &mut self,
        scene: &Scene,
        objective: BoundObjective,
        search: &SlotSearch,
        others: &[Vec<i64>],
    ) -> Result<()> {
        let earns = |outcome: &Outcome| {
            let figures = &outcome.figures;
            (earned(objective, figures), figures.picking_rate())
        };
        let best = SHARES.map(|share| (&search.ascent.best_prices, share));
        let others = others.iter().map(|prices| (prices, SHARES[0]));
        for (prices, share) in best.into_iter().chain(others) {
            let outcome = schedule(scene, &search.dual, prices, share)?;
            let best = self.schedule.as_ref();
            if best.is_none_or(|best| earns(best) < earns(&outcome)) {
                self.earned = self.earned.max(earns(&outcome).0);
                self.schedule = Some(outcome);
            }
        }
        Ok(())
    }

    fn finish(
        self,
        options: &BoundOptions,
        coarse: bool,
        search: &SlotSearch,
        effort: &Effort,
    ) -> Bound {
        let dual = &search.dual;
        let price = |&price: &i64| price as f64 / dual.units;
        Bound {
            objective: options.objective,
            value: self.value,
            relaxed: self.relaxed,
            // Rounded up by more than the division's rounding error.
            rate: Some(self.rate * (1.0 + 1e-12)).filter(|rate| rate.is_finite()),
            end: self.end,
            all_end: Some(self.all_end).filter(|end| end.is_finite()),
            reachable: dual.earliest.iter().flatten().count(),
            prices: search.ascent.best_prices.iter().map(price).collect(),
            slot_s: dual.slots.length,
            coarse,
            arcs: dual.networks.iter().map(|network| network.arcs()).sum(),
            iterations: effort.steps,
            stop: if self.reached_by(options.known.max(self.earned)) {
                BoundStop::Optimal
            } else if effort.stopped {
                BoundStop::Interrupted
            } else {
                BoundStop::Done
            },
            schedule: self.schedule,
        }
    }
}
