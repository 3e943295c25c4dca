//! The search for prices with slots of one length.

use super::ascent::{Ascent, Steps};
use super::dual::{Dual, Schedules};
use super::network::Slots;
use super::options::BoundOptions;
use super::profile::{BoundProfile, Ends, Leaving};
use crate::sim::Scene;
use std::collections::BTreeMap;

/// Length of the first steps of all.
const FIRST_STEP: f64 = 2.0;
/// Length of the first steps from the prices of longer slots.
const NEXT_STEP: f64 = 0.2;
/// Length of the first steps towards a bound of end or rate, and from the prices of longer slots.
const END_STEP: f64 = 1.0;
const NEXT_END_STEP: f64 = 0.4;
/// Number of steps after which the worst place for end or rate is determined again.
const ROUND: usize = 3;
/// Number of rounds without a better bound before the search gives up.
const PATIENCE: usize = 24;
/// Relative improvement of B(T) below which a round was in vain.
const IN_VAIN: f64 = 1e-4;
/// Factor by which steps become shorter after a round in vain, and the shortest.
const SHORTER: f64 = 0.9;
const SHORTEST: f64 = 0.01;

/// What was done so far, and what is left to do.
pub(super) struct Effort<'a> {
    /// Number of steps made.
    pub steps: usize,
    /// Approximate number of all steps.
    pub expected: usize,
    /// Whether the search was asked to stop.
    pub stopped: bool,
    /// Asked after every step, with the number of steps made and expected.
    pub go_on: &'a mut dyn FnMut(usize, usize) -> bool,
}

impl Effort<'_> {
    /// Counts a step; whether the search was asked to stop.
    fn step(&mut self) -> bool {
        self.steps += 1;
        self.stopped = !(self.go_on)(self.steps, self.expected);
        self.stopped
    }
}

/// One of the bounds of a profile that depend on the end of a run.
#[derive(Debug, Clone, Copy)]
pub(super) enum EndTarget {
    Rate,
    All,
    End,
}

impl EndTarget {
    /// In the order in which they are searched.
    pub(super) const ORDER: [Self; 3] = [Self::Rate, Self::All, Self::End];

    /// The bound, and the step of the profile that determines it.
    fn of(self, ends: &Ends) -> Option<(f64, usize)> {
        match self {
            Self::Rate => ends.rate,
            Self::All => ends.all,
            Self::End => ends.end,
        }
    }

    /// The share of the steps that it gets.
    fn share(self, steps: usize) -> usize {
        match self {
            Self::Rate => steps * 3 / 4,
            Self::All | Self::End => steps / 8,
        }
    }
}

/// Prices for the runs whose ends have the same items behind them.
#[derive(Debug, Clone)]
struct Guide {
    prices: Vec<i64>,
    /// Length of the next steps from them.
    length: f64,
    /// Whether they come from other slots and were not tried with these.
    untried: bool,
}

/// The guides of one target, by the first item that must be picked.
type Guides = BTreeMap<usize, Guide>;

/// Prices for other slots of the same scene.
#[derive(Debug, Clone, Default)]
pub(super) struct Prices {
    /// For the bound on what can be earned.
    best: Vec<i64>,
    /// Length of the first steps from them.
    length: f64,
    /// For each target, those for runs with certain ends.
    guides: [Guides; 3],
    /// For each target, whether steps towards it were all in vain.
    in_vain: [bool; 3],
}

/// The search with slots of one length.
pub(super) struct SlotSearch {
    pub dual: Dual,
    pub belt: Leaving,
    pub profile: BoundProfile,
    pub ascent: Ascent,
    /// Length of the first steps.
    length: f64,
    /// For each target, the prices for runs with certain ends.
    guides: [Guides; 3],
    /// For each target, whether steps towards it were all in vain, with longer slots or these.
    in_vain: [bool; 3],
}

impl SlotSearch {
    /// Begins with the prices that other slots gave, if any; `may_fail` says whether picks may fail.
    pub(super) fn new(
        scene: &Scene,
        may_fail: bool,
        options: &BoundOptions,
        slots: Slots,
        before: Option<Prices>,
    ) -> Self {
        let mut dual = Dual::new(scene, options.objective, slots);
        if may_fail {
            dual = dual.with_failures();
        }
        if let Some(counted) = &options.counted {
            dual = dual.counting(counted);
        }
        let belt = Leaving::new(scene, &dual);
        let profile = BoundProfile::new(&dual);
        let before = before.unwrap_or_else(|| Prices {
            best: dual.weights.iter().map(|weight| weight / 2).collect(),
            length: FIRST_STEP,
            ..Prices::default()
        });
        Self {
            ascent: Ascent::new(before.best, dual.weights.iter().sum()),
            dual,
            belt,
            profile,
            length: before.length,
            guides: before.guides,
            in_vain: before.in_vain,
        }
    }

    /// The prices found, for other slots.
    pub(super) fn prices(&self) -> Prices {
        let mut guides = self.guides.clone();
        for guide in guides.iter_mut().flat_map(|guides| guides.values_mut()) {
            guide.length = guide.length.min(NEXT_END_STEP);
            guide.untried = true;
        }
        // Slots may be too long for any price to prove anything.
        let better = self.ascent.best < self.dual.weights.iter().sum();
        Prices {
            best: self.ascent.best_prices.clone(),
            length: if better { NEXT_STEP } else { self.length },
            guides,
            in_vain: self.in_vain,
        }
    }

    /// The bounds of end and rate.
    pub(super) fn ends(&self) -> Ends {
        self.profile.ends(&self.dual, &self.belt)
    }

    /// Lowers the bound on what can be earned in at most `most` steps, until `known` reaches it.
    pub(super) fn earn(&mut self, most: usize, known: f64, effort: &mut Effort) {
        let steps = Steps {
            most,
            length: self.length,
        };
        let (dual, profile, belt) = (&self.dual, &mut self.profile, &self.belt);
        self.ascent
            .run(dual, Schedules::ANY, steps, profile, belt, |best| {
                effort.step() || known >= dual.weight(dual.whole(best))
            });
    }

    /// Tightens the bounds of rate and ends where they are worst, in at most `steps` steps, and
    /// returns the last prices for each.
    pub(super) fn tighten(&mut self, steps: usize, effort: &mut Effort) -> Vec<Vec<i64>> {
        let mut last = Vec::new();
        for target in EndTarget::ORDER {
            if effort.stopped || self.profile.is_empty() {
                break;
            }
            // What longer slots could not tighten is determined by something else.
            let steps = if self.in_vain[target as usize] {
                target.share(steps).min(ROUND)
            } else {
                target.share(steps)
            };
            let before = target.of(&self.ends()).map(|(bound, _)| bound);
            last.extend(self.tighten_one(target, steps, effort));
            let after = target.of(&self.ends()).map(|(bound, _)| bound);
            self.in_vain[target as usize] = before == after;
        }
        last
    }

    fn tighten_one(
        &mut self,
        target: EndTarget,
        steps: usize,
        effort: &mut Effort,
    ) -> Option<Vec<i64>> {
        let mut ends = self.ends();
        let (mut without, mut last) = (0, None);
        let mut made = 0;
        while made + ROUND <= steps {
            let Some((before, at)) = target.of(&ends).filter(|_| without < PATIENCE) else {
                break;
            };
            let schedules = match target {
                EndTarget::All => self.profile.complete_schedules(at),
                _ => self.profile.schedules(at, &self.belt),
            };
            let (ends_like, guide) = self.guide(target, schedules.must_from);
            let Guide {
                mut prices,
                length,
                untried,
            } = guide;
            let first = schedules.must_from.min(prices.len());
            for price in &mut prices[..first] {
                *price = (*price).max(0);
            }
            let value = self.profile.value(at);
            let mut ascent = Ascent::new(prices.clone(), value);
            let steps = Steps {
                most: if untried { 1 } else { ROUND },
                length,
            };
            let (profile, belt) = (&mut self.profile, &self.belt);
            ascent.run(&self.dual, schedules, steps, profile, belt, |_| {
                effort.step()
            });
            made += steps.most;
            let guides = &mut self.guides[target as usize];
            if untried {
                guides
                    .entry(ends_like)
                    .and_modify(|guide| guide.untried = false);
            } else {
                let gained = (value - self.profile.value(at)) as f64;
                let length = if gained > IN_VAIN * value as f64 {
                    length
                } else {
                    (length * SHORTER).max(SHORTEST)
                };
                prices = ascent.last_prices();
                let guide = Guide {
                    prices: prices.clone(),
                    length,
                    untried,
                };
                guides.insert(schedules.must_from, guide);
            }
            last = Some(prices);
            if effort.stopped {
                break;
            }
            ends = self.ends();
            let same = target.of(&ends).is_some_and(|(after, _)| after == before);
            without = if same { without + 1 } else { 0 };
        }
        last
    }

    /// The prices to begin with for runs that must pick the items from `must_from` on: those of the
    /// nearest ends, and which these are.
    fn guide(&self, target: EndTarget, must_from: usize) -> (usize, Guide) {
        let guides = &self.guides[target as usize];
        let before = guides.range(..=must_from).next_back();
        let after = guides.range(must_from..).next();
        let nearest = before.into_iter().chain(after);
        match nearest.min_by_key(|(like, _)| like.abs_diff(must_from)) {
            Some((like, guide)) => (*like, guide.clone()),
            None => {
                let guide = Guide {
                    prices: self.ascent.best_prices.clone(),
                    length: END_STEP,
                    untried: false,
                };
                (must_from, guide)
            }
        }
    }
}
