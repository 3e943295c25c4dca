//! Films of belts of which the truth is known.

use pickline::pattern::{Item, Pattern, random_stream};
use rand::{Rng, RngExt as _};
use std::fmt::Write as _;
use std::ops::RangeInclusive;

/// Items on a belt, before it moves.
struct Belt {
    ids: RangeInclusive<u32>,
    /// From one item to the next along the belt, and up to how much more [m].
    pitch: f64,
    slack: f64,
    /// They lie within half of it to both sides of the belt's middle [m].
    width: f64,
    seed: u64,
}

/// An item in a frame: where it lay before the belt moved [m].
struct Sight {
    id: u32,
    frame: u32,
    x0: f64,
    y: f64,
}

impl Belt {
    /// Shows every item in every frame.
    fn film(&self, frames: RangeInclusive<u32>, mut see: impl FnMut(&mut dyn Rng, Sight)) {
        let mut rng = random_stream(self.seed, 0);
        for id in self.ids.clone() {
            let x0 = -self.pitch * f64::from(id) - self.slack * rng.random::<f64>();
            let y = self.width * (rng.random::<f64>() - 0.5);
            for frame in frames.clone() {
                see(&mut rng, Sight { id, frame, x0, y });
            }
        }
    }
}

/// A camera above a belt at 0.25 m/s, 25 frames a second, 2 mm a pixel, 1280 x 600 pixels.
#[derive(Clone, Copy)]
pub struct Film {
    /// How far the travel is turned from image x, clockwise on the screen [degrees].
    pub angle: f64,
    /// Radial distortion: by this share inward at half the picture's width.
    pub barrel: f64,
    /// By this share larger at the right edge than in the middle.
    pub tilt: f64,
    pub corners: bool,
    /// Whether the tracker sees every other item in the picture's left half only and the
    /// others in the right: over the whole picture the errors of a lens cancel out.
    pub halves: bool,
}

pub const STRAIGHT: Film = Film {
    angle: 0.0,
    barrel: 0.0,
    tilt: 0.0,
    corners: false,
    halves: false,
};

impl Film {
    /// What a tracker writes of it, and the true pattern.
    pub fn shoot(&self) -> (String, Pattern) {
        let (sine, cosine) = self.angle.to_radians().sin_cos();
        let mut text = String::new();
        let mut items = Vec::new();
        let belt = Belt {
            ids: 1..=60,
            pitch: 0.08,
            slack: 0.05,
            width: 0.8,
            seed: 7,
        };
        let moved = |frame| 0.01 * f64::from(frame - 1);
        belt.film(1..=1000, |rng, sight| {
            let Sight { id, frame, x0, y } = sight;
            if frame == 1 {
                items.push(Item::at(id.to_string(), x0, y));
            }
            // From the middle of the picture, x along the travel, y down.
            let along = (x0 + moved(frame)) / 0.002 - 640.0;
            let aside = -y / 0.002;
            let (u, v) = (cosine * along - sine * aside, sine * along + cosine * aside);
            if self.halves && (along < 0.0) != (id % 2 == 0) {
                return;
            }
            let near = 1.0 + self.tilt * u / 640.0;
            let (u, v) = (u * near, v * near);
            let shrink = 1.0 - self.barrel * (u * u + v * v) / (640.0 * 640.0);
            let (u, v) = (u * shrink, v * shrink);
            let mut noise = || 0.6 * (rng.random::<f64>() - 0.5);
            let (x, y) = (u + 640.0 + noise(), v + 300.0 + noise());
            if !(20.0..1260.0).contains(&x) || !(-200.0..800.0).contains(&y) {
                return;
            }
            let (left, top) = (x - 20.0, y - 15.0);
            let (w, h) = if self.corners {
                (left + 40.0, top + 30.0)
            } else {
                (40.0, 30.0)
            };
            let _ = writeln!(
                text,
                "{frame},{id},{left:.2},{top:.2},{w:.2},{h:.2},0.9,-1,-1,-1"
            );
        });
        let first = items
            .iter()
            .map(|item| item.x0)
            .fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = items
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), item| {
                (l.min(item.y), h.max(item.y))
            });
        for item in &mut items {
            item.x0 -= first;
            item.y -= f64::midpoint(low, high);
        }
        (text, Pattern::new(items).unwrap())
    }
}

/// COCO's detections, without ids, of 30 items on a belt at 0.2 m/s, 20 frames a second, 1 mm
/// a pixel, whose travel is turned by quarter turns; `sparse` keeps every third item.
pub fn detections(turns: usize, sparse: bool, corners: bool) -> String {
    let belt = Belt {
        ids: 0..=29,
        pitch: 0.12,
        slack: 0.1,
        width: 0.4,
        seed: 3,
    };
    let mut boxes = Vec::new();
    let moved = |frame| 0.01 * f64::from(frame);
    belt.film(1..=599, |_, sight| {
        let Sight { id, frame, x0, y } = sight;
        let along = (x0 + moved(frame)) / 0.001;
        if !(20.0..980.0).contains(&along) || (sparse && id % 3 > 0) {
            return;
        }
        let across = 500.0 + y / 0.001;
        let (x, y) = match turns {
            0 => (along, across),
            1 => (across, along),
            2 => (1000.0 - along, across),
            _ => (across, 1000.0 - along),
        };
        let (left, top) = (x - 20.0, y - 15.0);
        let (w, h) = match corners {
            true => (x + 20.0, y + 15.0),
            false => (40.0, 30.0),
        };
        boxes.push(serde_json::json!({
            "image_id": frame, "category_id": 0, "bbox": [left, top, w, h], "score": 0.9
        }));
    });
    serde_json::Value::from(boxes).to_string()
}

/// A tracker's text of `items` on a belt that has moved by `moved` metres at a time [s], at
/// 0.2 m/s and 20 frames a second, 1 mm a pixel.
pub fn moving_film(items: u32, moved: impl Fn(f64) -> f64) -> String {
    let belt = Belt {
        ids: 1..=items,
        pitch: 0.1,
        slack: 0.05,
        width: 0.8,
        seed: 5,
    };
    let mut text = String::new();
    belt.film(1..=1999, |rng, sight| {
        let Sight { id, frame, x0, y } = sight;
        let along = (x0 + moved(f64::from(frame - 1) / 20.0)) / 0.001;
        let top = 400.0 + y / 0.001;
        let mut noise = || rng.random::<f64>() - 0.5;
        let (left, top) = (along + noise(), top + noise());
        if (0.0..1500.0).contains(&left) {
            let _ = writeln!(text, "{frame},{id},{left:.2},{top:.2},40,30,0.9,-1,-1,-1");
        }
    });
    text
}
