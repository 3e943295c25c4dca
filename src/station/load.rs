//! Stations by name: files and built-in stations.

use super::builtin::built_in;
use super::file::{BELT_SPEED, Overrides, SavedStrategy, parse_with_strategy};
use super::geometry::Station;
use crate::error::{Error, Result, nearest_file, shown};
use crate::files::is_path;
use std::path::{Path, PathBuf};

/// Loads the station of this name: the file with that name if there is one, otherwise
/// the built-in station.
///
/// # Errors
/// If the file cannot be read or breaks the schema; the error names the file, line and key. If
/// there is neither a file nor a built-in station with that name.
pub fn load(name: &str, overrides: Overrides) -> Result<Station> {
    load_with_strategy(name, overrides).map(|(station, _)| station)
}

/// Whether `name` refers to a file rather than a built-in station.
pub fn is_file(name: &str) -> bool {
    is_path(name) || Path::new(name).exists()
}

/// Like [`load`], but also returns the strategy that the file names. It is not validated here,
/// because this module does not know the strategies.
///
/// # Errors
/// See [`load`].
pub fn load_with_strategy(
    name: &str,
    overrides: Overrides,
) -> Result<(Station, Option<SavedStrategy>)> {
    match file_text(name)? {
        Some(text) => parse_with_strategy(&text, name, overrides),
        None => load_built_in(name, overrides).map(|station| (station, None)),
    }
}

/// The text of the file that `name` refers to; `None` if it refers to a built-in station.
///
/// # Errors
/// If the file cannot be read.
pub fn file_text(name: &str) -> Result<Option<String>> {
    if !is_file(name) {
        return Ok(None);
    }
    let path = Path::new(name);
    if let Some(station) = meant_built_in(path) {
        return Err(Error::path(
            name,
            "the file does not exist",
            format!("use `{station}` for the built-in station, or check the path"),
        ));
    }
    crate::files::read_text(path).map(Some)
}

/// The built-in station of this name, even if there is a file with that name.
///
/// # Errors
/// If there is none, or it cannot have these values.
pub fn load_built_in(name: &str, overrides: Overrides) -> Result<Station> {
    let with_extension = PathBuf::from(format!("{name}.toml"));
    let meant = match with_extension.is_file() {
        true => Some(with_extension),
        false => nearest_file(Path::new(name)),
    };
    let station = match (built_in(name), meant) {
        (Ok(station), _) => station,
        (Err(_), Some(file)) if is_toml(&file) => {
            return Err(Error::usage(
                "'station'",
                format!("`{}` is neither a file nor a built-in station", shown(name)),
                format!("did you mean {}?", shown(&file.display().to_string())),
            ));
        }
        (Err(error), _) => return Err(error),
    };
    let station = station.station(overrides.robots)?;
    match overrides.belt_speed {
        Some(speed) => station
            .with_belt_speed(speed)
            .map_err(|error| error.at(BELT_SPEED).into_usage()),
        None => Ok(station),
    }
}

fn is_toml(file: &Path) -> bool {
    file.extension()
        .is_some_and(|extension| extension == "toml")
}

/// The built-in station that a nonexistent file is probably meant to be.
fn meant_built_in(path: &Path) -> Option<&'static str> {
    if path.exists() || nearest_file(path).is_some() {
        return None;
    }
    let stem = path.file_stem()?.to_str()?;
    built_in(stem).ok().map(|station| station.name)
}
