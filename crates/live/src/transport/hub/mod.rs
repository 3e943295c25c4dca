//! The hub of all peers: which are connected, which message goes to which, and which are
//! disconnected.

mod admission;
mod hello;
mod options;
mod sending;

use crate::protocol::{HelloAnswer, Message};
#[cfg(feature = "mqtt")]
use crate::transport::mqtt;
use crate::transport::peer::Peer;
#[cfg(feature = "ros2")]
use crate::transport::ros2;
use crate::transport::tcp::{CLOSE_TIMEOUT, Tcp, WRITE_TIMEOUT};
use crate::transport::{
    Endpoint, INBOX_CAPACITY, Origin, RETRY_INTERVAL, Side, TransportEvent, listen_at, stream,
};
use pickline::error::{Error, Result, shown};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::SocketAddr;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

pub(crate) use hello::HelloOutcome;
pub use options::HubOptions;

/// A peer that has sent nothing for this time after connecting is treated as one without a hello.
const HELLO_TIMEOUT: Duration = Duration::from_millis(200);
/// If a token is required, a peer that has not presented it after this time is disconnected.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(5);

/// The peers of one side of a line, and the inbox for what they send.
#[derive(Debug)]
pub struct Hub {
    terms: HubOptions,
    inbox: Receiver<TransportEvent>,
    /// Remarks to be delivered before anything else.
    remarks: VecDeque<String>,
    peers: BTreeMap<u64, Peer>,
    next: u64,
    /// Robots named in a hello: only the peer that named them may speak for them.
    owned: BTreeSet<usize>,
    /// Peers that are being disconnected, and when they are cut off.
    leaving: Vec<(Instant, u64)>,
    tcp: Option<Tcp>,
    address: Option<SocketAddr>,
    connects_to: Option<String>,
    /// Keeps the inbox open.
    _sender: SyncSender<TransportEvent>,
    is_stdio: bool,
}

impl Hub {
    /// Opens the place. A connection is retried until something listens there.
    ///
    /// # Errors
    /// The address is invalid, or cannot be listened on.
    pub fn open(place: &Endpoint, terms: HubOptions) -> Result<Self> {
        let (sender, inbox) = sync_channel(INBOX_CAPACITY);
        let mut hub = Self {
            inbox,
            remarks: VecDeque::new(),
            peers: BTreeMap::new(),
            next: 1,
            owned: BTreeSet::new(),
            leaving: Vec::new(),
            tcp: None,
            address: None,
            connects_to: None,
            _sender: sender.clone(),
            is_stdio: matches!(place, Endpoint::Stdio),
            terms,
        };
        hub.start(place, sender)?;
        Ok(hub)
    }

    /// Starts the peer or the thread of connections at `endpoint`.
    fn start(&mut self, endpoint: &Endpoint, sender: SyncSender<TransportEvent>) -> Result<()> {
        match endpoint {
            Endpoint::Stdio => {
                let peer = stream::start(
                    0,
                    std::io::stdin(),
                    std::io::stdout(),
                    self.terms.dialect,
                    sender,
                );
                self.peers.insert(0, peer);
            }
            Endpoint::Listen(address) => {
                let listener = listen_at("'listen'", address)?;
                self.address = listener.local_addr().ok();
                let tcp = Tcp::start(sender, self.terms.access.tls.clone(), self.terms.dialect)?;
                tcp.listen(listener).map_err(|error| {
                    let cure = "try again";
                    let problem = format!("{}: {error}", shown(address));
                    Error::resources("'listen'", problem, cure).caused_by(error)
                })?;
                self.tcp = Some(tcp);
            }
            Endpoint::Connect(address) => {
                if std::net::ToSocketAddrs::to_socket_addrs(address.as_str()).is_err() {
                    let problem = format!("`{}` is not a valid address", shown(address));
                    let cure = "give HOST:PORT, for example 127.0.0.1:7400";
                    return Err(Error::usage("'connect'", problem, cure));
                }
                let tcp = Tcp::start(sender, self.terms.access.tls.clone(), self.terms.dialect)?;
                tcp.connect(address.clone(), Duration::ZERO);
                self.connects_to = Some(address.clone());
                self.tcp = Some(tcp);
            }
            #[cfg(feature = "mqtt")]
            Endpoint::Mqtt(settings) => {
                let peer = mqtt::start(self.next, settings, sender)?;
                self.keep(peer);
            }
            #[cfg(feature = "ros2")]
            Endpoint::Ros2(settings) => {
                let peer = ros2::start(self.next, settings, sender)?;
                self.keep(peer);
            }
        }
        Ok(())
    }

    fn keep(&mut self, peer: Peer) -> u64 {
        let number = self.next;
        self.peers.insert(number, peer);
        self.next += 1;
        number
    }

    /// The address that it listens on.
    pub fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    /// Whether its only peer is on stdin and stdout.
    pub fn is_stdio(&self) -> bool {
        self.is_stdio
    }

    /// Whether it connects to its only peer.
    pub(crate) fn connects(&self) -> bool {
        self.connects_to.is_some()
    }

    /// Number of connected peers.
    pub fn peers(&self) -> usize {
        self.peers.values().filter(|peer| peer.is_up()).count()
    }

    /// The next event from the peers within `timeout`.
    pub fn next_event(&mut self, timeout: Duration) -> Option<TransportEvent> {
        self.run_timers();
        if let Some(remark) = self.remarks.pop_front() {
            return Some(TransportEvent::Remark(remark));
        }
        // The hub keeps a sender, so it is never disconnected.
        let heard = self.inbox.recv_timeout(timeout).ok()?;
        if let Some(tcp) = &self.tcp {
            tcp.free_inbox_slot();
        }
        Some(heard)
    }

    /// Does what is due by time alone: sends queued messages, stops waiting for hellos, and
    /// disconnects peers whose time is up.
    pub(crate) fn run_timers(&mut self) {
        for peer in self.peers.values_mut() {
            peer.flush();
        }
        let needs_token = self.needs_token();
        let grace = if needs_token {
            TOKEN_TIMEOUT
        } else {
            HELLO_TIMEOUT
        };
        let unknown = self.peers.iter();
        let unknown = unknown.filter(|(_, peer)| peer.unknown_for().is_some_and(|t| t >= grace));
        let unknown: Vec<u64> = unknown.map(|(number, _)| *number).collect();
        for number in unknown {
            if needs_token {
                self.dismiss(number, "it sent no hello with a token in time");
            } else {
                self.release(number);
            }
        }
        let now = Instant::now();
        let peers = &mut self.peers;
        self.leaving.retain(|(at, number)| {
            let waits = now < *at;
            if !waits && let Some(peer) = peers.get_mut(number) {
                peer.disconnect();
            }
            waits
        });
    }

    fn needs_token(&self) -> bool {
        let asks = self.terms.side == Side::Node && self.connects_to.is_none();
        asks && self.terms.access.token.is_some()
    }

    /// The peer's identity is known or no longer waited for: sends the messages since it connected.
    fn release(&mut self, number: u64) {
        let Some(peer) = self.peers.get_mut(&number) else {
            return;
        };
        for message in peer.identify() {
            let robot = robot_of(&message, &self.terms.robots);
            if peer.identity.gets(&message, robot) {
                if self.terms.waits {
                    peer.send(message);
                } else {
                    peer.try_send(message, true);
                }
            }
        }
    }

    /// Disconnects a peer that began with something other than a message. Returns the remark for
    /// the user.
    pub fn foreign(&mut self, number: u64, start: &str) -> String {
        let title = self.peers.get(&number).map(Peer::title);
        let reason = "what it sends is not the live protocol, which is one JSON object per line";
        self.dismiss(number, reason);
        let title = title.unwrap_or_default();
        format!(
            "{title} was disconnected: {reason}; it begins with `{}`",
            shown(start)
        )
    }

    /// Disconnects a peer that reads nothing. Returns the remark for the user.
    pub(crate) fn stalled(&mut self, number: u64) -> Option<String> {
        let peer = self.peers.get_mut(&number)?;
        peer.disconnect();
        Some(format!(
            "{} has read nothing for {} s and was disconnected",
            peer.title(),
            WRITE_TIMEOUT.as_secs()
        ))
    }

    /// Disconnects a peer after a last message.
    fn dismiss(&mut self, number: u64, reason: &str) {
        if let Some(peer) = self.peers.get_mut(&number)
            && !peer.is_dismissed()
        {
            peer.dismiss(refusal(reason));
            self.leaving.push((Instant::now() + CLOSE_TIMEOUT, number));
        }
    }

    fn peer_mut(&mut self, origin: &Origin) -> Option<(u64, &mut Peer)> {
        match origin {
            Origin::Line { connection, .. } => {
                let peer = self.peers.get_mut(connection)?;
                Some((*connection, peer))
            }
            Origin::Topic(_) => {
                let (number, peer) = self.peers.iter_mut().next()?;
                Some((*number, peer))
            }
        }
    }

    /// Whether messages from `origin` count, because it is not being disconnected.
    pub(crate) fn counts(&self, origin: &Origin) -> bool {
        match origin {
            Origin::Line { connection, .. } => self.is_active(*connection),
            Origin::Topic(_) => true,
        }
    }

    /// The number of the connection of `origin`; none if there are no connections.
    pub(crate) fn connection(origin: &Origin) -> Option<u64> {
        match origin {
            Origin::Line { connection, .. } => Some(*connection),
            Origin::Topic(_) => None,
        }
    }

    /// The name in the hello of the peer of `origin`.
    pub(crate) fn name(&self, origin: &Origin) -> Option<&str> {
        let Origin::Line { connection, .. } = origin else {
            return None;
        };
        self.peers.get(connection)?.identity.name()
    }

    /// Whether messages from a peer count, because it is connected and not being disconnected.
    pub(crate) fn is_active(&self, number: u64) -> bool {
        self.peers
            .get(&number)
            .is_some_and(|peer| !peer.is_dismissed())
    }

    /// Removes a peer that has gone. Connects again if this side connects.
    pub fn leave(&mut self, number: u64) {
        if self.peers.remove(&number).is_none() {
            return;
        }
        if let (Some(tcp), Some(address)) = (&self.tcp, &self.connects_to) {
            tcp.connect(address.clone(), RETRY_INTERVAL);
        }
    }
}

/// Index in `robots` of the robot that a message is for.
fn robot_of(message: &Message, robots: &[String]) -> Option<usize> {
    let Message::FromNode(message) = message else {
        return None;
    };
    let name = message.robot()?;
    robots.iter().position(|robot| robot == name)
}

fn refusal(reason: &str) -> Message {
    Message::from(HelloAnswer {
        accepted: false,
        reason: Some(reason.to_owned()),
        robots: Vec::new(),
    })
}
