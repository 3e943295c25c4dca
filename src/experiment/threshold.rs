//! The threshold of detections with the highest recovery at a wanted purity.

use super::sweep_result::{Sweep, SweptMethod};
use crate::purity::Purity;

/// The thresholds of all methods for a wanted purity.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ThresholdChoices {
    /// The wanted purity.
    pub purity: f64,
    /// Description of the patterns that the thresholds were chosen on.
    pub trained_on: String,
    /// The methods, in the order of the sweep.
    pub methods: Vec<ThresholdChoice>,
}

/// The threshold of one method.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ThresholdChoice {
    /// The method's name in files.
    pub method: String,
    /// What was chosen; `None` if no threshold reaches the wanted purity on the training patterns.
    pub chosen: Option<ChosenThreshold>,
    /// The threshold with the highest purity on the training patterns, and that purity; `None` if
    /// nothing was binned at any threshold.
    pub purest: Option<(f64, f64)>,
}

/// A threshold that was chosen on training patterns, and what it gives on fresh ones.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ChosenThreshold {
    /// Items with a lower `p_detection` are left on the belt.
    pub value: f64,
    /// Purity and recovery on the training patterns.
    pub trained: Purity,
    /// Purity and recovery on the fresh patterns.
    pub fresh: Purity,
}

/// Chooses for each method the value of the sweep `training` with the highest recovery among those
/// with at least `purity`, on a tie the lowest. `fresh` is the same sweep of other patterns.
pub fn choose_thresholds(
    purity: f64,
    trained_on: String,
    training: &Sweep,
    fresh: &Sweep,
) -> ThresholdChoices {
    let methods = training.methods().zip(fresh.methods());
    let methods = methods.map(|(trained, fresh)| ThresholdChoice {
        method: fresh.name().to_owned(),
        chosen: choose(purity, &trained, &fresh),
        purest: purest(&trained),
    });
    ThresholdChoices {
        purity,
        trained_on,
        methods: methods.collect(),
    }
}

/// The values of a sweep with the purity and recovery at each, if known.
fn purities<'s>(method: &SweptMethod<'s>) -> impl Iterator<Item = (f64, &'s Purity)> + use<'s> {
    let points = method.points().collect::<Vec<_>>().into_iter();
    points.filter_map(|(value, point)| Some((value, &point.purity.as_ref()?.total)))
}

fn choose(purity: f64, trained: &SweptMethod, fresh: &SweptMethod) -> Option<ChosenThreshold> {
    let mut best: Option<(f64, &Purity)> = None;
    for (value, found) in purities(trained) {
        let reaches = found.purity().is_some_and(|found| found >= purity);
        if reaches && best.is_none_or(|(_, other)| found.recovery() > other.recovery()) {
            best = Some((value, found));
        }
    }
    let (value, trained) = best?;
    let (_, fresh) = purities(fresh).find(|(other, _)| *other == value)?;
    Some(ChosenThreshold {
        value,
        trained: *trained,
        fresh: *fresh,
    })
}

fn purest(trained: &SweptMethod) -> Option<(f64, f64)> {
    let found = purities(trained).filter_map(|(value, found)| Some((value, found.purity()?)));
    found.reduce(|best, next| if next.1 > best.1 { next } else { best })
}
