//! What a policy was trained on, and how far a line differs from that.
//!
//! A network is not reliable on lines unlike those it was trained on; that it still gives an
//! answer does not mean that the answer is good.

use super::metadata::Metadata;
use crate::error::shown_number;
use crate::station::{Station, built_in};
use serde::{Deserialize, Serialize};

/// A line that exceeds a range by more than this share is far from the training. The belt speed
/// was varied by a quarter in training.
const FAR: f64 = 0.25;
/// Tolerance for rounding at the ends of a range.
const SLACK: f64 = 1e-9;
/// The metadata entry with the ranges.
const KEY: &str = "trained_on";
/// The quantity in which otherwise equal stations may differ.
const ROBOTS: &str = "robots";
/// The quantity that is varied in training.
const BELT_SPEED: &str = "belt speed";

/// The range of one quantity of lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Extent {
    /// Name of the quantity.
    pub quantity: String,
    /// Its unit; empty for counts.
    pub unit: String,
    /// The smallest value, in the unit of the quantity.
    pub low: f64,
    /// The largest value, in the unit of the quantity.
    pub high: f64,
}

/// The ranges of the quantities of stations that differ only in the number of robots.
type Ranges = Vec<Extent>;

/// The lines that a policy was trained on: the ranges of their quantities, apart for stations that
/// differ in more than the number of robots. A slow belt under slow arms and a fast one under
/// fast arms say nothing of a fast belt under slow arms.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct Trained {
    families: Vec<Ranges>,
}

/// A quantity in which a line differs from everything that a policy was trained on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outside {
    /// The range on the line that was asked about.
    pub line: Extent,
    /// The range on the lines of the training.
    pub trained: Extent,
}

/// The quantities of a line on which its robots' observations and the duration of a pick
/// depend.
fn extents(station: &Station) -> Vec<Extent> {
    let (belt, robots) = (station.belt(), station.robots());
    let extent = |quantity: &str, unit: &str, values: &[f64]| Extent {
        quantity: quantity.to_owned(),
        unit: unit.to_owned(),
        low: values.iter().copied().fold(f64::INFINITY, f64::min),
        high: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    };
    let each = |of: &dyn Fn(&crate::station::Robot) -> f64| -> Vec<f64> {
        robots.iter().map(of).collect()
    };
    let spacings: Vec<f64> = robots
        .windows(2)
        .map(|pair| pair[1].base.x - pair[0].base.x)
        .collect();
    let mut list = vec![
        extent(ROBOTS, "", &[robots.len() as f64]),
        extent(BELT_SPEED, "m/s", &[belt.speed]),
        extent("belt width", "m", &[belt.width]),
        extent("reach", "m", &each(&|robot| robot.reach)),
        extent("arm speed", "m/s", &each(&|robot| robot.cruising_speed())),
        extent(
            "grasp and release time",
            "s",
            &each(&|robot| robot.mean_dwell()),
        ),
        extent(
            "time to move a quarter of the reach",
            "s",
            &each(&|robot| robot.arm.time(0.25 * robot.reach)),
        ),
        extent("bins", "", &each(&|robot| robot.bins.len() as f64)),
    ];
    if !spacings.is_empty() {
        list.push(extent("spacing of the bases", "m", &spacings));
    }
    list
}

/// Whether all ranges but those of the numbers of robots are the same but for rounding.
fn are_alike(a: &[Extent], b: &[Extent]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SLACK * a.abs().max(b.abs());
    a.iter().filter(|e| e.quantity != ROBOTS).all(|extent| {
        let mut others = b.iter().filter(|e| e.quantity == extent.quantity);
        others.all(|other| is_near(other.low, extent.low) && is_near(other.high, extent.high))
    })
}

/// The ranges of stations, joined where they differ only in the number of robots.
fn joined(all: impl Iterator<Item = Ranges>) -> Vec<Ranges> {
    let mut families: Vec<Ranges> = Vec::new();
    for ranges in all {
        match families.iter_mut().find(|known| are_alike(known, &ranges)) {
            Some(known) => merge(known, ranges),
            None => families.push(ranges),
        }
    }
    families
}

/// Widens `known` by `more`.
fn merge(known: &mut Ranges, more: Ranges) {
    for extent in more {
        match known.iter_mut().find(|e| e.quantity == extent.quantity) {
            Some(known) => {
                known.low = known.low.min(extent.low);
                known.high = known.high.max(extent.high);
            }
            None => known.push(extent),
        }
    }
}

impl Trained {
    /// The ranges over `stations`, each with its belt speed times `speed`, the lowest and the
    /// highest factor.
    pub(crate) fn on(stations: &[Station], speed: (f64, f64)) -> Self {
        let ranges = |station: &Station| {
            let mut ranges = extents(station);
            for extent in &mut ranges {
                if extent.quantity == BELT_SPEED {
                    extent.low *= speed.0;
                    extent.high *= speed.1;
                }
            }
            ranges
        };
        let families = joined(stations.iter().map(ranges));
        Self { families }
    }

    /// Writes the ranges into a policy's metadata.
    pub(crate) fn write(&self, metadata: &mut Metadata) {
        // Numbers and texts can always be written as JSON.
        metadata.set(KEY, serde_json::to_string(self).unwrap_or_default());
    }

    /// Reads the ranges from a policy's metadata; `None` if there are none. Before policies were
    /// trained on several kinds of stations, a file had one list of ranges. Older files have no
    /// ranges but the names of their stations, which are known if they are built in.
    pub(crate) fn read(metadata: &Metadata) -> Option<Self> {
        if let Some(text) = metadata.get(KEY) {
            let families: Vec<Ranges> = serde_json::from_str(text).ok().or_else(|| {
                let one: Option<Ranges> = serde_json::from_str(text).ok();
                one.map(|ranges| vec![ranges])
            })?;
            let families = joined(families.into_iter());
            return Some(Self { families });
        }
        let record: serde_json::Value = serde_json::from_str(metadata.get("training")?).ok()?;
        let names = record["stations"].as_array()?.iter();
        let station = |name: &serde_json::Value| -> Option<Station> {
            let name = name.as_str()?;
            let (name, robots) = match name.split_once(':') {
                Some((name, robots)) => (name, Some(robots.parse().ok()?)),
                None => (name, None),
            };
            built_in(name).ok()?.station(robots).ok()
        };
        let stations: Vec<Station> = names.map(station).collect::<Option<_>>()?;
        let speed = &record["plan"]["domain"]["speed"];
        let speed = speed[0].as_f64().zip(speed[1].as_f64());
        Some(Self::on(&stations, speed.unwrap_or((1.0, 1.0))))
    }

    /// The quantities in which `station` differs from the most similar stations of the training; empty
    /// if it is within all ranges of any of them.
    pub(crate) fn outside(&self, station: &Station) -> Vec<Outside> {
        let line = extents(station);
        let beyond = |ranges: &Ranges| -> Vec<Outside> {
            let outside = |line: &Extent| {
                let trained = ranges.iter().find(|e| e.quantity == line.quantity)?;
                let outside = Outside {
                    trained: trained.clone(),
                    line: line.clone(),
                };
                (outside.excess() > SLACK).then_some(outside)
            };
            line.iter().filter_map(outside).collect()
        };
        let way = |outside: &Vec<Outside>| outside.iter().map(Outside::distance).sum::<f64>();
        let nearest = self.families.iter().map(beyond);
        nearest
            .min_by(|a, b| way(a).total_cmp(&way(b)))
            .unwrap_or_default()
    }
}

impl Outside {
    /// How far the line is outside, as a share of the nearer end of the range.
    pub(crate) fn excess(&self) -> f64 {
        let (line, trained) = (&self.line, &self.trained);
        let share = |gap: f64, end: f64| {
            if gap <= 0.0 {
                0.0
            } else if end > 0.0 {
                gap / end
            } else {
                f64::INFINITY
            }
        };
        let below = share(trained.low - line.low, trained.low);
        below.max(share(line.high - trained.high, trained.high))
    }

    /// The logarithm of the factor by which the line is outside: the same for twice as much and for half
    /// as much.
    fn distance(&self) -> f64 {
        let (line, trained) = (&self.line, &self.trained);
        let factor = (line.high / trained.high).max(trained.low / line.low);
        match factor.is_nan() {
            true => f64::INFINITY,
            false => factor.ln().max(0.0),
        }
    }

    /// Whether the line is far from the training in this quantity.
    pub(crate) fn is_far(&self) -> bool {
        self.excess() > FAR + SLACK
    }
}

impl std::fmt::Display for Outside {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let span = |extent: &Extent| {
            // Written as a user would: 1.6, not 1.5999999999999999.
            let [low, high] = [extent.low, extent.high].map(|v| (v * 1e6).round() / 1e6);
            let space = if extent.unit.is_empty() { "" } else { " " };
            if low == high {
                format!("{}{space}{}", shown_number(low), extent.unit)
            } else {
                format!(
                    "{} to {}{space}{}",
                    shown_number(low),
                    shown_number(high),
                    extent.unit
                )
            }
        };
        write!(
            f,
            "{} {} (trained on {})",
            self.line.quantity,
            span(&self.line),
            span(&self.trained)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper(robots: usize) -> Station {
        built_in("paper").unwrap().station(Some(robots)).unwrap()
    }

    #[test]
    fn a_line_is_as_far_as_its_quantities_say() {
        let trained = Trained::on(&[paper(2), paper(4)], (0.8, 1.25));
        assert!(trained.outside(&paper(3)).is_empty());
        let slower = paper(3).with_belt_speed(0.04).unwrap();
        assert!(trained.outside(&slower).is_empty());
        let five = trained.outside(&paper(5));
        assert_eq!(five.len(), 1);
        assert_eq!(five[0].to_string(), "robots 5 (trained on 2 to 4)");
        assert!(!five[0].is_far());
        let one = trained.outside(&paper(1));
        assert!(one[0].is_far());
        let fast = paper(2).with_belt_speed(0.4).unwrap();
        let fast = trained.outside(&fast);
        assert_eq!(
            fast[0].to_string(),
            "belt speed 0.4 m/s (trained on 0.04 to 0.0625 m/s)"
        );
        assert!((fast[0].excess() - 5.4).abs() < 1e-9);
        let mut metadata = Metadata::default();
        assert_eq!(Trained::read(&metadata), None);
        trained.write(&mut metadata);
        assert_eq!(Trained::read(&metadata), Some(trained.clone()));
        // A file from before there were several kinds of stations.
        let one = serde_json::to_string(&trained.families[0]).unwrap();
        metadata.set(KEY, one);
        assert_eq!(Trained::read(&metadata), Some(trained));
    }

    /// Ranges of unlike stations are not joined: what lies between them is like neither.
    #[test]
    fn a_line_is_compared_with_the_most_similar_station() {
        let delta = built_in("delta").unwrap().station(None).unwrap();
        let trained = Trained::on(&[paper(2), delta.clone(), paper(3)], (0.8, 1.25));
        assert_eq!(trained.families.len(), 2);
        assert!(trained.outside(&delta).is_empty() && trained.outside(&paper(3)).is_empty());
        let fast = paper(2).with_belt_speed(0.4).unwrap();
        assert_eq!(
            trained.outside(&fast)[0].to_string(),
            "belt speed 0.4 m/s (trained on 0.04 to 0.0625 m/s)"
        );
        let slow = delta.with_belt_speed(0.05).unwrap();
        assert!(trained.outside(&slow)[0].is_far());
    }
}
