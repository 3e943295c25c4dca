//! Improves a plan: removes some stops, refills the gaps, and keeps the result if it is no
//! worse.
//!
//! Large neighbourhood search in the manner of slack induction by string removals (Christiaens
//! and Vanden Berghe 2020, DOI 10.1287/trsc.2019.0914). Strings of stops around a random item
//! are removed, the gaps are filled greedily while some items are randomly skipped ("blinks"),
//! and simulated annealing (Kirkpatrick et al. 1983, DOI 10.1126/science.220.4598.671) decides
//! whether to keep the result.
//!
//! The constants were tuned on the grids of 0.15 m and on Poisson patterns with seeds that no
//! report uses (`docs/lookahead.md`).

use super::horizon::Horizon;
use super::meter::Meter;
use super::plan::{self, NOBODY, PickPlan, PlannedPick};
use rand::{Rng, RngExt};

/// Longest string of stops that is removed at once.
const LONGEST: usize = 8;
/// Maximum number of robots that lose a string at once.
const MOST_ROBOTS: usize = 2;
/// Share of the items that a filling step skips.
const BLINKS: f64 = 0.1;
/// Initial temperature, as a share of the mean shortest processing time.
const HEAT: f64 = 0.02;
/// Cost of a later end of the plan, in seconds of delay of single robots per second.
const END: f64 = 3.0;

/// Reusable buffers of a search.
#[derive(Debug, Default)]
pub(super) struct Improver {
    current: PickPlan,
    cuts: Vec<Cut>,
    fill: Vec<PlannedPick>,
    open: Vec<u32>,
    /// For each place of the robot whose gap is being filled, when it must be free there [s].
    deadlines: Vec<f64>,
}

/// A string of stops `from..to` of a robot, and its replacement.
#[derive(Debug, Clone, Copy)]
struct Cut {
    robot: usize,
    from: usize,
    to: usize,
    /// Range of its new stops in `Improver::fill`.
    begin: usize,
    end: usize,
}

/// The effect of refilling the cuts.
#[derive(Debug, Clone, Copy, Default)]
struct Refill {
    /// Value gained.
    gain: f64,
    /// How much later [s] the robots can continue with their next stops, plus [`END`] times how
    /// much later the last one is done.
    delay: f64,
}

impl Improver {
    /// Improves `plan` for as long as `meter` allows. The plan never gets worse.
    pub(super) fn improve(
        &mut self,
        horizon: &Horizon,
        plan: &mut PickPlan,
        meter: &mut Meter,
        rng: &mut impl Rng,
    ) {
        // A horizon has at most as many items as a pattern.
        let items = horizon.items.len() as u32;
        if items == 0 {
            return;
        }
        let heat = HEAT * horizon.mean_shortest();
        self.current.copy_from(plan);
        let mut best = plan.score(horizon);
        loop {
            let gone = meter.share();
            if gone >= 1.0 {
                return;
            }
            // So that a round without anything to cut still counts.
            meter.spend(1);
            self.choose_cuts(horizon, rng.random_range(0..items), rng);
            let change = self.refill(horizon, meter, rng);
            // An exponential variate times the temperature gives the Metropolis criterion.
            let allowed = heat * (1.0 - gone) * -(1.0 - rng.random::<f64>()).ln();
            let slack = 1e-9 * (1.0 + self.current.value);
            let accepted = if change.gain.abs() > slack {
                change.gain > 0.0
            } else {
                change.delay <= allowed
            };
            if !accepted {
                self.put_back();
                continue;
            }
            self.commit(horizon, change.gain, meter);
            let score = self.current.score(horizon);
            if score.beats(&best) {
                best = score;
                plan.copy_from(&self.current);
            }
        }
    }

    /// Chooses strings around the item `seed` in the routes of robots that can reach it.
    fn choose_cuts(&mut self, horizon: &Horizon, seed: u32, rng: &mut impl Rng) {
        self.cuts.clear();
        let robots = horizon.robots();
        let first = rng.random_range(0..robots);
        for robot in (first..robots).chain(0..first) {
            let reach = horizon.reach(robot, seed);
            if reach.open > reach.close || !horizon.free[robot].is_finite() {
                continue;
            }
            let route = &self.current.routes[robot];
            let low = route.partition_point(|stop| stop.finish < reach.open);
            let high = route.partition_point(|stop| stop.start <= reach.close);
            let centre = if low < high {
                rng.random_range(low..high)
            } else {
                low
            };
            let length = rng.random_range(1..=LONGEST);
            let from = centre.saturating_sub(rng.random_range(0..length));
            self.cuts.push(Cut {
                robot,
                from,
                to: (from + length).min(route.len()),
                begin: 0,
                end: 0,
            });
            if self.cuts.len() == MOST_ROBOTS {
                break;
            }
        }
    }

    /// Removes the strings and fills the gaps.
    fn refill(&mut self, horizon: &Horizon, meter: &mut Meter, rng: &mut impl Rng) -> Refill {
        let mut change = Refill::default();
        for cut in &self.cuts {
            for stop in &self.current.routes[cut.robot][cut.from..cut.to] {
                self.current.owner[stop.place as usize] = NOBODY;
                change.gain -= horizon.values[stop.place as usize];
            }
        }
        self.fill.clear();
        let old_end = self.end(horizon, |_| false);
        let mut new_end = self.end(horizon, |robot| self.loses_its_tail(robot));
        for number in 0..self.cuts.len() {
            let Cut {
                robot, from, to, ..
            } = self.cuts[number];
            let route = &self.current.routes[robot];
            let (free, place) = match from.checked_sub(1) {
                Some(before) => {
                    let stop = &route[before];
                    (stop.finish, horizon.reach(robot, stop.place).bin)
                }
                None => (horizon.free[robot], horizon.place_of(robot)),
            };
            let was_free = if from < to {
                route[to - 1].finish
            } else {
                free
            };
            let after = route.get(to).copied();
            self.deadlines.clear();
            match after {
                None => self.deadlines.resize(horizon.places(robot), f64::INFINITY),
                Some(stop) if !horizon.has_places(robot) => self.deadlines.push(stop.latest),
                Some(stop) => {
                    // Where the gap ends decides when the next stop must be begun.
                    let next = route.get(to + 1).map_or(f64::INFINITY, |stop| stop.latest);
                    let of_robot = horizon.of_robot(robot);
                    for place in 0..horizon.places(robot) as u16 {
                        let latest = plan::latest(&of_robot, place, stop.place, next);
                        self.deadlines.push(latest);
                    }
                }
            }
            let begin = self.fill.len();
            let gap = Gap { robot, free, place };
            let Some(now_free) = self.fill_gap(horizon, gap, meter, rng) else {
                // From here the next stop cannot be reached in time, so the cut is not possible.
                for undone in &mut self.cuts[number..] {
                    (undone.begin, undone.end) = (self.fill.len(), self.fill.len());
                }
                self.cuts[number].begin = begin;
                change.gain = f64::NEG_INFINITY;
                return change;
            };
            for stop in &self.fill[begin..] {
                change.gain += horizon.values[stop.place as usize];
            }
            // Before the window of the next stop opens, the exact time does not matter.
            let end = match self.fill[begin..].last() {
                Some(stop) => horizon.reach(robot, stop.place).bin,
                None => place,
            };
            let opens = after.map_or(f64::NEG_INFINITY, |stop| {
                horizon.window(robot, end, stop.place).0
            });
            if after.is_none() {
                new_end = new_end.max(now_free);
            }
            change.delay += now_free.max(opens) - was_free.max(opens);
            self.cuts[number].begin = begin;
            self.cuts[number].end = self.fill.len();
        }
        change.delay += END * (new_end - old_end);
        change
    }

    /// When the last robot is done [s], ignoring some robots.
    fn end(&self, horizon: &Horizon, without: impl Fn(usize) -> bool) -> f64 {
        (0..horizon.robots())
            .filter(|&robot| horizon.free[robot].is_finite() && !without(robot))
            .map(|robot| self.current.done(horizon, robot))
            .fold(horizon.now, f64::max)
    }

    /// Whether the last stops of `robot` are being cut.
    fn loses_its_tail(&self, robot: usize) -> bool {
        let route = &self.current.routes[robot];
        let mut cuts = self.cuts.iter();
        cuts.any(|cut| cut.robot == robot && cut.to == route.len())
    }

    /// Greedily adds stops in a gap that leave the robot free by the deadline [s] of the place
    /// where it is then; returns when it is free. `None` if that place has no deadline that it can
    /// keep, which only happens with several places.
    ///
    /// The item with the least time per value is next. A random share (one per gap) of the
    /// shortest possible time for the item is subtracted. With a share of 0 this is SPT; with a
    /// share of 1, only the time wasted by picking the item now counts.
    fn fill_gap(
        &mut self,
        horizon: &Horizon,
        gap: Gap,
        meter: &mut Meter,
        rng: &mut impl Rng,
    ) -> Option<f64> {
        let Gap {
            robot,
            mut free,
            mut place,
        } = gap;
        let deadlines = &self.deadlines;
        let last = deadlines.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let single = !horizon.has_places(robot);
        let of_robot = horizon.of_robot(robot);
        let values = &horizon.values[..];
        self.open.clear();
        let owner = &mut self.current.owner;
        let queue = &horizon.queues[robot];
        let end = queue.partition_point(|candidate| candidate.open <= last);
        let within = queue[..end].iter().filter(|c| c.close >= free);
        let unowned = within.filter(|c| owner[c.item as usize] == NOBODY);
        self.open.extend(unowned.map(|c| c.item));
        let deducted: f64 = rng.random();
        loop {
            let blink = rng.next_u64();
            let mut best: Option<(f64, PlannedPick)> = None;
            self.open.retain(|&item| {
                let reach = of_robot.reach(item);
                if reach.close < free || owner[item as usize] != NOBODY {
                    return false;
                }
                let (open, close) = of_robot.window(place, item, reach);
                let start = free.max(open);
                if start > close {
                    // From another place there may still be time.
                    return true;
                }
                let finish = of_robot.finish(place, reach, start);
                if finish > deadlines[deadline_of(single, reach.bin)] {
                    // Later, the pick would end even later, unless it begins elsewhere.
                    return !single;
                }
                let time = finish - free - deducted * reach.shortest;
                let key = time / values[item as usize];
                if best.as_ref().is_none_or(|(least, _)| key < *least) && !blinks(blink, item) {
                    let stop = PlannedPick {
                        place: item,
                        start,
                        finish,
                        latest: f64::NAN,
                    };
                    best = Some((key, stop));
                }
                true
            });
            meter.spend(1);
            let Some((_, stop)) = best else {
                let in_time = single || free <= deadlines[usize::from(place)];
                return in_time.then_some(free);
            };
            // A robot of a station, of which there are at most 100.
            owner[stop.place as usize] = robot as u16;
            free = stop.finish;
            place = horizon.reach(robot, stop.place).bin;
            self.fill.push(stop);
        }
    }

    /// Undoes a refill.
    fn put_back(&mut self) {
        for stop in &self.fill {
            self.current.owner[stop.place as usize] = NOBODY;
        }
        for cut in &self.cuts {
            for stop in &self.current.routes[cut.robot][cut.from..cut.to] {
                self.current.owner[stop.place as usize] = cut.robot as u16;
            }
        }
    }

    /// Makes a refill part of the current plan.
    fn commit(&mut self, horizon: &Horizon, gain: f64, meter: &mut Meter) {
        self.current.value += gain;
        for cut in &self.cuts {
            let new = self.fill[cut.begin..cut.end].iter().copied();
            self.current.routes[cut.robot].splice(cut.from..cut.to, new);
            meter.spend(self.current.retime(horizon, cut.robot));
        }
    }
}

/// A gap in the stops of a robot: when it begins [s], and where the arm is then.
#[derive(Debug, Clone, Copy)]
struct Gap {
    robot: usize,
    free: f64,
    place: u16,
}

/// The index of the deadline of a robot that is at bin `bin`; `single` if it has only one place.
#[inline(always)]
fn deadline_of(single: bool, bin: u16) -> usize {
    if single { 0 } else { usize::from(bin) }
}

/// Whether the item at `place` is skipped in the step that drew `draw`. One draw per step and a
/// multiplicative hash (Knuth, The Art of Computer Programming 3, 6.4) are cheaper than one
/// draw per item.
fn blinks(draw: u64, place: u32) -> bool {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    let hash = (draw ^ u64::from(place)).wrapping_mul(GOLDEN);
    (hash as f64) < BLINKS * u64::MAX as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Arm;
    use crate::pattern::{Item, Pattern, grid, random_stream};
    use crate::planning::meter::Budget;
    use crate::planning::options::Goal;
    use crate::station::{Belt, Robot, Station, built_in};
    use nalgebra::Point2;

    fn meter() -> Meter {
        Meter::new(Budget::Decisions(u64::MAX))
    }

    fn paper(robots: usize) -> (Station, Pattern) {
        let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
        let pattern = grid(station.belt().width, 0.15, 60).unwrap();
        (station, pattern)
    }

    /// An improver at a plan of nothing.
    fn improver(horizon: &Horizon) -> Improver {
        let mut improver = Improver::default();
        improver.current.clear(horizon);
        improver
    }

    /// A light item beside the bin and a heavy one further away, both at their best moment: a
    /// gap of 3 s is long enough for either of them and not for both.
    #[test]
    fn a_gap_goes_to_the_quicker_item_or_to_the_heavier_one_where_the_weight_counts() {
        let belt = Belt {
            speed: 0.1,
            length: 2.0,
            width: 1.4,
        };
        let robot = Robot::new(
            "r1",
            Point2::new(0.0, 0.0),
            Point2::new(0.0, 0.0),
            0.7,
            Arm::constant(1.0),
        )
        .with_dwell(1.0, 0.0);
        let station = Station::new(belt, vec![robot]).unwrap();
        let item = |id: &str, y: f64, weight: f64| Item {
            weight: Some(weight),
            ..Item::at(id, 0.0, y)
        };
        let items = vec![item("light", 0.05, 0.1), item("heavy", 0.5, 1.0)];
        let pattern = Pattern::new(items).unwrap();
        for (goal, expected) in [(Goal::Picks, 0), (Goal::Weight, 1)] {
            let horizon = Horizon::of_all(&station, &pattern, &[0.0], goal);
            let filled = |seed: u64| {
                let mut improver = improver(&horizon);
                let mut rng = random_stream(seed, 0);
                improver.deadlines = vec![3.0];
                let gap = Gap {
                    robot: 0,
                    free: 0.0,
                    place: 0,
                };
                improver.fill_gap(&horizon, gap, &mut meter(), &mut rng);
                improver.fill
            };
            let fills: Vec<_> = (0..100).map(filled).collect();
            assert!(fills.iter().all(|fill| fill.len() <= 1), "{goal:?}");
            let as_expected = fills.iter().flatten().filter(|s| s.place == expected);
            // Each step overlooks a tenth of the items.
            assert!(as_expected.count() >= 75, "{goal:?}");
        }
    }

    #[test]
    fn a_robot_that_waits_for_ever_costs_no_budget() {
        let (station, pattern) = paper(3);
        let free = [0.0, f64::INFINITY, 0.0];
        let horizon = Horizon::of_all(&station, &pattern, &free, Goal::Picks);
        let mut improver = improver(&horizon);
        let mut rng = random_stream(1, 0);
        let mut cut = [0; 3];
        for seed in (0..horizon.items.len() as u32).cycle().take(300) {
            improver.choose_cuts(&horizon, seed, &mut rng);
            improver.cuts.iter().for_each(|c| cut[c.robot] += 1);
        }
        assert!(cut[0] > 0 && cut[1] == 0 && cut[2] > 0, "{cut:?}");
    }

    /// What a refill says is held against the plans before and after it.
    #[test]
    fn a_refill_says_what_it_gains_and_delays_and_can_be_put_back() {
        let (station, pattern) = paper(3);
        let horizon = Horizon::of_all(&station, &pattern, &[0.0, 1.5, 0.0], Goal::Picks);
        let mut improver = improver(&horizon);
        let mut rng = random_stream(2, 0);
        let picks = |plan: &PickPlan| plan.routes.iter().map(Vec::len).sum::<usize>() as f64;
        let mut later_ends = 0;
        for round in 0..1000 {
            let seed = rng.random_range(0..horizon.items.len() as u32);
            improver.choose_cuts(&horizon, seed, &mut rng);
            let before = improver.current.clone();
            let change = improver.refill(&horizon, &mut meter(), &mut rng);
            if round % 3 == 0 {
                improver.put_back();
                assert_eq!(improver.current.owner, before.owner);
                continue;
            }
            improver.commit(&horizon, change.gain, &mut meter());
            let after = &improver.current;
            assert_eq!(change.gain, picks(after) - picks(&before));
            let mut done: Vec<f64> = (0..3).map(|r| before.done(&horizon, r)).collect();
            let old_end = done.iter().copied().fold(0.0, f64::max);
            let mut delay = 0.0;
            for cut in &improver.cuts {
                let robot = cut.robot;
                if let Some(next) = before.routes[robot].get(cut.to) {
                    let mut stops = after.routes[robot].iter();
                    let moved = stops.find(|stop| stop.place == next.place).unwrap();
                    delay += moved.start - next.start;
                } else {
                    delay += after.done(&horizon, robot) - done[robot];
                    done[robot] = after.done(&horizon, robot);
                }
            }
            let new_end = done.iter().copied().fold(0.0, f64::max);
            let expected = delay + END * (new_end - old_end);
            assert!((change.delay - expected).abs() < 1e-9, "{change:?}");
            later_ends += usize::from(new_end > old_end);
        }
        assert!(later_ends > 10, "{later_ends}");
    }
}
