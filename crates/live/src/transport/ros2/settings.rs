//! Settings for a ROS 2 graph.

use crate::ClockKind;
use crate::transport::Side;
use std::net::{IpAddr, Ipv4Addr};

/// Settings for a ROS 2 graph.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Ros2Settings {
    /// DDS domain.
    pub domain: u16,
    /// Namespace of all topics: `/` and a name.
    pub namespace: String,
    /// The frame of all positions: the belt's.
    pub frame: String,
    /// Addresses of this machine in the networks to use.
    pub networks: Vec<IpAddr>,
    /// Whether detections are also accepted from best-effort publishers.
    pub best_effort: bool,
    /// Which of the two programs this is.
    pub side: Side,
    /// Whether node and station take turns, as with message time.
    pub turns: bool,
}

impl Ros2Settings {
    /// Domain 0 on this machine only, with topics in `namespace` (`/` and a name) and positions in
    /// the frame `belt`. With message time, node and station take turns.
    pub fn new(namespace: &str, side: Side, clock: ClockKind) -> Self {
        Self {
            domain: 0,
            namespace: namespace.to_owned(),
            frame: "belt".to_owned(),
            networks: vec![IpAddr::V4(Ipv4Addr::LOCALHOST)],
            best_effort: false,
            side,
            turns: clock == ClockKind::Messages,
        }
    }

    /// With this DDS domain.
    #[must_use]
    pub fn with_domain(mut self, domain: u16) -> Self {
        self.domain = domain;
        self
    }

    /// With positions in this frame.
    #[must_use]
    pub fn with_frame(mut self, frame: &str) -> Self {
        self.frame = frame.to_owned();
        self
    }

    /// With the networks in which this machine has these addresses.
    #[must_use]
    pub fn with_networks(mut self, networks: Vec<IpAddr>) -> Self {
        self.networks = networks;
        self
    }

    /// With detections from best-effort publishers too, or without them.
    #[must_use]
    pub fn with_best_effort(mut self, best_effort: bool) -> Self {
        self.best_effort = best_effort;
        self
    }
}
