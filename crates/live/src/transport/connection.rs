//! A connection that waits to be admitted.

use super::tls::Stream;
use std::net::SocketAddr;
use tokio::sync::OwnedSemaphorePermit;

/// A connection that is not yet admitted.
pub struct Connection {
    /// The stream of bytes in both directions, encrypted or not.
    pub stream: Stream,
    /// Address of the other side.
    pub address: Option<SocketAddr>,
    /// Held until the connection is admitted or closed, because only so many may wait.
    pub pending: OwnedSemaphorePermit,
}

impl std::fmt::Debug for Connection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Connection").field(&self.address).finish()
    }
}
