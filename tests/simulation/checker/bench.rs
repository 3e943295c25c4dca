//! A station and a run on it that is put together by hand, trip by trip, so that it can be
//! bent in one respect and stay right in all others.

use nalgebra::Point2;
use pickline::decision::{
    Failure, FailureCause, Figures, Miss, MissReason, Outcome, Pick, RobotFigures,
};
use pickline::pattern::{Item, Pattern};
use pickline::station::{Belt, Robot, Station};

pub struct Bench {
    pub station: Station,
    pub pattern: Pattern,
}

/// What was done and what was not; figures follow from it.
#[derive(Clone)]
pub struct Draft {
    pub picks: Vec<Pick>,
    pub failures: Vec<Failure>,
    pub missed: Vec<Miss>,
}

pub const BELT: Belt = Belt {
    speed: 0.3,
    length: 3.0,
    width: 1.0,
};

/// A robot at the middle of [`BELT`], at y = -0.6 m.
pub fn front() -> Robot {
    Robot::new(
        "front",
        Point2::new(1.5, -0.6),
        Point2::new(1.5, -0.5),
        0.9,
        pickline::kinematics::Arm::constant(0.9),
    )
    .with_dwell(0.2, 0.1)
}

/// The robot on the other side.
pub fn back() -> Robot {
    Robot {
        name: "back".into(),
        base: Point2::new(1.5, 0.6),
        ..front()
    }
    .with_only_bin(Point2::new(1.5, 0.5))
}

pub fn item(index: usize, x0: f64, y: f64) -> Item {
    Item {
        weight: Some(0.25 * (index + 1) as f64),
        ..Item::at(index.to_string(), x0, y)
    }
}

/// Nothing is done, and the items are missed for these reasons.
pub fn idle(reasons: &[MissReason]) -> Draft {
    let missed = reasons.iter().zip(0..);
    let missed = missed.map(|(&reason, item)| Miss { item, reason });
    Draft {
        picks: Vec::new(),
        failures: Vec::new(),
        missed: missed.collect(),
    }
}

impl Bench {
    pub fn of(belt: Belt, robots: Vec<Robot>, items: &[(f64, f64)]) -> Self {
        let items = items.iter().enumerate();
        let items = items.map(|(i, &(x0, y))| item(i, x0, y)).collect();
        Self {
            station: Station::new(belt, robots).unwrap(),
            pattern: Pattern::new(items).unwrap(),
        }
    }

    /// Two robots that face each other, and seven items.
    pub fn new() -> Self {
        let items = [
            (0.0, -0.2),
            (-0.1, 0.2),
            (-1.5, -0.2),
            (-1.6, 0.2),
            (-3.0, 0.0),
            (-4.5, 0.0),
            (-6.0, 0.1),
        ];
        Self::of(BELT, vec![front(), back()], &items)
    }

    /// `front` picks 0, 2 and 4, `back` picks 1 and 3. At item 4 `back` has failed before, and
    /// at item 5 both fail, first `front`. Nobody leaves for item 6.
    pub fn run(&self) -> Draft {
        Draft {
            picks: vec![
                self.pick(0, 0, 1.5),
                self.pick(1, 1, 1.5),
                self.pick(0, 2, 1.5),
                self.pick(1, 3, 1.5),
                self.pick(0, 4, 1.7),
            ],
            failures: vec![
                self.failure(1, 4, 1.1),
                self.failure(0, 5, 1.3),
                self.failure(1, 5, 1.6),
            ],
            missed: vec![
                Miss {
                    item: 5,
                    reason: MissReason::GraspFailed,
                },
                Miss {
                    item: 6,
                    reason: MissReason::Busy,
                },
            ],
        }
    }

    /// A way to `meet` that the robot reaches at `grasp` [s].
    pub fn trip(&self, robot: usize, item: u32, meet: Point2<f64>, grasp: f64) -> Pick {
        let of = &self.station.robots()[robot];
        let out = (meet - of.bins[0].at).norm() / of.arm.constant_speed().unwrap();
        Pick {
            robot,
            item,
            bin: 0,
            decide: grasp - out,
            grasp,
            release: grasp + of.grasp_time + out + of.bins[0].release_time,
            meet,
        }
    }

    /// The robot meets the item at `x` [m].
    pub fn pick(&self, robot: usize, item: u32, x: f64) -> Pick {
        let it = &self.pattern.items()[item as usize];
        let grasp = (x - it.x0) / self.station.belt().speed;
        self.trip(robot, item, Point2::new(x, it.y), grasp)
    }

    /// The robot leaves for the item at `decide` [s]: the meeting point of docs/model.md.
    pub fn leave(&self, robot: usize, item: u32, decide: f64) -> Pick {
        let of = &self.station.robots()[robot];
        let it = &self.pattern.items()[item as usize];
        let (v, u) = (self.station.belt().speed, of.arm.constant_speed().unwrap());
        let (dx, dy) = (it.x0 + v * decide - of.bins[0].at.x, it.y - of.bins[0].at.y);
        let k = u * u - v * v;
        let tau = (v * dx + (v * v * dx * dx + k * (dx * dx + dy * dy)).sqrt()) / k;
        let meet = Point2::new(it.x0 + v * (decide + tau), it.y);
        Pick {
            decide,
            ..self.trip(robot, item, meet, decide + tau)
        }
    }

    /// The robot meets the item at `x` [m], and does not get hold of it.
    pub fn failure(&self, robot: usize, item: u32, x: f64) -> Failure {
        Failure {
            attempt: self.pick(robot, item, x),
            cause: FailureCause::Grasp,
        }
    }

    /// The robot leaves when it could meet the item at `x` [m], or past it, but goes to `to`.
    pub fn vain_way(&self, robot: usize, item: u32, x: f64, to: Point2<f64>) -> Failure {
        let decide = self.pick(robot, item, x).decide;
        let of = &self.station.robots()[robot];
        let grasp = decide + (to - of.bins[0].at).norm() / of.arm.constant_speed().unwrap();
        Failure {
            attempt: self.trip(robot, item, to, grasp),
            cause: FailureCause::OutOfReach,
        }
    }

    /// The run with the figures that follow from it.
    pub fn finish(&self, draft: Draft) -> Outcome {
        let items = self.pattern.items();
        let belt = self.station.belt();
        let mut robots = vec![RobotFigures::default(); self.station.robots().len()];
        let mut end: f64 = 0.0;
        let failed = draft.failures.iter().map(|f| (&f.attempt, false));
        let picked = draft.picks.iter().map(|pick| (pick, true));
        for (trip, picked) in picked.chain(failed) {
            end = end.max(trip.release);
            // A robot or an item that is not there has no figures.
            if let Some(robot) = robots.get_mut(trip.robot) {
                robot.busy += trip.release - trip.decide;
                robot.picked += usize::from(picked);
                robot.failed += usize::from(!picked);
                if let Some(item) = items.get(trip.item as usize).filter(|_| picked) {
                    robot.weight += item.weight.unwrap();
                }
            }
        }
        for miss in &draft.missed {
            end = end.max((belt.length - items[miss.item as usize].x0) / belt.speed);
        }
        Outcome {
            downtimes: Vec::new(),
            figures: Figures {
                items: items.len(),
                picked: draft.picks.len(),
                weight: robots.iter().map(|robot| robot.weight).sum(),
                end,
            },
            robots,
            picks: draft.picks,
            failures: draft.failures,
            missed: draft.missed,
            left: Vec::new(),
        }
    }
}
