//! `--save`: stores the winner of a search as the strategy in a station file.

use super::args::{Common, StationChoice};
use super::session::Session;
use pickline::error::{Error, Result};
use pickline::files;
use pickline::station::{self, Overrides, Station, edited, parse_with_strategy, to_toml};
use std::path::{Path, PathBuf};

/// The file to save a strategy in, checked before the search.
pub(crate) struct SaveTarget {
    path: PathBuf,
    /// The station file that the search is for; `None` for a built-in station.
    source: Option<PathBuf>,
    /// Settings that a new file changes relative to `source`.
    overrides: Overrides,
}

const FLAG: &str = "--save";

impl SaveTarget {
    /// Saves to `file`, or to the station's own file if that is `None`.
    ///
    /// # Errors
    /// A built-in station without a file to save to, a station that the flags make differ
    /// from its file, or a file that exists.
    pub(crate) fn new(choice: &StationChoice, file: Option<&Path>) -> Result<Self> {
        let name = &choice.station;
        let source = station::is_file(name).then(|| PathBuf::from(name));
        let Some(path) = file else {
            let Some(source) = source else {
                return Err(Error::usage(
                    FLAG,
                    format!("`{name}` is a built-in station, which has no file"),
                    "name a new file: --save my-line.toml",
                ));
            };
            if choice.robots.is_some() || choice.belt_speed.is_some() {
                return Err(Error::usage(
                    FLAG,
                    format!(
                        "--robots and --belt-speed change the line, so the strategy would not \
                         be for the line in {name}"
                    ),
                    "leave them out, or save the changed line as a new file: --save new.toml",
                ));
            }
            files::check_target(&source)?;
            files::check_not_read_only(FLAG, &source)?;
            // Fail now rather than after a search of minutes.
            files::try_target(&source)?;
            return Ok(Self {
                path: source.clone(),
                source: Some(source),
                overrides: Overrides::default(),
            });
        };
        if path.exists() {
            return Err(Error::path(
                FLAG,
                format!("{} already exists", path.display()),
                "name a new file; without a name, the strategy is written to the --station file",
            ));
        }
        files::check_target(path)?;
        Ok(Self {
            path: path.to_owned(),
            source,
            overrides: choice.overrides(),
        })
    }

    /// Writes the assignment `best` as the strategy of `station`, unless the search was interrupted,
    /// and says so.
    ///
    /// # Errors
    /// As for [`SaveTarget::write`].
    pub(crate) fn keep(
        &self,
        common: &Common,
        session: &Session,
        station: &Station,
        best: &[&str],
    ) -> Result<()> {
        if session.interrupted() {
            common.remark("nothing is saved because the search was interrupted");
            return Ok(());
        }
        if session.missing_shards().is_some() {
            common.remark("nothing is saved because shards are missing");
            return Ok(());
        }
        let saved = self.write(station, &format!("rules:{}", best.join(",")))?;
        common.remark(&saved);
        Ok(())
    }

    /// Writes `station`'s file with `strategy` as its strategy, and returns a message about it.
    ///
    /// # Errors
    /// A file that has changed since it was read, or that cannot be written.
    fn write(&self, station: &Station, strategy: &str) -> Result<String> {
        let name = self.path.display().to_string();
        let before = match &self.source {
            Some(source) => files::read_text(source)?,
            None => to_toml(station),
        };
        let overrides = match self.source {
            Some(_) => self.overrides,
            None => Overrides::default(),
        };
        let text = edited(&before, &name, strategy, overrides)?;
        // The new text must read back as the line that was searched for.
        let (again, saved) = parse_with_strategy(&text, &name, Overrides::default())?;
        if again != *station || saved.is_none_or(|saved| saved.text != strategy) {
            return Err(Error::input(
                FLAG,
                format!("{name} has changed during the search"),
                "run the search again",
            ));
        }
        files::write_whole(&self.path, text.as_bytes())?;
        Ok(format!(
            "saved {strategy} as the strategy of {name}; simulate, run, compare and sweep use it"
        ))
    }
}
