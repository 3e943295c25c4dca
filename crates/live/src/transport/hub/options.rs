//! The settings of the hub.

use crate::ClockKind;
use crate::protocol::Hello;
use crate::transport::{Access, Dialect, Side};
use pickline::station::Station;

/// Maximum number of simultaneous peers over TCP, unless another number is given.
const USUAL_PEERS: usize = 64;

/// The settings of the hub.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct HubOptions {
    /// Which side this is.
    pub side: Side,
    /// Whether to wait for a slow peer, as with message time, instead of disconnecting it.
    pub waits: bool,
    /// The names of the station's robots, upstream first.
    pub robots: Vec<String>,
    /// What a peer must present when it connects.
    pub access: Access,
    /// Maximum number of peers over TCP at a time.
    pub most_peers: usize,
    /// The hello that a station sends first over TCP.
    pub hello: Option<Hello>,
    /// The dialect on streams.
    pub dialect: Dialect,
}

impl HubOptions {
    /// This side of the line of `station`, in JSON, without authentication, and with at most 64
    /// peers. With message time, slow peers are waited for.
    pub fn new(side: Side, station: &Station, clock: ClockKind) -> Self {
        let robots = station.robots().iter().map(|robot| robot.name.clone());
        Self {
            side,
            waits: clock == ClockKind::Messages,
            robots: robots.collect(),
            access: Access::default(),
            most_peers: USUAL_PEERS,
            hello: None,
            dialect: Dialect::Json,
        }
    }

    /// With peers that must present this when they connect.
    #[must_use]
    pub fn with_access(mut self, access: Access) -> Self {
        self.access = access;
        self
    }

    /// With at most this number of peers over TCP at a time.
    #[must_use]
    pub fn with_most_peers(mut self, most_peers: usize) -> Self {
        self.most_peers = most_peers;
        self
    }

    /// With this hello, which a station sends first over TCP.
    #[must_use]
    pub fn with_hello(mut self, hello: Hello) -> Self {
        self.hello = Some(hello);
        self
    }

    /// With this dialect on streams.
    #[must_use]
    pub fn with_dialect(mut self, dialect: Dialect) -> Self {
        self.dialect = dialect;
        self
    }
}
