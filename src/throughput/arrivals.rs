//! How items arrive at the start of the belt: their flow, and how it changes over a pattern.

use crate::sim::Scene;
use crate::stats;
use std::ops::Range;

/// Maximum number of batches for the interval. More batches would be shorter and therefore
/// correlated, and would hardly narrow the interval (Schmeiser 1982, DOI 10.1287/opre.30.3.556).
const MOST_BATCHES: usize = 20;
/// Number of stretches of equal duration over which the flow is judged: as many as have on average
/// at least [`STRETCH`] arrivals each. With fewer than 8, the flow is not judged.
const STRETCHES: std::ops::RangeInclusive<usize> = 8..=20;
/// Minimum mean number of arrivals per stretch, so that the columns of a grid spread evenly.
const STRETCH: usize = 10;
/// The flow counts as constant if it varies by less than this share over the stretches.
const EVEN: f64 = 0.1;
/// The flow counts as uneven if it varies by more than this share without a recognisable order.
const UNEVEN: f64 = 0.25;
/// If the flow of the items that the truncation rule keeps differs from that of the pattern by more
/// than this share, the rule has found a change of the flow.
const ELSEWHERE: f64 = 0.2;
/// One-sided 0.5 % critical value of the standard normal distribution.
const SIGNIFICANT: f64 = 2.576;

/// How the flow changes over a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Changes {
    /// Constant, or nearly so.
    None,
    /// Changes no larger than chance produces, as with clusters and gaps.
    Little,
    /// Large changes without a recognisable order.
    Uneven,
    /// Neighbouring stretches have similar flows, as in a shift profile or a ramp.
    InOrder,
}

/// The items grouped by arrival time at the start of the belt; those of one grid column arrive
/// together.
pub(super) struct Arrivals {
    /// Positions of the items that are to be picked, at time 0 [m].
    places: Vec<f64>,
    /// For each item of the pattern, its number among them; that of the next one for an item that is
    /// left on purpose.
    pub ranks: Vec<usize>,
    /// Speed of the belt [m/s].
    speed: f64,
    /// Index of the first item of each arrival time.
    pub starts: Vec<usize>,
}

impl Arrivals {
    /// The arrivals of the items of the pattern on `scene` that are to be picked.
    pub(super) fn of(scene: &Scene) -> Self {
        let items = scene.pattern().items();
        let mut left = scene.left().iter().peekable();
        let mut places = Vec::with_capacity(scene.offered());
        let mut ranks = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            ranks.push(places.len());
            if left.next_if(|left| left.item as usize == index).is_none() {
                places.push(item.x0);
            }
        }
        let later = |&i: &usize| i == 0 || places[i] < places[i - 1];
        Self {
            starts: (0..places.len()).filter(later).collect(),
            speed: scene.station().belt().speed,
            places,
            ranks,
        }
    }

    /// Number of items that are to be picked.
    pub(super) fn items(&self) -> usize {
        self.places.len()
    }

    /// The flow of the whole pattern, from its first to its last time of arrival [1/min].
    pub(super) fn whole_flow(&self) -> Option<f64> {
        let last = self.starts.len().checked_sub(1)?;
        self.flow(0..last)
    }

    /// Arrival time of `group` [s].
    pub(super) fn time(&self, group: usize) -> f64 {
        -self.places[self.starts[group]] / self.speed
    }

    /// Time from the arrival of the first of these groups to that of the group after them [s].
    fn lasts(&self, groups: &Range<usize>) -> f64 {
        self.time(groups.end) - self.time(groups.start)
    }

    /// The flow of these groups [1/min]; there must be a group after them.
    pub(super) fn flow(&self, groups: Range<usize>) -> Option<f64> {
        let items = self.starts[groups.end] - self.starts[groups.start];
        (items > 0).then(|| 60.0 * items as f64 / self.lasts(&groups))
    }

    /// How the flow changes, which depends only on the pattern. Order is judged by the serial
    /// correlation of the stretches (von Neumann 1941, DOI 10.1214/aoms/1177731677).
    pub(super) fn changes(&self) -> Changes {
        let last = self.starts.len() - 1;
        let count = (last / STRETCH).min(*STRETCHES.end());
        if count < *STRETCHES.start() {
            return Changes::None;
        }
        let (start, lasts) = (self.time(0), self.lasts(&(0..last)));
        let mut items = vec![0.0; count];
        for group in 0..last {
            let share = (self.time(group) - start) / lasts;
            let stretch = ((share * count as f64) as usize).min(count - 1);
            items[stretch] += (self.starts[group + 1] - self.starts[group]) as f64;
        }
        let n = count as f64;
        let mean = stats::mean(&items);
        let off: Vec<f64> = items.iter().map(|items| items / mean - 1.0).collect();
        let squares: f64 = off.iter().map(|off| off * off).sum();
        let scatter = (squares / (n - 1.0)).sqrt();
        if scatter < EVEN {
            return Changes::None;
        }
        let products: f64 = off.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let serial = products / squares;
        let deviation = ((n - 2.0) / (n * n - 1.0)).sqrt();
        match serial + 1.0 / n > SIGNIFICANT * deviation {
            true => Changes::InOrder,
            false if scatter > UNEVEN => Changes::Uneven,
            false => Changes::Little,
        }
    }

    /// Whether the flow of these groups differs much from that of the pattern.
    pub(super) fn elsewhere(&self, groups: &Range<usize>) -> bool {
        let whole = self.flow(0..self.starts.len() - 1);
        let here = self.flow(groups.clone());
        let ratio = here.zip(whole).map(|(here, whole)| here / whole);
        ratio.is_some_and(|ratio| (ratio - 1.0).abs() > ELSEWHERE)
    }

    /// Splits the groups into batches of about equal duration, each at least `window` [s] if there
    /// is time for two.
    pub(super) fn batches(&self, groups: &Range<usize>, window: f64) -> Vec<Range<usize>> {
        let lasts = self.lasts(groups);
        let count = ((lasts / window) as usize)
            .clamp(2, MOST_BATCHES)
            .min(groups.len());
        let start = self.time(groups.start);
        let mut cuts: Vec<usize> = (0..count)
            .map(|k| {
                let time = start + lasts * k as f64 / count as f64;
                groups.start + groups.clone().take_while(|&g| self.time(g) < time).count()
            })
            .collect();
        cuts.push(groups.end);
        // Gaps in the pattern can put two cuts at the same group.
        cuts.dedup();
        cuts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }
}
