//! The best of all schedules of a tiny instance, found by trying them all: an independent
//! witness for the bound.

use crate::common;
use pickline::decision::{Candidate, Figures, Moment};
use pickline::pattern::{Item, Pattern};
use pickline::planning::bound::{Bound, BoundObjective, BoundOptions, upper_bound};
use pickline::sim::{Disturbances, Scene};
use pickline::station::{Robot, Station};
use proptest::prelude::*;

pub fn bound(scene: &Scene, options: &BoundOptions) -> Bound {
    upper_bound(scene, options, &mut |_, _| true).unwrap()
}

pub fn options(objective: BoundObjective, iterations: usize) -> BoundOptions {
    BoundOptions::default()
        .with_objective(objective)
        .with_iterations(iterations)
}

/// The best of all schedules.
#[derive(Debug)]
pub struct Optimum {
    pub picks: usize,
    pub weight: f64,
    pub rate: f64,
    pub weighted_rate: f64,
    pub end: f64,
    pub all_end: Option<f64>,
}

/// Tries every schedule: which robot picks which items in which order. Leaving as early as
/// possible is best for any of them, as who leaves earlier is free earlier.
///
/// Under noise a pick succeeds at departures at which the robot may leave, by the reported
/// position, and meets the item where it is. Where grasps fail, an item is picked after as
/// many failed attempts as its luck says.
struct Enumeration<'a> {
    scene: &'a Scene<'a>,
    /// For each robot the items where they are, with the departures that meet them.
    queues: Vec<Vec<Candidate>>,
    /// Attempts that each item takes.
    attempts: Vec<u32>,
    /// Attempts made so far.
    made: Vec<u32>,
    /// From when on each item can be attempted again [s].
    back: Vec<f64>,
    best: Optimum,
}

/// More attempts than this are not tried.
const MOST_ATTEMPTS: u32 = 3;

/// The best of all schedules on `scene`.
pub fn optimum(scene: &Scene) -> Optimum {
    let items = scene.pattern().items();
    let luck = &scene.conditions().disturbances;
    let attempts = |(item, index): (&Item, u32)| {
        let mut tries = 0..MOST_ATTEMPTS;
        let success = tries.find(|&attempt| luck.grasp_succeeds(index, item, attempt));
        success.map_or(u32::MAX, |attempt| attempt + 1)
    };
    let mut all = Enumeration {
        scene,
        queues: queues(scene),
        attempts: items.iter().zip(0..).map(attempts).collect(),
        made: vec![0; items.len()],
        back: vec![0.0; items.len()],
        best: Optimum {
            picks: 0,
            weight: 0.0,
            rate: 0.0,
            weighted_rate: 0.0,
            end: f64::INFINITY,
            all_end: None,
        },
    };
    if luck.grasp_failures {
        let robots = scene.station().robots().len();
        all.attempt(&mut vec![0.0; robots], 0.0);
    } else {
        all.robot(0, 0.0, 0.0);
    }
    all.best
}

/// The departures at which a robot may leave for an item and meets it.
fn queues(scene: &Scene) -> Vec<Vec<Candidate>> {
    let station = scene.station();
    let true_one = |robot: &Robot, seen: &Candidate| {
        let item = &scene.pattern().items()[seen.item as usize];
        let (open, close) = robot.departure_window(station.belt(), 0, item.x0, item.y)?;
        let candidate = Candidate {
            x0: item.x0,
            y: item.y,
            open: open.max(seen.open),
            close: close.min(seen.close),
            ..*seen
        };
        (candidate.open <= candidate.close).then_some(candidate)
    };
    let robots = station.robots().iter().enumerate();
    robots
        .map(|(r, robot)| {
            scene
                .queue(r)
                .iter()
                .filter_map(|seen| true_one(robot, seen))
                .collect()
        })
        .collect()
}

impl Enumeration<'_> {
    fn is_taken(&self, item: usize) -> bool {
        self.made[item] >= self.attempts[item]
    }

    /// All continuations with robot `robot`, free at `free`, and those after it.
    fn robot(&mut self, robot: usize, free: f64, last_release: f64) {
        if robot == self.queues.len() {
            return self.enter(last_release);
        }
        self.robot(robot + 1, 0.0, last_release);
        for place in 0..self.queues[robot].len() {
            let candidate = self.queues[robot][place];
            let (item, start) = (candidate.item as usize, free.max(candidate.open));
            if self.is_taken(item) || start > candidate.close {
                continue;
            }
            let moment = Moment::new(self.scene.station(), robot, 0, start);
            let release = start + moment.processing_time(&candidate);
            self.made[item] = 1;
            self.robot(robot, release, last_release.max(release));
            self.made[item] = 0;
        }
    }

    /// All attempts of all robots in every order, those that fail among them.
    fn attempt(&mut self, free: &mut Vec<f64>, last_release: f64) {
        self.enter(last_release);
        for robot in 0..free.len() {
            for place in 0..self.queues[robot].len() {
                let candidate = self.queues[robot][place];
                let item = candidate.item as usize;
                let start = free[robot].max(candidate.open).max(self.back[item]);
                if self.is_taken(item) || self.attempts[item] == u32::MAX || start > candidate.close
                {
                    continue;
                }
                let moment = Moment::new(self.scene.station(), robot, 0, start);
                let release = start + moment.processing_time(&candidate);
                let over = start + moment.travel_time(&candidate) + moment.robot.grasp_time;
                let before = (free[robot], self.back[item]);
                free[robot] = release;
                self.back[item] = over;
                self.made[item] += 1;
                self.attempt(free, last_release.max(release));
                self.made[item] -= 1;
                (free[robot], self.back[item]) = before;
            }
        }
    }

    fn enter(&mut self, last_release: f64) {
        let items = self.scene.pattern().items();
        let taken: Vec<bool> = (0..items.len()).map(|item| self.is_taken(item)).collect();
        let of = |wanted: bool| (0..items.len()).filter(move |&i| taken[i] == wanted);
        let left = of.clone()(false).map(|item| self.scene.leaves_belt(item));
        let figures = Figures {
            items: items.len(),
            picked: of.clone()(true).count(),
            weight: of.clone()(true).map(|item| items[item].reward()).sum(),
            end: left.fold(last_release, f64::max),
        };
        let best = &mut self.best;
        best.picks = best.picks.max(figures.picked);
        best.weight = best.weight.max(figures.weight);
        best.rate = best.rate.max(figures.picking_rate());
        best.weighted_rate = best.weighted_rate.max(figures.weighted_rate());
        best.end = best.end.min(figures.end);
        if figures.complete() {
            let all = best.all_end.unwrap_or(f64::INFINITY);
            best.all_end = Some(all.min(figures.end));
        }
    }
}

/// A sum of weights may differ by the order in which it was added up.
pub const SUMS: f64 = 1.0 + 1e-12;

/// Nothing in `best` is better than `bound` says. Picks are whole numbers, so for them that
/// holds to the last bit.
pub fn holds(bound: &Bound, best: &Optimum) {
    let about = format!("{bound:?}\n{best:?}");
    let (earned, rate, sums) = match bound.objective {
        BoundObjective::Picks => (best.picks as f64, best.rate, 1.0),
        BoundObjective::Weight => (best.weight, best.weighted_rate, SUMS),
    };
    assert!(earned <= bound.value * sums, "{about}");
    assert!(bound.value <= bound.relaxed, "{about}");
    assert!(bound.rate.is_none_or(|most| rate <= most * sums), "{about}");
    assert!(bound.end <= best.end, "{about}");
    if let Some(end) = best.all_end {
        assert!(bound.all_end.is_some_and(|least| least <= end), "{about}");
    }
}

/// Tiny lines of at most three robots and `items` items: as the other tests have them, and
/// with arms so slow and items so close together that robots compete.
pub fn tiny(items: usize) -> impl Strategy<Value = (Station, Pattern)> {
    let any = prop_oneof![common::stations(), common::lines()];
    let few = any.prop_filter("at most three robots", |s| s.robots().len() <= 3);
    let dwell = prop_oneof![Just(0.0), 0.0..30.0f64];
    let cases = few.prop_flat_map(move |station| {
        let pattern = common::patterns(station.belt().width, items);
        (Just(station), pattern)
    });
    (cases, dwell, 0.05..1.0f64).prop_map(|((station, pattern), dwell, squeeze)| {
        let robot = |robot: &Robot| Robot {
            grasp_time: robot.grasp_time + dwell,
            ..robot.clone()
        };
        let robots = station.robots().iter().map(robot).collect();
        let item = |item: &Item| Item {
            x0: item.x0 * squeeze,
            ..item.clone()
        };
        let items = pattern.items().iter().map(item).collect();
        let station = Station::new(*station.belt(), robots).unwrap();
        (station, Pattern::new(items).unwrap())
    })
}

/// The same scene where nothing goes wrong.
pub fn undisturbed<'a>(scene: &Scene<'a>, camera_x: Option<f64>) -> Scene<'a> {
    let mut conditions = scene.conditions().clone();
    conditions.disturbances = Disturbances::default();
    conditions.camera_x = camera_x;
    Scene::under(scene.station(), scene.pattern(), conditions).unwrap()
}
