//! The statistics used to report results.

use crate::pattern::random_stream;
use rand::RngExt;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Coverage of every reported interval.
pub(crate) const CONFIDENCE: f64 = 0.95;

/// A closed interval `[low, high]`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// Lower end, included.
    pub low: f64,
    /// Upper end, included.
    pub high: f64,
}

impl Interval {
    /// The interval that contains only `value`.
    pub fn point(value: f64) -> Self {
        Self {
            low: value,
            high: value,
        }
    }

    /// The interval clamped to the possible range, `low` to `high`.
    pub fn within(self, low: f64, high: f64) -> Self {
        Self {
            low: self.low.max(low).min(high),
            high: self.high.min(high).max(low),
        }
    }

    /// The interval with both ends multiplied by `factor`.
    pub fn times(self, factor: f64) -> Self {
        Self {
            low: factor * self.low,
            high: factor * self.high,
        }
    }

    /// Whether the two ends differ.
    pub fn is_wide(&self) -> bool {
        self.low < self.high
    }

    /// Whether `value` lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// Arithmetic mean. The values are summed in order, so the result does not depend on the number of
/// threads.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// 95 % interval of the mean by Student's t. If all values are equal, the interval is that point.
/// `None` for a single value, which does not show how others would scatter.
pub(crate) fn mean_interval(values: &[f64]) -> Option<Interval> {
    let centre = mean(values);
    let squares: f64 = values.iter().map(|v| (v - centre) * (v - centre)).sum();
    interval_of(values.len(), centre, squares)
}

/// 95 % interval of the mean of shares, clamped to 0 to 1.
pub(crate) fn share_mean_interval(shares: &[f64]) -> Option<Interval> {
    mean_interval(shares).map(|interval| interval.within(0.0, 1.0))
}

/// 95 % interval of the mean of rates, clamped to 0 and above.
pub(crate) fn rate_mean_interval(rates: &[f64]) -> Option<Interval> {
    mean_interval(rates).map(|interval| interval.within(0.0, f64::INFINITY))
}

/// 95 % interval by Student's t of the mean of `count` values with mean `centre` and sum of squared
/// deviations `squares`; `None` for fewer than two values.
pub(crate) fn interval_of(count: usize, centre: f64, squares: f64) -> Option<Interval> {
    if count < 2 {
        return None;
    }
    let n = count as f64;
    if squares <= 0.0 {
        return Some(Interval::point(centre));
    }
    // With at least one degree of freedom the distribution always exists.
    let t = StudentsT::new(0.0, 1.0, n - 1.0)
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + CONFIDENCE / 2.0));
    let half = t * (squares / (n - 1.0) / n).sqrt();
    Some(Interval {
        low: centre - half,
        high: centre + half,
    })
}

/// How many of the first `values` belong to the run-in by the marginal standard error rule, MSER
/// (White 1997, DOI 10.1177/003754979706900601). The rule cuts off the first d values, for d up to
/// half of them, and chooses the d that minimises the squared standard error of the rest, sum((v -
/// mean)^2) / (n - d)^2; on a tie the smallest d. `None` if d is half of the values, which means
/// that they have not settled.
pub(crate) fn mser(values: &[f64]) -> Option<usize> {
    let n = values.len();
    if n < 2 {
        return (n == 1).then_some(0);
    }
    // Welford's sums, from the last value backwards, so that each cut takes one step.
    let (mut mean, mut squares) = (0.0, 0.0);
    let mut best: Option<(usize, f64)> = None;
    for cut in (0..n).rev() {
        let count = (n - cut) as f64;
        let distance = values[cut] - mean;
        mean += distance / count;
        squares += distance * (values[cut] - mean);
        let error = squares / (count * count);
        if cut <= n / 2 && best.is_none_or(|(_, least)| error <= least) {
            best = Some((cut, error));
        }
    }
    best.map(|(cut, _)| cut)
        .filter(|&cut| cut < n / 2 || cut == 0)
}

/// Mean of the worst `share` of the values (conditional value at risk; Rockafellar and Uryasev
/// 2000, DOI 10.21314/JOR.2000.038); their number is rounded up. Reorders `values`.
pub(crate) fn worst_mean(values: &mut [f64], share: f64) -> f64 {
    let count = ((share * values.len() as f64).ceil() as usize).clamp(1, values.len());
    if count < values.len() {
        values.select_nth_unstable_by(count - 1, f64::total_cmp);
    }
    let worst = &mut values[..count];
    // Selection leaves them in an unspecified order; sorting makes the sum reproducible.
    worst.sort_unstable_by(f64::total_cmp);
    mean(worst)
}

/// The value below which `share`, 0 to 1, of the sorted values lie, rounded to the nearest of them.
///
/// # Panics
/// Without values, or with another share.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    assert!(!sorted.is_empty() && (0.0..=1.0).contains(&share));
    sorted[(share * (sorted.len() - 1) as f64).round() as usize]
}

/// Wilson's 95 % score interval of the share of `hits` in `trials` (Wilson 1927, DOI
/// 10.1080/01621459.1927.10502953).
///
/// # Panics
/// With more hits than trials, or without trials.
pub fn share_interval(hits: usize, trials: usize) -> Interval {
    assert!(trials > 0 && hits <= trials);
    let n = trials as f64;
    let p = hits as f64 / n;
    let z = Normal::standard().inverse_cdf(0.5 + CONFIDENCE / 2.0);
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    Interval {
        low: (centre - half).max(0.0).min(p),
        high: (centre + half).min(1.0).max(p),
    }
}

/// 95 % interval of the share of hits among the trials of several samples, each with its `(hits,
/// trials)`, by the ratio estimator (Cochran 1977, Sampling Techniques, ISBN 0-471-16240-X, section
/// 6.3): samples have different numbers of trials, and those of one may depend on each other.
/// Without any scatter it is that of [`share_interval`], because hits alone do not prove that
/// nothing else is possible. `None` for fewer than two samples, and without trials.
///
/// # Panics
/// With more hits than trials in total.
pub fn pooled_share_interval(samples: &[(usize, usize)]) -> Option<Interval> {
    let hits: usize = samples.iter().map(|sample| sample.0).sum();
    let trials: usize = samples.iter().map(|sample| sample.1).sum();
    if trials == 0 {
        return None;
    }
    match ratio_interval(samples)? {
        ends if ends.is_wide() => Some(ends.within(0.0, 1.0)),
        _ => Some(share_interval(hits, trials)),
    }
}

/// 95 % interval of the ratio of two totals over several samples, each with its `(part, whole)`, by the
/// ratio estimator (Cochran 1977, Sampling Techniques, ISBN 0-471-16240-X, section 6.3). `None` for
/// fewer than two samples, and without a whole.
pub(crate) fn ratio_interval(samples: &[(usize, usize)]) -> Option<Interval> {
    let part: usize = samples.iter().map(|sample| sample.0).sum();
    let whole: usize = samples.iter().map(|sample| sample.1).sum();
    if whole == 0 {
        return None;
    }
    let ratio = part as f64 / whole as f64;
    let mean_whole = whole as f64 / samples.len() as f64;
    let off = |(part, whole): &(usize, usize)| {
        let residual = (*part as f64 - ratio * *whole as f64) / mean_whole;
        residual * residual
    };
    interval_of(samples.len(), ratio, samples.iter().map(off).sum())
}

/// Index resamples for a paired bootstrap (Efron 1979, DOI 10.1214/aos/1176344552). Every
/// comparison uses the same resamples.
#[derive(Debug)]
pub struct Bootstrap {
    resamples: Vec<Vec<u32>>,
}

impl Bootstrap {
    /// Draws `count` resamples of `n` indices from `seed`.
    pub fn new(n: usize, count: usize, seed: u64) -> Self {
        let mut rng = random_stream(seed, 0);
        let resamples = (0..count)
            .map(|_| (0..n).map(|_| rng.random_range(0..n as u32)).collect())
            .collect();
        Self { resamples }
    }

    /// 95 % percentile interval of `statistic(a) - statistic(b)`, with the same resamples for both.
    pub fn difference(
        &self,
        a: &[f64],
        b: &[f64],
        statistic: impl Fn(&mut [f64]) -> f64,
    ) -> Interval {
        if a == b {
            return Interval::point(0.0);
        }
        let mut buffer = Vec::with_capacity(a.len());
        let mut of = |values: &[f64], indices: &[u32]| {
            buffer.clear();
            buffer.extend(indices.iter().map(|&i| values[i as usize]));
            statistic(&mut buffer)
        };
        let mut differences: Vec<f64> = self
            .resamples
            .iter()
            .map(|indices| of(a, indices) - of(b, indices))
            .collect();
        differences.sort_unstable_by(f64::total_cmp);
        let tail = (1.0 - CONFIDENCE) / 2.0;
        Interval {
            low: quantile(&differences, tail),
            high: quantile(&differences, 1.0 - tail),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn t_interval_of_a_known_sample() {
        // t(0.975, 4) = 2.776445; sd of 1..5 is sqrt(2.5).
        let interval = mean_interval(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let half = 2.776_445_105 * (2.5f64 / 5.0).sqrt();
        assert!((interval.low - (3.0 - half)).abs() < 1e-6);
        assert!((interval.high - (3.0 + half)).abs() < 1e-6);
        assert_eq!(mean_interval(&[7.0]), None);
        assert_eq!(mean_interval(&[7.0, 7.0]), Some(Interval::point(7.0)));
    }

    #[test]
    fn worst_mean_takes_the_low_end() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!(worst_mean(&mut values.clone(), 0.4), 1.5);
        assert_eq!(worst_mean(&mut values.clone(), 1.0), 3.0);
        assert_eq!(worst_mean(&mut values.clone(), 1e-9), 1.0);
    }

    #[test]
    fn the_truncation_rule_finds_the_end_of_a_run_in() {
        let noise = |i: usize| ((i * 7919) % 13) as f64 / 13.0;
        let settled: Vec<f64> = (0..60).map(noise).collect();
        assert!(mser(&settled).unwrap() < 15);
        let run_in = |i: usize| noise(i) + 5.0 * (1.0 - i as f64 / 20.0).max(0.0);
        let late: Vec<f64> = (0..60).map(run_in).collect();
        let cut = mser(&late).unwrap();
        assert!((15..=22).contains(&cut), "{cut}");
        let growing: Vec<f64> = (0..60).map(|i| i as f64).collect();
        assert_eq!(mser(&growing), None);
        assert_eq!(mser(&[1.0; 60]), Some(0));
        assert_eq!((mser(&[]), mser(&[3.0])), (None, Some(0)));
        assert_eq!((mser(&[3.0, 3.0]), mser(&[3.0, 4.0])), (Some(0), None));
    }

    #[test]
    fn wilson_interval_of_a_known_share() {
        // 994 of 1000, computed by hand from the formula with z = 1.959964.
        let interval = share_interval(994, 1000);
        assert!((interval.low - 0.986_97).abs() < 1e-4, "{interval:?}");
        assert!((interval.high - 0.997_25).abs() < 1e-4, "{interval:?}");
        assert_eq!(share_interval(10, 10).high, 1.0);
        assert_eq!(share_interval(0, 10).low, 0.0);
    }

    #[test]
    fn pooled_shares_have_the_interval_of_a_ratio() {
        // Equal numbers of trials: the mean of the shares, with Student's t.
        let equal = [(8, 10), (9, 10), (7, 10), (10, 10)];
        let shares = equal.map(|(hits, trials)| f64::from(hits) / f64::from(trials));
        let samples = equal.map(|(hits, trials)| (hits as usize, trials as usize));
        let pooled = pooled_share_interval(&samples).unwrap();
        let plain = share_mean_interval(&shares).unwrap();
        assert!(
            (pooled.low - plain.low).abs() < 1e-12,
            "{pooled:?} {plain:?}"
        );
        assert!((pooled.high - plain.high).abs() < 1e-12);
        // Unequal numbers, by hand: 15 of 20; residuals 9 - 0.75 * 10 and 6 - 0.75 * 10, mean 10.
        let wide = pooled_share_interval(&[(9, 10), (6, 10)]).unwrap();
        assert_eq!((wide.low, wide.high), (0.0, 1.0));
        let three = pooled_share_interval(&[(9, 10), (12, 20), (3, 6)]).unwrap();
        let share = 24.0 / 36.0;
        let residuals = [9.0 - 10.0 * share, 12.0 - 20.0 * share, 3.0 - 6.0 * share];
        let squares: f64 = residuals.iter().map(|r| (r / 12.0) * (r / 12.0)).sum();
        // t(0.975, 2) = 4.302653.
        let half = 4.302_652_73 * (squares / 6.0).sqrt();
        assert!(
            (three.high - (share + half).min(1.0)).abs() < 1e-6,
            "{three:?}"
        );
        assert!((three.low - (share - half)).abs() < 1e-6, "{three:?}");
        // Nothing but hits is not certainty.
        let hits = pooled_share_interval(&[(50, 50), (50, 50)]).unwrap();
        assert_eq!(hits, share_interval(100, 100));
        for none in [&[][..], &[(5, 6)], &[(0, 0), (0, 0)]] {
            assert_eq!(pooled_share_interval(none), None);
        }
    }

    /// 95 of 100 intervals contain the share that the samples were drawn with.
    #[test]
    fn intervals_of_pooled_shares_cover_the_truth() {
        let mut rng = random_stream(11, 0);
        let mut covered = 0;
        for _ in 0..400 {
            let samples: Vec<(usize, usize)> = (0..20)
                .map(|_| {
                    let trials = rng.random_range(10..80usize);
                    let hits = (0..trials).filter(|_| rng.random::<f64>() < 0.9).count();
                    (hits, trials)
                })
                .collect();
            covered += usize::from(pooled_share_interval(&samples).unwrap().contains(0.9));
        }
        assert!((364..=395).contains(&covered), "{covered} of 400");
    }

    #[test]
    fn bootstrap_of_means_is_near_the_t_interval() {
        let a: Vec<f64> = (0..200).map(|i| f64::from(i % 17)).collect();
        let b: Vec<f64> = (0..200).map(|i| f64::from(i % 13)).collect();
        let differences: Vec<f64> = a.iter().zip(&b).map(|(x, y)| x - y).collect();
        let t = mean_interval(&differences).unwrap();
        let boot = Bootstrap::new(200, 2000, 1).difference(&a, &b, |v| mean(v));
        assert!((t.low - boot.low).abs() < 0.1 && (t.high - boot.high).abs() < 0.1);
    }

    #[test]
    fn intervals_are_cut_scaled_and_asked() {
        let of = |low: f64, high: f64| Interval { low, high };
        for ((low, high), cut) in [
            ((-1.0, 2.0), (0.0, 1.0)),
            ((0.2, 0.7), (0.2, 0.7)),
            ((2.0, 3.0), (1.0, 1.0)),
            ((-3.0, -2.0), (0.0, 0.0)),
        ] {
            assert_eq!(of(low, high).within(0.0, 1.0), of(cut.0, cut.1));
        }
        assert_eq!(of(0.5, 2.0).times(3.0), of(1.5, 6.0));
        assert_eq!(Interval::point(2.5), of(2.5, 2.5));
        let middle = of(1.0, 3.0);
        let inside = [0.9, 1.0, 2.0, 3.0, 3.1].map(|value| middle.contains(value));
        assert_eq!(inside, [false, true, true, true, false]);
        assert!(middle.is_wide() && !Interval::point(2.0).is_wide());
    }

    /// t(0.975, 1) = 12.7062, so the intervals of two values reach far.
    #[test]
    fn intervals_of_shares_and_rates_are_cut_to_what_is_possible() {
        let plain = mean_interval(&[0.4, 0.8]).unwrap();
        assert!(
            (plain.low - (0.6 - 12.706_204_736 * 0.2)).abs() < 1e-6,
            "{plain:?}"
        );
        assert!((plain.high - (0.6 + 12.706_204_736 * 0.2)).abs() < 1e-6);
        let share = share_mean_interval(&[0.4, 0.8]).unwrap();
        assert_eq!((share.low, share.high), (0.0, 1.0));
        let rate = rate_mean_interval(&[0.4, 0.8]).unwrap();
        assert_eq!((rate.low, rate.high), (0.0, plain.high));
        assert_eq!(
            (share_mean_interval(&[0.5]), rate_mean_interval(&[0.5])),
            (None, None)
        );
        assert_eq!(
            (interval_of(1, 0.5, 1.0), interval_of(0, 0.5, 1.0)),
            (None, None)
        );
        assert_eq!(interval_of(2, 0.5, -1e-18), Some(Interval::point(0.5)));
    }

    /// The rule computed from its definition, each cut separately.
    #[test]
    fn the_truncation_rule_is_the_best_of_all_cuts() {
        let mut rng = random_stream(3, 0);
        let (mut settled, mut drifting) = (0, 0);
        for round in 0..400 {
            let n = 2 + round % 17;
            let drift = f64::from(rng.random_range(0..3u32));
            let values: Vec<f64> = (0..n)
                .map(|i| rng.random::<f64>() + drift * ((n / 2) as f64 - i as f64).max(0.0))
                .collect();
            let error = |cut: usize| {
                let left = &values[cut..];
                let middle = mean(left);
                let squares: f64 = left.iter().map(|v| (v - middle).powi(2)).sum();
                squares / (left.len() * left.len()) as f64
            };
            let best = (0..=n / 2)
                .min_by(|&a, &b| error(a).total_cmp(&error(b)))
                .unwrap();
            let expected = (best < n / 2).then_some(best);
            assert_eq!(mser(&values), expected, "{values:?}");
            settled += usize::from(expected.is_some_and(|cut| cut > 0));
            drifting += usize::from(expected.is_none());
        }
        assert!(settled > 20 && drifting > 50, "{settled} {drifting}");
    }

    #[test]
    fn the_worst_are_counted_up() {
        let values = [0.3, -1.0, 2.0, 5.0, 0.1, 7.0, -4.0];
        let mut sorted = values;
        sorted.sort_by(f64::total_cmp);
        for (share, count) in [
            (0.01, 1),
            (1.0 / 7.0, 1),
            (0.15, 2),
            (0.5, 4),
            (0.99, 7),
            (1.0, 7),
        ] {
            let expected = sorted[..count].iter().sum::<f64>() / count as f64;
            assert_eq!(worst_mean(&mut values.clone(), share), expected, "{share}");
        }
    }

    #[test]
    fn a_quantile_is_the_nearest_value() {
        let sorted: Vec<f64> = (0..11).map(f64::from).collect();
        let found = [0.0, 0.04, 0.06, 0.5, 0.94, 0.96, 1.0].map(|share| quantile(&sorted, share));
        assert_eq!(found, [0.0, 0.0, 1.0, 5.0, 9.0, 10.0, 10.0]);
    }

    /// Both ends p solve `(hits/n - p)^2 = z^2 p (1 - p) / n`.
    #[test]
    fn wilsons_interval_solves_its_equation() {
        for (hits, trials) in [(3, 10), (1, 7), (50, 120), (9, 10), (1, 2)] {
            let (n, z) = (trials as f64, 1.959_963_985);
            let share = hits as f64 / n;
            let Interval { low, high } = share_interval(hits, trials);
            assert!(0.0 < low && low < share && share < high && high < 1.0);
            for p in [low, high] {
                let off = (share - p).powi(2) - z * z * p * (1.0 - p) / n;
                assert!(off.abs() < 1e-9, "{hits} of {trials}: {p}");
            }
        }
        let none = share_interval(0, 10);
        assert!(
            none.low == 0.0 && (none.high - 0.277_533).abs() < 1e-5,
            "{none:?}"
        );
    }

    /// From 40 resamples of one value each, the second lowest and the second highest difference.
    #[test]
    fn a_bootstrap_takes_the_middle_of_the_resamples() {
        let bootstrap = Bootstrap {
            resamples: (0..40).rev().map(|i| vec![i]).collect(),
        };
        let a: Vec<f64> = (0..40).map(|i| 3.0 * f64::from(i)).collect();
        let b: Vec<f64> = (0..40).map(f64::from).collect();
        let found = bootstrap.difference(&a, &b, |values| values[0]);
        assert_eq!((found.low, found.high), (2.0, 76.0));
        let found = bootstrap.difference(&b, &a, |values| values[0]);
        assert_eq!((found.low, found.high), (-76.0, -2.0));
        assert_eq!(
            bootstrap.difference(&a, &a, |_| f64::NAN),
            Interval::point(0.0)
        );
        let drawn = Bootstrap::new(5, 300, 1).resamples;
        assert!(drawn.len() == 300 && drawn.iter().all(|sample| sample.len() == 5));
        let mut seen = [0; 5];
        drawn.iter().flatten().for_each(|&i| seen[i as usize] += 1);
        assert!(
            seen.iter().all(|&count| (230..370).contains(&count)),
            "{seen:?}"
        );
        assert_ne!(Bootstrap::new(5, 300, 2).resamples, drawn);
    }
}
