//! Certificates and keys, read from files before a connection.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustls::client::WebPkiServerVerifier;
use rustls::pki_types::pem::{self, PemObject};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use rustls::{ClientConfig, RootCertStore};
use tracing::warn;
use vibrissa_protocol::plain;
use vibrissa_protocol::text_file::pem_of;

use super::address::{BrokerAddress, ClientCertificate, TlsOptions};

/// TLS configuration of a connection, read from files and checked.
#[derive(Clone, Default)]
pub struct Prepared {
    pub(super) tls: Option<Arc<ClientConfig>>,
    /// Stamps of the files, taken before they were read.
    stamps: Vec<Stamp>,
}

/// Identifies a version of a file: length, modification time in seconds and nanoseconds, and inode; `None` if the file
/// cannot be read.
type Stamp = Option<(u64, i64, i64, u64)>;

fn stamp(path: &Path) -> Stamp {
    let about = std::fs::metadata(path).ok()?;
    Some((about.len(), about.mtime(), about.mtime_nsec(), about.ino()))
}

fn stamps(options: &TlsOptions) -> Vec<Stamp> {
    let client = options.client.iter().flat_map(|client| [&client.certificate_file, &client.key_file]);
    options.ca_file.iter().chain(client).map(|path| stamp(path)).collect()
}

impl Prepared {
    /// The same configuration, or a new one if a file has changed.
    pub(super) fn read_again(&self, broker: &BrokerAddress) -> Result<Self, PrepareError> {
        match &broker.tls {
            Some(options) if stamps(options) != self.stamps => prepared(options),
            Some(_) | None => Ok(self.clone()),
        }
    }
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.tls.is_some() { "Prepared(TLS)" } else { "Prepared(plain)" })
    }
}

/// Why TLS cannot be configured.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// A file is missing, or may not be read.
    #[error("{key}: cannot read {}: {}", path.display(), plain::io(source))]
    Unreadable {
        /// Setting that names the file.
        key: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A file is not in PEM, or is truncated.
    #[error("{key}: {} is not PEM ({why}): it must have lines such as -----BEGIN CERTIFICATE-----", path.display())]
    NotPem {
        /// Setting that names the file.
        key: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Description of the defect.
        why: String,
    },
    /// A PEM file does not contain the required item.
    #[error("{key}: there is no {wanted} in {}", path.display())]
    Missing {
        /// Setting that names the file.
        key: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// The required item.
        wanted: &'static str,
    },
    /// The private key is encrypted with a passphrase.
    #[error("{key}: the private key in {} is encrypted: decrypt it (openssl pkey) and restrict who may read it", path.display())]
    EncryptedKey {
        /// Setting that names the file.
        key: &'static str,
        /// Path of the file.
        path: PathBuf,
    },
    /// A certificate or key is unusable.
    #[error("{key}: {} cannot be used: {why}", path.display())]
    Unusable {
        /// Setting that names the file.
        key: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Description of the defect.
        why: String,
    },
    /// The private key belongs to another certificate.
    #[error(
        "mqtt.client_key_file: the private key in {} does not belong to the certificate in {}",
        key_file.display(), certificate_file.display()
    )]
    KeyMismatch {
        /// File of the private key.
        key_file: PathBuf,
        /// File of the certificate.
        certificate_file: PathBuf,
    },
    /// The system has no certificates of authorities.
    #[error(
        "this system has no certificates of authorities ({0}): install them (ca-certificates), or set mqtt.ca_file"
    )]
    NoSystemAuthorities(String),
    /// No certificate can be issued for the host.
    #[error("mqtt.url: a certificate cannot be issued for host {0:?}")]
    BadHost(String),
    /// The TLS library fails.
    #[error("TLS cannot be used: {}", rejected(.0))]
    Tls(#[from] rustls::Error),
}

const CA: &str = "mqtt.ca_file";
const CERTIFICATE: &str = "mqtt.client_certificate_file";
const KEY: &str = "mqtt.client_key_file";

/// Reads and checks the files that a connection needs, so that a defect is reported at the start. Before each
/// connection, changed files are read again.
///
/// # Errors
/// A file is missing or defective; the error names it, and its setting.
pub fn prepare(broker: &BrokerAddress) -> Result<Prepared, PrepareError> {
    if broker.tls.is_none() && !broker.is_loopback() {
        let what = match &broker.credentials {
            Some(_) => "the MQTT password, contacts and setpoints go",
            None => "contacts and setpoints go",
        };
        let nodes: Vec<String> = broker.nodes().iter().map(ToString::to_string).collect();
        let broker = nodes.join(", ");
        warn!(
            broker,
            "{what} over the network in plain text, where others can read and change them: use mqtts:// in mqtt.url"
        );
    }
    let Some(options) = &broker.tls else { return Ok(Prepared::default()) };
    for node in broker.nodes() {
        if ServerName::try_from(node.host.as_str()).is_err() {
            return Err(PrepareError::BadHost(node.host));
        }
    }
    prepared(options)
}

fn prepared(options: &TlsOptions) -> Result<Prepared, PrepareError> {
    // Before the files are read, so that a change in the meantime is noticed later.
    let stamps = stamps(options);
    Ok(Prepared { tls: Some(Arc::new(client_config(options)?)), stamps })
}

/// Configuration for TLS 1.2 and 1.3.
fn client_config(options: &TlsOptions) -> Result<ClientConfig, PrepareError> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let authorities = Arc::new(authorities(options.ca_file.as_deref())?);
    let verifier = WebPkiServerVerifier::builder_with_provider(authorities, provider.clone())
        .build()
        .map_err(|_| PrepareError::NoSystemAuthorities("none of them can be used".to_owned()))?;
    let builder = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()?
        .with_webpki_verifier(verifier);
    match &options.client {
        None => Ok(builder.with_no_client_auth()),
        Some(client) => {
            let chain = certificates(CERTIFICATE, &client.certificate_file)?;
            let key = private_key(&client.key_file)?;
            builder.with_client_auth_cert(chain, key).map_err(|problem| refused_key(client, problem))
        }
    }
}

/// The authorities of the file, all of which must be usable; or the system's, of which some are usually unusable and
/// skipped.
fn authorities(file: Option<&Path>) -> Result<RootCertStore, PrepareError> {
    let mut store = RootCertStore::empty();
    let Some(path) = file else {
        let system = rustls_native_certs::load_native_certs();
        store.add_parsable_certificates(system.certs);
        if store.is_empty() {
            let text_of = |problem: &rustls_native_certs::Error| plain::text(&problem.to_string());
            let why = system.errors.first().map_or_else(|| "none found".to_owned(), text_of);
            return Err(PrepareError::NoSystemAuthorities(why));
        }
        return Ok(store);
    };
    for certificate in certificates(CA, path)? {
        store.add(certificate).map_err(|problem| PrepareError::Unusable {
            key: CA,
            path: path.to_owned(),
            why: rejected(&problem),
        })?;
    }
    Ok(store)
}

/// Why the TLS library refuses a certificate or a setting.
fn rejected(problem: &rustls::Error) -> String {
    if let rustls::Error::InvalidCertificate(defect) = problem {
        return plain::certificate(&format!("{defect:?}"));
    }
    plain::tls(&format!("{problem:?}"))
}

fn read(key: &'static str, path: &Path) -> Result<Vec<u8>, PrepareError> {
    let bytes =
        std::fs::read(path).map_err(|source| PrepareError::Unreadable { key, path: path.to_owned(), source })?;
    let bytes = pem_of(bytes);
    if bytes.windows(11).any(|window| window == b"-----BEGIN ") {
        return Ok(bytes);
    }
    let why = if bytes.is_empty() { "it is empty" } else { "it has no BEGIN line" };
    Err(PrepareError::NotPem { key, path: path.to_owned(), why: why.to_owned() })
}

/// Reads a list of at least one certificate.
fn certificates(key: &'static str, path: &Path) -> Result<Vec<CertificateDer<'static>>, PrepareError> {
    let bytes = read(key, path)?;
    let found: Result<Vec<_>, pem::Error> = CertificateDer::pem_slice_iter(&bytes).collect();
    let found = found.map_err(|_| PrepareError::NotPem {
        key,
        path: path.to_owned(),
        why: "a section is damaged".to_owned(),
    })?;
    if found.is_empty() {
        return Err(PrepareError::Missing { key, path: path.to_owned(), wanted: "certificate" });
    }
    Ok(found)
}

fn private_key(path: &Path) -> Result<PrivateKeyDer<'static>, PrepareError> {
    let bytes = read(KEY, path)?;
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the library's errors: the texts of the others may reveal the key"
    )]
    PrivateKeyDer::from_pem_slice(&bytes).map_err(|problem| match problem {
        pem::Error::NoItemsFound if String::from_utf8_lossy(&bytes).contains("BEGIN ENCRYPTED PRIVATE KEY") => {
            PrepareError::EncryptedKey { key: KEY, path: path.to_owned() }
        }
        pem::Error::NoItemsFound => PrepareError::Missing { key: KEY, path: path.to_owned(), wanted: "private key" },
        // The parser's text would reveal a piece of the key.
        _ => PrepareError::NotPem { key: KEY, path: path.to_owned(), why: "a section is damaged".to_owned() },
    })
}

fn refused_key(client: &ClientCertificate, problem: rustls::Error) -> PrepareError {
    let (key_file, certificate_file) = (client.key_file.clone(), client.certificate_file.clone());
    #[expect(clippy::wildcard_enum_match_arm, reason = "the library's errors: the text of the others is sufficient")]
    match problem {
        rustls::Error::InconsistentKeys(_) => PrepareError::KeyMismatch { key_file, certificate_file },
        rustls::Error::InvalidCertificate(why) => {
            let why = plain::certificate(&format!("{why:?}"));
            PrepareError::Unusable { key: CERTIFICATE, path: certificate_file, why }
        }
        other => PrepareError::Unusable { key: KEY, path: key_file, why: plain::tls(&format!("{other:?}")) },
    }
}
