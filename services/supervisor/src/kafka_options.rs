//! Settings of the partitioned log.

use std::path::PathBuf;

use vibrissa_store::secret::Secret;

/// How clients name themselves to the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SaslMechanism {
    /// The password itself; only over TLS.
    Plain,
    /// A proof of the password, with SHA-256.
    ScramSha256,
    /// A proof of the password, with SHA-512.
    ScramSha512,
}

/// User name and password.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KafkaCredentials {
    /// Mechanism of the log.
    pub mechanism: SaslMechanism,
    /// User name.
    pub username: String,
    /// Password.
    pub password: Secret,
}

/// Settings of the partitioned log.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KafkaOptions {
    /// Addresses of some brokers, `HOST:PORT`; the others are learned from them.
    pub brokers: Vec<String>,
    /// Whether connections are encrypted.
    pub is_encrypted: bool,
    /// Certificates (PEM) that may sign those of the brokers; `None` for the system's.
    pub ca_file: Option<PathBuf>,
    /// User name and password, if the brokers require them.
    pub credentials: Option<KafkaCredentials>,
    /// Topics of events; `None` if none are published.
    pub publish: Option<EventTopics>,
    /// Topic of contacts and statuses, in which `{fleet}` stands for the name of the fleet; `None` if they come over MQTT.
    pub ingest: Option<String>,
}

/// Topics of published events, and the limit of those that wait.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EventTopics {
    /// Topic of all events but contacts.
    pub events: String,
    /// Topic of contacts; `None` if these are not published.
    pub contacts: Option<String>,
    /// MiB of a fleet's waiting events from which its contacts are left out.
    pub waiting_mib_max: u32,
}

/// The topic of a fleet: `{fleet}` stands for its name.
#[must_use]
pub fn topic_of(topic: &str, fleet: &str) -> String {
    topic.replace("{fleet}", fleet)
}

/// Whether a text can be the name of a topic.
#[must_use]
pub fn is_topic(text: &str) -> bool {
    let is_good = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    (1..=249).contains(&text.len()) && text.bytes().all(is_good) && text != "." && text != ".."
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_have_letters_digits_dots_and_dashes() {
        for good in ["vibrissa.events", "a", "A_b-9"] {
            assert!(is_topic(good), "{good}");
        }
        for bad in ["", ".", "..", "a b", "a/b", "\u{e4}", &"a".repeat(250)] {
            assert!(!is_topic(bad), "{bad}");
        }
    }
}
