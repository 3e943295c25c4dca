//! `pickline station`.

use super::args::{StationChoice, StationCommand};
use super::outputs::Outputs;
use super::session::{Session, tell};
use super::settings::load_pattern;
use super::station_fit;
use pickline::clearance;
use pickline::error::{Error, Result, counted, rounded};
use pickline::files;
use pickline::kinematics;
use pickline::pattern::{Pattern, poisson_disk, random_stream};
use pickline::sim::Conditions;
use pickline::station::{
    Bin, Overrides, Robot, Station, commented_example, edited, station_hash, to_toml,
};
use pickline_report::{OutputProtection, Table, arms_apart, fixed, station_picture, with_origin};
use std::path::Path;

pub(crate) fn run(command: StationCommand, session: &Session) -> Result<()> {
    match command {
        StationCommand::Show {
            station,
            svg,
            pattern,
            camera_x,
            force,
        } => {
            let named = pattern.as_deref().map(Path::new);
            let read = [station.file(), ("--pattern", named)];
            OutputProtection::of("station show")
                .with_force(force)
                .check(&read, &[("--svg", svg.as_deref())])?;
            let camera = camera_x.map(plausible_camera).transpose()?;
            show(
                &station,
                svg.as_deref(),
                pattern.as_deref(),
                camera,
                session,
            )
        }
        StationCommand::Check { file, strict } => check(file, strict, session),
        StationCommand::Fit(args) => station_fit::run(*args, session),
        StationCommand::Init { file, force } => init(file.as_deref(), force, session),
    }
}

fn show(
    choice: &StationChoice,
    svg: Option<&Path>,
    pattern: Option<&str>,
    camera: Option<f64>,
    session: &Session,
) -> Result<()> {
    let (station, strategy) = choice.load_with_strategy(&tell)?;
    let mut outputs = Outputs::default();
    if svg.is_some() {
        let pattern = match pattern {
            Some(name) => {
                let (items, _) = load_pattern(pattern, station.belt().width)?;
                choice.check_pattern(name, &items, Some(&station))?;
                items.check_on(&station).map_err(|e| e.inside(name))?;
                items
            }
            None => covering(&station)?,
        };
        let picture = station_picture(&station, &pattern, camera);
        outputs.add(svg, || with_origin(&picture, &session.command()));
    }
    let mut text = to_toml(&station);
    if let Some(strategy) = strategy {
        text = edited(&text, &choice.station, &strategy, Overrides::default())?;
    }
    outputs.deliver(session, &text)
}

/// Checks that a camera position [m] is in the range that conditions allow.
fn plausible_camera(x: f64) -> Result<f64> {
    let conditions = Conditions::default().with_camera_x(x);
    conditions.check().map(|()| x)
}

/// A pattern that covers the whole belt, for a picture without a given pattern.
fn covering(station: &Station) -> Result<Pattern> {
    let belt = station.belt();
    // Within the valid radii of a pattern, whatever the belt.
    let radius = (belt.width / 5.0).clamp(1e-4, 1e3);
    // A maximal pattern has about 0.7 items per square radius; 1.3 are plenty.
    let count = 1.3 * (belt.length + radius) * (belt.width + radius) / (radius * radius);
    poisson_disk(
        belt.width,
        radius,
        count.min(1e4) as usize,
        &mut random_stream(1, 0),
    )
}

fn check(file: String, strict: bool, session: &Session) -> Result<()> {
    let choice = StationChoice {
        station: file,
        robots: None,
        belt_speed: None,
        strict,
    };
    let station = choice.load()?;
    let (apart, warnings) = arms_apart(&station, &clearance::apart(&station));
    if strict && let Some(warning) = warnings.first() {
        let cure = "move robots, bins or the ends of their reach apart, or leave out --strict";
        return Err(Error::input(choice.station, warning.as_str(), cure));
    }
    let fine = station.warnings(&choice.station).is_empty() && warnings.is_empty();
    let verdict = if fine { "ok" } else { "doubtful" };
    let belt = station.belt();
    let mut table = Table::new(&[
        "<robot",
        "reaches x [m]",
        "across the belt [%]",
        "pick takes [s]",
    ]);
    let mut remarks = Vec::new();
    for robot in station.robots() {
        let Some(reach) = Reach::of(&station, robot) else {
            remarks.push(format!(
                "remark    robot `{}` reaches no item\n",
                robot.name
            ));
            let none = || "-".to_owned();
            table.row([robot.name.clone(), none(), fixed(0.0, 0), none()]);
            continue;
        };
        let span = |[low, high]: [f64; 2], digits| {
            format!("{} to {}", fixed(low, digits), fixed(high, digits))
        };
        table.row([
            robot.name.clone(),
            span(reach.x, 3),
            fixed(100.0 * reach.strip, 0),
            span(reach.pick, 2),
        ]);
    }
    let warnings = warnings.iter().map(|text| format!("warning   {text}\n"));
    remarks.extend(warnings);
    let text = format!(
        "{}belt      {} m long, {} m wide, {} m/s\n{}{}{verdict:<10}{} ({}, hash {})\n",
        table.render(),
        rounded(belt.length, 9),
        rounded(belt.width, 9),
        rounded(belt.speed, 9),
        apart,
        remarks.concat(),
        choice.station,
        counted(station.robots().len(), "robot"),
        station_hash(&station)
    );
    session.print(text.as_bytes())
}

/// The part of the belt where a robot can meet items.
struct Reach {
    /// First and last position along the travel [m].
    x: [f64; 2],
    /// Share of the belt's width.
    strip: f64,
    /// Shortest and longest time for a pick [s].
    pick: [f64; 2],
}

impl Reach {
    /// Checks many lines along the belt; `None` if the robot reaches none of them.
    fn of(station: &Station, robot: &Robot) -> Option<Self> {
        const ROWS: u32 = 1000;
        let belt = station.belt();
        let mut met = 0;
        let (mut x, mut pick) = ([f64::INFINITY, 0.0], [f64::INFINITY, 0.0]);
        for row in 0..=ROWS {
            let y = belt.width * (f64::from(row) / f64::from(ROWS) - 0.5);
            let base = robot.base;
            let range = kinematics::meeting_range(base.x, base.y, robot.reach, y, belt.length);
            let Some((first, last)) = range else { continue };
            met += 1;
            x = [x[0].min(first), x[1].max(last)];
            for place in 0..robot.places() {
                let from = robot.place(place);
                for bin in &robot.bins {
                    // The quickest pick is opposite the place or the bin, or half-way if it takes
                    // the arm past both; the longest is at one of the two ends.
                    let half = f64::midpoint(from.x, bin.at.x);
                    let nearest = [from.x, bin.at.x, half].map(|x| x.clamp(first, last));
                    for meet in nearest.into_iter().chain([first, last]) {
                        let time = pick_time(robot, place, bin, (meet, y));
                        pick = [pick[0].min(time), pick[1].max(time)];
                    }
                }
            }
        }
        (met > 0).then(|| Self {
            x,
            strip: f64::from(met) / f64::from(ROWS + 1),
            pick,
        })
    }
}

/// Time [s] for a pick by `robot` from its place `place` over the point (`x`, `y`) [m] to `bin`.
fn pick_time(robot: &Robot, place: usize, bin: &Bin, (x, y): (f64, f64)) -> f64 {
    let from = robot.place(place);
    let out = kinematics::distance(x - from.x, y - from.y);
    let back = kinematics::distance(x - bin.at.x, y - bin.at.y);
    match robot.arm.constant_speed() {
        Some(speed) if from == bin.at => 2.0 * out / speed + robot.grasp_time + bin.release_time,
        _ => {
            let travel = robot.arm.time(out) + robot.arm.time(back);
            travel + robot.grasp_time + bin.release_time
        }
    }
}

fn init(file: Option<&Path>, force: bool, session: &Session) -> Result<()> {
    if let Some(file) = file.filter(|file| *file != Path::new("-")) {
        files::check_target(file)?;
        files::try_target(file)?;
    }
    if let Some(file) = file
        && file.exists()
        && !force
    {
        return Err(Error::path(
            file.display().to_string(),
            "the file already exists",
            "name another file, or add --force to overwrite it",
        ));
    }
    session.print_or_write(file, commented_example().as_bytes())
}
