//! Other nodes that send tasks under the same namespace. Two robots would be sent to one item, so
//! only the first node stays.

use ros2_client::Context;
use rustdds::{DomainParticipant, GUID, RTPSEntity};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// A node that was alone for this time counts as the first.
const ALONE_TIME: Duration = Duration::from_secs(5);
/// If two nodes start at the same time, the one that may stay gives the other this time to leave.
const YIELD_TIMEOUT: Duration = Duration::from_secs(5);

/// Interval of checks by a node that stays, because graphs may be large.
const POLL_INTERVAL: Duration = Duration::from_secs(1);

/// What to do about other nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Precedence {
    /// Nothing.
    Stay,
    /// Give no tasks until it is known which node stays.
    Wait,
    /// Stay, and tell the user that another node has come.
    Warn,
    /// Leave, because another node was first.
    GiveWay,
}

/// Looks for other nodes.
pub(crate) struct NodeWatcher {
    participant: DomainParticipant,
    topic: String,
    began: Instant,
    looked: Duration,
    other_nodes: OtherNodes<GUID>,
}

impl NodeWatcher {
    /// Watches the tasks under `namespace`, which begins with `/`.
    pub(crate) fn new(context: &Context, namespace: &str) -> Self {
        let participant = context.domain_participant();
        let own = participant.guid();
        Self {
            participant,
            // The DDS name of the ROS topic.
            topic: format!("rt{namespace}/tasks"),
            began: Instant::now(),
            looked: Duration::ZERO,
            other_nodes: OtherNodes::new(own),
        }
    }

    /// Checks for other nodes now; `up` is whether the robots are already connected to this node.
    pub(crate) fn look(&mut self, up: bool) -> Precedence {
        let now = self.began.elapsed();
        if self.other_nodes.stays && now < self.looked + POLL_INTERVAL {
            return Precedence::Stay;
        }
        self.looked = now;
        let own = self.participant.guid().prefix;
        let writers = self.participant.discovered_writers().into_iter();
        let others =
            writers.filter(|writer| writer.publication_topic_data.topic_name == self.topic);
        let others = others.map(|writer| writer.writer_proxy.remote_writer_guid);
        let others = others.filter(|writer| writer.prefix != own).collect();
        self.other_nodes.judge(&others, up, now)
    }
}

/// The other nodes, by id. The beginning of an id identifies the program.
struct OtherNodes<Id> {
    own: Id,
    /// Whether this node came first.
    stays: bool,
    /// Since when there is another node.
    met: Option<Duration>,
    /// The nodes that were reported to the user.
    told: BTreeSet<Id>,
}

impl<Id: Ord + Copy> OtherNodes<Id> {
    fn new(own: Id) -> Self {
        Self {
            own,
            stays: false,
            met: None,
            told: BTreeSet::new(),
        }
    }

    /// Decides what to do about `others`; `now` is the time since the start.
    fn judge(&mut self, others: &BTreeSet<Id>, up: bool, now: Duration) -> Precedence {
        self.stays |= up || (others.is_empty() && now >= ALONE_TIME);
        if others.is_empty() {
            self.met = None;
            return Precedence::Stay;
        }
        if self.stays {
            let known = others.is_subset(&self.told);
            self.told.extend(others);
            return if known {
                Precedence::Stay
            } else {
                Precedence::Warn
            };
        }
        // Both nodes reach the same decision, so one of them stays. If the other one was there all
        // along, it does not leave, so this one must.
        let met = *self.met.get_or_insert(now);
        if others.iter().any(|other| *other < self.own) || now - met > YIELD_TIMEOUT {
            Precedence::GiveWay
        } else {
            Precedence::Wait
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    #[test]
    fn who_was_there_first_stays() {
        let (nobody, other) = (BTreeSet::new(), BTreeSet::from([1]));
        for up in [false, true] {
            let mut other_nodes = OtherNodes::new(2);
            assert_eq!(other_nodes.judge(&nobody, up, after(0.0)), Precedence::Stay);
            assert_eq!(other_nodes.judge(&nobody, up, after(5.0)), Precedence::Stay);
            assert_eq!(other_nodes.judge(&other, up, after(6.0)), Precedence::Warn);
            assert_eq!(other_nodes.judge(&other, up, after(99.0)), Precedence::Stay);
            let more = BTreeSet::from([1, 3]);
            assert_eq!(other_nodes.judge(&more, up, after(100.0)), Precedence::Warn);
        }
        let mut other_nodes = OtherNodes::new(2);
        assert_eq!(
            other_nodes.judge(&other, false, after(0.1)),
            Precedence::GiveWay
        );
    }

    #[test]
    fn one_of_two_that_come_together_stays() {
        let mut first = OtherNodes::new(1);
        let mut second = OtherNodes::new(2);
        let nobody = BTreeSet::new();
        assert_eq!(
            first.judge(&BTreeSet::from([2]), false, after(0.1)),
            Precedence::Wait
        );
        assert_eq!(
            second.judge(&BTreeSet::from([1]), false, after(0.1)),
            Precedence::GiveWay
        );
        assert_eq!(first.judge(&nobody, false, after(1.0)), Precedence::Stay);
    }

    #[test]
    fn one_that_stays_is_not_waited_for() {
        let other = BTreeSet::from([2]);
        let mut other_nodes = OtherNodes::new(1);
        assert_eq!(
            other_nodes.judge(&other, false, after(1.0)),
            Precedence::Wait
        );
        assert_eq!(
            other_nodes.judge(&other, false, after(6.0)),
            Precedence::Wait
        );
        assert_eq!(
            other_nodes.judge(&other, false, after(6.1)),
            Precedence::GiveWay
        );
    }
}
