//! How many items are known that are not there, and how many are there that are not known,
//! when the tracker makes mistakes.
#![allow(dead_code)]

use super::tracker::{Camera, Mistakes, PERIOD, Tracker, World};
use pickline::pattern::random_stream;
use pickline::station::{Overrides, load};
use pickline::strategies::read_alone;
use pickline_live::protocol::Incoming;
use pickline_live::{ClockKind, Config, Controller};

pub const TOLERANCES: [f64; 7] = [0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.05];
pub const DISTANCES: [f64; 6] = [0.02, 0.03, 0.04, 0.05, 0.1, 0.2];
const SPEED: f64 = 0.3;
/// An item is known where its gripper would find it [m].
const GRIP: f64 = 0.01;
/// Where it is asked for, after the camera [m].
const GATE: [f64; 2] = [0.2, 0.5];

/// What came of a run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Figures {
    pub items: usize,
    /// Known and not there.
    pub ghosts: usize,
    /// There and not known.
    pub lost: usize,
}

impl Figures {
    pub fn per_thousand(self, count: usize) -> f64 {
        1000.0 * count as f64 / self.items as f64
    }
}

/// Plays a tracker to a line on which nothing is picked, and compares what it knows of the
/// belt behind the camera with what is there.
pub fn play(
    tolerance: f64,
    apart: f64,
    camera: Camera,
    mistakes: Mistakes,
    items: usize,
    seed: u64,
) -> Figures {
    let overrides = Overrides::default().with_robots(2).with_belt_speed(SPEED);
    let station = load("paper", overrides).unwrap();
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config::default()
        .with_clock(ClockKind::Messages)
        .with_tolerance(tolerance);
    let mut controller = Controller::new(station, strategy, config).unwrap();
    let world = World::dense(items, apart, SPEED, seed);
    let mut tracker = Tracker::new(&world, camera, mistakes, random_stream(seed, 2));
    let mut figures = Figures::default();
    let every = (GATE[1] - GATE[0]) / SPEED;
    let mut asked = 0.0;
    let pictures = ((world.end() + 3.0) / PERIOD) as usize;
    for number in 0..pictures {
        let time = number as f64 * PERIOD;
        for message in tracker.picture(&world, time) {
            controller.handle(message).unwrap();
        }
        controller.handle(Incoming::Tick { stamp: time }).unwrap();
        controller.take_output();
        if time - asked >= every - 1e-9 {
            asked = time;
            compare(&controller, &world, time, &mut figures);
        }
    }
    figures
}

fn compare(controller: &Controller, world: &World, time: f64, figures: &mut Figures) {
    let near = |x: f64| (GATE[0] - GRIP..GATE[1] + GRIP).contains(&x);
    let inside = |x: f64| (GATE[0]..GATE[1]).contains(&x);
    let travel = world.travel(time);
    let truth = world.items.iter().map(|at| [at[0] + travel, at[1]]);
    let truth: Vec<[f64; 2]> = truth.filter(|at| near(at[0])).collect();
    let view = controller.view(0);
    let known = view.items.iter().map(|item| [item.x, item.y]);
    let known: Vec<[f64; 2]> = known.filter(|at| near(at[0])).collect();
    let mut pairs = Vec::new();
    for (i, a) in truth.iter().enumerate() {
        for (j, b) in known.iter().enumerate() {
            let way = (a[0] - b[0]).hypot(a[1] - b[1]);
            if way <= GRIP {
                pairs.push((way, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut found, mut explained) = (vec![false; truth.len()], vec![false; known.len()]);
    for (_, i, j) in pairs {
        if !found[i] && !explained[j] {
            (found[i], explained[j]) = (true, true);
        }
    }
    let missing = |at: &[[f64; 2]], met: &[bool]| {
        let both = at.iter().zip(met);
        both.filter(|(at, met)| inside(at[0]) && !**met).count()
    };
    figures.items += truth.iter().filter(|at| inside(at[0])).count();
    figures.lost += missing(&truth, &found);
    figures.ghosts += missing(&known, &explained);
}

pub fn total(runs: impl Iterator<Item = Figures>) -> Figures {
    runs.fold(Figures::default(), |all, one| Figures {
        items: all.items + one.items,
        ghosts: all.ghosts + one.ghosts,
        lost: all.lost + one.lost,
    })
}

/// Both cameras on a bad day.
pub const CAMERAS: [(Camera, Mistakes, &str); 2] = [
    (Camera::Area, Mistakes::BAD_DAY, "40 pictures of each item"),
    (
        Camera::Once,
        Mistakes::BAD_DAY_ONCE,
        "one picture of each item",
    ),
];

pub fn shown(figures: Figures) -> String {
    let (ghosts, lost) = (figures.ghosts, figures.lost);
    format!(
        "{:.1} + {:.1}",
        figures.per_thousand(ghosts),
        figures.per_thousand(lost)
    )
}

/// A cell of the tables in docs/live.md: ghosts and lost items of two worlds of 1,000 items.
pub fn cell(tolerance: f64, apart: f64, camera: Camera, mistakes: Mistakes) -> Figures {
    let runs = 1..=2;
    total(runs.map(|seed| play(tolerance, apart, camera, mistakes, 1000, seed)))
}
