//! Feeds: ways in which items arrive, each with a given flow.
//!
//! The flow [1/min] is the number of items that pass a fixed point beside the belt per minute. On a
//! belt with speed V [m/s] it is 60 V times the density, the items per metre of belt [1/m]. A
//! pattern is fixed in space, so its flow changes with the belt speed.

use super::clustered::clustered;
use super::gaps::gaps;
use super::grid::{check_count, check_length, lattice};
use super::item::{Item, MOST_ITEMS, Pattern};
use super::poisson::{poisson_disk, radius_of};
use super::profile::Profile;
use crate::error::{Error, Result, shown_number};
use crate::station::Belt;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::Exp1;
use std::fmt;
use std::path::{Path, PathBuf};

/// A way in which items arrive.
#[derive(Debug, Clone, PartialEq)]
pub enum Feed {
    /// Rows and columns, as close to a square lattice as the flow allows.
    Grid,
    /// A maximal Poisson disk sample with the radius that gives the flow.
    PoissonDisk,
    /// A Poisson process: items are independent and may overlap.
    Random,
    /// Clusters at random positions: a Thomas process.
    Clustered,
    /// Random items with stretches of empty belt: an interrupted Poisson process.
    Gaps,
    /// Random items whose flow follows the profile in this file: an inhomogeneous
    /// Poisson process.
    Profile(PathBuf),
}

/// Every feed by name, with a description. A profile also needs a file.
pub const FEEDS: [(&str, &str); 6] = [
    ("grid", "rows and columns"),
    ("poisson", "Poisson disk, no two items close"),
    ("random", "Poisson process, items may overlap"),
    ("clustered", "clusters at random places"),
    ("gaps", "random, with stretches of empty belt"),
    ("profile", "random, the flow over time from a CSV file"),
];

impl Feed {
    /// The feed with this name; `None` if the name is unknown or the feed needs a file.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "grid" => Self::Grid,
            "poisson" => Self::PoissonDisk,
            "random" => Self::Random,
            "clustered" => Self::Clustered,
            "gaps" => Self::Gaps,
            _ => return None,
        })
    }

    /// The feed's name in [`FEEDS`].
    pub fn name(&self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::PoissonDisk => "poisson",
            Self::Random => "random",
            Self::Clustered => "clustered",
            Self::Gaps => "gaps",
            Self::Profile(_) => "profile",
        }
    }

    /// Whether a different seed gives a different pattern.
    pub fn is_random(&self) -> bool {
        *self != Self::Grid
    }

    /// The file that the feed reads, if any.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Profile(path) => Some(path),
            _ => None,
        }
    }
}

impl fmt::Display for Feed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Profile(path) => write!(f, "profile:{}", path.display()),
            _ => f.write_str(self.name()),
        }
    }
}

/// Parameters of the feeds other than the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedShape {
    /// Mean number of items in a cluster.
    pub cluster_size: f64,
    /// Standard deviation of an item's distance from its cluster's centre, along the belt
    /// and across [m].
    pub cluster_spread: f64,
    /// Mean length of an empty stretch [m].
    pub gap_length: f64,
    /// Share of the belt in empty stretches.
    pub gap_share: f64,
}

impl Default for FeedShape {
    fn default() -> Self {
        Self {
            cluster_size: 5.0,
            cluster_spread: 0.1,
            gap_length: 1.0,
            gap_share: 0.3,
        }
    }
}

impl FeedShape {
    /// Rejects parameters out of range; the error names the flag.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn check(&self) -> Result<()> {
        let within = |flag: &str, value: f64, low: f64, high: f64, what: &str| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::input(
                flag,
                format!("{} is not a valid {what}", shown_number(value)),
                format!(
                    "give a value from {} to {}",
                    shown_number(low),
                    shown_number(high)
                ),
            ))
        };
        within(
            "--cluster-size",
            self.cluster_size,
            1.0,
            1e6,
            "number of items",
        )?;
        within(
            "--cluster-spread",
            self.cluster_spread,
            0.0,
            100.0,
            "distance [m]",
        )?;
        within(
            "--gap-length",
            self.gap_length,
            0.01,
            1e4,
            "length of belt [m]",
        )?;
        within(
            "--gap-share",
            self.gap_share,
            1e-3,
            0.999,
            "share of the belt",
        )
    }
}

/// A feed with all inputs except the random numbers: the profile has been read.
#[derive(Debug, Clone)]
pub struct Feeder {
    feed: Feed,
    flow: f64,
    belt: Belt,
    shape: FeedShape,
    profile: Option<Profile>,
}

impl Feeder {
    /// Prepares `feed` with `flow` [1/min] on `belt`. A profile needs no flow; if one is given, the
    /// profile is scaled to that mean.
    ///
    /// # Errors
    /// If the flow is missing or invalid, the shape is out of range, or the profile cannot be read.
    pub fn new(feed: &Feed, flow: Option<f64>, belt: &Belt, shape: FeedShape) -> Result<Self> {
        shape.check()?;
        let profile = feed.file().map(Profile::load).transpose()?;
        if let Some(profile) = &profile {
            let share = flow.map_or(1.0, |flow| flow / profile.mean_flow());
            profile.check_items(share)?;
        }
        let flow = match (flow, &profile) {
            (Some(flow), _) => check_flow(flow)?,
            (None, Some(profile)) => profile.mean_flow(),
            (None, None) => {
                return Err(Error::input(
                    "--flow",
                    format!("the feed {feed} needs a flow"),
                    "give --flow F [items/min], for example --flow 60",
                ));
            }
        };
        Ok(Self {
            feed: feed.clone(),
            flow,
            belt: *belt,
            shape,
            profile,
        })
    }

    /// The requested flow [1/min].
    pub fn flow(&self) -> f64 {
        self.flow
    }

    /// Label of pattern number `place` of a set.
    pub(super) fn label(&self, place: usize) -> String {
        let (name, flow) = (self.feed.name(), shown_number(self.flow));
        match self.feed.is_random() {
            true => format!("{name} {flow}/min #{}", place + 1),
            false => format!("{name} {flow}/min"),
        }
    }

    /// Expected number of items in a pattern of at most `count`; a profile may end earlier.
    pub fn expected_items(&self, count: usize) -> f64 {
        let minutes = self.profile.as_ref().map(|p| p.duration() / 60.0);
        (count as f64).min(minutes.map_or(f64::INFINITY, |minutes| minutes * self.flow))
    }

    /// Draws a pattern of `count` items, or at most `count` items of a profile.
    ///
    /// # Errors
    /// If there are no items or too many, the pattern is too long, or the profile yields no item.
    /// item.
    pub fn draw(&self, count: usize, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        let width = self.belt.width;
        let density = self.flow / (60.0 * self.belt.speed);
        if let Some(profile) = &self.profile {
            return self.draw_profile(profile, count.min(MOST_ITEMS), rng);
        }
        check_count(count)?;
        // Clusters and gaps make some patterns longer than the mean.
        check_length(count, 2.0 * count as f64 / density)?;
        match self.feed {
            Feed::Grid => lattice(width, density, count),
            Feed::PoissonDisk => {
                let radius = radius_of(width, density);
                poisson_disk(width, radius, count, rng).map_err(|error| {
                    let flow = shown_number(self.flow);
                    error.at(&format!("--flow {flow}, a radius of {radius:.6} m"))
                })
            }
            Feed::Random => random(width, density, count, rng),
            Feed::Clustered => clustered(width, density, count, &self.shape, rng),
            Feed::Gaps | Feed::Profile(_) => gaps(width, density, count, &self.shape, rng),
        }
    }

    fn draw_profile(
        &self,
        profile: &Profile,
        count: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Pattern> {
        check_count(count)?;
        check_length(count, profile.duration() * self.belt.speed)?;
        let scale = self.flow / profile.mean_flow();
        let place = |time: f64, rng: &mut ChaCha8Rng| {
            (-self.belt.speed * time, across(self.belt.width, rng))
        };
        let items = profile.arrivals(scale, count, rng, place);
        if items.is_empty() {
            return Err(Error::input(
                profile.name(),
                "the profile yields no items",
                "give a higher flow, a longer profile or another --seed",
            ));
        }
        numbered(items)
    }
}

/// Checks the flow [1/min] and returns it.
pub(super) fn check_flow(flow: f64) -> Result<f64> {
    if (1e-3..=1e6).contains(&flow) {
        return Ok(flow);
    }
    Err(Error::input(
        "--flow",
        format!("{} is not a valid flow", shown_number(flow)),
        "give items per minute, from 0.001 to 1000000, for example 60",
    ))
}

/// Items at the given (along, across) positions [m], numbered in order.
pub(super) fn numbered(places: Vec<(f64, f64)>) -> Result<Pattern> {
    let item = |(i, (x, y)): (usize, (f64, f64))| Item::at((i + 1).to_string(), x, y);
    Pattern::new(places.into_iter().enumerate().map(item).collect())
}

/// A uniformly random position across a belt of `width` [m].
pub(super) fn across(width: f64, rng: &mut ChaCha8Rng) -> f64 {
    width * (rng.random::<f64>() - 0.5)
}

/// Items of a Poisson process of `density` [1/m]: distances along the belt are exponential, so that
/// the arrival times also form a Poisson process. Positions across the belt are uniform. The first
/// item is at x0 = 0.
fn random(width: f64, density: f64, count: usize, rng: &mut ChaCha8Rng) -> Result<Pattern> {
    let mut along = 0.0;
    let places = (0..count).map(|i| {
        if i > 0 {
            along -= rng.sample::<f64, _>(Exp1) / density;
        }
        (along, across(width, rng))
    });
    numbered(places.collect())
}
