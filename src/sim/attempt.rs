//! The result of a robot leaving for an item.

use super::scene::Scene;
use crate::decision::{Candidate, Failure, FailureCause, Moment, Pick};
use nalgebra::Point2;

/// The pick of `candidate` by a robot that leaves at the moment `at`.
#[inline]
pub(super) fn make_pick(at: &Moment, robot: usize, candidate: &Candidate) -> Pick {
    let travel = at.travel_time(candidate);
    Pick {
        robot,
        item: candidate.item,
        bin: candidate.bin,
        decide: at.time,
        grasp: at.time + travel,
        release: at.time + at.pick_time(candidate, travel),
        meet: Point2::new(at.x(candidate) + at.belt_speed * travel, candidate.y),
    }
}

/// Like [`make_pick`], but on a scene with disturbances, where the pick may fail. `attempt` is the
/// number of the attempt at this item, from 0; `place` is where the robot leaves from.
pub(super) fn try_pick(
    scene: &Scene,
    at: &Moment,
    (robot, place): (usize, usize),
    candidate: &Candidate,
    attempt: u32,
) -> Result<Pick, Failure> {
    let disturbances = &scene.conditions().disturbances;
    let item = &scene.pattern().items()[candidate.item as usize];
    let mut truth = *candidate;
    if disturbances.position_noise > 0.0 {
        (truth.x0, truth.y) = (item.x0, item.y);
        let belt = scene.station().belt();
        let window = at.robot.departure_window(belt, place, item.x0, item.y);
        if !window.is_some_and(|(open, close)| (open..=close).contains(&at.time)) {
            // The arm goes to the reported position and finds nothing.
            return Err(Failure {
                attempt: make_pick(at, robot, candidate),
                cause: FailureCause::OutOfReach,
            });
        }
    }
    let pick = make_pick(at, robot, &truth);
    if disturbances.grasp_succeeds(candidate.item, item, attempt) {
        Ok(pick)
    } else {
        Err(Failure {
            attempt: pick,
            cause: FailureCause::Grasp,
        })
    }
}
