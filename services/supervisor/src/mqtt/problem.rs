//! Why a connection fails, as a sentence with the host, file or user concerned, and what to do.

use std::fmt;
use std::io;

use rumqttc::{ClientError, ConnectReturnCode, ConnectionError, DisconnectReasonCode, StateError, TlsError};
use rustls::{AlertDescription, CertificateError};
use vibrissa_protocol::{Name, RobotTopic, plain};

use super::address::{BrokerAddress, Node};
use super::connector::{Limits, LookupError};
use super::hearing::PATIENCE;

/// Why a connection ends of which the client has stopped.
pub(super) const STOPPED: &str = "the client has stopped";

/// A cause of failure, with the broker concerned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Problem {
    /// Boxed, to keep results with a problem small.
    broker: Box<BrokerAddress>,
    cause: Cause,
}

/// Cause of a failure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Cause {
    /// The host name cannot be resolved.
    UnknownHost(String),
    /// Nothing listens on the port.
    Refused,
    /// There is no route to the host.
    Unreachable(String),
    /// No answer to the TCP connection attempt.
    NoAnswer,
    /// TCP is connected, but nothing arrives.
    Mute,
    /// The broker answers, but not in TLS.
    NotTls,
    /// An unknown authority has signed the broker's certificate.
    UnknownIssuer,
    /// The broker's certificate is for other names, which are listed.
    WrongName(Vec<String>),
    /// The broker's certificate has expired.
    Expired,
    /// The broker's certificate is not valid yet.
    NotYetValid,
    /// The broker's certificate is unusable for another reason.
    BadCertificate(String),
    /// The broker requires a client certificate.
    WantsCertificate,
    /// The broker rejects the client certificate.
    CertificateRefused(String),
    /// TLS fails for another reason.
    Tls(String),
    /// The peer closes the connection, or does not speak MQTT.
    NotMqtt,
    /// The broker speaks another version of MQTT.
    WrongVersion,
    /// The broker rejects the user or password, or requires some.
    NotAuthorized,
    /// The broker rejects the connection for another reason.
    NotAccepted(ConnectReturnCode),
    /// The broker lacks a feature that the fleet needs.
    Lacks(&'static str),
    /// The broker rejects a subscription.
    Subscription(String),
    /// The broker rejects a publication.
    Publication { topic: String, why: String },
    /// An established connection broke.
    Lost(String),
    /// An established connection has gone silent.
    Silent,
    /// Another client has connected with this client id.
    TakenOver,
    /// The broker has closed the connection without a reason.
    Closed,
    /// Probes for these topics did not come back.
    Unheard {
        fleet: Name,
        topics: Vec<RobotTopic>,
        /// No other message arrived either.
        is_silent: bool,
    },
    /// The broker rejects the publication of probes.
    ProbeRefused { fleet: Name, why: String },
}

impl Problem {
    pub(super) fn new(broker: &BrokerAddress, cause: Cause) -> Self {
        Self { broker: Box::new(broker.clone()), cause }
    }

    /// Classifies an error of the client.
    ///
    /// `reached`: TCP was connected. `connected`: the broker had accepted the connection.
    pub(super) fn of(broker: &BrokerAddress, error: &ConnectionError, reached: bool, connected: bool) -> Self {
        #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: classified by their contents")]
        let cause = match error {
            ConnectionError::ConnectionRefused(code) => of_code(*code),
            ConnectionError::Timeout(_) if reached => Cause::Mute,
            ConnectionError::Timeout(_) => Cause::NoAnswer,
            ConnectionError::MqttState(StateError::AwaitPingResp) => Cause::Silent,
            ConnectionError::MqttState(StateError::ServerDisconnect {
                reason_code: DisconnectReasonCode::SessionTakenOver,
                ..
            }) => Cause::TakenOver,
            other => match tls_of(other) {
                Some(problem) => of_tls(problem),
                None if connected && is_end(other) => Cause::Closed,
                None if connected => Cause::Lost(short(other)),
                None if !reached => of_dial(other),
                None if matches!(other, ConnectionError::Tls(_)) => Cause::NotTls,
                None => Cause::NotMqtt,
            },
        };
        Self::new(broker, cause)
    }

    /// The client has not taken a request.
    pub(super) fn of_client(broker: &BrokerAddress, error: &ClientError) -> Self {
        let why = match error {
            ClientError::RequestChannelFull(_) => "more messages wait than the client holds",
            ClientError::RequestChannelDisconnected(_) | ClientError::TrackingUnavailable => STOPPED,
            // The library may add variants.
            ClientError::InvalidRequest(_) | _ => "MQTT forbids a message of this form",
        };
        Self::new(broker, Cause::Lost(why.to_owned()))
    }

    /// The node concerned.
    pub(super) fn node(&self) -> Node {
        self.broker.node()
    }

    /// Whether the node did not answer within a time limit.
    pub(super) fn is_slow(&self) -> bool {
        matches!(self.cause, Cause::NoAnswer | Cause::Mute | Cause::Silent | Cause::Unheard { .. })
    }

    /// Whether another client has connected with this client id.
    pub(super) fn is_takeover(&self) -> bool {
        self.cause == Cause::TakenOver
    }

    /// Whether the broker has refused the connection because it retains no messages, and the last will asked for it.
    pub(super) fn is_retain_refused(&self) -> bool {
        self.cause == Cause::NotAccepted(ConnectReturnCode::RetainNotSupported)
    }

    /// Whether the broker has closed the connection without an understandable reason. After a takeover Mosquitto 2.0.11
    /// gives none, and newer versions send a DISCONNECT without the length of its properties, which the client library
    /// cannot parse.
    pub(super) fn is_unexplained_end(&self) -> bool {
        self.cause == Cause::Closed
    }
}

/// Whether the peer has closed the connection.
fn is_end(error: &ConnectionError) -> bool {
    matches!(error, ConnectionError::MqttState(StateError::ConnectionAborted))
        || io_of(error).is_some_and(|error| error.kind() == io::ErrorKind::ConnectionReset)
}

fn of_code(code: ConnectReturnCode) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's codes: the others have no specific advice")]
    match code {
        ConnectReturnCode::BadUserNamePassword
        | ConnectReturnCode::NotAuthorized
        | ConnectReturnCode::BadAuthenticationMethod => Cause::NotAuthorized,
        ConnectReturnCode::RefusedProtocolVersion | ConnectReturnCode::UnsupportedProtocolVersion => {
            Cause::WrongVersion
        }
        other => Cause::NotAccepted(other),
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

fn of_tls(error: &rustls::Error) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no specific advice")]
    match error {
        rustls::Error::InvalidCertificate(problem) => of_certificate(problem),
        rustls::Error::InvalidMessage(_) => Cause::NotTls,
        // TLS 1.3 has an alert for it; TLS 1.2 reports a handshake failure.
        rustls::Error::AlertReceived(AlertDescription::CertificateRequired | AlertDescription::HandshakeFailure) => {
            Cause::WantsCertificate
        }
        rustls::Error::AlertReceived(
            alert @ (AlertDescription::UnknownCA
            | AlertDescription::BadCertificate
            | AlertDescription::UnsupportedCertificate
            | AlertDescription::CertificateRevoked
            | AlertDescription::CertificateExpired
            | AlertDescription::CertificateUnknown
            | AlertDescription::AccessDenied
            | AlertDescription::DecryptError),
        ) => Cause::CertificateRefused(plain::alert(&format!("{alert:?}"))),
        other => Cause::Tls(plain::tls(&format!("{other:?}"))),
    }
}

fn of_certificate(problem: &CertificateError) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no specific advice")]
    match problem {
        CertificateError::UnknownIssuer | CertificateError::BadSignature => Cause::UnknownIssuer,
        CertificateError::NotValidForName => Cause::WrongName(Vec::new()),
        CertificateError::NotValidForNameContext { presented, .. } => Cause::WrongName(presented.clone()),
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => Cause::Expired,
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => Cause::NotYetValid,
        other => Cause::BadCertificate(plain::certificate(&format!("{other:?}"))),
    }
}

/// Classifies a failure before TCP was connected.
fn of_dial(error: &ConnectionError) -> Cause {
    let Some(error) = io_of(error) else { return Cause::Unreachable(short(error)) };
    if let Some(LookupError(why)) = error.get_ref().and_then(|inner| inner.downcast_ref()) {
        return Cause::UnknownHost(why.clone());
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's kinds: the others have no specific advice")]
    match error.kind() {
        io::ErrorKind::ConnectionRefused => Cause::Refused,
        io::ErrorKind::TimedOut => Cause::NoAnswer,
        _ => Cause::Unreachable(plain::io(error)),
    }
}

/// Reason of a broken connection, without the client's wrapping texts.
fn short(error: &ConnectionError) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the text of the others is sufficient")]
    match error {
        ConnectionError::MqttState(StateError::ServerDisconnect { reason_code, reason_string }) => {
            let said = reason_string.as_deref().map(|said| format!(" {said:?}")).unwrap_or_default();
            format!("the broker disconnected {}{said}", plain::reason_code(&format!("{reason_code:?}")))
        }
        other => io_of(other).map_or_else(|| plain::text(&other.to_string()), plain::io),
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let broker = &self.broker;
        write!(f, "MQTT broker {broker}: ")?;
        match &self.cause {
            Cause::UnknownHost(_) | Cause::Refused | Cause::Unreachable(_) | Cause::NoAnswer | Cause::Mute => {
                self.unreached(f)
            }
            Cause::UnknownIssuer
            | Cause::WrongName(_)
            | Cause::Expired
            | Cause::NotYetValid
            | Cause::BadCertificate(_) => self.untrusted(f),
            Cause::NotTls => write!(
                f,
                "it does not answer in TLS on port {}: use mqtt:// in mqtt.url if it has no TLS, or its port for TLS \
                 (usually 8883)",
                broker.port
            ),
            Cause::WantsCertificate => f.write_str(
                "it requires a client certificate: set mqtt.client_certificate_file and mqtt.client_key_file to one of \
                 an authority that it trusts",
            ),
            Cause::CertificateRefused(alert) => {
                write!(f, "it does not accept the client certificate in {}: {alert}", self.certificate_file())
            }
            Cause::Tls(why) => write!(f, "the TLS handshake failed: {why}"),
            Cause::NotMqtt => self.not_mqtt(f),
            Cause::WrongVersion => f.write_str("it does not support MQTT 5: use a broker that does"),
            Cause::NotAuthorized => self.not_authorized(f),
            Cause::NotAccepted(code) => {
                write!(f, "it does not accept the connection {}", plain::reason_code(&format!("{code:?}")))
            }
            Cause::Lacks(what) => f.write_str(what),
            Cause::Subscription(what) => {
                write!(f, "it does not let {} subscribe to {what}. Until then robots are not heard", self.user())
            }
            Cause::Publication { topic, why } => write!(
                f,
                "it rejects publications of {} on {topic}, {why}. Allow setpoint, receipt, request, estimate and \
                 supervisor/state in the broker's access list, and packets that are large enough",
                self.user()
            ),
            Cause::Lost(why) => write!(f, "the connection broke ({why}); reconnecting"),
            Cause::Silent => f.write_str("it has stopped answering; reconnecting"),
            Cause::TakenOver => f.write_str(
                "it has ended the connection because another client connected with the same client id, which is secret \
                 unless the broker or its log reveals it; reconnecting with a new one",
            ),
            Cause::Closed => {
                f.write_str("it closed the connection without a reason; reconnecting with a new client id")
            }
            Cause::Unheard { .. } => self.unheard(f),
            Cause::ProbeRefused { fleet, why } => write!(
                f,
                "it does not let {} publish probes and requests to its robots, {why}. Allow \
                 whisker/v1/{fleet}/supervisor/+ in the broker's access list",
                self.user()
            ),
        }
    }
}

impl Problem {
    fn unreached(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let host = &self.broker.host;
        let seconds = Limits::of(&self.broker).whole.as_secs();
        if let Cause::UnknownHost(why) = &self.cause {
            write!(f, "no address is known for host {host:?} ({why}): correct mqtt.url or DNS")
        } else if let Cause::Unreachable(why) = &self.cause {
            write!(f, "it cannot be reached ({why}): check the network, and mqtt.url")
        } else if self.cause == Cause::Refused {
            f.write_str("nothing listens there: start the broker, or correct mqtt.url")
        } else if self.cause == Cause::NoAnswer {
            write!(f, "no answer within {seconds} s: check the network, firewalls, and mqtt.url")
        } else {
            write!(
                f,
                "it accepts the connection but says nothing within {seconds} s: is it an MQTT broker, and is TLS {}?",
                if self.broker.tls.is_some() { "on at that port" } else { "off at that port (else write mqtts://)" }
            )
        }
    }

    fn unheard(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Cause::Unheard { fleet, topics, is_silent } = &self.cause else { return Ok(()) };
        let seconds = PATIENCE.as_secs();
        if *is_silent {
            f.write_str("it has stopped answering: ")?;
        }
        let topics: Vec<String> = topics.iter().map(|topic| topic.fleet_filter(fleet)).collect();
        write!(
            f,
            "a probe on {} did not come back within {seconds} s, so robots are not heard there; subscribing again on \
             a new connection",
            topics.join(", ")
        )
    }

    fn untrusted(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let host = &self.broker.host;
        if let Cause::WrongName(names) = &self.cause {
            match plain::host_names(names) {
                Some(names) => write!(
                    f,
                    "its certificate is not for {host:?} but for {names}: use one of these in mqtt.url, or give the \
                     broker a certificate for {host:?}"
                ),
                None => write!(
                    f,
                    "its certificate names no host, and its common name (CN) does not count: give the broker a \
                     certificate whose subjectAltName contains {host:?}"
                ),
            }
        } else if let Cause::BadCertificate(why) = &self.cause {
            write!(f, "its certificate cannot be used: {why}")
        } else if self.cause == Cause::Expired {
            f.write_str("its certificate has expired: renew it, or correct this host's clock")
        } else if self.cause == Cause::NotYetValid {
            f.write_str("its certificate is not valid yet: correct this host's clock, or the certificate")
        } else {
            let from = match self.broker.tls.as_ref().and_then(|tls| tls.ca_file.as_ref()) {
                Some(path) => format!("those in mqtt.ca_file {}", path.display()),
                None => "this system's".to_owned(),
            };
            write!(
                f,
                "its certificate is not signed by a trusted authority ({from}): set mqtt.ca_file to \
                       the certificate of the broker's authority"
            )
        }
    }

    fn not_mqtt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.broker.tls {
            None => f.write_str(
                "it does not answer as an MQTT broker: use mqtts:// in mqtt.url if it expects TLS, or correct the port",
            ),
            Some(tls) if tls.client.is_none() => f.write_str(
                "it closes the encrypted connection without an answer: if it requires a client certificate, set \
                 mqtt.client_certificate_file and mqtt.client_key_file; otherwise correct the port",
            ),
            Some(_) => write!(
                f,
                "it closes the encrypted connection without an answer: is the client certificate in {} signed by an \
                 authority that it trusts?",
                self.certificate_file()
            ),
        }
    }

    fn not_authorized(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.broker.credentials {
            Some(credentials) => write!(
                f,
                "it does not accept user {:?} with the password given: correct mqtt.username or mqtt.password_file, \
                 or the broker's list of users",
                credentials.username
            ),
            None => f.write_str("it requires a user and a password: set mqtt.username and mqtt.password_file"),
        }
    }

    fn user(&self) -> String {
        match &self.broker.credentials {
            Some(credentials) => format!("user {:?}", credentials.username),
            None => "an anonymous client".to_owned(),
        }
    }

    fn certificate_file(&self) -> String {
        let client = self.broker.tls.as_ref().and_then(|tls| tls.client.as_ref());
        client.map_or_else(|| "mqtt.client_certificate_file".to_owned(), |it| it.certificate_file.display().to_string())
    }
}

#[cfg(test)]
mod tests;
