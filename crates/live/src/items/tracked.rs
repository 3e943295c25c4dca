//! A known item: what is known of it, and who may be sent to it.

use crate::association::Covariance;
use crate::features::Features;
use crate::sight::PlacedDetection;
use serde::{Deserialize, Serialize};

/// The state of an item.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ItemState {
    /// No task is about it.
    Free,
    /// It is reserved for this task.
    Claimed(u64),
    /// It was picked at this time [s].
    Picked(f64),
    /// Too many attempts have failed.
    GivenUp,
    /// Its robot never reported a result.
    NoResult,
}

/// A known item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tracked {
    /// Its unique name in messages.
    pub id: String,
    /// Its x when the belt's travel was 0 [m].
    pub place: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// What else the camera has reported about it.
    #[serde(default)]
    pub features: Features,
    /// Time of its last measurement [s].
    pub measured: f64,
    /// Covariance of its position at that time [m^2].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Covariance>,
    /// The cameras that have seen it, and their ids for it.
    #[serde(default)]
    pub sightings: Vec<CameraRecord>,
    /// Number of pictures that show another item in its place, minus those that show both.
    #[serde(default)]
    pub overlooked: i32,
    /// Whether it is free, reserved for a task, or done with.
    pub state: ItemState,
    /// Whether any robot ever had a window for it.
    pub windowed: bool,
    /// Whether it was ever a candidate of a decision.
    pub offered: bool,
    /// Number of failed attempts.
    pub attempts: u32,
    /// The failed attempts in which the gripper reached it but the grasp failed.
    pub failed_grasps: u32,
    /// Robots that have dropped it, and when it may be offered to them again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// Whether it is let pass, because it came while the line was draining.
    #[serde(default)]
    pub barred: bool,
    /// Robots that refused it, one bit each; a station has at most 100.
    pub refused: u128,
    /// The tasks about it so far.
    pub tasks: Vec<u64>,
}

/// A robot that has dropped a task about an item.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Withheld {
    robot: usize,
    /// How often the robot has dropped it.
    times: u32,
    /// The robot is not offered the item before this time [s].
    until: f64,
}

/// How long an item is withheld from a robot that has dropped it [s]; it doubles each further time,
const FIRST_PAUSE: f64 = 1.0;
/// up to this [s].
const LONGEST_PAUSE: f64 = 60.0;

/// A camera's record of an item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CameraRecord {
    /// The camera, if it has a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// When the camera last saw the item [s].
    pub at: f64,
    /// The camera's ids for the item, the newest last.
    pub ids: Vec<String>,
}

impl Tracked {
    /// An item that is seen for the first time and called `id`.
    pub(crate) fn new(id: String, sight: &PlacedDetection) -> Self {
        Self {
            id,
            place: sight.place,
            y: sight.y,
            weight: sight.features.reward(),
            features: sight.features.clone(),
            measured: sight.time,
            covariance: sight.covariance,
            sightings: Vec::new(),
            overlooked: 0,
            state: ItemState::Free,
            windowed: false,
            offered: false,
            attempts: 0,
            failed_grasps: 0,
            withheld: Vec::new(),
            barred: false,
            refused: 0,
            tasks: Vec::new(),
        }
    }

    /// When `source` last saw it [s].
    pub(crate) fn seen_at(&self, source: Option<&str>) -> Option<f64> {
        self.sighting(source).map(|sighting| sighting.at)
    }

    /// Whether `source` has an id for it.
    pub(crate) fn is_named_by(&self, source: Option<&str>) -> bool {
        self.sighting(source).is_some_and(|s| !s.ids.is_empty())
    }

    /// Whether `source` knows it as `id`.
    pub(crate) fn is_known_as(&self, source: Option<&str>, id: &str) -> bool {
        let sighting = self.sighting(source);
        sighting.is_some_and(|s| s.ids.iter().any(|known| known == id))
    }

    /// All cameras' ids for it.
    pub(crate) fn ids(&self) -> impl Iterator<Item = &String> {
        self.sightings.iter().flat_map(|sighting| &sighting.ids)
    }

    fn sighting(&self, source: Option<&str>) -> Option<&CameraRecord> {
        let mut sightings = self.sightings.iter();
        sightings.find(|sighting| sighting.source.as_deref() == source)
    }

    /// Notes that `robot` has dropped it at `now` [s].
    pub(crate) fn withhold(&mut self, robot: usize, now: f64) {
        let known = self.withheld.iter().position(|w| w.robot == robot);
        let at = known.unwrap_or_else(|| {
            self.withheld.push(Withheld {
                robot,
                times: 0,
                until: now,
            });
            self.withheld.len() - 1
        });
        let withheld = &mut self.withheld[at];
        let pause = FIRST_PAUSE * f64::from(2u32.pow(withheld.times.min(16)));
        withheld.times += 1;
        withheld.until = now + pause.min(LONGEST_PAUSE);
    }

    /// The time from which it may be offered to `robot` [s].
    pub(crate) fn offered_from(&self, robot: usize) -> f64 {
        let found = self.withheld.iter().find(|w| w.robot == robot);
        found.map_or(f64::NEG_INFINITY, |withheld| withheld.until)
    }

    /// Whether it is free and may be offered.
    pub(crate) fn is_admitted(&self) -> bool {
        self.state == ItemState::Free && !self.barred
    }

    /// Whether it may be offered to `robot`.
    pub(crate) fn is_open_to(&self, robot: usize) -> bool {
        self.is_admitted() && self.refused & (1 << robot) == 0
    }

    /// The task that it is reserved for.
    pub(crate) fn claimed_by(&self) -> Option<u64> {
        match self.state {
            ItemState::Claimed(task) => Some(task),
            _ => None,
        }
    }
}
