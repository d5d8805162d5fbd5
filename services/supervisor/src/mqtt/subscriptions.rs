//! The topic filters of a connection.
//!
//! A whole fleet needs one filter for each topic. A shard subscribes to the connection messages of all robots, because these
//! tell which robots there are, and to the other topics only of its own robots. Its probes test the connection and this one
//! filter: all shards receive the probes of each.

use std::collections::{BTreeSet, VecDeque};

use rumqttc::{QoS, SubscribeFilterInput, SubscribeReasonCode};
use tracing::warn;
use vibrissa_edge::full_name::FullName;
use vibrissa_edge::shard::FleetShard;
use vibrissa_protocol::{Name, RobotTopic, plain};

/// Filters of one packet; brokers limit the size of packets.
const FILTERS_PER_PACKET: usize = 500;
/// Limit of a shard's robots that are subscribed to. Whoever may publish connection messages could otherwise add robots
/// without end.
const ROBOTS_MAX: usize = 20_000;

/// The topics that robots publish.
pub(super) fn heard() -> impl Iterator<Item = RobotTopic> {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot())
}

/// The filters of one packet, as texts.
pub(super) type Packet = Vec<String>;

/// The subscriptions of a connection.
#[derive(Debug)]
pub(super) struct Subscriptions {
    shard: FleetShard,
    /// Robots of the shard of a divided fleet.
    robots: BTreeSet<Name>,
    /// Packets that are sent and not acknowledged, the oldest first.
    unacknowledged: VecDeque<Packet>,
    /// Contacts and statuses come from elsewhere.
    is_without_contacts: bool,
}

/// The shard that a received message belongs to.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Receipt {
    /// The robot belongs to this shard.
    Own,
    /// It belongs to another one.
    Foreign,
    /// It belongs to this shard, and these filters are missing.
    New(Packet),
}

impl Subscriptions {
    /// Those of a shard with these robots.
    pub(super) fn new(shard: FleetShard, robots: impl IntoIterator<Item = Name>) -> Self {
        let robots = if shard.is_whole() { BTreeSet::new() } else { robots.into_iter().collect() };
        Self { shard, robots, unacknowledged: VecDeque::new(), is_without_contacts: false }
    }

    /// The same without contacts and statuses, which come from a partitioned log.
    pub(super) fn without_contacts(self) -> Self {
        Self { is_without_contacts: true, ..self }
    }

    /// The topics whose filters are probed.
    pub(super) fn probed(&self) -> impl Iterator<Item = RobotTopic> + use<> {
        let (is_whole, is_without) = (self.shard.is_whole(), self.is_without_contacts);
        heard().filter(move |&kind| (is_whole || kind == RobotTopic::Connection) && !(is_without && is_in_log(kind)))
    }

    /// Largest number of packets that a connection sends at once.
    pub(super) fn packets_max(&self) -> usize {
        let kinds = heard().count();
        match self.shard.is_whole() {
            true => 1,
            false => ROBOTS_MAX * kinds / FILTERS_PER_PACKET + 2,
        }
    }

    /// Packets of a new connection.
    pub(super) fn begin(&mut self) -> Vec<Packet> {
        self.unacknowledged.clear();
        self.packets(|_| true)
    }

    /// Packets that subscribe to the retained topics once more, so that the broker sends their messages again.
    pub(super) fn retained(&mut self) -> Vec<Packet> {
        self.packets(RobotTopic::is_retained)
    }

    fn packets(&mut self, which: impl Fn(RobotTopic) -> bool) -> Vec<Packet> {
        let fleet = self.shard.fleet();
        let of_fleet = self.probed().filter(|&kind| which(kind)).map(|kind| kind.fleet_filter(fleet));
        let which_of_robots = |kind| which(kind) && !(self.is_without_contacts && is_in_log(kind));
        let of_robots = self.robots.iter().flat_map(|robot| of_robot(&self.shard, robot, &which_of_robots));
        let filters: Vec<String> = of_fleet.chain(of_robots).collect();
        let packets: Vec<Packet> = filters.chunks(FILTERS_PER_PACKET).map(<[String]>::to_vec).collect();
        self.unacknowledged.extend(packets.iter().cloned());
        packets
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

    /// Decides about a message by its topic. A robot that is heard for the first time is added.
    pub(super) fn receive(&mut self, topic: &[u8]) -> Receipt {
        if self.shard.is_whole() {
            return Receipt::Own;
        }
        let mut levels = topic.rsplit(|&byte| byte == b'/').skip(1);
        let robot = levels.next().and_then(|robot| std::str::from_utf8(robot).ok()).unwrap_or_default();
        if !self.shard.has(robot) {
            return Receipt::Foreign;
        }
        match Name::robot(robot) {
            Ok(name) if !self.robots.contains(&name) => self.add(name),
            // The decoder refuses and counts it.
            Ok(_) | Err(_) => Receipt::Own,
        }
    }

    fn add(&mut self, robot: Name) -> Receipt {
        if self.robots.len() >= ROBOTS_MAX {
            let robot = FullName::robot(self.shard.fleet().as_str(), robot.as_str());
            warn!(fleet = %self.shard, %robot, limit = ROBOTS_MAX, "too many robots in this shard, one is not subscribed to");
            return Receipt::Own;
        }
        let filters: Packet =
            of_robot(&self.shard, &robot, &|kind| !(self.is_without_contacts && is_in_log(kind))).collect();
        self.robots.insert(robot);
        self.unacknowledged.push_back(filters.clone());
        Receipt::New(filters)
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

/// The filters for a robot, beside that of connection messages.
fn of_robot<'a>(
    shard: &'a FleetShard,
    robot: &'a Name,
    which: &'a impl Fn(RobotTopic) -> bool,
) -> impl Iterator<Item = String> + 'a {
    let kinds = heard().filter(|&kind| kind != RobotTopic::Connection && which(kind));
    kinds.map(|kind| kind.of(shard.fleet(), robot).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_fleet_needs_one_filter_for_each_topic() {
        let mut whole = Subscriptions::new(FleetShard::whole(Name::new("f").unwrap()), []);
        let packets = whole.begin();
        assert_eq!(packets.len(), 1);
        assert!(packets[0].iter().all(|filter| filter.starts_with("whisker/v1/f/+/")), "{packets:?}");
        assert_eq!(whole.receive(b"whisker/v1/f/any/contacts"), Receipt::Own);
    }

    #[test]
    fn a_shard_hears_who_there_is_and_the_rest_only_of_its_own_robots() {
        let fleet = Name::new("f").unwrap();
        let shard = FleetShard::new(fleet, 1, 4).unwrap();
        let names: Vec<String> = (0..400).map(|number| format!("r{number}")).collect();
        let own: Vec<&String> = names.iter().filter(|name| shard.has(name)).collect();
        let known = own.iter().skip(1).map(|name| Name::robot(name).unwrap());
        let mut subscriptions = Subscriptions::new(shard.clone(), known);
        let filters: Vec<String> = subscriptions.begin().concat();
        let wild: Vec<&String> = filters.iter().filter(|filter| filter.contains('+')).collect();
        assert_eq!(wild, ["whisker/v1/f/+/connection"]);
        assert_eq!(filters.len(), 1 + (own.len() - 1) * (heard().count() - 1));
        for name in &names {
            let expected = match (shard.has(name), name == own[0]) {
                (true, true) => "new",
                (true, false) => "own",
                (false, _) => "foreign",
            };
            let found = match subscriptions.receive(format!("whisker/v1/f/{name}/connection").as_bytes()) {
                Receipt::Own => "own",
                Receipt::Foreign => "foreign",
                Receipt::New(filters) => {
                    assert!(filters.contains(&format!("whisker/v1/f/{name}/contacts")), "{filters:?}");
                    "new"
                }
            };
            assert_eq!(found, expected, "{name}");
        }
        let again = subscriptions.receive(format!("whisker/v1/f/{}/contacts", own[0]).as_bytes());
        assert_eq!(again, Receipt::Own);
    }

    #[test]
    fn filters_go_out_in_packets_and_a_refused_one_is_named() {
        let shard = FleetShard::new(Name::new("f").unwrap(), 0, 2).unwrap();
        let robots = (0..1000).map(|number| format!("r{number}")).filter(|name| shard.has(name));
        let mut subscriptions = Subscriptions::new(shard.clone(), robots.map(|name| Name::robot(&name).unwrap()));
        let packets = subscriptions.begin();
        assert!(packets.len() > 3 && packets.iter().all(|packet| packet.len() <= FILTERS_PER_PACKET));
        let accepted = |packet: &Packet| vec![SubscribeReasonCode::Success(QoS::AtLeastOnce); packet.len()];
        assert_eq!(subscriptions.acknowledged(&accepted(&packets[0])), Ok(()));
        let mut codes = accepted(&packets[1]);
        codes[7] = SubscribeReasonCode::NotAuthorized;
        let refused = subscriptions.acknowledged(&codes).unwrap_err();
        assert!(refused.starts_with(&packets[1][7]), "{refused}");
        assert!(!subscriptions.are_complete());
    }
}
