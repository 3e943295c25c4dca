//! How finely times were recorded.
//!
//! A clock of 0.1 s makes many times equal that are not. Residuals then understate what is not known,
//! so whatever is estimated from such times takes the step of the clock into account.

use super::timed_move::TimedMove;

/// Steps [s] of clocks, control cycles and cameras, the coarsest first.
const STEPS: [f64; 21] = [
    1.0,
    0.5,
    0.25,
    0.2,
    0.1,
    0.05,
    0.04,
    1.0 / 30.0,
    0.02,
    1.0 / 60.0,
    0.016,
    0.012,
    0.01,
    0.008,
    0.005,
    0.004,
    0.002,
    0.001,
    0.0005,
    0.0002,
    0.0001,
];
/// By how much a stamp may miss a multiple of the step [s]: more than the last digit of the seconds
/// since 1970, less than any step.
const SLACK: f64 = 1e-6;

/// The coarsest step [s] of which all stamps of the moves are whole multiples, up to one shift that
/// they share; `None` if there is none, or not two different stamps.
pub(super) fn step_of(moves: &[TimedMove]) -> Option<f64> {
    let stamps: Vec<f64> = moves.iter().flat_map(stamps).collect();
    let first = *stamps.first()?;
    if stamps.iter().all(|stamp| *stamp == first) {
        return None;
    }
    let is_multiple = |stamp: f64, step: f64| {
        let count = ((stamp - first) / step).round();
        (stamp - first - count * step).abs() <= SLACK
    };
    let mut steps = STEPS.into_iter();
    steps.find(|step| stamps.iter().all(|stamp| is_multiple(*stamp, *step)))
}

/// The stamps of a move. When an arm that chases an item leaves is planned by the node, not read from
/// the clock of the robot.
fn stamps(timed: &TimedMove) -> impl Iterator<Item = f64> + use<> {
    let depart = timed.depart.filter(|_| timed.chased.is_none());
    [depart, timed.grasp, timed.release, timed.failed]
        .into_iter()
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    fn moves(round: impl Fn(f64) -> f64) -> Vec<TimedMove> {
        let at = Point2::new(0.0, 0.0);
        let timed = |i: u32| {
            let depart = 1.7e9 + 1.37 * f64::from(i) + 0.1 * f64::from(i).sin();
            let mut timed = TimedMove::new(0, 1, at, at);
            timed.depart = Some(round(depart));
            timed.grasp = Some(round(depart + 0.2 + 0.1 * f64::from(i).cos()));
            timed
        };
        (0..40).map(timed).collect()
    }

    #[test]
    fn the_coarsest_step_of_all_stamps_is_found() {
        for step in [0.1, 0.01, 0.001, 0.004, 1.0 / 30.0] {
            let found = step_of(&moves(|stamp| (stamp / step).round() * step));
            assert_eq!(found, Some(step));
            // A clock that started at any time has the same step.
            let shifted = step_of(&moves(|stamp| (stamp / step).round() * step + 0.000_37));
            assert_eq!(shifted, Some(step));
        }
        assert_eq!(step_of(&moves(|stamp| stamp)), None);
        assert_eq!(step_of(&moves(|_| 3.0)), None);
        let mut odd = moves(|stamp| (10.0 * stamp).round() / 10.0);
        odd[20].grasp = Some(odd[20].grasp.unwrap() + 0.03);
        assert_eq!(step_of(&odd), Some(0.01));
        assert_eq!(step_of(&[]), None);
    }
}
