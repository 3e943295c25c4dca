//! Which peers are admitted, and what each of them may send.

use super::{Hub, refusal};
use crate::RemarkSetting;
use crate::protocol::{Incoming, Rejected, Rejection};
use crate::transport::connection::Connection;
use crate::transport::tcp::WRITE_TIMEOUT;
use crate::transport::{Origin, Side};
use pickline::error::counted;
use std::time::Duration;

/// At the limit, a peer that has sent nothing for this time makes room for a new one.
const SILENCE_TIMEOUT: Duration = Duration::from_secs(1);
/// Number of invalid or disallowed lines in a row after which a peer is disconnected.
const MOST_REFUSED: u32 = 100;

impl Hub {
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

    /// Checks that the peer of `origin` may send `message`, which is from `robot` if from any.
    /// Returns whether it speaks for that robot for the first time.
    ///
    /// # Errors
    /// The peer may not send the message.
    pub(crate) fn admit(
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
    pub(crate) fn refuse(&mut self, origin: &Origin, rejected: &Rejected) -> Option<String> {
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
}
