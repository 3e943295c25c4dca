//! Settings of the connection to a broker.

use super::url::Broker;
use crate::ClockKind;
use crate::transport::Side;

/// Settings of the connection to a broker.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MqttSettings {
    /// The address of the broker, and who this client is there.
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

impl MqttSettings {
    /// A client of `broker` with topics under `prefix`, a new client id, and the authorities that
    /// this machine trusts.
    pub fn new(broker: Broker, prefix: &str, side: Side, clock: ClockKind) -> Self {
        Self {
            broker,
            prefix: prefix.to_owned(),
            client_id: None,
            authorities: None,
            certificate: None,
            side,
            clock,
        }
    }

    /// With this client id.
    #[must_use]
    pub fn with_client_id(mut self, client_id: impl Into<Option<String>>) -> Self {
        self.client_id = client_id.into();
        self
    }

    /// With the certificates of these authorities (PEM).
    #[must_use]
    pub fn with_authorities(mut self, authorities: impl Into<Option<Vec<u8>>>) -> Self {
        self.authorities = authorities.into();
        self
    }

    /// With this certificate and key (PEM).
    #[must_use]
    pub fn with_certificate(mut self, certificate: impl Into<Option<(Vec<u8>, Vec<u8>)>>) -> Self {
        self.certificate = certificate.into();
        self
    }
}
