//! Limits that a broker states when it accepts a connection, as far as they are too low for a fleet.

use rumqttc::ConnAck;
use vibrissa_protocol::PAYLOAD_MAX_BYTES;

use super::link::LowLimit;

/// Size of the largest packet of the contract, in bytes: the largest payload, a topic and properties.
const PACKET_BYTES: u32 = PAYLOAD_MAX_BYTES as u32 + 1024;

/// Packets of fewer bytes are too small for ordinary messages: a factsheet of some two hundred whiskers, or the contacts that
/// a robot sends after an outage.
const ORDINARY_BYTES: u32 = 64 * 1024;

/// Why no fleet can work with this broker.
pub(super) fn unusable(ack: &ConnAck) -> Option<&'static str> {
    let properties = ack.properties.as_ref()?;
    if properties.max_qos == Some(0) {
        return Some(
            "it accepts QoS 0 only, and robots need QoS 1: raise its limit (Mosquitto: max_qos; RMQTT: max_qos_allowed)",
        );
    }
    if properties.wildcard_subscription_available == Some(0) {
        return Some(
            "it does not accept wildcards in subscriptions, such as whisker/v1/FLEET/+/contacts: allow them there",
        );
    }
    None
}

/// A limit that larger robots will exceed.
pub(super) fn low(ack: &ConnAck) -> Option<LowLimit> {
    let limit = ack.properties.as_ref()?.max_packet_size.filter(|&limit| limit < PACKET_BYTES)?;
    let what = format!(
        "it accepts packets of at most {limit} bytes, so larger messages are lost; the contract allows {PACKET_BYTES}: raise \
         its limit (Mosquitto: max_packet_size and message_size_limit; RMQTT: max_packet_size; Artemis: maximumPacketSize)"
    );
    Some(LowLimit { what, is_too_low: limit < ORDINARY_BYTES })
}

#[cfg(test)]
mod tests {
    use rumqttc::{ConnAckProperties, ConnectReturnCode};

    use super::*;

    fn ack(change: impl FnOnce(&mut ConnAckProperties)) -> ConnAck {
        let mut properties = ConnAckProperties {
            session_expiry_interval: None,
            receive_max: None,
            max_qos: None,
            retain_available: None,
            max_packet_size: None,
            assigned_client_identifier: None,
            topic_alias_max: None,
            reason_string: None,
            user_properties: Vec::new(),
            wildcard_subscription_available: None,
            subscription_identifiers_available: None,
            shared_subscription_available: None,
            server_keep_alive: None,
            response_information: None,
            server_reference: None,
            authentication_method: None,
            authentication_data: None,
        };
        change(&mut properties);
        ConnAck { session_present: false, code: ConnectReturnCode::Success, properties: Some(properties) }
    }

    #[test]
    fn a_broker_without_limits_is_good_and_one_without_qos_1_or_wildcards_is_not() {
        assert_eq!((unusable(&ack(|_| {})), low(&ack(|_| {}))), (None, None));
        assert!(unusable(&ack(|it| it.max_qos = Some(1))).is_none());
        assert!(unusable(&ack(|it| it.max_qos = Some(0))).is_some_and(|what| what.contains("max_qos")));
        let without = ack(|it| it.wildcard_subscription_available = Some(0));
        assert!(unusable(&without).is_some_and(|what| what.contains("wildcards")));
    }

    #[test]
    fn a_limit_below_the_largest_message_is_told_with_its_value() {
        assert_eq!(low(&ack(|it| it.max_packet_size = Some(270_336))), None);
        let problem = low(&ack(|it| it.max_packet_size = Some(100_000))).unwrap();
        assert!(problem.what.contains("100000") && problem.what.contains("max_packet_size"), "{problem:?}");
        assert!(!problem.is_too_low && low(&ack(|it| it.max_packet_size = Some(4096))).unwrap().is_too_low);
    }
}
