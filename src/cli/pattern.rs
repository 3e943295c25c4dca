//! `pickline pattern`.

use super::args::{
    AxisArg, DescribeArgs, Format, GenerateArgs, ImportCommand, MotArgs, PatternCommand,
    PatternKind,
};
use super::session::{Session, tell};
use super::settings::{DEFAULT_GRID, json, load_pattern};
use crate::error::{Error, Result, shown_number};
use crate::files;
use crate::pattern::{describe, grid, mot, poisson_disk, random_stream, to_csv};
use crate::report::description_table;

/// Radius [m] and number of items of a Poisson disk pattern when none are given: a
/// case of the paper.
const DEFAULT_POISSON: (f64, usize) = (0.2, 29);

pub fn run(command: PatternCommand, session: &Session) -> Result<()> {
    match command {
        PatternCommand::Generate(args) => generate(&args, session),
        PatternCommand::Describe(args) => describe_pattern(&args, session),
        PatternCommand::Import(ImportCommand::Mot(args)) => import_mot(&args, session),
    }
}

fn generate(args: &GenerateArgs, session: &Session) -> Result<()> {
    files::check_target(args.output.as_deref())?;
    // Even where the width does not come from it: a wrong one must not pass unnoticed.
    let station = args.station.load()?;
    let width = match args.width {
        Some(width) if (1e-6..=1e3).contains(&width) => width,
        Some(width) => {
            return Err(Error::input(
                "--width",
                format!("{} m is not a belt width", shown_number(width)),
                "give metres, from 1e-6 to 1000",
            ));
        }
        None => station.belt().width,
    };
    let attributes = args.attributes.resolve()?;
    let mut rng = random_stream(args.seed, 0);
    let foreign = |flag: &str, kind: &str| {
        Error::input(
            flag,
            format!("has no meaning for a {kind} pattern"),
            "leave it out",
        )
    };
    let remark = |what: &str| {
        if !args.quiet {
            tell(&format!("generating {what}"));
        }
    };
    let pattern = match args.kind {
        PatternKind::Grid => {
            if args.radius.is_some() {
                return Err(foreign("--radius", "grid"));
            }
            let (spacing, count) = DEFAULT_GRID;
            let (own, count) = (args.spacing, args.count.unwrap_or(count));
            let spacing = own.unwrap_or(spacing);
            if own.is_none() || args.count.is_none() {
                remark(&format!("the grid of {spacing} m, {count} items"));
            }
            grid(width, spacing, count)?
        }
        PatternKind::Poisson => {
            if args.spacing.is_some() {
                return Err(foreign("--spacing", "Poisson disk"));
            }
            let (radius, count) = DEFAULT_POISSON;
            let (own, count) = (args.radius, args.count.unwrap_or(count));
            let radius = own.unwrap_or(radius);
            if own.is_none() || args.count.is_none() {
                remark(&format!(
                    "a Poisson disk pattern of {radius} m, {count} items"
                ));
            }
            poisson_disk(width, radius, count, &mut rng)?
        }
    };
    let pattern = attributes.apply(pattern, &mut rng)?;
    session.print_or_write(args.output.as_deref(), to_csv(&pattern).as_bytes())
}

fn describe_pattern(args: &DescribeArgs, session: &Session) -> Result<()> {
    if !(args.belt_speed > 0.0 && args.belt_speed.is_finite()) {
        return Err(Error::input(
            "--belt-speed",
            format!("{} is not a belt speed", args.belt_speed),
            "give m/s, above 0",
        ));
    }
    let width = crate::station::BUILT_INS[0].belt_width;
    let (pattern, name) = load_pattern(args.file.as_deref(), width)?;
    let description = describe(&pattern);
    let table = description_table(&description, args.belt_speed);
    let text = match args.format {
        Format::Table => format!("{}pattern   {name}\n", table.render()),
        Format::Json => json(&description)?,
        Format::Csv => table.to_csv(),
    };
    session.print(text.as_bytes())
}

fn import_mot(args: &MotArgs, session: &Session) -> Result<()> {
    files::check_target(args.output.as_deref())?;
    files::check_target(args.report.as_deref())?;
    let options = mot::Options {
        reverse: args.reverse,
        centre_px: args.centre_px,
        min_frames: args.min_frames,
        split_distance_m: args.split_distance,
        merge_distance_m: args.merge_distance,
        ..mot::Options::new(
            args.fps,
            args.scale,
            match args.axis {
                AxisArg::X => mot::Axis::X,
                AxisArg::Y => mot::Axis::Y,
            },
            args.belt_speed,
        )
    };
    let text = files::read_text(&args.file)?;
    let import = mot::import(&text, &args.file.display().to_string(), &options)?;
    if !args.quiet {
        for line in import.report.lines() {
            tell(&line);
        }
    }
    if let Some(file) = &args.report {
        files::write_whole(file, json(&import.report)?.as_bytes())?;
    }
    session.print_or_write(args.output.as_deref(), to_csv(&import.pattern).as_bytes())
}
