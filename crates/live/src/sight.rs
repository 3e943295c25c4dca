//! A detection, with its place on the belt.

use super::association::Covariance;
use super::features::Features;
use super::protocol::Detection;

/// A detection of an item.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedDetection {
    /// The camera, if it has a name.
    pub source: Option<String>,
    /// The id that the camera's tracker gave the item, if there is one.
    pub id: Option<String>,
    /// When the picture was taken [s].
    pub time: f64,
    /// Its x when the belt's travel was 0 [m].
    pub place: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Covariance of the position [m^2].
    pub covariance: Option<Covariance>,
    /// The item's other features.
    pub features: Features,
}

impl PlacedDetection {
    /// The sight from a detection at `time` [s], when the belt's travel was `travel` [m].
    pub(crate) fn of(detection: Detection, time: f64, travel: f64) -> Self {
        Self {
            features: Features::of(&detection),
            source: detection.source,
            id: detection.id,
            time,
            place: detection.x - travel,
            y: detection.y,
            covariance: detection.covariance,
        }
    }

    /// The camera, if it has a name.
    pub(crate) fn source(&self) -> Option<&str> {
        self.source.as_deref()
    }

    /// The id that the camera's tracker gave the item, if there is one.
    pub(crate) fn id(&self) -> Option<&str> {
        self.id.as_deref()
    }

    /// Distance from it to a place on the belt [m].
    pub(crate) fn way(&self, place: f64, y: f64) -> f64 {
        (self.place - place).hypot(self.y - y)
    }
}
