//! Compares robust and greedy dispatching rules (game theory) with a strategy that looks ahead.

use pickline::planning::LookaheadOptions;
use pickline::{CompareOptions, Environment, experiment, station};
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    run(&mut std::io::stdout())
}

/// Writes the picking rate of every method on every case.
pub fn run(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let station = station::built_in("paper")?.station(Some(2))?;
    let cases = experiment::load_cases("paper")?;
    let options = CompareOptions::default()
        .with_replicates(2)
        .with_bound(false)
        .with_strategy(LookaheadOptions::default().with_depth(2));
    let found = pickline::compare(&station, &cases, &options, &Environment::QUIET)?;

    for case in &found.comparison.cases {
        writeln!(out, "{}", case.case.name)?;
        for (method, result) in found.comparison.methods.iter().zip(&case.methods) {
            let (title, rate) = (method.title(), result.picking_rate);
            writeln!(out, "  {title:<24} {rate:.2} picks/min")?;
        }
    }
    for note in &found.notes {
        writeln!(out, "note: {note}")?;
    }
    Ok(())
}
