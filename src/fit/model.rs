//! The time that each part of a pick takes, as a function of the arm's parameters, with its slopes.

use crate::kinematics::{Arm, Encounter, TravelLaw, distance};

/// Index of the slowness `1 / u` [s/m] in the parameters.
pub(super) const SLOWNESS: usize = 0;
/// Index of `c = 1/a + 1/b` [s^2/m].
pub(super) const RAMP: usize = 1;
/// Index of `2 h`, the lift up and down [m].
pub(super) const LIFT: usize = 2;
/// Index of the grasp time [s].
pub(super) const GRASP: usize = 3;
/// Index of the first bin's dwell: grasp and release time together [s]. The other bins follow.
pub(super) const DWELL: usize = 4;

/// The parameters of one arm: slowness, ramp, lift, grasp time, and the dwell of each bin.
pub(super) type Parameters = Vec<f64>;

/// What a time was measured of.
#[derive(Debug, Clone, Copy)]
pub(super) enum Leg {
    /// From departure to grasp, over this distance in the plane [m].
    Out(f64),
    /// From grasp to release into the bin with this index, over this distance [m].
    Back(f64, usize),
    /// From departure to release: distances out and back [m], and the bin.
    Whole(f64, f64, usize),
    /// From departure to the end of a failed grasp, chasing an item.
    Chase(Encounter),
    /// From departure to release, chasing an item; the bin is at this place relative to where the arm
    /// left [m] and has this index.
    ChaseHome(Encounter, [f64; 2], usize),
}

impl Leg {
    /// Length of the way in the plane [m]: for a leg with two ways the longer one, for a chase the
    /// distance at departure.
    pub(super) fn reach(&self) -> f64 {
        match self {
            Self::Out(way) | Self::Back(way, _) => *way,
            Self::Whole(out, back, _) => out.max(*back),
            Self::Chase(item) | Self::ChaseHome(item, ..) => distance(item.dx, item.dy),
        }
    }

    /// The bin that the item went into.
    pub(super) fn bin(&self) -> Option<usize> {
        match self {
            Self::Back(_, bin) | Self::Whole(_, _, bin) | Self::ChaseHome(_, _, bin) => Some(*bin),
            Self::Out(_) | Self::Chase(_) => None,
        }
    }

    /// What it is called in files.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Out(_) => "out",
            Self::Back(..) => "back",
            Self::Whole(..) => "whole",
            Self::Chase(_) => "chase",
            Self::ChaseHome(..) => "chase_home",
        }
    }
}

/// One measured time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observation {
    /// Index of the row that it comes from; several may come from one.
    pub row: usize,
    pub leg: Leg,
    /// How long it took [s].
    pub time: f64,
}

/// T(l), with its slopes by slowness, ramp and length.
struct MoveTime {
    time: f64,
    by_slowness: f64,
    by_ramp: f64,
    by_length: f64,
    cruises: bool,
}

/// T of a path of this length [m]; see [`TravelLaw`].
fn move_time(parameters: &[f64], length: f64) -> MoveTime {
    let (s, c) = (parameters[SLOWNESS], parameters[RAMP]);
    // Top speed is reached from the length u^2 c / 2 on.
    if 2.0 * s * s * length >= c {
        let ramp = if s > 0.0 { c / s } else { 0.0 };
        return MoveTime {
            time: length * s + 0.5 * ramp,
            by_slowness: length - if s > 0.0 { 0.5 * ramp / s } else { 0.0 },
            by_ramp: if s > 0.0 { 0.5 / s } else { 0.0 },
            by_length: s,
            cruises: true,
        };
    }
    let time = (2.0 * length * c).sqrt();
    MoveTime {
        time,
        by_slowness: 0.0,
        by_ramp: 0.5 * time / c,
        by_length: if length > 0.0 {
            0.5 * time / length
        } else {
            0.0
        },
        cruises: false,
    }
}

/// The speed [m/s] of an arm that is not slowed down by the length of its way at all.
pub(super) const NO_LIMIT: f64 = 1e9;

/// The arm with these parameters.
pub(super) fn arm_of(parameters: &[f64]) -> Arm {
    let speed = 1.0 / parameters[SLOWNESS].max(1.0 / NO_LIMIT);
    let acceleration = 2.0 / parameters[RAMP];
    let law = match acceleration.is_finite() {
        true => TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration: acceleration,
        },
        false => TravelLaw::Constant { speed },
    };
    Arm {
        law,
        lift: 0.5 * parameters[LIFT],
    }
}

/// Adds T over `way` [m] to `time` and its slopes to `slopes`.
fn add_move(parameters: &[f64], way: f64, slopes: &mut [f64]) -> f64 {
    let part = move_time(parameters, way + parameters[LIFT]);
    slopes[SLOWNESS] += part.by_slowness;
    slopes[RAMP] += part.by_ramp;
    slopes[LIFT] += part.by_length;
    part.time
}

/// The time [s] that a leg takes; `slopes` becomes its slope by each parameter.
pub(super) fn predict(parameters: &[f64], leg: &Leg, slopes: &mut [f64]) -> f64 {
    slopes.fill(0.0);
    if let Some(bin) = leg.bin() {
        slopes[DWELL + bin] = 1.0;
    }
    let dwell = leg.bin().map_or(0.0, |bin| parameters[DWELL + bin]);
    match *leg {
        Leg::Out(way) => add_move(parameters, way, slopes),
        Leg::Back(way, _) => dwell + add_move(parameters, way, slopes),
        Leg::Whole(out, back, _) => {
            dwell + add_move(parameters, out, slopes) + add_move(parameters, back, slopes)
        }
        Leg::Chase(item) => {
            slopes[GRASP] = 1.0;
            parameters[GRASP] + chase(parameters, &item, slopes).0
        }
        Leg::ChaseHome(item, bin, _) => {
            let (tau, along) = chase(parameters, &item, slopes);
            let back = distance(along - bin[0], item.dy - bin[1]);
            // The meeting point moves with the time of the way out.
            let way = slopes.to_vec();
            let time = add_move(parameters, back, slopes);
            let length = back + parameters[LIFT];
            let shift = match back > 0.0 {
                true => item.belt_speed * (along - bin[0]) / back,
                false => 0.0,
            };
            let shift = shift * move_time(parameters, length).by_length;
            for index in [SLOWNESS, RAMP, LIFT] {
                slopes[index] += shift * way[index];
            }
            dwell + tau + time
        }
    }
}

/// The time [s] until the arm meets an item that moves on, whose slopes are added to `slopes`, and
/// the meeting point along the belt relative to where the arm left [m].
fn chase(parameters: &[f64], item: &Encounter, slopes: &mut [f64]) -> (f64, f64) {
    let tau = arm_of(parameters).travel_time(item);
    let along = item.dx + item.belt_speed * tau;
    let way = distance(along, item.dy);
    let part = move_time(parameters, way + parameters[LIFT]);
    let approach = if way > 0.0 {
        item.belt_speed * along / way
    } else {
        0.0
    };
    // From T(l(tau), p) = tau.
    let gain = 1.0 / (1.0 - part.by_length * approach).max(0.05);
    slopes[SLOWNESS] += gain * part.by_slowness;
    slopes[RAMP] += gain * part.by_ramp;
    slopes[LIFT] += gain * part.by_length;
    (tau, along)
}

/// The longest path of this leg [m], and whether the arm reaches its top speed there.
pub(super) fn longest_path(parameters: &[f64], leg: &Leg) -> (f64, bool) {
    let way = match *leg {
        Leg::Chase(item) | Leg::ChaseHome(item, ..) => {
            let mut unused = vec![0.0; parameters.len()];
            let (_, along) = chase(parameters, &item, &mut unused);
            distance(along, item.dy)
        }
        _ => leg.reach(),
    };
    let length = way + parameters[LIFT];
    (length, move_time(parameters, length).cruises)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes are those of differences, and times those of the arm.
    #[test]
    fn slopes_are_those_of_the_times() {
        let item = Encounter {
            dx: -0.3,
            dy: 0.4,
            belt_speed: 0.4,
            upstream: -1.0,
            downstream: 2.0,
        };
        let legs = [
            Leg::Out(0.02),
            Leg::Out(0.7),
            Leg::Back(0.4, 1),
            Leg::Whole(0.1, 0.8, 0),
            Leg::Chase(item),
            Leg::ChaseHome(item, [0.2, -0.1], 1),
        ];
        for parameters in [
            vec![0.5, 0.04, 0.05, 0.06, 0.1, 0.2],
            vec![0.2, 0.09, 0.02, 0.06, 0.1, 0.2],
        ] {
            let mut slopes = vec![0.0; 6];
            let mut unused = vec![0.0; 6];
            for leg in &legs {
                let time = predict(&parameters, leg, &mut slopes);
                for index in 0..6 {
                    let mut moved = parameters.clone();
                    moved[index] += 1e-6;
                    let by = (predict(&moved, leg, &mut unused) - time) / 1e-6;
                    assert!((by - slopes[index]).abs() < 1e-4, "{leg:?} {index}: {by}");
                }
            }
            let arm = arm_of(&parameters);
            let time = predict(&parameters, &Leg::Out(0.7), &mut slopes);
            assert!((time - arm.time(0.7)).abs() < 1e-12);
        }
    }
}
