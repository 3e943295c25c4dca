//! The hub of all peers: which are connected, which message goes to which, and which are
//! disconnected.

mod hello;
mod sending;

use crate::RemarkSetting;
use crate::protocol::{Hello, HelloAnswer, Incoming, Message, Rejected, Rejection};
use crate::transport::connection::Connection;
#[cfg(feature = "mqtt")]
use crate::transport::mqtt;
use crate::transport::peer::Peer;
#[cfg(feature = "ros2")]
use crate::transport::ros2;
use crate::transport::tcp::{CLOSE_TIMEOUT, Tcp, WRITE_TIMEOUT};
use crate::transport::{
    Access, Dialect, Endpoint, INBOX_CAPACITY, Origin, RETRY_INTERVAL, Side, TransportEvent,
    listen_at, stream,
};
use pickline::error::{Error, Result, counted, shown};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::SocketAddr;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// A peer that has sent nothing for this time after connecting is treated as one without a hello.
const HELLO_TIMEOUT: Duration = Duration::from_millis(200);
/// If a token is required, a peer that has not presented it after this time is disconnected.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(5);
/// At the limit, a peer that has sent nothing for this time makes room for a new one.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);
/// Number of invalid or disallowed lines in a row after which a peer is disconnected.
const MOST_REFUSED: u32 = 100;

/// Settings of the hub.
#[derive(Debug, Clone)]
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

/// The outcome of a hello.
#[derive(Debug, PartialEq, Eq)]
pub enum HelloOutcome {
    /// The peer may stay; it speaks for these robots from now on.
    Accepted(Vec<usize>),
    /// The peer may not stay, for this reason.
    Refused(String),
}

/// All peers.
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
    pub fn connects(&self) -> bool {
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
    pub fn run_timers(&mut self) {
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

    /// Adds a peer that has connected. Returns its number; none if it was turned away. At the
    /// limit, a peer that has sent nothing since it connected is disconnected for it.
    pub fn join(&mut self, connection: Connection) -> Option<u64> {
        let tcp = self.tcp.as_ref()?;
        let sockets = self.peers.iter().filter(|(_, peer)| peer.is_on_socket());
        let there = sockets.filter(|(_, peer)| peer.is_up());
        let (mut count, mut silent) = (0, None);
        for (number, peer) in there {
            count += 1;
            let is_silent = !peer.has_spoken && peer.since.elapsed() >= SILENCE_TIMEOUT;
            if is_silent && silent.is_none() {
                silent = Some(*number);
            }
        }
        let is_full = count >= self.terms.most_peers;
        if is_full && silent.is_none() {
            let there = counted(count, "peer");
            let address = connection.address.map(|at| at.to_string());
            self.remarks.push_back(format!(
                "{} was turned away: {there} are connected, and {} allows no more",
                address.unwrap_or_default(),
                RemarkSetting::MaxPeers
            ));
            let reason = format!("{there} are connected, and no more are allowed");
            tcp.reject(connection, &refusal(&reason));
            return None;
        }
        let deadline = (!self.terms.waits).then_some(WRITE_TIMEOUT);
        let peer = tcp.serve(self.next, connection, deadline);
        let number = self.keep(peer);
        if let Some(silent) = silent.filter(|_| is_full) {
            self.dismiss(
                silent,
                "another peer wants to connect, and this one has sent nothing yet",
            );
        }
        if self.connects() {
            // It is the peer at the given address, so no hello is needed.
            self.release(number);
        }
        if self.terms.side == Side::Station {
            self.release(number);
            if let Some(hello) = self.terms.hello.clone() {
                self.send_to(number, hello);
            }
        }
        Some(number)
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

    /// Checks that the peer of `origin` may send `message`, which is from `robot` if from any.
    /// Returns whether it speaks for that robot for the first time.
    ///
    /// # Errors
    /// The peer may not send the message.
    pub fn admit(
        &mut self,
        origin: &Origin,
        message: &Incoming,
        robot: Option<usize>,
    ) -> std::result::Result<bool, Rejected> {
        let needs_token = self.needs_token();
        let Some((number, peer)) = self.peer_mut(origin) else {
            return Ok(false);
        };
        if needs_token && peer.is_on_socket() && !peer.identity.has_greeted() {
            let reason = "its first line is not a hello with a token";
            self.dismiss(number, reason);
            let expected = format!("{reason}; expected `hello` first");
            return Err(Rejected::new(Rejection::NotAllowed, expected));
        }
        let is_owned = robot.is_some_and(|robot| self.owned.contains(&robot));
        let Some(peer) = self.peers.get_mut(&number) else {
            return Ok(false);
        };
        peer.identity.check(message, robot, is_owned)?;
        (peer.has_spoken, peer.refused) = (true, 0);
        // An order to a robot does not make its sender speak for the robot.
        let speaks = robot.filter(|_| message.order().is_none());
        let is_first = speaks.is_some_and(|robot| peer.identity.note(robot));
        if peer.unknown_for().is_some() {
            self.release(number);
        }
        Ok(is_first)
    }

    /// Handles a refused line of `origin`, which is invalid or not allowed. The peer is
    /// disconnected if this is its first line, if it is a hello, or if there were too many. Returns
    /// why, if so.
    pub fn refuse(&mut self, origin: &Origin, rejected: &Rejected) -> Option<String> {
        if let Some(number) = Self::connection(origin).filter(|_| rejected.is_hello) {
            let peer = self.peers.get(&number)?;
            let (title, ends) = (peer.title(), peer.is_on_socket());
            self.refuse_hello(number, &rejected.message);
            return ends.then(|| format!("{title} was disconnected: its hello was refused"));
        }
        let (number, peer) = self.peer_mut(origin)?;
        if !peer.is_on_socket() {
            return None;
        }
        peer.refused += 1;
        let reason = if !peer.has_spoken && rejected.reason.is_foreign() {
            "its first line is not a message of the live protocol".to_owned()
        } else if peer.refused >= MOST_REFUSED {
            format!("{MOST_REFUSED} lines in a row were refused")
        } else {
            return None;
        };
        let text = format!("{} was disconnected: {reason}", peer.title());
        self.dismiss(number, &reason);
        Some(text)
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
    pub fn stalled(&mut self, number: u64) -> Option<String> {
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
    pub fn counts(&self, origin: &Origin) -> bool {
        match origin {
            Origin::Line { connection, .. } => self.is_active(*connection),
            Origin::Topic(_) => true,
        }
    }

    /// The number of the connection of `origin`; none if there are no connections.
    pub fn connection(origin: &Origin) -> Option<u64> {
        match origin {
            Origin::Line { connection, .. } => Some(*connection),
            Origin::Topic(_) => None,
        }
    }

    /// The name in the hello of the peer of `origin`.
    pub fn name(&self, origin: &Origin) -> Option<&str> {
        let Origin::Line { connection, .. } = origin else {
            return None;
        };
        self.peers.get(connection)?.identity.name()
    }

    /// Whether messages from a peer count, because it is connected and not being disconnected.
    pub fn is_active(&self, number: u64) -> bool {
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
