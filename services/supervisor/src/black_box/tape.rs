//! The newest messages of one robot, one after the other in a ring of bytes, with its state at some of the times.

use std::collections::VecDeque;

use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

/// Number of an entry with the robot's state; messages have the number of their topic.
const STATE: u8 = u8::MAX;
/// Bytes of an entry before its payload: time, kind, length of the payload.
const HEAD: usize = 8 + 1 + 4;

/// Kind of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EntryKind {
    /// A message on this topic.
    Message(RobotTopic),
    /// The robot's state.
    State,
}

impl EntryKind {
    fn number(self) -> u8 {
        match self {
            Self::State => STATE,
            // There are few topics.
            Self::Message(topic) => RobotTopic::ALL.iter().position(|one| *one == topic).unwrap_or_default() as u8,
        }
    }

    fn of(number: u8) -> Self {
        RobotTopic::ALL.get(usize::from(number)).map_or(Self::State, |topic| Self::Message(*topic))
    }
}

/// An entry of a tape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry<'t> {
    /// Time by the supervisor's clock.
    pub(super) at: Micros,
    pub(super) kind: EntryKind,
    pub(super) payload: &'t [u8],
}

/// Entries in the order of their addition.
#[derive(Debug, Default)]
pub(super) struct Tape {
    ring: VecDeque<u8>,
    /// Times of the states on it.
    states: VecDeque<Micros>,
}

impl Tape {
    /// Number of bytes.
    pub(super) fn bytes(&self) -> usize {
        self.ring.len()
    }

    /// Bytes that an entry with such a payload takes.
    pub(super) fn bytes_of(payload: usize) -> usize {
        HEAD + payload
    }

    /// Times of the states on the tape.
    pub(super) fn states(&self) -> &VecDeque<Micros> {
        &self.states
    }

    /// Appends an entry.
    pub(super) fn push(&mut self, at: Micros, kind: EntryKind, payload: &[u8]) {
        self.ring.extend(&at.0.to_le_bytes());
        self.ring.push_back(kind.number());
        // Longer messages do not pass the broker.
        self.ring.extend(&(payload.len() as u32).to_le_bytes());
        self.ring.extend(payload);
        if kind == EntryKind::State {
            self.states.push_back(at);
        }
    }

    /// Time and kind of the first entry.
    pub(super) fn first(&self) -> Option<(Micros, EntryKind)> {
        (!self.ring.is_empty()).then(|| (Micros(u64::from_le_bytes(self.array(0))), EntryKind::of(self.ring[8])))
    }

    /// Removes the first entry, and returns its payload if it is of a kind that is wanted.
    pub(super) fn pop(&mut self, is_wanted: impl Fn(EntryKind) -> bool) -> Option<(EntryKind, Vec<u8>)> {
        let (_, kind) = self.first()?;
        let end = HEAD + u32::from_le_bytes(self.array(9)) as usize;
        let payload = is_wanted(kind).then(|| (kind, self.ring.range(HEAD..end).copied().collect()));
        self.ring.drain(..end);
        if kind == EntryKind::State {
            self.states.pop_front();
        }
        payload
    }

    /// Gives memory back that is no longer needed.
    pub(super) fn shrink(&mut self, most: usize) {
        if self.ring.capacity() > 2 * most.max(4096) {
            self.ring.shrink_to(most);
        }
    }

    /// A copy of all entries.
    pub(super) fn copy(&self) -> TapeCopy {
        let (front, back) = self.ring.as_slices();
        TapeCopy([front, back].concat())
    }

    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|index| self.ring[at + index])
    }
}

/// The entries of a tape at some time.
#[derive(Debug)]
pub(super) struct TapeCopy(Vec<u8>);

impl TapeCopy {
    /// The entries in their order.
    pub(super) fn entries(&self) -> impl Iterator<Item = Entry<'_>> {
        let mut rest = &self.0[..];
        std::iter::from_fn(move || {
            let (head, after) = rest.split_at_checked(HEAD)?;
            let payload = u32::from_le_bytes(head[9..].try_into().ok()?) as usize;
            let (payload, after) = after.split_at_checked(payload)?;
            rest = after;
            let at = Micros(u64::from_le_bytes(head[..8].try_into().ok()?));
            Some(Entry { at, kind: EntryKind::of(head[8]), payload })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_back_in_their_order_after_the_ring_has_turned() {
        let mut tape = Tape::default();
        let contacts = EntryKind::Message(RobotTopic::Contacts);
        for number in 0..1000_u64 {
            let kind = if number % 100 == 50 { EntryKind::State } else { contacts };
            tape.push(Micros(number), kind, format!("payload {number}").as_bytes());
            while tape.bytes() > 4000 {
                tape.pop(|_| false);
            }
        }
        let copy = tape.copy();
        let entries: Vec<Entry<'_>> = copy.entries().collect();
        let first = entries[0].at.0;
        assert!(first > 800, "{first}");
        assert_eq!(tape.first(), Some((Micros(first), entries[0].kind)));
        for (number, entry) in (first..1000).zip(&entries) {
            assert_eq!((entry.at.0, entry.payload), (number, format!("payload {number}").as_bytes()));
        }
        assert_eq!(entries.len() as u64, 1000 - first);
        let states: Vec<u64> = entries.iter().filter(|one| one.kind == EntryKind::State).map(|one| one.at.0).collect();
        assert_eq!(tape.states().iter().map(|at| at.0).collect::<Vec<_>>(), states);
    }

    #[test]
    fn every_topic_has_its_number() {
        for topic in RobotTopic::ALL {
            let kind = EntryKind::Message(topic);
            assert_eq!(EntryKind::of(kind.number()), kind);
        }
        assert_eq!(EntryKind::of(EntryKind::State.number()), EntryKind::State);
    }
}
