//! Publications, subscriptions, retained messages and deliveries.

use std::ops::Bound;

use rumqttc::{
    DisconnectReasonCode, Packet, PubAck, PubAckReason, Publish, QoS, RetainForwardRule, SubAck, Subscribe,
    SubscribeFilter, SubscribeReasonCode, UnsubAck, UnsubAckReason, Unsubscribe, matches, valid_filter, valid_topic,
};
use tokio::time::Instant;

use super::{LinkId, Machine};
use crate::broker::message::{ClientId, Delivery, Message};
use crate::broker::subscriptions::Grant;

impl Machine {
    pub(super) fn publish(&mut self, now: Instant, link: LinkId, client: &ClientId, publish: Publish) {
        let is_topic = std::str::from_utf8(&publish.topic).is_ok_and(|topic| !topic.is_empty() && valid_topic(topic));
        let fault = if publish.size() > self.limits.packet_bytes_max as usize {
            Some(DisconnectReasonCode::PacketTooLarge)
        } else if publish.qos == QoS::ExactlyOnce {
            Some(DisconnectReasonCode::QoSNotSupported)
        } else if publish.properties.as_ref().is_some_and(|properties| properties.topic_alias.is_some()) {
            Some(DisconnectReasonCode::TopicAliasInvalid)
        } else {
            (!is_topic).then_some(DisconnectReasonCode::TopicNameInvalid)
        };
        if let Some(reason) = fault {
            self.dismiss(now, link, reason);
            return;
        }
        let (qos, id) = (publish.qos, publish.pkid);
        let reason = self.accept(now, client, publish);
        if qos == QoS::AtLeastOnce {
            let ack = PubAck { pkid: id, reason, properties: None };
            self.send(link, Packet::PubAck(ack));
        }
    }

    /// Publishes a message or a will, unless its topic is refused.
    pub(super) fn accept(&mut self, now: Instant, client: &ClientId, publish: Publish) -> PubAckReason {
        let message = Message::new(now, client.clone(), publish);
        let topic = message.topic();
        if self.faults.refused.iter().any(|filter| matches(topic, filter)) {
            self.counts.refused_publications += 1;
            return PubAckReason::NotAuthorized;
        }
        self.counts.published += 1;
        self.observe(now, client, &message.publish, None);
        if message.publish.retain && message.publish.payload.is_empty() {
            self.retained.remove(topic);
        } else if message.publish.retain {
            self.retained.insert(topic.to_owned(), message.clone());
        }
        let receivers = self.subscriptions.receivers(topic, client);
        let reason = if receivers.is_empty() { PubAckReason::NoMatchingSubscribers } else { PubAckReason::Success };
        for (receiver, grant) in receivers {
            self.deliver(now, &receiver, &message, grant.qos, message.publish.retain && grant.keeps_retain);
        }
        reason
    }

    fn deliver(&mut self, now: Instant, to: &ClientId, message: &Message, granted: QoS, retain: bool) {
        let Some(session) = self.sessions.get(to) else { return };
        if session.has_ended(now) {
            self.forget_session(to);
            return;
        }
        let is_away = session.link.is_none();
        let is_once = granted == QoS::AtLeastOnce && message.publish.qos == QoS::AtLeastOnce;
        let qos = if is_once { QoS::AtLeastOnce } else { QoS::AtMostOnce };
        // As Mosquitto does without queue_qos0_messages.
        if is_away && !is_once {
            return;
        }
        if !is_once && self.draw(self.faults.loss) {
            self.counts.lost += 1;
            return;
        }
        let is_repeated = is_once && self.draw(self.faults.repetition);
        let Some(session) = self.sessions.get_mut(to) else { return };
        let delivery = Delivery { message: message.clone(), qos, retain, dup: false, id: None };
        session.push(delivery.clone(), &self.limits, &mut self.counts);
        if is_repeated {
            self.counts.repeated += 1;
            session.push(Delivery { dup: true, ..delivery }, &self.limits, &mut self.counts);
        }
        self.flush(now, to);
    }

    /// Sends what waits for a client, as far as its window allows.
    pub(super) fn flush(&mut self, now: Instant, to: &ClientId) {
        while let Some(session) = self.sessions.get_mut(to)
            && let Some(link) = session.link
            && let Some((publish, from)) = session.next(now, &mut self.counts)
        {
            self.counts.delivered += 1;
            self.observe(now, &from, &publish, Some(to));
            self.send(link, Packet::Publish(publish));
        }
    }

    pub(super) fn subscribe(&mut self, now: Instant, link: LinkId, client: &ClientId, subscribe: Subscribe) {
        let mut wanted = Vec::new();
        let mut return_codes = Vec::new();
        for filter in subscribe.filters {
            if filter.path.starts_with("$share/") {
                return_codes.push(SubscribeReasonCode::SharedSubscriptionsNotSupported);
                continue;
            }
            if !valid_filter(&filter.path) {
                return_codes.push(SubscribeReasonCode::TopicFilterInvalid);
                continue;
            }
            let SubscribeFilter { path, nolocal, preserve_retain, retain_forward_rule, .. } = filter;
            // QoS 2 is lowered to 1.
            let qos = if filter.qos == QoS::AtMostOnce { QoS::AtMostOnce } else { QoS::AtLeastOnce };
            let grant = Grant { qos, is_no_local: nolocal, keeps_retain: preserve_retain };
            let is_new = self.subscriptions.add(&path, client, grant);
            return_codes.push(SubscribeReasonCode::Success(qos));
            let wants_retained = match retain_forward_rule {
                RetainForwardRule::OnEverySubscribe => true,
                RetainForwardRule::OnNewSubscribe => is_new,
                RetainForwardRule::Never => false,
            };
            wanted.extend(wants_retained.then_some((path, qos)));
        }
        let ack = SubAck { pkid: subscribe.pkid, return_codes, properties: None };
        self.send(link, Packet::SubAck(ack));
        for (filter, qos) in wanted {
            for topic in self.retained_on(&filter) {
                self.deliver_retained(now, client, &topic, qos);
            }
        }
    }

    fn deliver_retained(&mut self, now: Instant, client: &ClientId, topic: &str, qos: QoS) {
        let Some(message) = self.retained.get(topic).cloned() else { return };
        if message.has_expired(now) {
            self.counts.expired += 1;
            self.retained.remove(topic);
            return;
        }
        self.deliver(now, client, &message, qos, true);
    }

    /// Topics with a retained message that a filter matches.
    fn retained_on(&self, filter: &str) -> Vec<String> {
        // `a/#` matches `a`, too.
        let literal = filter.split(['+', '#']).next().unwrap_or_default().trim_end_matches('/');
        let from = self.retained.range::<str, _>((Bound::Included(literal), Bound::Unbounded));
        let near = from.map(|(topic, _)| topic).take_while(|topic| topic.starts_with(literal));
        near.filter(|topic| matches(topic, filter)).cloned().collect()
    }

    pub(super) fn unsubscribe(&mut self, link: LinkId, client: &ClientId, unsubscribe: Unsubscribe) {
        let ended = |filter: &String| match self.subscriptions.remove(filter, client) {
            true => UnsubAckReason::Success,
            false => UnsubAckReason::NoSubscriptionExisted,
        };
        let reasons = unsubscribe.filters.iter().map(ended).collect();
        let ack = UnsubAck { pkid: unsubscribe.pkid, reasons, properties: None };
        self.send(link, Packet::UnsubAck(ack));
    }

    /// Loses all subscriptions of a client, which stays connected.
    pub(in crate::broker) fn forget_subscriptions(&mut self, client: &str) {
        self.counts.forgotten_subscriptions += self.subscriptions.forget(&ClientId::from(client)) as u64;
    }

    /// Loses the retained messages that a filter matches.
    pub(in crate::broker) fn forget_retained(&mut self, filter: &str) {
        for topic in self.retained_on(filter) {
            self.retained.remove(&topic);
            self.counts.forgotten_retained += 1;
        }
    }
}
