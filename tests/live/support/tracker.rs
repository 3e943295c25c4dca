//! A camera with a tracker behind it that makes the mistakes of real ones, over a belt of
//! which the truth is known.
#![allow(dead_code)]

use pickline::pattern::random_stream;
use pickline_live::protocol::{Detection, Incoming};
use rand::{Rng, RngExt as _};
use std::f64::consts::TAU;

/// What goes wrong.
#[derive(Debug, Clone, Copy)]
pub struct Mistakes {
    /// Standard deviation of a position, along and across the belt [m].
    pub jitter: f64,
    /// Share of detections that are missing.
    pub lost: f64,
    /// Share of items that are not seen for 0.3 s to 1 s on their way.
    pub gaps: f64,
    /// An item that was not seen for so long has another id then [s].
    pub memory: f64,
    /// Share of detections that swap ids with the nearest item.
    pub swapped: f64,
    /// Share of detections from which on the item has another id.
    pub renumbered: f64,
    /// Time between two restarts of the tracker, which counts from 1 again [s].
    pub restarts: f64,
    /// Share of detections that come twice, under two ids or one.
    pub doubled: f64,
    /// Standard deviation of the second box from the first, along and across [m].
    pub double_off: f64,
    /// Detections of nothing, for each detection of an item.
    pub false_positives: f64,
}

impl Mistakes {
    /// A tracker that makes none.
    pub const NONE: Self = Self {
        jitter: 0.0,
        lost: 0.0,
        gaps: 0.0,
        memory: f64::INFINITY,
        swapped: 0.0,
        renumbered: 0.0,
        restarts: f64::INFINITY,
        doubled: 0.0,
        double_off: 0.0,
        false_positives: 0.0,
    };

    /// A tracker on a bad day: 40 pictures of each item, in which are 5 items in 1,000 that are
    /// not there.
    pub const BAD_DAY: Self = Self {
        jitter: 0.002,
        lost: 0.1,
        gaps: 0.1,
        memory: 0.5,
        swapped: 0.002,
        renumbered: 0.002,
        restarts: 10.0,
        doubled: 0.01,
        double_off: 0.002,
        false_positives: 0.000_125,
    };

    /// The same for a camera that sees each item once: what it does not see, nobody can know.
    pub const BAD_DAY_ONCE: Self = Self {
        lost: 0.0,
        gaps: 0.0,
        false_positives: 0.005,
        ..Self::BAD_DAY
    };
}

/// Time between two pictures [s].
pub const PERIOD: f64 = 0.05;
/// Where the belt is seen that long before an item is at its start [m]; items come from there.
pub const UPSTREAM: f64 = -0.6;

/// What a picture shows of the belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Camera {
    /// The 0.6 m upstream of the belt's start: each item is in many pictures.
    Area,
    /// As much as passes between two pictures: each item is in one.
    Once,
}

/// Items on a belt, with their x before it has moved.
#[derive(Debug, Clone)]
pub struct World {
    /// Places, downstream first [m].
    pub items: Vec<[f64; 2]>,
    /// Speeds of the belt, each with the time from which on it holds [s, m/s]. It has not
    /// moved before the first.
    pub speeds: Vec<(f64, f64)>,
    /// Half of the width in which they lie [m].
    pub half_width: f64,
}

impl World {
    /// `count` items, none nearer to another than `apart` [m], as dense as they fall, in a
    /// lane four such distances wide.
    pub fn dense(count: usize, apart: f64, speed: f64, seed: u64) -> Self {
        let mut rng = random_stream(seed, 1);
        let half_width = (2.0 * apart).min(0.5);
        let mut items: Vec<[f64; 2]> = Vec::new();
        let mut front = UPSTREAM;
        while items.len() < count {
            // A strip as long as the distance is filled until nothing fits.
            let mut failures = 0;
            while failures < 60 && items.len() < count {
                let x = front - rng.random_range(0.0..apart);
                let y = rng.random_range(-half_width..half_width);
                let mut near = items.iter().rev().take(60);
                if near.all(|at| (at[0] - x).hypot(at[1] - y) >= apart) {
                    items.push([x, y]);
                    failures = 0;
                } else {
                    failures += 1;
                }
            }
            front -= apart;
        }
        items.sort_by(|a, b| b[0].total_cmp(&a[0]));
        Self {
            items,
            speeds: vec![(0.0, speed)],
            half_width,
        }
    }

    /// How far the belt has gone by `time` [m].
    pub fn travel(&self, time: f64) -> f64 {
        let ends = self.speeds.iter().skip(1).map(|next| next.0);
        let stretches = self.speeds.iter().zip(ends.chain([f64::INFINITY]));
        let gone = stretches.map(|((from, speed), end)| speed * (time.min(end) - from).max(0.0));
        gone.sum()
    }

    /// When the belt has gone `travel` [m] [s].
    pub fn time_at(&self, travel: f64) -> f64 {
        let mut gone = 0.0;
        for pair in self.speeds.windows(2) {
            let next = gone + pair[0].1 * (pair[1].0 - pair[0].0);
            if travel < next {
                return pair[0].0 + (travel - gone) / pair[0].1;
            }
            gone = next;
        }
        let last = self.speeds[self.speeds.len() - 1];
        last.0 + (travel - gone) / last.1
    }

    /// Speed of the belt at `time` [m/s].
    pub fn speed(&self, time: f64) -> f64 {
        let holds = self.speeds.iter().rev().find(|(from, _)| *from <= time);
        holds.map_or(0.0, |(_, speed)| *speed)
    }

    /// Where an item is at `time` [m].
    pub fn place(&self, item: usize, time: f64) -> [f64; 2] {
        let at = self.items[item];
        [at[0] + self.travel(time), at[1]]
    }

    /// When the last item has left the picture [s].
    pub fn end(&self) -> f64 {
        let last = self.items.last().map_or(0.0, |at| at[0]);
        self.time_at(-last)
    }
}

/// The tracker.
pub struct Tracker<R> {
    camera: Camera,
    mistakes: Mistakes,
    rng: R,
    next_id: u64,
    /// Id of each item, and when it was seen last [s].
    tracks: Vec<Option<(u64, f64)>>,
    /// When each item is not seen [s].
    hidden: Vec<(f64, f64)>,
    restarted: f64,
}

impl<R: Rng> Tracker<R> {
    pub fn new(world: &World, camera: Camera, mistakes: Mistakes, mut rng: R) -> Self {
        let hidden = world.items.iter().map(|at| {
            let enters = world.time_at(UPSTREAM - at[0]);
            let stays = world.time_at(-at[0]) - enters;
            if rng.random::<f64>() < mistakes.gaps {
                let from = enters + rng.random_range(0.0..stays);
                (from, from + rng.random_range(0.3..1.0))
            } else {
                (f64::INFINITY, f64::INFINITY)
            }
        });
        let hidden = hidden.collect();
        Self {
            camera,
            mistakes,
            rng,
            next_id: 1,
            tracks: vec![None; world.items.len()],
            hidden,
            restarted: 0.0,
        }
    }

    fn happens(&mut self, share: f64) -> bool {
        self.rng.random::<f64>() < share
    }

    fn error(&mut self, deviation: f64) -> [f64; 2] {
        let (a, b): (f64, f64) = (self.rng.random(), self.rng.random());
        let radius = deviation * (-2.0 * (1.0 - a).ln()).sqrt();
        [radius * (TAU * b).cos(), radius * (TAU * b).sin()]
    }

    fn fresh(&mut self) -> u64 {
        self.next_id += 1;
        self.next_id - 1
    }

    /// The picture taken at `time` [s].
    pub fn picture(&mut self, world: &World, time: f64) -> Vec<Incoming> {
        if time - self.restarted >= self.mistakes.restarts {
            self.restarted = time;
            self.next_id = 1;
            self.tracks.fill(None);
        }
        let from = match self.camera {
            Camera::Area => UPSTREAM,
            Camera::Once => -world.speed(time) * PERIOD,
        };
        let mut seen: Vec<(usize, [f64; 2])> = Vec::new();
        let travel = world.travel(time);
        for (item, at) in world.items.iter().enumerate() {
            let x = at[0] + travel;
            let is_hidden = (self.hidden[item].0..self.hidden[item].1).contains(&time);
            if !(from..0.0).contains(&x) || is_hidden || self.happens(self.mistakes.lost) {
                continue;
            }
            let off = self.error(self.mistakes.jitter);
            seen.push((item, [x + off[0], at[1] + off[1]]));
            let remembered = self.tracks[item].filter(|t| time - t.1 <= self.mistakes.memory);
            let id = match remembered {
                Some((id, _)) if !self.happens(self.mistakes.renumbered) => id,
                _ => self.fresh(),
            };
            self.tracks[item] = Some((id, time));
        }
        for index in 0..seen.len() {
            if self.happens(self.mistakes.swapped) {
                let (item, at) = seen[index];
                let others = seen.iter().filter(|other| other.0 != item);
                let way = |other: &[f64; 2]| (other[0] - at[0]).hypot(other[1] - at[1]);
                let other = others.min_by(|a, b| way(&a.1).total_cmp(&way(&b.1)));
                if let Some((other, _)) = other.copied() {
                    self.tracks.swap(item, other);
                }
            }
        }
        let mut picture = Vec::new();
        for (item, at) in seen {
            let id = self.tracks[item].map(|track| track.0);
            picture.push(detection(time, at, id));
            if self.happens(self.mistakes.doubled) {
                let off = self.error(self.mistakes.double_off);
                let second = if self.happens(0.5) {
                    Some(self.fresh())
                } else {
                    None
                };
                picture.push(detection(time, [at[0] + off[0], at[1] + off[1]], second));
            }
            if self.happens(self.mistakes.false_positives) {
                let x = self.rng.random_range(from..0.0);
                let y = self.rng.random_range(-world.half_width..world.half_width);
                let id = self.fresh();
                picture.push(detection(time, [x, y], Some(id)));
            }
        }
        picture
    }
}

fn detection(stamp: f64, at: [f64; 2], id: Option<u64>) -> Incoming {
    Incoming::Detection(Detection {
        stamp,
        id: id.map(|id| id.to_string()),
        x: at[0],
        y: at[1],
        ..Detection::default()
    })
}
