//! The partitioned log: addresses, credentials and topics.

use super::choices::{IngestArg, LogArg, PublishContactsArg, SaslArg};
use super::keys::Key;
use super::reader::Reader;
use vibrissa_supervisor::kafka_options::{EventTopics, KafkaCredentials, KafkaOptions, is_topic, topic_of};

/// Keys that have an effect only if the log is used.
const KEYS: [Key; 4] = [Key::KafkaUrl, Key::KafkaUsername, Key::KafkaPasswordFile, Key::KafkaCaFile];

/// Settings of the log; without addresses if it is not used.
pub(super) fn kafka(reader: &mut Reader) -> Option<KafkaOptions> {
    let (publish, ingest) = (reader.word::<LogArg>(Key::Publish), reader.word::<IngestArg>(Key::Ingest));
    let ingest_topic = reader.parsed(Key::KafkaIngestTopic, |text| {
        let what = "must be the name of a topic: 1 to 249 letters, digits, dots, underscores or dashes, and {fleet} for \
                    the name of the fleet, of up to 64 characters";
        let longest = topic_of(text, &"f".repeat(64));
        is_topic(&longest).then(|| text.to_owned()).ok_or(what)
    });
    let url = reader.parsed(Key::KafkaUrl, addresses);
    let (events, contacts) = (topic(reader, Key::KafkaEventsTopic), topic(reader, Key::KafkaContactsTopic));
    let publish_contacts = reader.word::<PublishContactsArg>(Key::KafkaPublishContacts);
    let waiting_mib_max = reader.whole(Key::KafkaWaitingMibMax);
    let credentials = credentials(reader);
    let ca_file = reader.file(Key::KafkaCaFile);
    let (publishes, ingests) = (publish? == LogArg::Kafka, ingest? == IngestArg::Kafka);
    for key in KEYS.into_iter().filter(|_| !publishes && !ingests) {
        if reader.is_explicit(key) {
            reader.refuse(key, "has no effect without publish = \"kafka\" or ingest = \"kafka\"");
        }
    }
    if !publishes && !ingests {
        return Some(KafkaOptions::default());
    }
    let user = if publishes { Key::Publish } else { Key::Ingest };
    if !cfg!(feature = "kafka") {
        let what = "this program was built without Kafka: build it with --features kafka, or leave the key out";
        reader.refuse(user, what);
        return None;
    }
    if !reader.is_explicit(Key::KafkaUrl) {
        reader.refuse(user, "needs kafka.url, such as kafka://HOST:9092");
    }
    let Addresses { brokers, is_encrypted } = url?;
    if !is_encrypted && reader.is_explicit(Key::KafkaCaFile) {
        reader.refuse(Key::KafkaCaFile, "has no effect on a plain-text connection: write kafka.url with kafkas://");
    }
    let contacts = contacts?;
    let topics = EventTopics {
        events: events?,
        contacts: (publish_contacts? == PublishContactsArg::All).then_some(contacts),
        waiting_mib_max: waiting_mib_max?,
    };
    let (publish, ingest) = (publishes.then_some(topics), ingest_topic.filter(|_| ingests));
    Some(KafkaOptions { brokers, is_encrypted, ca_file, credentials, publish, ingest })
}

fn topic(reader: &mut Reader, key: Key) -> Option<String> {
    reader.parsed(key, |text| {
        let what = "must be the name of a topic: 1 to 249 letters, digits, dots, underscores or dashes";
        is_topic(text).then(|| text.to_owned()).ok_or(what)
    })
}

fn credentials(reader: &mut Reader) -> Option<KafkaCredentials> {
    let (username, password) = (reader.text(Key::KafkaUsername), reader.secret_file(Key::KafkaPasswordFile));
    let mechanism = reader.word::<SaslArg>(Key::KafkaSasl);
    let keys = [Key::KafkaUsername, Key::KafkaPasswordFile];
    for (key, other) in [(keys[0], keys[1]), (keys[1], keys[0])] {
        if reader.is_explicit(key) && !reader.is_explicit(other) {
            reader.refuse(key, format!("has no effect alone: set {other} too"));
        }
    }
    Some(KafkaCredentials { mechanism: mechanism?.into(), username: username?, password: password? })
}

/// The brokers of a URL.
#[derive(Debug, PartialEq)]
struct Addresses {
    brokers: Vec<String>,
    is_encrypted: bool,
}

/// Reads `kafka://HOST:PORT,HOST:PORT`, or the same with `kafkas://`.
fn addresses(text: &str) -> Result<Addresses, String> {
    let example = "write kafka://HOST:9092,HOST:9092, or kafkas:// for TLS";
    let (list, is_encrypted) = match (text.strip_prefix("kafka://"), text.strip_prefix("kafkas://")) {
        (Some(list), _) => (list, false),
        (None, Some(list)) => (list, true),
        (None, None) => return Err(format!("must begin with kafka:// or kafkas://: {example}")),
    };
    let mut brokers = Vec::new();
    for broker in list.trim_end_matches('/').split(',').map(str::trim) {
        if broker.contains('@') {
            return Err("must not hold a password: set kafka.username and kafka.password_file instead".to_owned());
        }
        let parts = broker.rsplit_once(':').filter(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
        if parts.is_none() || broker.contains(['/', '?', '#']) {
            return Err(format!("must name a host and a port for each broker: {example}"));
        }
        brokers.push(broker.to_owned());
    }
    Ok(Addresses { brokers, is_encrypted })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_url_names_brokers_with_ports() {
        let read = |brokers: &[&str], is_encrypted| {
            Ok(Addresses { brokers: brokers.iter().map(|&broker| broker.to_owned()).collect(), is_encrypted })
        };
        assert_eq!(addresses("kafka://a:9092, b:9093/"), read(&["a:9092", "b:9093"], false));
        assert_eq!(addresses("kafkas://[::1]:9092"), read(&["[::1]:9092"], true));
        for (bad, expected) in [
            ("a:9092", "must begin with"),
            ("kafka://a", "host and a port"),
            ("kafka://", "host and a port"),
            ("kafka://a:9092,", "host and a port"),
            ("kafka://a:b", "host and a port"),
            ("kafka://a:1/x", "host and a port"),
            ("kafka://u:hunter2@a:1", "kafka.password_file"),
        ] {
            let problem = addresses(bad).unwrap_err();
            assert!(problem.contains(expected) && !problem.contains("hunter2"), "{bad}: {problem}");
        }
    }
}
