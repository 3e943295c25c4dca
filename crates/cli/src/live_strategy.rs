//! The strategy of a live line, running or replayed.

use super::progress::Bar;
use super::session::Session;
use super::settings::{budget, on_threads};
use pickline::error::Result;
use pickline::optimize::Environment;
use pickline::planning::{Allowance, Budget};
use pickline::station::Station;
use pickline::strategies::{Blueprint, StrategySpec};
use pickline::study::{self, BlueprintOptions};
use pickline_live::ClockKind;

/// The time or work budget of each decision on a live line.
///
/// # Errors
/// An invalid time.
pub(crate) fn allowance(ms: Option<f64>, clock: ClockKind) -> Result<Allowance> {
    let otherwise = match clock {
        // The belt does not wait.
        ClockKind::System => Budget::LIVE,
        // The same stream gives the same output on every machine.
        ClockKind::Messages => Budget::EXPERIMENT,
    };
    let allowance = Allowance::default().with_asked(budget(ms)?);
    Ok(allowance.with_otherwise(otherwise))
}

/// `strategy` on the line of `station`.
///
/// # Errors
/// As for [`study::blueprint`].
pub(crate) fn live_strategy(
    strategy: &StrategySpec,
    options: &BlueprintOptions,
    quiet: bool,
    station: &Station,
    session: &Session,
) -> Result<Blueprint> {
    let bar = Bar::before_a_line(quiet);
    let environment = Environment {
        stop: session.stop(),
        progress: &bar,
        ..Environment::QUIET
    };
    on_threads(None, || {
        study::blueprint(strategy, station, options, &environment)
    })
}
