//! The items that are in view.

use super::claims::Claims;
use super::scene::Scene;
use crate::decision::BeltItem;

/// The known unclaimed items on the belt. Because sightings are sorted, they lie between two
/// indices that only increase.
#[derive(Debug, Clone, Default)]
pub(super) struct ItemsInView {
    pub items: Vec<BeltItem>,
    first: usize,
    end: usize,
}

impl ItemsInView {
    /// Returns to time 0.
    pub(super) fn reset(&mut self) {
        self.items.clear();
        self.first = 0;
        self.end = 0;
    }

    /// Fills `items` with what is in view at `time` [s], which must not decrease between calls.
    pub(super) fn update(&mut self, scene: &Scene, claims: &Claims, time: f64) {
        let belt = scene.station().belt();
        let seen = scene.sightings();
        let x = |index: usize| seen[index].x0 + belt.speed * time;
        while self.end < seen.len() && scene.knows(&seen[self.end], time) {
            self.end += 1;
        }
        while self.first < self.end && x(self.first) > belt.length {
            self.first += 1;
        }
        let known = &seen[self.first..self.end];
        self.items.clear();
        // A filtered iterator would not know how many there are at most.
        self.items.reserve(known.len());
        for seen in known {
            if !claims.contains(seen.item) {
                self.items.push(BeltItem {
                    item: seen.item,
                    x0: seen.x0,
                    x: seen.x0 + belt.speed * time,
                    y: seen.y,
                    weight: seen.weight,
                    class: seen.class,
                    odds: scene.odds(seen.item),
                });
            }
        }
    }
}
