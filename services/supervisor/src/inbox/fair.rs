//! Fair queues of received messages: each robot has a queue, and the queues take turns.
//!
//! Two rules keep robots apart. Space: a robot's messages may take at most as much space as is still free, so that
//! there is always space for the others (dynamic thresholds, Choudhury and Hahne 1998). Turns: each queue may give the
//! same number of bytes per turn (deficit round robin, Shreedhar and Varghese 1995), and only [`ROUND_BYTES`] per
//! transaction. So a message of a robot with little traffic waits for at most one turn of each other robot, whatever
//! they send. Each robot's messages keep their order.

use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasher, RandomState};

use vibrissa_core::units::Micros;

use super::Incoming;

/// Memory of a message besides its topic and payload, bytes, rounded up.
pub(super) const MESSAGE_BYTES: usize = 256;
/// Bytes that a queue may give per turn: two messages of 20 contacts, or about ten of one contact.
const TURN_BYTES: usize = 8 * 1024;
/// Bytes that the engine takes at a time: about 7,000 contacts, which take it some milliseconds.
const TAKE_BYTES: usize = 1024 * 1024;
/// Bytes of one robot per transaction: about 1,700 contacts, whose commit takes about 20 ms.
const ROUND_BYTES: usize = 256 * 1024;
/// Weight of a factsheet in bytes: the engine waits for the database before it takes the next message.
const FACTSHEET_BYTES: usize = 64 * 1024;
/// A queue with more bytes is long: its last message waits for several turns.
const LONG_BYTES: usize = 4 * TURN_BYTES;
/// Limit of the robots that are named as shed between two calls of [`FairQueues::take_shed`].
const SHED_ROBOTS_MAX: usize = 256;
/// Capacity in messages that an empty queue keeps.
const KEPT_PLACES: usize = 16;
/// Limit of idle queues that keep their robot until the round ends, to remember the bytes given in the round.
const IDLE_MAX: usize = 4096;
/// Queues that stay allocated while all are empty.
const KEPT_QUEUES: usize = 16_384;

/// An amount of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Filling {
    /// Number of messages.
    pub messages: usize,
    /// Sum of their weights in bytes.
    pub bytes: usize,
}

impl Filling {
    fn add(&mut self, bytes: usize) {
        self.messages += 1;
        self.bytes += bytes;
    }

    fn remove(&mut self, bytes: usize) {
        self.messages -= 1;
        self.bytes -= bytes;
    }
}

/// Limits of the waiting messages. The reserves are not available to contacts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) messages: usize,
    pub(super) messages_reserved: usize,
    pub(super) bytes: usize,
    pub(super) bytes_reserved: usize,
}

/// Why a message is shed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ShedReason {
    /// No space is left.
    Full,
    /// Its robot's messages take as much space as is free for all others.
    OverShare,
}

/// A robot whose messages were shed because it sent more than its share.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shed {
    /// The robot's level of the topic, as received.
    pub robot: Vec<u8>,
    /// Number of messages shed since the last call of [`Inbox::take_shed`](super::Inbox::take_shed).
    pub messages: u64,
}

/// The messages of one robot.
#[derive(Debug, Default)]
struct Queue {
    /// Hash of the robot's name.
    robot: u64,
    messages: VecDeque<Incoming>,
    /// Space taken by waiting messages, and by received ones that are not handed over yet. The second item is that of
    /// contacts, the first that of all other messages.
    held: [Filling; 2],
    /// Bytes that it may still give in its turn.
    deficit: usize,
    /// It is this queue's turn, and the bytes of the turn are in the deficit.
    is_its_turn: bool,
    /// Bytes that it has given in this round.
    given: usize,
    round: u64,
    /// Since it was last empty, it has had to wait for another round.
    is_throttled: bool,
    /// It became empty in this round.
    is_idle: bool,
    /// Number of the last shedding report that names this robot, and its index in that report.
    shed: Option<(u64, usize)>,
}

impl Queue {
    fn is_unused(&self) -> bool {
        self.held.iter().all(|held| held.messages == 0)
    }
}

/// The waiting messages of all robots.
#[derive(Debug, Default)]
pub(super) struct FairQueues {
    queues: Vec<Queue>,
    /// Indices of queues without a robot.
    unused: Vec<usize>,
    /// Indices of queues that became empty in this round.
    idle: Vec<usize>,
    by_robot: HashMap<u64, usize>,
    /// Queues with messages, in the order of their turns.
    turns: VecDeque<usize>,
    /// Space taken in all queues.
    held: Filling,
    waiting: usize,
    /// Number of queues that have given their bytes of the round, and have more.
    throttled: usize,
    round: u64,
    report: u64,
    shed: Vec<Shed>,
    shed_others: u64,
    /// With random keys, so that nobody can choose names that share a queue.
    names: RandomState,
}

/// Space that a message takes, bytes.
pub(super) fn weight(topic: &[u8], payload: &[u8]) -> usize {
    topic.len() + payload.len() + MESSAGE_BYTES
}

fn is_contacts(topic: &[u8]) -> bool {
    topic.ends_with(b"/contacts")
}

/// Bytes that a message takes from its robot's turn.
fn cost(message: &Incoming) -> usize {
    let own = weight(&message.topic, &message.payload);
    if message.topic.ends_with(b"/factsheet") { own.max(FACTSHEET_BYTES) } else { own }
}

/// The robot's level of a topic; the whole topic if there is none.
fn robot_of(topic: &[u8]) -> &[u8] {
    topic.split(|&byte| byte == b'/').nth(3).unwrap_or(topic)
}

impl FairQueues {
    /// Space taken by waiting messages and by received ones that are not handed over yet.
    pub(super) fn held(&self) -> Filling {
        self.held
    }

    /// Whether no messages wait.
    pub(super) fn is_empty(&self) -> bool {
        self.waiting == 0
    }

    /// Whether messages wait for another round.
    pub(super) fn is_throttling(&self) -> bool {
        self.throttled > 0
    }

    /// Reserves space for a message in its robot's queue. Returns the queue's index, for [`Self::push`].
    pub(super) fn reserve(&mut self, topic: &[u8], payload: &[u8], bounds: &Bounds) -> Result<usize, ShedReason> {
        let (weight, is_contacts) = (weight(topic, payload), is_contacts(topic));
        let reserve = if is_contacts { (bounds.messages_reserved, bounds.bytes_reserved) } else { (0, 0) };
        let free = Filling {
            messages: bounds.messages.saturating_sub(self.held.messages + reserve.0),
            bytes: bounds.bytes.saturating_sub(self.held.bytes + reserve.1),
        };
        if free.messages == 0 || free.bytes < weight {
            return Err(ShedReason::Full);
        }
        let at = self.queue_of(robot_of(topic));
        let own = &mut self.queues[at].held[usize::from(is_contacts)];
        if own.messages > 0 && (own.messages >= free.messages || own.bytes + weight > free.bytes) {
            self.note_shed(at, topic);
            return Err(ShedReason::OverShare);
        }
        own.add(weight);
        self.held.add(weight);
        Ok(at)
    }

    fn queue_of(&mut self, robot: &[u8]) -> usize {
        let key = self.names.hash_one(robot);
        *self.by_robot.entry(key).or_insert_with(|| {
            let at = self.unused.pop().unwrap_or_else(|| {
                self.queues.push(Queue::default());
                self.queues.len() - 1
            });
            self.queues[at].robot = key;
            at
        })
    }

    fn note_shed(&mut self, at: usize, topic: &[u8]) {
        let place = self.queues[at].shed.filter(|&(report, _)| report == self.report).map(|(_, place)| place);
        if let Some(shed) = place.and_then(|place| self.shed.get_mut(place)) {
            shed.messages += 1;
        } else if self.shed.len() < SHED_ROBOTS_MAX {
            self.queues[at].shed = Some((self.report, self.shed.len()));
            self.shed.push(Shed { robot: robot_of(topic).to_owned(), messages: 1 });
        } else {
            self.shed_others += 1;
        }
    }

    /// Counts a message that was shed because no space was left.
    pub(super) fn note_full(&mut self) {
        self.shed_others += 1;
    }

    /// Starts a new shedding report. Returns the robots of the old one, and the number of messages shed of others.
    pub(super) fn take_shed(&mut self) -> (Vec<Shed>, u64) {
        self.report += 1;
        (std::mem::take(&mut self.shed), std::mem::take(&mut self.shed_others))
    }

    /// Whether a message added to this queue now waits for several turns.
    pub(super) fn is_long(&self, at: usize) -> bool {
        self.queues[at].held.iter().map(|held| held.bytes).sum::<usize>() > LONG_BYTES
    }

    /// Appends a message to the queue in which its space is reserved.
    pub(super) fn push(&mut self, at: usize, message: Incoming) {
        let queue = &mut self.queues[at];
        if queue.messages.is_empty() {
            self.turns.push_back(at);
        }
        queue.messages.push_back(message);
        self.waiting += 1;
    }

    /// Frees the space of a message.
    fn let_go(&mut self, at: usize, weight: usize, is_contacts: bool) {
        self.held.remove(weight);
        let queue = &mut self.queues[at];
        queue.held[usize::from(is_contacts)].remove(weight);
        if queue.is_unused() && !std::mem::replace(&mut queue.is_idle, true) {
            self.idle.push(at);
            if self.idle.len() > IDLE_MAX {
                self.release_idle();
            }
        }
    }

    /// Detaches queues that are still empty from their robots.
    fn release_idle(&mut self) {
        for at in self.idle.drain(..) {
            let queue = &mut self.queues[at];
            queue.is_idle = false;
            if queue.is_unused() {
                self.by_robot.remove(&queue.robot);
                let mut messages = std::mem::take(&mut queue.messages);
                messages.shrink_to(KEPT_PLACES);
                *queue = Queue { messages, ..Queue::default() };
                self.unused.push(at);
            }
        }
        if self.by_robot.is_empty() && self.queues.len() > KEPT_QUEUES {
            (self.queues, self.unused) = (Vec::new(), Vec::new());
        }
    }

    /// Begins another round: each robot may give [`ROUND_BYTES`] again.
    pub(super) fn begin_round(&mut self, round: u64) {
        if round != self.round {
            self.round = round;
            self.release_idle();
        }
    }

    /// Gives up to `most` messages in turns, and returns their number: 0 if none wait, or if all of them wait for
    /// another round.
    pub(super) fn give(&mut self, most: usize, to: &mut impl FnMut(Incoming)) -> usize {
        let (mut count, mut bytes, mut passed_over) = (0, 0, 0);
        while count < most && bytes < TAKE_BYTES && passed_over < self.turns.len() {
            let Some(&at) = self.turns.front() else { break };
            let queue = &mut self.queues[at];
            if queue.round != self.round {
                (queue.round, queue.given) = (self.round, 0);
            }
            if queue.given >= ROUND_BYTES {
                self.throttled += usize::from(!std::mem::replace(&mut queue.is_throttled, true));
                queue.is_its_turn = false;
                self.turns.rotate_left(1);
                passed_over += 1;
                continue;
            }
            passed_over = 0;
            if !std::mem::replace(&mut queue.is_its_turn, true) {
                queue.deficit += TURN_BYTES;
            }
            let cost = queue.messages.front().map_or(0, cost);
            if queue.deficit < cost {
                queue.is_its_turn = false;
                self.turns.rotate_left(1);
                continue;
            }
            let Some(message) = queue.messages.pop_front() else { break };
            queue.deficit -= cost;
            queue.given += cost;
            if queue.messages.is_empty() {
                self.throttled -= usize::from(std::mem::take(&mut queue.is_throttled));
                (queue.deficit, queue.is_its_turn) = (0, false);
                self.turns.pop_front();
            }
            (count, bytes, self.waiting) = (count + 1, bytes + cost, self.waiting - 1);
            self.let_go(at, weight(&message.topic, &message.payload), is_contacts(&message.topic));
            to(message);
        }
        count
    }

    /// Receipt time of the oldest message, without those that wait because their own robot sends too much.
    pub(super) fn oldest(&self) -> Option<Micros> {
        let queues = self.turns.iter().map(|&at| &self.queues[at]);
        let own_pace = queues.filter(|queue| !queue.is_throttled);
        own_pace.filter_map(|queue| queue.messages.front()).map(|message| message.received).min()
    }

    /// Robots whose messages wait because they send too much, by their level of the topic, and the receipt times of their
    /// oldest messages.
    pub(super) fn delayed(&self) -> impl Iterator<Item = (&[u8], Micros)> {
        let throttled = self.turns.iter().map(|&at| &self.queues[at]).filter(|queue| queue.is_throttled);
        throttled.filter_map(|queue| queue.messages.front()).map(|first| (robot_of(&first.topic), first.received))
    }

    /// Drops all messages, because the receiver has gone.
    pub(super) fn clear(&mut self) {
        *self = Self { report: self.report, round: self.round, ..Self::default() };
    }
}

#[cfg(test)]
mod tests;
