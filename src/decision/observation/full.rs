//! The full observation, relative to the deciding robot so that one policy works at any position in
//! lines of any length.
//!
//! Times are multiples of `T = reach / speed` [s] of the deciding robot, or `log(t) = ln(1 + t / T)
//! / 3` if they span orders of magnitude. Lengths are multiples of its reach. y is mirrored so that
//! the belt is at y > 0 of every robot.
//!
//! | slot | feature |
//! |---|---|
//! | 0 | 1 if the slot holds an item |
//! | 1, 2 | x, y relative to the base |
//! | 3 | processing time P / 2 T |
//! | 4, 5 | time left in the extended workspace / time to cross the workspace; log |
//! | 6 | reward r |
//! | 7 | shortest P from now on for this robot, / 2 T |
//! | 8 | log time until then |
//! | 9 | current P minus that, / 2 T |
//! | 10 | share of the other robots that could still pick it |
//! | 11 | whether the next robot downstream could |
//! | 12 | log time until the first of them could; 2 if none can |
//! | 13 | shortest P of any of them, / 2 T; 2 if none can |
//! | 14 | log time left until the last of them no longer can |
//! | 15 | P minus the shortest P of all slots, / 2 T |
//! | 16 | log time left minus the minimum of all slots |
//!
//! | global | feature |
//! |---|---|
//! | 0..3 | position in the line from 0 to 1; first; last |
//! | 3 | number of robots / 6 |
//! | 4, 5 | next robot downstream: busy, log time until free |
//! | 6, 7 | next robot upstream: the same |
//! | 8 | mean log time until free of the other robots |
//! | 9 | number of candidates as count(n) = ln(1 + n) / 4 |
//! | 10 | load: items in view in or upstream of the workspace, count |
//! | 11 | those of them that no other robot can still pick, count |
//! | 12, 13, 14 | load of the next robot downstream and upstream, mean of the others, count |
//! | 15 | items in view, count |
//! | 16 | belt speed / arm speed |
//! | 17 | log time that an item takes to cross the middle of the workspace |
//! | 18 | grasp and release time / T |
//! | 19 | x of the last item in view / belt length: approach of the end of the pattern |
//! | 20 | load divided by the robots that could pick each item: this robot's share, count |

use crate::decision::candidate::{Candidate, Moment};
use crate::decision::snapshot::{BeltItem, Snapshot};
use crate::kinematics::{self, Encounter};
use crate::station::{Belt, Bin, Robot};
use nalgebra::Point2;

/// Number of global features.
pub(super) const GLOBALS: usize = 21;
/// Number of features per slot.
pub(super) const FEATURES: usize = 17;

/// The value that represents "never" for a time or duration.
pub(super) const NEVER: f32 = 2.0;

/// The scales of the numbers of one robot.
pub(super) struct Scale {
    /// The time T [s].
    time: f64,
}

impl Scale {
    pub(super) fn of(robot: &Robot) -> Self {
        Self {
            time: robot.crossing_time(),
        }
    }

    pub(super) fn log(&self, time: f64) -> f32 {
        // A robot that waits forever is equivalent to one that waits very long. A polynomial would
        // be faster than `ln`, but rounding does not matter here.
        ((1.0 + time.clamp(0.0, 1e4) / self.time) as f32).ln() / 3.0
    }

    fn half(&self, time: f64) -> f32 {
        (time / (2.0 * self.time)) as f32
    }
}

pub(super) fn count(items: f32) -> f32 {
    (1.0 + items).ln() / 4.0
}

/// Fills `globals`, and `slots`, one every `stride` values, with the features of the chosen candidates.
pub(super) fn encode(
    snapshot: &Snapshot,
    chosen: &[usize],
    globals: &mut [f32],
    (slots, stride): (&mut [f32], usize),
) {
    let moment = snapshot.moment();
    let scale = Scale::of(moment.robot);
    encode_globals(snapshot, &moment, &scale, globals);
    for (place, slot) in chosen.iter().zip(slots.chunks_exact_mut(stride)) {
        encode_slot(
            snapshot,
            &moment,
            &scale,
            &snapshot.candidates[*place],
            slot,
        );
    }
    let least = |feature: usize| {
        let values = slots.chunks_exact(stride).map(|slot| slot[feature]);
        values.fold(f32::INFINITY, f32::min)
    };
    let (shortest, first) = (least(3), least(5));
    for slot in slots.chunks_exact_mut(stride) {
        slot[15] = slot[3] - shortest;
        slot[16] = slot[5] - first;
    }
}

/// An item for one robot, which leaves from where its arm is and puts it into `bin`.
struct Errand<'a> {
    robot: &'a Robot,
    from: Point2<f64>,
    bin: &'a Bin,
    x0: f64,
    y: f64,
}

impl Errand<'_> {
    /// The best pick for a departure at or after `time` [s]: the shortest processing time [s] and
    /// the corresponding departure time [s]. `None` if the item is out of reach.
    #[inline(always)]
    fn best_to_come(&self, belt: &Belt, time: f64) -> Option<(f64, f64)> {
        let Self {
            robot,
            from,
            bin,
            x0,
            y,
        } = *self;
        let base = robot.base;
        let (x_in, x_out) = kinematics::meeting_range(base.x, base.y, robot.reach, y, belt.length)?;
        let v = belt.speed;
        let x = x0 + v * time;
        let dwell = robot.grasp_time + bin.release_time;
        let Some(u) = robot.arm.constant_speed().filter(|_| bin.at == from) else {
            return Some(self.best_of_some(belt, time, (x_in, x_out)));
        };
        let travel = kinematics::travel_time(x - from.x, y - from.y, v, u);
        let soonest = x + v * travel;
        // Nearest to the bin among the positions where it can still be met.
        if soonest >= from.x || x_out <= soonest {
            return Some((2.0 * travel + dwell, time));
        }
        let meet = from.x.min(x_out);
        let travel = kinematics::distance(meet - from.x, y - from.y) / u;
        Some((2.0 * travel + dwell, (meet - x0) / v - travel))
    }

    /// The same for any arm and bin, among the soonest meeting point and those opposite the arm's
    /// place, opposite the bin and half-way.
    #[inline(never)]
    fn best_of_some(&self, belt: &Belt, time: f64, (x_in, x_out): (f64, f64)) -> (f64, f64) {
        let (robot, from, bin) = (self.robot, self.from, self.bin);
        let x = self.x0 + belt.speed * time;
        let travel = robot.arm.travel_time(&Encounter {
            dx: x - from.x,
            dy: self.y - from.y,
            belt_speed: belt.speed,
            upstream: -x,
            downstream: belt.length - x,
        });
        let soonest = x + belt.speed * travel;
        let move_time = |x: f64, to: Point2<f64>| {
            let way = kinematics::distance(x - to.x, self.y - to.y);
            robot.arm.time(way)
        };
        let dwell = robot.grasp_time + bin.release_time;
        let mut best = (travel + move_time(soonest, bin.at) + dwell, time);
        for x in [from.x, bin.at.x, f64::midpoint(from.x, bin.at.x)] {
            let x = x.clamp(x_in, x_out);
            if x > soonest {
                let out = move_time(x, from);
                let whole = out + move_time(x, bin.at) + dwell;
                if whole < best.0 {
                    best = (whole, (x - self.x0) / belt.speed - out);
                }
            }
        }
        best
    }
}

fn encode_slot(
    snapshot: &Snapshot,
    moment: &Moment,
    scale: &Scale,
    candidate: &Candidate,
    slot: &mut [f32],
) {
    let robot = moment.robot;
    let now = snapshot.time;
    let processing = moment.processing_time(candidate);
    let left = candidate.close - now;
    let crossing = 2.0 * robot.reach / moment.belt_speed;
    // A candidate can be met, so there is always a best pick.
    let belt = snapshot.station.belt();
    let errand = Errand {
        robot,
        from: moment.from,
        bin: &robot.bins[usize::from(candidate.bin)],
        x0: candidate.x0,
        y: candidate.y,
    };
    let (best, when) = errand.best_to_come(belt, now).unwrap_or((processing, now));
    slot[0] = 1.0;
    slot[1] = ((moment.x(candidate) - robot.base.x) / robot.reach) as f32;
    slot[2] = (side(robot) * (candidate.y - robot.base.y) / robot.reach) as f32;
    slot[3] = scale.half(processing);
    slot[4] = (left / crossing) as f32;
    slot[5] = scale.log(left);
    slot[6] = candidate.weight as f32;
    slot[7] = scale.half(best);
    slot[8] = scale.log(when - now);
    slot[9] = scale.half(processing - best);
    let robots = snapshot.station.robots();
    let (mut able, mut soonest, mut shortest, mut last) = (0, f64::INFINITY, f64::INFINITY, 0.0f64);
    slot[11] = 0.0;
    for (index, other) in robots.iter().enumerate() {
        if index == snapshot.robot {
            continue;
        }
        let Some(bin) = snapshot.station.bin_for(index, candidate.class) else {
            continue;
        };
        let from = usize::from(snapshot.places[index]);
        let window = other.departure_window(belt, from, candidate.x0, candidate.y);
        let Some((open, close)) = window else {
            continue;
        };
        let errand = Errand {
            robot: other,
            from: other.place(from),
            bin: &other.bins[usize::from(bin)],
            ..errand
        };
        let from = open.max(now).max(snapshot.free_at[index]);
        if close < from {
            continue;
        }
        able += 1;
        soonest = soonest.min(from - now);
        last = last.max(close - now);
        if let Some((best, _)) = errand.best_to_come(belt, from) {
            shortest = shortest.min(best);
        }
        if index == snapshot.robot + 1 {
            slot[11] = 1.0;
        }
    }
    slot[10] = able as f32 / (robots.len().max(2) - 1) as f32;
    slot[12] = if able > 0 { scale.log(soonest) } else { NEVER };
    slot[13] = if able > 0 {
        scale.half(shortest)
    } else {
        NEVER
    };
    slot[14] = scale.log(last);
}

/// The sign that orients y towards the belt.
pub(super) fn side(robot: &Robot) -> f64 {
    if robot.base.y <= 0.0 { 1.0 } else { -1.0 }
}

/// Whether an item is in the workspace or will enter it.
fn ahead(robot: &Robot, item: &BeltItem) -> bool {
    let (dx, dy) = (item.x - robot.base.x, item.y - robot.base.y);
    let reach = robot.reach * robot.reach;
    dy * dy <= reach && (dx <= 0.0 || dx * dx + dy * dy <= reach)
}

fn encode_globals(snapshot: &Snapshot, moment: &Moment, scale: &Scale, globals: &mut [f32]) {
    let robots = snapshot.station.robots();
    let (own, last) = (snapshot.robot, robots.len() - 1);
    globals.fill(0.0);
    globals[0] = own as f32 / last.max(1) as f32;
    globals[1] = f32::from(u8::from(own == 0));
    globals[2] = f32::from(u8::from(own == last));
    globals[3] = robots.len() as f32 / 6.0;
    let others = last.max(1) as f32;
    for index in (0..=last).filter(|index| *index != own) {
        let until = snapshot.time_until_free(index);
        let log = scale.log(until);
        let busy = f32::from(u8::from(until > 0.0));
        if index == own + 1 {
            (globals[4], globals[5]) = (busy, log);
        } else if index + 1 == own {
            (globals[6], globals[7]) = (busy, log);
        }
        globals[8] += log / others;
    }
    globals[9] = count(snapshot.candidates.len() as f32);
    let (mut load, mut alone, mut share) = (0.0, 0.0, 0.0);
    let (mut down, mut up, mut elsewhere) = (0.0, 0.0, 0.0);
    for item in snapshot.in_view {
        let mut able = 0.0;
        let mut mine = false;
        for (index, robot) in robots.iter().enumerate() {
            let takes = snapshot.station.has_bin_for(index, item.class);
            let ahead = takes && ahead(robot, item);
            let one = f32::from(u8::from(ahead));
            able += one;
            if index == own {
                mine = ahead;
            } else {
                elsewhere += one;
                if index == own + 1 {
                    down += one;
                } else if index + 1 == own {
                    up += one;
                }
            }
        }
        if mine {
            load += 1.0;
            share += 1.0 / able;
            alone += f32::from(u8::from(able == 1.0));
        }
    }
    globals[10] = count(load);
    globals[11] = count(alone);
    globals[12] = count(down);
    globals[13] = count(up);
    globals[14] = count(elsewhere / others);
    globals[15] = count(snapshot.in_view.len() as f32);
    globals[16] = (moment.belt_speed / moment.robot.cruising_speed()) as f32;
    globals[17] = scale.log(2.0 * moment.robot.reach / moment.belt_speed);
    globals[18] = (moment.robot.mean_dwell() / scale.time) as f32;
    let end = snapshot.in_view.last().map_or(0.0, |item| item.x);
    globals[19] = (end / snapshot.station.belt().length) as f32;
    globals[20] = count(share);
}
