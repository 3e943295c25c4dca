//! Plausible ranges of the quantities on a real line, and the unit that was probably meant if a
//! value lies outside.
//!
//! A value that the model allows can still be a mistake: nothing stops a computation with a width
//! of 600, but no belt is 600 m wide. Such values give a [`Warning`], not an error. The ranges are
//! wide enough for every line from a laboratory bench to an airport, and narrow enough to catch a
//! usual value that is off by a factor of 1000.

use crate::error::{Error, rounded};
use std::fmt;

/// A value that is allowed but most likely wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Warning {
    /// File with key, or the flag.
    pub place: String,
    /// What is implausible, with the value found and the likely unit.
    pub problem: String,
    /// What to do if the value is wrong.
    pub cure: String,
}

impl Warning {
    /// A warning: `place` is where, `problem` names the value, `cure` says what to change.
    pub fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            problem: problem.into(),
            cure: cure.into(),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: {}\n  cure: {}", self.place, self.problem, self.cure)
    }
}

impl From<Warning> for Error {
    fn from(warning: Warning) -> Self {
        Self::input(warning.place, warning.problem, warning.cure)
    }
}

/// A unit that people often use by mistake.
#[derive(Debug)]
pub struct Unit {
    /// Its name in the plural, for the question in a warning.
    name: &'static str,
    /// Its symbol, shown after the value.
    symbol: &'static str,
    /// Factor that converts a value from this unit to the right one.
    factor: f64,
}

const fn unit(name: &'static str, symbol: &'static str, factor: f64) -> Unit {
    Unit {
        name,
        symbol,
        factor,
    }
}

/// Units of length, as factors of 1 m.
pub static LENGTHS: &[Unit] = &[
    unit("millimetres", "mm", 1e-3),
    unit("centimetres", "cm", 1e-2),
];
/// Units of speed, as factors of 1 m/s.
pub static SPEEDS: &[Unit] = &[
    unit("millimetres per second", "mm/s", 1e-3),
    unit("metres per minute", "m/min", 1.0 / 60.0),
];
/// Units of acceleration, as factors of 1 m/s^2.
static ACCELERATIONS: &[Unit] = &[unit("millimetres per second squared", "mm/s^2", 1e-3)];
/// Units of timestamps, as factors of 1 s.
pub static STAMPS: &[Unit] = &[
    unit("milliseconds", "ms", 1e-3),
    unit("microseconds", "us", 1e-6),
    unit("nanoseconds", "ns", 1e-9),
];
/// Units of probabilities, as factors of 1.
pub static SHARES: &[Unit] = &[unit("percent", "%", 1e-2)];
/// Units of angles, as factors of 1 rad.
pub static ANGLES: &[Unit] = &[unit("degrees", "deg", std::f64::consts::PI / 180.0)];
/// Units of position variances, as factors of 1 m^2.
pub static VARIANCES: &[Unit] = &[
    unit("square millimetres", "mm^2", 1e-6),
    unit("square centimetres", "cm^2", 1e-4),
];
static TIMES: &[Unit] = &[unit("milliseconds", "ms", 1e-3)];
static MILLISECONDS: &[Unit] = &[unit("seconds", "s", 1e3), unit("microseconds", "us", 1e-3)];
static FLOWS: &[Unit] = &[
    unit("items per hour", "items/h", 1.0 / 60.0),
    unit("items per second", "items/s", 60.0),
];
static AREAS: &[Unit] = &[
    unit("square millimetres", "mm^2", 1e-2),
    unit("square metres", "m^2", 1e4),
];

/// A quantity whose plausible range is known.
#[derive(Debug)]
pub struct Quantity {
    /// Its name, with the indefinite article.
    name: &'static str,
    /// Symbol of the right unit.
    symbol: &'static str,
    /// Name of the right unit.
    right: &'static str,
    low: f64,
    high: f64,
    /// The units in which it is often given by mistake.
    mistaken: &'static [Unit],
}

const fn length(name: &'static str, low: f64, high: f64) -> Quantity {
    Quantity {
        name,
        symbol: "m",
        right: "metres",
        low,
        high,
        mistaken: LENGTHS,
    }
}

const fn speed(name: &'static str, low: f64, high: f64) -> Quantity {
    Quantity {
        name,
        symbol: "m/s",
        right: "metres per second",
        low,
        high,
        mistaken: SPEEDS,
    }
}

const fn time(name: &'static str, low: f64, high: f64) -> Quantity {
    Quantity {
        name,
        symbol: "s",
        right: "seconds",
        low,
        high,
        mistaken: TIMES,
    }
}

/// Speed of a belt [m/s].
pub static BELT_SPEED: Quantity = speed("a belt speed", 5e-4, 5.0);
/// Step between tested belt speeds [m/s].
pub static SPEED_STEP: Quantity = speed("a step between belt speeds", 1e-6, 0.5);
/// Length of a belt [m].
pub(crate) static BELT_LENGTH: Quantity = length("a belt length", 0.1, 250.0);
/// Width of a belt [m].
pub static BELT_WIDTH: Quantity = length("a belt width", 0.02, 5.0);
/// Reach of an arm [m].
pub(crate) static REACH: Quantity = length("a reach", 0.05, 5.0);
/// Speed of an end effector [m/s].
pub(crate) static ARM_SPEED: Quantity = speed("an end-effector speed", 0.01, 20.0);
/// Acceleration of an end effector [m/s^2].
pub(crate) static ACCELERATION: Quantity = Quantity {
    name: "an acceleration",
    symbol: "m/s^2",
    right: "metres per second squared",
    low: 0.01,
    high: 2000.0,
    mistaken: ACCELERATIONS,
};
/// Height by which an arm lifts an item [m].
pub(crate) static LIFT: Quantity = length("a lift", 0.0, 1.0);
/// Length of a path in a table of travel times [m].
pub(crate) static PATH: Quantity = length("the length of a path", 0.0, 20.0);
/// Travel time of an end effector [s].
pub(crate) static TRAVEL_TIME: Quantity = time("a travel time", 0.0, 30.0);
/// Dwell time at a grasp or a release [s].
pub(crate) static DWELL: Quantity = time("a dwell time", 0.0, 10.0);
/// Distance between neighbouring bases along the belt [m].
pub(crate) static BASE_GAP: Quantity = length("a distance between neighbouring bases", 0.0, 20.0);
/// Distance of an item from the belt's centre line [m].
pub(crate) static OFF_CENTRE: Quantity = length("a distance from the belt's centre line", 0.0, 2.5);
/// Mean distance from one item to the next along the belt [m].
pub(crate) static ITEM_GAP: Quantity =
    length("a mean distance between items along the belt", 0.0, 10.0);
/// Position of an item along the belt, as a camera sees it [m]: from far upstream of the start to
/// the end of the longest belt.
pub static ITEM_PLACE: Quantity = length("a position along the belt", -25.0, 250.0);
/// Standard deviation of an item's distance from its cluster's centre [m].
pub static CLUSTER_SPREAD: Quantity = length("a cluster spread", 0.0, 5.0);
/// Mean length of an empty stretch of belt [m].
pub static GAP_LENGTH: Quantity = length("a mean length of an empty stretch", 0.01, 50.0);
/// Flow of items [1/min].
pub static FLOW: Quantity = Quantity {
    name: "a flow",
    symbol: "items/min",
    right: "items per minute",
    low: 0.1,
    high: 20_000.0,
    mistaken: FLOWS,
};
/// Jump of a track that is treated as a change to another item [m].
pub static SPLIT_DISTANCE: Quantity = length("a jump from one item to another", 1e-3, 2.0);
/// Distance within which two tracks belong to one item [m].
pub static MERGE_DISTANCE: Quantity = length("a distance between tracks of an item", 1e-4, 0.3);
/// Position error of a camera [m].
pub static POSITION_NOISE: Quantity = length("a position error", 0.0, 0.2);
/// Standard deviation of a position measured by a camera [m].
pub static DEVIATION: Quantity = length("a position's standard deviation", 0.0, 0.05);
/// Distance within which two detections belong to one item [m].
pub static TOLERANCE: Quantity = length("a distance between detections of an item", 0.0, 0.2);
/// Time until a message is sent again or given up on [s].
pub static TIMEOUT: Quantity = time("a timeout", 0.0, 120.0);
/// Length of a time slot [s].
pub static SLOT: Quantity = time("a time slot", 0.0, 5.0);
/// Time limit for one decision [ms].
pub static DECISION_TIME: Quantity = Quantity {
    name: "a decision time",
    symbol: "ms",
    right: "milliseconds",
    low: 0.05,
    high: 5000.0,
    mistaken: MILLISECONDS,
};
/// Area of an item [cm^2].
pub static ITEM_AREA: Quantity = Quantity {
    name: "an item area",
    symbol: "cm^2",
    right: "square centimetres",
    low: 0.01,
    high: 5000.0,
    mistaken: AREAS,
};

impl Quantity {
    /// A warning at `place` if `value` is not plausible. Infinite values and NaN give none;
    /// rejecting them is up to the reader of the value.
    pub fn check(&self, place: &str, value: f64) -> Option<Warning> {
        if !value.is_finite() || (self.low..=self.high).contains(&value) {
            return None;
        }
        let problem = format!(
            "{} {} is not plausible for {}{}",
            rounded(value, 9),
            self.symbol,
            self.name,
            self.question(value),
        );
        let cure = format!(
            "give {} [{}]; if the value is right, ignore this warning",
            self.right, self.symbol
        );
        Some(Warning::new(place, problem, cure))
    }

    /// The question which other unit was meant, for every unit in which `value` would be plausible;
    /// see [`question`].
    pub fn question(&self, value: f64) -> String {
        question(value, self.symbol, self.mistaken, |factor| {
            let meant = value * factor;
            meant != 0.0 && (self.low..=self.high).contains(&meant)
        })
    }
}

/// A warning at `place` if `hz` is not a plausible decision rate of a controller [Hz].
pub fn check_rate(place: &str, hz: f64) -> Option<Warning> {
    const PLAUSIBLE: std::ops::RangeInclusive<f64> = 0.1..=1e5;
    // 0 means no fixed rate.
    if hz == 0.0 || !hz.is_finite() || PLAUSIBLE.contains(&hz) {
        return None;
    }
    let shown = rounded(hz, 9);
    let meant = [
        ("the period in seconds", "s", 1.0 / hz),
        ("the period in milliseconds", "ms", 1e3 / hz),
        ("kilohertz", "kHz", 1e3 * hz),
    ];
    let meant = meant.iter().filter(|(.., hz)| PLAUSIBLE.contains(hz));
    let (names, values): (Vec<String>, Vec<String>) = meant
        .map(|(name, symbol, hz)| {
            let hz = rounded(*hz, 9);
            (
                (*name).to_owned(),
                format!("{shown} {symbol} means {hz} Hz"),
            )
        })
        .unzip();
    let question = match names.is_empty() {
        true => String::new(),
        false => format!("; {}? ({})", names.join(" or "), values.join(", ")),
    };
    Some(Warning::new(
        place,
        format!("{shown} Hz is not plausible for a decision rate{question}"),
        "give hertz [Hz]; if the value is right, ignore this warning",
    ))
}

/// `; millimetres? (600 mm is 0.6 m)`, with every unit in which `value` would fit; empty if there
/// is none.
pub fn question(value: f64, symbol: &str, units: &[Unit], fits: impl Fn(f64) -> bool) -> String {
    let likely: Vec<&Unit> = units.iter().filter(|unit| fits(unit.factor)).collect();
    if likely.is_empty() {
        return String::new();
    }
    let names: Vec<&str> = likely.iter().map(|unit| unit.name).collect();
    let values = likely.iter().map(|unit| {
        // The last digits are conversion noise. Timestamps have more significant digits.
        let digits = if value.abs() < 1e9 { 9 } else { 13 };
        let shown = |value: f64| rounded(value, digits);
        let (value, converted) = (shown(value), shown(value * unit.factor));
        let text = format!("{value} {} is {converted} {symbol}", unit.symbol);
        // Probabilities have no symbol.
        text.trim_end().to_owned()
    });
    let values: Vec<String> = values.collect();
    format!("; {}? ({})", names.join(" or "), values.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likely_units_are_named_with_the_value_in_the_right_one() {
        for (quantity, value, words) in [
            (
                &BELT_WIDTH,
                600.0,
                &["600 m", "belt width", "millimetres", "600 mm is 0.6 m"][..],
            ),
            (&BELT_WIDTH, 60.0, &["centimetres", "60 cm is 0.6 m"]),
            (&REACH, 565.0, &["millimetres", "0.565 m"]),
            (&DWELL, 100.0, &["milliseconds", "100 ms is 0.1 s"]),
            (&BELT_SPEED, 50.0, &["millimetres per second", "0.05 m/s"]),
            (&BELT_SPEED, 30.0, &["metres per minute", "0.5 m/s"]),
            (&ARM_SPEED, 500.0, &["0.5 m/s"]),
            (&ITEM_AREA, 8000.0, &["square millimetres", "80 cm^2"]),
            (&ITEM_AREA, 0.008, &["square metres", "80 cm^2"]),
            (&DECISION_TIME, 0.01, &["10 ms", "seconds?"]),
            (&BELT_SPEED, 1e-5, &["not plausible"]),
            (
                &FLOW,
                1e6,
                &["items per hour", "1000000 items/h is 16666.6667 items/min"],
            ),
            (&FLOW, 0.05, &["items per second", "3 items/min"]),
            (&CLUSTER_SPREAD, 100.0, &["millimetres", "0.1 m"]),
            (&GAP_LENGTH, 1000.0, &["millimetres", "1000 mm is 1 m"]),
            (&SPLIT_DISTANCE, 100.0, &["millimetres", "0.1 m"]),
            (&MERGE_DISTANCE, 20.0, &["millimetres", "0.02 m"]),
            (&ITEM_AREA, 14670977.999999998, &["14670978 cm^2 is not"]),
        ] {
            let warning = quantity.check("here", value).unwrap();
            let text = warning.to_string();
            for word in words {
                assert!(text.contains(word), "{word} not in {text}");
            }
            assert!(text.starts_with("here: ") && text.contains("cure: "));
        }
        let rate = check_rate("'update_hz'", 0.001).unwrap().to_string();
        assert!(
            rate.contains("period in seconds") && rate.contains("1000 Hz"),
            "{rate}"
        );
        for hz in [0.0, 0.5, 50.0, 1000.0, f64::NAN] {
            assert_eq!(check_rate("", hz), None);
        }
        assert!(!BELT_SPEED.check("", 1e-5).unwrap().problem.contains('?'));
        for (quantity, value) in [
            (&BELT_WIDTH, 0.1),
            (&DWELL, 0.0),
            (&REACH, 0.8),
            (&BELT_SPEED, 0.05),
            (&BELT_SPEED, f64::NAN),
        ] {
            assert_eq!(quantity.check("", value), None);
        }
    }
}
