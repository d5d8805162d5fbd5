//! Why Apache Kafka fails, with what to do: the errors of `rskafka`.

use rskafka::client::error::{Error, ProtocolError};
use vibrissa_protocol::plain;

/// Why an operation fails.
pub(super) fn cause(problem: &Error) -> String {
    if let Error::ServerError { protocol_error, error_message, .. } = problem {
        let said = error_message.as_ref().map(|said| format!("; it says {said:?}")).unwrap_or_default();
        return format!("{}{said}", of_protocol(protocol_error));
    }
    // The library's other errors differ only by their texts, which contain those of their causes.
    let text = problem.to_string();
    let has = |parts: &[&str]| parts.iter().any(|part| text.contains(part));
    if let Some((_, defect)) = text.split_once("invalid peer certificate: ") {
        return plain::certificate(defect);
    }
    let remedy = if has(&["onnection refused"]) {
        "no broker listens there: start the brokers, or correct kafka.url"
    } else if has(&["lookup address", "Name or service", "No address"]) {
        "no address is known for a broker: correct kafka.url, the brokers' advertised.listeners, or DNS"
    } else if has(&["timed out", "Timeout", "deadline"]) && !has(&["eof", "reset", "Broken pipe", "InvalidMessage"]) {
        "no broker answers in time: check the network, firewalls and the brokers' advertised.listeners"
    } else if has(&[
        "eof",
        "Eof",
        "EOF",
        "reset",
        "Broken pipe",
        "InvalidMessage",
        "InvalidContentType",
        "corrupt message",
    ]) {
        "a broker closes the connection, or does not answer in the protocol expected: check that kafka.url has the port \
         with TLS exactly if kafka.tls is on, and that SASL is on at both sides"
    } else if has(&["matching version", "ApiVersion"]) {
        "a broker is too old: docs/kafka.md names the oldest version"
    } else {
        return plain::text(&text);
    };
    remedy.to_owned()
}

/// Why TLS cannot be used.
pub(super) fn of_tls(problem: &rustls::Error) -> String {
    plain::tls(&format!("{problem:?}"))
}

fn of_protocol(problem: &ProtocolError) -> String {
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "a hundred codes: the others are about what this program does not do"
    )]
    let remedy = match problem {
        ProtocolError::TopicAuthorizationFailed => {
            "this user may not use the topic: allow reading and writing in its ACL"
        }
        ProtocolError::GroupAuthorizationFailed => "this user may not use the group: allow it in its ACL",
        ProtocolError::ClusterAuthorizationFailed => "this user may not do it in the cluster: allow it in its ACL",
        ProtocolError::SaslAuthenticationFailed => "the user or the password is wrong: correct them",
        ProtocolError::UnsupportedSaslMechanism => "the brokers lack this mechanism of SASL: correct kafka.sasl",
        ProtocolError::UnknownTopicOrPartition => {
            "the topic or its partition does not exist: create it, see docs/kafka.md"
        }
        ProtocolError::MessageTooLarge | ProtocolError::RecordListTooLarge => {
            "a record is too large: raise the topic's max.message.bytes"
        }
        ProtocolError::InvalidTimestamp => {
            "a record's time is refused: correct the clocks, or the topic's limits of times"
        }
        ProtocolError::OffsetOutOfRange => "the records at this position are deleted: lengthen the topic's retention",
        ProtocolError::NotEnoughReplicas | ProtocolError::NotEnoughReplicasAfterAppend => {
            "too few replicas are in sync: start the missing brokers"
        }
        ProtocolError::LeaderNotAvailable
        | ProtocolError::NotLeaderOrFollower
        | ProtocolError::BrokerNotAvailable
        | ProtocolError::ReplicaNotAvailable
        | ProtocolError::NetworkException
        | ProtocolError::RequestTimedOut => "the partition has no leader now: it goes away, unless a broker stays away",
        ProtocolError::KafkaStorageError | ProtocolError::LogDirNotFound => "a broker's disk fails: look at its log",
        ProtocolError::CorruptMessage | ProtocolError::InvalidRecord => "a record is damaged: look at the broker's log",
        ProtocolError::PolicyViolation => "a policy of the brokers forbids it: ask their administrator",
        ProtocolError::ThrottlingQuotaExceeded => "a quota is used up: raise the quota of this user",
        other => return format!("the brokers refuse it ({}): look at their log", plain::name(&format!("{other:?}"))),
    };
    remedy.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_each_cause_has_a_remedy_and_no_words_of_the_library() {
        for code in [
            ProtocolError::TopicAuthorizationFailed,
            ProtocolError::UnknownTopicOrPartition,
            ProtocolError::NotLeaderOrFollower,
            ProtocolError::MessageTooLarge,
            ProtocolError::FencedLeaderEpoch,
        ] {
            let shown = of_protocol(&code);
            assert!(shown.contains(": ") && !shown.contains(&format!("{code:?}")), "{shown}");
        }
        assert!(of_protocol(&ProtocolError::FencedLeaderEpoch).contains("(fenced leader epoch)"));
        let refused = "all retries failed: error connecting to broker \"b:1\": Connection refused (os error 111)";
        for (text, part) in [(refused, "start the brokers"), ("early eof", "TLS"), ("x (os error 5)", "x")] {
            let shown = cause(&Error::InvalidResponse(text.to_owned()));
            assert!(shown.contains(part) && !shown.contains("os error"), "{shown}");
        }
    }
}
