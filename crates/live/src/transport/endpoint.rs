//! Where the peers of a program are.

#[cfg(feature = "mqtt")]
use super::mqtt;
#[cfg(feature = "ros2")]
use super::ros2;

/// Where the peers are.
#[derive(Debug, Clone)]
pub enum Endpoint {
    /// One peer, on stdin and stdout.
    Stdio,
    /// All peers that connect to this address.
    Listen(String),
    /// The peer that listens at this address.
    Connect(String),
    /// All clients of this broker.
    #[cfg(feature = "mqtt")]
    Mqtt(Box<mqtt::MqttSettings>),
    /// All nodes of this ROS 2 graph.
    #[cfg(feature = "ros2")]
    Ros2(Box<ros2::Ros2Settings>),
}
