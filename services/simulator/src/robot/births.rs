//! Answers to requests for births, which all robots of a fleet receive at once.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_protocol::{Message, SupervisorRequestKind, Topic, decode};

use super::{Outgoing, Robot};
use crate::scenario::Misbehaviour;

/// Longest delay of an answer, in microseconds. Random delays keep a fleet from answering at the same moment.
pub(crate) const DELAY_MAX_US: u64 = 2_000_000;

/// The time of the next answer.
#[derive(Debug)]
pub(super) struct Births {
    due_us: Option<u64>,
    delays: ChaCha8Rng,
}

impl Births {
    pub(super) fn new(delays: ChaCha8Rng) -> Self {
        Self { due_us: None, delays }
    }

    /// Time of the next answer, if a request waits for one.
    pub(super) fn due_us(&self) -> Option<u64> {
        self.due_us
    }

    /// A birth was sent, which answers all requests so far.
    pub(super) fn sent(&mut self) {
        self.due_us = None;
    }

    /// A request has arrived. One answer serves all requests that arrive before it.
    fn requested(&mut self, now_us: u64) {
        let delay_us = self.delays.random_range(0..DELAY_MAX_US);
        self.due_us.get_or_insert(now_us + delay_us);
    }
}

impl Robot {
    /// Handles a message on the fleet's `supervisor/request`; an invalid one is counted and has no effect. It is no sign of
    /// this robot's own supervisor: in a divided fleet the owner of any shard may have sent it.
    pub fn receive_request_to_all(&mut self, payload: &[u8], now_us: u64) {
        let topic = Topic::SupervisorRequest { fleet: self.config.fleet.clone() };
        let Ok(Message::SupervisorRequest(request)) = decode(&topic, payload) else {
            self.refused += 1;
            return;
        };
        match request.request {
            SupervisorRequestKind::Birth if self.breaks(Misbehaviour::IgnoresBirthRequest) => {}
            SupervisorRequestKind::Birth => self.births.requested(now_us),
        }
    }

    /// Sends birth and factsheet again, in the present boot.
    pub(super) fn answer_birth_request(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        self.births.sent();
        self.birth(now_us, out);
        self.factsheet(now_us, out);
    }
}
