//! What can be planned at one decision: the items in view and the robots that can reach them.

use super::options::Goal;
use crate::decision::{Candidate, Snapshot};
use crate::kinematics;
use crate::station::Station;

/// The planner's copy of a [`Snapshot`]. Items are identified by their *place* in it, which is
/// downstream first as in the pattern, so that ties are broken as in the simulator.
#[derive(Debug, Default)]
pub(super) struct Horizon {
    /// Time of the decision [s].
    pub now: f64,
    /// The deciding robot.
    pub robot: usize,
    /// When each robot can leave next [s], never before `now`; infinite for a robot that waits
    /// forever.
    pub free: Vec<f64>,
    /// Index of each item in its pattern.
    pub items: Vec<u32>,
    /// Pairs of index and place, sorted by index.
    places: Vec<(u32, u32)>,
    /// Value of each item, above 0: 1, or its weight.
    pub values: Vec<f64>,
    /// When each item would leave the belt [s].
    pub leaves: Vec<f64>,
    /// For each robot, one entry per item.
    reach: Vec<Vec<ItemReach>>,
    /// For each robot, the items that it can still reach, by opening time, then place;
    /// `Candidate::item` is the place.
    pub queues: Vec<Vec<Candidate>>,
    arms: Vec<RobotTiming>,
    belt_speed: f64,
    /// The windows of the item being added, one per robot.
    windows: Vec<Option<(f64, f64)>>,
}

/// One item for one robot.
#[derive(Debug, Clone, Copy)]
pub(super) struct ItemReach {
    /// Position along the travel at time 0 [m].
    x0: f64,
    /// Position across the belt, relative to the bin [m].
    dy: f64,
    /// First departure that meets it [s]; infinite if there is none.
    pub open: f64,
    /// Last departure that meets it [s]; minus infinity if there is none.
    pub close: f64,
    /// Shortest possible duration of picking it [s].
    pub shortest: f64,
}

#[derive(Debug, Clone, Copy)]
struct RobotTiming {
    bin_x: f64,
    speed: f64,
    grasp: f64,
    release: f64,
}

/// An item that is to be planned.
struct SeenItem {
    /// Its index in the pattern.
    item: u32,
    /// Position along the travel at time 0 [m].
    x0: f64,
    /// Position across the belt [m].
    y: f64,
    /// Weight, which the rules use.
    weight: f64,
    /// Value in plans: 1, or the weight.
    value: f64,
}

impl Horizon {
    /// Fills the horizon from `snapshot`, without items that no robot can reach within `ahead`
    /// [s] from now.
    pub(super) fn read(&mut self, snapshot: &Snapshot, ahead: f64, goal: Goal) {
        let station = snapshot.station;
        let robots = station.robots().len();
        self.now = snapshot.time;
        self.robot = snapshot.robot;
        self.belt_speed = station.belt().speed;
        self.free.clear();
        let free = snapshot.free_at.iter();
        self.free.extend(free.map(|free| free.max(snapshot.time)));
        self.free[snapshot.robot] = snapshot.time;
        self.arms.clear();
        self.arms
            .extend(station.robots().iter().map(|robot| RobotTiming {
                bin_x: robot.bin.x,
                speed: robot.speed,
                grasp: robot.grasp_time,
                release: robot.release_time,
            }));
        self.items.clear();
        self.values.clear();
        self.leaves.clear();
        self.reach.resize_with(robots, Vec::new);
        self.queues.resize_with(robots, Vec::new);
        self.reach.iter_mut().for_each(Vec::clear);
        self.queues.iter_mut().for_each(Vec::clear);
        self.add_seen(snapshot, ahead, goal);
        let places = self.items.iter().zip(0..);
        self.places.clear();
        self.places
            .extend(places.map(|(&item, place)| (item, place)));
        self.places.sort_unstable();
        for queue in &mut self.queues {
            // The sort is stable, so equal openings stay in pattern order.
            queue.sort_by(|a, b| a.open.total_cmp(&b.open));
        }
    }

    /// Adds the items that can be seen or picked now, downstream first.
    fn add_seen(&mut self, snapshot: &Snapshot, ahead: f64, goal: Goal) {
        // A robot may leave for an item before the camera at the belt's start has seen it, so
        // the candidates are merged in. Both lists are sorted downstream first.
        let (mut candidates, mut view) = (snapshot.candidates, snapshot.in_view);
        loop {
            let (item, x0, y, weight) = match (candidates, view) {
                ([c, rest @ ..], [b, ..]) if (-c.x0, c.item) < (-b.x0, b.item) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.weight)
                }
                (_, [b, rest @ ..]) => {
                    view = rest;
                    if candidates.first().is_some_and(|c| c.item == b.item) {
                        candidates = &candidates[1..];
                    }
                    (b.item, b.x0, b.y, b.weight)
                }
                ([c, rest @ ..], []) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.weight)
                }
                ([], []) => break,
            };
            let value = match goal {
                Goal::Picks => 1.0,
                Goal::Weight => weight,
            };
            // An item without value is not worth a robot's time.
            if value > 0.0 {
                let seen = SeenItem {
                    item,
                    x0,
                    y,
                    weight,
                    value,
                };
                self.add(snapshot.station, seen, ahead);
            }
        }
    }

    /// Adds the item `seen`, if some robot reaches it within `ahead` [s] from now.
    fn add(&mut self, station: &Station, seen: SeenItem, ahead: f64) {
        let SeenItem {
            item,
            x0,
            y,
            weight,
            value,
        } = seen;
        let belt = station.belt();
        let until = self.now + ahead;
        self.windows.clear();
        self.windows.extend(station.robots().iter().map(|robot| {
            let window = robot.departure_window(belt, x0, y);
            window.filter(|&(open, close)| close >= self.now && open <= until)
        }));
        if self.windows.iter().all(Option::is_none) {
            return;
        }
        // A snapshot has at most as many items as a pattern, whose indices are u32.
        let place = self.items.len() as u32;
        for (robot, window) in self.windows.iter().enumerate() {
            let (open, close) = window.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
            let mut reach = ItemReach {
                x0,
                dy: y - station.robots()[robot].bin.y,
                open,
                close,
                shortest: f64::INFINITY,
            };
            if window.is_some() {
                let at = self.best_start(robot, &reach);
                reach.shortest = self.finish(robot, &reach, at) - at;
            }
            self.reach[robot].push(reach);
            if window.is_some() {
                self.queues[robot].push(Candidate {
                    item: place,
                    x0,
                    y,
                    // The rules use the weight, whatever the goal.
                    weight,
                    open,
                    close,
                });
            }
        }
        self.items.push(item);
        self.values.push(value);
        self.leaves.push((belt.length - x0) / belt.speed);
    }

    /// Number of robots.
    pub(super) fn robots(&self) -> usize {
        self.free.len()
    }

    /// The place of an item of the pattern; `None` if it is out of view or out of reach.
    pub(super) fn place(&self, item: u32) -> Option<u32> {
        let found = self.places.binary_search_by_key(&item, |&(item, _)| item);
        found.ok().map(|at| self.places[at].1)
    }

    /// Shortest possible duration of a pick, averaged over robots and the items within their
    /// reach [s].
    pub(super) fn mean_shortest(&self) -> f64 {
        let all = self.reach.iter().flatten().map(|reach| reach.shortest);
        let (sum, count) = all
            .filter(|shortest| shortest.is_finite())
            .fold((0.0, 0.0), |(sum, count), shortest| {
                (sum + shortest, count + 1.0)
            });
        sum / f64::max(count, 1.0)
    }

    /// The data of one item for one robot.
    #[inline(always)]
    pub(super) fn reach(&self, robot: usize, place: u32) -> &ItemReach {
        &self.reach[robot][place as usize]
    }

    /// When `robot` is free again if it leaves for the item at `start` [s].
    #[inline(always)]
    pub(super) fn finish(&self, robot: usize, reach: &ItemReach, start: f64) -> f64 {
        let arm = &self.arms[robot];
        let dx = reach.x0 + self.belt_speed * start - arm.bin_x;
        let travel = kinematics::travel_time(dx, reach.dy, self.belt_speed, arm.speed);
        start + kinematics::processing_time(travel, arm.grasp, arm.release)
    }

    /// The departure in the window [s] for which the pick takes the shortest time. The travel
    /// time of [`kinematics::travel_time`] is shortest where its derivative along the belt is
    /// zero, `dx = -|dy| v / u`, and increases on both sides.
    fn best_start(&self, robot: usize, reach: &ItemReach) -> f64 {
        let arm = &self.arms[robot];
        let dx = -reach.dy.abs() * self.belt_speed / arm.speed;
        let at = (dx + arm.bin_x - reach.x0) / self.belt_speed;
        at.clamp(reach.open, reach.close)
    }

    /// The last departure at which `robot`, leaving for the item, is free again by `deadline`
    /// [s]. This is the inverse of [`Horizon::finish`], which increases with the departure
    /// because the arm is faster than the belt. Backwards in time the belt moves the other way,
    /// so the way back has the meeting point's closed form with -v.
    #[inline(always)]
    pub(super) fn latest_start(&self, robot: usize, reach: &ItemReach, deadline: f64) -> f64 {
        let arm = &self.arms[robot];
        let lifted = deadline - arm.grasp - arm.release;
        let dx = reach.x0 + self.belt_speed * lifted - arm.bin_x;
        let travel = kinematics::travel_time(dx, reach.dy, -self.belt_speed, arm.speed);
        lifted - 2.0 * travel
    }
}

#[cfg(test)]
impl Horizon {
    /// With all of `pattern` in view at time 0, when the first robot decides and the others
    /// are free at the times [s] given.
    pub(crate) fn of_all(
        station: &Station,
        pattern: &crate::pattern::Pattern,
        free_at: &[f64],
        goal: Goal,
    ) -> Self {
        let items = pattern.items().iter().zip(0..);
        let in_view: Vec<_> = items
            .map(|(item, index)| crate::decision::BeltItem {
                item: index,
                x0: item.x0,
                x: item.x0,
                y: item.y,
                weight: item.reward(),
            })
            .collect();
        let snapshot = Snapshot {
            station,
            time: 0.0,
            robot: 0,
            candidates: &[],
            free_at,
            in_view: &in_view,
        };
        let mut horizon = Self::default();
        horizon.read(&snapshot, f64::INFINITY, goal);
        horizon
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::Strategy;
    use crate::pattern::grid;
    use crate::sim::{Scene, simulate};
    use crate::station::built_in;

    /// Checks horizons in a run that picks the first candidate.
    struct Probe(Horizon);

    impl Strategy for Probe {
        fn decide(&mut self, snapshot: &Snapshot) -> crate::decision::Action {
            let horizon = &mut self.0;
            horizon.read(snapshot, f64::INFINITY, Goal::Picks);
            for candidate in snapshot.candidates {
                let place = horizon.place(candidate.item).expect("a candidate is known");
                let reach = horizon.reach(snapshot.robot, place);
                assert_eq!((reach.open, reach.close), (candidate.open, candidate.close));
                let at = snapshot.moment();
                let finish = horizon.finish(snapshot.robot, reach, snapshot.time);
                assert_eq!(finish, snapshot.time + at.processing_time(candidate));
                let start = horizon.latest_start(snapshot.robot, reach, finish);
                assert!((start - snapshot.time).abs() < 1e-9);
                // No departure in the window takes less than the shortest time.
                for step in 0..=100 {
                    let share = f64::from(step) / 100.0;
                    let start = reach.open + share * (reach.close - reach.open);
                    let time = horizon.finish(snapshot.robot, reach, start) - start;
                    assert!(time >= reach.shortest - 1e-12);
                }
            }
            crate::decision::Action::Pick(0)
        }

        fn name(&self) -> String {
            "probe".into()
        }
    }

    #[test]
    fn times_are_those_of_the_simulator_and_can_be_turned_round() {
        for name in ["paper", "paper-narrow"] {
            let station = built_in(name).unwrap().station(Some(2)).unwrap();
            let pattern = grid(station.belt().width, 0.15, 60).unwrap();
            let scene = Scene::new(&station, &pattern).unwrap();
            let outcome = simulate(&scene, &mut Probe(Horizon::default())).unwrap();
            assert!(!outcome.picks.is_empty());
        }
    }
}
