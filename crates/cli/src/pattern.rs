//! `pickline pattern`.

use super::args::{
    AxisArg, BoxesArg, DescribeArgs, GenerateArgs, ImportCommand, PatternCommand, PatternKind,
    StationChoice, TracksArgs,
};
use super::flags::flag;
use super::outputs::{self, Outputs};
use super::session::{Session, tell};
use super::settings::load_pattern;
use super::warnings::warn;
use pickline::error::{Error, Result, counted, shown, shown_number, spell_settings};
use pickline::files;
use pickline::pattern::{
    Feed, FeedShape, Feeder, Pattern, describe, grid, poisson_disk, random_stream, to_csv, tracking,
};
use pickline::plausible::{BELT_SPEED, BELT_WIDTH, MERGE_DISTANCE, SPLIT_DISTANCE};
use pickline::station::Belt;
use pickline::study::DEFAULT_GRID;
use pickline_report::{DescriptionReport, json_text, origin_comment};
use rand::rngs::ChaCha8Rng;
use serde::Serialize;
use std::path::Path;

/// Default radius [m] and number of items of a Poisson disk pattern: a case of the paper.
const DEFAULT_POISSON: (f64, usize) = (0.2, 29);
/// Default flow [1/min] of feeds other than profiles.
const DEFAULT_FLOW: f64 = 60.0;

pub fn run(command: PatternCommand, session: &Session) -> Result<()> {
    match command {
        PatternCommand::Generate(args) => generate(&args, session),
        PatternCommand::Describe(args) => describe_pattern(&args, session),
        PatternCommand::Import(ImportCommand::Tracks(args)) => import_tracks(&args, session),
    }
}

fn generate(args: &GenerateArgs, session: &Session) -> Result<()> {
    let output = written(args.output.as_deref());
    let read = [args.station.file(), ("--profile", args.profile.as_deref())];
    outputs::check(
        "pattern generate",
        args.force,
        &read,
        &[("--output", output)],
    )?;
    let belt = chosen_belt(args)?;
    let attributes = args.attributes.resolve()?;
    let mut rng = random_stream(args.seed, 0);
    let kind = args.kind.feed(args.profile.as_deref())?;
    check_lengths(args, &kind)?;
    let shape = args.feed.shape(&[&kind], &args.station)?;
    let by_length = args.feed.flow.is_none() && matches!(kind, Feed::Grid | Feed::PoissonDisk);
    let pattern = if by_length {
        by_distance(args, &kind, belt.width, &mut rng)?
    } else {
        by_flow(args, &kind, &belt, shape, &mut rng)?
    };
    let pattern = attributes.apply(pattern, &mut rng)?;
    args.station.check_pattern("the pattern", &pattern)?;
    write_pattern(output, &pattern, session)
}

/// The file of `--output`, unless it is stdout.
fn written(output: Option<&Path>) -> Option<&Path> {
    output.filter(|file| *file != Path::new("-"))
}

/// Writes `pattern` to `file`, with the command line that made it, or prints it.
fn write_pattern(file: Option<&Path>, pattern: &Pattern, session: &Session) -> Result<()> {
    let text = to_csv(pattern);
    match file {
        Some(file) => {
            let origin = origin_comment(&session.command());
            files::write_whole(file, (origin + &text).as_bytes())
        }
        None => session.print(text.as_bytes()),
    }
}

/// A grid or a Poisson disk pattern, given by the distance between its items.
fn by_distance(
    args: &GenerateArgs,
    kind: &Feed,
    width: f64,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    let remark = |what: String, open: bool| {
        if open && !args.quiet {
            tell(&format!("generating {what}"));
        }
    };
    if *kind == Feed::Grid {
        let (spacing, count) = DEFAULT_GRID;
        let (own, count) = (args.spacing, args.count.unwrap_or(count));
        let spacing = own.unwrap_or(spacing);
        remark(
            format!("the grid of {spacing} m, {count} items"),
            own.is_none() || args.count.is_none(),
        );
        return grid(width, spacing, count);
    }
    let (radius, count) = DEFAULT_POISSON;
    let (own, count) = (args.radius, args.count.unwrap_or(count));
    let radius = own.unwrap_or(radius);
    remark(
        format!("a Poisson disk pattern of {radius} m, {count} items"),
        own.is_none() || args.count.is_none(),
    );
    poisson_disk(width, radius, count, rng)
}

/// The belt of the station, with the width that the flag gives.
///
/// # Errors
/// An invalid station or width.
fn chosen_belt(args: &GenerateArgs) -> Result<Belt> {
    // Load it even if the width is given: an invalid station must not go unnoticed.
    let station = args.station.load()?;
    let mut belt = *station.belt();
    match args.width {
        Some(width) if (1e-6..=1e3).contains(&width) => {
            let values = [("--width", &BELT_WIDTH, Some(width))];
            args.station.check_values(&values)?;
            belt.width = width;
        }
        Some(width) => {
            return Err(Error::usage(
                "--width",
                format!("{} m is not a belt width", shown_number(width)),
                "give metres, from 1e-6 to 1000",
            ));
        }
        None => {}
    }
    Ok(belt)
}

/// Checks that a distance between items is given only where it applies.
///
/// # Errors
/// Another kind of pattern, or a flow as well.
fn check_lengths(args: &GenerateArgs, kind: &Feed) -> Result<()> {
    let lengths = [
        ("--spacing", args.spacing, Feed::Grid),
        ("--radius", args.radius, Feed::PoissonDisk),
    ];
    for (flag, length, own) in &lengths {
        if length.is_some() && kind != own {
            return Err(foreign(flag, kind));
        }
        if length.is_some() && args.feed.flow.is_some() {
            return Err(Error::usage(
                "--flow",
                format!("{flag} already determines the flow"),
                "give only one of the two",
            ));
        }
    }
    Ok(())
}

/// A pattern of the feed `kind`, given by its flow.
fn by_flow(
    args: &GenerateArgs,
    kind: &Feed,
    belt: &Belt,
    shape: FeedShape,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    let usual = kind.file().is_none().then_some(DEFAULT_FLOW);
    let feeder = Feeder::new(kind, args.feed.flow.or(usual), belt, shape)?;
    let usual = match kind.file() {
        Some(_) => usize::MAX,
        None => DEFAULT_GRID.1,
    };
    let pattern = feeder.draw(args.count.unwrap_or(usual), rng)?;
    if let Some(count) = args.count.filter(|count| *count > pattern.len()) {
        tell(&format!(
            "warning: --count {count}: the profile has only {} items",
            pattern.len()
        ));
    }
    if !args.quiet {
        tell(&format!(
            "generating the feed {kind} of {} items/min at {} m/s: {}",
            shown_number(feeder.flow()),
            shown_number(belt.speed),
            achieved(&pattern, belt.speed)
        ));
    }
    Ok(pattern)
}

/// The flow that a pattern actually has, as text.
fn achieved(pattern: &Pattern, belt_speed: f64) -> String {
    let count = pickline::error::counted(pattern.len(), "item");
    match DescriptionReport::new(describe(pattern), Some(belt_speed)).flow_per_min {
        Some(flow) => format!("{count}, {flow:.1} items/min over its length"),
        None => count,
    }
}

fn foreign(flag: &str, kind: &Feed) -> Error {
    let name = match kind {
        Feed::PoissonDisk => "Poisson disk",
        other => other.name(),
    };
    Error::usage(
        flag,
        format!("does not apply to a {name} pattern"),
        "leave it out",
    )
}

impl PatternKind {
    /// The feed of this kind.
    fn feed(self, profile: Option<&Path>) -> Result<Feed> {
        let feed = match self {
            Self::Grid => Feed::Grid,
            Self::Poisson => Feed::PoissonDisk,
            Self::Random => Feed::Random,
            Self::Clustered => Feed::Clustered,
            Self::Gaps => Feed::Gaps,
            Self::Profile => Feed::Profile(profile.unwrap_or(Path::new("")).to_owned()),
        };
        match (self, profile) {
            (Self::Profile, None) => Err(Error::usage(
                "--profile",
                "a profile pattern needs a file",
                "give a CSV file with the columns time_s,flow_per_min",
            )),
            (Self::Profile, Some(_)) | (_, None) => Ok(feed),
            (_, Some(_)) => Err(foreign("--profile", &feed)),
        }
    }
}

fn describe_pattern(args: &DescribeArgs, session: &Session) -> Result<()> {
    if let Some(speed) = args.belt_speed
        && !(speed > 0.0 && speed.is_finite())
    {
        return Err(Error::usage(
            "--belt-speed",
            format!("{speed} is not a belt speed"),
            "give m/s, above 0",
        ));
    }
    let station = args.station.as_ref().map(|station| {
        let choice = StationChoice {
            station: station.clone(),
            robots: None,
            belt_speed: args.belt_speed,
            strict: args.strict,
        };
        choice.load()
    });
    let belt = station.transpose()?.map(|station| *station.belt());
    let width = belt.map_or(pickline::station::BUILT_INS[0].belt_width, |belt| {
        belt.width
    });
    let (pattern, name) = load_pattern(args.file.as_deref(), width)?;
    let named = args.file.as_deref().unwrap_or(&name);
    let given = args.belt_speed.filter(|_| args.station.is_none());
    let unlikely = given.and_then(|speed| BELT_SPEED.check("--belt-speed", speed));
    warn(
        args.strict,
        unlikely.into_iter().chain(pattern.warnings(named)),
    )?;
    let speed = belt.map(|belt| belt.speed).or(args.belt_speed);
    let report = DescriptionReport::new(describe(&pattern), speed).named(name);
    let text = outputs::rendered(&report, args.format, &outputs::WHOLE)?;
    session.print(text.as_bytes())
}

/// The content of the `--report` file: the report and the command line that made it.
#[derive(Serialize)]
struct Imported<'a> {
    command: &'a str,
    #[serde(flatten)]
    report: &'a tracking::ImportReport,
}

/// Parses a width and height [px] such as `1280x720`.
fn image_size(text: &str) -> Result<(f64, f64)> {
    let parts = text.split_once(['x', 'X']);
    let numbers = parts.and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    numbers.ok_or_else(|| {
        Error::usage(
            "--image-size",
            format!("`{}` is not an image size", shown(text)),
            "give the width and height in pixels, for example 1280x720",
        )
    })
}

/// Refuses to write to the folder of a recording: the next import would read the output as
/// part of the recording.
fn check_outside(folder: &Path, written: &[(&str, Option<&Path>)]) -> Result<()> {
    let whole = std::fs::canonicalize(folder).ok();
    for (flag, file) in written {
        if let Some(file) = file
            && whole.is_some()
            && std::fs::canonicalize(files::folder_of(file)).ok() == whole
        {
            return Err(Error::usage(
                *flag,
                format!("{} is in the folder of the recording", file.display()),
                "use another folder",
            ));
        }
    }
    Ok(())
}

/// The options that the flags give.
///
/// # Errors
/// An unknown format, or a value that is not an image size.
fn import_options(args: &TracksArgs) -> Result<tracking::ImportOptions> {
    Ok(tracking::ImportOptions {
        format: args
            .form
            .as_deref()
            .map(|name| name.parse().map_err(|error: Error| error.at("--as")))
            .transpose()?,
        boxes: args.boxes.map(|boxes| match boxes {
            BoxesArg::Sizes => tracking::Boxes::Sizes,
            BoxesArg::Corners => tracking::Boxes::Corners,
            BoxesArg::Centres => tracking::Boxes::Centres,
        }),
        image_size: args.image_size.as_deref().map(image_size).transpose()?,
        angle_deg: args.angle,
        accept_mismatch: args.accept_mismatch,
        reverse: args.reverse,
        centre_px: args.centre_px,
        min_frames: args.min_frames,
        split_distance_m: args.split_distance,
        merge_distance_m: args.merge_distance,
        ..tracking::ImportOptions::new(
            args.fps,
            args.scale,
            match args.axis {
                AxisArg::X => tracking::ImageAxis::X,
                AxisArg::Y => tracking::ImageAxis::Y,
            },
            args.belt_speed,
        )
    })
}

/// Rejects, with `--strict`, an import with warnings.
///
/// # Errors
/// The first of `doubts`.
fn check_doubts(args: &TracksArgs, doubts: &[String]) -> Result<()> {
    let [first, more @ ..] = doubts else {
        return Ok(());
    };
    let others = match more.len() {
        0 => String::new(),
        more => format!(
            "; and {}, shown without --strict",
            counted(more, "more warning")
        ),
    };
    Err(Error::input(
        args.file.display().to_string(),
        format!("{first}{others}"),
        "correct it, or leave out --strict",
    ))
}

fn import_tracks(args: &TracksArgs, session: &Session) -> Result<()> {
    let output = written(args.output.as_deref());
    let targets = [("--output", output), ("--report", args.report.as_deref())];
    let read = [("the recording", Some(args.file.as_path()))];
    outputs::check("pattern import", args.force, &read, &targets)?;
    if args.file.is_dir() {
        check_outside(&args.file, &targets)?;
    }
    let options = import_options(args)?;
    let recording = tracking::Recording::load(&args.file)?;
    let mut import = tracking::import(&recording, &args.file.display().to_string(), &options)?;
    let flags = [
        BELT_SPEED.check("--belt-speed", args.belt_speed),
        SPLIT_DISTANCE.check("--split-distance", args.split_distance),
        MERGE_DISTANCE.check("--merge-distance", args.merge_distance),
    ];
    warn(
        args.strict,
        flags
            .into_iter()
            .flatten()
            .chain(import.pattern.warnings("the pattern")),
    )?;
    for doubt in &mut import.report.warnings {
        *doubt = spell_settings(doubt, flag);
    }
    let doubts = &import.report.warnings;
    if args.strict {
        check_doubts(args, doubts)?;
    }
    if !args.quiet {
        for line in import.report.lines() {
            tell(&spell_settings(&line, flag));
        }
    }
    // Even with --quiet, as nothing may go wrong silently.
    for doubt in doubts {
        tell(&format!("warning: {doubt}"));
    }
    let command = session.command();
    let report = json_text(&Imported {
        command: &command,
        report: &import.report,
    })?;
    let mut outputs = Outputs::default();
    outputs.add(args.report.as_deref(), || report);
    write_pattern(output, &import.pattern, session).and(outputs.write())
}
