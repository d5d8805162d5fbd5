//! Address of the broker, credentials, and TLS settings.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use url::{Host, Url};
use vibrissa_protocol::plain;

use vibrissa_store::secret::Secret;

/// How to reach and authenticate the broker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BrokerAddress {
    /// Host name or address; IPv6 without brackets.
    pub host: String,
    /// TCP port of the broker.
    pub port: u16,
    /// Further nodes of the same cluster; a connection that fails is tried at the next one.
    pub others: Vec<Node>,
    /// User and password; `None` for a broker that accepts anonymous clients.
    pub credentials: Option<Credentials>,
    /// TLS settings; `None` connects in plain text.
    pub tls: Option<TlsOptions>,
    /// How long an owner may keep a fleet that it does not hear, while another supervisor hears it.
    pub deaf_release_after: Duration,
}

/// One node of the broker: where it listens.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Node {
    /// Host name or address; IPv6 without brackets.
    pub host: String,
    /// TCP port of the node.
    pub port: u16,
}

/// Limit of the nodes of one broker.
const NODES_MAX: usize = 16;

/// Default of `deaf_release_after`.
const DEAF_RELEASE_AFTER: Duration = Duration::from_secs(10);

/// Credentials of a broker user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Credentials {
    /// Name of the user.
    pub username: String,
    /// Password of the user.
    pub password: Secret,
}

/// Paths of PEM files for TLS.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TlsOptions {
    /// Certificates of the authorities that may sign the broker's certificate; `None` takes the system's.
    pub ca_file: Option<PathBuf>,
    /// Client certificate of this supervisor, if the broker requires one.
    pub client: Option<ClientCertificate>,
}

/// Client certificate and private key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientCertificate {
    /// The certificate, followed by the intermediate certificates up to its authority.
    pub certificate_file: PathBuf,
    /// Private key of the certificate.
    pub key_file: PathBuf,
}

impl BrokerAddress {
    /// A broker in plain text that accepts anonymous clients.
    #[must_use]
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        let host = host.into();
        let others = Vec::new();
        Self { host, port, others, credentials: None, tls: None, deaf_release_after: DEAF_RELEASE_AFTER }
    }

    /// The node that this address names first.
    #[must_use]
    pub fn node(&self) -> Node {
        Node { host: self.host.clone(), port: self.port }
    }

    /// All nodes, in the order of the setting.
    #[must_use]
    pub fn nodes(&self) -> Vec<Node> {
        std::iter::once(self.node()).chain(self.others.iter().cloned()).collect()
    }

    /// The same broker with this node in the first place.
    pub(super) fn at(&self, node: &Node) -> Self {
        let others = self.nodes().into_iter().filter(|other| other != node).collect();
        Self { host: node.host.clone(), port: node.port, others, ..self.clone() }
    }

    /// Whether all nodes are on this host, so that others cannot read the traffic.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        self.nodes().iter().all(Node::is_loopback)
    }
}

impl Node {
    fn is_loopback(&self) -> bool {
        self.host.eq_ignore_ascii_case("localhost")
            || self.host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
    }
}

/// Host and port, as in a URL: `broker:1883`, `[::1]:1883`.
impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

/// Host and port of the first node.
impl fmt::Display for BrokerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.node().fmt(f)
    }
}

/// Why a text is not the URL of a broker. The text is not repeated, because it may hold a password by mistake.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadBrokerUrl {
    /// The URL holds a user or a password.
    #[error(
        "a broker's URL must not hold a user or password, because others can see it: set mqtt.username and \
         mqtt.password_file instead"
    )]
    Credentials,
    /// The URL has another form.
    #[error("not a broker's URL ({0}): it must look like mqtt://host:1883, or mqtts://host:8883 for TLS")]
    Malformed(String),
    /// One of several URLs is bad.
    #[error("address {number} of {count}: {problem}")]
    Address {
        /// Number of the URL, from 1 on.
        number: usize,
        /// Number of URLs.
        count: usize,
        /// Reason why this URL is bad.
        problem: Box<BadBrokerUrl>,
    },
    /// Some URLs have TLS, and others do not.
    #[error(
        "mqtt:// and mqtts:// are mixed: TLS is the same for all nodes of a broker, so write one of them everywhere"
    )]
    Mixed,
    /// A node is named twice.
    #[error("the node {0} is named twice: leave one out")]
    Repeated(Node),
    /// There are too many nodes.
    #[error("{0} addresses are too many: name at most {NODES_MAX} nodes of the broker")]
    TooMany(usize),
}

/// One or more URLs, separated by commas, of the nodes of one broker.
impl FromStr for BrokerAddress {
    type Err = BadBrokerUrl;

    fn from_str(text: &str) -> Result<Self, BadBrokerUrl> {
        let texts: Vec<&str> = text.split(',').map(str::trim).collect();
        let count = texts.len();
        if count > NODES_MAX {
            return Err(BadBrokerUrl::TooMany(count));
        }
        let mut broker: Option<Self> = None;
        for (at, text) in texts.into_iter().enumerate() {
            let address = Self::from_url(text).map_err(|problem| match count {
                1 => problem,
                _ => BadBrokerUrl::Address { number: at + 1, count, problem: Box::new(problem) },
            })?;
            match &mut broker {
                None => broker = Some(address),
                Some(broker) if broker.tls.is_some() != address.tls.is_some() => return Err(BadBrokerUrl::Mixed),
                Some(broker) if broker.nodes().contains(&address.node()) => {
                    return Err(BadBrokerUrl::Repeated(address.node()));
                }
                Some(broker) => broker.others.push(address.node()),
            }
        }
        broker.ok_or_else(|| BadBrokerUrl::Malformed("no address".to_owned()))
    }
}

impl BrokerAddress {
    /// `mqtt://host[:1883]` or, with TLS and the system's authorities, `mqtts://host[:8883]`.
    fn from_url(text: &str) -> Result<Self, BadBrokerUrl> {
        let malformed = |why: &str| BadBrokerUrl::Malformed(why.to_owned());
        let url = Url::parse(text).map_err(|problem| malformed(&plain::url(&problem.to_string())))?;
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
            // An escape: other characters than those of ASCII.
            Some(Host::Domain(name)) if name.contains('%') => {
                return Err(malformed("a host name is in ASCII, an international one in Punycode: xn--..."));
            }
            Some(Host::Domain(name)) if !name.is_empty() => name.to_owned(),
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
    fn a_host_that_is_not_in_ascii_is_refused_with_what_to_write() {
        assert!(address("mqtt://xn--bcher-kva.example").is_ok());
        for host in ["b\u{fc}cher.example", "b%C3%BCcher.example"] {
            let refusal = address(&format!("mqtts://{host}")).unwrap_err();
            assert!(refusal.to_string().contains("Punycode: xn--"), "{refusal}");
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
    fn several_addresses_are_the_nodes_of_one_broker() {
        let three = address("mqtts://a, mqtts://b:8884,mqtts://[::1]").unwrap();
        let shown: Vec<String> = three.nodes().iter().map(ToString::to_string).collect();
        assert_eq!(shown, ["a:8883", "b:8884", "[::1]:8883"]);
        assert!(three.tls.is_some());
        let second = three.at(&three.nodes()[1]);
        assert_eq!((second.to_string().as_str(), second.nodes().len()), ("b:8884", 3));
        assert_eq!(address("mqtt://a,mqtts://b"), Err(BadBrokerUrl::Mixed));
        let node = Node { host: "a".to_owned(), port: 1883 };
        assert_eq!(address("mqtt://a,mqtt://b,mqtt://a:1883"), Err(BadBrokerUrl::Repeated(node)));
        let many: Vec<String> = (0..17).map(|number| format!("mqtt://h{number}")).collect();
        assert_eq!(address(&many.join(",")), Err(BadBrokerUrl::TooMany(17)));
        for bad in ["mqtt://a,", ",mqtt://a", "mqtt://a,b:1883", "mqtt://a,mqtt://u:hunter2@b"] {
            let refusal = address(bad).unwrap_err().to_string();
            assert!(refusal.starts_with("address ") && !refusal.contains("hunter2"), "{refusal}");
        }
        assert!(address("mqtt://localhost,mqtt://127.0.0.1").unwrap().is_loopback());
        assert!(!address("mqtt://localhost,mqtt://10.0.0.7").unwrap().is_loopback());
    }

    #[test]
    fn an_address_is_shown_as_in_a_url() {
        assert_eq!(BrokerAddress::new("::1", 1).to_string(), "[::1]:1");
        assert_eq!(BrokerAddress::new("h", 1).to_string(), "h:1");
    }
}
