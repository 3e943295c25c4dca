//! Restores the sending order of messages over all topics, one turn at a time.
//!
//! DDS keeps the order within a topic but not between topics. With message time node and
//! station take turns. A turn ends with a message that gives its number of messages. Messages are
//! held until the turn is complete and then passed on in the order of their publication times in
//! DDS.

use crate::transport::TransportEvent;

/// Maximum number of held messages; a station that takes turns sends fewer in one turn.
const MOST_HELD: usize = 100_000;
/// Length of the prefix of a writer's identity that all writers of a participant share [bytes].
const PARTICIPANT: usize = 12;

/// The sender and publication time of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sent {
    /// The participant that published it.
    pub sender: [u8; PARTICIPANT],
    /// When it was published [ns].
    pub at: i64,
}

impl Sent {
    /// The DDS metadata of a message: its writer's identity, and its publication time [ns].
    pub(crate) fn new(writer: &[u8], at: i64) -> Self {
        let mut sender = [0; PARTICIPANT];
        for (byte, known) in sender.iter_mut().zip(writer) {
            *byte = *known;
        }
        Self { sender, at }
    }
}

/// The held messages.
#[derive(Debug, Default)]
pub(crate) struct Turns {
    held: Vec<(Sent, Vec<TransportEvent>)>,
    /// Ends of turns, each with the number of messages before it in the turn.
    ends: Vec<(Sent, usize)>,
}

/// The error for a turn with too many messages.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Endless;

impl Turns {
    /// Adds the events of a message. If it ends a turn, `end` is the number of messages before it.
    /// Returns the events to pass on now.
    ///
    /// # Errors
    /// The turn does not end.
    pub(crate) fn take(
        &mut self,
        sent: Sent,
        heard: Vec<TransportEvent>,
        end: Option<u32>,
    ) -> Result<Vec<TransportEvent>, Endless> {
        if self.held.len() >= MOST_HELD {
            return Err(Endless);
        }
        self.held.push((sent, heard));
        self.ends.extend(end.map(|before| (sent, before as usize)));
        let mut ready = Vec::new();
        while let Some(place) = self.ends.iter().position(|end| self.is_whole(end)) {
            let (end, _) = self.ends.remove(place);
            let mut turn: Vec<_> = self
                .held
                .extract_if(.., |(sent, _)| sent.at <= end.at)
                .collect();
            // Equal times keep their order of arrival.
            turn.sort_by_key(|(sent, _)| sent.at);
            ready.extend(turn.into_iter().flat_map(|(_, heard)| heard));
        }
        Ok(ready)
    }

    /// Whether all messages of its sender's turn up to its `end` have come.
    fn is_whole(&self, (end, before): &(Sent, usize)) -> bool {
        let mine = |sent: &Sent| sent.sender == end.sender && sent.at <= end.at;
        let held = self.held.iter().filter(|(sent, _)| mine(sent)).count();
        held > *before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Origin;

    fn sent(sender: u8, at: i64) -> Sent {
        Sent::new(&[sender; 24], at)
    }

    fn line(text: &str) -> Vec<TransportEvent> {
        vec![TransportEvent::Line(
            Origin::Topic("t".into()),
            text.as_bytes().to_vec(),
        )]
    }

    fn texts(heard: Vec<TransportEvent>) -> String {
        let text = |heard: TransportEvent| match heard {
            TransportEvent::Line(_, text) => String::from_utf8(text).unwrap(),
            other => panic!("{other:?}"),
        };
        heard.into_iter().map(text).collect()
    }

    #[test]
    fn a_turn_is_handed_on_once_it_is_whole_in_the_order_of_sending() {
        let mut turns = Turns::default();
        let mut take =
            |sender, at, text, end| texts(turns.take(sent(sender, at), line(text), end).unwrap());
        assert_eq!(take(1, 30, "c", None), "");
        // The end overtakes what was sent before it.
        assert_eq!(take(1, 40, ".", Some(3)), "");
        assert_eq!(take(1, 10, "a", None), "");
        // Messages of other senders do not count, and are passed on too.
        assert_eq!(take(2, 20, "x", None), "");
        // A message of the next turn is not part of this one.
        assert_eq!(take(1, 50, "d", None), "");
        assert_eq!(take(1, 20, "b", None), "axbc.");
        assert_eq!(take(1, 60, ".", Some(1)), "d.");
        // A turn that consists only of its end.
        assert_eq!(take(1, 70, ".", Some(0)), ".");
    }

    #[test]
    fn what_never_ends_is_not_held_for_ever() {
        let mut turns = Turns::default();
        for at in 0..MOST_HELD {
            assert!(turns.take(sent(1, at as i64), Vec::new(), None).is_ok());
        }
        let last = turns.take(sent(1, 0), Vec::new(), None);
        assert_eq!(last.unwrap_err(), Endless);
    }
}
