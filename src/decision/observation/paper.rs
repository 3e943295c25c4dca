//! The observation of the paper (Jermann et al., section on actions, observations and rewards).
//! Units are m and s, so that all numbers are of the order of 1.

use crate::decision::snapshot::Snapshot;

/// Number of robots that are represented; further robots of a longer line are not visible.
pub(super) const ROBOTS: usize = 6;
/// The longest time until free [s] that is represented: a robot that waits forever is equivalent to
/// one that is busy for a very long time.
pub(super) const LONGEST: f64 = 1e3;
/// Busy and time until free [s] of every robot, upstream first.
pub(super) const GLOBALS: usize = 2 * ROBOTS;
/// x and y relative to the robot's base [m], processing time [s], reward.
pub(super) const FEATURES: usize = 4;

/// Fills `globals`, and `slots` with the features of the chosen candidates.
pub(super) fn encode(
    snapshot: &Snapshot,
    chosen: &[usize],
    globals: &mut [f32],
    slots: &mut [f32],
) {
    globals.fill(0.0);
    let robots = snapshot.free_at.len().min(ROBOTS);
    for (index, pair) in globals.chunks_exact_mut(2).enumerate().take(robots) {
        let time = snapshot.time_until_free(index).min(LONGEST) as f32;
        pair[0] = f32::from(u8::from(time > 0.0));
        pair[1] = time;
    }
    let moment = snapshot.moment();
    for (place, slot) in chosen.iter().zip(slots.chunks_exact_mut(FEATURES)) {
        let candidate = &snapshot.candidates[*place];
        slot[0] = (moment.x(candidate) - moment.robot.base.x) as f32;
        slot[1] = (candidate.y - moment.robot.base.y) as f32;
        slot[2] = moment.processing_time(candidate) as f32;
        slot[3] = candidate.weight as f32;
    }
}
