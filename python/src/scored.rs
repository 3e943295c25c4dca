//! The patterns that a study scores on.

use crate::pattern::Pattern;
use pickline::pattern::{Attributes, FeedParameters, PatternSource};
use pickline::study::ScoredPatterns;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// A source of patterns as text, or patterns.
#[derive(FromPyObject)]
pub(crate) enum GivenPatterns {
    #[pyo3(transparent)]
    Source(String),
    #[pyo3(transparent)]
    Patterns(Vec<Py<Pattern>>),
}

impl GivenPatterns {
    /// Reads what the Python side makes of the argument `patterns`.
    pub(crate) fn read(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        given.extract().map_err(|_| {
            let kind = given.get_type();
            PyTypeError::new_err(format!(
                "patterns: {kind} is neither a source of patterns nor patterns\n  cure: give a text such as \
                 grid:0.15, a Pattern, or a list of them"
            ))
        })
    }
}

/// The patterns themselves.
pub(crate) fn unwrapped(patterns: &[Py<Pattern>]) -> Vec<pickline::Pattern> {
    let inner = patterns.iter().map(|pattern| &*pattern.get().inner);
    inner.cloned().collect()
}

/// The keyword arguments that describe a feed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FeedArguments {
    flow: Option<f64>,
    cluster_size: Option<f64>,
    cluster_spread: Option<f64>,
    gap_length: Option<f64>,
    gap_share: Option<f64>,
}

impl FeedArguments {
    /// Reads them from the dictionary that the Python side makes of keyword arguments.
    pub(crate) fn read(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        given.extract().map_err(|error: PyErr| {
            PyTypeError::new_err(format!(
                "feed: {}\n  cure: give flow, sizes, lengths and shares as numbers",
                error.value(given.py())
            ))
        })
    }

    /// The parameters other than the flow.
    pub(crate) fn parameters(&self) -> FeedParameters {
        FeedParameters {
            cluster_size: self.cluster_size,
            cluster_spread: self.cluster_spread,
            gap_length: self.gap_length,
            gap_share: self.gap_share,
        }
    }

    /// The flow [1/min], if it is given.
    pub(crate) fn flow(&self) -> Option<f64> {
        self.flow
    }
}

/// The patterns that are given, or those of a source with `items` items in each, of this feed, and items
/// with these areas, probabilities of detection and of grasps, and classes.
pub(crate) fn patterns_of(
    given: &GivenPatterns,
    items: Option<usize>,
    feed: &FeedArguments,
    attributes: [Option<&str>; 4],
) -> pickline::Result<ScoredPatterns> {
    let [area, p_detection, p_grasp, classes] = attributes;
    let attributes = Attributes::named(area, p_detection, p_grasp, classes)?;
    let mut patterns: ScoredPatterns = match given {
        GivenPatterns::Source(text) => text.parse()?,
        GivenPatterns::Patterns(patterns) => PatternSource::given(unwrapped(patterns))?.into(),
    };
    if let Some(flow) = feed.flow() {
        patterns = patterns.with_flow(flow)?;
    }
    if let Some(items) = items {
        patterns = patterns.with_items(items);
    }
    let patterns = patterns.with_parameters(&feed.parameters())?;
    Ok(patterns.with_attributes(attributes))
}
