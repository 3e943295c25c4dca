//! Messages of all topics in the order in which they were sent, a turn at a time.
//!
//! DDS keeps the order within a topic and not among topics. With `--clock messages` node and
//! station take turns: a turn ends with a message that says how many there were in it, so
//! what is heard is held until all of the turn is there, and then handed on in the order of
//! the times at which DDS says that it was published.

use crate::transport::Heard;

/// Messages that are held at most; a station that takes turns sends fewer in one.
const MOST: usize = 100_000;
/// Bytes of a writer's identity that are the same for all writers of a participant.
const PARTICIPANT: usize = 12;

/// Where a message is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// The participant that published it.
    pub sender: [u8; PARTICIPANT],
    /// When it did [ns].
    pub at: i64,
}

impl Sent {
    /// What DDS says of a message: its writer's identity, and when it was published [ns].
    pub fn new(writer: &[u8], at: i64) -> Self {
        let mut sender = [0; PARTICIPANT];
        for (byte, known) in sender.iter_mut().zip(writer) {
            *byte = *known;
        }
        Self { sender, at }
    }
}

/// What is held.
#[derive(Debug, Default)]
pub struct Turns {
    held: Vec<(Sent, Vec<Heard>)>,
    /// Ends of turns: by whom, and how many messages there were before it in the turn.
    ends: Vec<(Sent, usize)>,
}

/// More was heard in one turn than anybody sends.
#[derive(Debug, PartialEq, Eq)]
pub struct Endless;

impl Turns {
    /// Takes what came of one message; `end` is how many messages came before it in the turn
    /// that it ends. Returns what is to be handed on now.
    ///
    /// # Errors
    /// A turn that does not end.
    pub fn take(
        &mut self,
        sent: Sent,
        heard: Vec<Heard>,
        end: Option<u32>,
    ) -> Result<Vec<Heard>, Endless> {
        if self.held.len() >= MOST {
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
            // Equal times stay as they came.
            turn.sort_by_key(|(sent, _)| sent.at);
            ready.extend(turn.into_iter().flat_map(|(_, heard)| heard));
        }
        Ok(ready)
    }

    /// Whether all that its sender published in the turn up to its `end` has come.
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

    fn line(text: &str) -> Vec<Heard> {
        vec![Heard::Line(
            Origin::Topic("t".into()),
            text.as_bytes().to_vec(),
        )]
    }

    fn texts(heard: Vec<Heard>) -> String {
        let text = |heard: Heard| match heard {
            Heard::Line(_, text) => String::from_utf8(text).unwrap(),
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
        // Others count for nothing, and are handed on too.
        assert_eq!(take(2, 20, "x", None), "");
        // A message of the next turn is none of this one.
        assert_eq!(take(1, 50, "d", None), "");
        assert_eq!(take(1, 20, "b", None), "axbc.");
        assert_eq!(take(1, 60, ".", Some(1)), "d.");
        // A turn of nothing but its end.
        assert_eq!(take(1, 70, ".", Some(0)), ".");
    }

    #[test]
    fn what_never_ends_is_not_held_for_ever() {
        let mut turns = Turns::default();
        for at in 0..MOST {
            assert!(turns.take(sent(1, at as i64), Vec::new(), None).is_ok());
        }
        let last = turns.take(sent(1, 0), Vec::new(), None);
        assert_eq!(last.unwrap_err(), Endless);
    }
}
