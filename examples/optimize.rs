//! Finds the best dispatching rule for each robot of a line, and checks it on fresh patterns.

use pickline::{Environment, OptimizeOptions, station};
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    run(&mut std::io::stdout())
}

/// Writes the three best assignments, and the best again on fresh patterns.
pub fn run(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let station = station::built_in("paper")?.station(Some(2))?;
    let options = OptimizeOptions::default()
        .with_patterns("poisson:0.15:6".parse()?)
        .with_validation(10);
    let found = pickline::optimize(&station, &options, &Environment::QUIET)?;

    for ranked in found.optimum.ranking.entries.iter().take(3) {
        let (rules, rate) = (ranked.assignment.to_string(), ranked.mean);
        writeln!(out, "{rules:<12} {rate:.2} picks/min")?;
    }
    if let Some((validation, patterns)) = &found.validation {
        let rate = validation.value;
        writeln!(out, "the best again: {rate:.2} picks/min on {patterns}")?;
    }
    Ok(())
}
