//! Why a connection fails, as a sentence that names the file or key concerned and what to do.
//!
//! Keys are those of `agent.toml`.

use std::fmt::Display;
use std::io;

use rumqttc::tokio_rustls::rustls::{self, AlertDescription, CertificateError};
use rumqttc::{ConnectReturnCode, ConnectionError, DisconnectReasonCode, StateError, TlsError};

use vibrissa_protocol::plain;

use super::broker::{Authorities, Broker};

/// How far an attempt has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// TCP is not connected.
    Nothing,
    /// TCP is connected.
    Reached,
    /// The broker has accepted the robot.
    Accepted,
}

/// The sentence for an error of the client at the node with this host.
pub(super) fn problem(broker: &Broker, host: &str, error: &ConnectionError, progress: Progress) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: classified by their contents")]
    match error {
        ConnectionError::ConnectionRefused(code) => refused(broker, *code),
        ConnectionError::Timeout(_) if progress == Progress::Nothing => {
            "no answer: check the network, firewalls and broker.url".to_owned()
        }
        ConnectionError::Timeout(_) => {
            "it accepts the connection but says nothing: check whether its port expects TLS (mqtts://) or not (mqtt://)"
                .to_owned()
        }
        ConnectionError::MqttState(StateError::ServerDisconnect {
            reason_code: DisconnectReasonCode::SessionTakenOver,
            ..
        }) => "another client of this name has connected: give each robot a name of its own in agent.toml".to_owned(),
        other => match (tls_of(other), progress) {
            (Some(problem), _) => of_tls(broker, host, problem),
            (None, Progress::Accepted) => format!("the connection broke ({})", short(other)),
            (None, Progress::Nothing) => unreached(other),
            (None, Progress::Reached) => not_mqtt(broker, other),
        },
    }
}

fn refused(broker: &Broker, code: ConnectReturnCode) -> String {
    match (code, &broker.credentials) {
        (
            ConnectReturnCode::BadUserNamePassword
            | ConnectReturnCode::NotAuthorized
            | ConnectReturnCode::BadAuthenticationMethod,
            Some((user, _)),
        ) => format!(
            "it does not accept user {user:?} with the password given: correct broker.username, the file of \
             broker.password_file, or the broker's list of users"
        ),
        (
            ConnectReturnCode::BadUserNamePassword
            | ConnectReturnCode::NotAuthorized
            | ConnectReturnCode::BadAuthenticationMethod,
            None,
        ) => "it requires a user and a password: set broker.username and broker.password_file".to_owned(),
        (ConnectReturnCode::RefusedProtocolVersion | ConnectReturnCode::UnsupportedProtocolVersion, _) => {
            "it does not support MQTT 5: use a broker that does".to_owned()
        }
        (other, _) => format!("it does not accept the connection {}", plain::reason_code(&format!("{other:?}"))),
    }
}

/// The socket's error, which the client wraps in several ways.
fn io_of(error: &ConnectionError) -> Option<&io::Error> {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others contain no socket error")]
    match error {
        ConnectionError::Io(error)
        | ConnectionError::Tls(TlsError::Io(error))
        | ConnectionError::MqttState(StateError::Io(error) | StateError::Deserialization(rumqttc::Error::Io(error))) => {
            Some(error)
        }
        _ => None,
    }
}

/// The TLS error; after the handshake the client wraps it in a socket error.
fn tls_of(error: &ConnectionError) -> Option<&rustls::Error> {
    if let ConnectionError::Tls(TlsError::TLS(error)) = error {
        return Some(error);
    }
    io_of(error)?.get_ref()?.downcast_ref()
}

fn of_tls(broker: &Broker, host: &str, error: &rustls::Error) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no specific advice")]
    match error {
        rustls::Error::InvalidCertificate(problem) => of_certificate(broker, host, problem),
        rustls::Error::InvalidMessage(_) => not_tls(),
        // TLS 1.3 has an alert for it; TLS 1.2 reports a handshake failure.
        rustls::Error::AlertReceived(AlertDescription::CertificateRequired | AlertDescription::HandshakeFailure) => {
            wants_certificate()
        }
        rustls::Error::AlertReceived(alert) => match &broker.client {
            Some(client) => format!(
                "it does not accept the client certificate in {}: {}",
                client.certificate_file.display(),
                plain::alert(&format!("{alert:?}"))
            ),
            None => format!("the TLS handshake failed: {}", plain::alert(&format!("{alert:?}"))),
        },
        other => format!("the TLS handshake failed: {}", plain::tls(&format!("{other:?}"))),
    }
}

fn of_certificate(broker: &Broker, host: &str, problem: &CertificateError) -> String {
    let not_for = |names: &dyn Display| {
        format!(
            "its certificate is not for {host:?}{names}: name such a host in broker.url, or give the broker a \
             certificate for {host:?}"
        )
    };
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no specific advice")]
    match problem {
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            let from = match &broker.tls {
                Some(Authorities::File(path)) => format!("those in {}", path.display()),
                Some(Authorities::System) | None => "this system's".to_owned(),
            };
            format!(
                "its certificate is not signed by a trusted authority ({from}): set broker.ca_file to the certificate \
                 of the broker's authority"
            )
        }
        CertificateError::NotValidForName => not_for(&""),
        CertificateError::NotValidForNameContext { presented, .. } => match plain::host_names(presented) {
            Some(names) => not_for(&format!(" but for {names}")),
            None => format!(
                "its certificate names no host, and its common name (CN) does not count: give the broker a certificate \
                 whose subjectAltName contains {host:?}"
            ),
        },
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "its certificate has expired: renew it, or correct this robot's clock".to_owned()
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "its certificate is not valid yet: correct this robot's clock, or the certificate".to_owned()
        }
        other => format!("its certificate cannot be used: {}", plain::certificate(&format!("{other:?}"))),
    }
}

fn not_tls() -> String {
    "it does not answer in TLS: write mqtt:// in broker.url if it has no TLS, or its port for TLS (usually 8883)"
        .to_owned()
}

fn wants_certificate() -> String {
    "it requires a client certificate: set broker.client_certificate_file and broker.client_key_file to one of an \
     authority that it trusts"
        .to_owned()
}

/// The peer closes the connection, or does not speak MQTT.
fn not_mqtt(broker: &Broker, error: &ConnectionError) -> String {
    match (&broker.tls, &broker.client) {
        (None, _) => {
            "it does not answer as an MQTT broker: write mqtts:// in broker.url if it expects TLS, or correct the port"
                .to_owned()
        }
        (Some(_), _) if matches!(error, ConnectionError::Tls(TlsError::Io(_))) => not_tls(),
        (Some(_), _) if matches!(error, ConnectionError::Tls(_)) => {
            format!("TLS cannot be used: {}", plain::text(&error.to_string()))
        }
        (Some(_), None) => {
            "it closes the encrypted connection without an answer: set broker.client_certificate_file and \
             broker.client_key_file if it requires a client certificate, or correct the port"
                .to_owned()
        }
        (Some(_), Some(client)) => format!(
            "it closes the encrypted connection without an answer: check that an authority that it trusts has signed the \
             client certificate in {}",
            client.certificate_file.display()
        ),
    }
}

fn unreached(error: &ConnectionError) -> String {
    match io_of(error).map(io::Error::kind) {
        Some(io::ErrorKind::ConnectionRefused) => {
            "nothing listens there: start the broker, or correct broker.url".to_owned()
        }
        Some(io::ErrorKind::TimedOut) => "no answer: check the network, firewalls and broker.url".to_owned(),
        _ => format!("it cannot be reached ({}): check broker.url and the network", short(error)),
    }
}

/// Text of an error without the client's wrapping texts.
fn short(error: &ConnectionError) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the text of the others is sufficient")]
    match error {
        ConnectionError::MqttState(StateError::AwaitPingResp) => "it has stopped answering".to_owned(),
        ConnectionError::MqttState(StateError::ConnectionAborted) => {
            "the broker has closed it; its log says why, such as another client under this robot's name".to_owned()
        }
        ConnectionError::MqttState(StateError::ServerDisconnect { reason_code, reason_string }) => {
            let said = reason_string.as_deref().map(|said| format!(" {said:?}")).unwrap_or_default();
            format!("it has disconnected {}{said}", plain::reason_code(&format!("{reason_code:?}")))
        }
        other => io_of(other).map_or_else(|| plain::text(&other.to_string()), plain::io),
    }
}
