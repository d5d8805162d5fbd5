//! Answers to requests for births, which all robots of a fleet receive at once.

use rand::Rng;
use vibrissa_protocol::{Message, SupervisorRequestKind, Topic, decode};
use vibrissa_robot::contract::Moment;
use vibrissa_robot::contract::births::DELAY_MAX_US;

use super::{Outgoing, Robot};
use crate::scenario::Misbehaviour;

impl Robot {
    /// Handles a message on the fleet's `supervisor/request`; an invalid one is counted and has no effect. It is no sign of
    /// the fleet's owner: a supervisor whose lease has just ended may have sent it.
    pub fn receive_request_to_all(&mut self, payload: &[u8], now_us: u64) {
        let topic = Topic::SupervisorRequest { fleet: self.config.fleet.clone() };
        let Ok(Message::SupervisorRequest(request)) = decode(&topic, payload) else {
            self.refused += 1;
            return;
        };
        match request.request {
            SupervisorRequestKind::Birth if self.breaks(Misbehaviour::IgnoresBirthRequest) => {}
            SupervisorRequestKind::Birth => {
                self.births.requested(Moment::of_us(now_us), self.birth_delays.random_range(0..DELAY_MAX_US));
            }
        }
    }

    /// Sends birth and factsheet again, in the present boot.
    pub(super) fn answer_birth_request(&mut self, now_us: u64, out: &mut Vec<Outgoing>) {
        self.births.sent();
        self.birth(now_us, out);
        self.factsheet(now_us, out);
    }
}
