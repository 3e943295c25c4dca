//! Settings for a ROS 2 graph.

use crate::transport::Side;
use std::net::IpAddr;

/// Settings for a ROS 2 graph.
#[derive(Debug, Clone)]
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
