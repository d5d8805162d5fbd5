//! Where a broker is, as whom to connect to it, and how to know it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use url::{Host, Url};

use vibrissa_store::secret::Secret;

/// Where the broker is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BrokerAddress {
    /// Host name or address; IPv6 without brackets.
    pub host: String,
    /// Port.
    pub port: u16,
    /// As whom to connect; none for a broker that asks nobody.
    pub credentials: Option<Credentials>,
    /// How to know the broker, and to be known; none speaks in plain text.
    pub tls: Option<TlsOptions>,
    /// How long an owner may keep a fleet that it does not hear, while another supervisor hears it.
    pub deaf_release_after: Duration,
}

/// Default of `deaf_release_after`.
const DEAF_RELEASE_AFTER: Duration = Duration::from_secs(10);

/// A user of the broker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Credentials {
    /// Name.
    pub username: String,
    /// Password.
    pub password: Secret,
}

/// Files in PEM.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TlsOptions {
    /// Certificates of the authorities that the broker's may come from; none takes the system's.
    pub ca_file: Option<PathBuf>,
    /// This supervisor's own certificate, with those between it and its authority, and its private key.
    pub client: Option<ClientCertificate>,
}

/// What a supervisor shows of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientCertificate {
    /// The certificate, and those between it and its authority.
    pub certificate_file: PathBuf,
    /// Its private key.
    pub key_file: PathBuf,
}

impl BrokerAddress {
    /// A broker that is spoken to in plain text and asks for no password.
    #[must_use]
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        let host = host.into();
        Self { host, port, credentials: None, tls: None, deaf_release_after: DEAF_RELEASE_AFTER }
    }

    /// Whether nobody else can listen to what is said: the host is this one.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        self.host.eq_ignore_ascii_case("localhost")
            || self.host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
    }
}

/// Host and port, as in a URL: `broker:1883`, `[::1]:1883`.
impl fmt::Display for BrokerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

/// The text is no address of a broker. It is not repeated: it may hold a password by mistake.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadBrokerUrl {
    /// A user or a password in it.
    #[error(
        "a broker's URL must not hold a user or password, which others would see: set mqtt.username and \
         mqtt.password_file instead"
    )]
    Credentials,
    /// Anything else.
    #[error("not a broker's URL ({0}): it must look like mqtt://host:1883, or mqtts://host:8883 for TLS")]
    Malformed(String),
}

/// `mqtt://host[:1883]` or, with TLS and the system's authorities, `mqtts://host[:8883]`.
impl FromStr for BrokerAddress {
    type Err = BadBrokerUrl;

    fn from_str(text: &str) -> Result<Self, BadBrokerUrl> {
        let malformed = |why: &str| BadBrokerUrl::Malformed(why.to_owned());
        let url = Url::parse(text).map_err(|problem| malformed(&problem.to_string()))?;
        let (tls, usual_port) = match url.scheme() {
            "mqtt" => (None, 1883),
            "mqtts" => (Some(TlsOptions::default()), 8883),
            _ => return Err(malformed("neither mqtt:// nor mqtts://")),
        };
        if !url.username().is_empty() || url.password().is_some() {
            return Err(BadBrokerUrl::Credentials);
        }
        if !matches!(url.path(), "" | "/") || url.query().is_some() || url.fragment().is_some() {
            return Err(malformed("something follows the port"));
        }
        let host = match url.host() {
            Some(Host::Ipv6(address)) => address.to_string(),
            Some(Host::Ipv4(address)) => address.to_string(),
            // What needs an escape is no host's name.
            Some(Host::Domain(name)) if !name.is_empty() && !name.contains('%') => name.to_owned(),
            Some(Host::Domain(_)) | None => return Err(malformed("no host")),
        };
        let port = url.port().unwrap_or(usual_port);
        if port == 0 {
            return Err(malformed("port 0"));
        }
        Ok(Self { tls, ..Self::new(host, port) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> Result<BrokerAddress, BadBrokerUrl> {
        text.parse()
    }

    #[test]
    fn a_brokers_url_has_a_host_and_perhaps_a_port() {
        assert_eq!(address("mqtt://h:1884"), Ok(BrokerAddress::new("h", 1884)));
        assert_eq!(address("mqtt://h"), Ok(BrokerAddress::new("h", 1883)));
        assert_eq!(address("mqtt://10.0.0.7/"), Ok(BrokerAddress::new("10.0.0.7", 1883)));
        assert_eq!(address("mqtt://[::1]:1885/"), Ok(BrokerAddress::new("::1", 1885)));
        let tls =
            |host: &str, port| BrokerAddress { tls: Some(TlsOptions::default()), ..BrokerAddress::new(host, port) };
        assert_eq!(address("mqtts://broker.example"), Ok(tls("broker.example", 8883)));
        assert_eq!(address("mqtts://[fd00::7]:8884"), Ok(tls("fd00::7", 8884)));
        for bad in [
            "h:1883",
            "mqtt://",
            "mqtt://h:x",
            "mqtt://h:0",
            "mqtt://h:70000",
            "http://h",
            "mqtt://h/topic",
            "mqtt://h?q",
        ] {
            assert!(matches!(address(bad), Err(BadBrokerUrl::Malformed(_))), "{bad}");
        }
    }

    #[test]
    fn a_password_in_a_url_is_refused_and_not_repeated() {
        for bad in ["mqtt://u:hunter2@h", "mqtts://hunter2@h:1", "mqtt://:hunter2@h"] {
            let refusal = address(bad).unwrap_err();
            assert_eq!(refusal, BadBrokerUrl::Credentials, "{bad}");
            assert!(refusal.to_string().contains("mqtt.username"), "{refusal}");
        }
        let malformed = address("mqtt://u:hunter2@h:x").unwrap_err().to_string();
        assert!(!malformed.contains("hunter2"), "{malformed}");
    }

    #[test]
    fn an_address_is_shown_as_in_a_url() {
        assert_eq!(BrokerAddress::new("::1", 1).to_string(), "[::1]:1");
        assert_eq!(BrokerAddress::new("h", 1).to_string(), "h:1");
    }
}
