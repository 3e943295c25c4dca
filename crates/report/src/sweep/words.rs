//! What a sweep says about its limits, in words.

use super::report::{BoundsReport, LimitReport, SweepReport};
use pickline::clearance::MARGIN;
use pickline::error::counted;
use pickline::experiment::AS_GOOD;

impl SweepReport {
    /// Recommended values, one sentence per method; empty in a sweep of the belt speed or of the
    /// threshold of detections, which are the user's choice. `named` gives the name of a method.
    pub(super) fn recommendations(&self, named: impl Fn(&str) -> String) -> Vec<String> {
        if self.sweep == "speed" || self.is_of_thresholds() {
            return Vec::new();
        }
        let unit = self.unit_word();
        // Values that were not run may be better.
        let values = self.points.len() / self.limits.len();
        let gaps = || {
            let points = self.points.iter().step_by(self.limits.len());
            let values: Vec<f64> = points.map(|point| point.value).collect();
            values.windows(2).any(|pair| pair[1] > pair[0] + 1.0)
        };
        let least = match self.sweep {
            "robots" => "the fewest",
            _ => "the least",
        };
        let least = match (values < self.planned, self.sweep) {
            (true, _) => format!(
                "{least} of the {values} (of {}) values that were run",
                self.planned
            ),
            (_, "robots") if gaps() => format!("{least} of the numbers that were run"),
            _ => least.to_owned(),
        };
        let line = |(j, limit): (usize, &LimitReport)| match limit.recommended {
            Some(value) => {
                let mut of_method = self.points.iter().skip(j).step_by(self.limits.len());
                let point = of_method.find(|point| point.value == value);
                let throughput = point.map_or("-".into(), |point| point.throughput.shown(1));
                let unit = unit_of(value, unit);
                let of_method = self.points.iter().skip(j).step_by(self.limits.len());
                let unjudged = of_method
                    .filter(|point| {
                        point.value < value && point.throughput.throughput_per_min.is_none()
                    })
                    .count();
                let unjudged = match unjudged {
                    0 => String::new(),
                    count => format!(
                        "; {} below it could not be judged, for lack of a steady state (see the note)",
                        counted(count, "value")
                    ),
                };
                format!(
                    "{}: {value} {unit}, {least} with at least {} % of the highest throughput; \
                     {throughput} picks/min{unjudged}",
                    named(&limit.method),
                    100.0 * AS_GOOD
                )
            }
            None if !self.is_steady() => format!(
                "{}: nothing, because there is no throughput (see the note)",
                named(&limit.method)
            ),
            None => format!(
                "{}: nothing, because arms can come too close at every value",
                named(&limit.method)
            ),
        };
        self.limits.iter().enumerate().map(line).collect()
    }

    /// The values at which arms can meet, in words.
    pub(super) fn avoided(&self) -> Option<String> {
        let meet = &self.arms_can_meet;
        let (first, last) = (meet.first()?, meet.last()?);
        let range = match meet.len() {
            1 => first.to_string(),
            count => format!("{first} to {last} ({count} values)"),
        };
        let unit = self.unit_word();
        // Neither the belt's speed nor a threshold moves an arm.
        let moves = self.sweep != "speed" && !self.is_of_thresholds();
        let words = format!("{range} {unit}: arms can meet, or come closer than {MARGIN} m");
        moves.then_some(words)
    }
}

impl BoundsReport {
    /// What is proven about the limits, in words; `helps`: larger values make picking easier.
    pub(super) fn words(&self, helps: bool, unit: &str) -> String {
        let nearest = if helps {
            self.impossible.last()
        } else {
            self.impossible.first()
        };
        let Some(nearest) = nearest else {
            return "that some strategy picks everything is refuted at no value of this sweep"
                .into();
        };
        let (side, beyond) = match helps {
            true => (
                "below",
                self.points.iter().filter(|p| p.value <= *nearest).count(),
            ),
            false => (
                "above",
                self.points.iter().filter(|p| p.value >= *nearest).count(),
            ),
        };
        let further = match (beyond, beyond == self.impossible.len()) {
            (1, _) => String::new(),
            (_, true) => format!(" or at any value {side} it"),
            (_, false) => format!(
                ", nor at {} of the values {side} it",
                self.impossible.len() - 1
            ),
        };
        let unit = unit_of(*nearest, unit);
        format!("no strategy picks everything at {nearest} {unit}{further}; that is proven")
    }
}

/// `unit` in the singular or plural, as `value` requires.
fn unit_of(value: f64, unit: &str) -> &str {
    match unit {
        "robots" if value == 1.0 => "robot",
        unit => unit,
    }
}
