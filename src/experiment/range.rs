//! The values of a sweep: as requested, or about thirty values around the line's limits.

use super::sweep::Setting;
use crate::error::{Error, Result, shown_number};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Scene};
use rayon::prelude::*;

/// The values of a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    /// First value, in the unit of the varied quantity.
    pub from: f64,
    /// Last value, included.
    pub to: f64,
    /// Distance between two values.
    pub step: f64,
}

/// Maximum number of values in one sweep; more are treated as a typing mistake.
const MOST_VALUES: f64 = 10_000.0;

impl Range {
    /// The values, as the decimal numbers that a user would write.
    ///
    /// # Errors
    /// A range that is empty, reversed or far too fine.
    pub(crate) fn values(&self) -> Result<Vec<f64>> {
        if !(self.from > 0.0 && self.from.is_finite()) {
            return Err(Error::usage(
                "'from'",
                format!("{} is not a valid start of a sweep", self.from),
                "give a number above 0",
            ));
        }
        self.steps()
    }

    /// The same for values from 0 to 1, both included.
    ///
    /// # Errors
    /// A range that is empty, reversed, far too fine, or beyond 0 to 1.
    pub(crate) fn probabilities(&self) -> Result<Vec<f64>> {
        for (setting, value) in [("'from'", self.from), ("'to'", self.to)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::usage(
                    setting,
                    format!("{value} is not a probability"),
                    "give a number from 0 to 1",
                ));
            }
        }
        self.steps()
    }

    /// The values of a range that begins at a valid value.
    fn steps(&self) -> Result<Vec<f64>> {
        let Self { from, to, step } = *self;
        let wrong =
            |setting: &str, problem: String, cure: &str| Err(Error::usage(setting, problem, cure));
        if !(to >= from && to.is_finite()) {
            return wrong(
                "'to'",
                format!("{to} is not a valid end of a sweep from {from}"),
                &format!("give {from} or more as 'to', or a lower 'from'"),
            );
        }
        if !(step > 0.0 && step.is_finite() && (to - from) / step <= MOST_VALUES) {
            let problem = format!("{step} is not a valid step from {from} to {to}");
            let cure = format!(
                "give a number above 0, at least {}",
                shown_number(round_up((to - from) / MOST_VALUES))
            );
            return wrong("'step'", problem, &cure);
        }
        // A range that is a whole number of steps includes its end, whatever the rounding.
        let count = ((to - from) / step + 1e-9).floor() as u32;
        Ok((0..=count)
            .map(|k| ((from + f64::from(k) * step) * 1e9).round() / 1e9)
            .collect())
    }
}

/// The next larger number with one significant digit.
fn round_up(value: f64) -> f64 {
    if value <= 0.0 {
        return value;
    }
    let power = 10f64.powi(value.log10().floor() as i32);
    ((value / power - 1e-9).ceil() * power * 1e12).round() / 1e12
}

/// Maximum number of values of a sweep for which no step is given.
pub(super) const ROWS: f64 = 30.0;

/// The largest of the steps 1, 2, 5, 10, ... and their decimal fractions that is at most
/// `most`.
pub(crate) fn round_step(most: f64) -> f64 {
    // A number that is already such a step stays the same, whatever the rounding.
    let most = most * (1.0 + 1e-9);
    let decade = 10f64.powf(most.log10().floor());
    let step = [5.0, 2.0, 1.0]
        .map(|m| m * decade)
        .into_iter()
        .find(|step| *step <= most);
    decimal(step.unwrap_or(decade))
}

/// The smallest of those steps with which a sweep from `from` to `to` has at most `ROWS` rows.
pub(crate) fn step_between(from: f64, to: f64) -> f64 {
    let least = (to - from) / (ROWS - 1.0);
    if least <= 0.0 {
        return to.max(f64::MIN_POSITIVE);
    }
    let below = round_step(least);
    // The next one, unless the number is already a round step.
    let steps = [1.0, 2.0, 2.5, 5.0].map(|m| decimal(m * below));
    let fits = |step: &&f64| **step * (1.0 + 1e-9) >= least && is_round(**step);
    steps.iter().find(fits).copied().unwrap_or(below)
}

fn is_round(step: f64) -> bool {
    (round_step(step) / step - 1.0).abs() < 1e-6
}

/// `value` as the decimal number that a user would write.
fn decimal(value: f64) -> f64 {
    let digits = (11.0 - value.abs().log10().ceil()).clamp(0.0, 18.0) as usize;
    // A number that was just printed can be parsed.
    format!("{value:.digits$}").parse().unwrap_or(value)
}

impl Range {
    /// From `low` to `high` on multiples of a round step, with about `ROWS` values.
    pub(crate) fn around(low: f64, high: f64) -> Self {
        let step = step_between(low, high);
        let from = decimal((low / step).floor().max(1.0) * step);
        let to = decimal((high / step).ceil().max(1.0) * step);
        Self { from, to, step }
    }
}

/// Up to which value a method picks everything.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct ValueLimit {
    /// The highest value below the first miss; `None` if the first value misses an item.
    pub highest: Option<f64>,
    /// The first value at which an item is missed; `None` if none is.
    pub first_miss: Option<f64>,
}

/// Up to which value each method picks every item of every pattern. The values `step`,
/// `2 step`, ... up to `most` are run in order, because a line may miss an item at one speed
/// and pick everything at a higher one. Each method is run until its first miss.
///
/// # Errors
/// A line that `setting` rejects, an illegal action, or [`Interrupted`](crate::error::ErrorKind).
pub fn find_limits(
    setting: impl Fn(f64) -> Result<Setting>,
    (step, most): (f64, f64),
    patterns: &[Pattern],
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Vec<ValueLimit>> {
    let steps = (most / step + 1e-9).floor() as u64;
    environment
        .progress
        .begin("finding limits", steps, "values");
    let methods = setting(step)?.methods.len();
    let mut limits = vec![ValueLimit::default(); methods];
    for k in 1..=steps {
        let value = decimal(k as f64 * step);
        let setting = setting(value)?;
        let holds = |method: &super::Method| -> Result<bool> {
            let whole = |(place, pattern): (usize, &Pattern)| -> Result<bool> {
                if environment.stopped() {
                    return Err(Error::interrupted());
                }
                let seed = conditions.disturbances.seed.wrapping_add(place as u64);
                let scene = Scene::under(&setting.station, pattern, conditions.with_seed(seed))?;
                Ok(method.run(&scene, environment)?.figures.complete())
            };
            let all: Result<Vec<bool>> = patterns.par_iter().enumerate().map(whole).collect();
            Ok(all?.into_iter().all(|whole| whole))
        };
        for (method, limit) in setting.methods.iter().zip(&mut limits) {
            if limit.first_miss.is_none() {
                match holds(method)? {
                    true => limit.highest = Some(value),
                    false => limit.first_miss = Some(value),
                }
            }
        }
        environment.progress.advance(1);
        if limits.iter().all(|limit| limit.first_miss.is_some()) {
            break;
        }
    }
    environment.progress.end();
    Ok(limits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_decimal_and_end_at_their_end() {
        let range = |from, to, step| Range { from, to, step }.values();
        assert_eq!(
            range(0.04, 0.044, 0.001).unwrap(),
            [0.04, 0.041, 0.042, 0.043, 0.044]
        );
        assert_eq!(range(1.0, 3.0, 1.0).unwrap(), [1.0, 2.0, 3.0]);
        assert_eq!(range(1.0, 1.0, 1.0).unwrap(), [1.0]);
        for (from, to, step, flag) in [
            (0.0, 1.0, 0.1, "'from': "),
            (-1.0, 1.0, 0.1, "'from': "),
            (f64::NAN, 1.0, 0.1, "'from': "),
            (2.0, 1.0, 0.1, "'to': "),
            (1.0, f64::INFINITY, 0.1, "'to': "),
            (1.0, 2.0, 0.0, "'step': "),
            (1.0, 2.0, -0.1, "'step': "),
            (1.0, 2.0, 1e-9, "'step': "),
            (1.0, 2.0, f64::NAN, "'step': "),
        ] {
            let message = range(from, to, step).unwrap_err().to_string();
            assert!(message.starts_with(flag), "{from} {to} {step}: {message}");
        }
    }

    #[test]
    fn probabilities_are_from_0_to_1() {
        let range = |from, to, step| Range { from, to, step }.probabilities();
        assert_eq!(range(0.0, 1.0, 0.5).unwrap(), [0.0, 0.5, 1.0]);
        assert_eq!(range(0.3, 0.3, 0.1).unwrap(), [0.3]);
        for (from, to, step, flag) in [
            (-0.1, 1.0, 0.1, "'from': "),
            (f64::NAN, 1.0, 0.1, "'from': "),
            (0.5, 1.1, 0.1, "'to': "),
            (0.5, 0.4, 0.1, "'to': "),
            (0.0, 1.0, 0.0, "'step': "),
        ] {
            let message = range(from, to, step).unwrap_err().to_string();
            assert!(message.starts_with(flag), "{from} {to} {step}: {message}");
        }
    }

    #[test]
    fn steps_are_round_and_rows_about_thirty() {
        for (most, step) in [(0.0019, 0.001), (0.002, 0.002), (7.0, 5.0), (0.049, 0.02)] {
            assert_eq!(round_step(most), step, "{most}");
        }
        for (low, high) in [
            (0.02, 0.08),
            (0.8, 3.2),
            (0.0004, 0.0007),
            (0.32, 1.28),
            (1.0, 1.1),
        ] {
            let range = Range::around(low, high);
            let values = range.values().unwrap();
            assert!(
                (11..=32).contains(&values.len()),
                "{low} to {high}: {range:?}"
            );
            assert!(values[0] <= low && *values.last().unwrap() >= high * (1.0 - 1e-9));
        }
    }

    /// The smallest step of 1, 2 or 5 times a power of ten with which `from` to `to` has at
    /// most thirty values.
    fn least_step(from: f64, to: f64) -> f64 {
        let powers = (-9..9).flat_map(|power| [1.0, 2.0, 5.0].map(|m| (m, power)));
        let steps = powers.map(|(m, power)| format!("{m}e{power}").parse::<f64>().unwrap());
        let fits = |step: &f64| (to - from) / step <= 29.0 + 1e-6;
        steps.filter(fits).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_step_is_the_least_round_one_with_thirty_values() {
        for (from, to, step) in [
            (0.02, 0.08, 0.005),
            (0.0, 0.29, 0.01),
            (0.0, 0.2901, 0.02),
            (0.0, 0.58, 0.02),
            (0.0, 0.5801, 0.05),
            (0.0, 1.45, 0.05),
            (0.0, 1.451, 0.1),
            (1.0, 30.0, 1.0),
            (1.0, 31.0, 2.0),
            (0.0, 2900.0, 100.0),
            (1e-3, 1.29e-2, 5e-4),
        ] {
            assert_eq!(step_between(from, to), step, "{from} to {to}");
            assert_eq!(least_step(from, to), step, "{from} to {to}");
        }
        for place in 1..400 {
            let (from, to) = (0.01 * f64::from(place % 7), 0.017 * f64::from(place));
            if to > from {
                assert_eq!(
                    step_between(from, to),
                    least_step(from, to),
                    "{from} to {to}"
                );
            }
        }
        // A single value, whatever its size.
        assert_eq!(step_between(0.3, 0.3), 0.3);
        assert_eq!(step_between(0.3, 0.2), 0.2);
        assert_eq!(step_between(0.0, 0.0), f64::MIN_POSITIVE);
    }

    #[test]
    fn round_steps_are_decimal_numbers() {
        for (most, step) in [
            (0.05, 0.05),
            (0.1, 0.1),
            (0.099_999_999_999, 0.1),
            (0.0999, 0.05),
            (9.9, 5.0),
            (10.0, 10.0),
            (1234.0, 1000.0),
            (4999.0, 2000.0),
            (0.3, 0.2),
            (3e-7, 2e-7),
        ] {
            assert_eq!(round_step(most), step, "{most}");
        }
        for (value, expected) in [
            (0.1 + 0.2, 0.3),
            (3.0 * 0.001, 0.003),
            (1234.0, 1234.0),
            (7e-12, 7e-12),
            (5.0f64.sqrt(), 2.236_067_977_5),
            (100.0 * 5.0f64.sqrt(), 223.606_797_75),
        ] {
            assert_eq!(decimal(value), expected, "{value}");
        }
    }

    #[test]
    fn a_range_around_what_a_line_can_do_ends_on_multiples_of_its_step() {
        for (low, high, from, to, step) in [
            (0.021, 0.077, 0.02, 0.078, 0.002),
            (0.8, 3.2, 0.8, 3.2, 0.1),
            (0.84, 3.21, 0.8, 3.3, 0.1),
            // Never 0, which is not a valid belt speed.
            (0.0001, 0.05, 0.002, 0.05, 0.002),
            (1e-6, 1e-6, 1e-6, 1e-6, 1e-6),
        ] {
            let range = Range::around(low, high);
            assert_eq!(
                (range.from, range.to, range.step),
                (from, to, step),
                "{low} to {high}"
            );
        }
    }

    #[test]
    fn invalid_ranges_are_reported_with_their_flag() {
        for (from, to, step, words) in [
            (
                0.0,
                1.0,
                0.1,
                &["'from'", "0 is not a valid start", "above 0"][..],
            ),
            (
                f64::INFINITY,
                1.0,
                0.1,
                &["'from'", "inf is not a valid start"],
            ),
            (
                2.0,
                1.0,
                0.1,
                &["'to'", "1 is not a valid end", "from 2", "give 2 or more"],
            ),
            (1.0, f64::INFINITY, 0.1, &["'to'", "inf is not a valid end"]),
            (
                1.0,
                2.0,
                0.0,
                &[
                    "'step'",
                    "0 is not a valid step from 1 to 2",
                    "at least 0.0001",
                ],
            ),
            (
                1.0,
                2.0,
                f64::INFINITY,
                &["'step'", "inf is not a valid step"],
            ),
            (1.0, 2.0, 0.99e-4, &["'step'", "at least 0.0001"]),
            (1.0, 2.5, 1e-5, &["'step'", "at least 0.0002"]),
            (1.0, 1.0, 0.0, &["'step'", "at least 0"]),
            (1.0, 301.0, 0.01, &["'step'", "at least 0.03"]),
        ] {
            let message = Range { from, to, step }.values().unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
        // The maximum number of values.
        let most = Range {
            from: 1.0,
            to: 2.0,
            step: 1e-4,
        }
        .values()
        .unwrap();
        assert_eq!((most.len(), most[10_000]), (10_001, 2.0));
        // The end need not be a multiple of the step.
        assert_eq!(
            Range {
                from: 1.0,
                to: 2.0,
                step: 0.4
            }
            .values()
            .unwrap(),
            [1.0, 1.4, 1.8]
        );
    }
}
