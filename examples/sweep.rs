//! Finds how many robots a line needs until another one gains nothing.

use pickline::experiment::Axis;
use pickline::{Environment, SweepOptions, station};
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    run(&mut std::io::stdout())
}

/// Writes what each number of robots picks, and how many are enough.
pub fn run(out: &mut impl Write) -> Result<(), Box<dyn Error>> {
    let line = station::built_in("paper")?;
    let station = line.station(Some(2))?;
    let options = SweepOptions::default()
        .with_axis(Axis::Robots)
        .with_robots(|robots| line.station(Some(robots)))
        .with_to(3.0)
        .with_patterns("poisson:0.15:2".parse()?)
        .with_bound(false);
    let found = pickline::sweep(&station, &options, &Environment::QUIET)?;

    let robust = found.sweep.method("robust_gt")?;
    for (robots, point) in robust.points() {
        let (rules, share) = (&point.title, 100.0 * point.picked_share);
        writeln!(out, "{robots} robots: {share:.1} % picked by {rules}")?;
    }
    if let Some(robots) = robust.recommended() {
        writeln!(out, "{robots} robots are enough")?;
    }
    Ok(())
}
