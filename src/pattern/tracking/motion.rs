//! The belt as seen in the tracks: its direction and speed in the image, whether both are the same
//! throughout the image, and whether the boxes can be of the stated kind.
//!
//! The velocity of a track is a median of slopes (Theil 1950; Sen 1968, DOI
//! 10.1080/01621459.1968.10480934), so that a few bad boxes or tracks have no effect. Spreads are
//! median absolute deviations.

use super::median::{centre, median_of};
use super::options::ImportOptions;
use super::pace::{Pace, TrackStep, steps};
use super::track::{BoxSighting, Track, slope};

/// Tracks with fewer boxes, or a shorter travel [px], are not used.
const FEWEST_BOXES: usize = 5;
const LEAST_TRAVEL: f64 = 20.0;
/// Number of pieces of the image, along and across the travel, in which speeds are compared.
const PIECES: usize = 6;
/// Minimum number of speeds for a reliable median of a piece.
const FEWEST_SPEEDS: usize = 8;
/// What the tracks that ride on the belt show.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Motion {
    /// Number of tracks that are long enough to use.
    pub tracks: usize,
    /// The travel's angle from the given direction, positive towards larger pixel values of the
    /// other axis [degrees].
    pub angle_deg: f64,
    /// Standard error of the angle [degrees].
    pub angle_error_deg: f64,
    /// Speed along the travel [m/s].
    pub speed: f64,
    /// Position error due to the angle [m]: along the belt between items at different positions
    /// across, or across the belt between the first and the last box of one item, whichever is
    /// greater.
    pub angle_off_m: f64,
    /// Slowest and fastest piece of the image along the travel [m/s]; `None` if there are too few
    /// boxes.
    pub speeds_along: Option<[f64; 2]>,
    /// Slowest and fastest piece of the image across the travel [m/s].
    pub speeds_across: Option<[f64; 2]>,
    /// Whether the middle of the image is faster or slower than both ends, as with a lens, rather
    /// than one end faster than the other, as with a tilted camera.
    pub bends: bool,
    /// Position error due to speeds that vary over the image or tracks that bend [m]; 0 if neither
    /// is more than chance.
    pub bent_off_m: f64,
    /// Slowest and fastest part of the recording [m/s]; `None` if there are too few boxes.
    pub speeds_over_time: Option<[f64; 2]>,
    /// Position error due to speeds that vary over time [m]; 0 if that may be chance.
    pub unsteady_off_m: f64,
    /// How much a box grows per travelled distance: two thirds if the lower right corner was read
    /// as the size, 1 if the upper left corner was read as the centre as well.
    pub growth: f64,
}

/// The velocity of a track [px/frame], along and across.
struct Velocity {
    along: f64,
    across: f64,
}

fn velocity(track: &Track) -> Option<Velocity> {
    let seen = &track.sightings;
    let (first, last) = (seen.first()?, seen.last()?);
    let travel = (last.along - first.along).hypot(last.across - first.across);
    if seen.len() < FEWEST_BOXES || travel < LEAST_TRAVEL {
        return None;
    }
    let frame = |s: &BoxSighting| f64::from(s.frame);
    Some(Velocity {
        along: slope(seen, &frame, &|s| s.along)?,
        across: slope(seen, &frame, &|s| s.across)?,
    })
}

/// The median velocity of all moving tracks [px/frame], along and across; `None` if hardly any is
/// long enough.
pub(super) fn way(tracks: &[Track]) -> Option<(f64, f64)> {
    let velocities: Vec<Velocity> = tracks.iter().filter_map(velocity).collect();
    Some((
        median_of(velocities.iter().map(|v| v.along))?,
        median_of(velocities.iter().map(|v| v.across))?,
    ))
}

/// Measures `tracks` on a belt with this pace; `None` if hardly any is long enough.
pub(super) fn measure<'t>(
    tracks: impl Iterator<Item = &'t Track>,
    pace: Option<&Pace>,
    options: &ImportOptions,
) -> Option<Motion> {
    let moving: Vec<(&Track, Velocity)> = tracks
        .filter_map(|track| Some((track, velocity(track)?)))
        .filter(|(_, v)| v.along > 0.0)
        .collect();
    let metres = options.scale_m_per_px;
    let angles: Vec<f64> = moving
        .iter()
        .map(|(_, v)| v.across.atan2(v.along))
        .collect();
    let (angle, angle_error) = centre(&angles)?;
    let speeds = moving.iter().map(|(_, v)| v.along.hypot(v.across));
    let frame_speed = median_of(speeds)?;
    let (least, most) = range_of(moving.iter().map(|(track, _)| track.across()));
    let travels = moving.iter().filter_map(|(track, _)| {
        let seen = &track.sightings;
        Some(seen.last()?.along - seen.first()?.along)
    });
    let travel = median_of(travels)?;
    let pieces_along = pieces_along(&moving, pace, frame_speed);
    // Whole tracks differ in speed if the belt speed varies over time.
    let is_steady = pace.is_none_or(|pace| !pace.explains());
    let pieces_across = pieces_across(&moving).filter(|_| is_steady);
    let bend = bend(&moving);
    let scaled = |v: f64| v * metres * options.fps;
    let range = |pieces: &Option<ImagePieces>| {
        pieces
            .as_ref()
            .map(|p| [scaled(p.slowest), scaled(p.fastest)])
    };
    let off = pieces_along.as_ref().map_or(0.0, |p| p.off_px);
    // Slower rows lag behind in proportion to the distance travelled through the image.
    let lag = |p: &ImagePieces| travel / 2.0 * (p.fastest - p.slowest) / frame_speed / 2.0;
    let differing = pieces_across.as_ref().filter(|p| p.off_px > 0.0);
    let off_across = differing.map_or(0.0, lag);
    Some(Motion {
        tracks: moving.len(),
        angle_deg: angle.to_degrees(),
        angle_error_deg: angle_error.to_degrees(),
        speed: frame_speed * metres * options.fps,
        angle_off_m: angle.sin().abs() * metres * (most - least).max(travel),
        speeds_along: range(&pieces_along),
        speeds_across: range(&pieces_across),
        bends: [&pieces_along, &pieces_across]
            .into_iter()
            .flatten()
            .any(|pieces| pieces.bends && pieces.off_px > 0.0)
            || bend > 0.0,
        bent_off_m: metres * off.max(off_across).max(bend),
        speeds_over_time: pace.map(|pace| pace.range.map(scaled)),
        unsteady_off_m: pace.map_or(0.0, |pace| pace.off_px * metres),
        growth: growth(&moving),
    })
}

/// How much a box grows per travelled distance.
fn growth(moving: &[(&Track, Velocity)]) -> f64 {
    let size = |s: &BoxSighting| s.size.map_or(f64::NAN, |size| size.0);
    let growths = moving
        .iter()
        .filter_map(|(track, _)| slope(&track.sightings, &|s| s.along, &size));
    median_of(growths).unwrap_or_default().abs()
}

/// The range of `values`, which are finite.
fn range_of(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// Speeds by piece of the image [px/frame].
struct ImagePieces {
    slowest: f64,
    fastest: f64,
    /// Whether the middle is faster or slower than both ends.
    bends: bool,
    /// Position error due to the differences [px]; 0 if they may be chance.
    off_px: f64,
}

/// Compares `speeds` [px/frame], each with its position [px], between equal pieces of the image.
fn compare(mut speeds: Vec<(f64, f64)>, frame_speed: f64, is_along: bool) -> Option<ImagePieces> {
    speeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The outermost boxes are cut off by the edge of the image.
    let cut = speeds.len() / 50;
    let kept = speeds.get(cut..speeds.len() - cut)?;
    let (low, high) = (kept.first()?.0, kept.last()?.0);
    let width = (high - low) / PIECES as f64;
    let mut medians = Vec::with_capacity(PIECES);
    for piece in 0..PIECES {
        let from = low + width * piece as f64;
        let inside = kept
            .iter()
            .filter(|(place, _)| (from..=from + width).contains(place));
        let values: Vec<f64> = inside.map(|(_, speed)| *speed).collect();
        if values.len() >= FEWEST_SPEEDS {
            medians.push(centre(&values)?);
        }
    }
    if medians.len() < 3 {
        return None;
    }
    let fold = |f: fn(f64, f64) -> f64, from: f64| medians.iter().map(|m| m.0).fold(from, f);
    let (slowest, fastest) = (
        fold(f64::min, f64::INFINITY),
        fold(f64::max, f64::NEG_INFINITY),
    );
    let error = medians.iter().map(|m| m.1).fold(0.0, f64::max);
    let ends = [medians[0].0, medians[medians.len() - 1].0];
    let inner = &medians[1..medians.len() - 1];
    let middle = inner.iter().map(|m| m.0).sum::<f64>() / inner.len() as f64;
    let bends = ends.iter().all(|end| *end < middle) || ends.iter().all(|end| *end > middle);
    let chance = fastest - slowest < 4.0 * error || fastest - slowest < 0.01 * frame_speed;
    // Along the travel, the differences accumulate on the way through the image.
    let (mut place, mut least, mut most) = (0.0f64, 0.0f64, 0.0f64);
    let mean = medians.iter().map(|m| m.0).sum::<f64>() / medians.len() as f64;
    for (speed, _) in &medians {
        place += width * (speed / mean - 1.0);
        (least, most) = (least.min(place), most.max(place));
    }
    Some(ImagePieces {
        slowest,
        fastest,
        bends,
        off_px: match (chance, is_along) {
            (true, _) => 0.0,
            (false, true) => (most - least) / 2.0,
            (false, false) => fastest - slowest,
        },
    })
}

/// Speeds along the travel, without the effect of a belt that changes its speed.
fn pieces_along(
    moving: &[(&Track, Velocity)],
    pace: Option<&Pace>,
    frame_speed: f64,
) -> Option<ImagePieces> {
    let steps = steps(moving.iter().map(|(track, _)| *track));
    let steady = |step: &TrackStep| pace.map_or(step.speed, |pace| pace.steady(step));
    let speeds = steps.iter().map(|step| (step.place, steady(step)));
    compare(speeds.collect(), frame_speed, true)
}

/// Speeds of whole tracks, by position across the travel.
fn pieces_across(moving: &[(&Track, Velocity)]) -> Option<ImagePieces> {
    let speeds = moving.iter().map(|(track, v)| (track.across(), v.along));
    let frame_speed = median_of(moving.iter().map(|(_, v)| v.along))?;
    compare(speeds.collect(), frame_speed, false)
}

/// How far tracks bend sideways between their ends [px]: three quarters bend less. 0 if that may be
/// chance.
fn bend(moving: &[(&Track, Velocity)]) -> f64 {
    let mut bends = Vec::new();
    let mut errors = Vec::new();
    for (track, _) in moving {
        let seen = &track.sightings;
        let third = seen.len() / 3;
        if third < FEWEST_BOXES {
            continue;
        }
        let part = |from: usize| -> Option<(f64, f64)> {
            // The slope of a straight track must not widen the spread.
            let part = &seen[from..from + third];
            let across: Vec<f64> = part.iter().map(|s| s.across).collect();
            centre(&across)
        };
        let parts = (
            part(0),
            part((seen.len() - third) / 2),
            part(seen.len() - third),
        );
        if let (Some(first), Some(middle), Some(last)) = parts {
            bends.push((middle.0 - f64::midpoint(first.0, last.0)).abs());
            errors.push(first.1.max(middle.1).max(last.1));
        }
    }
    bends.sort_by(f64::total_cmp);
    let most = bends.get(bends.len() * 3 / 4).copied().unwrap_or_default();
    let error = median_of(errors.into_iter()).unwrap_or_default();
    if bends.len() < 3 || most < 4.0 * error {
        0.0
    } else {
        most
    }
}
