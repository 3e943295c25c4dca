//! A monotone table of travel times: medians of groups of like ways, made monotone.
//!
//! The times of neighbouring groups that decrease are averaged until none does, by the algorithm of
//! pooling adjacent violators (Ayer et al. 1955, DOI 10.1214/aoms/1177728423).

use super::model::{Leg, Observation};
use super::robust::{median, scale_of};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::ops::Range;

/// Fewer ways than this do not make a group, nor fewer groups a table.
const LEAST_GROUP: usize = 10;
const LEAST_GROUPS: usize = 3;
/// Ways that differ by less than this are of one length [m].
const LEAST_SPREAD: f64 = 1e-3;
/// More points would follow the noise.
const MOST_GROUPS: usize = 12;
/// Variance of a median over that of a mean of normal values.
const MEDIAN_VARIANCE: f64 = std::f64::consts::FRAC_PI_2;
/// A law is rejected if it would fit as badly by chance with at most this probability,
const REJECTION: f64 = 1e-3;
/// and is off by at least this share of the times, in the root of the mean square over the groups.
const NOTABLE: f64 = 0.01;

/// A table, and the dwell of each bin [s].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TableEstimate {
    /// Points (l [m], t [s]); the first l is 0.
    pub points: Vec<(f64, f64)>,
    /// Indices of the points that are medians of times; the others are extrapolated.
    pub measured: Range<usize>,
    /// Grasp and release time together, for each bin [s].
    pub dwell: Vec<f64>,
}

/// How ways are grouped.
#[derive(Debug, Clone)]
pub(super) struct Groups {
    /// The upper ends of the groups [m], the last of which is infinite.
    ends: Vec<f64>,
    /// Length of the way of an observation [m]; `None` for one that is in no group.
    way: fn(&Observation) -> Option<f64>,
}

/// The way in the plane [m] and the bin of an observation of one way; `None` for others.
fn one_way(observation: &Observation) -> Option<(f64, Option<usize>)> {
    match observation.leg {
        Leg::Out(way) => Some((way, None)),
        Leg::Back(way, bin) => Some((way, Some(bin))),
        _ => None,
    }
}

/// Why no table can be made of these times.
pub(super) fn no_table_because(observations: &[Observation]) -> &'static str {
    let is_chase = |o: &Observation| matches!(o.leg, Leg::Chase(_) | Leg::ChaseHome(..));
    match observations.iter().any(is_chase) {
        true => {
            "a recording does not say when a grasp begins, and without that a table cannot be told \
             from the grasp and release times"
        }
        false => "too few moves say when the grasp began, or over too few lengths",
    }
}

impl Groups {
    /// Groups of equally many single ways, of which a table can be made; `None` if there are too few.
    pub(super) fn of_ways(observations: &[Observation]) -> Option<Self> {
        Self::of(observations, |o| one_way(o).map(|way| way.0))
    }

    /// Groups of equally many times by the longest way in them, whatever they are of; they can only
    /// be asked whether a law fits.
    pub(super) fn of_reaches(observations: &[Observation]) -> Option<Self> {
        Self::of(observations, |o| Some(o.leg.reach()))
    }

    fn of(observations: &[Observation], way: fn(&Observation) -> Option<f64>) -> Option<Self> {
        let mut ways: Vec<f64> = observations.iter().filter_map(way).collect();
        ways.sort_unstable_by(f64::total_cmp);
        let count = (ways.len() / LEAST_GROUP).min(MOST_GROUPS);
        if count < LEAST_GROUPS {
            return None;
        }
        let mut ends: Vec<f64> = (1..count).map(|i| ways[i * ways.len() / count]).collect();
        ends.push(f64::INFINITY);
        let mut last = ways[0];
        ends.retain(|end| {
            let is_apart = end - last >= LEAST_SPREAD;
            last = if is_apart { *end } else { last };
            is_apart
        });
        (ends.len() >= LEAST_GROUPS).then_some(Self { ends, way })
    }

    /// For each group its ways [m] and values.
    fn split(&self, pairs: impl Iterator<Item = (f64, f64)>) -> Vec<(Vec<f64>, Vec<f64>)> {
        let mut groups = vec![(Vec::new(), Vec::new()); self.ends.len()];
        for (way, value) in pairs {
            let group = self.ends.partition_point(|end| *end <= way);
            let (ways, values) = &mut groups[group.min(self.ends.len() - 1)];
            ways.push(way);
            values.push(value);
        }
        groups
    }

    /// Whether the `residuals` of a law with this number of parameters depend on the way more than
    /// by chance, and notably: whether the law does not fit. The stamps have this step [s], or 0.
    pub(super) fn reject(
        &self,
        observations: &[Observation],
        residuals: &[f64],
        (parameters, step): (usize, f64),
    ) -> bool {
        let pairs = observations.iter().zip(residuals);
        let pairs = pairs.filter_map(|(o, r)| (self.way)(o).map(|way| (way, *r)));
        let groups = self.split(pairs);
        let centre = |values: &[f64]| median(values.to_vec());
        let within = groups.iter().flat_map(|(_, values)| {
            let centre = centre(values);
            values.iter().map(move |value| value - centre)
        });
        let scale = scale_of(&within.collect::<Vec<_>>(), step);
        let filled = groups.iter().filter(|(_, values)| !values.is_empty());
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0usize);
        for (_, values) in filled {
            // The median of rounded times may be off by half a step, however many they are.
            let off = (centre(values).abs() - 0.5 * step).max(0.0);
            sum += values.len() as f64 * (off / scale).powi(2) / MEDIAN_VARIANCE;
            squares += off * off;
            count += 1;
        }
        let Some(freedom) = count.checked_sub(parameters).filter(|freedom| *freedom > 0) else {
            return false;
        };
        let times = observations.iter().filter(|o| (self.way)(o).is_some());
        let typical = median(times.map(|o| o.time).collect());
        let is_notable = (squares / count as f64).sqrt() > NOTABLE * typical;
        let limit = ChiSquared::new(freedom as f64).map(|chi| chi.inverse_cdf(1.0 - REJECTION));
        is_notable && limit.is_ok_and(|limit| sum > limit)
    }

    /// The table of these observations of an arm with this lift, `2 h` [m]. `dwell` is where the
    /// search for the dwells begins; they stay if no way out is known, because they are then part of
    /// the times.
    pub(super) fn table(
        &self,
        observations: &[Observation],
        lift: f64,
        dwell: &[f64],
    ) -> TableEstimate {
        let mut estimate = TableEstimate {
            points: Vec::new(),
            measured: 0..0,
            dwell: dwell.to_vec(),
        };
        let has_out = observations.iter().any(|o| matches!(o.leg, Leg::Out(_)));
        for _ in 0..if has_out { 8 } else { 1 } {
            let pairs = observations.iter().filter_map(|o| {
                let (way, bin) = one_way(o)?;
                let dwell = bin.map_or(0.0, |bin| estimate.dwell[bin]);
                Some((way + lift, o.time - dwell))
            });
            let ends = self.ends.iter().map(|end| end + lift).collect();
            (estimate.points, estimate.measured) = Self { ends, ..*self }.points(pairs);
            if has_out {
                estimate.dwell = dwells(observations, lift, &estimate, dwell);
            }
        }
        estimate
    }

    /// The points of a table of these lengths [m] and times [s], and which of them are medians.
    fn points(&self, pairs: impl Iterator<Item = (f64, f64)>) -> (Vec<(f64, f64)>, Range<usize>) {
        let groups = self.split(pairs);
        let groups = groups.into_iter().filter(|(ways, _)| !ways.is_empty());
        let groups: Vec<(f64, f64, f64)> = groups
            .map(|(ways, values)| (ways.len() as f64, median(ways), median(values).max(0.0)))
            .collect();
        let levels = monotone(groups.iter().map(|group| (group.0, group.2)));
        let points = groups
            .iter()
            .zip(levels)
            .map(|(group, level)| (group.1, level));
        let mut points: Vec<(f64, f64)> = points.collect();
        points.dedup_by(|next, point| next.0 <= point.0);
        let slope = match points.as_slice() {
            [first, second, ..] => (second.1 - first.1) / (second.0 - first.0),
            _ => 0.0,
        };
        let mut measured = 0..points.len();
        if let Some(&(way, time)) = points.first().filter(|point| point.0 > 0.0) {
            points.insert(0, (0.0, (time - slope * way).max(0.0)));
            measured = 1..points.len();
        }
        if let [only] = points[..] {
            points.push((only.0 + 1.0, only.1));
        }
        (points, measured)
    }
}

/// The median of what the ways back take longer than the table says, for each bin; `before` where
/// there is none.
fn dwells(
    observations: &[Observation],
    lift: f64,
    table: &TableEstimate,
    before: &[f64],
) -> Vec<f64> {
    let dwell = |bin: usize| {
        let longer = observations.iter().filter_map(|o| match o.leg {
            Leg::Back(way, own) if own == bin => Some(o.time - table.time(way + lift)),
            _ => None,
        });
        let longer: Vec<f64> = longer.collect();
        match longer.is_empty() {
            true => before[bin],
            false => median(longer).max(0.0),
        }
    };
    (0..before.len()).map(dwell).collect()
}

impl TableEstimate {
    /// T of a path of this length [m].
    pub(super) fn time(&self, length: f64) -> f64 {
        crate::kinematics::TravelLaw::Table(self.points.clone()).time(length)
    }

    /// The time that a leg takes [s] with this lift, `2 h` [m]; `None` for one that chases an item.
    pub(super) fn predict(&self, leg: &Leg, lift: f64) -> Option<f64> {
        match *leg {
            Leg::Out(way) => Some(self.time(way + lift)),
            Leg::Back(way, bin) => Some(self.dwell[bin] + self.time(way + lift)),
            Leg::Whole(out, back, bin) => {
                Some(self.dwell[bin] + self.time(out + lift) + self.time(back + lift))
            }
            Leg::Chase(_) | Leg::ChaseHome(..) => None,
        }
    }
}

/// The nearest values that never decrease, by least squares with weights.
fn monotone(weighted: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut blocks: Vec<(f64, f64, usize)> = Vec::new();
    for (weight, value) in weighted {
        blocks.push((weight, value, 1));
        while let [.., (w1, v1, n1), (w2, v2, n2)] = blocks[..]
            && v1 > v2
        {
            blocks.truncate(blocks.len() - 2);
            blocks.push((w1 + w2, (w1 * v1 + w2 * v2) / (w1 + w2), n1 + n2));
        }
    }
    let levels = blocks.iter();
    levels
        .flat_map(|&(_, value, count)| std::iter::repeat_n(value, count))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_decreases_is_pooled() {
        let values = [(1.0, 1.0), (1.0, 3.0), (3.0, 2.0), (1.0, 4.0), (1.0, 0.0)];
        let found = monotone(values.into_iter());
        // 3 and 2 by 1:3, then 4 and 0 with them: (2.25 * 4 + 4 + 0) / 6.
        let pooled = (2.25 * 4.0 + 4.0) / 6.0;
        assert_eq!(found[0], 1.0);
        assert!(
            found[1..]
                .iter()
                .all(|value| (value - pooled).abs() < 1e-12),
            "{found:?}"
        );
    }
}
