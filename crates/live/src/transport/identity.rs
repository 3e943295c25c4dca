//! The identity of a peer: what it is sent, and what it may send.

use crate::protocol::{Hello, Incoming, Message, Outgoing, Rejected, Rejection, Role};
use std::collections::BTreeSet;

/// What a peer has stated about itself. Robots are numbered upstream first.
#[derive(Debug, Default)]
pub(super) struct Identity {
    /// Its role and name, once it has sent a hello.
    hello: Option<(Role, String)>,
    /// The robots named in its hello.
    robots: BTreeSet<usize>,
    /// The robots from which it has sent messages.
    heard: BTreeSet<usize>,
    /// Whether all peers share this connection: stdin and stdout, a broker, a ROS graph.
    is_shared: bool,
}

impl Identity {
    /// A connection that all peers share, unless it sends a hello.
    pub(super) fn shared() -> Self {
        Self {
            is_shared: true,
            ..Self::default()
        }
    }

    /// Notes its hello for these robots.
    pub(super) fn greet(&mut self, hello: Hello, robots: BTreeSet<usize>) {
        self.hello = Some((hello.role, hello.name));
        self.robots = robots;
        self.heard.clear();
        self.is_shared = false;
    }

    /// Whether it has sent a hello.
    pub(super) fn has_greeted(&self) -> bool {
        self.hello.is_some()
    }

    /// Its role, if it has sent a hello.
    pub(super) fn role(&self) -> Option<Role> {
        self.hello.as_ref().map(|(role, _)| *role)
    }

    /// Whether it only reports about the line and needs no answers.
    pub(super) fn is_source(&self) -> bool {
        matches!(self.role(), Some(Role::Camera | Role::Encoder))
    }

    /// Its name, if it has sent a hello.
    pub(super) fn name(&self) -> Option<&str> {
        self.hello.as_ref().map(|(_, name)| name.as_str())
    }

    /// The robots that it speaks for.
    pub(super) fn robots(&self) -> impl Iterator<Item = usize> + '_ {
        self.robots.union(&self.heard).copied()
    }

    /// Whether it speaks for a robot: its hello names it, or it has sent messages from it.
    pub(super) fn speaks_for(&self, robot: usize) -> bool {
        self.is_shared || self.robots.contains(&robot) || self.heard.contains(&robot)
    }

    /// Notes a message from a robot. Returns whether it is the first one.
    pub(super) fn note(&mut self, robot: usize) -> bool {
        !self.is_shared && !self.robots.contains(&robot) && self.heard.insert(robot)
    }

    /// Whether tasks of a robot that are sent to this peer may reach the robot. `is_owned` is
    /// whether any hello names the robot.
    pub(super) fn carries(&self, robot: usize, is_owned: bool) -> bool {
        match self.role() {
            None => self.is_shared || !is_owned,
            Some(Role::Robot) => self.robots.contains(&robot),
            Some(Role::Camera | Role::Encoder | Role::Operator | Role::Observer) => false,
        }
    }

    /// Whether it is sent a message for `robot`, or for all.
    pub(super) fn gets(&self, message: &Message, robot: Option<usize>) -> bool {
        let Message::FromNode(message) = message else {
            return true;
        };
        match (self.role(), message.robot()) {
            // These peers have no drive that could follow a request.
            (Some(Role::Camera | Role::Robot | Role::Operator), None) => {
                matches!(message, Outgoing::Status(_) | Outgoing::Due(_))
            }
            (None | Some(Role::Observer), _) | (_, None) => true,
            (Some(Role::Robot), Some(_)) => robot.is_some_and(|r| self.robots.contains(&r)),
            (Some(Role::Camera | Role::Encoder | Role::Operator), Some(_)) => false,
        }
    }

    /// Checks that it may send `message`, which is from `robot` if from any.
    ///
    /// # Errors
    /// Its role may not send the message, or it may not speak for the robot.
    pub(super) fn check(
        &self,
        message: &Incoming,
        robot: Option<usize>,
        is_owned: bool,
    ) -> Result<(), Rejected> {
        let is_of_a_source = matches!(
            message,
            Incoming::Detection(_) | Incoming::Belt(_) | Incoming::Tick { .. }
        );
        let is_order = message.order().is_some();
        let allowed = match self.role() {
            None => self.is_shared || !is_owned,
            Some(Role::Robot) => robot.map_or(!is_order, |robot| self.robots.contains(&robot)),
            Some(Role::Camera | Role::Encoder) => is_of_a_source,
            Some(Role::Operator) => is_order,
            Some(Role::Observer) => false,
        };
        if allowed {
            return Ok(());
        }
        let kind = message.kind();
        let problem = match self.role() {
            None => format!(
                "`{kind}` for a robot that the hello of another peer names; expected a hello with \
                 the role `robot` that names it first"
            ),
            Some(Role::Robot) if robot.is_none() => format!(
                "`{kind}` for the whole line; a peer with the role `robot` may order it only for \
                 its robots, an `operator` for all"
            ),
            Some(Role::Robot) => {
                format!("`{kind}` for a robot that the hello of this peer does not name")
            }
            Some(role) => format!(
                "a peer with the role `{}` may not send `{kind}`",
                role.name()
            ),
        };
        Err(Rejected::new(Rejection::NotAllowed, problem))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::{Cancel, Status, decode};

    fn peer(role: Role, robots: &[usize]) -> Identity {
        let mut identity = Identity::default();
        let hello = Hello {
            stamp: None,
            name: "p".into(),
            role,
            robots: Vec::new(),
            token: None,
        };
        identity.greet(hello, robots.iter().copied().collect());
        identity
    }

    fn said(line: &str) -> Incoming {
        decode(line.as_bytes()).unwrap()
    }

    #[test]
    fn each_role_is_sent_and_may_say_what_it_needs() {
        let cancel = Message::from(Outgoing::Cancel(Cancel {
            stamp: 0.0,
            task: 1,
            robot: "r1".into(),
            reason: String::new(),
        }));
        let status = Message::from(Outgoing::Status(Box::<Status>::default()));
        let item = said(r#"{"kind":"detection","stamp":1,"x":0,"y":0}"#);
        let ack = said(r#"{"kind":"ack","stamp":1,"task":1}"#);
        let stop = said(r#"{"kind":"stop","stamp":1}"#);
        // Role; gets a cancel of robot 0; may send a detection, an ack of robot 0, an ack of an
        // unknown task, a stop of robot 0, a stop of the line.
        for (role, robots, gets, says) in [
            (
                Role::Camera,
                &[][..],
                false,
                [true, false, false, false, false],
            ),
            (
                Role::Encoder,
                &[],
                false,
                [true, false, false, false, false],
            ),
            (
                Role::Operator,
                &[],
                false,
                [false, false, false, true, true],
            ),
            (Role::Observer, &[], true, [false; 5]),
            (Role::Robot, &[0], true, [true, true, true, true, false]),
            (Role::Robot, &[1], false, [true, false, true, false, false]),
        ] {
            let peer = peer(role, robots);
            assert_eq!(peer.gets(&cancel, Some(0)), gets, "{role:?}");
            assert!(peer.gets(&status, None), "{role:?}");
            let found = [
                peer.check(&item, None, true),
                peer.check(&ack, Some(0), true),
                peer.check(&ack, None, true),
                peer.check(&stop, Some(0), true),
                peer.check(&stop, None, false),
            ];
            assert_eq!(found.map(|found| found.is_ok()), says, "{role:?}");
            assert_eq!(peer.carries(0, true), robots == [0]);
        }
    }

    #[test]
    fn a_peer_without_hello_keeps_its_robots_until_another_says_hello_for_them() {
        let ack = said(r#"{"kind":"ack","stamp":1,"task":1}"#);
        let mut peer = Identity::default();
        assert!(!peer.speaks_for(0) && peer.carries(0, false));
        assert!(peer.note(0) && !peer.note(0) && peer.speaks_for(0));
        assert!(peer.check(&ack, Some(0), false).is_ok());
        assert!(!peer.carries(0, true));
        let refused = peer.check(&ack, Some(0), true).unwrap_err();
        assert_eq!(refused.reason, Rejection::NotAllowed);
        let mut shared = Identity::shared();
        assert!(shared.speaks_for(7) && shared.carries(7, true) && !shared.note(7));
    }
}
