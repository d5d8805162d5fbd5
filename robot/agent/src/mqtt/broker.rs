//! The broker that a robot connects to.

use std::path::{Path, PathBuf};

use rumqttc::Transport;
use rumqttc::tokio_rustls::rustls::pki_types::pem::PemObject;
use rumqttc::tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use url::Url;
use vibrissa_protocol::text_file::{pem_of, read_text};
use vibrissa_protocol::{Name, plain};

/// Address of the broker, and the credentials to connect with.
#[derive(Clone, PartialEq, Eq)]
pub struct Broker {
    /// Host name or address; IPv6 without brackets.
    pub host: String,
    /// Port of the broker.
    pub port: u16,
    /// Host and port of further nodes of the same broker, which are tried in turn.
    pub others: Vec<(String, u16)>,
    /// User name and password, if the broker requires them. `{fleet}` and `{robot}` in the user name are replaced
    /// for each robot.
    pub credentials: Option<(String, String)>,
    /// File of that password. It is read again before each attempt after a failed one, so that a corrected file needs no
    /// restart.
    pub password_file: Option<PathBuf>,
    /// Certificate authorities for TLS; `None` for a connection without TLS.
    pub tls: Option<Authorities>,
    /// Client certificate, if the broker requires one; only with authorities from a file.
    pub client: Option<ClientCertificate>,
}

/// Client certificate and private key, in PEM.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClientCertificate {
    /// The certificate, followed by the intermediate ones up to its authority.
    pub certificate_file: PathBuf,
    /// Private key of the certificate.
    pub key_file: PathBuf,
}

/// Source of the certificate authorities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Authorities {
    /// The system's certificate store.
    System,
    /// A file with certificates in PEM.
    File(PathBuf),
}

/// Reason for which a broker cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BadBroker {
    /// The broker's URL is invalid. The error does not repeat it, because it may contain a password by mistake.
    #[error("invalid broker URL ({0}): expected mqtt://host[:1883], or mqtts://host[:8883] for TLS")]
    Address(String),
    /// The certificate authorities cannot be loaded.
    #[error("cannot use the certificate authorities from {0}: {1}")]
    Authorities(String, String),
    /// A file of the client certificate cannot be loaded.
    #[error("cannot use the client certificate: {0}")]
    Client(String),
    /// The password cannot be read.
    #[error("cannot read the password from {path}: {why}", path = .0, why = plain::io(.1))]
    Password(String, std::io::Error),
}

impl std::fmt::Debug for Broker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Passwords stay out of logs.
        let scheme = if self.tls.is_some() { "mqtts" } else { "mqtt" };
        for (at, (host, port)) in self.nodes().iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            write!(f, "{comma}{scheme}://{}", address(host, *port))?;
        }
        Ok(())
    }
}

impl Broker {
    /// A broker without credentials and TLS.
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        let (credentials, password_file, tls, client) = (None, None, None, None);
        Self { host: host.into(), port, others: Vec::new(), credentials, password_file, tls, client }
    }

    /// Parses `mqtt://host[:port]` or `mqtts://host[:port]`, or several of them separated by commas; the default port is
    /// 1883 or 8883.
    ///
    /// # Errors
    /// [`BadBroker::Address`] for anything else.
    pub fn from_url(text: &str) -> Result<Self, BadBroker> {
        let mut nodes = text.split(',').map(|text| Self::from_one_url(text.trim()));
        let mut broker = nodes.next().unwrap_or_else(|| Err(BadBroker::Address("no address".to_owned())))?;
        for node in nodes {
            let node = node?;
            if node.tls.is_some() != broker.tls.is_some() {
                return Err(BadBroker::Address("mqtt:// and mqtts:// are mixed".to_owned()));
            }
            broker.others.push((node.host, node.port));
        }
        Ok(broker)
    }

    fn from_one_url(text: &str) -> Result<Self, BadBroker> {
        let bad = |why: &str| BadBroker::Address(why.to_owned());
        let url = Url::parse(text).map_err(|problem| bad(&plain::url(&problem.to_string())))?;
        let (tls, usual_port) = match url.scheme() {
            "mqtt" => (None, 1883),
            "mqtts" => (Some(Authorities::System), 8883),
            _ => return Err(bad("neither mqtt:// nor mqtts://")),
        };
        if !url.username().is_empty() || url.password().is_some() {
            return Err(bad("it has a user name or a password: give them apart"));
        }
        if !matches!(url.path(), "" | "/") {
            return Err(bad("unexpected text after the port"));
        }
        let host = url.host_str().unwrap_or_default().trim_matches(['[', ']']).to_owned();
        if host.is_empty() {
            return Err(bad("no host"));
        }
        Ok(Self { tls, ..Self::new(host, url.port().unwrap_or(usual_port)) })
    }

    /// Host and port of each node.
    #[must_use]
    pub fn nodes(&self) -> Vec<(String, u16)> {
        std::iter::once((self.host.clone(), self.port)).chain(self.others.iter().cloned()).collect()
    }

    /// User name and password of a robot.
    #[must_use]
    pub fn credentials_of(&self, fleet: &Name, robot: &Name) -> Option<(String, String)> {
        let (user, password) = self.credentials.as_ref()?;
        let user = user.replace("{fleet}", fleet.as_str()).replace("{robot}", robot.as_str());
        Some((user, password.clone()))
    }

    /// Transport to the broker, with or without TLS.
    ///
    /// # Errors
    /// The certificate authorities cannot be loaded.
    pub fn transport(&self) -> Result<Transport, BadBroker> {
        let refused = |whose: String, why: String| BadBroker::Authorities(whose, why);
        match &self.tls {
            None => Ok(Transport::tcp()),
            Some(Authorities::System) => Transport::try_tls_with_default_config()
                .map_err(|why| refused("the system".to_owned(), why.to_string())),
            Some(Authorities::File(path)) => {
                let whose = || path.display().to_string();
                let certificates = std::fs::read(path).map_err(|why| refused(whose(), why.to_string()))?;
                let certificates = pem_of(certificates);
                if certificates_in(&certificates) == 0 {
                    return Err(refused(whose(), "the file contains no certificate in PEM".to_owned()));
                }
                let client = self.client.as_ref().map(ClientCertificate::read).transpose()?;
                Ok(Transport::tls(certificates, client, None))
            }
        }
    }

    /// Reads the password file and the files of TLS again; the transport, if it is from files.
    ///
    /// # Errors
    /// A file cannot be used; the credentials are the same as before then.
    pub fn read_again(&mut self) -> Result<Option<Transport>, BadBroker> {
        let password = self.password_file.as_deref().map(password_in).transpose()?;
        if let (Some((_, old)), Some(new)) = (&mut self.credentials, password) {
            *old = new;
        }
        match self.tls {
            Some(Authorities::File(_)) => self.transport().map(Some),
            // The system's authorities are large, and rarely the fault.
            Some(Authorities::System) | None => Ok(None),
        }
    }
}

/// Length of the longest accepted password file, bytes.
const PASSWORD_FILE_MAX_BYTES: u64 = 4096;

/// The password in a file, without the line break with which editors end it.
///
/// # Errors
/// The file cannot be read.
pub fn password_in(path: &Path) -> Result<String, BadBroker> {
    let text =
        read_text(path, PASSWORD_FILE_MAX_BYTES).map_err(|why| BadBroker::Password(path.display().to_string(), why))?;
    Ok(text.trim_end_matches(['\n', '\r']).to_owned())
}

/// Number of valid certificates in a PEM file.
fn certificates_in(pem: &[u8]) -> usize {
    CertificateDer::pem_slice_iter(pem).filter(Result::is_ok).count()
}

impl ClientCertificate {
    /// The contents of both files. No text shows a part of the key.
    fn read(&self) -> Result<(Vec<u8>, Vec<u8>), BadBroker> {
        let read = |path: &Path| {
            std::fs::read(path)
                .map(pem_of)
                .map_err(|why| BadBroker::Client(format!("cannot read {}: {}", path.display(), plain::io(&why))))
        };
        let (certificate, key) = (read(&self.certificate_file)?, read(&self.key_file)?);
        if certificates_in(&certificate) == 0 {
            let path = self.certificate_file.display();
            return Err(BadBroker::Client(format!("{path} contains no certificate in PEM")));
        }
        if PrivateKeyDer::from_pem_slice(&key).is_err() {
            let path = self.key_file.display();
            return Err(BadBroker::Client(format!(
                "{path} contains no private key in PEM without a passphrase (openssl pkey removes one)"
            )));
        }
        Ok((certificate, key))
    }
}

/// Host and port for the network library: `h:1883`, `[::1]:1883`.
#[must_use]
pub fn address(host: &str, port: u16) -> String {
    if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_may_have_a_port() {
        assert_eq!(Broker::from_url("mqtt://broker").unwrap(), Broker::new("broker", 1883));
        assert_eq!(Broker::from_url("mqtt://127.0.0.1:1884/").unwrap(), Broker::new("127.0.0.1", 1884));
        let tls = Broker { tls: Some(Authorities::System), ..Broker::new("::1", 8883) };
        assert_eq!(Broker::from_url("mqtts://[::1]").unwrap(), tls);
        let two = Broker::from_url("mqtt://a, mqtt://[::1]:1884").unwrap();
        assert_eq!(two.nodes(), [("a".to_owned(), 1883), ("::1".to_owned(), 1884)]);
        assert_eq!(format!("{two:?}"), "mqtt://a:1883,mqtt://[::1]:1884");
        assert_eq!(format!("{tls:?}"), "mqtts://[::1]:8883");
        for bad in ["", "127.0.0.1", "http://h", "mqtt://", "mqtt://h:x", "mqtt://u@h", "mqtt://u:p@h", "mqtt://h/t"] {
            assert!(Broker::from_url(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn each_robot_has_a_user_of_its_own_and_no_password_is_shown() {
        let credentials = Some(("{fleet}/{robot}".to_owned(), "hunter2".to_owned()));
        let broker = Broker { credentials, ..Broker::new("h", 1) };
        let name = |text| Name::new(text).unwrap();
        let of = broker.credentials_of(&name("lab"), &name("crawler-1"));
        assert_eq!(of, Some(("lab/crawler-1".to_owned(), "hunter2".to_owned())));
        assert_eq!(format!("{broker:?}"), "mqtt://h:1");
        assert!(!format!("{:?}", Broker::from_url("mqtt://u:hunter2@h")).contains("hunter2"));
    }
}
