//! `pickline check`.

use super::args::{CheckArgs, OutputFormat, StationChoice};
use super::outputs::{WHOLE, rendered};
use super::session::{Session, tell};
use super::settings::{load_pattern, read_stdin};
use super::warnings::warn;
use pickline::checker::{PicksFile, Terms, read_picks, violations};
use pickline::error::{Error, Result};
use pickline::files;
use pickline::pattern::Pattern;
use pickline::plausible::Warning;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline_report::{Provenance, VerificationReport};

pub(crate) fn run(args: CheckArgs, session: &Session) -> Result<()> {
    args.resolve()?.run(session)
}

/// A resolved call.
struct CheckPlan {
    choice: StationChoice,
    station: Station,
    pattern: Pattern,
    /// The pattern and the picks, in words.
    sources: String,
    picks: PicksFile,
    terms: Terms,
    format: OutputFormat,
}

impl CheckArgs {
    fn resolve(self) -> Result<CheckPlan> {
        let terms = Terms::default()
            .with_tolerance(self.tolerance)
            .with_camera_x(self.camera_x)
            .with_update_hz(self.update_hz);
        terms.check()?;
        let conditions = Conditions::default()
            .with_camera_x(self.camera_x)
            .with_update_hz(self.update_hz);
        conditions.check()?;
        let is_piped = self.picks.as_os_str() == "-";
        if is_piped && self.pattern.as_deref() == Some("-") {
            return Err(Error::usage(
                "--pattern",
                "stdin is used for the picks",
                "give one of the two as a file",
            ));
        }
        let station = self.station.load()?;
        let (pattern, pattern_name) = load_pattern(self.pattern.as_deref(), station.belt().width)?;
        self.station.check_conditions(&conditions, &station)?;
        let place = self.pattern.as_deref().unwrap_or(&pattern_name);
        self.station
            .check_pattern(place, &pattern, Some(&station))?;
        pattern.check_on(&station).map_err(|e| e.inside(place))?;
        let (name, text) = match is_piped {
            true => ("stdin".to_owned(), read_stdin()?),
            false => (
                self.picks.display().to_string(),
                files::read_text(&self.picks)?,
            ),
        };
        let picks = read_picks(&text, &name, &station, &pattern)?;
        if picks.attempts.is_empty() {
            let problem = "has a header, but no picks";
            let cure = "give the file that the line wrote";
            warn(self.station.strict, [Warning::new(&name, problem, cure)])?;
        }
        if self.pattern.is_none() && !self.quiet {
            tell(&format!("checking {name} against {pattern_name}"));
        }
        Ok(CheckPlan {
            choice: self.station,
            sources: format!(
                "{pattern_name}; picks of {name} (hash {})",
                files::fingerprint(text)
            ),
            station,
            pattern,
            picks,
            terms,
            format: self.format,
        })
    }
}

impl CheckPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let (station, pattern) = (&self.station, &self.pattern);
        let found = violations(station, pattern, &self.picks.attempts, self.terms);
        let made = Provenance::new(
            &session.command(),
            &self.choice.station,
            station,
            &self.sources,
            0,
        );
        let made = made.without_seed().under_facts(self.terms.describe());
        let (picks, terms) = (&self.picks, self.terms);
        let report = VerificationReport::new(station, pattern, picks, &found, terms, made);
        session.print(rendered(&report, self.format, &WHOLE)?.as_bytes())?;
        report.verdict()
    }
}
