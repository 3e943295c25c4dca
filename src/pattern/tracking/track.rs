//! Tracks: the boxes with one id, and where and how fast they are.

use super::formats::FileRow;
use super::median::{median, median_of};
use super::options::{ImageAxis, ImportOptions};

/// Up to this many boxes, the speed is estimated from all pairs. Beyond it, the cost would grow
/// quadratically although the estimate is already good.
const ALL_PAIRS: usize = 32;

/// A box of a track.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoxSighting {
    /// Frame, from 1.
    pub frame: u32,
    /// Line of the file, from 1.
    pub line: usize,
    /// Centre of the box along the travel, growing with it [px].
    pub along: f64,
    /// Centre of the box across the travel, as the image counts it [px].
    pub across: f64,
    /// Size of the box along and across the travel [px]; `None` for a point.
    pub size: Option<(f64, f64)>,
    /// Confidence in the file, possibly outside 0 to 1.
    pub confidence: Option<f64>,
    /// Class of the object, if given.
    pub class: Option<String>,
}

impl BoxSighting {
    /// The box of `row`, from this line of the file.
    pub(super) fn new(row: FileRow, line: usize, options: &ImportOptions) -> Self {
        let (width, height) = row.size.unwrap_or_default();
        let (x, y) = (row.left + width / 2.0, row.top + height / 2.0);
        let (along, across) = options.turned(x, y);
        let swapped = options.axis == ImageAxis::Y;
        Self {
            frame: row.frame,
            line,
            along,
            across,
            size: row.size.map(|(w, h)| if swapped { (h, w) } else { (w, h) }),
            confidence: row.confidence,
            class: row.class,
        }
    }

    /// Area of the box [px^2]; `None` for a point.
    pub(super) fn area(&self) -> Option<f64> {
        self.size.map(|(along, across)| along * across)
    }
}

/// The boxes with one id, by frame; never empty, and no repeated frames.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Track {
    pub name: String,
    pub sightings: Vec<BoxSighting>,
}

/// Time between two frames [s].
pub(super) fn seconds(from: &BoxSighting, to: &BoxSighting, options: &ImportOptions) -> f64 {
    (f64::from(to.frame) - f64::from(from.frame)) / options.fps
}

/// Travel between two boxes [m].
pub(super) fn travel(from: &BoxSighting, to: &BoxSighting, options: &ImportOptions) -> f64 {
    (to.along - from.along) * options.scale_m_per_px
}

/// Speed along the travel between two boxes [m/s].
pub(super) fn speed_between(from: &BoxSighting, to: &BoxSighting, options: &ImportOptions) -> f64 {
    travel(from, to, options) / seconds(from, to, options)
}

impl Track {
    /// The first and the last frame.
    pub(super) fn span(&self) -> (u32, u32) {
        let frame = |sighting: Option<&BoxSighting>| sighting.map_or(0, |s| s.frame);
        (frame(self.sightings.first()), frame(self.sightings.last()))
    }

    /// Time from the first box to the last [s].
    pub(super) fn duration(&self, options: &ImportOptions) -> f64 {
        let (first, last) = self.span();
        f64::from(last.saturating_sub(first)) / options.fps
    }

    /// Position along the travel at time 0 [m]: the median over its boxes.
    pub(super) fn x0(&self, options: &ImportOptions) -> f64 {
        let at_start = |s: &BoxSighting| {
            let time = (f64::from(s.frame) - 1.0) / options.fps;
            s.along * options.scale_m_per_px - options.belt_speed * time
        };
        median(&mut self.sightings.iter().map(at_start).collect::<Vec<_>>())
    }

    /// Position across the travel, as the image counts it [px]: the median over its boxes.
    pub(super) fn across(&self) -> f64 {
        median(&mut self.sightings.iter().map(|s| s.across).collect::<Vec<_>>())
    }

    /// Speed along the travel [m/s]: the median of the slopes between pairs of boxes (Theil 1950;
    /// Sen 1968, doi:10.1080/01621459.1968.10480934). In a long track every box is paired only with
    /// the one half the track later, which takes linear time. `None` for a single box.
    pub(super) fn speed(&self, options: &ImportOptions) -> Option<f64> {
        let pairs = pairs(&self.sightings).into_iter();
        median_of(pairs.map(|(from, to)| speed_between(from, to, options)))
    }
}

/// The pairs of boxes whose slopes count: all pairs, or in a long track every box with the one half
/// the track later.
fn pairs(seen: &[BoxSighting]) -> Vec<(&BoxSighting, &BoxSighting)> {
    if seen.len() <= ALL_PAIRS {
        let pairs = |i: usize| seen[i + 1..].iter().map(move |to| (&seen[i], to));
        return (0..seen.len()).flat_map(pairs).collect();
    }
    seen.iter().zip(&seen[seen.len() / 2..]).collect()
}

/// The median of the slopes of `y` over `x`; `None` if no pair of boxes has one.
pub(super) fn slope(
    seen: &[BoxSighting],
    x: &dyn Fn(&BoxSighting) -> f64,
    y: &dyn Fn(&BoxSighting) -> f64,
) -> Option<f64> {
    let slopes = pairs(seen).into_iter();
    let slopes = slopes.map(|(from, to)| (y(to) - y(from)) / (x(to) - x(from)));
    median_of(slopes.filter(|slope| slope.is_finite()))
}

/// The smallest step between two frames of one track: 1, or more if the tracker processed only
/// every n-th frame. `None` if no track has two boxes.
pub(super) fn stride(tracks: &[Track]) -> Option<u32> {
    let steps = tracks.iter().flat_map(|track| track.sightings.windows(2));
    steps.map(|pair| pair[1].frame - pair[0].frame).min()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// 10 frames per second, 1 mm per pixel: the belt moves 10 px per frame.
    pub(in super::super) fn options() -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1)
    }

    /// Boxes at (frame, along, across).
    pub(in super::super) fn track(name: &str, boxes: &[(u32, f64, f64)]) -> Track {
        let sighting = |&(frame, along, across): &(u32, f64, f64)| BoxSighting {
            frame,
            line: 1,
            along,
            across,
            size: None,
            confidence: None,
            class: None,
        };
        Track {
            name: name.to_owned(),
            sightings: boxes.iter().map(sighting).collect(),
        }
    }

    /// A track over `frames` at `speed` [px/frame] from `along` at frame 0.
    pub(in super::super) fn moving(
        name: &str,
        frames: std::ops::Range<u32>,
        along: f64,
        speed: f64,
    ) -> Track {
        let boxes: Vec<_> = frames
            .map(|f| (f, along + speed * f64::from(f), 100.0))
            .collect();
        track(name, &boxes)
    }

    #[test]
    fn the_speed_is_robust_in_short_and_long_tracks() {
        for length in [5, 32, 33, 400] {
            let mut seen = moving("1", 1..length + 1, 0.0, 10.0);
            let speed = |t: &Track| t.speed(&options()).unwrap();
            assert!((speed(&seen) - 0.1).abs() < 1e-12, "{length}");
            for at in (1..seen.sightings.len()).step_by(10) {
                seen.sightings[at].along += 500.0;
            }
            assert!((speed(&seen) - 0.1).abs() < 1e-3, "{length}");
            assert!((seen.x0(&options()) - 0.01).abs() < 1e-9);
        }
        assert_eq!(moving("1", 4..5, 0.0, 10.0).speed(&options()), None);
    }
}
