//! The arguments for ROS 2: which graph to join, and how.

use clap::Args;
use std::net::IpAddr;

/// Communication over a ROS 2 graph.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "ROS 2")]
pub(crate) struct Ros2Args {
    /// Join a ROS 2 graph (Jazzy, any DDS) instead of using stdin and stdout
    #[arg(long, conflicts_with_all = ["listen", "connect"])]
    #[cfg_attr(feature = "mqtt", arg(conflicts_with = "mqtt"))]
    pub ros2: bool,
    /// Prefix of all topics
    #[arg(
        long,
        value_name = "NAME",
        default_value = "/pickline",
        requires = "ros2"
    )]
    pub ros2_namespace: String,
    /// DDS domain, 0 to 232 [default: ROS_DOMAIN_ID, otherwise 0]
    #[arg(
        long,
        value_name = "N",
        requires = "ros2",
        allow_negative_numbers = true
    )]
    pub ros2_domain: Option<u16>,
    /// The belt's frame, the `frame_id` of all positions; messages in other frames are refused
    #[arg(long, value_name = "FRAME", default_value = "belt", requires = "ros2")]
    pub ros2_frame: String,
    /// Address of this machine in the robots' network; may be given several times
    /// [default: 127.0.0.1, this machine only]
    #[arg(long, value_name = "ADDRESS", requires = "ros2")]
    pub ros2_network: Vec<IpAddr>,
    /// Also accept best-effort publishers of detections; detections may get lost
    #[arg(long, requires = "ros2")]
    pub ros2_best_effort: bool,
}
