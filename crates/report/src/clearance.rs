//! How close arms come to each other, in a run and by the station's geometry.

use super::table::fixed;
use pickline::clearance::{Apart, Clearance, MARGIN, Overlap, TOLERANCE};
use pickline::error::{shown, shown_number};
use pickline::station::Station;
use serde::Serialize;

/// The smallest distance between two arms in a run.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ClearanceReport {
    /// Distance between the arms, each the segment from base to tool point [m]; 0 if they
    /// cross.
    pub distance_m: f64,
    /// The true distance is smaller by at most this [m].
    pub tolerance_m: f64,
    /// Time at which it occurs [s].
    pub time_s: f64,
    /// Names of the two robots, upstream first.
    pub robots: [String; 2],
    /// The nearest point on each arm [m].
    pub points: [[f64; 2]; 2],
}

impl ClearanceReport {
    /// The report of `clearance` for a run on `station`.
    pub fn new(station: &Station, clearance: &Clearance) -> Self {
        Self {
            distance_m: clearance.distance,
            tolerance_m: TOLERANCE,
            time_s: clearance.time,
            robots: clearance.robots.map(|i| station.robots()[i].name.clone()),
            points: clearance.points.map(|point| [point.x, point.y]),
        }
    }

    /// The line for the terminal.
    pub(super) fn line(&self) -> String {
        let [one, other] = self.robots.each_ref().map(|name| shown(name));
        let [x, y] = self.points[0].map(|v| fixed(v, 3));
        let time = fixed(self.time_s, 2);
        if self.distance_m == 0.0 {
            return format!(
                "arms      {one} and {other} collide at {time} s at ({x}, {y}) m: strategies do \
                 not keep arms apart\n"
            );
        }
        let doubt = match self.distance_m < MARGIN {
            true => format!(
                ", less than {} m: arms have a thickness",
                shown_number(MARGIN)
            ),
            false => String::new(),
        };
        format!(
            "arms      at least {} m apart: {one} and {other} at {time} s, near ({x}, {y}) m{doubt}\n",
            fixed(self.distance_m, 3)
        )
    }
}

/// Maximum number of pairs of robots to list; the others are only counted.
const MOST_PAIRS: usize = 12;

/// Lines about which arms of `station` can touch: what is fine, and a warning for each pair
/// that is not.
pub fn arms_apart(station: &Station, apart: &Apart) -> (String, Vec<String>) {
    let name = |robot: usize| shown(&station.robots()[robot].name);
    let fine = apart.others.filter(|_| apart.overlaps.is_empty());
    let fine = fine.map_or(String::new(), |(distance, [one, other])| {
        format!(
            "arms      always at least {} m apart ({} and {} come closest)\n",
            fixed(distance, 3),
            name(one),
            name(other)
        )
    });
    let overlaps = apart.overlaps.iter().take(MOST_PAIRS);
    let overlaps = overlaps.map(|overlap| overlap_warning(overlap, overlap.robots.map(name)));
    let mut warnings: Vec<String> = overlaps.collect();
    let near = apart.near.iter().take(MOST_PAIRS).map(|(distance, pair)| {
        let [one, other] = pair.map(name);
        format!(
            "the arms of {one} and {other} can come as close as {} m, less than {} m: arms have a \
             thickness",
            fixed(*distance, 3),
            shown_number(MARGIN)
        )
    });
    let near: Vec<String> = near.collect();
    let more = apart.overlaps.len().saturating_sub(MOST_PAIRS);
    if more > 0 {
        warnings.push(format!(
            "the arms of {more} more pairs of robots can collide"
        ));
    }
    warnings.extend(near);
    let more = apart.near.len().saturating_sub(MOST_PAIRS);
    if more > 0 {
        warnings.push(format!(
            "the arms of {more} more pairs of robots can come that close"
        ));
    }
    (fine, warnings)
}

/// The warning about two arms, named, that can collide.
fn overlap_warning(overlap: &Overlap, [one, other]: [String; 2]) -> String {
    let span = |[low, high]: [f64; 2]| format!("x = {} to {} m", fixed(low, 3), fixed(high, 3));
    let shared = match overlap.workspaces {
        Some(shared) => format!(
            "their workspaces share {} m^2 of the belt, {}",
            fixed(shared.area, 3),
            span(shared.x)
        ),
        None => format!(
            "their paths to the bins intersect, {}",
            span(overlap.swept.x)
        ),
    };
    let rest = match overlap.at_rest {
        0.0 => "they cross".to_owned(),
        distance => format!("they are {} m apart", fixed(distance, 3)),
    };
    format!("the arms of {one} and {other} can collide: {shared}; at rest {rest}")
}
