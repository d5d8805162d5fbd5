//! The subscriptions of all clients, found by topic.

use std::collections::{BTreeMap, BTreeSet};

use rumqttc::{QoS, has_wildcards, matches};

use super::message::ClientId;

/// What a client was granted for a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grant {
    /// Highest quality of service of deliveries.
    pub(super) qos: QoS,
    /// The client's own messages are left out.
    pub(super) is_no_local: bool,
    /// Live messages keep the publisher's retain flag.
    pub(super) keeps_retain: bool,
}

type ByFilter = BTreeMap<String, BTreeMap<ClientId, Grant>>;

/// All subscriptions. Filters without wildcards, which most robots have, are found without a search.
#[derive(Debug, Default)]
pub(super) struct Subscriptions {
    exact: ByFilter,
    wild: ByFilter,
    /// Filters of each client.
    of: BTreeMap<ClientId, BTreeSet<String>>,
}

impl Subscriptions {
    fn by_filter(&mut self, filter: &str) -> &mut ByFilter {
        if has_wildcards(filter) { &mut self.wild } else { &mut self.exact }
    }

    /// Adds or replaces a subscription; returns whether it is new.
    pub(super) fn add(&mut self, filter: &str, client: &ClientId, grant: Grant) -> bool {
        self.by_filter(filter).entry(filter.to_owned()).or_default().insert(client.clone(), grant);
        self.of.entry(client.clone()).or_default().insert(filter.to_owned())
    }

    /// Ends a subscription; returns whether it existed.
    pub(super) fn remove(&mut self, filter: &str, client: &ClientId) -> bool {
        let by_filter = self.by_filter(filter);
        if let Some(clients) = by_filter.get_mut(filter) {
            clients.remove(client);
            if clients.is_empty() {
                by_filter.remove(filter);
            }
        }
        self.of.get_mut(client).is_some_and(|filters| filters.remove(filter))
    }

    /// Ends all subscriptions of a client; returns their number.
    pub(super) fn forget(&mut self, client: &ClientId) -> usize {
        let filters = self.of.get(client).cloned().unwrap_or_default();
        for filter in &filters {
            self.remove(filter, client);
        }
        self.of.remove(client);
        filters.len()
    }

    /// Receivers of a message. A client with several filters that match gets it once, with the most that they grant.
    pub(super) fn receivers(&self, topic: &str, from: &str) -> BTreeMap<ClientId, Grant> {
        let wild = self.wild.iter().filter(|(filter, _)| matches(topic, filter)).map(|(_, clients)| clients);
        let mut receivers = BTreeMap::<ClientId, Grant>::new();
        for (client, grant) in self.exact.get(topic).into_iter().chain(wild).flatten() {
            if grant.is_no_local && **client == *from {
                continue;
            }
            let best = receivers.entry(client.clone()).or_insert(*grant);
            if grant.qos == QoS::AtLeastOnce {
                best.qos = grant.qos;
            }
            best.keeps_retain |= grant.keeps_retain;
        }
        receivers
    }
}
