//! An arm: its travel-time law and its lift, and where it meets an item that moves.

use super::law::{TravelLaw, trapezoid_time};
use super::{distance, travel_time};

/// Steps after which the search for a meeting point ends. Newton's method takes three to five; a
/// bisection to the last bit takes about sixty.
const MOST_STEPS: usize = 200;

/// How an arm moves: up by the lift, along the belt's plane, down again.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// Time for the length of the path.
    pub law: TravelLaw,
    /// Height h [m] by which the arm rises before it travels and sinks afterwards.
    pub lift: f64,
}

/// An item on the way of an arm that leaves now.
#[derive(Debug, Clone, Copy)]
pub struct Encounter {
    /// From the arm's place to the item at departure, along the belt [m].
    pub dx: f64,
    /// The same across the belt [m].
    pub dy: f64,
    /// Speed of the belt [m/s].
    pub belt_speed: f64,
    /// Belt upstream of the item at departure, as a negative number: the meeting point is on the
    /// belt, so its distance from the item is in `upstream..=downstream` [m].
    pub upstream: f64,
    /// Belt downstream of the item at departure [m].
    pub downstream: f64,
}

impl Arm {
    /// The paper's arm: always at this speed [m/s], without lift.
    pub fn constant(speed: f64) -> Self {
        Self {
            law: TravelLaw::Constant { speed },
            lift: 0.0,
        }
    }

    /// The speed [m/s] of the paper's arm; `None` for an arm that accelerates, lifts, or follows a
    /// table.
    #[inline(always)]
    pub fn constant_speed(&self) -> Option<f64> {
        match self.law {
            TravelLaw::Constant { speed } if self.lift == 0.0 => Some(speed),
            _ => None,
        }
    }

    /// Time [s] for a move between two points this far apart in the plane [m].
    #[inline(always)]
    pub fn time(&self, distance: f64) -> f64 {
        let length = distance + 2.0 * self.lift;
        // The other laws are too long to be inlined wherever an arm moves.
        match self.law {
            TravelLaw::Constant { speed } => length / speed,
            _ => self.law.time(length),
        }
    }

    /// The share of the way of `distance` [m] in the plane that the arm has covered `elapsed` [s] after
    /// its start, of a move that takes `whole` [s]: none while it is lifted and all while it is
    /// lowered. An arm with a measured table is taken to move along its path uniformly.
    pub fn progress(&self, distance: f64, elapsed: f64, whole: f64) -> f64 {
        if elapsed >= whole || distance <= 0.0 {
            return 1.0;
        }
        let length = distance + 2.0 * self.lift;
        let covered = match self.law {
            TravelLaw::Constant { .. } | TravelLaw::Table(_) => length * elapsed / whole,
            TravelLaw::Trapezoid {
                speed,
                acceleration,
                deceleration,
            } => {
                let peak = speed.min((2.0 * length / self.law.ramp()).sqrt());
                let (up, down) = (peak / acceleration, peak / deceleration);
                let left = (whole - elapsed).max(0.0);
                if elapsed < up {
                    0.5 * acceleration * elapsed * elapsed
                } else if left < down {
                    length - 0.5 * deceleration * left * left
                } else {
                    peak * (elapsed - 0.5 * up)
                }
            }
        };
        ((covered - self.lift) / distance).clamp(0.0, 1.0)
    }

    /// Time [s] from departure until the arm meets the item: the only root of
    /// `T(|d + (v tau, 0)| + 2 h) = tau` for which the meeting point is on the belt. An item that
    /// can only be met beyond an end of the belt is met at that end.
    ///
    /// Closed forms where there are any, otherwise Newton's method inside a bracket, which ends
    /// when the step no longer changes the time or the error is a few units in the last place.
    #[inline(always)]
    pub fn travel_time(&self, item: &Encounter) -> f64 {
        match self.constant_speed() {
            Some(speed) => travel_time(item.dx, item.dy, item.belt_speed, speed),
            None => self.general_travel_time(item),
        }
    }

    /// For an arm that accelerates a time [s] that [`Arm::travel_time`] of an item at this distance [m] is
    /// not below, and a length [m] that its way is not below; `None` for other arms.
    ///
    /// The distance of a moving item is convex over time, so it is at least what its present rate of
    /// change makes of it, for which there is a closed form, and no less than across the belt.
    #[inline]
    pub(crate) fn least_travel_time(
        &self,
        dx: f64,
        dy: f64,
        belt_speed: f64,
    ) -> Option<(f64, f64)> {
        let TravelLaw::Trapezoid { speed, .. } = self.law else {
            return None;
        };
        let c = self.law.ramp();
        let now = distance(dx, dy);
        let rate = if now > 0.0 {
            belt_speed * dx / now
        } else {
            belt_speed
        };
        let length = now + 2.0 * self.lift;
        let threshold = speed * speed * c / 2.0;
        // The root of `T(length + rate tau) = tau`, at top speed or in the ramps.
        let cruising = (length + threshold) / (speed - rate);
        let tau = match length + rate * cruising >= threshold {
            true => cruising,
            false => {
                let recedes = c * rate;
                recedes + (recedes * recedes + 2.0 * c * length).sqrt()
            }
        };
        // An item that comes nearer is met before the time for its present distance has passed.
        let until = if rate > 0.0 {
            tau
        } else {
            self.law.time(length)
        };
        Some((tau, (now + rate * until).max(dy.abs())))
    }

    /// The same from above: a time that [`Arm::travel_time`] does not exceed, and a length that its way
    /// does not exceed. T is at most what it is at top speed, `l / u + u c / 2`.
    #[inline]
    pub(crate) fn most_travel_time(&self, dx: f64, dy: f64, belt_speed: f64) -> Option<(f64, f64)> {
        let TravelLaw::Trapezoid { speed, .. } = self.law else {
            return None;
        };
        let now = distance(dx, dy);
        let length = now + 2.0 * self.lift + speed * speed * self.law.ramp() / 2.0;
        // An item that is met before it is as far downstream as it is upstream is never farther than now.
        let steady = length / speed;
        if belt_speed * steady <= -2.0 * dx {
            return Some((steady, now));
        }
        let receding = length / (speed - belt_speed);
        Some((receding, now + belt_speed * receding))
    }

    fn general_travel_time(&self, item: &Encounter) -> f64 {
        let low = (item.upstream / item.belt_speed).max(0.0);
        let high = (item.downstream / item.belt_speed).max(low);
        match &self.law {
            TravelLaw::Constant { speed } => self.cruise(item, *speed, 0.0),
            TravelLaw::Trapezoid { speed, .. } => {
                let c = self.law.ramp();
                if !self.is_met_in_ramps(item, (*speed, c)) {
                    let tau = self.cruise(item, *speed, speed * c / 2.0);
                    if tau >= speed * c && tau >= low && tau <= high {
                        return tau;
                    }
                }
                self.ramp(item, (*speed, c), (low, high))
            }
            TravelLaw::Table(_) => self.search(item, (low, high)),
        }
    }

    /// The root at top speed `speed`, for a law `l / u + offset`. With `a = 2 h / u + offset` the arm
    /// behaves like the paper's that leaves `a` later: `|d + v a + v s| = u s`, `tau = a + s`.
    fn cruise(&self, item: &Encounter, speed: f64, offset: f64) -> f64 {
        let a = 2.0 * self.lift / speed + offset;
        let v = item.belt_speed;
        a + travel_time(item.dx + v * a, item.dy, v, speed)
    }

    /// Whether a trapezoidal profile meets the item before it reaches its top speed: when it would, the
    /// path that the arm has covered reaches the item. Without a square root.
    #[inline]
    fn is_met_in_ramps(&self, item: &Encounter, (speed, c): (f64, f64)) -> bool {
        let covered = speed * speed * c / 2.0 - 2.0 * self.lift;
        let along = item.dx + item.belt_speed * speed * c;
        covered > 0.0 && along * along + item.dy * item.dy < covered * covered
    }

    /// The root of a trapezoidal profile in its ramps. Instead of `T(l) = tau` it solves
    /// `l(tau) = l` with the inverse of T, which saves a square root per step.
    fn ramp(&self, item: &Encounter, (speed, c): (f64, f64), (low, high): (f64, f64)) -> f64 {
        let v = item.belt_speed;
        let (threshold, constant) = (speed * c, speed * speed * c / 2.0);
        let excess = |tau: f64| {
            let (reached, slope) = if tau <= threshold {
                (tau * tau / (2.0 * c), tau / c)
            } else {
                (speed * tau - constant, speed)
            };
            let along = item.dx + v * tau;
            let way = distance(along, item.dy);
            let length = way + 2.0 * self.lift;
            let approach = if way > 0.0 { v * along / way } else { v };
            (reached - length, slope - approach, length)
        };
        let length = distance(item.dx, item.dy) + 2.0 * self.lift;
        newton(excess, trapezoid_time(length, speed, c), (low, high))
    }

    /// The root of any law.
    fn search(&self, item: &Encounter, (low, high): (f64, f64)) -> f64 {
        let v = item.belt_speed;
        let excess = |tau: f64| {
            let along = item.dx + v * tau;
            let way = distance(along, item.dy);
            let length = way + 2.0 * self.lift;
            let approach = if way > 0.0 { v * along / way } else { v };
            let time = self.law.time(length);
            (tau - time, 1.0 - self.law.slope(length) * approach, tau)
        };
        let start = self.time(distance(item.dx, item.dy));
        newton(excess, start, (low, high))
    }

    /// Time [s] at which the arm must leave the place (`from_x`, `from_y`) to meet, at `meet_x`, the
    /// item that was at (`x0`, `y`) at time 0 [m].
    ///
    /// It increases with `meet_x` along the belt because the arm is faster than the belt.
    #[inline]
    pub fn departure_time(
        &self,
        meet_x: f64,
        (x0, y): (f64, f64),
        (from_x, from_y): (f64, f64),
        belt_speed: f64,
    ) -> f64 {
        (meet_x - x0) / belt_speed - self.time(distance(meet_x - from_x, y - from_y))
    }
}

/// The root in `[low, high]` of a function that increases there; the nearer end if there is none.
/// `excess` returns value, slope, and the size of the terms of which the value is a difference.
///
/// Newton's method, with bisection where a step would leave the bracket (Press et al., Numerical
/// Recipes, 3rd ed. 2007, ISBN 978-0-521-88068-8, section 9.4).
#[inline]
fn newton(
    excess: impl Fn(f64) -> (f64, f64, f64),
    start: f64,
    (mut low, mut high): (f64, f64),
) -> f64 {
    let mut at = start.clamp(low, high);
    for _ in 0..MOST_STEPS {
        let (value, slope, size) = excess(at);
        let beyond_an_end = (value > 0.0 && at <= low) || (value < 0.0 && at >= high);
        if value.abs() <= 2.0 * f64::EPSILON * size || beyond_an_end {
            return at;
        }
        if value < 0.0 {
            low = at;
        } else {
            high = at;
        }
        let step = at - value / slope;
        let next = if step > low && step < high {
            step
        } else {
            f64::midpoint(low, high)
        };
        if next == at || next <= low || next >= high {
            return at;
        }
        at = next;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    const BELT: f64 = 0.5;

    fn arms() -> [Arm; 4] {
        let trapezoid = |speed, lift| Arm {
            law: TravelLaw::Trapezoid {
                speed,
                acceleration: 20.0,
                deceleration: 15.0,
            },
            lift,
        };
        [
            Arm {
                lift: 0.03,
                ..Arm::constant(2.0)
            },
            trapezoid(10.0, 0.02),
            trapezoid(1.0, 0.05),
            Arm {
                law: TravelLaw::Table(vec![(0.0, 0.1), (0.2, 0.2), (0.5, 0.25), (0.6, 0.25)]),
                lift: 0.0,
            },
        ]
    }

    #[test]
    fn a_departure_leads_to_its_meeting_point() {
        for arm in arms() {
            for (from, x0) in [((0.6, -0.4), -0.7), ((0.9, 0.35), -1.3)] {
                for step in 0..=40 {
                    let (meet, y) = (0.05 + 1.0 * f64::from(step) / 40.0, 0.1);
                    let t = arm.departure_time(meet, (x0, y), from, BELT);
                    let x = x0 + BELT * t;
                    let item = Encounter {
                        dx: x - from.0,
                        dy: y - from.1,
                        belt_speed: BELT,
                        upstream: -x,
                        downstream: 1.2 - x,
                    };
                    let tau = arm.travel_time(&item);
                    let met = x + BELT * tau;
                    let back = arm.departure_time(met, (x0, y), from, BELT);
                    assert!(
                        (back - t).abs() <= 1e-12 * (1.0 + t.abs()),
                        "{arm:?} {meet}"
                    );
                    assert!((met - meet).abs() < 1e-9, "{arm:?}: {met} {meet}");
                }
            }
        }
    }

    #[test]
    fn bounds_are_below_the_times_and_near_them() {
        for arm in &arms()[1..3] {
            for (dx, dy) in [
                (-0.6, 0.05),
                (-0.2, 0.3),
                (-0.02, 0.2),
                (0.0, 0.0),
                (0.1, 0.1),
                (0.4, 0.4),
            ] {
                let item = Encounter {
                    dx,
                    dy,
                    belt_speed: BELT,
                    upstream: -9.0,
                    downstream: 9.0,
                };
                let tau = arm.travel_time(&item);
                let way = distance(dx + BELT * tau, dy);
                let (least, shortest) = arm.least_travel_time(dx, dy, BELT).unwrap();
                assert!(
                    least <= tau * (1.0 + 1e-12),
                    "{arm:?} {dx} {dy}: {least} {tau}"
                );
                assert!(
                    shortest <= way + 1e-12,
                    "{arm:?} {dx} {dy}: {shortest} {way}"
                );
                let (most, longest) = arm.most_travel_time(dx, dy, BELT).unwrap();
                assert!(
                    most >= tau * (1.0 - 1e-12),
                    "{arm:?} {dx} {dy}: {most} {tau}"
                );
                assert!(longest >= way - 1e-12, "{arm:?} {dx} {dy}: {longest} {way}");
                // Nothing but the curvature of the distance is lost.
                assert!(least > 0.75 * tau, "{arm:?} {dx} {dy}: {least} {tau}");
            }
        }
        assert!(arms()[0].least_travel_time(0.1, 0.1, BELT).is_none());
        assert!(arms()[3].most_travel_time(0.1, 0.1, BELT).is_none());
    }

    #[test]
    fn a_constant_arm_without_lift_is_the_papers() {
        let arm = Arm::constant(2.0);
        let item = Encounter {
            dx: -0.3,
            dy: 0.4,
            belt_speed: BELT,
            upstream: -1.0,
            downstream: 1.0,
        };
        assert_eq!(arm.travel_time(&item), travel_time(-0.3, 0.4, BELT, 2.0));
        assert_eq!(arm.constant_speed(), Some(2.0));
        assert!(arms().iter().all(|arm| arm.constant_speed().is_none()));
    }

    #[test]
    fn what_can_only_be_met_beyond_the_belt_is_met_at_its_end() {
        let arm = &arms()[1];
        let item = Encounter {
            dx: 0.3,
            dy: 0.4,
            belt_speed: BELT,
            upstream: -1.0,
            downstream: 0.01,
        };
        assert_eq!(arm.travel_time(&item), 0.01 / BELT);
    }
}
