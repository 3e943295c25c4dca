//! The times in which each robot is down, drawn and merged.

use super::conditions::Conditions;
use super::outages::RandomOutages;
use crate::decision::Downtime;
use crate::error::{Error, Result, shown_number};
use crate::pattern::random_stream;
use crate::station::Station;
use rand::RngExt;
use rand_distr::Exp1;

/// Derives the seed of random outages from the master seed, so that they do not repeat the random
/// numbers of patterns, grasps and positions.
const OUTAGES: u64 = 0x6f75_7461_6765_7301;
/// More random outages of one robot in a run are treated as a wrong unit.
const MOST: f64 = 1e6;

/// A time in which a robot is down [s]: from the first, included, to the second, excluded.
type Span = (f64, f64);

/// The times in which each robot of a scene is down.
#[derive(Debug, Clone, Default)]
pub(super) struct Downtimes {
    /// For each robot its disjoint times in order; empty if no robot is ever down.
    spans: Vec<Vec<Span>>,
    /// The given outages of each robot.
    given: Vec<Vec<Span>>,
    random: Option<RandomOutages>,
    seed: u64,
}

impl Downtimes {
    /// The outages under `conditions` on `station`, in a run in which no robot decides later than
    /// `last` [s].
    ///
    /// # Errors
    /// An outage of a robot that the station does not have, or far too many random outages.
    pub(super) fn new(conditions: &Conditions, station: &Station, last: f64) -> Result<Self> {
        let robots = station.robots().len();
        let mut given = vec![Vec::new(); robots];
        for outage in &conditions.given_outages {
            given[outage.robot_on(station)?].push((outage.from, outage.to));
        }
        let random = conditions.random_outages;
        if let Some(RandomOutages { mtbf, mttr }) = random
            && last > MOST * (mtbf + mttr)
        {
            return Err(Error::usage(
                "'outages'",
                format!(
                    "a run of {} s has more than {MOST} outages of each robot",
                    shown_number(last.round())
                ),
                "give the mean times in seconds, not in hours or minutes",
            ));
        }
        let mut downtimes = Self {
            spans: Vec::new(),
            given,
            random,
            seed: conditions.disturbances.seed ^ OUTAGES,
        };
        // A robot that goes down at the very last moment does not decide then.
        let last = last.next_up();
        downtimes.spans = (0..robots)
            .map(|robot| downtimes.until(robot, last))
            .collect();
        Ok(downtimes)
    }

    /// Whether no robot is ever down.
    pub(super) fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The times of `robot` that begin before `last` [s], disjoint and in order. What it does up to
    /// then does not depend on later ones.
    fn until(&self, robot: usize, last: f64) -> Vec<Span> {
        let mut all = self.given[robot].clone();
        if let Some(RandomOutages { mtbf, mttr }) = self.random {
            let mut rng = random_stream(self.seed, robot as u64);
            let mut mean = |mean: f64| mean * rng.sample::<f64, _>(Exp1);
            let mut fails = mean(mtbf);
            while fails < last {
                let repaired = fails + mean(mttr);
                all.push((fails, repaired));
                fails = repaired + mean(mtbf);
            }
        }
        all.retain(|&(from, to)| from < last && from < to);
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut merged: Vec<Span> = Vec::with_capacity(all.len());
        for (from, to) in all {
            match merged.last_mut() {
                Some(before) if from <= before.1 => before.1 = before.1.max(to),
                _ => merged.push((from, to)),
            }
        }
        merged
    }

    /// When `robot` is ready again [s], if it is down at `time` [s].
    #[inline]
    pub(super) fn ends(&self, robot: usize, time: f64) -> Option<f64> {
        let spans = self.spans.get(robot)?;
        let begun = spans.partition_point(|&(from, _)| from <= time);
        let (_, to) = spans[begun.checked_sub(1)?];
        (time < to).then_some(to)
    }

    /// Whether `robot` is down at some time from `open` to `close` [s], if any robot is ever down.
    pub(super) fn touch(&self, robot: usize, (open, close): Span) -> bool {
        let spans = &self.spans[robot];
        let over = spans.partition_point(|&(_, to)| to <= open);
        spans.get(over).is_some_and(|&(from, _)| from <= close)
    }

    /// The times in which robots are down while they may decide, in order of beginning, then of
    /// robots.
    pub(super) fn known(&self) -> Vec<Downtime> {
        in_order(self.spans.iter().cloned())
    }

    /// All times up to `end` [s], in the same order.
    pub(super) fn before(&self, end: f64) -> Vec<Downtime> {
        let mut all = in_order((0..self.spans.len()).map(|robot| self.until(robot, end)));
        all.iter_mut().for_each(|down| down.to = down.to.min(end));
        all
    }
}

/// The times of all robots, in order of beginning, then of robots.
fn in_order(of_robots: impl Iterator<Item = Vec<Span>>) -> Vec<Downtime> {
    let of_robot = |(robot, spans): (usize, Vec<Span>)| {
        let spans = spans.into_iter();
        spans.map(move |(from, to)| Downtime { robot, from, to })
    };
    let mut all: Vec<Downtime> = of_robots.enumerate().flat_map(of_robot).collect();
    all.sort_by(|a, b| a.from.total_cmp(&b.from));
    all
}
