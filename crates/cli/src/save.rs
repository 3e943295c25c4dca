//! `--save`: the winner of a search becomes the strategy of a station file.

use super::args::StationChoice;
use pickline::error::{Error, Result};
use pickline::files;
use pickline::station::{self, Overrides, Station, edited, parse_with_strategy, to_toml};
use std::path::{Path, PathBuf};

/// Where a strategy is to be saved, checked before the search.
pub struct Target {
    path: PathBuf,
    /// The station file that it was found for; none of a built-in station.
    source: Option<PathBuf>,
    /// What a new file says otherwise than that.
    overrides: Overrides,
}

const FLAG: &str = "--save";

impl Target {
    /// Where `file`, or the file of the station where there is none, is.
    ///
    /// # Errors
    /// A built-in station with no file to save to, a station that the flags make another
    /// than its file's, a file that exists.
    pub fn new(choice: &StationChoice, file: Option<&Path>) -> Result<Self> {
        let name = &choice.station;
        let source = station::is_file(name).then(|| PathBuf::from(name));
        let Some(path) = file else {
            let Some(source) = source else {
                return Err(Error::input(
                    FLAG,
                    format!("`{name}` is a built-in station, which has no file"),
                    "name a new file: --save my-line.toml",
                ));
            };
            if choice.robots.is_some() || choice.belt_speed.is_some() {
                return Err(Error::input(
                    FLAG,
                    format!(
                        "--robots and --belt-speed make another line than that of {name}, which \
                         would get its strategy"
                    ),
                    "drop them, or save the other line as a new file: --save new.toml",
                ));
            }
            files::check_target(&source)?;
            files::check_not_read_only(FLAG, &source)?;
            // The search may take minutes.
            files::try_target(&source)?;
            return Ok(Self {
                path: source.clone(),
                source: Some(source),
                overrides: Overrides::default(),
            });
        };
        if path.exists() {
            return Err(Error::input(
                FLAG,
                format!("{} exists", path.display()),
                "name a new file; without a name the strategy is written into the file of \
                 --station",
            ));
        }
        files::check_target(path)?;
        Ok(Self {
            path: path.to_owned(),
            source,
            overrides: choice.overrides(),
        })
    }

    /// Writes `station`'s file with `strategy` as its strategy, and says what was done.
    ///
    /// # Errors
    /// A file that has become another since it was read, or that cannot be written.
    pub fn write(&self, station: &Station, strategy: &str) -> Result<String> {
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
        // Nothing is written that would not be read back as what was searched for.
        let (again, saved) = parse_with_strategy(&text, &name, Overrides::default())?;
        if again != *station || saved.is_none_or(|saved| saved.text != strategy) {
            return Err(Error::input(
                FLAG,
                format!("{name} is no longer the line that was searched for"),
                "search again with the file as it is now",
            ));
        }
        files::write_whole(&self.path, text.as_bytes())?;
        Ok(format!(
            "saved {strategy} as the strategy of {name}; simulate, run, compare and sweep use it"
        ))
    }
}
