//! Throughput: the picks per minute of a line in its steady state, without run-in, run-out and idle
//! belt. `docs/model.md` defines the rule implemented here.

mod arrivals;

use crate::decision::{LeftItem, LeftReason, Outcome, Pick};
use crate::sim::Scene;
use crate::stats::{self, Interval};
use arrivals::{Arrivals, Changes};
use std::fmt;
use std::ops::Range;

/// The steady state of one run.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct SteadyState {
    /// Its items, as indices into those of the pattern that are to be picked.
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
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Unsteady {
    /// Items that arrive per minute over the whole pattern [1/min]; `None` if all arrive at once.
    pub flow: Option<f64>,
    /// Why there is no steady state.
    pub reason: UnsteadyReason,
}

/// Why a run has no steady state. Displays as a sentence with the cure.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum UnsteadyReason {
    /// No item is to be picked.
    Empty {
        /// Whether some are left because of their probability of detection.
        uncertain: bool,
    },
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
    /// No item arrives between the run-in and the run-out.
    Bunched {
        /// The longest departure window [s].
        window: f64,
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
/// Items in a batch of the truncation rule (the 5 in MSER-5).
const MSER_BATCH: usize = 5;
impl fmt::Display for UnsteadyReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { uncertain: false } => f.write_str(
                "no item is to be picked; give the items classes that robots have bins for",
            ),
            Self::Empty { uncertain: true } => f.write_str(
                "no item is to be picked: their probabilities of detection are below the threshold; \
                 give a lower one",
            ),
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
            Self::Bunched { window } => write!(
                f,
                "no items arrive between {window:.1} s after the first item and {window:.1} s before the \
                 last one, {window:.1} s being the longest departure window; give a pattern with items \
                 in between"
            ),
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
            flow: arrivals.whole_flow(),
            reason,
        })
    };
    if scene.offered() == 0 {
        let low = |left: &LeftItem| left.reason == LeftReason::LowDetection;
        return unsteady(UnsteadyReason::Empty {
            uncertain: scene.left().iter().any(low),
        });
    }
    let window = longest_window(scene);
    let groups = arrivals.starts.len();
    let (first, last) = match groups {
        0 => (0.0, 0.0),
        _ => (arrivals.time(0), arrivals.time(groups - 1)),
    };
    let lasts = last - first;
    if groups < 2 || lasts < WINDOWS * window {
        return unsteady(UnsteadyReason::Short {
            lasts,
            window,
            items: enough_items(scene).filter(|&items| items > arrivals.items()),
        });
    }
    let begin = (0..groups).find(|&g| arrivals.time(g) >= first + window);
    let end = (0..groups).rfind(|&g| arrivals.time(g) <= last - window);
    let (begin, end) = (begin.unwrap_or(0), end.unwrap_or(groups - 1));
    if begin >= end {
        return unsteady(UnsteadyReason::Bunched { window });
    }
    let whole = arrivals.starts[begin]..arrivals.starts[end];
    let drifting = UnsteadyReason::Drifting {
        items: 2 * arrivals.items(),
    };
    let summarise = |groups, flow_changes| {
        let mut state = steady_over(&arrivals, groups, window, scene, outcome);
        state.flow_changes = flow_changes;
        Ok(state)
    };
    let changes = arrivals.changes();
    if changes == Changes::InOrder {
        return summarise(begin..end, true);
    }
    let left = truncate(whole, &pick_series(&arrivals, scene, outcome)).and_then(|left| {
        // Cuts fall between arrival times, so that items that arrive together stay together.
        let begin = arrivals.starts.partition_point(|&start| start < left.start);
        let end = arrivals.starts.partition_point(|&start| start <= left.end) - 1;
        (begin < end).then_some(begin..end)
    });
    match left {
        Some(left) if changes == Changes::None || !arrivals.elsewhere(&left) => {
            summarise(left, false)
        }
        None if changes != Changes::Uneven => unsteady(drifting),
        _ => summarise(begin..end, true),
    }
}

/// A number of items, at the density of the pattern on `scene`, that is enough for a steady state;
/// `None` if there is no density.
pub(crate) fn enough_items(scene: &Scene) -> Option<usize> {
    let arrivals = Arrivals::of(scene);
    let flow = arrivals.whole_flow();
    flow.map(|flow| round_up(ENOUGH_WINDOWS * longest_window(scene) * flow / 60.0))
}

/// The steady state whose items are those of these `groups`, with an interval from batches of at
/// least `window` [s], for a pattern whose flow does not change.
fn steady_over(
    arrivals: &Arrivals,
    groups: Range<usize>,
    window: f64,
    scene: &Scene,
    outcome: &Outcome,
) -> SteadyState {
    let starts = &arrivals.starts;
    let items = arrivals.items();
    let mut picked_before = vec![0; items + 1];
    for pick in &outcome.picks {
        picked_before[arrivals.ranks[pick.item as usize] + 1] = 1;
    }
    for i in 0..items {
        picked_before[i + 1] += picked_before[i];
    }
    let picked = |groups: &Range<usize>| -> usize {
        picked_before[starts[groups.end]] - picked_before[starts[groups.start]]
    };
    let count = |groups: &Range<usize>| starts[groups.end] - starts[groups.start];
    let flow = arrivals.whole_flow().unwrap_or_default();
    let share = picked(&groups) as f64 / count(&groups) as f64;
    let batches = arrivals.batches(&groups, window);
    // The share is a ratio of two sums. A batch's deviation is therefore its picks minus the
    // share of its items, divided by the mean number of items.
    let mean = count(&groups) as f64 / batches.len() as f64;
    let squares = batches.iter().map(|batch| {
        let distance = (picked(batch) as f64 - share * count(batch) as f64) / mean;
        distance * distance
    });
    let squares: Vec<f64> = squares.collect();
    let interval = stats::interval_of(squares.len(), share, squares.iter().sum());
    let (start, end) = (arrivals.time(groups.start), arrivals.time(groups.end));
    SteadyState {
        items: starts[groups.start]..starts[groups.end],
        start,
        end,
        picked: picked(&groups),
        throughput: share * flow,
        interval: interval.map(|share| share.within(0.0, 1.0).times(flow)),
        flow,
        flow_changes: false,
        utilisation: utilisation(scene, outcome, start..end),
    }
}

/// For each robot, the share of the time that it is busy while what arrives in `arrives` [s] passes
/// its base.
fn utilisation(scene: &Scene, outcome: &Outcome, arrives: Range<f64>) -> Vec<f64> {
    let station = scene.station();
    let busy = |robot: usize| {
        let passes = station.robots()[robot].base.x / station.belt().speed;
        let failed = outcome.failures.iter().map(|failure| &failure.attempt);
        let attempts = outcome.picks.iter().chain(failed);
        let overlap = |pick: &Pick| {
            let (start, end) = (arrives.start + passes, arrives.end + passes);
            (pick.release.min(end) - pick.decide.max(start)).max(0.0)
        };
        attempts
            .filter(|pick| pick.robot == robot)
            .map(overlap)
            .sum::<f64>()
    };
    let robots = 0..station.robots().len();
    robots
        // An empty sum is -0.
        .map(|robot| (busy(robot) / (arrives.end - arrives.start)).min(1.0) + 0.0)
        .collect()
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
fn pick_series(arrivals: &Arrivals, scene: &Scene, outcome: &Outcome) -> [Vec<f64>; 2] {
    let items = arrivals.items();
    let station = scene.station();
    let ends = station.robots().iter().map(|r| r.base.x + r.reach);
    let end = ends.fold(0.0, f64::max).min(station.belt().length);
    let mut picked = vec![0.0; items];
    let mut left = vec![end; items];
    for pick in &outcome.picks {
        let rank = arrivals.ranks[pick.item as usize];
        picked[rank] = 1.0;
        left[rank] = pick.meet.x.min(end);
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
