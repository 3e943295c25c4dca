//! JSON Lines over stdin and stdout, and over TCP.
//!
//! What all peers say comes in one after another, as lines of the protocol, so that one
//! decoder judges them all; what is said goes to all of them. Every queue is bounded. A
//! TCP peer whose queue is full is disconnected: the tasks that it has not acknowledged
//! are sent again to whoever connects. Others cannot be disconnected: while a queue is
//! more than half full no task is given, and what must not be lost is kept.

mod lines;
#[cfg(feature = "mqtt")]
pub mod mqtt;
mod origin;
mod peer;
#[cfg(feature = "ros2")]
pub mod ros2;
mod stream;

use crate::error::{Error, Result, shown};
use crate::live::protocol::{Message, Rejected};
use peer::{Peer, QUEUE};
use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

pub use origin::Origin;

/// Lines read and not yet heeded, of all peers together; readers wait beyond.
const INBOX: usize = 1024;
/// Time between two tries to connect.
const RETRY: Duration = Duration::from_millis(200);

/// What is heard of the peers.
#[derive(Debug)]
pub enum Heard {
    /// A line.
    Line(Origin, Vec<u8>),
    /// Something that was refused before it became a line.
    Refused(Origin, Rejected),
    /// A peer has connected.
    Joined(TcpStream),
    /// A peer says no more.
    Left(u64),
    /// A peer that is kept is there, perhaps again, and has perhaps not heard what was said.
    Up(u64),
    /// A peer that is kept is not there for the moment.
    Down(u64),
    /// Who was at a peer that is kept says no more; others may come.
    Ended(u64),
    /// Something that the user should know.
    Remark(String),
    /// It cannot go on.
    Failed(Error),
}

/// Which of the two programs this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The node: it hears the station and sends tasks.
    Node,
    /// A station: the other way round.
    Station,
}

/// Where the peers are.
#[derive(Debug, Clone)]
pub enum Place {
    /// One peer, on stdin and stdout.
    Stdio,
    /// Whoever connects to this address.
    Listen(String),
    /// The one that listens at this address.
    Connect(String),
    /// Whoever talks to this broker.
    #[cfg(feature = "mqtt")]
    Mqtt(Box<mqtt::Settings>),
    /// Whoever is in this ROS 2 graph.
    #[cfg(feature = "ros2")]
    Ros2(Box<ros2::Settings>),
}

/// Listens at `address`, which was given by `flag`.
///
/// # Errors
/// An address that is none, is not of this machine or is taken.
pub fn listen_at(flag: &str, address: &str) -> Result<TcpListener> {
    TcpListener::bind(address).map_err(|error| {
        let cure = "give HOST:PORT of this machine with a free port, or port 0 for any";
        Error::input(flag, format!("{}: {error}", shown(address)), cure)
    })
}

/// Connects to `address`, trying until it works or nobody wants to hear of it any more.
/// That it has to be waited for is told once, and that it is there then.
fn connect(address: &str, sender: &SyncSender<Heard>) {
    let at = shown(address);
    let mut waits = false;
    loop {
        match TcpStream::connect(address) {
            Ok(stream) => {
                if waits {
                    let _ = sender.send(Heard::Remark(format!("connected to {at}")));
                }
                let _ = sender.send(Heard::Joined(stream));
                return;
            }
            Err(error) if !waits => {
                waits = true;
                let text = format!("nobody to talk to at {at}: {error}; trying again");
                if sender.send(Heard::Remark(text)).is_err() {
                    return;
                }
            }
            Err(_) => {}
        }
        thread::sleep(RETRY);
    }
}

/// All peers.
#[derive(Debug)]
pub struct Hub {
    inbox: Receiver<Heard>,
    sender: SyncSender<Heard>,
    peers: BTreeMap<u64, Peer>,
    next: u64,
    address: Option<SocketAddr>,
    connects_to: Option<String>,
    stdio: bool,
}

impl Hub {
    /// Opens the place. Connecting goes on until somebody listens there.
    ///
    /// # Errors
    /// An address that is none, or cannot be listened at.
    pub fn open(place: &Place) -> Result<Self> {
        let (sender, inbox) = sync_channel(INBOX);
        let mut hub = Self {
            inbox,
            sender,
            peers: BTreeMap::new(),
            next: 1,
            address: None,
            connects_to: None,
            stdio: matches!(place, Place::Stdio),
        };
        match place {
            Place::Stdio => {
                let sender = hub.sender.clone();
                let peer = stream::start(0, std::io::stdin(), std::io::stdout(), None, sender);
                hub.peers.insert(0, peer);
            }
            Place::Listen(address) => {
                let listener = listen_at("--listen", address)?;
                hub.address = listener.local_addr().ok();
                let sender = hub.sender.clone();
                thread::spawn(move || {
                    for stream in listener.incoming().flatten() {
                        if sender.send(Heard::Joined(stream)).is_err() {
                            return;
                        }
                    }
                });
            }
            Place::Connect(address) => {
                if std::net::ToSocketAddrs::to_socket_addrs(address.as_str()).is_err() {
                    let problem = format!("`{}` is no address", shown(address));
                    let cure = "give HOST:PORT, for example 127.0.0.1:7400";
                    return Err(Error::input("--connect", problem, cure));
                }
                hub.connects_to = Some(address.clone());
                hub.connect();
            }
            #[cfg(feature = "mqtt")]
            Place::Mqtt(settings) => {
                let peer = mqtt::start(hub.next, settings, hub.sender.clone())?;
                hub.keep(peer);
            }
            #[cfg(feature = "ros2")]
            Place::Ros2(settings) => {
                let peer = ros2::start(hub.next, settings, hub.sender.clone())?;
                hub.keep(peer);
            }
        }
        Ok(hub)
    }

    #[cfg(any(feature = "mqtt", feature = "ros2"))]
    fn keep(&mut self, peer: Peer) {
        self.peers.insert(self.next, peer);
        self.next += 1;
    }

    /// Connects in the background, until it works.
    fn connect(&self) {
        if let Some(address) = self.connects_to.clone() {
            let sender = self.sender.clone();
            thread::spawn(move || connect(&address, &sender));
        }
    }

    /// Where it listens.
    pub fn address(&self) -> Option<SocketAddr> {
        self.address
    }

    /// Whether the one peer is on stdin and stdout.
    pub fn is_stdio(&self) -> bool {
        self.stdio
    }

    /// How many peers there are now.
    pub fn peers(&self) -> usize {
        self.peers.values().filter(|peer| peer.is_up()).count()
    }

    /// The next thing heard within `patience`.
    pub fn hear(&mut self, patience: Duration) -> Option<Heard> {
        for peer in self.peers.values_mut() {
            peer.flush();
        }
        // The hub keeps a sender, so it is never disconnected.
        self.inbox.recv_timeout(patience).ok()
    }

    /// Takes in a peer that has connected.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn join(&mut self, stream: TcpStream) -> std::io::Result<()> {
        // Tasks are short and must not wait for more of them.
        stream.set_nodelay(true)?;
        let (reads, socket) = (stream.try_clone()?, stream.try_clone()?);
        let number = self.next;
        self.next += 1;
        let sender = self.sender.clone();
        let peer = stream::start(number, reads, stream, Some(socket), sender);
        self.peers.insert(number, peer);
        Ok(())
    }

    /// Lets a peer go, and connects again where that is what it does.
    pub fn leave(&mut self, number: u64) {
        if self.peers.remove(&number).is_some() {
            self.connect();
        }
    }

    /// Sends a message to all, waiting for room.
    pub fn send(&mut self, message: impl Into<Message>) {
        let message = message.into();
        for peer in self.peers.values_mut() {
            peer.send(message.clone());
        }
    }

    /// Sends a message to all without waiting; returns those that did not keep up and were
    /// disconnected. What does not `matter` is left out where there is no room.
    pub fn try_send(&mut self, message: impl Into<Message>, matters: bool) -> Vec<u64> {
        let message = message.into();
        let peers = self.peers.iter_mut();
        let slow = peers.filter_map(|(number, peer)| {
            (!peer.try_send(message.clone(), matters)).then_some(*number)
        });
        slow.collect()
    }

    /// How many messages wait, at the peer where most do.
    pub fn queued(&self) -> usize {
        self.peers.values().map(Peer::queued).max().unwrap_or(0)
    }

    /// Whether there is no room for one more message somewhere.
    pub fn is_full(&self) -> bool {
        self.queued() >= QUEUE
    }

    /// Whether tasks should wait: there is nobody, or somebody does not keep up.
    pub fn is_stalled(&self) -> bool {
        self.peers() == 0 || self.is_half_full()
    }

    /// Whether so much waits somewhere that no more should be added than has to be.
    pub fn is_half_full(&self) -> bool {
        self.queued() > QUEUE / 2
    }

    /// Ends all streams to the peers after what is still to be written; they may go on
    /// talking.
    pub fn finish_writing(&mut self) {
        self.peers.values_mut().for_each(Peer::finish_writing);
    }

    /// Writes what is left and closes all, waiting at most `patience`.
    ///
    /// # Errors
    /// What could not be written, where that is known by then.
    pub fn close(mut self, patience: Duration) -> Result<()> {
        let until = Instant::now() + patience;
        for (_, peer) in std::mem::take(&mut self.peers) {
            peer.close(until.saturating_duration_since(Instant::now()));
        }
        let mut left = self.inbox.try_iter();
        match left.find_map(|heard| match heard {
            Heard::Failed(error) => Some(error),
            _ => None,
        }) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
