//! `pickline station fit`.

use super::args::{FitArgs, LawArg, OutputFormat, StationChoice};
use super::outputs::{Outputs, WHOLE, rendered};
use super::session::Session;
use super::settings::{check_threads, on_threads};
use super::warnings::warn;
use pickline::error::{Error, Result};
use pickline::files;
use pickline::fit::{FitLaw, FitOptions, TimedMove, fit_line, fitted_station, read_moves};
use pickline::plausible::Warning;
#[cfg(feature = "mcap")]
use pickline::station::{Overrides, parse};
use pickline::station::{Station, to_toml};
#[cfg(feature = "mcap")]
use pickline_live::recording::{RecordingReader, read_recorded_moves};
use pickline_report::{
    ChartKind, FitReport, OutputProtection, Provenance, VerbReport as _, origin_comment,
};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// The station of verbs that are given none.
const USUAL: &str = "paper";
/// How an MCAP file begins.
const MCAP: [u8; 6] = *b"\x89MCAP0";

pub(crate) fn run(args: FitArgs, session: &Session) -> Result<()> {
    args.resolve()?.run(session)
}

/// A resolved call.
struct FitPlan {
    source: MovesSource,
    options: FitOptions,
    threads: Option<usize>,
    format: OutputFormat,
    chart: &'static ChartKind<FitReport>,
    out: Option<PathBuf>,
    svg: Option<PathBuf>,
}

/// The moves, and where they come from.
struct MovesSource {
    station: Station,
    station_name: String,
    moves: Vec<TimedMove>,
    /// Number of rows that are no moves.
    unused: usize,
    ignored: Vec<String>,
    /// The file, in words.
    description: String,
}

impl FitArgs {
    fn resolve(self) -> Result<FitPlan> {
        let options = FitOptions::default()
            .with_law(self.law.into())
            .with_lift(self.lift)
            .with_resamples(self.resamples)
            .with_seed(self.seed);
        options.check()?;
        check_threads(self.threads)?;
        let chart = ChartKind::named(FitReport::CHARTS, self.chart.as_deref());
        let chart = chart.map_err(|error| error.at("--chart"))?;
        let station = self.station.as_deref().map(Path::new);
        OutputProtection::of("station fit")
            .with_force(self.force)
            .check(
                &[("--station", station), ("the moves", Some(&self.moves))],
                &[
                    ("--out", self.out.as_deref()),
                    ("--svg", self.svg.as_deref()),
                ],
            )?;
        Ok(FitPlan {
            source: self.read()?,
            options,
            threads: self.threads,
            format: self.format,
            chart,
            out: self.out,
            svg: self.svg,
        })
    }

    fn read(&self) -> Result<MovesSource> {
        let mut start = Vec::new();
        let file = std::fs::File::open(&self.moves);
        let file = file.map_err(|error| Error::read(&self.moves, error))?;
        file.take(MCAP.len() as u64)
            .read_to_end(&mut start)
            .map_err(|error| Error::read(&self.moves, error))?;
        match start == MCAP {
            true => self.read_recording(),
            false => self.read_csv(),
        }
    }

    /// The station of this name, with its name.
    fn load(&self, name: &str) -> Result<(Station, String)> {
        let choice = StationChoice {
            station: name.to_owned(),
            robots: None,
            belt_speed: None,
            strict: self.strict,
        };
        Ok((choice.load()?, choice.station))
    }

    fn read_csv(&self) -> Result<MovesSource> {
        let name = self.moves.display().to_string();
        let (station, station_name) = self.load(self.station.as_deref().unwrap_or(USUAL))?;
        let text = files::read_text(&self.moves)?;
        if self.station.is_none() {
            // Unlike a recording, a file of moves does not say of which line it is.
            let assumed = Warning::new(
                "--station",
                format!("not given: {name} is taken for moves of the built-in station {USUAL}"),
                "give the station that the moves are of",
            );
            warn(self.strict, [assumed])?;
        }
        let read = read_moves(&text, &name, &station)?;
        Ok(MovesSource {
            station,
            station_name,
            moves: read.moves,
            unused: read.without_times,
            ignored: read.ignored,
            description: format!("moves of {name} (hash {})", files::fingerprint(text)),
        })
    }

    #[cfg(feature = "mcap")]
    fn read_recording(&self) -> Result<MovesSource> {
        let name = self.moves.display().to_string();
        let mut reader = RecordingReader::open(&self.moves)?;
        let (station, station_name) = match &self.station {
            Some(given) => self.load(given)?,
            None => {
                let text = &reader.heading.station;
                let station = parse(text, "its station", Overrides::default());
                (
                    station.map_err(|error| error.inside(&name))?,
                    format!("that of {name}"),
                )
            }
        };
        let read = read_recorded_moves(&mut reader, &station);
        let read = read.map_err(|error| error.inside(&name))?;
        Ok(MovesSource {
            station,
            station_name,
            moves: read.moves,
            unused: read.unused,
            ignored: Vec::new(),
            description: format!("recording {name}"),
        })
    }

    #[cfg(not(feature = "mcap"))]
    fn read_recording(&self) -> Result<MovesSource> {
        Err(Error::usage(
            self.moves.display().to_string(),
            "is a recording, which this build cannot read",
            "build with the feature mcap, or give a CSV file of moves",
        ))
    }
}

impl From<LawArg> for FitLaw {
    fn from(law: LawArg) -> Self {
        match law {
            LawArg::Auto => Self::Auto,
            LawArg::Speed => Self::Speed,
            LawArg::Trapezoid => Self::Trapezoid,
            LawArg::Table => Self::Table,
        }
    }
}

impl FitPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let MovesSource { station, moves, .. } = &self.source;
        let fit = on_threads(self.threads, || fit_line(station, moves, &self.options))?;
        let command = session.command();
        let made = Provenance::new(
            &command,
            &self.source.station_name,
            station,
            &self.source.description,
            self.options.seed,
        );
        let report = FitReport::new(station, &fit, made);
        let report = report.of_source(self.source.unused, self.source.ignored.clone());
        let text = rendered(&report, self.format, &WHOLE)?;
        let mut outputs = Outputs::default();
        outputs.try_add(self.svg.as_deref(), || {
            self.chart.svg(&report, report.provenance())
        });
        outputs.try_add(self.out.as_deref(), || {
            let fitted = fitted_station(station, &fit).map_err(|error| error.inside("--out"))?;
            Ok(origin_comment(&command) + &to_toml(&fitted))
        });
        outputs.deliver(session, &text)
    }
}
