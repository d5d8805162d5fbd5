//! Connections to the log. Each operation has a time limit; after a failure everything is connected anew. `wire` has
//! those of the readers.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rskafka::BackoffConfig;
use rskafka::client::error::{Error, ProtocolError, RequestError};
use rskafka::client::partition::{PartitionClient, UnknownTopicHandling};
use rskafka::client::{Client, ClientBuilder, Credentials, SaslConfig};
use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::{self, PemObject};
use rustls::{ClientConfig, RootCertStore};
use tokio::time::timeout;
use vibrissa_protocol::plain;
use vibrissa_protocol::text_file::pem_of;

use super::cause::{cause, of_tls};
use super::defect::Defect;
use crate::kafka_options::{KafkaOptions, SaslMechanism};

/// Time limit for one operation, such as a write that all replicas acknowledge.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);
/// How the supervisor names itself to the brokers.
pub(super) const CLIENT: &str = "vibrissa";
/// Largest answer of a broker.
pub(super) const ANSWER_BYTES_MAX: usize = 64 * 1024 * 1024;

/// Why the log cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KafkaError {
    /// A file of certificates is missing or defective.
    #[error("kafka.ca_file: cannot use {}: {why}", path.display())]
    Certificates {
        /// Path of the file.
        path: PathBuf,
        /// Description of the defect.
        why: String,
    },
    /// The system has no certificates of authorities.
    #[error("this system has no certificates of authorities: install them (ca-certificates), or set kafka.ca_file")]
    NoSystemAuthorities,
    /// The TLS library fails.
    #[error("TLS cannot be used: {}", of_tls(.0))]
    Tls(#[from] rustls::Error),
    /// A topic does not exist.
    #[error("the log has no topic {0:?}: create it, see docs/kafka.md")]
    NoTopic(String),
    /// No broker has answered in time.
    #[error("the log does not answer within {} s", PATIENCE.as_secs())]
    NoAnswer,
    /// The brokers refuse the credentials.
    #[error("the brokers refuse the credentials: check kafka.username, kafka.password_file and kafka.sasl")]
    Credentials,
    /// The certificate of a broker is not trusted.
    #[error("the certificate of a broker cannot be trusted, check kafka.ca_file and the host in kafka.url: {}", cause(.0))]
    NotTrusted(Error),
    /// A batch cannot be read.
    #[error("{0}")]
    Defect(#[from] Defect),
    /// The log answers with an error, or the connection fails.
    #[error("{}", cause(.0))]
    Failed(Error),
}

impl From<Error> for KafkaError {
    fn from(error: Error) -> Self {
        // The library's error has no type for these.
        let text = error.to_string();
        if text.contains("SaslAuthenticationFailed") {
            Self::Credentials
        } else if text.contains("invalid peer certificate") {
            Self::NotTrusted(error)
        } else {
            Self::Failed(error)
        }
    }
}

impl KafkaError {
    /// Whether the answer has come and cannot be read: it would be the same again.
    pub(super) fn is_unreadable(&self) -> bool {
        matches!(
            self,
            Self::Defect(_)
                | Self::Failed(Error::Request(
                    RequestError::ReadError(_) | RequestError::ReadVersionedError(_) | RequestError::TooMuchData { .. }
                ))
        )
    }

    /// Whether the brokers refuse these records for good, as too large or malformed.
    pub(super) fn is_refusal(&self) -> bool {
        let Self::Failed(Error::ServerError { protocol_error, .. }) = self else { return false };
        matches!(
            protocol_error,
            ProtocolError::MessageTooLarge | ProtocolError::RecordListTooLarge | ProtocolError::InvalidRecord
        )
    }
}

/// Makes connections.
#[derive(Debug, Clone)]
pub(super) struct Connector {
    pub(super) options: KafkaOptions,
    pub(super) tls: Option<Arc<ClientConfig>>,
}

impl Connector {
    pub(super) fn new(options: &KafkaOptions) -> Result<Self, KafkaError> {
        let tls = options.is_encrypted.then(|| tls(options)).transpose()?;
        Ok(Self { options: options.clone(), tls })
    }

    /// How the supervisor proves who it is; `None` if the brokers do not ask.
    pub(super) fn sasl(&self) -> Option<SaslConfig> {
        let credentials = self.options.credentials.as_ref()?;
        let own = Credentials::new(credentials.username.clone(), credentials.password.reveal().to_owned());
        Some(match credentials.mechanism {
            SaslMechanism::Plain => SaslConfig::Plain(own),
            SaslMechanism::ScramSha256 => SaslConfig::ScramSha256(own),
            SaslMechanism::ScramSha512 => SaslConfig::ScramSha512(own),
        })
    }

    /// Connects to a broker, and learns the topics.
    pub(super) async fn connect(&self) -> Result<Log, KafkaError> {
        let backoff = BackoffConfig {
            init_backoff: Duration::from_millis(50),
            max_backoff: Duration::from_secs(1),
            base: 2.0,
            // Counts the pauses only, not the attempts between them; the reason must be known before the time limit.
            deadline: Some(PATIENCE / 5),
        };
        let mut builder = ClientBuilder::new(self.options.brokers.clone())
            .client_id(CLIENT)
            .max_message_size(ANSWER_BYTES_MAX)
            .backoff_config(backoff);
        if let Some(tls) = &self.tls {
            builder = builder.tls_config(tls.clone());
        }
        if let Some(sasl) = self.sasl() {
            builder = builder.sasl_config(sasl);
        }
        within(async {
            let client = builder.build().await?;
            let partitions = partitions_of(&client).await?;
            Ok::<_, Error>(Log { client, partitions, open: BTreeMap::new() })
        })
        .await
    }
}

/// Runs an operation within the time limit.
pub(super) async fn within<T, E: Into<KafkaError>>(work: impl Future<Output = Result<T, E>>) -> Result<T, KafkaError> {
    match timeout(PATIENCE, work).await {
        Ok(done) => done.map_err(Into::into),
        Err(_) => Err(KafkaError::NoAnswer),
    }
}

/// Number of partitions by topic, as the brokers have them now.
async fn partitions_of(client: &Client) -> Result<BTreeMap<String, u32>, Error> {
    let topics = client.list_topics().await?;
    Ok(topics.into_iter().map(|topic| (topic.name, topic.partitions.len() as u32)).collect())
}

/// A connection to the log, for writing.
pub(super) struct Log {
    client: Client,
    /// Number of partitions by topic when the connection was made.
    partitions: BTreeMap<String, u32>,
    open: BTreeMap<(String, u32), Arc<PartitionClient>>,
}

impl Log {
    /// Number of partitions of a topic, at least one.
    pub(super) fn partitions(&self, topic: &str) -> Result<u32, KafkaError> {
        let known = self.partitions.get(topic).copied().filter(|&count| count > 0);
        known.ok_or_else(|| KafkaError::NoTopic(topic.to_owned()))
    }

    /// A partition, connected.
    pub(super) async fn partition(&mut self, topic: &str, partition: u32) -> Result<Arc<PartitionClient>, KafkaError> {
        let at = (topic.to_owned(), partition);
        if let Some(open) = self.open.get(&at) {
            return Ok(open.clone());
        }
        let opening = self.client.partition_client(topic, partition as i32, UnknownTopicHandling::Error);
        let client = Arc::new(within(opening).await?);
        self.open.insert(at, client.clone());
        Ok(client)
    }
}

fn tls(options: &KafkaOptions) -> Result<Arc<ClientConfig>, KafkaError> {
    let mut roots = RootCertStore::empty();
    match &options.ca_file {
        Some(path) => {
            let defect = |why: String| KafkaError::Certificates { path: path.clone(), why };
            let damaged = |problem: pem::Error| defect(plain::text(&problem.to_string()));
            let pem = std::fs::read(path).map(pem_of).map_err(|problem| defect(plain::io(&problem)))?;
            for certificate in CertificateDer::pem_slice_iter(&pem) {
                roots.add(certificate.map_err(damaged)?).map_err(|problem| defect(of_tls(&problem)))?;
            }
            if roots.is_empty() {
                return Err(defect("it has no certificate".to_owned()));
            }
        }
        None => {
            roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
            if roots.is_empty() {
                return Err(KafkaError::NoSystemAuthorities);
            }
        }
    }
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions()?;
    Ok(Arc::new(config.with_root_certificates(roots).with_no_client_auth()))
}
