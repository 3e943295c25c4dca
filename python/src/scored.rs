//! The patterns that a study scores on.

use pickline::Result;
use pickline::pattern::Attributes;
use pickline::study::ScoredPatterns;

/// The patterns of the source `text` with `items` items in each, a feed of `flow` [1/min], and items with
/// these areas, probabilities of detection and of grasps, and classes.
pub(crate) fn patterns_of(
    text: &str,
    items: Option<usize>,
    flow: Option<f64>,
    attributes: [Option<&str>; 4],
) -> Result<ScoredPatterns> {
    let [area, p_detection, p_grasp, classes] = attributes;
    let attributes = Attributes::named(area, p_detection, p_grasp, classes)?;
    let mut patterns: ScoredPatterns = text.parse()?;
    if let Some(flow) = flow {
        patterns = patterns.with_flow(flow)?;
    }
    if let Some(items) = items {
        patterns = patterns.with_items(items);
    }
    Ok(patterns.with_attributes(attributes))
}
