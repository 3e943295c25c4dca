//! What the camera reports about an item besides its position.

use super::protocol::Detection;
use pickline::decision::Odds;
use pickline::pattern::Item;
use pickline::station::Station;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// What is known about an item besides its position; unreported fields are none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Features {
    /// Area seen from above [cm^2].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area_cm2: Option<f64>,
    /// Probability that this is a real item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_detection: Option<f64>,
    /// Probability that a grasp succeeds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_grasp: Option<f64>,
    /// Explicit weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// Class of the item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Angle of its long side, from x towards y [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Height of its top above the belt [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Length and width [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Any other data for the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<Map<String, Value>>,
}

impl Features {
    /// The features in a detection.
    pub(crate) fn of(detection: &Detection) -> Self {
        Self {
            area_cm2: detection.area_cm2,
            p_detection: detection.p_detection,
            p_grasp: detection.p_grasp,
            weight: detection.weight,
            class: detection.class.clone(),
            angle: detection.angle,
            height: detection.height,
            size: detection.size,
            data: detection.data.clone(),
        }
    }

    /// Merges `other`: all of its values if it is newer, otherwise only those that are not known
    /// yet. Values that `other` lacks stay.
    pub(crate) fn take(&mut self, other: Self, is_newer: bool) {
        fn merge<T>(mine: &mut Option<T>, other: Option<T>, is_newer: bool) {
            if other.is_some() && (is_newer || mine.is_none()) {
                *mine = other;
            }
        }
        // Destructured, so that no field is forgotten.
        let Self {
            area_cm2,
            p_detection,
            p_grasp,
            weight,
            class,
            angle,
            height,
            size,
            data,
        } = other;
        merge(&mut self.area_cm2, area_cm2, is_newer);
        merge(&mut self.p_detection, p_detection, is_newer);
        merge(&mut self.p_grasp, p_grasp, is_newer);
        merge(&mut self.weight, weight, is_newer);
        merge(&mut self.class, class, is_newer);
        merge(&mut self.angle, angle, is_newer);
        merge(&mut self.height, height, is_newer);
        merge(&mut self.size, size, is_newer);
        merge(&mut self.data, data, is_newer);
    }

    /// The object-specific reward that follows from the features.
    pub(crate) fn reward(&self) -> f64 {
        self.item().reward()
    }

    /// The weight on `station`, where its class may be worth more.
    pub(crate) fn weight_on(&self, station: &Station) -> f64 {
        self.item().weight_on(station)
    }

    /// What can go wrong with the item, as far as the camera says it.
    pub(crate) fn odds(&self) -> Odds {
        Odds {
            grasp: self.p_grasp.unwrap_or(1.0),
            detection: self.p_detection.unwrap_or(1.0),
        }
    }

    /// Whether the item is left on the belt where it must be real with at least the probability
    /// `least`.
    pub(crate) fn is_too_uncertain(&self, least: f64) -> bool {
        self.odds().detection < least
    }

    fn item(&self) -> Item {
        Item {
            area_cm2: self.area_cm2,
            p_detection: self.p_detection,
            p_grasp: self.p_grasp,
            weight: self.weight,
            class: self.class.clone(),
            ..Item::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_fields_keep_their_value_and_old_messages_only_fill_gaps() {
        let mut known = Features {
            area_cm2: Some(100.0),
            class: Some("pet".into()),
            ..Features::default()
        };
        let said = Features {
            p_detection: Some(0.5),
            class: Some("hdpe".into()),
            ..Features::default()
        };
        let mut late = known.clone();
        known.take(said.clone(), true);
        assert_eq!(known.class.as_deref(), Some("hdpe"));
        let expected = 0.5 / (1.0 + (-1.0f64).exp());
        assert!((known.reward() - expected).abs() < 1e-15);
        late.take(said, false);
        assert_eq!(late.class.as_deref(), Some("pet"));
        assert_eq!(late.p_detection, Some(0.5));
    }
}
