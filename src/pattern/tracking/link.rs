//! Boxes of a detector without a tracker: items do not slide, so the belt's motion says
//! which box is the same item a frame later.

use super::options::Options;
use super::read::{Sighting, Track};
use std::collections::BTreeMap;

/// A box that is missing in so many frames in a row ends its track; pieces of one item are
/// merged later like those of any tracker.
const LONGEST_GAP: u32 = 5;
/// So many tracks nearest along the belt are looked at for a box; more would be in one
/// place only in a degenerate file.
const NEIGHBOURS: usize = 64;

/// Tracks of `boxes`, named by their order. Each box continues the track whose last box,
/// moved with the belt, is nearest and at most the merge distance away; the nearest pairs
/// go first.
pub(super) fn link(boxes: Vec<Sighting>, options: &Options) -> Vec<Track> {
    let reach = options.merge_distance_m / options.scale_m_per_px;
    let step = options.belt_speed / (options.fps * options.scale_m_per_px);
    let mut by_frame: BTreeMap<u32, Vec<Sighting>> = BTreeMap::new();
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
        // Where each open track should be now.
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
