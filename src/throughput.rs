//! Throughput: the picks per minute of a line in its steady state, without run-in, run-out and idle
//! belt. `docs/model.md` defines the rule implemented here.

use crate::decision::{Outcome, Pick};
use crate::pattern::Item;
use crate::sim::Scene;
use crate::station::Station;
use crate::stats::{self, Interval};
use std::fmt;
use std::ops::Range;

/// The steady state of one run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SteadyState {
    /// Its items, as indices into the pattern.
    pub items: Range<usize>,
    /// When the first of these items passes the start of the belt [s].
    pub start: f64,
    /// When the first item after them does [s].
    pub end: f64,
    /// How many of these items are picked.
    pub picked: usize,
    /// Picks per minute: the picked share of these items times the flow [1/min].
    pub throughput: f64,
    /// Its 95 % interval by batch means [1/min]; `None` if there is only one batch.
    pub interval: Option<Interval>,
    /// Items that arrive per minute over the whole pattern [1/min], picked or not.
    pub flow: f64,
    /// Whether the flow changes over the pattern. There is then no true steady state, and `items`
    /// is the whole pattern except its ends.
    pub flow_changes: bool,
    /// For each robot, upstream first, the share of the time that it is busy while these items pass
    /// its base.
    pub utilisation: Vec<f64>,
}

/// A run without a steady state.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Unsteady {
    /// Items that arrive per minute over the whole pattern [1/min]; `None` if all arrive at once.
    pub flow: Option<f64>,
    /// Why there is no steady state.
    pub reason: UnsteadyReason,
}

/// Why a run has no steady state. Displays as a sentence with the cure.
#[derive(Debug, Clone, PartialEq)]
pub enum UnsteadyReason {
    /// The whole pattern belongs to run-in and run-out: its items arrive within `lasts` [s], too
    /// short compared with the longest departure window of `window` [s].
    Short {
        /// Time from the first arrival to the last [s].
        lasts: f64,
        /// The longest departure window [s].
        window: f64,
        /// Number of items of this density that is enough; `None` if there is no density.
        items: Option<usize>,
    },
    /// Run-in or run-out takes half or more of the remaining pattern.
    Drifting {
        /// Number of items that may be enough.
        items: usize,
    },
}

/// The pattern must last this many times the longest departure window: one window is cut off at
/// each end, and batches need at least two.
const WINDOWS: f64 = 4.0;
/// Recommended duration of a pattern, as a multiple of the longest departure window.
const ENOUGH_WINDOWS: f64 = 12.0;
/// Maximum number of batches for the interval. More batches would be shorter and therefore
/// correlated, and would hardly narrow the interval (Schmeiser 1982, DOI 10.1287/opre.30.3.556).
const MOST_BATCHES: usize = 20;
/// Items in a batch of the truncation rule (the 5 in MSER-5).
const MSER_BATCH: usize = 5;
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

impl fmt::Display for UnsteadyReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short {
                lasts,
                window,
                items,
            } => {
                write!(
                    f,
                    "the pattern is too short for a steady state: its items arrive within {lasts:.1} s, \
                     and it takes {:.1} s, {WINDOWS} times the longest departure window; ",
                    WINDOWS * window
                )?;
                match items {
                    Some(items) => write!(f, "give {items} items or more of this density"),
                    None => write!(f, "give a longer one"),
                }
            }
            Self::Drifting { items } => write!(
                f,
                "run-in and run-out take half of the pattern or more; give {items} items or more"
            ),
        }
    }
}

/// The steady state of the run `outcome` on `scene`.
///
/// First, the items that arrive within one longest departure window of the first or the last item
/// are left out: when the line meets them, some robot's window is not yet full or no longer full.
/// Then MSER-5 truncates the rest at both ends (White 1997, DOI 10.1177/003754979706900601). If the
/// flow changes over the pattern, nothing more is truncated: there is no steady state to find, only
/// a mean.
///
/// # Errors
/// If the run is too short or has not settled.
pub fn steady_state(scene: &Scene, outcome: &Outcome) -> Result<SteadyState, Unsteady> {
    let arrivals = Arrivals::of(scene);
    let unsteady = |reason| {
        Err(Unsteady {
            flow: arrivals.flow(0..arrivals.starts.len() - 1),
            reason,
        })
    };
    let window = longest_window(scene);
    let groups = arrivals.starts.len();
    let (first, last) = (arrivals.time(0), arrivals.time(groups - 1));
    let lasts = last - first;
    if groups < 2 || lasts < WINDOWS * window {
        return unsteady(UnsteadyReason::Short {
            lasts,
            window,
            items: enough_items(scene).filter(|&items| items > scene.pattern().len()),
        });
    }
    let begin = (0..groups).find(|&g| arrivals.time(g) >= first + window);
    let end = (0..groups).rfind(|&g| arrivals.time(g) <= last - window);
    let (begin, end) = (begin.unwrap_or(0), end.unwrap_or(groups - 1));
    let whole = arrivals.starts[begin]..arrivals.starts[end];
    let drifting = UnsteadyReason::Drifting {
        items: 2 * scene.pattern().len(),
    };
    let summarise = |groups, flow_changes| {
        Ok(arrivals.summarise(groups, flow_changes, window, scene.station(), outcome))
    };
    let changes = arrivals.changes();
    if begin < end && changes == Changes::InOrder {
        return summarise(begin..end, true);
    }
    let left = truncate(whole, &pick_series(scene, outcome)).and_then(|left| {
        // Cuts fall between arrival times, so that items that arrive together stay together.
        let begin = arrivals.starts.partition_point(|&start| start < left.start);
        let end = arrivals.starts.partition_point(|&start| start <= left.end) - 1;
        (begin < end).then_some(begin..end)
    });
    match left {
        Some(left) if changes == Changes::None || !arrivals.elsewhere(&left) => {
            summarise(left, false)
        }
        None if begin >= end || changes != Changes::Uneven => unsteady(drifting),
        _ => summarise(begin..end, true),
    }
}

/// A number of items, at the density of the pattern on `scene`, that is enough for a steady state;
/// `None` if there is no density.
pub(crate) fn enough_items(scene: &Scene) -> Option<usize> {
    let arrivals = Arrivals::of(scene);
    let flow = arrivals.flow(0..arrivals.starts.len() - 1);
    flow.map(|flow| round_up(ENOUGH_WINDOWS * longest_window(scene) * flow / 60.0))
}

/// How the flow changes over a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Changes {
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
struct Arrivals<'s> {
    items: &'s [Item],
    speed: f64,
    /// Index of the first item of each arrival time.
    starts: Vec<usize>,
}

impl<'s> Arrivals<'s> {
    fn of(scene: &Scene<'s>) -> Self {
        let items = scene.pattern().items();
        let later = |&i: &usize| i == 0 || items[i].x0 < items[i - 1].x0;
        Self {
            items,
            speed: scene.station().belt().speed,
            starts: (0..items.len()).filter(later).collect(),
        }
    }

    /// Arrival time of `group` [s].
    fn time(&self, group: usize) -> f64 {
        -self.items[self.starts[group]].x0 / self.speed
    }

    /// Time from the arrival of the first of these groups to that of the group after them [s].
    fn lasts(&self, groups: &Range<usize>) -> f64 {
        self.time(groups.end) - self.time(groups.start)
    }

    /// The flow of these groups [1/min]; there must be a group after them.
    fn flow(&self, groups: Range<usize>) -> Option<f64> {
        let items = self.starts[groups.end] - self.starts[groups.start];
        (items > 0).then(|| 60.0 * items as f64 / self.lasts(&groups))
    }

    /// How the flow changes, which depends only on the pattern. Order is judged by the serial
    /// correlation of the stretches (von Neumann 1941, DOI 10.1214/aoms/1177731677).
    fn changes(&self) -> Changes {
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
    fn elsewhere(&self, groups: &Range<usize>) -> bool {
        let whole = self.flow(0..self.starts.len() - 1);
        let here = self.flow(groups.clone());
        let ratio = here.zip(whole).map(|(here, whole)| here / whole);
        ratio.is_some_and(|ratio| (ratio - 1.0).abs() > ELSEWHERE)
    }

    fn summarise(
        &self,
        groups: Range<usize>,
        flow_changes: bool,
        window: f64,
        station: &Station,
        outcome: &Outcome,
    ) -> SteadyState {
        let mut picked_before = vec![0; self.items.len() + 1];
        for pick in &outcome.picks {
            picked_before[pick.item as usize + 1] = 1;
        }
        for i in 0..self.items.len() {
            picked_before[i + 1] += picked_before[i];
        }
        let picked = |groups: &Range<usize>| -> usize {
            picked_before[self.starts[groups.end]] - picked_before[self.starts[groups.start]]
        };
        let count = |groups: &Range<usize>| self.starts[groups.end] - self.starts[groups.start];
        let flow = self.flow(0..self.starts.len() - 1).unwrap_or_default();
        let share = picked(&groups) as f64 / count(&groups) as f64;
        let batches = self.batches(&groups, window);
        // The share is a ratio of two sums. A batch's deviation is therefore its picks minus the
        // share of its items, divided by the mean number of items.
        let mean = count(&groups) as f64 / batches.len() as f64;
        let squares = batches.iter().map(|batch| {
            let distance = (picked(batch) as f64 - share * count(batch) as f64) / mean;
            distance * distance
        });
        let squares: Vec<f64> = squares.collect();
        let interval = stats::interval_of(squares.len(), share, squares.iter().sum());
        let (start, end) = (self.time(groups.start), self.time(groups.end));
        let busy = |robot: usize| {
            let passes = station.robots()[robot].base.x / self.speed;
            let failed = outcome.failures.iter().map(|failure| &failure.attempt);
            let attempts = outcome.picks.iter().chain(failed);
            let overlap = |pick: &Pick| {
                (pick.release.min(end + passes) - pick.decide.max(start + passes)).max(0.0)
            };
            attempts
                .filter(|pick| pick.robot == robot)
                .map(overlap)
                .sum::<f64>()
        };
        let robots = 0..station.robots().len();
        SteadyState {
            items: self.starts[groups.start]..self.starts[groups.end],
            start,
            end,
            picked: picked(&groups),
            throughput: share * flow,
            interval: interval.map(|share| share.within(0.0, 1.0).times(flow)),
            flow,
            flow_changes,
            utilisation: robots
                // An empty sum is -0.
                .map(|robot| (busy(robot) / (end - start)).min(1.0) + 0.0)
                .collect(),
        }
    }

    /// Splits the groups into batches of about equal duration, each at least `window` [s] if there
    /// is time for two.
    fn batches(&self, groups: &Range<usize>, window: f64) -> Vec<Range<usize>> {
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

/// The longest departure window over all robots and items [s].
fn longest_window(scene: &Scene) -> f64 {
    let robots = 0..scene.station().robots().len();
    let windows = robots.flat_map(|robot| scene.queue(robot));
    windows
        .map(|item| item.close - item.open)
        .fold(0.0, f64::max)
}

/// Series per item that show whether a run has settled: whether the item is picked [1], and where
/// it leaves the belt [m], at most the end of the last workspace. The second grows with a queue,
/// even on a line that still picks everything.
fn pick_series(scene: &Scene, outcome: &Outcome) -> [Vec<f64>; 2] {
    let items = scene.pattern().len();
    let station = scene.station();
    let ends = station.robots().iter().map(|r| r.base.x + r.reach);
    let end = ends.fold(0.0, f64::max).min(station.belt().length);
    let mut picked = vec![0.0; items];
    let mut left = vec![end; items];
    for pick in &outcome.picks {
        picked[pick.item as usize] = 1.0;
        left[pick.item as usize] = pick.meet.x.min(end);
    }
    [picked, left]
}

/// The items of `whole` that the truncation rule keeps. It first cuts the run-in, then the run-out
/// of the rest. `None` if less than half is left or the rule finds no cut.
fn truncate(whole: Range<usize>, series: &[Vec<f64>]) -> Option<Range<usize>> {
    // The longest cut of any series, in batches from the front or the back.
    let cut = |items: &Range<usize>, backwards: bool| -> Option<usize> {
        let cuts = series.iter().map(|values| {
            let values = &values[items.clone()];
            // A remainder does not form a batch.
            let batches: Vec<f64> = match backwards {
                false => values.chunks_exact(MSER_BATCH).map(stats::mean).collect(),
                true => values.rchunks_exact(MSER_BATCH).map(stats::mean).collect(),
            };
            stats::mser(&batches).map(|cut| MSER_BATCH * cut)
        });
        cuts.collect::<Option<Vec<_>>>()?.into_iter().max()
    };
    let mut left = whole.clone();
    left.start += cut(&left, false)?;
    left.end -= cut(&left, true)?;
    (2 * left.len() >= whole.len()).then_some(left)
}

/// Rounds up to two significant digits, as a user would write the count.
fn round_up(count: f64) -> usize {
    let unit = 10f64.powf((count.max(10.0).log10()).floor() - 1.0);
    ((count / unit).ceil() * unit) as usize
}

/// Throughput over several runs, one per pattern.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Throughput {
    /// Mean [1/min]; `None` if fewer than half of the runs have a steady state.
    pub mean: Option<f64>,
    /// Its 95 % interval: over the patterns, or by batch means where there is only one.
    pub interval: Option<Interval>,
    /// Mean number of arriving items per minute [1/min] over the same patterns, or over all
    /// patterns if there is no throughput.
    pub flow: Option<f64>,
    /// For each robot, the mean share of the time that it is busy while the items of the steady
    /// state pass it; empty if there is no steady state.
    pub utilisation: Vec<f64>,
    /// Number of runs that have a steady state and are counted.
    pub steady: usize,
    /// Number of counted runs whose flow changes over the pattern.
    pub changing: usize,
    /// Number of runs.
    pub runs: usize,
    /// Reason that the first run without a steady state has none.
    pub missing: Option<UnsteadyReason>,
}

/// The steady state of a run, or why there is none.
pub type Steadiness = Result<SteadyState, Unsteady>;

impl Throughput {
    /// The throughput over `runs`.
    pub fn of<'r>(runs: impl IntoIterator<Item = &'r Steadiness>) -> Self {
        let runs: Vec<_> = runs.into_iter().collect();
        Self::on(&runs, |_| true)
    }

    /// The throughput of several lines or methods on the same patterns; each entry of `runs` holds
    /// the runs of one of them, in the order of the patterns. They are compared on the patterns on
    /// which all have a steady state, provided that these are at least half. Those with fewer
    /// steady patterns are excluded.
    pub fn beside(runs: &[Vec<&Steadiness>]) -> Vec<Self> {
        let enough = |steady: usize, all: usize| steady > 0 && 2 * steady >= all;
        let takes_part = |runs: &&Vec<&Steadiness>| {
            enough(runs.iter().filter(|run| run.is_ok()).count(), runs.len())
        };
        let part: Vec<_> = runs.iter().filter(takes_part).collect();
        let patterns = runs.first().map_or(0, Vec::len);
        let common = (0..patterns).map(|p| part.iter().all(|runs| runs[p].is_ok()));
        let common: Vec<bool> = common.collect();
        let all = !enough(common.iter().filter(|common| **common).count(), patterns);
        runs.iter()
            .map(|own| Self::on(own, |p| all || common[p] || !takes_part(&own)))
            .collect()
    }

    /// The throughput over the runs on the patterns for which `counts` is true.
    fn on(runs: &[&Steadiness], counts: impl Fn(usize) -> bool) -> Self {
        let counted = runs.iter().enumerate().filter(|(p, _)| counts(*p));
        let steady = counted.filter_map(|(_, run)| run.as_ref().ok());
        let steady: Vec<&SteadyState> = steady.collect();
        let missing = runs.iter().find_map(|run| run.as_ref().err());
        let enough = !steady.is_empty() && 2 * steady.len() >= runs.len();
        let flows: Option<Vec<f64>> = match enough {
            true => Some(steady.iter().map(|run| run.flow).collect()),
            false => {
                let flow = |run: &&Steadiness| match run {
                    Ok(steady) => Some(steady.flow),
                    Err(unsteady) => unsteady.flow,
                };
                runs.iter().map(flow).collect()
            }
        };
        let flow = flows.map(|flows| stats::mean(&flows));
        let rates: Vec<f64> = steady.iter().map(|run| run.throughput).collect();
        let robots = steady.first().map_or(0, |run| run.utilisation.len());
        let utilisation = |robot: usize| {
            let shares: Vec<f64> = steady.iter().map(|run| run.utilisation[robot]).collect();
            stats::mean(&shares)
        };
        let interval = match (&steady[..], flow) {
            ([one], _) => one.interval,
            (_, Some(flow)) => {
                // Of the picked share, as for batches: the scatter of the flows says nothing about
                // the line.
                let mean = stats::mean(&rates);
                let distances = steady
                    .iter()
                    .map(|run| run.throughput - mean / flow * run.flow);
                let squares = distances.map(|distance| distance * distance).sum();
                stats::interval_of(steady.len(), mean, squares)
                    .map(|interval| interval.within(0.0, flow.max(mean)))
            }
            (_, None) => None,
        };
        Self {
            mean: enough.then(|| stats::mean(&rates)),
            interval: interval.filter(|_| enough),
            flow,
            utilisation: match enough {
                true => (0..robots).map(utilisation).collect(),
                false => Vec::new(),
            },
            steady: steady.len(),
            changing: steady.iter().filter(|run| run.flow_changes).count(),
            runs: runs.len(),
            missing: missing.map(|unsteady| unsteady.reason.clone()),
        }
    }

    /// Picks per arriving item, which makes lines on different pattern sets comparable.
    pub fn share(&self) -> Option<f64> {
        let flow = self.flow.filter(|flow| *flow > 0.0)?;
        Some(self.mean? / flow)
    }
}
