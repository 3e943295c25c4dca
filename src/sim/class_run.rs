//! What a run picked of each class.

use super::scene::Scene;
use crate::decision::Outcome;
use std::collections::BTreeMap;

/// The items of one class in one run.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct ClassRun {
    /// Name of the class; `None` for the items without one.
    pub class: Option<String>,
    /// Whether the class is wanted and some robot has a bin for it.
    pub wanted: bool,
    /// Number of items of this class in the pattern.
    pub items: usize,
    /// How many of them were picked.
    pub picked: usize,
}

impl ClassRun {
    /// The share of the items that was picked; `None` if they are not to be picked.
    pub fn recovery(&self) -> Option<f64> {
        self.wanted
            .then(|| self.picked as f64 / self.items.max(1) as f64)
    }
}

/// The items of each class of the pattern in the run `outcome` on `scene`, those without a class
/// first, then by name. Empty on a station where neither bins nor values depend on the class.
pub fn class_runs(scene: &Scene, outcome: &Outcome) -> Vec<ClassRun> {
    let (station, items) = (scene.station(), scene.pattern().items());
    if station.class_names().is_empty() {
        return Vec::new();
    }
    let mut counts: BTreeMap<Option<&str>, (usize, usize)> = BTreeMap::new();
    for item in items {
        counts.entry(item.class.as_deref()).or_default().0 += 1;
    }
    for pick in &outcome.picks {
        let class = items[pick.item as usize].class.as_deref();
        counts.entry(class).or_default().1 += 1;
    }
    let run = |(class, (items, picked)): (Option<&str>, (usize, usize))| ClassRun {
        class: class.map(str::to_owned),
        wanted: station.takes(station.class_id(class)),
        items,
        picked,
    };
    counts.into_iter().map(run).collect()
}
