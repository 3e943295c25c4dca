//! The ranges of the controller's settings.

use super::Config;
use crate::clock::ClockKind;
use pickline::error::{Error, Result, counted, shown, shown_number};
use pickline::station::Station;
use std::ops::RangeInclusive;

/// Lead times of a robot [s].
const LEAD: RangeInclusive<f64> = 0.0..=60.0;

impl Config {
    /// Delays of pictures [s].
    pub const CAMERA_DELAYS: RangeInclusive<f64> = -10.0..=10.0;

    /// Checks that every setting is in its range, and that no robot is missing for a lead time. The
    /// errors name the settings as `pickline run` does; [`Timeouts::belt`](crate::Timeouts::belt) is
    /// `'belt_timeout'`.
    ///
    /// # Errors
    /// [`Usage`](pickline::error::ErrorKind::Usage): the first setting that is out of range.
    pub fn check(&self, station: &Station) -> Result<()> {
        check_range("'tolerance'", self.tolerance, 0.0..=1.0, "m")?;
        check_range("'ack_timeout'", self.ack_timeout, 1e-3..=1e3, "s")?;
        check_range("'result_timeout'", self.result_timeout, 1e-3..=1e4, "s")?;
        for (setting, silence) in [
            ("'belt_timeout'", self.timeouts.belt),
            ("'robot_timeout'", self.timeouts.robot),
        ] {
            if let Some(silence) = silence.filter(|silence| *silence != 0.0) {
                check_range(setting, silence, 0.01..=1e4, "s, or 0 to disable it")?;
            }
        }
        let delay = self.camera_delay;
        check_range("'camera_delay'", delay, Self::CAMERA_DELAYS, "s")?;
        if self.status_every != 0.0 {
            let least = match self.clock {
                ClockKind::System => 0.01,
                // Time may jump by an hour, which sends all its statuses at once.
                ClockKind::Messages => 0.1,
            };
            let unit = "s, or 0 for only the last one";
            check_range("'status_every'", self.status_every, least..=1e6, unit)?;
        }
        check_range("'min_detection'", self.min_detection, 0.0..=1.0, "")?;
        check_range("'stop_margin'", self.stop_margin, 0.0..=1e3, "s")?;
        // These have no flag, so they are named by their fields.
        check_range("view_from", self.view_from, -1e6..=1e6, "m")?;
        check_count("most_attempts", self.most_attempts > 0)?;
        check_count("most_items", self.most_items > 0)?;
        self.check_lead(station.robots().len())
    }

    fn check_lead(&self, robots: usize) -> Result<()> {
        if self.lead.len() > robots {
            let (times, robots) = (self.lead.len(), counted(robots, "robot"));
            return Err(Error::usage(
                "'lead'",
                format!("{} for {robots}", counted(times, "lead time")),
                "give at most one for each robot, upstream first",
            ));
        }
        let mut lead = self.lead.iter();
        lead.try_for_each(|seconds| check_range("'lead'", *seconds, LEAD, "s"))
    }
}

/// The lead time of each robot for [`Config::lead`] [s], from texts `S` for all robots and `NAME=S`
/// for one. A value for one robot overrides a value for all, whatever their order.
///
/// # Errors
/// [`Usage`](pickline::error::ErrorKind::Usage): a value that is not a time or is out of range, or a
/// robot that the station does not have.
pub fn lead_times(given: &[String], station: &Station) -> Result<Vec<f64>> {
    let robots = station.robots();
    let mut lead = vec![0.0; robots.len()];
    let (one, all): (Vec<&String>, Vec<&String>) = given.iter().partition(|t| t.contains('='));
    for text in all.into_iter().chain(one) {
        let (name, time) = match text.rsplit_once('=') {
            Some((name, time)) => (Some(name), time),
            None => (None, text.as_str()),
        };
        let seconds: f64 = time.trim().parse().map_err(|_| {
            let problem = format!("`{}` is not a time", shown(text));
            let cure = "give seconds for all robots, such as 0.1, or for one robot, such as r1=0.1";
            Error::usage("'lead'", problem, cure)
        })?;
        check_range("'lead'", seconds, LEAD, "s")?;
        let Some(name) = name else {
            lead.fill(seconds);
            continue;
        };
        let Some(index) = robots.iter().position(|robot| robot.name == name) else {
            let known: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
            return Err(Error::usage(
                "'lead'",
                format!("there is no robot `{}`", shown(name)),
                format!("give one of {}", known.join(", ")),
            ));
        };
        lead[index] = seconds;
    }
    Ok(lead)
}

/// Checks that the value of `setting` is in `range`; NaN is in none.
///
/// # Errors
/// A value outside the range. The cure gives the range in `unit`.
fn check_range(setting: &str, value: f64, range: RangeInclusive<f64>, unit: &str) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (shown_number(*range.start()), shown_number(*range.end()));
    Err(Error::usage(
        setting,
        format!("{} is out of range", shown_number(value)),
        format!("give {low} to {high} {unit}").trim_end(),
    ))
}

fn check_count(setting: &str, is_positive: bool) -> Result<()> {
    match is_positive {
        true => Ok(()),
        false => Err(Error::usage(
            setting,
            "0 is out of range",
            "give at least 1",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Timeouts;
    use pickline::error::ErrorKind;
    use pickline::station::built_in;

    fn station() -> Station {
        built_in("paper").unwrap().station(Some(2)).unwrap()
    }

    fn plain() -> Config {
        Config::default()
    }

    fn silence(seconds: f64) -> Timeouts {
        Timeouts::default().with_belt(seconds)
    }

    #[test]
    fn the_ends_of_every_range_are_allowed() {
        let messages = |every| {
            let config = plain().with_clock(ClockKind::Messages);
            config.with_status_every(every)
        };
        for config in [
            plain(),
            plain().with_tolerance(0.0),
            plain().with_tolerance(1.0),
            plain().with_ack_timeout(1e-3),
            plain().with_result_timeout(1e4),
            plain().with_timeouts(silence(0.0).with_robot(0.01)),
            plain().with_camera_delay(-10.0),
            plain().with_status_every(0.01),
            messages(0.0),
            messages(0.1),
            plain().with_lead(vec![60.0, 0.0]),
            plain().with_stop_margin(1e3),
            plain().with_min_detection(1.0),
        ] {
            config.check(&station()).unwrap();
        }
    }

    #[test]
    fn values_out_of_range_are_refused_with_setting_and_cure() {
        let every = plain().with_clock(ClockKind::Messages);
        let robot = Timeouts::default().with_robot(f64::NAN);
        for (config, message) in [
            (
                plain().with_tolerance(-1.0),
                "'tolerance': -1 is out of range\n  cure: give 0 to 1 m",
            ),
            (
                plain().with_ack_timeout(0.0),
                "'ack_timeout': 0 is out of range\n  cure: give 0.001 to 1000 s",
            ),
            (
                plain().with_result_timeout(f64::INFINITY),
                "'result_timeout': inf is out of range\n  cure: give 0.001 to 10000 s",
            ),
            (
                plain().with_timeouts(silence(-1.0)),
                "'belt_timeout': -1 is out of range\n  cure: give 0.01 to 10000 s, or 0 to disable it",
            ),
            (
                plain().with_timeouts(robot),
                "'robot_timeout': NaN is out of range\n  cure: give 0.01 to 10000 s, or 0 to disable it",
            ),
            (
                plain().with_camera_delay(11.0),
                "'camera_delay': 11 is out of range\n  cure: give -10 to 10 s",
            ),
            (
                every.with_status_every(0.05),
                "'status_every': 0.05 is out of range\n  cure: give 0.1 to 1000000 s, or 0 for \
                 only the last one",
            ),
            (
                plain().with_stop_margin(-0.1),
                "'stop_margin': -0.1 is out of range\n  cure: give 0 to 1000 s",
            ),
            (
                plain().with_min_detection(1.1),
                "'min_detection': 1.1 is out of range\n  cure: give 0 to 1",
            ),
            (
                plain().with_view_from(f64::NAN),
                "view_from: NaN is out of range\n  cure: give -1000000 to 1000000 m",
            ),
            (
                plain().with_most_attempts(0),
                "most_attempts: 0 is out of range\n  cure: give at least 1",
            ),
            (
                plain().with_most_items(0),
                "most_items: 0 is out of range\n  cure: give at least 1",
            ),
            (
                plain().with_lead(vec![f64::NAN, -3.0]),
                "'lead': NaN is out of range\n  cure: give 0 to 60 s",
            ),
            (
                plain().with_lead(vec![0.0; 3]),
                "'lead': 3 lead times for 2 robots\n  cure: give at most one for each robot, \
                 upstream first",
            ),
        ] {
            let error = config.check(&station()).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Usage, "{error}");
            assert_eq!(error.to_string(), message);
        }
    }

    #[test]
    fn lead_times_are_read_for_all_robots_and_for_one() {
        let read = |texts: &[&str]| {
            let texts: Vec<String> = texts.iter().map(|text| (*text).to_owned()).collect();
            lead_times(&texts, &station())
        };
        assert_eq!(read(&[]).unwrap(), [0.0, 0.0]);
        assert_eq!(read(&["0.5"]).unwrap(), [0.5, 0.5]);
        assert_eq!(read(&["r2=0.25", "2"]).unwrap(), [2.0, 0.25]);
        for (text, words) in [
            ("soon", "'lead': `soon` is not a time"),
            ("r1=-1", "'lead': -1 is out of range"),
            ("r9=1", "there is no robot `r9`\n  cure: give one of r1, r2"),
            ("=1", "there is no robot ``"),
        ] {
            let message = read(&[text]).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
