//! Reason codes of MQTT 5 (section 2.4), by the names that clients give them.

use super::{variant, words};

/// Why a broker refuses something or ends a connection, and what to do. `debug` is the `Debug` output of the reason code.
#[must_use]
pub fn reason_code(debug: &str) -> String {
    let text = match variant(debug) {
        "UnspecifiedError" | "Unspecified" | "Failure" | "ImplementationSpecificError" | "ImplementationSpecific" => {
            "for a reason that it does not tell: look at the broker's log"
        }
        "MalformedPacket" | "ProtocolError" | "PayloadFormatInvalid" => {
            "because it does not understand a packet: look at the broker's log, and update the broker"
        }
        "BadUserNamePassword" | "BadAuthenticationMethod" => "because of the user or the password: correct them",
        "NotAuthorized" => "because this user may not do it: allow it in the broker's access list",
        "ClientIdentifierNotValid" | "BadClientId" => {
            "because of the client identifier: let the broker accept identifiers of up to 64 letters, digits and hyphens"
        }
        "UnsupportedProtocolVersion" | "RefusedProtocolVersion" => {
            "because it does not support MQTT 5: use one that does"
        }
        "ServerUnavailable" | "ServiceUnavailable" => "because it is not available: wait, or look at the broker's log",
        "ServerBusy" => "because it is busy: wait, or give the broker more resources",
        "ServerShuttingDown" => "because it is stopping: start it again",
        "Banned" => "because this client is banned: lift the ban at the broker",
        "TopicNameInvalid" | "TopicFilterInvalid" => "because of the topic: let the broker allow whisker/v1/#",
        "PacketTooLarge" => {
            "because a packet is larger than the broker allows: raise its limit of the packet size to at least 300 kB"
        }
        "QuotaExceeded" => "because a quota is used up: raise the broker's limits of this user",
        "ConnectionRateExceeded" | "MessageRateTooHigh" => {
            "because there are more messages or connections per second than it allows: raise the broker's limit of the rate"
        }
        "RetainNotSupported" => "because it retains no messages: allow retained messages at the broker",
        "QoSNotSupported" => "because it lacks the quality of service 1: allow it at the broker",
        "UseAnotherServer" | "ServerMoved" => "because clients shall use another server: correct the broker's URL",
        "KeepAliveTimeout" => "because it heard nothing for too long: check the network",
        "SessionTakenOver" => "because another client has connected with the same identifier: give each its own",
        "ReceiveMaximumExceeded" => "because more messages were under way than it allows: raise its receive maximum",
        "TopicAliasInvalid" => "because it refuses a topic alias: update the broker",
        "AdministrativeAction" => "because an administrator has ended it: ask the broker's administrator",
        "PkidInUse" | "PacketIdentifierInUse" => {
            "because a packet identifier is in use: it goes away with a new connection"
        }
        "SharedSubscriptionsNotSupported" | "SubscriptionIdNotSupported" | "WildcardSubscriptionsNotSupported" => {
            "because it lacks subscriptions with wildcards or identifiers: allow them at the broker"
        }
        other => return format!("with the reason {}: look at the broker's log", words(other)),
    };
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reason_has_a_remedy_and_not_the_name_of_the_code() {
        for code in
            ["QuotaExceeded", "ServerBusy", "Banned", "QoSNotSupported", "NotAuthorized", "Success(AtLeastOnce)"]
        {
            let text = reason_code(code);
            assert!(text.contains(": ") && !text.contains(variant(code)), "{code}: {text}");
        }
    }
}
