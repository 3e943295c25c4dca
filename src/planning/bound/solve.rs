//! From a scene to its bound.

use super::ascent::{Ascent, Steps};
use super::dual::{Dual, Schedules};
use super::options::{BoundObjective, BoundOptions, Chosen, choose_slots};
use super::profile::{BoundProfile, Ends, Leaving};
use super::schedule::schedule;
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

/// Shares of the prices at which schedules are made: at the full prices nothing is worth more
/// than anything else.
const SHARES: [f64; 2] = [0.9, 0.95];
/// Length of the first steps, found by experiment (`docs/bound.md`).
const FIRST_STEP: f64 = 2.0;
/// Length of the first steps from good prices, to improve a bound of end or rate.
const LATER_STEP: f64 = 0.5;
/// Number of steps after which the worst places for end and rate are determined again.
const ROUND: usize = 3;
/// Number of rounds without a better bound before the search gives up.
const PATIENCE: usize = 12;

/// One of the bounds of a profile.
type NextTarget = fn(&Ends) -> Option<(f64, usize)>;

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
    let undisturbed;
    let scene = if scene.conditions().can_go_wrong() {
        undisturbed = without_disturbances(scene)?;
        &undisturbed
    } else {
        scene
    };
    let Some(Chosen { slots, coarse }) = choose_slots(scene, options)? else {
        return Ok(trivial(scene, options));
    };
    let mut dual = Dual::new(scene, options.objective, slots);
    if let Some(counted) = &options.counted {
        dual = dual.counting(counted);
    }
    let belt = Leaving::new(scene, &dual);
    let mut search = IntervalSearch {
        profile: BoundProfile::new(&dual),
        ascent: Ascent::new(
            dual.weights.iter().map(|weight| weight / 2).collect(),
            dual.weights.iter().sum(),
        ),
        dual,
        belt,
        steps: 0,
        expected: options.iterations * if options.ends { 2 } else { 1 },
        stopped: false,
        known: options.known,
        other_prices: Vec::new(),
        found: None,
    };
    let trivial_ends = search.profile.ends(&search.dual, &search.belt);
    if !search.optimal() {
        search.earn(options.iterations, go_on);
    }
    let mut ends = trivial_ends;
    if options.ends {
        ends = search.ends(options.iterations, go_on);
    }
    // The figures of a schedule count all of its picks.
    if options.schedule && options.counted.is_none() && !search.stopped {
        search.make_schedules(scene, options.objective)?;
    }
    Ok(Bound {
        coarse,
        ..search.finish(options.objective, ends)
    })
}

/// The scene without failures and outages, in which every pick that succeeds on `scene` is a pick:
/// failures and outages only cost time. With noisy positions, a pick succeeds within the window of the true
/// position, whatever the camera reported when.
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

struct IntervalSearch {
    dual: Dual,
    belt: Leaving,
    profile: BoundProfile,
    ascent: Ascent,
    steps: usize,
    expected: usize,
    stopped: bool,
    known: f64,
    /// The latest prices for each bound of end and rate.
    other_prices: Vec<Vec<i64>>,
    found: Option<Outcome>,
}

impl IntervalSearch {
    /// Whether a known schedule earns as much as the bound allows.
    fn optimal(&self) -> bool {
        self.known >= self.dual.weight(self.dual.whole(self.ascent.best))
    }

    /// Lowers the bound on what can be earned.
    fn earn(&mut self, iterations: usize, go_on: &mut dyn FnMut(usize, usize) -> bool) {
        let dual = &self.dual;
        let known = self.known;
        let (made, expected, stopped) = (&mut self.steps, self.expected, &mut self.stopped);
        let step = |best: i64| {
            *made += 1;
            *stopped = !go_on(*made, expected);
            *stopped || known >= dual.weight(dual.whole(best))
        };
        let steps = Steps {
            most: iterations,
            length: FIRST_STEP,
        };
        let (profile, belt) = (&mut self.profile, &self.belt);
        self.ascent
            .run(dual, Schedules::ANY, steps, profile, belt, step);
    }

    /// Looks for a schedule close to the bound, using all prices that improved some bound.
    fn make_schedules(&mut self, scene: &Scene, objective: BoundObjective) -> Result<()> {
        let earns = |outcome: &Outcome| {
            let figures = &outcome.figures;
            (earned(objective, figures), figures.picking_rate())
        };
        let best = SHARES.map(|share| (&self.ascent.best_prices, share));
        let others = self.other_prices.iter().map(|prices| (prices, SHARES[0]));
        for (prices, share) in best.into_iter().chain(others) {
            let outcome = schedule(scene, &self.dual, prices, share)?;
            let best = self.found.as_ref();
            if best.is_none_or(|best| earns(best) < earns(&outcome)) {
                self.known = self.known.max(earns(&outcome).0);
                self.found = Some(outcome);
            }
        }
        Ok(())
    }

    /// Tightens the bounds of rate and end where they are worst, in at most `steps` steps.
    fn ends(&mut self, steps: usize, go_on: &mut dyn FnMut(usize, usize) -> bool) -> Ends {
        let targets: [(NextTarget, usize); 3] = [
            (|ends| ends.rate, steps / 2),
            (|ends| ends.all, steps / 4),
            (|ends| ends.end, steps / 4),
        ];
        let mut ends = self.profile.ends(&self.dual, &self.belt);
        for (number, (target, steps)) in targets.into_iter().enumerate() {
            let mut prices = self.ascent.best_prices.clone();
            let mut without = 0;
            for _ in 0..steps / ROUND {
                let Some((before, at)) = target(&ends).filter(|_| without < PATIENCE) else {
                    break;
                };
                if self.stopped || self.profile.is_empty() {
                    return ends;
                }
                let schedules = if number == 1 {
                    self.profile.complete_schedules(at)
                } else {
                    self.profile.schedules(at, &self.belt)
                };
                for price in &mut prices[..schedules.must_from.min(self.dual.weights.len())] {
                    *price = (*price).max(0);
                }
                let mut ascent = Ascent::new(prices, self.profile.value(at));
                let (made, expected, stopped) = (&mut self.steps, self.expected, &mut self.stopped);
                let steps = Steps {
                    most: ROUND,
                    length: LATER_STEP,
                };
                let (profile, belt) = (&mut self.profile, &self.belt);
                ascent.run(&self.dual, schedules, steps, profile, belt, |_| {
                    *made += 1;
                    *stopped = !go_on(*made, expected);
                    *stopped
                });
                prices = ascent.last_prices();
                ends = self.profile.ends(&self.dual, &self.belt);
                let same = target(&ends).is_some_and(|(after, _)| after == before);
                without = if same { without + 1 } else { 0 };
            }
            self.other_prices.push(prices);
        }
        ends
    }

    fn finish(self, objective: BoundObjective, ends: Ends) -> Bound {
        let dual = &self.dual;
        let units = self.ascent.best;
        let price = |&price: &i64| price as f64 / dual.units;
        Bound {
            objective,
            value: dual.weight(dual.whole(units)),
            relaxed: dual.weight(units),
            // Rounded up by more than the division's rounding error.
            rate: ends
                .rate
                .map(|(rate, _)| rate * (1.0 + 1e-12))
                .filter(|rate| rate.is_finite()),
            end: ends.end.map_or(0.0, |(end, _)| end),
            all_end: ends.all.map(|(end, _)| end),
            reachable: dual.earliest.iter().flatten().count(),
            prices: self.ascent.best_prices.iter().map(price).collect(),
            slot_s: dual.slots.length,
            coarse: false,
            arcs: dual.networks.iter().map(|network| network.arcs()).sum(),
            iterations: self.steps,
            stop: if self.optimal() {
                BoundStop::Optimal
            } else if self.stopped {
                BoundStop::Interrupted
            } else {
                BoundStop::Done
            },
            schedule: self.found,
        }
    }
}
