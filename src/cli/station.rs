//! `pickline station`.

use super::args::{StationChoice, StationCommand};
use super::session::Session;
use super::settings::load_pattern;
use crate::error::{Error, Result};
use crate::files;
use crate::pattern::{Pattern, poisson_disk, random_stream};
use crate::report::{Table, fixed, station_hash, station_picture};
use crate::station::{Station, commented_example, to_toml};
use std::path::Path;

pub fn run(command: StationCommand, session: &Session) -> Result<()> {
    match command {
        StationCommand::Show {
            station,
            svg,
            pattern,
        } => show(&station, svg.as_deref(), pattern.as_deref(), session),
        StationCommand::Check { file } => check(file, session),
        StationCommand::Init { file, force } => init(file.as_deref(), force, session),
    }
}

fn show(
    choice: &StationChoice,
    svg: Option<&Path>,
    pattern: Option<&str>,
    session: &Session,
) -> Result<()> {
    let station = choice.load()?;
    if let Some(file) = svg {
        let (pattern, name) = match pattern {
            Some(_) => load_pattern(pattern, station.belt().width)?,
            None => (covering(&station)?, "the grid over the belt".to_owned()),
        };
        pattern.check_on(&station).map_err(|e| e.inside(&name))?;
        files::write_whole(file, station_picture(&station, &pattern).as_bytes())?;
    }
    session.print(to_toml(&station).as_bytes())
}

/// A pattern that covers the whole belt, for a picture without one of its own.
fn covering(station: &Station) -> Result<Pattern> {
    let belt = station.belt();
    // Within the radii that a pattern may have, however odd the belt.
    let radius = (belt.width / 5.0).clamp(1e-4, 1e3);
    // A maximal pattern has fewer items than one a square of side 0.9 radius.
    let count = 1.3 * (belt.length + radius) * (belt.width + radius) / (radius * radius);
    poisson_disk(
        belt.width,
        radius,
        count.min(1e4) as usize,
        &mut random_stream(1, 0),
    )
}

fn check(file: String, session: &Session) -> Result<()> {
    let choice = StationChoice {
        station: file,
        robots: None,
        belt_speed: None,
    };
    let station = choice.load()?;
    let belt = station.belt();
    let mut table = Table::new(&[
        "<robot",
        "reaches x [m]",
        "across the belt [%]",
        "cycle [s]",
    ]);
    let mut remarks = Vec::new();
    for robot in station.robots() {
        let strip = reachable_rows(&station, robot);
        if strip == 0.0 {
            remarks.push(format!(
                "remark    robot `{}` reaches no item\n",
                robot.name
            ));
        }
        // An item that stands right at the bin costs the dwell times only; one at
        // the far end of the reach the most.
        let far = 2.0 * robot.reach / robot.speed + robot.grasp_time + robot.release_time;
        table.row([
            robot.name.clone(),
            format!(
                "{} to {}",
                fixed((robot.base.x - robot.reach).max(0.0), 3),
                fixed((robot.base.x + robot.reach).min(belt.length), 3)
            ),
            fixed(100.0 * strip, 0),
            format!(
                "{} to {}",
                fixed(robot.grasp_time + robot.release_time, 2),
                fixed(far, 2)
            ),
        ]);
    }
    let text = format!(
        "{}belt      {} m long, {} m wide, {} m/s\n{}ok        {} ({} robots, hash {})\n",
        table.render(),
        belt.length,
        belt.width,
        belt.speed,
        remarks.concat(),
        choice.station,
        station.robots().len(),
        station_hash(&station)
    );
    session.print(text.as_bytes())
}

/// Share of the belt's width whose items `robot` has a window for.
fn reachable_rows(station: &Station, robot: &crate::station::Robot) -> f64 {
    const ROWS: u32 = 1000;
    let belt = station.belt();
    let rows = (0..=ROWS).filter(|&row| {
        let y = belt.width * (f64::from(row) / f64::from(ROWS) - 0.5);
        // Far enough upstream to come past the whole workspace.
        let x0 = -(robot.base.x.abs() + robot.reach) - belt.length;
        robot.departure_window(belt, x0, y).is_some()
    });
    rows.count() as f64 / f64::from(ROWS + 1)
}

fn init(file: Option<&Path>, force: bool, session: &Session) -> Result<()> {
    if let Some(file) = file
        && file.exists()
        && !force
    {
        return Err(Error::input(
            file.display().to_string(),
            "the file exists",
            "name another file, or add --force to overwrite it",
        ));
    }
    session.print_or_write(file, commented_example().as_bytes())
}
