//! Whether the belt speed is constant during the recording.
//!
//! Speeds of boxes may vary over time, for example if the belt stops, and over the image, for
//! example due to the lens. Items are not everywhere at all times, so either can look like the
//! other. The one that explains the speeds better is removed before looking for the other (one step
//! of the median polish of Tukey 1977, "Exploratory Data Analysis").

use super::median::{centre, median_of};
use super::track::{BoxSighting, Track};

/// Number of parts of the recording, and of the image, in which speeds are compared.
const MOST_TIMES: usize = 200;
const PLACES: usize = 24;
/// Minimum number of speeds for a reliable median.
const FEWEST_SPEEDS: usize = 8;
/// A track counts if it reaches this share of the usual speed for some time: a belt that stops
/// carries items that stand still, but dirt stands still in all frames.
const MOVES: f64 = 0.5;

/// A section of a track.
pub(super) struct TrackStep {
    /// Number of the track.
    track: usize,
    /// Its middle along the travel [px].
    pub place: f64,
    /// Its middle in time [frame].
    frame: f64,
    /// Speed [px/frame].
    pub speed: f64,
}

/// Steps between boxes an eighth of a track apart.
pub(super) fn steps<'t>(tracks: impl Iterator<Item = &'t Track>) -> Vec<TrackStep> {
    let mut steps = Vec::new();
    for (track, seen) in tracks.map(|track| &track.sightings).enumerate() {
        let apart = (seen.len() / 8).max(2);
        let frame = |s: &BoxSighting| f64::from(s.frame);
        for (from, to) in seen.iter().zip(&seen[apart.min(seen.len())..]) {
            steps.push(TrackStep {
                track,
                place: f64::midpoint(from.along, to.along),
                frame: f64::midpoint(frame(from), frame(to)),
                speed: (to.along - from.along) / (frame(to) - frame(from)),
            });
        }
    }
    steps
}

/// A range divided into equal pieces.
struct EqualPieces {
    low: f64,
    width: f64,
    count: usize,
}

impl EqualPieces {
    fn of(places: impl Iterator<Item = f64>, count: usize) -> Self {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        let width = ((high - low) / count as f64).max(f64::MIN_POSITIVE);
        Self { low, width, count }
    }

    fn piece(&self, place: f64) -> usize {
        // The cast saturates if the position is outside the range.
        (((place - self.low) / self.width) as usize).min(self.count - 1)
    }

    /// The speeds in every piece.
    fn speeds(&self, steps: &[TrackStep], place: impl Fn(&TrackStep) -> f64) -> Vec<Vec<f64>> {
        let mut speeds = vec![Vec::new(); self.count];
        for step in steps {
            speeds[self.piece(place(step))].push(step.speed);
        }
        speeds
    }
}

/// Median speed of every piece, or the usual speed if it has too few.
fn medians(speeds: &[Vec<f64>], usual: f64) -> Vec<f64> {
    let median = |speeds: &Vec<f64>| match speeds.len() {
        FEWEST_SPEEDS.. => median_of(speeds.iter().copied()).unwrap_or(usual),
        _ => usual,
    };
    speeds.iter().map(median).collect()
}

/// The belt's speed over time.
pub(super) struct Pace {
    /// Slowest and fastest part of the recording [px/frame].
    pub range: [f64; 2],
    /// Position error due to speeds that vary over time [px]; 0 if they may be chance.
    pub off_px: f64,
    times: EqualPieces,
    /// How much faster than usual each part of the recording is [px/frame]; empty if the position
    /// in the image explains the speeds better.
    excess: Vec<f64>,
}

impl Pace {
    /// Whether time explains the differences between speeds and they are more than chance.
    pub(super) fn explains(&self) -> bool {
        self.off_px > 0.0 && !self.excess.is_empty()
    }

    /// The speed of a step without the effect of its time [px/frame].
    pub(super) fn steady(&self, step: &TrackStep) -> f64 {
        let excess = self.excess.get(self.times.piece(step.frame));
        step.speed - excess.copied().unwrap_or_default()
    }
}

/// The pace of the belt from `tracks`; `None` if there are too few.
pub(super) fn pace(tracks: &[Track]) -> Option<Pace> {
    let mut steps = steps(tracks.iter());
    let rough = median_of(steps.iter().map(|s| s.speed).filter(|v| *v > 0.0))?;
    let mut fast = vec![(0usize, 0usize); tracks.len()];
    for step in &steps {
        let (moving, all) = &mut fast[step.track];
        *all += 1;
        *moving += usize::from(step.speed > MOVES * rough);
    }
    // More than a tenth of its steps must move: a few bad boxes are not motion.
    steps.retain(|step| fast[step.track].0 * 10 > fast[step.track].1);
    let usual = median_of(steps.iter().map(|s| s.speed))?;
    let frames = steps.iter().map(|s| s.frame);
    let (first, last) = frames.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| {
        (l.min(f), h.max(f))
    });
    let lengths = tracks.iter().filter_map(|track| {
        let seen = &track.sightings;
        Some(f64::from(seen.last()?.frame) - f64::from(seen.first()?.frame))
    });
    // At least as long as a step, so that neighbouring parts do not share steps.
    let step = (median_of(lengths)? / 8.0).max(1.0);
    let count = ((last - first) / step) as usize;
    let times = EqualPieces::of(steps.iter().map(|s| s.frame), count.clamp(1, MOST_TIMES));
    let places = EqualPieces::of(steps.iter().map(|s| s.place), PLACES);
    let over_time = medians(&times.speeds(&steps, |s| s.frame), usual);
    let over_place = medians(&places.speeds(&steps, |s| s.place), usual);
    let in_time = |s: &TrackStep| over_time[times.piece(s.frame)];
    let in_place = |s: &TrackStep| over_place[places.piece(s.place)];
    let left = |median: &dyn Fn(&TrackStep) -> f64| -> f64 {
        steps.iter().map(|s| (s.speed - median(s)).abs()).sum()
    };
    let by_time = left(&in_time) < left(&in_place);
    let mut excess = Vec::new();
    if by_time {
        excess = over_time.iter().map(|speed| speed - usual).collect();
    } else {
        let corrected: Vec<f64> = steps
            .iter()
            .map(|s| s.speed - (in_place(s) - usual))
            .collect();
        for (step, speed) in steps.iter_mut().zip(corrected) {
            step.speed = speed;
        }
    }
    let (range, off_px) = deviation(&steps, &times, usual)?;
    Some(Pace {
        range,
        off_px,
        times,
        excess,
    })
}

/// The range of speeds over time, and how far the belt deviates from constant motion.
fn deviation(steps: &[TrackStep], times: &EqualPieces, usual: f64) -> Option<([f64; 2], f64)> {
    let mut pieces: Vec<Vec<&TrackStep>> = (0..times.count).map(|_| Vec::new()).collect();
    for step in steps {
        pieces[times.piece(step.frame)].push(step);
    }
    let mut known = Vec::new();
    for piece in pieces.iter().filter(|p| p.len() >= FEWEST_SPEEDS) {
        let speeds: Vec<f64> = piece.iter().map(|s| s.speed).collect();
        let (speed, error) = centre(&speeds)?;
        let half = |odd: usize| {
            let half = piece.iter().filter(|s| s.track % 2 == odd);
            median_of(half.map(|s| s.speed))
        };
        // A difference that only one half of the tracks shows is an error; one that all show is due
        // to the belt.
        let halves = half(0).zip(half(1));
        let error_of_halves = halves.map(|(one, other)| (one - other).abs() / 2.0);
        known.push((speed, error * (speeds.len() as f64).sqrt(), error_of_halves));
    }
    // If only a single track is visible, its steps share boxes, so they count once. They differ
    // more than usual if the belt changes its speed within the piece, which is not an error.
    let spread = median_of(known.iter().map(|(_, spread, _)| *spread))?;
    let (mut slowest, mut fastest) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut place, mut least, mut most, mut variance) = (0.0f64, 0.0f64, 0.0f64, 0.0);
    for (speed, _, error) in known {
        (slowest, fastest) = (slowest.min(speed), fastest.max(speed));
        place += times.width * (speed - usual);
        variance += (times.width * error.unwrap_or(spread)).powi(2);
        (least, most) = (least.min(place), most.max(place));
    }
    let off = (most - least) / 2.0;
    let chance = off < 4.0 * variance.sqrt() || fastest - slowest < 0.02 * usual.abs();
    Some(([slowest, fastest], if chance { 0.0 } else { off }))
}
