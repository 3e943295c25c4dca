//! Settings of the connection to a broker.

use super::url::Broker;
use crate::ClockKind;
use crate::transport::Side;

/// Settings of the connection to a broker.
#[derive(Debug, Clone)]
pub struct MqttSettings {
    /// The broker.
    pub broker: Broker,
    /// Prefix of all topics.
    pub prefix: String,
    /// Client id; if none, a new one for every run.
    pub client_id: Option<String>,
    /// Certificates of trusted authorities (PEM); if none, those of the machine.
    pub authorities: Option<Vec<u8>>,
    /// Certificate and key of this client (PEM).
    pub certificate: Option<(Vec<u8>, Vec<u8>)>,
    /// Which of the two programs this is.
    pub side: Side,
    /// The kind of clock.
    pub clock: ClockKind,
}
