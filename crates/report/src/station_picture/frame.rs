//! Where everything is in the picture: scale, rows, and places of the labels.

use super::labels::label_width;
use pickline::station::{Robot, Station};

/// Width of the drawing area [px], and its maximum height in one row and in total.
pub(super) const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 560.0;
/// Space left and right of the drawing area, for the axis across and the belt's width [px].
pub(super) const LEFT: f64 = 56.0;
pub(super) const RIGHT: f64 = 58.0;
/// From the belt down to the end of the camera's label [px].
const CAMERA: f64 = 22.0;
/// Space for the axis below a row and the header above all rows [px].
const AXIS: f64 = 46.0;
const HEAD: f64 = 46.0;
/// Height of a robot's name and reach, and their distance from the base [px].
const LABEL: f64 = 30.0;
const TO_LABEL: f64 = 12.0;
/// Levels of labels for robots that stand close to each other.
const LEVELS: usize = 3;
/// Share of the line's length kept free before and after it.
const ROOM: f64 = 0.04;
/// A line lower than this [px] is broken into rows, at most this many, which overlap by this
/// much [px].
const LOWEST: f64 = 110.0;
const MOST_ROWS: f64 = 6.0;
const OVERLAP: f64 = 36.0;

/// From the belt frame [m] to the picture [px]: x to the right, y upwards. If the line is
/// broken into rows, this is the first row, as long as the whole line.
pub(super) struct Frame {
    pub left: f64,
    pub right: f64,
    pub bottom: f64,
    pub top: f64,
    pub scale: f64,
    pub rows: usize,
    /// Space for labels above and below the line [px].
    room: [f64; 2],
    /// Position of each robot's label: middle and upper baseline [px].
    pub labels: Vec<(f64, f64)>,
}

impl Frame {
    pub(super) fn around(station: &Station, camera: Option<f64>) -> Self {
        let belt = station.belt();
        let all = |r: &Robot| {
            [r.base, r.rest]
                .into_iter()
                .chain(r.bins.iter().map(|bin| bin.at))
                .collect::<Vec<_>>()
        };
        let places = || station.robots().iter().flat_map(all);
        let with_camera = camera.is_some();
        let camera = camera.unwrap_or(0.0);
        let low = places().map(|p| p.x).fold(camera.min(0.0), f64::min);
        let high = places()
            .map(|p| p.x)
            .fold(camera.max(belt.length), f64::max);
        let room = ROOM * (high - low);
        let (left, right) = (low - room, high + room);
        let half = 0.5 * belt.width;
        let bottom = places().map(|p| p.y).fold(-half, f64::min);
        let top = places().map(|p| p.y).fold(half, f64::max);
        let (length, height) = (right - left, top - bottom);
        let one = (WIDTH / length).min(HEIGHT / height);
        let rows = (LOWEST / (one * height)).ceil().clamp(1.0, MOST_ROWS);
        let scale = match rows as usize {
            1 => one,
            _ => ((rows * WIDTH - (rows - 1.0) * 2.0 * OVERLAP) / length).min(HEIGHT / height),
        };
        let mut frame = Self {
            left,
            right,
            bottom,
            top,
            scale,
            rows: rows as usize,
            room: [0.0; 2],
            labels: Vec::new(),
        };
        frame.place_labels(station, with_camera);
        frame
    }

    /// Places names beyond the bases, on as many levels as needed to keep them apart.
    fn place_labels(&mut self, station: &Station, with_camera: bool) {
        // Ends of the labels on each level, above and below.
        let mut ends = [[f64::NEG_INFINITY; LEVELS]; 2];
        let mut places = Vec::new();
        for robot in station.robots() {
            let side = usize::from(robot.base.y < 0.0);
            let half = 0.5 * label_width(robot);
            let middle = self.x(robot.base.x);
            let free = ends[side].iter().position(|end| *end + 8.0 < middle - half);
            let level = free.unwrap_or(LEVELS - 1);
            ends[side][level] = middle + half;
            self.room[side] = self.room[side].max((level + 1) as f64 * LABEL + TO_LABEL);
            places.push((middle, side, level));
        }
        // The arrow of travel is always above the belt.
        self.room[0] = self.room[0].max(LABEL);
        // The camera's label is below the belt.
        let below = if with_camera { CAMERA } else { TO_LABEL };
        self.room[1] = self.room[1].max(below);
        let (upper, lower) = (self.y(self.top), self.y(self.bottom));
        self.labels = places
            .into_iter()
            .map(|(middle, side, level)| {
                let away = TO_LABEL + level as f64 * LABEL;
                let y = match side {
                    0 => upper - away - LABEL + 13.0,
                    _ => lower + away + 13.0,
                };
                (middle, y)
            })
            .collect();
    }

    pub(super) fn row_height(&self) -> f64 {
        (self.top - self.bottom) * self.scale + self.room[0] + self.room[1]
    }

    pub(super) fn row_top(&self, row: usize) -> f64 {
        HEAD + row as f64 * (self.row_height() + AXIS)
    }

    /// Shift of a row to the left, relative to the first [px].
    pub(super) fn shift(&self, row: usize) -> f64 {
        row as f64 * (WIDTH - 2.0 * OVERLAP)
    }

    /// The row that names a robot. `middle` is the middle of its label in the first row (as
    /// long as the whole line) and `width` the label's width [px].
    pub(super) fn row_of_label(&self, middle: f64, width: f64) -> usize {
        let inside = |row: &usize, room: f64| {
            let x = middle - self.shift(*row);
            (LEFT + room..=LEFT + WIDTH - room).contains(&x)
        };
        let mut rows = (0..self.rows).filter(|row| inside(row, 0.0));
        let first = rows.next().unwrap_or(0);
        let fits = inside(&first, 0.5 * width);
        rows.find(|row| !fits && inside(row, 0.5 * width))
            .unwrap_or(first)
    }

    /// The part of the line that a row shows [m].
    pub(super) fn span(&self, row: usize) -> [f64; 2] {
        let left = self.left + self.shift(row) / self.scale;
        [left, (left + WIDTH / self.scale).min(self.right)]
    }

    pub(super) fn size(&self) -> (f64, f64) {
        (LEFT + WIDTH + RIGHT, self.row_top(self.rows))
    }

    pub(super) fn x(&self, x: f64) -> f64 {
        // A short line is centred.
        let free = match self.rows {
            1 => 0.5 * (WIDTH - (self.right - self.left) * self.scale),
            _ => 0.0,
        };
        LEFT + free + (x - self.left) * self.scale
    }

    pub(super) fn y(&self, y: f64) -> f64 {
        HEAD + self.room[0] + (self.top - y) * self.scale
    }
}
