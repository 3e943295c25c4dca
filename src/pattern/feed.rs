//! Feeds: ways in which items arrive.

use crate::error::{Error, Result, shown_number};
use crate::setters::setters;
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

/// Every feed by name, with a description. A profile also needs a file, so the list is by hand.
pub(crate) const FEEDS: [(&str, &str); 6] = [
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

    /// The name of the feed, for example `random`.
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
#[non_exhaustive]
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

setters!(FeedShape {
    /// With this mean number of items in a cluster.
    fn with_cluster_size(cluster_size: f64);
    /// With this standard deviation of an item's distance from its cluster's centre [m].
    fn with_cluster_spread(cluster_spread: f64);
    /// With empty stretches of this mean length [m].
    fn with_gap_length(gap_length: f64);
    /// With this share of the belt in empty stretches.
    fn with_gap_share(gap_share: f64);
});

/// Those parameters of a [`FeedShape`] that are given; the others have their usual values.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FeedParameters {
    /// [`FeedShape::cluster_size`].
    pub cluster_size: Option<f64>,
    /// [`FeedShape::cluster_spread`] [m].
    pub cluster_spread: Option<f64>,
    /// [`FeedShape::gap_length`] [m].
    pub gap_length: Option<f64>,
    /// [`FeedShape::gap_share`].
    pub gap_share: Option<f64>,
}

impl FeedParameters {
    /// The shape of feeds, where `feeds` are generated.
    ///
    /// # Errors
    /// A parameter out of range, or one that applies to none of `feeds`.
    pub fn shape(&self, feeds: &[&Feed]) -> Result<FeedShape> {
        for (setting, given, own) in [
            ("'cluster_size'", self.cluster_size, Feed::Clustered),
            ("'cluster_spread'", self.cluster_spread, Feed::Clustered),
            ("'gap_length'", self.gap_length, Feed::Gaps),
            ("'gap_share'", self.gap_share, Feed::Gaps),
        ] {
            if given.is_some() && !feeds.contains(&&own) {
                return Err(Error::usage(
                    setting,
                    format!("applies only to the feed {own}"),
                    format!("leave it out, or use the feed {own}"),
                ));
            }
        }
        let usual = FeedShape::default();
        let shape = usual
            .with_cluster_size(self.cluster_size.unwrap_or(usual.cluster_size))
            .with_cluster_spread(self.cluster_spread.unwrap_or(usual.cluster_spread))
            .with_gap_length(self.gap_length.unwrap_or(usual.gap_length))
            .with_gap_share(self.gap_share.unwrap_or(usual.gap_share));
        shape.check()?;
        Ok(shape)
    }
}

impl FeedShape {
    /// Rejects parameters out of range; the error names the setting.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn check(&self) -> Result<()> {
        let within = |setting: &str, value: f64, low: f64, high: f64, what: &str| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::usage(
                setting,
                format!("{} is not a valid {what}", shown_number(value)),
                format!(
                    "give a value from {} to {}",
                    shown_number(low),
                    shown_number(high)
                ),
            ))
        };
        within(
            "'cluster_size'",
            self.cluster_size,
            1.0,
            1e6,
            "number of items",
        )?;
        within(
            "'cluster_spread'",
            self.cluster_spread,
            0.0,
            100.0,
            "distance [m]",
        )?;
        within(
            "'gap_length'",
            self.gap_length,
            0.01,
            1e4,
            "length of belt [m]",
        )?;
        within(
            "'gap_share'",
            self.gap_share,
            1e-3,
            0.999,
            "share of the belt",
        )
    }
}
