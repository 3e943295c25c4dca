//! `pickline pattern import`.

use super::target::{write_pattern, written};
use crate::args::{AxisArg, BoxesArg, TracksArgs};
use crate::flags::flag;
use crate::outputs::Outputs;
use crate::session::{Session, tell};
use crate::warnings::warn;
use pickline::error::{Error, Result, counted, shown, spell_settings};
use pickline::files;
use pickline::pattern::Pattern;
use pickline::pattern::tracking::{self, ClassNames, ImportOptions};
use pickline::plausible::{BELT_SPEED, MERGE_DISTANCE, SPLIT_DISTANCE};
use pickline_report::{OutputProtection, json_text};
use serde::Serialize;
use std::path::{Path, PathBuf};

pub(super) fn run(args: TracksArgs, session: &Session) -> Result<()> {
    args.resolve()?.run(session)
}

/// A resolved call.
struct ImportPlan {
    /// The recording.
    file: PathBuf,
    options: ImportOptions,
    output: Option<PathBuf>,
    report: Option<PathBuf>,
    strict: bool,
    quiet: bool,
}

impl TracksArgs {
    fn resolve(self) -> Result<ImportPlan> {
        let output = written(self.output.clone());
        let targets = [
            ("--output", output.as_deref()),
            ("--report", self.report.as_deref()),
        ];
        let read = [
            ("the recording", Some(self.file.as_path())),
            ("--class-names", self.class_names_file()),
        ];
        OutputProtection::of("pattern import")
            .with_force(self.force)
            .check(&read, &targets)?;
        if self.file.is_dir() {
            check_outside(&self.file, &targets)?;
        }
        Ok(ImportPlan {
            options: self.options()?,
            file: self.file,
            output,
            report: self.report,
            strict: self.strict,
            quiet: self.quiet,
        })
    }

    /// The options that the flags give.
    ///
    /// # Errors
    /// An unknown format, or a value that is not an image size.
    fn options(&self) -> Result<ImportOptions> {
        let axis = match self.axis {
            AxisArg::X => tracking::ImageAxis::X,
            AxisArg::Y => tracking::ImageAxis::Y,
        };
        let format = self.form.as_deref();
        let format = format.map(|name| name.parse().map_err(|error: Error| error.at("--as")));
        let boxes = self.boxes.map(|boxes| match boxes {
            BoxesArg::Sizes => tracking::Boxes::Sizes,
            BoxesArg::Corners => tracking::Boxes::Corners,
            BoxesArg::Centres => tracking::Boxes::Centres,
        });
        let options = ImportOptions::new(self.fps, self.scale, axis, self.belt_speed);
        Ok(options
            .with_format(format.transpose()?)
            .with_boxes(boxes)
            .with_image_size(self.image_size.as_deref().map(image_size).transpose()?)
            .with_angle_deg(self.angle)
            .with_accept_mismatch(self.accept_mismatch)
            .with_reverse(self.reverse)
            .with_centre_px(self.centre_px)
            .with_min_frames(self.min_frames)
            .with_split_distance_m(self.split_distance)
            .with_merge_distance_m(self.merge_distance)
            .with_class_names(self.class_names()?))
    }

    /// The file of `--class-names`; `None` if the names themselves are given.
    fn class_names_file(&self) -> Option<&Path> {
        let names = Path::new(self.class_names.as_deref()?);
        // A file may have a colon in its name, and names are never without one.
        let is_file = names.is_file() || !names.to_string_lossy().contains(':');
        is_file.then_some(names)
    }

    /// The names of the class ids, if they are given.
    fn class_names(&self) -> Result<Option<ClassNames>> {
        if let Some(file) = self.class_names_file() {
            let text = files::read_text(file)?;
            return ClassNames::from_lines(&text, &file.display().to_string()).map(Some);
        }
        self.class_names.as_deref().map(str::parse).transpose()
    }
}

impl ImportPlan {
    fn run(&self, session: &Session) -> Result<()> {
        let recording = tracking::Recording::load(&self.file)?;
        let name = self.file.display().to_string();
        let mut import = tracking::import(&recording, &name, &self.options)?;
        self.check_values(&import.pattern)?;
        for doubt in &mut import.report.warnings {
            *doubt = spell_settings(doubt, flag);
        }
        let doubts = &import.report.warnings;
        if self.strict {
            check_doubts(&name, doubts)?;
        }
        if !self.quiet {
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
        outputs.add(self.report.as_deref(), || report);
        write_pattern(self.output.as_deref(), &import.pattern, session).and(outputs.write())
    }

    /// Warns about implausible values of flags and of the pattern.
    fn check_values(&self, pattern: &Pattern) -> Result<()> {
        let options = &self.options;
        let flags = [
            BELT_SPEED.check("--belt-speed", options.belt_speed),
            SPLIT_DISTANCE.check("--split-distance", options.split_distance_m),
            MERGE_DISTANCE.check("--merge-distance", options.merge_distance_m),
        ];
        let flags = flags.into_iter().flatten();
        warn(self.strict, flags.chain(pattern.warnings("the pattern")))
    }
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

/// Rejects, with `--strict`, an import with warnings.
///
/// # Errors
/// The first of `doubts`.
fn check_doubts(file: &str, doubts: &[String]) -> Result<()> {
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
        file,
        format!("{first}{others}"),
        "correct it, or leave out --strict",
    ))
}
