//! Which of many assignments are worth scoring on more patterns.
//!
//! An assignment is dropped as soon as the patterns so far say that it is not the best: under the
//! worst pattern and the conditional value at risk because it cannot be, under the mean by a paired
//! test against the leader (racing: Maron and Moore 1997, DOI 10.1023/A:1006556606079). Of those that
//! pass, fewer go on the more patterns they are scored on, so that every round costs about the same
//! (successive halving: Jamieson and Talwalkar 2016, arXiv:1502.07943).

use super::objective::Risk;
use crate::stats;

/// Standard errors by which an assignment may be behind the leader and still go on. Tests are
/// repeated for many assignments, so it is well above the 1.96 of a single one.
const ERRORS: f64 = 2.6;
/// Assignments per robot that may go on from the first round.
const PER_ROBOT: usize = 16;
/// Assignments that may always go on.
const FEWEST: usize = 4;

/// Number of patterns in the round after one of `count`.
pub(super) fn next_count(count: usize, patterns: usize) -> usize {
    (2 * count).min(patterns)
}

/// Number of assignments that may go on from `sample` patterns to `count` on a line of `robots`
/// robots.
pub(super) fn most_going_on(robots: usize, sample: usize, count: usize) -> usize {
    (2 * PER_ROBOT * robots * sample / count).max(FEWEST)
}

/// Whether an assignment with `values` on the first of `patterns` patterns may still be better over
/// all of them than the leader, which has the values `leader` on the same and aggregates to `beaten`
/// over all if that is known.
pub(super) fn may_win(
    risk: Risk,
    values: &[f64],
    leader: &[f64],
    beaten: Option<f64>,
    patterns: usize,
) -> bool {
    let count = values.len();
    let most = match risk {
        Risk::Mean => None,
        Risk::Worst => Some(risk.aggregate(values)),
        // The worst m of all patterns are no better than the worst m of some.
        Risk::Cvar(share) => {
            let share = (share * patterns as f64).ceil() / count as f64;
            (share <= 1.0).then(|| Risk::Cvar(share).aggregate(values))
        }
    };
    match (risk, most, beaten) {
        (Risk::Mean, ..) => {
            let behind: Vec<f64> = leader.iter().zip(values).map(|(l, v)| l - v).collect();
            stats::mean(&behind) <= ERRORS * standard_error(&behind, patterns)
        }
        (_, Some(most), Some(beaten)) => most > beaten,
        _ => true,
    }
}

/// Standard error of the mean of `values`, which were drawn from `total` values without replacement
/// (Cochran 1977, Sampling Techniques, ISBN 0-471-16240-X, section 2.6).
fn standard_error(values: &[f64], total: usize) -> f64 {
    let n = values.len() as f64;
    let mean = stats::mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    let rest = 1.0 - n / total as f64;
    (squares / (n - 1.0).max(1.0) / n * rest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_double_and_fewer_go_on() {
        let mut counts = vec![12];
        while counts[counts.len() - 1] < 240 {
            counts.push(next_count(counts[counts.len() - 1], 240));
        }
        assert_eq!(counts, [12, 24, 48, 96, 192, 240]);
        let going = counts[1..].iter().map(|&count| most_going_on(4, 12, count));
        assert_eq!(going.collect::<Vec<_>>(), [64, 32, 16, 8, 6]);
        assert_eq!(most_going_on(1, 12, 240), FEWEST);
    }

    /// Behind by a little that scatters, an assignment may win; behind always, or on all patterns, it
    /// may not.
    #[test]
    fn under_the_mean_a_paired_test_decides() {
        let leader = [5.0, 6.0, 7.0, 8.0];
        let scattered = [6.0, 5.0, 7.5, 7.0];
        let behind = [4.0, 5.1, 5.9, 7.0];
        let may = |values: &[f64], patterns| may_win(Risk::Mean, values, &leader, None, patterns);
        assert!(may(&scattered, 40) && may(&leader, 40) && !may(&behind, 40));
        // All patterns are known: the lower mean cannot win, an equal one can.
        assert!(!may(&scattered, 4) && may(&leader, 4));
    }

    /// The worst of all patterns are no better than the worst of some.
    #[test]
    fn under_the_worst_patterns_only_what_cannot_win_is_dropped() {
        let values = [3.0, 1.0, 2.0, 4.0];
        for (risk, patterns, beaten, may) in [
            (Risk::Worst, 40, 0.9, true),
            (Risk::Worst, 40, 1.0, false),
            // The worst two of ten are at most 1.5 on average, the worst four at most 2.5.
            (Risk::Cvar(0.2), 10, 1.4, true),
            (Risk::Cvar(0.2), 10, 1.5, false),
            (Risk::Cvar(0.4), 10, 2.4, true),
            (Risk::Cvar(0.4), 10, 2.5, false),
            // Of the worst eight only four are known.
            (Risk::Cvar(0.8), 10, 9.0, true),
        ] {
            let found = may_win(risk, &values, &values, Some(beaten), patterns);
            assert_eq!(found, may, "{risk} {patterns} {beaten}");
            assert!(may_win(risk, &values, &values, None, patterns));
        }
    }
}
