//! Beginning and end of connections and sessions.

use std::sync::Arc;
use std::time::Duration;

use rumqttc::{
    ConnAck, ConnAckProperties, Connect, ConnectReturnCode, Disconnect, DisconnectReasonCode, LastWill, Packet, QoS,
};
use tokio::time::Instant;

use super::{Link, LinkId, Machine};
use crate::broker::message::{ClientId, will_as_publish};

impl Machine {
    pub(super) fn connect(&mut self, now: Instant, link: LinkId, connect: Connect, will: Option<LastWill>) {
        let properties = connect.properties.unwrap_or_default();
        let assigned = connect.client_id.is_empty().then(|| {
            self.nameless += 1;
            format!("nameless-{}", self.nameless)
        });
        let client: ClientId = Arc::from(assigned.as_deref().unwrap_or(&connect.client_id));
        if let Some(old) = self.sessions.get(&client).and_then(|session| session.link) {
            self.counts.takeovers += 1;
            self.dismiss(now, old, DisconnectReasonCode::SessionTakenOver);
        }
        let session_present =
            !connect.clean_start && self.sessions.get(&client).is_some_and(|session| !session.has_ended(now));
        if !session_present {
            self.forget_session(&client);
        }
        self.sessions.entry(client.clone()).or_default().begin(link, &properties, &self.limits);
        let patience = (connect.keep_alive > 0).then(|| Duration::from_millis(1500 * u64::from(connect.keep_alive)));
        self.timers.extend(patience.map(|patience| (now + patience, link)));
        let will = will.map(will_as_publish);
        self.links.insert(link, Link { client: client.clone(), will, patience, heard: now });
        self.counts.connections += 1;
        let properties = Some(self.promises(assigned));
        let ack = ConnAck { session_present, code: ConnectReturnCode::Success, properties };
        self.send(link, Packet::ConnAck(ack));
        self.flush(now, &client);
    }

    /// What the broker states when it accepts a connection.
    fn promises(&self, assigned: Option<String>) -> ConnAckProperties {
        ConnAckProperties {
            session_expiry_interval: None,
            receive_max: Some(self.limits.in_flight_max),
            max_qos: Some(QoS::AtLeastOnce as u8),
            retain_available: Some(1),
            max_packet_size: Some(self.limits.packet_bytes_max),
            assigned_client_identifier: assigned,
            topic_alias_max: None,
            reason_string: None,
            user_properties: Vec::new(),
            wildcard_subscription_available: Some(1),
            subscription_identifiers_available: Some(0),
            shared_subscription_available: Some(0),
            server_keep_alive: None,
            response_information: None,
            server_reference: None,
            authentication_method: None,
            authentication_data: None,
        }
    }

    /// The client says farewell.
    pub(super) fn farewell(&mut self, now: Instant, link: LinkId, client: &ClientId, disconnect: &Disconnect) {
        let expiry_s = disconnect.properties.as_ref().and_then(|properties| properties.session_expiry_interval);
        if let (Some(seconds), Some(session)) = (expiry_s, self.sessions.get_mut(client)) {
            session.live_for(seconds);
        }
        self.leave(now, link, disconnect.reason_code != DisconnectReasonCode::NormalDisconnection);
        self.end(link);
    }

    /// Ends a connection, and tells the client why.
    pub(super) fn dismiss(&mut self, now: Instant, link: LinkId, reason: DisconnectReasonCode) {
        self.send(link, Packet::Disconnect(Disconnect::new(reason)));
        self.end(link);
        self.leave(now, link, true);
    }

    /// The connection is over. Its client is not told.
    pub(super) fn leave(&mut self, now: Instant, link: LinkId, publishes_will: bool) {
        let Some(Link { client, will, .. }) = self.links.remove(&link) else { return };
        if let Some(session) = self.sessions.get_mut(&client) {
            session.leave(now);
            if session.has_ended(now) {
                self.forget_session(&client);
            }
        }
        if let Some(will) = will.filter(|_| publishes_will) {
            self.counts.wills += 1;
            self.accept(now, &client, will);
        }
    }

    /// Ends a session with its subscriptions.
    pub(super) fn forget_session(&mut self, client: &ClientId) {
        self.sessions.remove(client);
        self.subscriptions.forget(client);
    }

    /// Whether this is a connection that was accepted and has not ended.
    pub(in crate::broker) fn knows(&self, link: LinkId) -> bool {
        self.links.contains_key(&link)
    }

    /// Connections of this client, or all.
    pub(in crate::broker) fn links_of(&self, client: Option<&str>) -> Vec<LinkId> {
        match client {
            None => self.links.keys().copied().collect(),
            Some(client) => self.sessions.get(client).and_then(|session| session.link).into_iter().collect(),
        }
    }

    /// Client ids of all connections.
    pub(in crate::broker) fn clients(&self) -> Vec<String> {
        let connected = self.sessions.iter().filter(|(_, session)| session.link.is_some());
        connected.map(|(client, _)| client.to_string()).collect()
    }

    /// Ends all connections without wills, and forgets the sessions that do not outlive them.
    pub(in crate::broker) fn restart(&mut self, now: Instant, forgets_everything: bool) {
        self.counts.restarts += 1;
        for link in self.links_of(None) {
            self.leave(now, link, false);
        }
        self.timers.clear();
        if forgets_everything {
            for client in self.sessions.keys().cloned().collect::<Vec<_>>() {
                self.forget_session(&client);
            }
            self.retained.clear();
        }
    }
}
