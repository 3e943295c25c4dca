//! `pickline pattern generate`.

use super::target::{write_pattern, written};
use crate::args::{GenerateArgs, PatternKind, StationChoice};
use crate::session::{Session, tell};
use pickline::error::{Error, Result, counted, shown_number};
use pickline::pattern::{
    Attributes, Feed, FeedShape, Feeder, Pattern, describe, grid, poisson_disk, random_stream,
};
use pickline::plausible::BELT_WIDTH;
use pickline::station::Belt;
use pickline::study::DEFAULT_GRID;
use pickline_report::{DescriptionReport, OutputProtection};
use rand::rngs::ChaCha8Rng;
use std::path::{Path, PathBuf};

/// Default radius [m] and number of items of a Poisson disk pattern: a case of the paper.
const DEFAULT_POISSON: (f64, usize) = (0.2, 29);
/// Default flow [1/min] of feeds other than profiles.
const DEFAULT_FLOW: f64 = 60.0;

pub(super) fn run(args: GenerateArgs, session: &Session) -> Result<()> {
    let plan = args.resolve()?;
    let pattern = plan.pattern()?;
    plan.choice.check_pattern("the pattern", &pattern, None)?;
    write_pattern(plan.output.as_deref(), &pattern, session)
}

/// A resolved call.
struct GeneratePlan {
    choice: StationChoice,
    belt: Belt,
    kind: Feed,
    shape: FeedShape,
    /// Flow [1/min].
    flow: Option<f64>,
    /// Distance between neighbours of a grid, or least distance of a Poisson disk pattern [m].
    distance: Option<f64>,
    /// Number of items.
    count: Option<usize>,
    attributes: Attributes,
    seed: u64,
    output: Option<PathBuf>,
    quiet: bool,
}

impl GenerateArgs {
    fn resolve(self) -> Result<GeneratePlan> {
        let output = written(self.output.clone());
        let read = [self.station.file(), ("--profile", self.profile.as_deref())];
        let targets = [("--output", output.as_deref())];
        OutputProtection::of("pattern generate")
            .with_force(self.force)
            .check(&read, &targets)?;
        let belt = self.chosen_belt()?;
        let attributes = self.attributes.resolve()?;
        let kind = self.kind.feed(self.profile.as_deref())?;
        self.check_distances(&kind)?;
        let shape = self.feed.shape(&[&kind], &self.station)?;
        Ok(GeneratePlan {
            choice: self.station,
            belt,
            kind,
            shape,
            flow: self.feed.flow,
            distance: self.spacing.or(self.radius),
            count: self.count,
            attributes,
            seed: self.seed,
            output,
            quiet: self.quiet,
        })
    }

    /// The belt of the station, with the width that the flag gives.
    ///
    /// # Errors
    /// An invalid station or width.
    fn chosen_belt(&self) -> Result<Belt> {
        // Load it even if the width is given: an invalid station must not go unnoticed.
        let station = self.station.load()?;
        let mut belt = *station.belt();
        match self.width {
            Some(width) if (1e-6..=1e3).contains(&width) => {
                let values = [("--width", &BELT_WIDTH, Some(width))];
                self.station.check_values(&values)?;
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
    fn check_distances(&self, kind: &Feed) -> Result<()> {
        let distances = [
            ("--spacing", self.spacing, Feed::Grid),
            ("--radius", self.radius, Feed::PoissonDisk),
        ];
        for (flag, distance, own) in &distances {
            if distance.is_some() && kind != own {
                return Err(foreign(flag, kind));
            }
            if distance.is_some() && self.feed.flow.is_some() {
                return Err(Error::usage(
                    "--flow",
                    format!("{flag} already determines the flow"),
                    "give only one of the two",
                ));
            }
        }
        Ok(())
    }
}

impl GeneratePlan {
    fn pattern(&self) -> Result<Pattern> {
        let mut rng = random_stream(self.seed, 0);
        let by_distance = self.flow.is_none();
        let pattern = match &self.kind {
            Feed::Grid if by_distance => self.grid(),
            Feed::PoissonDisk if by_distance => self.poisson_disk(&mut rng),
            _ => self.feed(&mut rng),
        };
        self.attributes.apply(pattern?, &mut rng)
    }

    /// A grid, given by the distance between its items.
    fn grid(&self) -> Result<Pattern> {
        let (spacing, count) = self.distance_and_count(DEFAULT_GRID, "the grid");
        grid(self.belt.width, spacing, count)
    }

    /// A Poisson disk pattern, given by the least distance between its items.
    fn poisson_disk(&self, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        let (radius, count) = self.distance_and_count(DEFAULT_POISSON, "a Poisson disk pattern");
        poisson_disk(self.belt.width, radius, count, rng)
    }

    /// The distance between items and their number, as given or else as in `usual`; says what
    /// is generated if one of them is not given.
    fn distance_and_count(&self, usual: (f64, usize), what: &str) -> (f64, usize) {
        let distance = self.distance.unwrap_or(usual.0);
        let count = self.count.unwrap_or(usual.1);
        if (self.distance.is_none() || self.count.is_none()) && !self.quiet {
            tell(&format!("generating {what} of {distance} m, {count} items"));
        }
        (distance, count)
    }

    /// A pattern of the feed, given by its flow.
    fn feed(&self, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        let (kind, belt) = (&self.kind, &self.belt);
        let (usual_flow, usual_count) = match kind.file() {
            Some(_) => (None, usize::MAX),
            None => (Some(DEFAULT_FLOW), DEFAULT_GRID.1),
        };
        let feeder = Feeder::new(kind, self.flow.or(usual_flow), belt, self.shape)?;
        let pattern = feeder.draw(self.count.unwrap_or(usual_count), rng)?;
        if let Some(count) = self.count.filter(|count| *count > pattern.len()) {
            tell(&format!(
                "warning: --count {count}: the profile has only {} items",
                pattern.len()
            ));
        }
        if !self.quiet {
            tell(&format!(
                "generating the feed {kind} of {} items/min at {} m/s: {}",
                shown_number(feeder.flow()),
                shown_number(belt.speed),
                achieved(&pattern, belt.speed)
            ));
        }
        Ok(pattern)
    }
}

/// The flow that a pattern actually has, as text.
fn achieved(pattern: &Pattern, belt_speed: f64) -> String {
    let count = counted(pattern.len(), "item");
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
