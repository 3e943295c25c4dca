//! Profiles: the flow over a shift.

use super::item::MOST_ITEMS;
use crate::csv_file::CsvFile;
use crate::error::{Error, Result, known_names, shown, shown_number};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::Exp1;
use std::path::Path;

const COLUMNS: [&str; 2] = ["time_s", "flow_per_min"];
/// Longer times, more than a year, are treated as a typing mistake [s].
const LONGEST: f64 = 4e7;

/// The flow [1/min] over time [s], interpolated linearly between its rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Profile {
    name: String,
    /// Time since the first row [s] and flow [1/min]. At least two points in order of time; two
    /// points at the same time are a step.
    points: Vec<(f64, f64)>,
}

impl Profile {
    /// Reads a profile: CSV with the columns `time_s` and `flow_per_min`.
    ///
    /// # Errors
    /// If the file cannot be read, or the first problem in it, with its line.
    pub(super) fn load(path: &Path) -> Result<Self> {
        Self::parse(&crate::files::read_text(path)?, &path.display().to_string())
    }

    pub(super) fn parse(text: &str, name: &str) -> Result<Self> {
        let mut file = CsvFile::new(text, name);
        let [time, flow] = columns(&mut file, name)?;
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut record = csv::StringRecord::new();
        while let Some(line) = file.next(&mut record)? {
            let mut read = |place: usize, column: usize, most: f64| {
                let text = record.get(place).unwrap_or_default();
                let place = format!("{name}:{line}: {}", COLUMNS[column]);
                number(&mut file, text, place, most)
            };
            let (time, flow) = (read(time, 0, LONGEST)?, read(flow, 1, 1e6)?);
            if let Some((before, _)) = points.last().filter(|(before, _)| *before > time) {
                return Err(Error::input(
                    format!("{name}:{line}: time_s"),
                    format!(
                        "{} s follows {} s",
                        shown_number(time),
                        shown_number(*before)
                    ),
                    "sort the rows by time; two rows with the same time are a step",
                ));
            }
            points.push((time, flow));
        }
        let start = points.first().map_or(0.0, |point| point.0);
        points.iter_mut().for_each(|point| point.0 -= start);
        let profile = Self {
            name: name.to_owned(),
            points,
        };
        if profile.duration() <= 0.0 || profile.mean_flow() <= 0.0 {
            return Err(Error::input(
                name,
                "the profile has no duration or zero flow",
                "give at least two rows with different times, and a flow greater than 0",
            ));
        }
        Ok(profile)
    }

    /// The name of the file, for messages.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Time from the first row to the last [s].
    pub(super) fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.0)
    }

    /// Mean flow over the duration [1/min].
    pub(super) fn mean_flow(&self) -> f64 {
        let piece = |pair: &[(f64, f64)]| (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1) / 2.0;
        self.points.windows(2).map(piece).sum::<f64>() / self.duration()
    }

    /// Rejects a profile that yields more items than a pattern may have if its flow is multiplied
    /// by `scale`.
    ///
    /// # Errors
    /// If there are too many items.
    pub(super) fn check_items(&self, scale: f64) -> Result<()> {
        let items = scale * self.mean_flow() * self.duration() / 60.0;
        if items <= MOST_ITEMS as f64 {
            return Ok(());
        }
        Err(Error::input(
            &*self.name,
            format!("the profile yields about {items:.3e} items"),
            format!("use lower flows or a shorter time; a pattern has at most {MOST_ITEMS} items"),
        ))
    }

    /// At most `count` arrivals of an inhomogeneous Poisson process with `scale` times this flow,
    /// by thinning: arrivals are drawn at the maximum flow, and each is kept with the ratio of the
    /// current flow to the maximum (Lewis and Shedler, "Simulation of nonhomogeneous Poisson
    /// processes by thinning", Naval Research Logistics Quarterly 26, 1979, DOI
    /// 10.1002/nav.3800260304). `place` maps an arrival time [s] to the position of the item.
    pub(super) fn arrivals(
        &self,
        scale: f64,
        count: usize,
        rng: &mut ChaCha8Rng,
        place: impl Fn(f64, &mut ChaCha8Rng) -> (f64, f64),
    ) -> Vec<(f64, f64)> {
        let highest = self.points.iter().map(|point| point.1).fold(0.0, f64::max);
        let mean_step = 60.0 / (scale * highest);
        let mut places = Vec::new();
        let (mut time, mut piece) = (0.0, 0);
        while places.len() < count {
            time += mean_step * rng.sample::<f64, _>(Exp1);
            if time > self.duration() {
                break;
            }
            while self.points[piece + 1].0 < time {
                piece += 1;
            }
            let [(from, low), (to, high)] = [self.points[piece], self.points[piece + 1]];
            let flow = low + (high - low) * (time - from) / (to - from);
            if rng.random::<f64>() * highest < flow {
                places.push(place(time, rng));
            }
        }
        places
    }
}

/// The places of [`COLUMNS`] in the header of `file`, which messages call `name`.
fn columns(file: &mut CsvFile, name: &str) -> Result<[usize; COLUMNS.len()]> {
    let (header, line) = file.header()?;
    let mut places = [None; COLUMNS.len()];
    for (place, column) in header.iter().enumerate() {
        let Some(known) = COLUMNS.iter().position(|&known| known == column) else {
            return Err(Error::input(
                format!("{name}:{line}: column {}", place + 1),
                format!("unknown column `{}`", shown(column)),
                if column.starts_with("time") {
                    format!("{}; give seconds", known_names(column, &COLUMNS))
                } else {
                    known_names(column, &COLUMNS)
                },
            ));
        };
        places[known] = Some(place);
    }
    match places {
        [Some(time), Some(flow)] => Ok([time, flow]),
        _ => Err(Error::input(
            format!("{name}:{line}"),
            "a profile has two columns",
            "start it with the header `time_s,flow_per_min`",
        )),
    }
}

/// The field `text` of `file`, at `place`, as a number from 0 to `most`.
fn number(file: &mut CsvFile, text: &str, place: String, most: f64) -> Result<f64> {
    let found = file.number(text);
    if let Ok(number) = found
        && (0.0..=most).contains(&number)
    {
        return Ok(number);
    }
    let cure = if place.ends_with(COLUMNS[0]) {
        "give seconds from the start, for example 5400"
    } else if text.trim_start().starts_with('-') || text.contains("nan") {
        "give items per minute, 0 where none arrive"
    } else {
        file.number_cure()
    };
    let problem = format!("`{}` is not a number from 0 to {most:e}", shown(text));
    let wrong = Error::input(place, problem, cure);
    Err(match found {
        Ok(_) => wrong,
        Err(cause) => wrong.caused_by(cause),
    })
}
