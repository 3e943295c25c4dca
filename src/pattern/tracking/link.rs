//! Links the boxes of a detector without a tracker. Items do not slide, so the belt's motion
//! determines which box shows the same item one frame later.

use super::options::{ImageAxis, ImportOptions};
use super::track::{BoxSighting, Track};
use std::collections::BTreeMap;

/// A track ends if its box is missing for this many consecutive frames. The pieces of an item are
/// merged later like those of any tracker.
const LONGEST_GAP: u32 = 5;
/// Number of tracks, nearest along the belt, that are considered for a box. Only in a degenerate
/// file could more be at the same place.
const NEIGHBOURS: usize = 64;

/// Tracks of `boxes`, numbered in order. Each box continues the track whose last box, moved with
/// the belt, is nearest and at most the merge distance away. The nearest pairs are linked first.
pub(super) fn link(boxes: Vec<BoxSighting>, options: &ImportOptions) -> Vec<Track> {
    let reach = options.merge_distance_m / options.scale_m_per_px;
    let step = options.belt_speed / (options.fps * options.scale_m_per_px);
    let mut by_frame: BTreeMap<u32, Vec<BoxSighting>> = BTreeMap::new();
    for sighting in boxes {
        by_frame.entry(sighting.frame).or_default().push(sighting);
    }
    let mut tracks: Vec<Track> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for (frame, boxes) in by_frame {
        let last = |track: usize, tracks: &[Track]| {
            let sighting = tracks[track].sightings.last();
            sighting.map_or((0, 0.0, 0.0), |s| (s.frame, s.along, s.across))
        };
        open.retain(|&track| frame - last(track, &tracks).0 <= LONGEST_GAP);
        // Predicted position of each open track.
        let mut expected: Vec<(f64, f64, usize)> = open
            .iter()
            .map(|&track| {
                let (before, along, across) = last(track, &tracks);
                (along + step * f64::from(frame - before), across, track)
            })
            .collect();
        expected.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (index, sighting) in boxes.iter().enumerate() {
            let from = expected.partition_point(|place| place.0 < sighting.along - reach);
            let near = expected[from..].iter().take(NEIGHBOURS);
            for &(along, across, track) in near.take_while(|p| p.0 <= sighting.along + reach) {
                let off = (along - sighting.along).hypot(across - sighting.across);
                if off <= reach {
                    pairs.push((off, index, track));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut track_of: Vec<Option<usize>> = vec![None; boxes.len()];
        let mut taken = std::collections::HashSet::new();
        for (_, index, track) in pairs {
            if track_of[index].is_none() && taken.insert(track) {
                track_of[index] = Some(track);
            }
        }
        for (sighting, track) in boxes.into_iter().zip(track_of) {
            match track {
                Some(track) => tracks[track].sightings.push(sighting),
                None => {
                    open.push(tracks.len());
                    tracks.push(Track {
                        name: (tracks.len() + 1).to_string(),
                        sightings: vec![sighting],
                    });
                }
            }
        }
    }
    tracks
}

/// Number of frame pairs examined to find the direction; more would only take time.
const MOST_PAIRS: usize = 2000;
/// Boxes must move at least this far between the two frames of a pair [px]; less could be detector
/// noise.
const LEAST_MOTION: f64 = 12.0;
/// Longest time between the two frames of a pair [frames].
const LONGEST_LAG: f64 = 50.0;

/// The four directions along the image axes, as (along, across) relative to the given direction,
/// which is first.
const WAYS: [(f64, f64); 4] = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];

/// For each of the four directions, how many boxes are found again a little later where a belt in
/// that direction would have carried them.
fn found_again(boxes: &[BoxSighting], options: &ImportOptions) -> [f64; WAYS.len()] {
    let step = options.belt_speed / (options.fps * options.scale_m_per_px);
    let lag = (LEAST_MOTION / step).ceil().clamp(1.0, LONGEST_LAG) as u32;
    let mut by_frame: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
    for s in boxes {
        by_frame
            .entry(s.frame)
            .or_default()
            .push((s.along, s.across));
    }
    by_frame
        .values_mut()
        .for_each(|boxes| boxes.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let mut scores = [0.0; WAYS.len()];
    for (&frame, from) in by_frame
        .iter()
        .step_by(by_frame.len().div_ceil(MOST_PAIRS).max(1))
    {
        let later = frame.saturating_add(lag);
        let Some((&then, to)) = by_frame
            .range(later..=later.saturating_add(LONGEST_GAP))
            .next()
        else {
            continue;
        };
        let motion = step * f64::from(then - frame);
        // A belt with half or one and a half times the speed still moves in that direction.
        let reach = motion / 2.0;
        for ((along, across), score) in WAYS.iter().zip(&mut scores) {
            for place in from {
                let (x, y) = (place.0 + motion * along, place.1 + motion * across);
                let first = to.partition_point(|other| other.0 < x - reach);
                let near = to[first..].iter().take_while(|other| other.0 <= x + reach);
                let off = near
                    .take(NEIGHBOURS)
                    .map(|other| (other.0 - x).hypot(other.1 - y) / reach)
                    .fold(1.0, f64::min);
                *score += 1.0 - off * off;
            }
        }
    }
    scores
}

/// What is wrong with 'axis' and 'reverse', and what to use instead, if boxes without tracks
/// clearly travel in another direction.
pub(super) fn other_way(
    boxes: &[BoxSighting],
    options: &ImportOptions,
) -> Option<(String, String)> {
    let scores = found_again(boxes, options);
    let given = scores[0];
    let best = (1..WAYS.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b]))?;
    let found = scores[best];
    // More than chance, and more than the neighbours of densely spaced items cause.
    if found < 1.5 * given || found - given <= 4.0 * (found + given).sqrt() {
        return None;
    }
    let (along, across) = WAYS[best];
    let swapped = across != 0.0;
    let axis = match (options.axis, swapped) {
        (ImageAxis::X, false) | (ImageAxis::Y, true) => "x",
        (ImageAxis::Y, false) | (ImageAxis::X, true) => "y",
    };
    let backwards = match swapped {
        true => across < 0.0,
        false => (along < 0.0) != options.reverse,
    };
    let (pixels, reverse) = match backwards {
        true => ("smaller", "with 'reverse'"),
        false => ("larger", "without 'reverse'"),
    };
    Some((
        format!(
            "the boxes have no track ids and travel towards {pixels} pixel values of image {axis}, \
             which is not the given direction"
        ),
        format!("give 'axis' {axis} {reverse}"),
    ))
}
