//! Arguments resolved to what the library works with.

use super::args::{
    AttributeArgs, Common, ConditionArgs, FeedArgs, Format, StationChoice, TrainingArgs,
};
use super::session::tell;
use super::warnings::warn;
use crate::error::{Error, Result};
use crate::files;
use crate::pattern::{
    self, Attributes, Distribution, Feed, FeedShape, Pattern, PatternSource, grid,
};
use crate::plausible::POSITION_NOISE;
use crate::sim::{Conditions, Disturbances};
use crate::station::{self, Overrides, Station};
use crate::strategies::{self, Parsed};
use serde::Serialize;
use std::io::Read as _;
use std::path::Path;

impl StationChoice {
    /// Where the station comes from, as a file.
    pub fn file(&self) -> (&str, Option<&Path>) {
        ("--station", Some(Path::new(&self.station)))
    }

    /// What the station is called: a built-in by its name, a file by its own without folder
    /// and extension.
    pub fn title(&self) -> String {
        let stem = Path::new(&self.station).file_stem();
        stem.map_or_else(
            || self.station.clone(),
            |stem| stem.to_string_lossy().into_owned(),
        )
    }

    /// The station, of which nothing is said.
    ///
    /// # Errors
    /// As for [`station::load`].
    pub fn resolve(&self) -> Result<Station> {
        let overrides = Overrides {
            robots: self.robots,
            belt_speed: self.belt_speed,
        };
        station::load(&self.station, overrides)
    }
}

impl FeedArgs {
    /// The shape of feeds, of which the call makes those of `feeds`.
    ///
    /// # Errors
    /// A figure out of its range, or a flag that has no meaning for any of them.
    pub fn shape(&self, feeds: &[&Feed]) -> Result<FeedShape> {
        for (flag, given, own) in [
            ("--cluster-size", self.cluster_size, Feed::Clustered),
            ("--cluster-spread", self.cluster_spread, Feed::Clustered),
            ("--gap-length", self.gap_length, Feed::Gaps),
            ("--gap-share", self.gap_share, Feed::Gaps),
        ] {
            if given.is_some() && !feeds.contains(&&own) {
                return Err(Error::input(
                    flag,
                    format!("has a meaning for the feed {own} only"),
                    format!("leave it out, or use the feed {own}"),
                ));
            }
        }
        let usual = FeedShape::default();
        let shape = FeedShape {
            cluster_size: self.cluster_size.unwrap_or(usual.cluster_size),
            cluster_spread: self.cluster_spread.unwrap_or(usual.cluster_spread),
            gap_length: self.gap_length.unwrap_or(usual.gap_length),
            gap_share: self.gap_share.unwrap_or(usual.gap_share),
        };
        shape.check()?;
        Ok(shape)
    }

    /// The patterns that `--patterns` and `--flow` name, and the shape of their feeds.
    ///
    /// # Errors
    /// A text that is no source, flags that have no meaning for it.
    pub fn source(&self, patterns: &str) -> Result<(PatternSource, FeedShape)> {
        let source = patterns.parse::<PatternSource>()?.with_flow(self.flow)?;
        let feeds: Vec<&Feed> = source.feed().into_iter().collect();
        let shape = self.shape(&feeds)?;
        Ok((source, shape))
    }
}

impl AttributeArgs {
    /// The distributions.
    ///
    /// # Errors
    /// A text that is no distribution.
    pub fn resolve(&self) -> Result<Attributes> {
        let read = |text: &Option<String>, flag: &str| -> Result<Option<Distribution>> {
            let read = |text: &String| {
                text.parse()
                    .map_err(|e: Error| e.at(&format!("{flag} {text}")))
            };
            text.as_ref().map(read).transpose()
        };
        Ok(Attributes {
            area_cm2: read(&self.area, "--area")?,
            p_detection: read(&self.p_detection, "--p-detection")?,
            p_grasp: read(&self.p_grasp, "--p-grasp")?,
        })
    }
}

impl ConditionArgs {
    /// Says what of the conditions is not plausible on `station`.
    ///
    /// # Errors
    /// As for [`warn`].
    pub fn check_on(&self, choice: &StationChoice, station: &Station) -> Result<()> {
        let camera = self.camera_x;
        let camera = camera.and_then(|x| station.check_camera("--camera-x", x));
        let noise = POSITION_NOISE.check("--position-noise", self.position_noise);
        warn(choice.strict, camera.into_iter().chain(noise))
    }

    /// The conditions, their luck under the master seed.
    ///
    /// # Errors
    /// Values that are none.
    pub fn resolve(&self, common: &Common) -> Result<Conditions> {
        let conditions = Conditions {
            update_hz: common.update_hz,
            camera_x: self.camera_x,
            disturbances: Disturbances {
                grasp_failures: self.grasp_failures.is_some(),
                default_p_grasp: self.grasp_failures.unwrap_or(1.0),
                position_noise: self.position_noise,
                seed: common.seed,
            },
        };
        conditions.check()?;
        Ok(conditions)
    }
}

impl Common {
    /// Checks the settings that do not concern the verb's own work, before it begins:
    /// a long computation must not end in a folder that cannot be written.
    ///
    /// # Errors
    /// A number of threads that cannot be had, a folder that cannot be made.
    pub fn check(&self) -> Result<()> {
        match self.threads {
            Some(threads) if !(1..=1024).contains(&threads) => Err(Error::input(
                "--threads",
                format!("{threads} is not a number of threads"),
                "give 1 to 1024, or leave it out for all cores",
            )),
            _ => self.out.as_deref().map_or(Ok(()), files::check_folder),
        }
    }

    /// Runs `work` on the chosen number of threads.
    ///
    /// # Errors
    /// Threads that cannot be had, or what `work` returns.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        // 0 stands for all cores.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map_err(|error| Error::input("--threads", error.to_string(), "give fewer"))?;
        pool.install(work)
    }

    /// A remark for the user, unless quiet.
    pub fn remark(&self, text: &str) {
        if !self.quiet {
            tell(text);
        }
    }

    /// The result in the chosen format.
    pub fn render(
        &self,
        table: impl FnOnce() -> String,
        csv: impl FnOnce() -> String,
        value: &impl Serialize,
    ) -> Result<String> {
        Ok(match self.format {
            Format::Table => table(),
            Format::Csv => csv(),
            Format::Json => json(value)?,
        })
    }
}

/// The strategy that `text` names; says how it was read, unless `quiet`.
///
/// # Errors
/// As for [`strategies::parse`].
pub fn parse_strategy(text: &str, quiet: bool) -> Result<Parsed> {
    let strategy = strategies::parse(text)?;
    if let Some(remark) = strategy.remark().filter(|_| !quiet) {
        tell(remark);
    }
    Ok(strategy)
}

/// `value` as JSON text with a line end.
///
/// # Errors
/// Never for the reports of this crate; passed on so that nothing panics.
pub fn json(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::Refuted(format!("the result is no JSON: {error}")))?;
    Ok(text + "\n")
}

/// The pattern that the user named, `-` for stdin, or the built-in grid; and what it
/// is, in words.
///
/// # Errors
/// A file that cannot be read or is no pattern.
pub fn load_pattern(file: Option<&str>, width: f64) -> Result<(Pattern, String)> {
    match file {
        None => {
            let (spacing, count) = DEFAULT_GRID;
            let pattern = grid(width, spacing, count)?;
            Ok((
                pattern,
                format!("the built-in grid of {spacing} m, {count} items"),
            ))
        }
        Some("-") => {
            let mut bytes = Vec::new();
            std::io::stdin()
                .read_to_end(&mut bytes)
                .map_err(|error| Error::read(Path::new("stdin"), error))?;
            let text = files::utf8(bytes, "stdin")?;
            let loaded = pattern::read(&text, "stdin")?;
            let description = format!("read from stdin ({})", loaded.describe());
            Ok((loaded.pattern, description))
        }
        Some(file) => {
            let loaded = pattern::load(Path::new(file))?;
            let description = format!("{file} ({})", loaded.describe());
            Ok((loaded.pattern, description))
        }
    }
}

/// Spacing [m] and number of items of the pattern that stands in where none is given.
pub const DEFAULT_GRID: (f64, usize) = (0.15, 50);

/// What is told where `--grasp-failures` makes no difference.
pub const NOTHING_FAILS: &str = "no item has a p_grasp below 1, so no grasp fails; give \
     --grasp-failures P for items without one";

/// What a reader of a comparison under `conditions` should know. `generated` says that no
/// pattern comes from a file.
pub fn condition_notes(
    conditions: &Conditions,
    training: &TrainingArgs,
    generated: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    let Conditions {
        camera_x,
        disturbances,
        ..
    } = conditions;
    if training.robust.is_none() && (camera_x.is_some() || disturbances.any()) {
        notes.push("robust GT was found with every item known and nothing going wrong".to_owned());
    }
    if generated && disturbances.never_fails(&[]) {
        notes.push(NOTHING_FAILS.to_owned());
    }
    notes
}
