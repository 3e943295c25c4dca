//! Feeds: ways in which items arrive, each set by its flow.
//!
//! The flow [1/min] is how many items pass a place beside the belt in a minute. On a belt
//! of speed V [m/s] it is 60 V times the density, the items per metre of belt [1/m]; a
//! pattern is fixed in space, so at another speed its flow is another.

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
    /// Rows and columns, as near to a square lattice as the flow allows.
    Grid,
    /// A maximal Poisson disk sample of the radius that gives the flow.
    PoissonDisk,
    /// A Poisson process: no item knows of another, so they may overlap.
    Random,
    /// Clusters at random places: a Thomas process.
    Clustered,
    /// Random items with stretches of empty belt: an interrupted Poisson process.
    Gaps,
    /// Random items whose flow follows the profile in this file: an inhomogeneous
    /// Poisson process.
    Profile(PathBuf),
}

/// Every feed as it is written, with what it is. A profile has its file besides.
pub const FEEDS: [(&str, &str); 6] = [
    ("grid", "rows and columns"),
    ("poisson", "Poisson disk, no two items close"),
    ("random", "Poisson process, items may overlap"),
    ("clustered", "clusters at random places"),
    ("gaps", "random, with stretches of empty belt"),
    ("profile", "random, the flow over time from a CSV file"),
];

impl Feed {
    /// The feed of this name; none of one that is unknown or needs a file.
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

    /// How it is written in [`FEEDS`].
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

    /// Whether another seed gives another pattern.
    pub fn is_random(&self) -> bool {
        *self != Self::Grid
    }

    /// The file that it reads.
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

/// What shapes feeds besides their flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedShape {
    /// Mean number of items in a cluster.
    pub cluster_size: f64,
    /// Standard deviation of an item's distance from its cluster's centre, along the belt
    /// and across [m].
    pub cluster_spread: f64,
    /// Mean length of an empty stretch [m].
    pub gap_length: f64,
    /// Share of the belt that lies in empty stretches.
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
    /// Refuses what no feed has, named by its flag.
    ///
    /// # Errors
    /// A figure out of its range.
    pub fn check(&self) -> Result<()> {
        let within = |flag: &str, value: f64, low: f64, high: f64, what: &str| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::input(
                flag,
                format!("{} is not {what}", shown_number(value)),
                format!("give {} to {}", shown_number(low), shown_number(high)),
            ))
        };
        within(
            "--cluster-size",
            self.cluster_size,
            1.0,
            1e6,
            "a number of items",
        )?;
        within(
            "--cluster-spread",
            self.cluster_spread,
            0.0,
            100.0,
            "a distance [m]",
        )?;
        within(
            "--gap-length",
            self.gap_length,
            0.01,
            1e4,
            "a length of belt [m]",
        )?;
        within(
            "--gap-share",
            self.gap_share,
            1e-3,
            0.999,
            "a share of the belt",
        )
    }
}

/// A feed with everything that it needs but the random numbers: the profile is read.
#[derive(Debug, Clone)]
pub struct Feeder {
    feed: Feed,
    flow: f64,
    belt: Belt,
    shape: FeedShape,
    profile: Option<Profile>,
}

impl Feeder {
    /// `feed` of `flow` [1/min] on `belt`. A profile needs no flow; with one it is scaled
    /// to that mean.
    ///
    /// # Errors
    /// A flow that is none or missing, a shape out of range, a profile that cannot be read.
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

    /// The flow asked for [1/min].
    pub fn flow(&self) -> f64 {
        self.flow
    }

    /// How pattern number `place` of a set is called.
    pub(super) fn label(&self, place: usize) -> String {
        let (name, flow) = (self.feed.name(), shown_number(self.flow));
        match self.feed.is_random() {
            true => format!("{name} {flow}/min #{}", place + 1),
            false => format!("{name} {flow}/min"),
        }
    }

    /// How many items a pattern has, of at most `count`: a profile ends.
    pub fn expected_items(&self, count: usize) -> f64 {
        let minutes = self.profile.as_ref().map(|p| p.duration() / 60.0);
        (count as f64).min(minutes.map_or(f64::INFINITY, |minutes| minutes * self.flow))
    }

    /// A pattern of `count` items, of a profile as many as it brings and at most that.
    ///
    /// # Errors
    /// No items or too many, more belt than a pattern may take, a profile that brings no
    /// item.
    pub fn draw(&self, count: usize, rng: &mut ChaCha8Rng) -> Result<Pattern> {
        let width = self.belt.width;
        let density = self.flow / (60.0 * self.belt.speed);
        if let Some(profile) = &self.profile {
            return self.draw_profile(profile, count.min(MOST_ITEMS), rng);
        }
        check_count(count)?;
        // Clusters and gaps put some patterns further apart than the mean.
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
                "the profile brought no item",
                "give a higher flow, a longer profile or another --seed",
            ));
        }
        numbered(items)
    }
}

/// The flow, if it is one.
pub(super) fn check_flow(flow: f64) -> Result<f64> {
    if (1e-3..=1e6).contains(&flow) {
        return Ok(flow);
    }
    Err(Error::input(
        "--flow",
        format!("{} is not a flow", shown_number(flow)),
        "give items per minute, from 0.001 to 1000000, for example 60",
    ))
}

/// Items at (along, across) [m], numbered as given.
pub(super) fn numbered(places: Vec<(f64, f64)>) -> Result<Pattern> {
    let item = |(i, (x, y)): (usize, (f64, f64))| Item::at((i + 1).to_string(), x, y);
    Pattern::new(places.into_iter().enumerate().map(item).collect())
}

/// A place across a belt of `width` [m], evenly.
pub(super) fn across(width: f64, rng: &mut ChaCha8Rng) -> f64 {
    width * (rng.random::<f64>() - 0.5)
}

/// Items of a Poisson process of `density` [1/m]: the distances along the belt are
/// exponential, so the arrival times are those of a Poisson process too, and the places
/// across are even. The first is at x0 = 0.
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
