//! Why there is no connection, in a sentence for people: what is wrong, with which host, file or user, and
//! what to do.

use std::fmt;
use std::io;

use rumqttc::{ConnectReturnCode, ConnectionError, DisconnectReasonCode, StateError, TlsError};
use rustls::{AlertDescription, CertificateError};
use vibrissa_protocol::{Name, RobotTopic};

use super::address::BrokerAddress;
use super::dial::{CONNECT_TIMEOUT, LookupError};
use super::hearing::PATIENCE;

/// A cause, with the broker that it is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Problem {
    /// In a box, so that results with a problem stay small.
    broker: Box<BrokerAddress>,
    cause: Cause,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Cause {
    /// The host's name has no address.
    UnknownHost(String),
    /// Nothing listens there.
    Refused,
    /// The network does not lead there.
    Unreachable(String),
    /// No answer to the attempt to connect.
    NoAnswer,
    /// Connected by TCP, and then nothing.
    Mute,
    /// It answers something, but not in TLS.
    NotTls,
    /// Its certificate comes from an authority that is not known.
    UnknownIssuer,
    /// Its certificate is for other names.
    WrongName(Vec<String>),
    /// Its certificate is not valid any more.
    Expired,
    /// Its certificate is not valid yet.
    NotYetValid,
    /// Its certificate cannot be used for another reason.
    BadCertificate(String),
    /// It wants a certificate of ours.
    WantsCertificate,
    /// It does not want the one that it got.
    CertificateRefused(String),
    /// TLS fails for another reason.
    Tls(String),
    /// It closes the connection, or says what no broker says.
    NotMqtt,
    /// It speaks another version of MQTT.
    WrongVersion,
    /// It does not accept the user or the password, or wants some.
    NotAuthorized,
    /// It does not accept the connection for another reason.
    NotAccepted(ConnectReturnCode),
    /// It does not let us read.
    Subscription(String),
    /// It does not let us write.
    Publication(String),
    /// The connection stood, and broke.
    Lost(String),
    /// The connection stands, but nothing comes through it.
    Silent,
    /// Another client has connected with our client id.
    TakenOver,
    /// The broker has closed the connection and says nothing of why.
    Closed,
    /// Probes for these topics did not come back.
    Unheard {
        fleet: Name,
        topics: Vec<RobotTopic>,
        /// Nor did anything else.
        is_silent: bool,
    },
    /// It does not let us publish probes.
    ProbeRefused { fleet: Name, why: String },
}

impl Problem {
    pub(super) fn new(broker: &BrokerAddress, cause: Cause) -> Self {
        Self { broker: Box::new(broker.clone()), cause }
    }

    /// What of the client's errors it is.
    ///
    /// `reached`: TCP stood. `connected`: the broker had accepted the connection.
    pub(super) fn of(broker: &BrokerAddress, error: &ConnectionError, reached: bool, connected: bool) -> Self {
        #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: told apart by what they hold")]
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

    /// Whether another client has connected with our client id.
    pub(super) fn is_takeover(&self) -> bool {
        self.cause == Cause::TakenOver
    }

    /// Whether the broker has closed the connection without a reason that is understood. After a takeover Mosquitto 2.0.11 gives
    /// none, and newer ones send a DISCONNECT without the length of its properties, which the client library does not read.
    pub(super) fn is_unexplained_end(&self) -> bool {
        self.cause == Cause::Closed
    }
}

/// Whether the other side has closed the connection.
fn is_end(error: &ConnectionError) -> bool {
    matches!(error, ConnectionError::MqttState(StateError::ConnectionAborted))
        || io_of(error).is_some_and(|error| error.kind() == io::ErrorKind::ConnectionReset)
}

fn of_code(code: ConnectReturnCode) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's codes: the others have no advice of their own")]
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

/// The error of the socket, wherever the client has put it.
fn io_of(error: &ConnectionError) -> Option<&io::Error> {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others hold no such thing")]
    match error {
        ConnectionError::Io(error)
        | ConnectionError::Tls(TlsError::Io(error))
        | ConnectionError::MqttState(StateError::Io(error) | StateError::Deserialization(rumqttc::Error::Io(error))) => {
            Some(error)
        }
        _ => None,
    }
}

/// The error of TLS; after the handshake it comes by way of the socket.
fn tls_of(error: &ConnectionError) -> Option<&rustls::Error> {
    if let ConnectionError::Tls(TlsError::TLS(error)) = error {
        return Some(error);
    }
    io_of(error)?.get_ref()?.downcast_ref()
}

fn of_tls(error: &rustls::Error) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no advice of their own")]
    match error {
        rustls::Error::InvalidCertificate(problem) => of_certificate(problem),
        rustls::Error::InvalidMessage(_) => Cause::NotTls,
        // TLS 1.3 has an alert of its own for it; 1.2 says that nothing fits.
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
        ) => Cause::CertificateRefused(format!("{alert:?}")),
        other => Cause::Tls(other.to_string()),
    }
}

fn of_certificate(problem: &CertificateError) -> Cause {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others have no advice of their own")]
    match problem {
        CertificateError::UnknownIssuer | CertificateError::BadSignature => Cause::UnknownIssuer,
        CertificateError::NotValidForName => Cause::WrongName(Vec::new()),
        CertificateError::NotValidForNameContext { presented, .. } => Cause::WrongName(presented.clone()),
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => Cause::Expired,
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => Cause::NotYetValid,
        other => Cause::BadCertificate(other.to_string()),
    }
}

/// TCP never stood.
fn of_dial(error: &ConnectionError) -> Cause {
    let Some(error) = io_of(error) else { return Cause::Unreachable(short(error)) };
    if let Some(LookupError(why)) = error.get_ref().and_then(|inner| inner.downcast_ref()) {
        return Cause::UnknownHost(why.clone());
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's kinds: the others have no advice of their own")]
    match error.kind() {
        io::ErrorKind::ConnectionRefused => Cause::Refused,
        io::ErrorKind::TimedOut => Cause::NoAnswer,
        _ => Cause::Unreachable(error.to_string()),
    }
}

/// What broke a connection, without the client's layers.
fn short(error: &ConnectionError) -> String {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the others say it themselves")]
    match error {
        ConnectionError::MqttState(StateError::ServerDisconnect { reason_code, reason_string }) => {
            let said = reason_string.as_deref().map(|said| format!(" {said:?}")).unwrap_or_default();
            format!("the broker ended it: {reason_code:?}{said}")
        }
        other => io_of(other).map_or_else(|| other.to_string(), ToString::to_string),
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
                "it does not answer in TLS on port {}: write mqtt:// in mqtt.url if it has none, or the port that has \
                 it (usually 8883)",
                broker.port
            ),
            Cause::WantsCertificate => f.write_str(
                "it wants a client certificate: set mqtt.client_certificate_file and mqtt.client_key_file to one from \
                 an authority that it knows",
            ),
            Cause::CertificateRefused(alert) => write!(
                f,
                "it does not accept the client certificate in {} ({alert}): it must come from an authority that the \
                 broker knows, and not have expired",
                self.certificate_file()
            ),
            Cause::Tls(why) => write!(f, "no agreement on TLS: {why}"),
            Cause::NotMqtt => self.not_mqtt(f),
            Cause::WrongVersion => f.write_str("it does not speak MQTT 5, which is needed: use one that does"),
            Cause::NotAuthorized => self.not_authorized(f),
            Cause::NotAccepted(code) => write!(f, "it does not accept the connection: {code:?}"),
            Cause::Subscription(what) => write!(
                f,
                "it does not let {} read {what}: allow that in the broker's access list; until then robots are not \
                 heard",
                self.user()
            ),
            Cause::Publication(why) => write!(
                f,
                "it does not take what {} publishes ({why}): allow setpoint, receipt, request and supervisor/state in \
                 the broker's access list",
                self.user()
            ),
            Cause::Lost(why) => write!(f, "the connection broke ({why}); trying again"),
            Cause::Silent => f.write_str("it has stopped answering; trying again"),
            Cause::TakenOver => f.write_str(
                "it has ended the connection because another client connected with the same client id, which nobody else \
                 can know unless the broker or its log tells it; connecting again under a new one",
            ),
            Cause::Closed => f.write_str(
                "it has closed the connection without a reason, as a broker does that ends, and some when another client \
                 connects with the same client id; connecting again under a new one",
            ),
            Cause::Unheard { .. } => self.unheard(f),
            Cause::ProbeRefused { fleet, why } => write!(
                f,
                "it does not let {} publish the probes that prove that robots are heard ({why}): allow \
                 whisker/v1/{fleet}/supervisor/+ in the broker's access list",
                self.user()
            ),
        }
    }
}

impl Problem {
    fn unreached(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let host = &self.broker.host;
        let seconds = CONNECT_TIMEOUT.as_secs();
        if let Cause::UnknownHost(why) = &self.cause {
            write!(f, "no address is known for host {host:?} ({why}): correct mqtt.url, or the name service")
        } else if let Cause::Unreachable(why) = &self.cause {
            write!(f, "it cannot be reached ({why}): check the network, and mqtt.url")
        } else if self.cause == Cause::Refused {
            f.write_str("nothing listens there: start the broker, or correct mqtt.url")
        } else if self.cause == Cause::NoAnswer {
            write!(f, "no answer within {seconds} s: check the network, firewalls, and mqtt.url")
        } else {
            write!(
                f,
                "it takes the connection but says nothing within {seconds} s: is it an MQTT broker, and is TLS {}?",
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
            "a probe did not come back within {seconds} s from {}, so robots are not heard there; subscribing again on a new \
             connection",
            topics.join(", ")
        )
    }

    fn untrusted(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let host = &self.broker.host;
        if let Cause::WrongName(names) = &self.cause {
            // As rustls lists them: DnsName("a.example").
            let names = names.join(", ");
            write!(
                f,
                "its certificate is not for {host:?} but for {names}: write such a name in mqtt.url, or give the broker \
                 a certificate for {host:?}"
            )
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
                "its certificate comes from none of the authorities that are trusted, {from}: set mqtt.ca_file to \
                       the certificate of the broker's authority"
            )
        }
    }

    fn not_mqtt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.broker.tls {
            None => f.write_str(
                "it does not answer as an MQTT broker: write mqtts:// in mqtt.url if it expects TLS, or correct the port",
            ),
            Some(tls) if tls.client.is_none() => f.write_str(
                "it ends the encrypted connection without an answer: if it wants a client certificate, set \
                 mqtt.client_certificate_file and mqtt.client_key_file; otherwise correct the port",
            ),
            Some(_) => write!(
                f,
                "it ends the encrypted connection without an answer: is the client certificate in {} from an authority \
                 that it knows?",
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
            None => f.write_str("it wants a user and a password: set mqtt.username and mqtt.password_file"),
        }
    }

    fn user(&self) -> String {
        match &self.broker.credentials {
            Some(credentials) => format!("user {:?}", credentials.username),
            None => "a client without a name".to_owned(),
        }
    }

    fn certificate_file(&self) -> String {
        let client = self.broker.tls.as_ref().and_then(|tls| tls.client.as_ref());
        client.map_or_else(|| "mqtt.client_certificate_file".to_owned(), |it| it.certificate_file.display().to_string())
    }
}
