//! Meeting point, processing time and departure window of one robot and one item: the exact
//! geometry on which everything else is built.
//!
//! Frame and symbols are those of `docs/model.md`: the belt moves along +x at `v` [m/s], the end
//! effector at `u > v` [m/s]; positions are in the belt frame [m]. Source of the extended workspace
//! and the meeting point: Jermann et al., "An Efficient Multi-Robot Arm Coordination Strategy for
//! Pick-and-Place Tasks using Reinforcement Learning". The closed forms follow from equating the
//! travel times. Arms that accelerate, lift, or follow a measured table are in [`Arm`] and
//! [`TravelLaw`].

mod arm;
mod law;

pub use arm::{Arm, Encounter};
pub use law::TravelLaw;

/// Time [s] that an end effector needs to travel from its bin to an item that moves with the belt.
///
/// (`dx`, `dy`) [m] is the vector from the bin to the item at departure. The result is the positive
/// root of `|d + (v tau, 0)| = u tau`, which exists for every `d` because `u > v`.
#[inline(always)]
pub fn travel_time(dx: f64, dy: f64, belt_speed: f64, arm_speed: f64) -> f64 {
    let k = arm_speed * arm_speed - belt_speed * belt_speed;
    let vdx = belt_speed * dx;
    (vdx + (vdx * vdx + k * (dx * dx + dy * dy)).sqrt()) / k
}

/// Total time [s] of a pick: out, grasp, back along the same line, release.
#[inline(always)]
pub(crate) fn processing_time(travel: f64, grasp_time: f64, release_time: f64) -> f64 {
    2.0 * travel + grasp_time + release_time
}

/// Length [m] of the vector (`dx`, `dy`) [m].
#[inline(always)]
pub fn distance(dx: f64, dy: f64) -> f64 {
    (dx * dx + dy * dy).sqrt()
}

/// The range of x [m] in which a robot can meet an item that travels along the line `y`: within
/// `reach` of the base at (`base_x`, `base_y`) and on the belt, `0 <= x <= belt_length`. `None` if
/// the line is out of reach.
pub fn meeting_range(
    base_x: f64,
    base_y: f64,
    reach: f64,
    y: f64,
    belt_length: f64,
) -> Option<(f64, f64)> {
    let dy = y - base_y;
    let square = reach * reach - dy * dy;
    if square < 0.0 {
        return None;
    }
    let half_chord = square.sqrt();
    let x_in = (base_x - half_chord).max(0.0);
    let x_out = (base_x + half_chord).min(belt_length);
    (x_in <= x_out).then_some((x_in, x_out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meeting_an_item_straight_across() {
        // 3-4-5: the item is 0.4 m across; the arm covers 0.5 m while the belt covers 0.3 m.
        let tau = travel_time(0.0, 0.4, 0.3, 0.5);
        assert!((tau - 1.0).abs() < 1e-15, "{tau}");
    }

    #[test]
    fn travel_time_solves_its_equation() {
        for (dx, dy) in [(-1.0, 0.3), (0.7, -0.2), (0.0, 0.0), (1e-9, 1e-9)] {
            let (v, u) = (0.05, 0.5);
            let tau = travel_time(dx, dy, v, u);
            assert!(tau >= 0.0);
            let gap = distance(dx + v * tau, dy) - u * tau;
            assert!(gap.abs() < 1e-15, "({dx}, {dy}): {gap}");
        }
    }

    #[test]
    fn range_is_clipped_to_the_belt_and_empty_out_of_reach() {
        assert_eq!(meeting_range(0.5, 0.0, 1.0, 0.0, 1.2), Some((0.0, 1.2)));
        assert_eq!(meeting_range(0.5, 0.0, 1.0, 1.1, 1.2), None);
        assert_eq!(meeting_range(3.0, 0.0, 1.0, 0.0, 1.5), None);
        // Touching the circle at one point still counts: both ends are included.
        assert_eq!(meeting_range(2.0, 0.0, 1.0, 1.0, 3.0), Some((2.0, 2.0)));
    }
}
