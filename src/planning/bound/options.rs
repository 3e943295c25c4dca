//! What is bounded, and how hard the search tries.

use super::network::{Network, Slots, latest_release};
use crate::decision::Moment;
use crate::error::{Error, Result, shown_number};
use crate::sim::Scene;

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Items picked.
    Picks,
    /// The sum of their weights.
    Weight,
}

/// How hard to try. The same options give the same bound on any machine.
#[derive(Debug, Clone)]
pub struct Options {
    /// What is counted.
    pub objective: Objective,
    /// Length of the slots [s]; chosen from the processing times when not given.
    pub slot_s: Option<f64>,
    /// Most steps of the prices; the bounds of end and rate may take as many again.
    pub iterations: usize,
    /// Whether end and rate are bounded too; they are trivial otherwise.
    pub ends: bool,
    /// Whether to look for a schedule to hold against the bound.
    pub schedule: bool,
    /// What a schedule is known to earn: a bound that is no higher ends the search.
    pub known: f64,
    /// Slots are chosen long enough for no more picks in slots than this.
    pub arcs: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            objective: Objective::Picks,
            slot_s: None,
            iterations: 200,
            ends: true,
            schedule: true,
            known: 0.0,
            arcs: 2_000_000,
        }
    }
}

impl Options {
    /// For a pattern of `items` items whose bound is all that is asked for: time and memory in
    /// proportion, so that the slots of long patterns are no longer than those of short ones.
    pub fn in_full(objective: Objective, items: usize) -> Self {
        let usual = Self::default();
        Self {
            objective,
            arcs: items
                .saturating_mul(ARCS_PER_ITEM)
                .clamp(usual.arcs, MOST_IN_FULL),
            ..usual
        }
    }

    /// What reports afford by the way: less than a tenth of a second on a usual pattern.
    pub fn quick(objective: Objective) -> Self {
        Self {
            objective,
            schedule: false,
            arcs: QUICK_ARCS,
            ..Self::default()
        }
    }

    /// The same for holding runs on a pattern of `items` items against, the best of which
    /// picks `picked`: a bound that a run reaches cannot be bettered. A longer pattern is
    /// worth time in proportion, or its slots would be too long to prove anything.
    pub fn beside(picked: usize, items: usize) -> Self {
        let share = (items as f64 / USUAL_ITEMS as f64).max(1.0);
        Self {
            known: picked as f64,
            arcs: (QUICK_ARCS as f64 * share).min(MOST_BESIDE) as usize,
            ..Self::quick(Objective::Picks)
        }
    }
}

/// Picks in slots that reports afford by the way, on a pattern of so many items.
const QUICK_ARCS: usize = 100_000;
const USUAL_ITEMS: usize = 150;
/// However long a pattern is, no more: several patterns are bounded at once, and this many
/// take about 100 MB.
const MOST_BESIDE: f64 = 4e6;
/// Picks in slots for each item where the bound is all that is asked for, and in all; these
/// take about 500 MB.
const ARCS_PER_ITEM: usize = 2000;
const MOST_IN_FULL: usize = 20_000_000;
/// Slots more than this many times as long as would be chosen for the picks alone are coarse.
const COARSE: f64 = 2.5;

/// Shortest and longest slot [s] that may be asked for.
const SLOT_RANGE: (f64, f64) = (1e-6, 1e6);
/// More picks in slots than this do not fit into memory with comfort.
const MOST_ARCS: f64 = 5e7;
/// More slots in a day than this can no longer be told apart by their times.
const MOST_SLOTS: f64 = 1e14;
/// Slots in a mean processing time, unless that is too many for the whole.
const SLOTS_PER_PICK: f64 = 50.0;

/// Slots, and whether they are so long for want of memory or time that the bound is weak.
pub(super) struct Chosen {
    pub slots: Slots,
    pub coarse: bool,
}

/// The slots for `scene`; none when there are too many items for any that are worth it.
///
/// # Errors
/// A length that is none, or so short that the picks do not fit into memory.
pub(super) fn choose_slots(scene: &Scene, options: &Options) -> Result<Option<Chosen>> {
    let robots = 0..scene.station().robots().len();
    let size = |slots: Slots| -> f64 {
        let sizes = robots.clone().map(|r| Network::size(scene.queue(r), slots));
        sizes.sum()
    };
    let windows: usize = robots.clone().map(|robot| scene.queue(robot).len()).sum();
    if options.slot_s.is_none() && windows > options.arcs {
        return Ok(None);
    }
    let last = robots.clone().flat_map(|robot| {
        let queue = scene.queue(robot).iter();
        queue.map(move |candidate| latest_release(scene.station(), robot, candidate))
    });
    let last = last.fold(0.0, f64::max);
    if let Some(length) = options.slot_s {
        let slots = Slots { length };
        if !(SLOT_RANGE.0..=SLOT_RANGE.1).contains(&length) {
            let (low, high) = SLOT_RANGE;
            return Err(Error::input(
                "--slot",
                format!("{} is not a length of a slot", shown_number(length)),
                format!("give seconds, from {low:e} to {high:e}, such as 0.05"),
            ));
        }
        let arcs = size(slots);
        if arcs > MOST_ARCS || last / length > MOST_SLOTS {
            return Err(Error::input(
                "--slot",
                format!(
                    "{} s is too short for this pattern: {arcs:.1e} picks in slots, at most \
                     {MOST_ARCS:.0e} fit",
                    shown_number(length)
                ),
                "give a longer slot, or leave it out to have one chosen",
            ));
        }
        let coarse = false;
        return Ok(Some(Chosen { slots, coarse }));
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for robot in robots.clone() {
        for candidate in scene.queue(robot) {
            let middle = 0.5 * (candidate.open + candidate.close);
            sum += Moment::new(scene.station(), robot, middle).processing_time(candidate);
            count += 1.0;
        }
    }
    let mean = if count > 0.0 { sum / count } else { 0.0 };
    // A mean of 0 is a line whose picks take no time; any slot will do.
    let wanted = (mean / SLOTS_PER_PICK).clamp(SLOT_RANGE.0, SLOT_RANGE.1);
    let fits =
        |length: f64| size(Slots { length }) <= options.arcs as f64 && last / length <= MOST_SLOTS;
    // Lengths that one would write: 1, 2, 5, 10, ... times a power of ten.
    let exponent = wanted.log10().floor() as i32;
    let lengths = (exponent..exponent + 14).flat_map(|exponent| {
        let power = 10f64.powi(exponent.abs());
        [1.0, 2.0, 5.0].map(|digit| {
            if exponent < 0 {
                digit / power
            } else {
                digit * power
            }
        })
    });
    let mut lengths = lengths.skip_while(|length| *length * 1.999 < wanted);
    let length = lengths.find(|&length| fits(length));
    // In slots longer than a pick there is next to nothing left to bound.
    Ok(length
        .filter(|&length| count == 0.0 || length <= mean.max(wanted))
        .map(|length| Chosen {
            slots: Slots { length },
            coarse: length > COARSE * wanted,
        }))
}
