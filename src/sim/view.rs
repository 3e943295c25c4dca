//! Which items are in view.

use super::claims::Claims;
use super::scene::Scene;
use crate::decision::BeltItem;

/// The unclaimed items on the belt. As patterns are sorted, they lie between two
/// indices that only grow.
#[derive(Debug, Clone, Default)]
pub(super) struct View {
    pub items: Vec<BeltItem>,
    first: usize,
    end: usize,
}

impl View {
    /// Back to time 0.
    pub fn reset(&mut self) {
        self.items.clear();
        self.first = 0;
        self.end = 0;
    }

    /// Fills `items` with what is in view at `time` [s], no earlier than last time.
    pub fn update(&mut self, scene: &Scene, claims: &Claims, time: f64) {
        let belt = scene.station().belt();
        let items = scene.pattern().items();
        let x = |index: usize| items[index].x0 + belt.speed * time;
        while self.end < items.len() && x(self.end) >= 0.0 {
            self.end += 1;
        }
        while self.first < self.end && x(self.first) > belt.length {
            self.first += 1;
        }
        self.items.clear();
        let unclaimed = (self.first..self.end).filter(|&i| !claims.contains(i as u32));
        self.items.extend(unclaimed.map(|i| BeltItem {
            item: i as u32,
            x0: items[i].x0,
            x: x(i),
            y: items[i].y,
            weight: items[i].reward(),
        }));
    }
}
