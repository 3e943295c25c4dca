//! Draws patterns of a feed with a given flow.
//!
//! The flow [1/min] is the number of items that pass a fixed point beside the belt per minute. On a
//! belt with speed V [m/s] it is 60 V times the density, the items per metre of belt [1/m]. A
//! pattern is fixed in space, so its flow changes with the belt speed.

use super::clustered::clustered;
use super::feed::{Feed, FeedShape};
use super::gaps::gaps;
use super::grid::{check_count, check_length, lattice};
use super::item::{MOST_ITEMS, Pattern};
use super::poisson::{poisson_disk, radius_of};
use super::profile::Profile;
use super::random::{across, random};
use crate::error::{Error, Result, shown_number};
use crate::station::Belt;
use rand::rngs::ChaCha8Rng;

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
                return Err(Error::usage(
                    "'flow'",
                    format!("the feed {feed} needs a flow"),
                    "give 'flow' F [items/min], for example 'flow' 60",
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
    pub(crate) fn expected_items(&self, count: usize) -> f64 {
        let minutes = self.profile.as_ref().map(|p| p.duration() / 60.0);
        (count as f64).min(minutes.map_or(f64::INFINITY, |minutes| minutes * self.flow))
    }

    /// Draws a pattern of `count` items, or at most `count` items of a profile.
    ///
    /// # Errors
    /// If there are no items or too many, the pattern is too long, or the profile yields no item.
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
                    error.at(&format!("'flow' {flow}, a radius of {radius:.6} m"))
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
                "give a higher flow, a longer profile or another 'seed'",
            ));
        }
        Pattern::numbered(items)
    }
}

/// Checks the flow [1/min] and returns it.
pub(super) fn check_flow(flow: f64) -> Result<f64> {
    if (1e-3..=1e6).contains(&flow) {
        return Ok(flow);
    }
    Err(Error::usage(
        "'flow'",
        format!("{} is not a valid flow", shown_number(flow)),
        "give items per minute, from 0.001 to 1000000, for example 60",
    ))
}
