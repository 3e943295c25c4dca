//! Turns arguments into the library's settings.

use super::args::{
    AttributeArgs, Common, ConditionArgs, DetectionArgs, FeedArgs, LimitArgs, OutageArgs,
    PatternSetArgs, StationChoice, TrainingArgs,
};
use super::session::tell;
use super::warnings::warn;
use pickline::error::{Error, Result, shown, shown_number};
use pickline::files;
use pickline::optimize::Limits;
use pickline::pattern::{self, Attributes, Feed, FeedParameters, FeedShape, Pattern, grid};
use pickline::planning::Budget;
use pickline::plausible::{CLUSTER_SPREAD, FLOW, GAP_LENGTH};
use pickline::sim::{Conditions, Disturbances};
use pickline::station::{self, Overrides, Station};
use pickline::strategies::{self, StrategySpec};
use pickline::study::{DEFAULT_GRID, RobustTraining, ScoredPatterns};
use std::io::Read as _;
use std::path::Path;

impl StationChoice {
    /// The flag and file that the station comes from.
    pub(crate) fn file(&self) -> (&str, Option<&Path>) {
        ("--station", Some(Path::new(&self.station)))
    }

    /// The station's name: that of the built-in, or the file name without folder and
    /// extension.
    pub(crate) fn title(&self) -> String {
        let stem = Path::new(&self.station).file_stem();
        stem.map_or_else(
            || self.station.clone(),
            |stem| stem.to_string_lossy().into_owned(),
        )
    }

    /// The same station with another number of robots.
    pub(crate) fn with_robots(mut self, robots: usize) -> Self {
        self.robots = Some(robots);
        self
    }

    /// The station settings that the flags override.
    pub(crate) fn overrides(&self) -> Overrides {
        Overrides::default()
            .with_robots(self.robots)
            .with_belt_speed(self.belt_speed)
    }

    /// The station; warns about implausible values.
    ///
    /// # Errors
    /// As for [`StationChoice::resolve`] and [`warn`].
    pub(crate) fn load(&self) -> Result<Station> {
        self.load_with_strategy(&|_| ()).map(|(station, _)| station)
    }

    /// Like [`StationChoice::load`], with the strategy that the file names.
    ///
    /// # Errors
    /// As for [`StationChoice::resolve_with_strategy`] and [`warn`].
    pub(crate) fn load_with_strategy(
        &self,
        remark: &dyn Fn(&str),
    ) -> Result<(Station, Option<String>)> {
        let (station, strategy) = self.resolve_with_strategy(remark)?;
        let mut warnings = station.warnings(&self.station);
        if self.belt_speed.is_some() {
            // The speed comes from the flag, not from the file.
            let speed = format!("{}: belt.speed", self.station);
            for warning in warnings.iter_mut().filter(|w| w.place == speed) {
                warning.place = "--belt-speed".into();
            }
        }
        warn(self.strict, warnings)?;
        Ok((station, strategy))
    }

    /// The station, without remarks or warnings.
    ///
    /// # Errors
    /// As for [`StationChoice::resolve_with_strategy`].
    pub(crate) fn resolve(&self) -> Result<Station> {
        self.resolve_with_strategy(&|_| ())
            .map(|(station, _)| station)
    }

    /// The station, and the strategy that its file names. If `--robots` sets another number
    /// of robots than that strategy is for, it is ignored, and `remark` is called.
    ///
    /// # Errors
    /// As for [`station::load`]; a strategy that is invalid or does not fit the robots in the
    /// file.
    pub(crate) fn resolve_with_strategy(
        &self,
        remark: &dyn Fn(&str),
    ) -> Result<(Station, Option<String>)> {
        let (station, saved) = station::load_with_strategy(&self.station, self.overrides())?;
        let Some(mut saved) = saved else {
            return Ok((station, None));
        };
        // A policy's path is relative to the station file that names it.
        if let Some(policy) = strategies::policy_file(&saved.text)
            && let Some(folder) = Path::new(&self.station).parent()
        {
            saved.text = format!("onnx:{}", folder.join(policy).display());
        }
        let robots = station.robots().len();
        let in_file = |error: Error| error.at(&saved.place).into_input();
        let parsed = strategies::parse(&saved.text).map_err(in_file)?;
        match parsed.check_on(&station) {
            Ok(()) => Ok((station, Some(saved.text))),
            Err(_) if self.robots.is_some() => {
                remark(&format!(
                    "{}: ignoring {}, which does not fit --robots {robots}",
                    saved.place,
                    shown(&saved.text)
                ));
                Ok((station, None))
            }
            Err(error) => Err(in_file(error)),
        }
    }
}

impl FeedArgs {
    /// The shape of feeds, when the call generates `feeds`.
    ///
    /// # Errors
    /// A value out of range, or a flag that applies to none of `feeds`; with `--strict`, an
    /// implausible value.
    pub(crate) fn shape(&self, feeds: &[&Feed], station: &StationChoice) -> Result<FeedShape> {
        let parameters = FeedParameters {
            cluster_size: self.cluster_size,
            cluster_spread: self.cluster_spread,
            gap_length: self.gap_length,
            gap_share: self.gap_share,
        };
        let shape = parameters.shape(feeds)?;
        station.check_values(&[
            ("--flow", &FLOW, self.flow),
            ("--cluster-spread", &CLUSTER_SPREAD, self.cluster_spread),
            ("--gap-length", &GAP_LENGTH, self.gap_length),
        ])?;
        Ok(shape)
    }

    /// The patterns that `--patterns`, `--flow` and `--items` name.
    ///
    /// # Errors
    /// A text that is not a pattern source, or flags that do not apply to it.
    pub(crate) fn patterns(
        &self,
        text: &str,
        items: Option<usize>,
        station: &StationChoice,
    ) -> Result<ScoredPatterns> {
        let mut patterns: ScoredPatterns = text.parse()?;
        if let Some(flow) = self.flow {
            patterns = patterns.with_flow(flow)?;
        }
        if let Some(items) = items {
            patterns = patterns.with_items(items);
        }
        let feeds: Vec<&Feed> = patterns.source().feed().into_iter().collect();
        let shape = self.shape(&feeds, station)?;
        Ok(patterns.with_shape(shape))
    }
}

impl PatternSetArgs {
    /// The patterns on which assignments are scored.
    ///
    /// # Errors
    /// As for [`FeedArgs::patterns`]; an invalid distribution.
    pub(crate) fn resolve(&self, station: &StationChoice) -> Result<ScoredPatterns> {
        let patterns = self.feed.patterns(&self.patterns, self.items, station)?;
        Ok(patterns.with_attributes(self.attributes.resolve()?))
    }
}

impl TrainingArgs {
    /// How robust GT (game theory) is found for `station`: as asked for, otherwise on the
    /// paper's set, if `paper`, or on patterns like those scored.
    ///
    /// # Errors
    /// As for [`RobustTraining::named`].
    pub(crate) fn resolve(
        &self,
        station: &Station,
        seed: u64,
        paper: bool,
    ) -> Result<RobustTraining> {
        let (robust, set) = (self.robust.as_deref(), self.train_patterns.as_deref());
        RobustTraining::named(robust, set, self.train_items, paper, (station, seed))
    }
}

impl AttributeArgs {
    /// The distributions of the item attributes.
    ///
    /// # Errors
    /// As for [`Attributes::named`].
    pub(crate) fn resolve(&self) -> Result<Attributes> {
        Attributes::named(
            self.area.as_deref(),
            self.p_detection.as_deref(),
            self.p_grasp.as_deref(),
            self.classes.as_deref(),
        )
    }
}

impl ConditionArgs {
    /// The conditions, with the master seed for their random events.
    ///
    /// # Errors
    /// Invalid values.
    pub(crate) fn resolve(&self, common: &Common) -> Result<Conditions> {
        if let Some(given) = &self.grasp_failures {
            let number = if given.is_empty() { "" } else { " " };
            return Err(Error::usage(
                "--grasp-failures",
                "has been renamed to --grasp-success, whose number is the probability that a \
                 grasp succeeds",
                format!(
                    "use --grasp-success{number}{} if this number is the probability of success",
                    shown(given)
                ),
            ));
        }
        let conditions = Conditions::default()
            .with_update_hz(common.update_hz)
            .with_camera_x(self.camera_x)
            .with_min_detection(self.min_detection)
            .with_disturbances(
                Disturbances::default()
                    .with_grasp_failures(self.grasp_success.is_some())
                    .with_default_p_grasp(self.grasp_success.unwrap_or(1.0))
                    .with_position_noise(self.position_noise)
                    .with_seed(common.seed),
            );
        conditions.check()?;
        Ok(conditions)
    }
}

impl OutageArgs {
    /// `conditions` with these outages.
    ///
    /// # Errors
    /// A text that is not an outage, or whose times are not valid.
    pub(crate) fn added_to(&self, conditions: Conditions) -> Result<Conditions> {
        let random = self.outages.as_deref().map(str::parse).transpose()?;
        let mut given = self.outage.iter();
        given.try_fold(conditions.with_outages(random), |conditions, text| {
            Ok(conditions.with_outage(text.parse()?))
        })
    }
}

impl DetectionArgs {
    /// `conditions`, in which detections may be wrong if that is asked for.
    pub(crate) fn add_to(&self, mut conditions: Conditions) -> Conditions {
        conditions.disturbances.misdetections = self.misdetections;
        conditions
    }
}

impl Common {
    /// Checks the settings that all verbs share before the work begins: a long computation
    /// must not end with an output folder that cannot be written.
    ///
    /// # Errors
    /// An invalid number of threads, or a folder that cannot be created.
    pub(crate) fn check(&self) -> Result<()> {
        check_threads(self.threads)?;
        self.out.as_deref().map_or(Ok(()), files::check_folder)
    }

    /// Runs `work` on the chosen number of threads.
    ///
    /// # Errors
    /// As for [`on_threads`].
    pub(crate) fn on_threads<T: Send>(&self, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
        on_threads(self.threads, work)
    }

    /// A remark for the user, unless quiet.
    pub(crate) fn remark(&self, text: &str) {
        if !self.quiet {
            tell(text);
        }
    }
}

/// Checks the value of `--threads`.
///
/// # Errors
/// An invalid number of threads.
pub(crate) fn check_threads(threads: Option<usize>) -> Result<()> {
    match threads {
        Some(threads) if !(1..=1024).contains(&threads) => Err(Error::usage(
            "--threads",
            format!("{threads} is not a number of threads"),
            "give 1 to 1024, or leave it out for all cores",
        )),
        _ => Ok(()),
    }
}

/// Runs `work` on this number of threads, or on all cores.
///
/// # Errors
/// Threads that cannot be started, or what `work` returns.
pub(crate) fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    // 0 means all cores.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|error| {
            let cure = "close other programs, or use fewer threads, such as --threads 1";
            Error::resources("worker threads", error.to_string(), cure).caused_by(error)
        })?;
    pool.install(work)
}

/// The budget per decision from `--budget-ms`.
///
/// # Errors
/// An invalid time.
pub(crate) fn budget(ms: Option<f64>) -> Result<Option<Budget>> {
    let read = |ms: f64| {
        Budget::milliseconds(ms).ok_or_else(|| {
            let (least, most) = Budget::MILLISECONDS.into_inner();
            Error::usage(
                "--budget-ms",
                format!("{} is not a valid time for a decision", shown_number(ms)),
                format!("give milliseconds, from {least} to {most}"),
            )
        })
    };
    ms.map(read).transpose()
}

/// Parses the strategy in `text`; prints how it was interpreted, unless `quiet`.
///
/// # Errors
/// As for [`strategies::parse`].
pub(crate) fn parse_strategy(text: &str, quiet: bool) -> Result<StrategySpec> {
    let strategy = strategies::parse(text)?;
    if let Some(remark) = strategy.remark().filter(|_| !quiet) {
        tell(remark);
    }
    Ok(strategy)
}

/// The text on stdin.
pub(crate) fn read_stdin() -> Result<String> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .read_to_end(&mut bytes)
        .map_err(|error| Error::read(Path::new("stdin"), error))?;
    files::utf8(bytes, "stdin")
}

/// The pattern in `file` (`-` for stdin), or the built-in grid; and its description.
///
/// # Errors
/// A file that cannot be read or is not a pattern.
pub(crate) fn load_pattern(file: Option<&str>, width: f64) -> Result<(Pattern, String)> {
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
            let text = read_stdin()?;
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

/// The strategy to run without `--strategy`, and a text saying where it comes from: the
/// station file if it names one, otherwise the paper.
pub(crate) fn default_strategy(saved: Option<String>, robots: usize) -> (String, &'static str) {
    match saved {
        Some(text) => (text, ", the strategy of the station file"),
        None => (strategies::default_strategy(robots), ""),
    }
}

impl LimitArgs {
    /// The limits of a search.
    ///
    /// # Errors
    /// As for [`Limits::of`].
    pub(crate) fn resolve(&self) -> Result<Limits> {
        Limits::of(self.max_runs, self.time_limit)
    }
}
