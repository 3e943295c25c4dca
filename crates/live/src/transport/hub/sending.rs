//! What is sent to which peer, and what waits to be sent.

use super::{Hub, robot_of};
use crate::protocol::Message;
use crate::transport::TransportEvent;
use crate::transport::peer::{Peer, QUEUE_CAPACITY};
use pickline::error::Result;
use std::time::{Duration, Instant};

impl Hub {
    /// Sends a message to all peers that should get it, waiting for space in their queues.
    pub(crate) fn send(&mut self, message: impl Into<Message>) {
        let message = message.into();
        let robot = robot_of(&message, &self.terms.robots);
        for peer in self.peers.values_mut() {
            if peer.identity.gets(&message, robot) {
                peer.send(message.clone());
            }
        }
    }

    /// Sends a message to all peers that should get it, without waiting. Returns remarks about the
    /// peers that lagged behind and were disconnected. A message that does not matter is dropped
    /// for peers without space.
    pub fn try_send(&mut self, message: impl Into<Message>, matters: bool) -> Vec<String> {
        let message = message.into();
        let robot = robot_of(&message, &self.terms.robots);
        let mut slow = Vec::new();
        for peer in self.peers.values_mut() {
            if peer.identity.gets(&message, robot) && !peer.try_send(message.clone(), matters) {
                slow.push(peer.title());
                peer.disconnect();
            }
        }
        slow
    }

    /// Sends a message to one peer only.
    pub(crate) fn send_to(&mut self, number: u64, message: impl Into<Message>) {
        let message = message.into();
        let robot = robot_of(&message, &self.terms.robots);
        let Some(peer) = self.peers.get_mut(&number) else {
            return;
        };
        if !peer.identity.gets(&message, robot) {
            return;
        }
        if self.terms.waits {
            peer.send(message);
        } else if !peer.try_send(message, true) {
            peer.disconnect();
        }
    }

    /// Number of messages in the longest queue.
    pub fn queued(&self) -> usize {
        self.peers.values().map(Peer::queued).max().unwrap_or(0)
    }

    /// Whether any queue is full.
    pub fn is_full(&self) -> bool {
        self.queued() >= QUEUE_CAPACITY
    }

    /// Whether any queue is more than half full, so that only necessary messages should be added.
    pub(crate) fn is_half_full(&self) -> bool {
        self.peers.values().any(Peer::is_half_full)
    }

    /// The robots that should get no task now, because no peer can deliver it or the peer that
    /// speaks for them lags behind. Other peers cannot hold them up.
    pub(crate) fn held(&self) -> Vec<usize> {
        let robots = 0..self.terms.robots.len();
        robots.filter(|robot| self.is_held(*robot)).collect()
    }

    fn is_held(&self, robot: usize) -> bool {
        let is_owned = self.owned.contains(&robot);
        let needs_token = self.needs_token();
        let mut is_carried = false;
        for peer in self.peers.values().filter(|peer| peer.is_up()) {
            let is_stranger = needs_token && peer.is_on_socket() && !peer.identity.has_greeted();
            if is_stranger || !peer.identity.carries(robot, is_owned) {
                continue;
            }
            let keeps_up = !peer.is_half_full();
            if !keeps_up && peer.identity.speaks_for(robot) {
                return true;
            }
            is_carried |= keeps_up;
        }
        !is_carried
    }

    /// Ends all streams to the peers once everything is written. The peers may keep sending.
    pub fn finish_writing(&mut self) {
        self.peers.values_mut().for_each(Peer::finish_writing);
    }

    /// Writes the remaining messages and closes all connections, within `timeout`.
    ///
    /// # Errors
    /// A write has failed, if that is known by then.
    pub fn close(mut self, timeout: Duration) -> Result<()> {
        let needs_token = self.needs_token();
        let unknown = self.peers.iter();
        let unknown = unknown.filter(|(_, peer)| !needs_token && peer.unknown_for().is_some());
        let unknown: Vec<u64> = unknown.map(|(number, _)| *number).collect();
        for number in unknown {
            self.release(number);
        }
        let until = Instant::now() + timeout;
        for (_, peer) in std::mem::take(&mut self.peers) {
            peer.close(until.saturating_duration_since(Instant::now()));
        }
        let mut left = self.inbox.try_iter();
        match left.find_map(|heard| match heard {
            TransportEvent::Failed(error) => Some(error),
            _ => None,
        }) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}
