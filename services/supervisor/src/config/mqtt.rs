//! The broker: where it is, and how to know it and be known.

use url::Url;

use super::keys::Key;
use super::reader::Reader;
use crate::mqtt::{BrokerAddress, ClientCertificate, Credentials, TlsOptions};

/// What only an encrypted connection has a use for.
const TLS_KEYS: [Key; 3] = [Key::MqttCaFile, Key::MqttClientCertificateFile, Key::MqttClientKeyFile];
/// What only a broker that asks has a use for.
const CREDENTIAL_KEYS: [Key; 3] = [Key::MqttUsername, Key::MqttPassword, Key::MqttPasswordFile];

/// The external broker, if there is one.
pub(super) fn broker(reader: &mut Reader) -> Option<BrokerAddress> {
    let is_external = reader.is_explicit(Key::MqttUrl);
    let found = reader.parsed(Key::MqttUrl, place);
    let credentials = credentials(reader);
    let (ca_file, client) = (reader.file(Key::MqttCaFile), client(reader));
    if !is_external {
        for key in CREDENTIAL_KEYS.into_iter().chain(TLS_KEYS) {
            if reader.is_explicit(key) {
                reader.refuse(key, "is of no use without mqtt.url: only an external broker asks for it");
            }
        }
    }
    if is_external && reader.is_explicit(Key::MqttPort) {
        let what = "is the embedded broker's, but mqtt.url names an external one: leave one of them out, \
                    or write the external broker's port into mqtt.url";
        reader.refuse(Key::MqttPort, what);
    }
    let place = found?;
    if !place.is_tls {
        for key in TLS_KEYS {
            if reader.is_explicit(key) {
                reader.refuse(key, "is of no use on a connection in plain text: write mqtt.url with mqtts://");
            }
        }
    }
    let tls = place.is_tls.then_some(TlsOptions { ca_file, client });
    Some(BrokerAddress { host: place.host, port: place.port, credentials, tls })
}

fn credentials(reader: &mut Reader) -> Option<Credentials> {
    let username = reader.text(Key::MqttUsername);
    let written = reader.secret(Key::MqttPassword);
    let filed = reader.secret_file(Key::MqttPasswordFile);
    let is_set = CREDENTIAL_KEYS.map(|key| reader.is_explicit(key));
    let [has_username, is_written, is_filed] = is_set;
    if is_written && is_filed {
        reader.refuse(Key::MqttPasswordFile, "mqtt.password is set too: leave one of them out");
    }
    if has_username && !is_written && !is_filed {
        reader.refuse(Key::MqttUsername, "needs a password: set mqtt.password_file or mqtt.password");
    }
    if !has_username && (is_written || is_filed) {
        let key = if is_written { Key::MqttPassword } else { Key::MqttPasswordFile };
        reader.refuse(key, "needs a user: set mqtt.username");
    }
    Some(Credentials { username: username?, password: written.or(filed)? })
}

fn client(reader: &mut Reader) -> Option<ClientCertificate> {
    let keys = [Key::MqttClientCertificateFile, Key::MqttClientKeyFile];
    let [certificate_file, key_file] = keys.map(|key| reader.file(key));
    for (key, other) in [(keys[0], keys[1]), (keys[1], keys[0])] {
        if reader.is_explicit(key) && !reader.is_explicit(other) {
            reader.refuse(key, format!("is of no use alone: set {other} too"));
        }
    }
    Some(ClientCertificate { certificate_file: certificate_file?, key_file: key_file? })
}

/// What a URL says of a broker.
#[derive(Debug, PartialEq, Eq)]
struct Place {
    host: String,
    port: u16,
    is_tls: bool,
}

/// The text may hold a password by mistake: no part of it comes back in the error.
fn place(text: &str) -> Result<Place, String> {
    const LOOKS: &str = "write mqtt://HOST:1883, or mqtts://HOST:8883 for TLS";
    let bad = |why: &str| format!("not a broker's URL ({why}): {LOOKS}");
    let url = Url::parse(text).map_err(|problem| bad(&problem.to_string()))?;
    let (is_tls, port) = match url.scheme() {
        "mqtt" => (false, 1883),
        "mqtts" => (true, 8883),
        _ => return Err(bad("neither mqtt:// nor mqtts://")),
    };
    if !url.username().is_empty() || url.password().is_some() {
        return Err("must not hold a user or password, which others would see: \
                    set mqtt.username and mqtt.password_file instead"
            .to_owned());
    }
    if !matches!(url.path(), "" | "/") || url.query().is_some() || url.fragment().is_some() {
        return Err(bad("something follows the port"));
    }
    let host = url.host_str().unwrap_or_default();
    // What needs an escape is no host's name.
    if host.is_empty() || host.contains('%') {
        return Err(bad("no host"));
    }
    let port = url.port().unwrap_or(port);
    if port == 0 {
        return Err(bad("port 0"));
    }
    Ok(Place { host: host.trim_matches(['[', ']']).to_owned(), port, is_tls })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_brokers_url_has_a_scheme_a_host_and_perhaps_a_port() {
        let says = |text: &str| place(text).map(|place| (place.host, place.port, place.is_tls));
        assert_eq!(says("mqtt://h:1884"), Ok(("h".to_owned(), 1884, false)));
        assert_eq!(says("mqtt://h"), Ok(("h".to_owned(), 1883, false)));
        assert_eq!(says("mqtts://h/"), Ok(("h".to_owned(), 8883, true)));
        assert_eq!(says("mqtts://[::1]:1885/"), Ok(("::1".to_owned(), 1885, true)));
        let bad = ["", "h:1883", "h", "mqtt://", "mqtt:", "mqtt:h", "mqtt://h:x", "mqtt://h:0", "mqtt://h:70000"];
        for bad in bad.into_iter().chain(["http://h", "mqtt://h/x", "mqtt://h?x", "mqtt://h#x", "mqtt://a b"]) {
            let problem = says(bad).unwrap_err();
            assert!(problem.contains("mqtts://HOST:8883"), "{bad}: {problem}");
        }
    }

    #[test]
    fn a_password_in_the_url_is_refused_and_not_repeated() {
        for bad in ["mqtt://u:hunter2@h", "mqtts://u:hunter2@h:8883/", "mqtt://hunter2@h", "http://u:hunter2@h"] {
            let problem = place(bad).unwrap_err();
            assert!(!problem.contains("hunter2"), "{problem}");
        }
        assert!(place("mqtt://u:p@h").unwrap_err().contains("mqtt.username"));
    }
}
