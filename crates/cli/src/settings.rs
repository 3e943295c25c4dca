//! Arguments resolved to what the library works with.

use super::args::{
    AttributeArgs, Common, ConditionArgs, FeedArgs, Format, LimitArgs, StationChoice,
};
use super::session::tell;
use super::warnings::warn;
use pickline::error::{Error, Result, shown, shown_number};
use pickline::files;
use pickline::optimize::{Limits, MostRuns};
use pickline::pattern::{
    self, Attributes, Distribution, Feed, FeedShape, Pattern, PatternSource, grid,
};
use pickline::plausible::{CLUSTER_SPREAD, FLOW, GAP_LENGTH, POSITION_NOISE, check_rate};
use pickline::sim::{Conditions, Disturbances};
use pickline::station::{self, Overrides, Station};
use pickline::strategies::{self, Parsed};
use serde::Serialize;
use std::io::Read as _;
use std::path::Path;
use std::time::{Duration, Instant};

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

    /// What the flags change.
    pub fn overrides(&self) -> Overrides {
        Overrides {
            robots: self.robots,
            belt_speed: self.belt_speed,
        }
    }

    /// The station, of which nothing is said.
    ///
    /// # Errors
    /// As for [`StationChoice::resolve_with_strategy`].
    pub fn resolve(&self) -> Result<Station> {
        self.resolve_with_strategy(&|_| ())
            .map(|(station, _)| station)
    }

    /// The station and the strategy that its file names. One for another number of robots
    /// than `--robots` asks for is none, which `remark` is told.
    ///
    /// # Errors
    /// As for [`station::load`], a strategy that is none or that does not fit the file's own
    /// robots.
    pub fn resolve_with_strategy(
        &self,
        remark: &dyn Fn(&str),
    ) -> Result<(Station, Option<String>)> {
        let (station, saved) = station::load_with_strategy(&self.station, self.overrides())?;
        let Some(mut saved) = saved else {
            return Ok((station, None));
        };
        // A policy is looked for beside the station file that names it.
        if let Some(policy) = strategies::policy_file(&saved.text)
            && let Some(folder) = Path::new(&self.station).parent()
        {
            saved.text = format!("onnx:{}", folder.join(policy).display());
        }
        let robots = station.robots().len();
        let parsed = strategies::parse(&saved.text).map_err(|e| e.at(&saved.place))?;
        match parsed.alone(robots) {
            Ok(_) => Ok((station, Some(saved.text))),
            Err(_) if self.robots.is_some() => {
                remark(&format!(
                    "{}: {} is not used, as it does not fit --robots {robots}",
                    saved.place,
                    shown(&saved.text)
                ));
                Ok((station, None))
            }
            Err(error) => Err(error.at(&saved.place)),
        }
    }
}

impl FeedArgs {
    /// The shape of feeds, of which the call makes those of `feeds`.
    ///
    /// # Errors
    /// A figure out of its range, or a flag that has no meaning for any of them; with
    /// `--strict` what is not plausible.
    pub fn shape(&self, feeds: &[&Feed], station: &StationChoice) -> Result<FeedShape> {
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
        station.check_values(&[
            ("--flow", &FLOW, self.flow),
            ("--cluster-spread", &CLUSTER_SPREAD, self.cluster_spread),
            ("--gap-length", &GAP_LENGTH, self.gap_length),
        ])?;
        Ok(shape)
    }

    /// The patterns that `--patterns` and `--flow` name, and the shape of their feeds.
    ///
    /// # Errors
    /// A text that is no source, flags that have no meaning for it.
    pub fn source(
        &self,
        patterns: &str,
        station: &StationChoice,
    ) -> Result<(PatternSource, FeedShape)> {
        let source = patterns.parse::<PatternSource>()?.with_flow(self.flow)?;
        let feeds: Vec<&Feed> = source.feed().into_iter().collect();
        let shape = self.shape(&feeds, station)?;
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
    pub fn check_on(
        &self,
        choice: &StationChoice,
        common: &Common,
        station: &Station,
    ) -> Result<()> {
        let camera = self.camera_x;
        let camera = camera.and_then(|x| station.check_camera("--camera-x", x));
        let noise = POSITION_NOISE.check("--position-noise", self.position_noise);
        let rate = check_rate("--update-hz", common.update_hz);
        warn(choice.strict, camera.into_iter().chain(noise).chain(rate))
    }

    /// The conditions, their luck under the master seed.
    ///
    /// # Errors
    /// Values that are none.
    pub fn resolve(&self, common: &Common) -> Result<Conditions> {
        if let Some(given) = &self.grasp_failures {
            let number = if given.is_empty() { "" } else { " " };
            return Err(Error::input(
                "--grasp-failures",
                "is now called --grasp-success: its number is the probability that a grasp \
                 succeeds",
                format!(
                    "write --grasp-success{number}{} if that is what the number means",
                    shown(given)
                ),
            ));
        }
        let conditions = Conditions {
            update_hz: common.update_hz,
            camera_x: self.camera_x,
            disturbances: Disturbances {
                grasp_failures: self.grasp_success.is_some(),
                default_p_grasp: self.grasp_success.unwrap_or(1.0),
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

/// The strategy to run where `--strategy` is not given, and words for where it is from: the
/// station file's own, else the paper's.
pub fn default_strategy(saved: Option<String>, robots: usize) -> (String, &'static str) {
    match saved {
        Some(text) => (text, ", the strategy of the station file"),
        None => (strategies::default_strategy(robots), ""),
    }
}

/// Spacing [m] and number of items of the pattern that stands in where none is given.
pub const DEFAULT_GRID: (f64, usize) = (0.15, 50);

/// What is told where `--grasp-success` makes no difference.
pub const NOTHING_FAILS: &str = "no item has a p_grasp below 1, so no grasp fails; give \
     --grasp-success P for items without one";

/// What turns the seed of one kind of luck into that of another, far from the seeds of
/// sets of patterns that follow each other.
const OTHER_LUCK: u64 = 1 << 32;

/// The conditions with luck that a set judged under `conditions` never meets: for training
/// and for fresh patterns.
pub fn other_luck(conditions: &Conditions) -> Conditions {
    let seed = conditions.disturbances.seed;
    conditions.with_seed(seed.wrapping_add(OTHER_LUCK))
}

impl LimitArgs {
    /// The limits of a search.
    ///
    /// # Errors
    /// A time that is none.
    pub fn resolve(&self) -> Result<Limits> {
        let seconds = |limit: f64| {
            let time = Duration::try_from_secs_f64(limit).ok();
            let time = time.filter(|time| !time.is_zero() && limit <= LONGEST);
            time.ok_or_else(|| {
                Error::input(
                    "--time-limit",
                    format!("{} is not a time for a search", shown_number(limit)),
                    format!("give seconds, above 0 and up to {LONGEST:e}"),
                )
            })
        };
        let time = self.time_limit.map(seconds).transpose()?;
        Ok(Limits {
            runs: match self.max_runs {
                None => MostRuns::Usual,
                Some(0) => MostRuns::Any,
                Some(runs) => MostRuns::Of(runs),
            },
            until: time.map(|time| Instant::now() + time),
        })
    }
}

/// Longer times than this [s] are taken for a slip of the pen.
const LONGEST: f64 = 1e7;

/// What a reader of a comparison under `conditions` should know. `generated` says that no
/// pattern comes from a file.
pub fn condition_notes(conditions: &Conditions, generated: bool) -> Vec<String> {
    let nothing = generated && conditions.disturbances.never_fails(&[]);
    nothing
        .then(|| NOTHING_FAILS.to_owned())
        .into_iter()
        .collect()
}
