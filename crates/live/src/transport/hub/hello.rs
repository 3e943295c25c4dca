//! Hellos: who a peer is, which robots it speaks for, and whether it may stay.

use super::{Hub, refusal, robot_of};
use crate::protocol::{Hello, HelloAnswer, Message, Role};
use crate::transport::peer::Peer;
use pickline::error::{known_names, shown};
use std::collections::BTreeSet;

/// The outcome of a hello.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum HelloOutcome {
    /// The peer may stay; it speaks for these robots from now on.
    Accepted(Vec<usize>),
    /// The peer may not stay, for this reason.
    Refused(String),
}

impl Hub {
    /// Handles the hello of a peer.
    pub(crate) fn handle_hello(&mut self, number: u64, hello: Hello) -> HelloOutcome {
        let refused = match self.check_hello(number, &hello) {
            Ok(robots) => {
                let spoken = self.accept(number, hello, robots);
                return HelloOutcome::Accepted(spoken);
            }
            Err(reason) => reason,
        };
        self.refuse_hello(number, &refused);
        HelloOutcome::Refused(refused)
    }

    /// Answers a refused hello, and ends the connection if that is possible.
    pub(super) fn refuse_hello(&mut self, number: u64, reason: &str) {
        if let Some(peer) = self.peers.get_mut(&number) {
            if peer.is_on_socket() {
                self.dismiss(number, reason);
            } else {
                peer.try_send(refusal(reason), true);
            }
        }
    }

    fn check_hello(
        &self,
        number: u64,
        hello: &Hello,
    ) -> std::result::Result<BTreeSet<usize>, String> {
        let on_socket = self.peers.get(&number).is_some_and(Peer::is_on_socket);
        let asked = on_socket && self.needs_token();
        if let Some(token) = self.terms.access.token.as_ref().filter(|_| asked) {
            match &hello.token {
                None => return Err("its hello has no token".into()),
                Some(given) if !token.is(given) => return Err("its token is wrong".into()),
                Some(_) => {}
            }
        }
        let names = &self.terms.robots;
        let robots = hello.robots.iter().map(|robot| {
            let place = names.iter().position(|name| name == robot);
            place.ok_or_else(|| {
                let known: Vec<&str> = names.iter().map(String::as_str).collect();
                let cure = known_names(&shown(robot), &known);
                format!("there is no robot `{}`; {cure}", shown(robot))
            })
        });
        let robots = robots.collect::<std::result::Result<BTreeSet<usize>, String>>()?;
        self.check_owners(number, hello, &robots)?;
        Ok(robots)
    }

    /// Checks that each robot has one peer at a time. Two peers would get the same tasks and both
    /// carry them out.
    fn check_owners(
        &self,
        number: u64,
        hello: &Hello,
        robots: &BTreeSet<usize>,
    ) -> std::result::Result<(), String> {
        if hello.role != Role::Robot {
            return Ok(());
        }
        let others = self.peers.iter().filter(|(other, peer)| {
            let is_other = **other != number && peer.identity.name() != Some(&hello.name);
            is_other && peer.is_up() && peer.identity.role() == Some(Role::Robot)
        });
        for (_, peer) in others {
            if let Some(robot) = robots.iter().find(|r| peer.identity.speaks_for(**r)) {
                let robot = shown(&self.terms.robots[*robot]);
                let title = peer.title();
                return Err(format!("{title} already speaks for `{robot}`"));
            }
        }
        Ok(())
    }

    fn accept(&mut self, number: u64, hello: Hello, robots: BTreeSet<usize>) -> Vec<usize> {
        if hello.role == Role::Robot {
            self.owned.extend(&robots);
            // The robot has reconnected before its old connection was noticed as dead.
            let same = self.peers.iter().filter(|(other, peer)| {
                let is_same = peer.identity.role() == Some(Role::Robot)
                    && peer.identity.name() == Some(&hello.name);
                **other != number && is_same && peer.is_on_socket()
            });
            let same = same.filter(|(_, peer)| robots.iter().any(|r| peer.identity.speaks_for(*r)));
            let same: Vec<u64> = same.map(|(other, _)| *other).collect();
            for other in same {
                self.dismiss(other, "it has sent a hello over another connection");
            }
        }
        let Some(peer) = self.peers.get_mut(&number) else {
            return Vec::new();
        };
        let before: Vec<usize> = peer.identity.robots().collect();
        let new = robots.iter().copied().filter(|r| !before.contains(r));
        let new: Vec<usize> = new.collect();
        peer.identity.greet(hello, robots);
        (peer.has_spoken, peer.refused) = (true, 0);
        let kept = peer.identify();
        let answer = HelloAnswer {
            accepted: true,
            reason: None,
            robots: self.terms.robots.clone(),
        };
        // The answer goes before anything else.
        let answer = Message::from(answer);
        for message in std::iter::once(answer).chain(kept) {
            let robot = robot_of(&message, &self.terms.robots);
            if peer.identity.gets(&message, robot) {
                if self.terms.waits {
                    peer.send(message);
                } else {
                    peer.try_send(message, true);
                }
            }
        }
        new
    }
}
