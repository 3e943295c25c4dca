//! The settings of a sweep.

use super::options::{MethodSettings, StudyOptions};
use super::patterns::ScoredPatterns;
use super::robust::{RobustTraining, training_patterns};
use super::values::ValueOptions;
use crate::error::{Error, Result, shown_number};
use crate::experiment::Axis;
use crate::pattern::{PatternSet, PatternSource};
use crate::sim::Conditions;
use crate::station::Station;
use std::sync::Arc;

/// Spacing [m] and number of items of the default pattern, a grid.
pub const DEFAULT_GRID: (f64, usize) = (0.15, 50);

/// The settings of a sweep. By default the belt speed is varied around the line's limit, on the
/// grid of 0.15 m, with robust GT (game theory) and the bound.
pub type SweepOptions = StudyOptions<SweepSettings>;

/// What only the settings of a sweep have.
#[derive(Clone)]
pub struct SweepSettings {
    pub(super) methods: MethodSettings,
    pub(super) values: ValueOptions,
    pub(super) patterns: ScoredPatterns,
    pub(super) purity: Option<f64>,
    pub(super) threshold_patterns: Option<PatternSet>,
}

impl Default for SweepSettings {
    fn default() -> Self {
        Self {
            methods: MethodSettings::default(),
            values: ValueOptions::default(),
            patterns: PatternSource::Grid(DEFAULT_GRID.0).into(),
            purity: None,
            threshold_patterns: None,
        }
    }
}

impl AsMut<MethodSettings> for SweepSettings {
    fn as_mut(&mut self) -> &mut MethodSettings {
        &mut self.methods
    }
}

impl SweepOptions {
    /// With this quantity varied.
    #[must_use]
    pub fn with_axis(mut self, axis: Axis) -> Self {
        self.own.values.axis = axis;
        self
    }

    /// With this first value, instead of one below the line's limit.
    #[must_use]
    pub fn with_from(mut self, from: f64) -> Self {
        self.own.values.from = Some(from);
        self
    }

    /// With this last value, instead of one above the line's limit.
    #[must_use]
    pub fn with_to(mut self, to: f64) -> Self {
        self.own.values.to = Some(to);
        self
    }

    /// With this step between values, instead of a round one that gives up to thirty values.
    #[must_use]
    pub fn with_step(mut self, step: f64) -> Self {
        self.own.values.step = Some(step);
        self
    }

    /// With the line of a given number of robots, which a sweep of the robots needs: a station
    /// does not know where another robot would stand.
    #[must_use]
    pub fn with_robots(
        mut self,
        line: impl Fn(usize) -> Result<Station> + Send + Sync + 'static,
    ) -> Self {
        self.own.values.of_robots = Some(Arc::new(line));
        self
    }

    /// With these patterns at every value.
    #[must_use]
    pub fn with_patterns(mut self, patterns: ScoredPatterns) -> Self {
        self.own.patterns = patterns;
        self
    }

    /// With the threshold of detections that has the highest recovery at this purity, or a higher
    /// one, for each method. It is chosen on training patterns, by default like those that are
    /// scored. Only for a sweep of that threshold.
    #[must_use]
    pub fn with_purity(mut self, purity: f64) -> Self {
        self.own.purity = Some(purity);
        self
    }

    /// With that threshold chosen on these patterns, instead of on those of robust GT (game theory)
    /// or on patterns like those that are scored.
    #[must_use]
    pub fn with_threshold_patterns(mut self, patterns: PatternSet) -> Self {
        self.own.threshold_patterns = Some(patterns);
        self
    }

    /// With robust GT (game theory) found as users name it; see [`RobustTraining::named`]. With a purity,
    /// which has to be set before, rules and a training set may both be named: the set is then for the
    /// threshold.
    ///
    /// # Errors
    /// As for [`RobustTraining::named`].
    pub fn with_named_training(
        self,
        robust: Option<&str>,
        set: Option<&str>,
        items: Option<usize>,
        (station, seed): (&Station, u64),
    ) -> Result<Self> {
        if let (Some(_), Some(rules), Some(set)) = (self.own.purity, robust, set) {
            let set = training_patterns(set, items, (station, seed))?;
            let training = RobustTraining::given(rules)?;
            return Ok(self.with_training(training).with_threshold_patterns(set));
        }
        let training = RobustTraining::named(robust, set, items, false, (station, seed))?;
        Ok(self.with_training(training))
    }

    /// The patterns that are named to choose the threshold of detections on.
    pub(super) fn threshold_patterns(&self) -> Option<&PatternSet> {
        match (&self.own.threshold_patterns, &self.own.methods.training) {
            (Some(set), _) | (None, RobustTraining::On(set)) => Some(set),
            _ => None,
        }
    }

    /// The conditions, in which detections may be wrong if their threshold is varied.
    ///
    /// # Errors
    /// Invalid conditions, or settings that do not fit the varied quantity.
    pub(super) fn checked_conditions(&self) -> Result<Conditions> {
        let mut conditions = self.conditions.with_seed(self.seed);
        conditions.check()?;
        let is_varied = self.own.values.axis == Axis::MinDetection;
        if let Some(purity) = self.own.purity {
            if !is_varied {
                return Err(Error::usage(
                    "'purity'",
                    "applies only to a sweep of the threshold of detections",
                    "leave it out, or choose 'sweep_axis' min-detection",
                ));
            }
            if !(purity > 0.0 && purity <= 1.0) {
                return Err(Error::usage(
                    "'purity'",
                    format!("{} is not a purity", shown_number(purity)),
                    "give the share of what is binned that belongs there, above 0 and at most 1, \
                     such as 0.98",
                ));
            }
        }
        if is_varied && conditions.min_detection > 0.0 {
            return Err(Error::usage(
                "'min_detection'",
                "is the quantity that the sweep varies",
                "leave it out, or vary another quantity",
            ));
        }
        conditions.disturbances.misdetections |= is_varied;
        Ok(conditions)
    }
}
