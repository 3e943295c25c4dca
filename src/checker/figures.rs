//! The figures of a run, from its attempts alone.

use super::physics::{left_reason, weight_of};
use crate::decision::{FailureCause, Figures, Pick};
use crate::pattern::Pattern;
use crate::station::Station;

/// The figures of a run that consists of `attempts`, by the definitions of the model. What they allow is not
/// checked: see [`violations`](super::violations). An attempt at an item that does not exist, or at one that is
/// picked already, counts for its time only.
pub fn figures(
    station: &Station,
    pattern: &Pattern,
    attempts: &[(Pick, Option<FailureCause>)],
) -> Figures {
    let belt = station.belt();
    let items = pattern.items();
    let mut is_picked = vec![false; items.len()];
    let mut weight = 0.0;
    let mut end: f64 = 0.0;
    for (pick, cause) in attempts {
        end = end.max(pick.release);
        let place = pick.item as usize;
        if let (None, Some(false)) = (cause, is_picked.get(place)) {
            is_picked[place] = true;
            weight += weight_of(station, &items[place]);
        }
    }
    let mut offered = 0;
    for (item, picked) in items.iter().zip(&is_picked) {
        if left_reason(station, item).is_none() {
            offered += 1;
            // The run is not over while an item can still be picked.
            if !picked {
                end = end.max((belt.length - item.x0) / belt.speed);
            }
        }
    }
    Figures {
        items: offered,
        picked: is_picked.iter().filter(|picked| **picked).count(),
        weight,
        end,
    }
}
