//! The topic filters of a connection: one for each kind of message of the fleet's robots.

use std::collections::VecDeque;

use rumqttc::{QoS, SubscribeFilterInput, SubscribeReasonCode};
use vibrissa_protocol::{Name, RobotTopic, plain};

/// The topics that robots publish.
pub(super) fn heard() -> impl Iterator<Item = RobotTopic> {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot())
}

/// The filters of one packet, as texts.
pub(super) type Packet = Vec<String>;

/// The subscriptions of a connection.
#[derive(Debug)]
pub(super) struct Subscriptions {
    fleet: Name,
    /// Packets that are sent and not acknowledged, the oldest first.
    unacknowledged: VecDeque<Packet>,
    /// Contacts and statuses come from elsewhere.
    is_without_contacts: bool,
}

impl Subscriptions {
    /// Those of a fleet.
    pub(super) fn new(fleet: Name) -> Self {
        Self { fleet, unacknowledged: VecDeque::new(), is_without_contacts: false }
    }

    /// The same without contacts and statuses, which come from a partitioned log.
    pub(super) fn without_contacts(self) -> Self {
        Self { is_without_contacts: true, ..self }
    }

    /// The topics that are subscribed to.
    pub(super) fn kinds(&self) -> impl Iterator<Item = RobotTopic> + use<> {
        let is_without = self.is_without_contacts;
        heard().filter(move |&kind| !(is_without && is_in_log(kind)))
    }

    /// The packet of a new connection.
    pub(super) fn begin(&mut self) -> Packet {
        self.unacknowledged.clear();
        self.packet(|_| true)
    }

    /// A packet that subscribes to the retained topics once more, so that the broker sends their messages again.
    pub(super) fn retained(&mut self) -> Packet {
        self.packet(RobotTopic::is_retained)
    }

    fn packet(&mut self, which: impl Fn(RobotTopic) -> bool) -> Packet {
        let packet: Packet =
            self.kinds().filter(|&kind| which(kind)).map(|kind| kind.fleet_filter(&self.fleet)).collect();
        self.unacknowledged.push_back(packet.clone());
        packet
    }

    /// Takes an acknowledgement, which come in the order of the packets.
    ///
    /// # Errors
    /// The first filter that the broker refuses, with its reason code.
    pub(super) fn acknowledged(&mut self, codes: &[SubscribeReasonCode]) -> Result<(), String> {
        let packet = self.unacknowledged.pop_front().unwrap_or_default();
        let is_refused = |code: &SubscribeReasonCode| !matches!(code, SubscribeReasonCode::Success(_));
        match codes.iter().enumerate().find(|(_, code)| is_refused(code)) {
            None => Ok(()),
            Some((at, code)) => {
                let filter = packet.get(at).map_or("the robots' topics", String::as_str);
                Err(refused_filter(filter, *code))
            }
        }
    }

    /// Whether all packets are acknowledged.
    pub(super) fn are_complete(&self) -> bool {
        self.unacknowledged.is_empty()
    }
}

/// Whether messages of this topic come from a partitioned log, if there is one.
fn is_in_log(kind: RobotTopic) -> bool {
    matches!(kind, RobotTopic::Contacts | RobotTopic::Status)
}

/// A filter that the broker refuses, and why.
pub(super) fn refused_filter(filter: &str, code: SubscribeReasonCode) -> String {
    format!("{filter}, {}", plain::reason_code(&format!("{code:?}")))
}

/// The filters of a packet, for the client.
pub(super) fn inputs(packet: Packet) -> impl Iterator<Item = SubscribeFilterInput> {
    packet.into_iter().map(|filter| SubscribeFilterInput::new(filter, QoS::AtLeastOnce))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn subscriptions() -> Subscriptions {
        Subscriptions::new(Name::new("f").unwrap())
    }

    #[test]
    fn a_fleet_needs_one_filter_for_each_topic() {
        let filters = subscriptions().begin();
        assert_eq!(filters.len(), heard().count());
        assert!(filters.iter().all(|filter| filter.starts_with("whisker/v1/f/+/")), "{filters:?}");
        let filters = subscriptions().without_contacts().begin();
        assert_eq!(filters.len(), heard().count() - 2);
        assert!(
            !filters.iter().any(|filter| filter.ends_with("contacts") || filter.ends_with("status")),
            "{filters:?}"
        );
    }

    #[test]
    fn a_refused_filter_is_named() {
        let mut subscriptions = subscriptions();
        let packet = subscriptions.begin();
        let again = subscriptions.retained();
        let accepted = |packet: &Packet| vec![SubscribeReasonCode::Success(QoS::AtLeastOnce); packet.len()];
        assert_eq!(subscriptions.acknowledged(&accepted(&packet)), Ok(()));
        assert!(!subscriptions.are_complete());
        let mut codes = accepted(&again);
        codes[1] = SubscribeReasonCode::NotAuthorized;
        let refused = subscriptions.acknowledged(&codes).unwrap_err();
        assert!(refused.starts_with(&again[1]), "{refused}");
        assert!(subscriptions.are_complete());
    }
}
