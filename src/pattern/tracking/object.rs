//! Turns tracks into objects: splits tracks whose id was reused, and merges the tracks of an object
//! whose id changed.

use super::options::ImportOptions;
use super::track::{BoxSighting, Track, seconds, speed_between, travel};
use std::collections::HashMap;

/// Number of tracks per cell that are considered for a merge. A cell is about as large as one item,
/// so only a degenerate file has more; the limit keeps such a file fast.
const NEIGHBOURS: usize = 64;

/// Splits a track where it jumps by more than the split distance between consecutive boxes; the
/// pieces are called `ID`, `ID.2`, ...
///
/// Along the travel, a jump must deviate from the belt's motion *and* from the track's own motion:
/// an object that stands still, or moves at another speed than the given one, falls behind the belt
/// from box to box, but it is still one object. Items do not slide, so a jump across the travel
/// also counts.
pub(super) fn split(track: Track, stride: Option<u32>, options: &ImportOptions) -> Vec<Track> {
    let own = own_speed(&track.sightings, stride, options);
    let limit = options.split_distance_m;
    let jumps = |from: &BoxSighting, to: &BoxSighting| {
        let (time, moved) = (seconds(from, to, options), travel(from, to, options));
        let off = |speed: f64| (moved - speed * time).abs() > limit;
        let aside = (to.across - from.across).abs() * options.scale_m_per_px;
        aside > limit || (off(options.belt_speed) && off(own))
    };
    let name = track.name;
    let mut pieces: Vec<Track> = Vec::new();
    for sighting in track.sightings {
        let follows =
            |piece: &Track| (piece.sightings.last()).is_some_and(|last| !jumps(last, &sighting));
        match pieces.last_mut() {
            Some(piece) if follows(piece) => piece.sightings.push(sighting),
            _ => pieces.push(Track {
                name: match pieces.len() {
                    0 => name.clone(),
                    count => format!("{name}.{}", count + 1),
                },
                sightings: vec![sighting],
            }),
        }
    }
    pieces
}

/// The speed of most steps of a track [m/s]: the median over the steps of one stride; of two middle
/// values, the one closer to the belt speed. Longer steps are ignored, because the return of an id
/// is a long step. Without steps of one stride, the belt speed.
fn own_speed(seen: &[BoxSighting], stride: Option<u32>, options: &ImportOptions) -> f64 {
    let short = |pair: &&[BoxSighting]| Some(pair[1].frame - pair[0].frame) == stride;
    let mut speeds: Vec<f64> = seen
        .windows(2)
        .filter(short)
        .map(|pair| speed_between(&pair[0], &pair[1], options))
        .collect();
    speeds.sort_unstable_by(f64::total_cmp);
    let off = |speed: &f64| (speed - options.belt_speed).abs();
    let middle = speeds.len() / 2;
    let candidates = match speeds.len() % 2 {
        0 if middle > 0 => &speeds[middle - 1..=middle],
        1 => &speeds[middle..=middle],
        _ => &[],
    };
    let nearest = candidates
        .iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .copied();
    nearest.unwrap_or(options.belt_speed)
}

/// One object, with the sightings under all of its ids.
#[derive(Debug)]
pub(super) struct Object {
    /// All sightings, under the name of its first track.
    pub track: Track,
    /// The ids of the tracks that were merged, in order of time.
    pub parts: Vec<String>,
    /// Another object, by index, that was at the same place at the same time.
    pub twin: Option<usize>,
}

/// Merges tracks that are one object with a new id: they do not overlap in time, and their x0 and
/// their positions across agree within the merge distance. Every track follows the nearest one that
/// ended before it began. Takes linear time except for the sorting.
pub(super) fn merge(mut tracks: Vec<Track>, options: &ImportOptions) -> Vec<Object> {
    let reach = options.merge_distance_m;
    tracks.sort_by_key(Track::span);
    let place = |t: &Track| (t.x0(options), t.across() * options.scale_m_per_px);
    let places: Vec<(f64, f64)> = tracks.iter().map(place).collect();
    let spans: Vec<(u32, u32)> = tracks.iter().map(Track::span).collect();
    // A cell is as wide as the merge distance, so partners are in neighbouring cells. It holds the
    // tracks that have no successor yet.
    let cell_of = |(x, y): (f64, f64)| ((x / reach).floor() as i64, (y / reach).floor() as i64);
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::with_capacity(tracks.len());
    let mut objects: Vec<Object> = Vec::new();
    let mut object_of: Vec<usize> = Vec::with_capacity(tracks.len());
    for (index, track) in tracks.into_iter().enumerate() {
        let (here, (x, y)) = (cell_of(places[index]), places[index]);
        let mut before: Option<(f64, (i64, i64), usize)> = None;
        let mut twin = None;
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let cell = (here.0.saturating_add(dx), here.1.saturating_add(dy));
            let near = cells.get(&cell).map_or(&[][..], Vec::as_slice);
            for &other in near.iter().rev().take(NEIGHBOURS) {
                let off = (places[other].0 - x).abs().max((places[other].1 - y).abs());
                if off > reach {
                    continue;
                }
                if spans[other].1 >= spans[index].0 {
                    twin = Some(object_of[other]);
                } else if before.is_none_or(|(least, ..)| off < least) {
                    before = Some((off, cell, other));
                }
            }
        }
        if let Some((_, cell, other)) = before {
            let object = object_of[other];
            objects[object].parts.push(track.name);
            objects[object].track.sightings.extend(track.sightings);
            object_of.push(object);
            if let Some(near) = cells.get_mut(&cell)
                && let Some(at) = near.iter().rposition(|&i| i == other)
            {
                near.remove(at);
            }
        } else {
            object_of.push(objects.len());
            objects.push(Object {
                parts: vec![track.name.clone()],
                track,
                twin,
            });
        }
        cells.entry(here).or_default().push(index);
    }
    objects
}

#[cfg(test)]
mod tests {
    use super::super::track::stride;
    use super::super::track::tests::{moving, options, track};
    use super::*;

    fn pieces(track: Track) -> Vec<(String, usize)> {
        let stride = stride(std::slice::from_ref(&track));
        split(track, stride, &options())
            .into_iter()
            .map(|t| (t.name, t.sightings.len()))
            .collect()
    }

    fn parts(tracks: Vec<Track>) -> Vec<Vec<String>> {
        merge(tracks, &options())
            .into_iter()
            .map(|o| o.parts)
            .collect()
    }

    #[test]
    fn gaps_that_fit_the_motion_stay_whole() {
        let boxes: Vec<_> = [1, 2, 3, 40, 41, 90]
            .map(|f| (f, 10.0 * f64::from(f), 5.0))
            .into();
        assert_eq!(pieces(track("4", &boxes)), [("4".to_owned(), 6)]);
    }

    #[test]
    fn an_id_that_comes_back_is_split() {
        let mut seen = moving("4", 1..11, 0.0, 10.0);
        seen.sightings
            .extend(moving("4", 50..55, -490.0, 10.0).sightings);
        seen.sightings
            .extend(moving("4", 80..81, -790.0, 10.0).sightings);
        let names = ["4", "4.2", "4.3"].map(str::to_owned);
        let expected: Vec<_> = names.into_iter().zip([10, 5, 1]).collect();
        assert_eq!(pieces(seen), expected);
        // Right afterwards, and to a neighbour across the belt.
        let swap = track(
            "5",
            &[
                (1, 0.0, 0.0),
                (2, 10.0, 0.0),
                (3, 20.0, 150.0),
                (4, 30.0, 150.0),
            ],
        );
        assert_eq!(pieces(swap).len(), 2);
        let ahead = track("6", &[(1, 0.0, 0.0), (2, 10.0, 0.0), (3, 320.0, 0.0)]);
        assert_eq!(pieces(ahead).len(), 2);
    }

    #[test]
    fn what_moves_otherwise_is_not_split() {
        // With every step the object falls 0.2 m behind the belt.
        let mut fast_belt = options();
        fast_belt.belt_speed = 2.0;
        let standing = moving("1", 1..20, 300.0, 0.0);
        let whole = split(standing, Some(1), &fast_belt);
        assert_eq!(whole.len(), 1);
        let sparse = track("2", &[(1, 300.0, 0.0), (6, 300.0, 0.0), (11, 300.0, 0.0)]);
        assert_eq!(split(sparse, Some(5), &fast_belt).len(), 1);
    }

    #[test]
    fn one_object_under_two_ids_is_merged() {
        let tracks = vec![
            moving("9", 12..20, 3.0, 10.0),
            moving("3", 1..11, 0.0, 10.0),
            moving("8", 30..33, 15.0, 10.0),
            moving("5", 1..11, 400.0, 10.0),
        ];
        assert_eq!(parts(tracks), [vec!["3", "9", "8"], vec!["5"]]);
    }

    #[test]
    fn overlapping_or_distant_tracks_are_not_merged() {
        let overlapping = vec![
            moving("1", 1..11, 0.0, 10.0),
            moving("2", 10..20, 1.0, 10.0),
        ];
        let objects = merge(overlapping, &options());
        assert_eq!(objects.len(), 2);
        assert_eq!((objects[0].twin, objects[1].twin), (None, Some(0)));
        let along = vec![
            moving("1", 1..9, 0.0, 10.0),
            moving("2", 10..20, 21.0, 10.0),
        ];
        assert_eq!(parts(along).len(), 2);
        let mut aside = moving("2", 10..20, 0.0, 10.0);
        aside.sightings.iter_mut().for_each(|s| s.across += 21.0);
        assert_eq!(parts(vec![moving("1", 1..9, 0.0, 10.0), aside]).len(), 2);
    }

    #[test]
    fn the_nearest_predecessor_is_taken() {
        let tracks = vec![
            moving("1", 1..9, -15.0, 10.0),
            moving("2", 1..9, 4.0, 10.0),
            moving("3", 10..20, 0.0, 10.0),
        ];
        assert_eq!(parts(tracks), [vec!["1"], vec!["2", "3"]]);
    }
}
