//! What is really on the belt, and what became of it.

use crate::support::tracker::{UPSTREAM, World};
use pickline::pattern::random_stream;
use rand::RngExt as _;

/// How near to the gripper an item must be [m].
pub const GRASP: f64 = 0.005;

/// What became of an item.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fate {
    /// It is on the belt, or has left it at its end.
    OnBelt,
    /// A robot holds it.
    Held,
    /// It is in the bin of this robot.
    InBin(usize),
    /// A robot has dropped it beside the belt.
    Dropped,
}

/// What a robot finds where it closes its gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Found {
    /// An item.
    Item(usize),
    /// None, but there is one beside the gripper [m].
    Beside(f64),
    /// None: what was there is gone already.
    Taken,
    /// None, and there never was one.
    Nothing,
}

/// The belt with its items.
pub struct Truth {
    /// Where they are, and how the belt moves.
    pub world: World,
    pub fates: Vec<Fate>,
}

impl Truth {
    pub fn new(world: World) -> Self {
        let fates = vec![Fate::OnBelt; world.items.len()];
        Self { world, fates }
    }

    /// The item nearest to a place among those for which `counts` holds, and its distance.
    fn nearest(
        &self,
        at: [f64; 2],
        time: f64,
        counts: impl Fn(Fate) -> bool,
    ) -> Option<(usize, f64)> {
        let travel = self.world.travel(time);
        let items = self.world.items.iter().zip(&self.fates).enumerate();
        items
            .filter(|(_, (_, fate))| counts(**fate))
            .map(|(i, (item, _))| (i, (item[0] + travel - at[0]).hypot(item[1] - at[1])))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// What is at a place.
    pub fn find(&self, at: [f64; 2], time: f64) -> Found {
        let here = self.nearest(at, time, |fate| fate == Fate::OnBelt);
        let gone = self.nearest(at, time, |fate| fate != Fate::OnBelt);
        match (here, gone) {
            (Some((item, way)), _) if way <= GRASP => Found::Item(item),
            // Nearer than any two items are.
            (_, Some((_, way))) if way < 3.0 * GRASP => Found::Taken,
            (Some((_, way)), _) if way < 12.0 * GRASP => Found::Beside(way),
            _ => Found::Nothing,
        }
    }

    /// How many items are in the bin of a robot.
    pub fn in_bin(&self, robot: usize) -> usize {
        let fates = self.fates.iter();
        fates.filter(|fate| **fate == Fate::InBin(robot)).count()
    }
}

/// Items at random, none nearer to another than `apart` [m], on average one every `gap` [m]
/// of a belt with these speeds.
pub fn scatter(count: usize, gap: f64, apart: f64, speeds: Vec<(f64, f64)>, seed: u64) -> World {
    let mut rng = random_stream(seed, 3);
    let half_width = 0.25;
    let mut items: Vec<[f64; 2]> = Vec::new();
    let mut x = UPSTREAM;
    while items.len() < count {
        let share: f64 = rng.random();
        x += gap * (1.0 - share).ln();
        let y = rng.random_range(-half_width..half_width);
        let mut near = items.iter().rev().take(20);
        if near.all(|at| (at[0] - x).hypot(at[1] - y) >= apart) {
            items.push([x, y]);
        }
    }
    World {
        items,
        speeds,
        half_width,
    }
}

/// A belt that goes from speed to speed at 1 m/s^2; each with the time for which it holds
/// [m/s, s]. The last one holds for ever.
pub fn program(start: f64, stretches: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const STEP: f64 = 0.01;
    let mut speeds = vec![(start, stretches[0].0)];
    let (mut time, mut speed) = (start, stretches[0].0);
    for (target, lasts) in stretches {
        while (target - speed).abs() > 1e-9 {
            speed += (target - speed).clamp(-STEP, STEP);
            speeds.push((time, speed));
            time += STEP;
        }
        time += lasts;
    }
    speeds
}
