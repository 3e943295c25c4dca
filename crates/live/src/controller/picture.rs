//! A picture that may still be incomplete, and the detections that wait for the belt.

use crate::protocol::Detection;
use crate::sight::PlacedDetection;

/// Maximum number of detections that are matched together. A larger picture is split, and its parts
/// know of each other.
const MOST_TOGETHER: usize = 256;

/// Detections of one picture that are not yet matched to items.
#[derive(Debug, Default)]
pub(super) struct Picture {
    /// The detections of the picture so far.
    pub seen: Vec<PlacedDetection>,
    /// Detections with their times [s], for which the belt's position is not yet known.
    pub waiting: Vec<(f64, Detection)>,
}

impl Picture {
    /// Whether a detection of `source` at `time` [s] belongs to this picture.
    pub(super) fn takes(&self, source: Option<&str>, time: f64) -> bool {
        let is_same = |first: &PlacedDetection| first.time == time && first.source() == source;
        self.seen.first().is_some_and(is_same) && self.seen.len() < MOST_TOGETHER
    }

    /// A picture that holds only detections that wait for the belt.
    pub(super) fn restore(waiting: Vec<(f64, Detection)>) -> Self {
        Self {
            seen: Vec::new(),
            waiting,
        }
    }
}
