//! Warnings about what is allowed but most likely wrong: printed once, or errors with
//! `--strict`.

use super::args::StationChoice;
use super::session::tell;
use pickline::error::{Error, Result, counted};
use pickline::pattern::{Pattern, PatternSet};
use pickline::plausible::{POSITION_NOISE, Quantity, Warning, check_rate};
use pickline::sim::Conditions;
use pickline::station::Station;

/// Prints `warnings`, even with `--quiet`, as nothing may go wrong silently.
///
/// # Errors
/// The first of them, if `strict`.
pub(crate) fn warn(strict: bool, warnings: impl IntoIterator<Item = Warning>) -> Result<()> {
    let warnings: Vec<Warning> = warnings.into_iter().collect();
    if strict && let Some(first) = warnings.first() {
        let more = warnings.len() - 1;
        let mut warning = first.clone();
        if more > 0 {
            let others = counted(more, "more warning");
            warning.problem += &format!("; and {others}, shown without --strict");
        }
        let is_flag = warning.place.starts_with("--");
        let error = Error::from(warning);
        return Err(match is_flag {
            true => error.into_usage(),
            false => error,
        });
    }
    for warning in &warnings {
        tell(&format!("warning: {warning}"));
    }
    Ok(())
}

impl StationChoice {
    /// Warns about implausible values of flags.
    ///
    /// # Errors
    /// As for [`warn`].
    pub(crate) fn check_values(&self, values: &[(&str, &Quantity, Option<f64>)]) -> Result<()> {
        let check = |(flag, quantity, value): &(&str, &Quantity, Option<f64>)| {
            value.and_then(|value| quantity.check(flag, value))
        };
        warn(self.strict, values.iter().filter_map(check))
    }

    /// Warns about conditions that are implausible on `station`.
    ///
    /// # Errors
    /// As for [`warn`].
    pub(crate) fn check_conditions(
        &self,
        conditions: &Conditions,
        station: &Station,
    ) -> Result<()> {
        let camera = conditions.camera_x;
        let camera = camera.and_then(|x| station.check_camera("--camera-x", x));
        let noise = conditions.disturbances.position_noise;
        let noise = POSITION_NOISE.check("--position-noise", noise);
        let rate = check_rate("--update-hz", conditions.update_hz);
        warn(self.strict, camera.into_iter().chain(noise).chain(rate))
    }

    /// Warns about implausible values in a pattern, and about items that no robot of `station` has a
    /// bin for.
    ///
    /// # Errors
    /// As for [`warn`].
    pub(crate) fn check_pattern(
        &self,
        name: &str,
        pattern: &Pattern,
        station: Option<&Station>,
    ) -> Result<()> {
        let mut warnings = pattern.warnings(name);
        warnings.extend(station.and_then(|station| pattern.check_bins(name, station)));
        warn(self.strict, warnings)
    }

    /// Warns about the first pattern of a set that has implausible values; the others are
    /// usually like it.
    ///
    /// # Errors
    /// As for [`warn`].
    pub(crate) fn check_set(&self, set: &PatternSet, station: &Station) -> Result<()> {
        let all = set.labels.iter().zip(&set.patterns);
        let mut warnings = all.map(|(name, pattern)| {
            let mut warnings = pattern.warnings(name);
            warnings.extend(pattern.check_bins(name, station));
            warnings
        });
        warn(
            self.strict,
            warnings.find(|w| !w.is_empty()).unwrap_or_default(),
        )
    }
}
