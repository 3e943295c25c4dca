//! Values that are possible but most likely wrong: in millimetres, in metres per minute.
//!
//! Impossible values are refused ([`super::protocol::decode`]). The values here are used, but cause
//! a warning now and then, because with them a line picks nothing. Impossible extra fields of a
//! robot's state or result are removed; the rest of the message counts.

use super::protocol::{BeltState, Detection, FoundPlace, Incoming};
use pickline::error::shown_number;
use pickline::plausible::{
    BELT_SPEED, DEVIATION, ITEM_AREA, ITEM_PLACE, LENGTHS, SPEEDS, STAMPS, VARIANCES, Warning,
    question,
};
use pickline::station::Station;

/// A belt that is this many times as fast as the station says causes a warning.
const TIMES_AS_FAST: f64 = 10.0;
/// Minimum travel that is compared with the speed [m]; below it, rounding and noise dominate.
const LEAST_TRAVEL: f64 = 1e-3;
/// A `found` further than this [m] from the belt's start is impossible.
const FURTHEST_FOUND: f64 = 250.0;
/// An `available_at` is at most this long [s] before its message, and at most [`FREE_AFTER`] [s]
/// after it.
const FREE_BEFORE: f64 = 60.0;
const FREE_AFTER: f64 = 3600.0;

/// What values are judged by.
#[derive(Debug, Clone)]
pub(crate) struct Doubts {
    /// Speed of the belt in the station file [m/s].
    belt_speed: f64,
    last_belt: Option<BeltState>,
    found: Option<Warning>,
}

impl Doubts {
    /// Doubts about messages on `station`.
    pub(crate) fn new(station: &Station) -> Self {
        Self {
            belt_speed: station.belt().speed,
            last_belt: None,
            found: None,
        }
    }

    /// Takes the warning about the last message, if any. Its place is the kind of message with the
    /// field.
    pub(crate) fn take(&mut self) -> Option<Warning> {
        self.found.take()
    }

    /// Checks a message. Returns whether any of its values is doubtful. Impossible values in
    /// optional fields are removed.
    pub(crate) fn look(&mut self, message: &mut Incoming) -> bool {
        self.found = match message {
            Incoming::Detection(detection) => look_at_item(detection),
            Incoming::Belt(belt) => {
                let doubt = self
                    .look_at_speed(belt)
                    .or_else(|| self.look_at_travel(belt));
                self.last_belt = Some(belt.clone());
                doubt
            }
            Incoming::Robot(status) => take_out_time(
                "robot: available_at",
                status.stamp,
                &mut status.available_at,
            ),
            Incoming::Result(report) => {
                let place = take_out_place(&mut report.found);
                let field = "result: available_at";
                let time = take_out_time(field, report.stamp, &mut report.available_at);
                place.or(time)
            }
            _ => None,
        };
        self.found.is_some()
    }

    fn look_at_speed(&self, belt: &BeltState) -> Option<Warning> {
        let (speed, nominal) = (belt.speed.abs(), self.belt_speed);
        if let Some(doubt) = BELT_SPEED.check("belt: speed", speed) {
            // A stationary belt may drift a little.
            return (speed > 1.0).then_some(doubt);
        }
        let near = |speed: f64| (nominal / 2.0..=nominal * 2.0).contains(&speed);
        let meant = question(speed, "m/s", SPEEDS, |factor| near(speed * factor));
        if speed < TIMES_AS_FAST * nominal || meant.is_empty() {
            return None;
        }
        let problem = format!(
            "{} m/s is {:.0} times the station's {} m/s{meant}",
            shown_number(belt.speed),
            speed / nominal,
            shown_number(nominal),
        );
        let cure =
            "send metres per second [m/s]; or set the belt's usual speed in the station file";
        Some(Warning::new("belt: speed", problem, cure))
    }

    /// Compares the encoder with the speed.
    fn look_at_travel(&self, belt: &BeltState) -> Option<Warning> {
        let last = self.last_belt.as_ref()?;
        let travel = belt.position? - last.position?;
        let expected = last.speed * (belt.stamp - last.stamp);
        if expected.abs() < LEAST_TRAVEL {
            return None;
        }
        let fits = |factor: f64| (0.5..=2.0).contains(&(travel * factor / expected));
        let meant = question(travel, "m", LENGTHS, fits);
        if meant.is_empty() {
            return None;
        }
        let problem = format!(
            "the belt has travelled {} m, but its speed gives {} m{meant}",
            shown_number(travel),
            shown_number(expected),
        );
        Some(Warning::new("belt: position", problem, "send metres [m]"))
    }
}

/// Removes an impossible `found`.
fn take_out_place(found: &mut Option<FoundPlace>) -> Option<Warning> {
    let at = (*found)?;
    let sides = [("x", at.x), ("y", at.y)].into_iter();
    let mut wrong = sides.filter(|(_, value)| value.is_nan() || value.abs() > FURTHEST_FOUND);
    let (name, value) = wrong.next()?;
    *found = None;
    let problem = format!(
        "{} m is not on any belt, and is ignored{}",
        shown_number(value),
        ITEM_PLACE.question(value)
    );
    let cure = "send metres [m], in the belt frame";
    Some(Warning::new(format!("result: found.{name}"), problem, cure))
}

/// Removes an impossible `available_at` [s] from a message with the timestamp `stamp` [s].
fn take_out_time(place: &str, stamp: f64, available: &mut Option<f64>) -> Option<Warning> {
    let at = (*available)?;
    let fits = |at: f64| (stamp - FREE_BEFORE..=stamp + FREE_AFTER).contains(&at);
    if fits(at) {
        return None;
    }
    *available = None;
    let meant = if fits(stamp + at) {
        "; seconds from now?".to_owned()
    } else {
        question(at, "s", STAMPS, |factor| fits(at * factor))
    };
    let problem = format!(
        "{} s is not between {FREE_BEFORE} s before and an hour after the message's timestamp, {} \
         s, and is ignored{meant}",
        shown_number(at),
        shown_number(stamp),
    );
    Some(Warning::new(
        place,
        problem,
        "send a time on the same clock as timestamps [s]",
    ))
}

fn look_at_item(detection: &Detection) -> Option<Warning> {
    let place = |field: &str| format!("detection: {field}");
    let deviation = |[xx, _, yy]: [f64; 3]| {
        let variance = xx.max(yy);
        let mut doubt = DEVIATION.check(&place("covariance"), variance.sqrt())?;
        let meant = question(variance, "m^2", VARIANCES, |factor| {
            (variance * factor).sqrt() <= 0.05
        });
        doubt.problem = format!(
            "a variance of {} m^2 is a standard deviation of {:.3} m: everything within three of \
             them is treated as one item{meant}",
            shown_number(variance),
            variance.sqrt(),
        );
        doubt.cure = "send square metres [m^2]; omit the field if it is not known".into();
        Some(doubt)
    };
    ITEM_PLACE
        .check(&place("x"), detection.x)
        .or_else(|| ITEM_AREA.check(&place("area_cm2"), detection.area_cm2?))
        .or_else(|| deviation(detection.covariance?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::decode;
    use pickline::station::built_in;

    fn doubts() -> Doubts {
        Doubts::new(&built_in("paper").unwrap().station(Some(2)).unwrap())
    }

    fn look(doubts: &mut Doubts, fields: &str) -> Option<String> {
        let mut message = decode(format!("{{{fields}}}").as_bytes()).unwrap();
        let is_doubtful = doubts.look(&mut message);
        let found = doubts.take().map(|doubt| doubt.to_string());
        assert_eq!(is_doubtful, found.is_some());
        found
    }

    #[test]
    fn likely_units_are_asked_for() {
        for (fields, words) in [
            (
                r#""kind":"detection","stamp":1,"x":-40,"y":0"#,
                &["detection: x", "-40 mm is -0.04 m"][..],
            ),
            (
                r#""kind":"detection","stamp":1,"x":0,"y":0,"area_cm2":8000"#,
                &["area_cm2", "8000 mm^2 is 80 cm^2"],
            ),
            (
                r#""kind":"detection","stamp":1,"x":0,"y":0,"covariance":[0.01,0,0.01]"#,
                &["covariance", "one item", "0.01 mm^2 is 1e-8 m^2"],
            ),
            (
                r#""kind":"belt","stamp":1,"speed":6"#,
                &["6 m/s", "6 m/min is 0.1 m/s"],
            ),
            // The station says 0.05 m/s.
            (
                r#""kind":"belt","stamp":1,"speed":3"#,
                &["60 times the station's 0.05 m/s", "metres per minute?"],
            ),
        ] {
            let text = look(&mut doubts(), fields).unwrap();
            for word in words {
                assert!(text.contains(word), "{word} not in {text}");
            }
        }
        for fields in [
            r#""kind":"detection","stamp":1,"x":-3,"y":0,"area_cm2":80,"covariance":[1e-6,0,1e-6]"#,
            r#""kind":"belt","stamp":1,"speed":0"#,
            r#""kind":"belt","stamp":1,"speed":-1e-5"#,
            r#""kind":"belt","stamp":1,"speed":0.4"#,
        ] {
            assert_eq!(look(&mut doubts(), fields), None, "{fields}");
        }
    }

    #[test]
    fn an_encoder_in_millimetres_is_found_by_its_speed() {
        let run = |factor: f64| {
            let mut doubts = doubts();
            let mut found = None;
            for i in 0..20 {
                let position = 0.05 * f64::from(i) * factor;
                let fields =
                    format!(r#""kind":"belt","stamp":{i},"speed":0.05,"position":{position}"#);
                found = found.or(look(&mut doubts, &fields));
            }
            found
        };
        assert_eq!(run(1.0), None);
        assert!(run(1e3).unwrap().contains("millimetres?"));
        assert!(run(1e2).unwrap().contains("centimetres?"));
    }
}
