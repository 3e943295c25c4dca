//! What can be planned at one decision: the items in view and the robots that can reach them.

use super::options::Goal;
use super::timing::{ItemReach, RobotTiming};
use crate::decision::{Candidate, Odds, Snapshot};
use crate::station::{ClassId, Station};

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
    /// Number of the attempt at the item, from 0. An item whose grasps may fail has one place for
    /// each attempt that is planned, one after the other.
    pub attempts: Vec<u8>,
    /// Pairs of index and first place, sorted by index.
    places: Vec<(u32, u32)>,
    /// Value of each item, above 0: 1, or its weight, times the probability that the attempt is made
    /// and succeeds.
    pub values: Vec<f64>,
    /// When each item would leave the belt [s].
    pub leaves: Vec<f64>,
    /// For each robot, one entry per item.
    reach: Vec<Vec<ItemReach>>,
    /// For each robot with several places, the windows of each item from each of them [s]; where
    /// there is none, it closes before it opens.
    windows: Vec<Vec<(f64, f64)>>,
    /// For each robot, the items that it can still reach, by opening time, then place;
    /// `Candidate::item` is the place. Windows are the widest over the places of the robot.
    pub queues: Vec<Vec<Candidate>>,
    arms: Vec<RobotTiming>,
    /// The widest windows of the item being added, one per robot.
    widest: Vec<Option<(f64, f64)>>,
}

/// An attempt at an item that is to be planned.
#[derive(Clone, Copy)]
struct SeenItem {
    /// Its index in the pattern.
    item: u32,
    /// Number of the attempt, from 0.
    attempt: u8,
    /// Position along the travel at time 0 [m].
    x0: f64,
    /// Position across the belt [m].
    y: f64,
    /// Weight, which the rules use.
    weight: f64,
    /// Value in plans: what the attempt is expected to gain.
    value: f64,
    /// Class on the station.
    class: ClassId,
}

/// Maximum number of attempts at one item that are planned.
const MOST_ATTEMPTS: u8 = 3;
/// Further attempts are planned only if they are worth more than this share of the first. Less
/// likely ones cost more of the search than they gain (`docs/lookahead.md`).
const LEAST_SHARE: f64 = 0.25;

/// What counts in a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Valuation {
    pub goal: Goal,
    /// Whether the probabilities of failing are counted.
    pub foresee: bool,
}

impl Horizon {
    /// Fills the horizon from `snapshot`, without items that no robot can reach within `ahead`
    /// [s] from now.
    pub(super) fn read(&mut self, snapshot: &Snapshot, ahead: f64, valuation: Valuation) {
        let station = snapshot.station;
        let robots = station.robots().len();
        self.now = snapshot.time;
        self.robot = snapshot.robot;
        self.free.clear();
        let free = snapshot.free_at.iter();
        self.free.extend(free.map(|free| free.max(snapshot.time)));
        self.free[snapshot.robot] = snapshot.time;
        // Robots do not change within a run, and copying their bins would take long.
        let robots_of =
            |arms: &[RobotTiming]| arms.iter().map(|arm| &arm.robot).eq(station.robots());
        if !robots_of(&self.arms) {
            self.arms.clear();
            let all = station.robots().iter();
            self.arms
                .extend(all.map(|robot| RobotTiming::of(robot, station.belt())));
        }
        for (arm, place) in self.arms.iter_mut().zip(snapshot.places) {
            arm.place = *place;
            arm.put_on(station.belt());
        }
        self.items.clear();
        self.attempts.clear();
        self.values.clear();
        self.leaves.clear();
        self.reach.resize_with(robots, Vec::new);
        self.queues.resize_with(robots, Vec::new);
        self.windows.resize_with(robots, Vec::new);
        self.reach.iter_mut().for_each(Vec::clear);
        self.windows.iter_mut().for_each(Vec::clear);
        self.queues.iter_mut().for_each(Vec::clear);
        self.add_seen(snapshot, ahead, valuation);
        let places = self.items.iter().zip(&self.attempts).zip(0..);
        let first = places.filter(|((_, attempt), _)| **attempt == 0);
        self.places.clear();
        self.places
            .extend(first.map(|((&item, _), place)| (item, place)));
        self.places.sort_unstable();
        for queue in &mut self.queues {
            // The sort is stable, so equal openings stay in pattern order.
            queue.sort_by(|a, b| a.open.total_cmp(&b.open));
        }
    }

    /// Adds the items that can be seen or picked now, downstream first.
    fn add_seen(&mut self, snapshot: &Snapshot, ahead: f64, valuation: Valuation) {
        // A robot may leave for an item before the camera at the belt's start has seen it, so
        // the candidates are merged in. Both lists are sorted downstream first.
        let (mut candidates, mut view) = (snapshot.candidates, snapshot.in_view);
        loop {
            let next = snapshot.candidates.len() - candidates.len();
            let (item, x0, y, weight, class, odds) = match (candidates, view) {
                ([c, rest @ ..], [b, ..]) if (-c.x0, c.item) < (-b.x0, b.item) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.weight, c.class, snapshot.odds_of(next))
                }
                (_, [b, rest @ ..]) => {
                    view = rest;
                    if candidates.first().is_some_and(|c| c.item == b.item) {
                        candidates = &candidates[1..];
                    }
                    (b.item, b.x0, b.y, b.weight, b.class, b.odds)
                }
                ([c, rest @ ..], []) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.weight, c.class, snapshot.odds_of(next))
                }
                ([], []) => break,
            };
            let seen = SeenItem {
                item,
                attempt: 0,
                x0,
                y,
                weight,
                value: valuation.first_attempt(weight, odds),
                class,
            };
            // An item without value is not worth a robot's time.
            if seen.value > 0.0 {
                self.add(snapshot.station, seen, ahead);
                if valuation.foresee {
                    self.add_further_attempts(snapshot.station, seen, odds.grasp, ahead);
                }
            }
        }
    }

    /// Adds attempts at the item `seen` after the first, whose grasps succeed with probability
    /// `p_grasp`: attempt number k + 1 is only made if k have failed.
    fn add_further_attempts(
        &mut self,
        station: &Station,
        seen: SeenItem,
        p_grasp: f64,
        ahead: f64,
    ) {
        let mut share = 1.0;
        for attempt in 1..MOST_ATTEMPTS {
            share *= 1.0 - p_grasp;
            if share <= LEAST_SHARE {
                return;
            }
            let again = SeenItem {
                attempt,
                value: seen.value * share,
                ..seen
            };
            self.add(station, again, ahead);
        }
    }

    /// Adds the item `seen`, if some robot reaches it within `ahead` [s] from now.
    fn add(&mut self, station: &Station, seen: SeenItem, ahead: f64) {
        let SeenItem { x0, y, .. } = seen;
        let belt = station.belt();
        let until = self.now + ahead;
        self.widest.clear();
        for (index, arm) in self.arms.iter().enumerate() {
            let windows = &mut self.windows[index];
            let begin = windows.len();
            let takes = station.has_bin_for(index, seen.class);
            let window = |place: usize| {
                let window = arm.robot.departure_window(belt, place, x0, y);
                window.filter(|&(open, close)| takes && close >= self.now && open <= until)
            };
            let widest = if arm.places == 1 {
                window(0)
            } else {
                windows.extend((0..arm.places).map(|place| window(place).unwrap_or(NEVER)));
                let own = windows[begin..].iter().copied();
                let widest = own.fold(NEVER, |a, b| (a.0.min(b.0), a.1.max(b.1)));
                (widest.0 <= widest.1).then_some(widest)
            };
            self.widest.push(widest);
        }
        if self.widest.iter().all(Option::is_none) {
            for (arm, windows) in self.arms.iter().zip(&mut self.windows) {
                let known = windows.len().saturating_sub(arm.places);
                windows.truncate(known);
            }
            return;
        }
        // A snapshot has at most as many items as a pattern, whose indices are u32.
        let place = self.items.len() as u32;
        for robot in 0..self.arms.len() {
            let window = self.widest[robot];
            let (open, close) = window.unwrap_or(NEVER);
            let mut reach = ItemReach {
                x0,
                y,
                bin: station.bin_for(robot, seen.class).unwrap_or(0),
                open,
                close,
                shortest: f64::INFINITY,
            };
            if window.is_some() {
                reach.shortest = self.arms[robot].shortest(&reach);
            }
            self.reach[robot].push(reach);
            if window.is_some() {
                self.queues[robot].push(Candidate {
                    item: place,
                    bin: reach.bin,
                    class: seen.class,
                    x0,
                    y,
                    // The rules use the weight, whatever the goal.
                    weight: seen.weight,
                    open,
                    close,
                });
            }
        }
        self.items.push(seen.item);
        self.attempts.push(seen.attempt);
        self.values.push(seen.value);
        self.leaves.push((belt.length - x0) / belt.speed);
    }

    /// Number of robots.
    pub(super) fn robots(&self) -> usize {
        self.free.len()
    }

    /// The first place of an item of the pattern; `None` if it is out of view or out of reach.
    pub(super) fn place(&self, item: u32) -> Option<u32> {
        let found = self.places.binary_search_by_key(&item, |&(item, _)| item);
        found.ok().map(|at| self.places[at].1)
    }

    /// The places of an item of the pattern, one for each attempt.
    pub(super) fn places_of(&self, item: u32) -> impl Iterator<Item = u32> {
        let first = self.place(item).into_iter();
        first
            .flat_map(|first| first..)
            .take_while(move |&place| self.items.get(place as usize) == Some(&item))
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

    /// Where the arm of `robot` is when it is free.
    #[inline(always)]
    pub(super) fn place_of(&self, robot: usize) -> u16 {
        self.arms[robot].place
    }

    /// What `robot` alone needs, for loops over its items.
    #[inline(always)]
    pub(super) fn of_robot(&self, robot: usize) -> RobotHorizon<'_> {
        RobotHorizon {
            arm: &self.arms[robot],
            reach: &self.reach[robot],
            windows: &self.windows[robot],
        }
    }

    /// Whether `robot` leaves from more than one place.
    #[inline(always)]
    pub(super) fn has_places(&self, robot: usize) -> bool {
        self.arms[robot].places > 1
    }

    /// Number of places of `robot`.
    pub(super) fn places(&self, robot: usize) -> usize {
        self.arms[robot].places
    }

    /// When `robot` is free again if it leaves `from` for the item at `start` [s].
    #[inline(always)]
    pub(super) fn finish(&self, robot: usize, from: u16, reach: &ItemReach, start: f64) -> f64 {
        self.arms[robot].finish(from, reach, start)
    }

    /// The window [s] of the item at `place` for `robot` that leaves `from`; it closes before it
    /// opens if there is none.
    #[inline(always)]
    pub(super) fn window(&self, robot: usize, from: u16, place: u32) -> (f64, f64) {
        let of_robot = self.of_robot(robot);
        of_robot.window(from, place, of_robot.reach(place))
    }
}

/// A [`Horizon`] for one robot.
#[derive(Clone, Copy)]
pub(super) struct RobotHorizon<'a> {
    arm: &'a RobotTiming,
    reach: &'a [ItemReach],
    windows: &'a [(f64, f64)],
}

impl<'a> RobotHorizon<'a> {
    /// The item at `place`.
    #[inline(always)]
    pub(super) fn reach(&self, place: u32) -> &'a ItemReach {
        &self.reach[place as usize]
    }

    /// [`Horizon::window`] of the item at `place`, which is `reach`.
    #[inline(always)]
    pub(super) fn window(&self, from: u16, place: u32, reach: &ItemReach) -> (f64, f64) {
        match self.arm.places {
            1 => (reach.open, reach.close),
            places => self.windows[place as usize * places + usize::from(from)],
        }
    }

    /// As [`Horizon::finish`].
    #[inline(always)]
    pub(super) fn finish(&self, from: u16, reach: &ItemReach, start: f64) -> f64 {
        self.arm.finish(from, reach, start)
    }

    /// The last departure from `from`, in its window for the item [s], at which the robot is free again
    /// by `deadline` [s].
    #[inline(always)]
    pub(super) fn latest_start(
        &self,
        from: u16,
        reach: &ItemReach,
        window: (f64, f64),
        deadline: f64,
    ) -> f64 {
        self.arm.latest_start(from, reach, window, deadline)
    }
}

impl Valuation {
    /// What the first attempt at an item of this weight is expected to gain.
    fn first_attempt(&self, weight: f64, odds: Odds) -> f64 {
        let odds = if self.foresee { odds } else { Odds::SURE };
        match self.goal {
            Goal::Picks => odds.grasp * odds.detection,
            // The reward of the paper has the probability of the detection.
            Goal::Weight => weight * odds.grasp,
        }
    }
}

/// Where there is no window.
const NEVER: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

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
                weight: item.weight_on(station),
                class: item.class_on(station),
                odds: Odds::SURE,
            })
            .collect();
        let start = |robot: &crate::station::Robot| robot.start() as u16;
        let places: Vec<u16> = station.robots().iter().map(start).collect();
        let snapshot = Snapshot {
            station,
            time: 0.0,
            robot: 0,
            candidates: &[],
            candidate_odds: &[],
            free_at,
            places: &places,
            in_view: &in_view,
        };
        let mut horizon = Self::default();
        let foresee = true;
        horizon.read(&snapshot, f64::INFINITY, Valuation { goal, foresee });
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
            let valuation = Valuation {
                goal: Goal::Picks,
                foresee: true,
            };
            horizon.read(snapshot, f64::INFINITY, valuation);
            for candidate in snapshot.candidates {
                let place = horizon.place(candidate.item).expect("a candidate is known");
                let reach = horizon.reach(snapshot.robot, place);
                assert_eq!((reach.open, reach.close), (candidate.open, candidate.close));
                let at = snapshot.moment();
                let from = snapshot.places[snapshot.robot];
                let finish = horizon.finish(snapshot.robot, from, reach, snapshot.time);
                assert_eq!(finish, snapshot.time + at.processing_time(candidate));
                let window = (reach.open, reach.close);
                let of_robot = horizon.of_robot(snapshot.robot);
                let start = of_robot.latest_start(from, reach, window, finish);
                assert!((start - snapshot.time).abs() < 1e-9);
                // No departure in the window takes less than the shortest time.
                for step in 0..=100 {
                    let share = f64::from(step) / 100.0;
                    let start = reach.open + share * (reach.close - reach.open);
                    let time = horizon.finish(snapshot.robot, from, reach, start) - start;
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
