//! The observation for real lines: the full one, and what only real lines have.
//!
//! Lengths are multiples of the reach of the deciding robot, y is mirrored, and positions are
//! relative to its base, as in [`full`](super::full), whose features come first.
//!
//! | slot | feature |
//! |---|---|
//! | 17 | probability that a grasp of the item succeeds |
//! | 18 | probability that it is what it was reported as |
//! | 19, 20 | x, y of the bin that it goes into, where the arm is then |
//!
//! | global | feature |
//! |---|---|
//! | 21, 22 | x, y of the arm |
//! | 23 | time for a move of a quarter of the reach / for the whole reach: 0.25 at constant speed |
//! | 24 | twice the lift |
//! | 25 | number of bins / 4 |
//! | 26 | y of the belt's centre line |
//! | 27 | width of the belt |
//! | 28, 29 | means of slot features 17 and 18 over the items in view; 1 if there are none |

use super::full;
use crate::decision::odds::Odds;
use crate::decision::snapshot::Snapshot;
use crate::station::Robot;
use nalgebra::Point2;

/// Number of global features.
pub(super) const GLOBALS: usize = full::GLOBALS + 9;
/// Number of features per slot.
pub(super) const FEATURES: usize = full::FEATURES + 4;

/// Fills `globals`, and `slots` with the features of the chosen candidates.
pub(super) fn encode(
    snapshot: &Snapshot,
    chosen: &[usize],
    globals: &mut [f32],
    slots: &mut [f32],
) {
    let (plain, own) = globals.split_at_mut(full::GLOBALS);
    full::encode(snapshot, chosen, plain, (slots, FEATURES));
    let robot = &snapshot.station.robots()[snapshot.robot];
    let bins = &robot.bins;
    for (place, slot) in chosen.iter().zip(slots.chunks_exact_mut(FEATURES)) {
        let slot = &mut slot[full::FEATURES..];
        let odds = snapshot.odds_of(*place);
        let bin = &bins[usize::from(snapshot.candidates[*place].bin)];
        slot[0] = odds.grasp as f32;
        slot[1] = odds.detection as f32;
        (slot[2], slot[3]) = relative(robot, bin.at);
    }
    let belt = snapshot.station.belt();
    (own[0], own[1]) = relative(robot, snapshot.moment().from);
    let quarter = robot.arm.time(0.25 * robot.reach);
    own[2] = (quarter / robot.arm.time(robot.reach).max(1e-9)) as f32;
    own[3] = (2.0 * robot.arm.lift / robot.reach) as f32;
    own[4] = bins.len() as f32 / 4.0;
    own[5] = relative(robot, Point2::origin()).1;
    own[6] = (belt.width / robot.reach) as f32;
    own[7] = mean_in_view(snapshot, |odds| odds.grasp);
    own[8] = mean_in_view(snapshot, |odds| odds.detection);
}

/// `point` relative to the base.
pub(super) fn relative(robot: &Robot, point: Point2<f64>) -> (f32, f32) {
    let away = (point - robot.base) / robot.reach;
    (away.x as f32, (full::side(robot) * away.y) as f32)
}

fn mean_in_view(snapshot: &Snapshot, of: impl Fn(&Odds) -> f64) -> f32 {
    let items = snapshot.in_view;
    if items.is_empty() {
        return 1.0;
    }
    let sum: f64 = items.iter().map(|item| of(&item.odds)).sum();
    (sum / items.len() as f64) as f32
}
