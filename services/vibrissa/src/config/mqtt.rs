//! The broker: address, TLS and credentials.

use std::str::FromStr;
use std::time::Duration;

use super::keys::Key;
use super::reader::Reader;
use vibrissa_supervisor::mqtt::{BrokerAddress, ClientCertificate, Credentials, TlsOptions};

/// Keys that have an effect only on an encrypted connection.
const TLS_KEYS: [Key; 3] = [Key::MqttCaFile, Key::MqttClientCertificateFile, Key::MqttClientKeyFile];
/// Keys of user name and password: for the external broker, or of the embedded one.
const CREDENTIAL_KEYS: [Key; 3] = [Key::MqttUsername, Key::MqttPassword, Key::MqttPasswordFile];

/// The external broker, if configured, and the credentials of the embedded one, if there are any.
pub(super) fn broker(reader: &mut Reader) -> (Option<BrokerAddress>, Option<Credentials>) {
    let credentials = credentials(reader);
    let embedded = if reader.is_explicit(Key::MqttUrl) { None } else { credentials.clone() };
    (external(reader, credentials), embedded)
}

fn external(reader: &mut Reader, credentials: Option<Credentials>) -> Option<BrokerAddress> {
    let is_external = reader.is_explicit(Key::MqttUrl);
    let found = reader.parsed(Key::MqttUrl, |text| BrokerAddress::from_str(text).map_err(|bad| bad.to_string()));
    let (ca_file, client) = (reader.file(Key::MqttCaFile), client(reader));
    let deaf_release_after = reader.number(Key::MqttDeafReleaseAfterS).map(Duration::from_secs_f64);
    if !is_external {
        for key in TLS_KEYS {
            if reader.is_explicit(key) {
                reader.refuse(key, "has no effect without mqtt.url: only an external broker requires it");
            }
        }
    }
    if is_external && reader.is_explicit(Key::MqttPort) {
        let what = "is the embedded broker's, but mqtt.url names an external one: leave one of them out, \
                    or write the external broker's port into mqtt.url";
        reader.refuse(Key::MqttPort, what);
    }
    let broker = found?;
    if broker.tls.is_none() {
        for key in TLS_KEYS {
            if reader.is_explicit(key) {
                reader.refuse(key, "has no effect on a plain-text connection: write mqtt.url with mqtts://");
            }
        }
    }
    let tls = broker.tls.is_some().then_some(TlsOptions { ca_file, client });
    Some(BrokerAddress { credentials, tls, deaf_release_after: deaf_release_after?, ..broker })
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
    let (certificate_file, key_file) = (reader.file(keys[0]), reader.private_file(keys[1]));
    for (key, other) in [(keys[0], keys[1]), (keys[1], keys[0])] {
        if reader.is_explicit(key) && !reader.is_explicit(other) {
            reader.refuse(key, format!("has no effect alone: set {other} too"));
        }
    }
    Some(ClientCertificate { certificate_file: certificate_file?, key_file: key_file? })
}
