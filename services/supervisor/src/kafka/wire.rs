//! The readers' connections to brokers. They take the bytes of batches as they are: `batch` unpacks them with limits, and
//! the library's own reader has none.

use std::io::{self, Cursor};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use rskafka::ConnectionError;
use rskafka::client::error::{Error, ProtocolError, RequestContext, RequestError};
use rskafka::messenger::Messenger;
use rskafka::protocol::api_key::ApiKey;
use rskafka::protocol::api_version::{ApiVersion, ApiVersionRange};
use rskafka::protocol::messages::{
    FetchRequest, FetchRequestPartition, FetchRequestTopic, IsolationLevel, ListOffsetsRequest,
    ListOffsetsRequestPartition, ListOffsetsRequestTopic, MetadataRequest, MetadataRequestTopic, MetadataResponse,
    NORMAL_CONSUMER, ReadVersionedError, ReadVersionedType, RequestBody, WriteVersionedError, WriteVersionedType,
};
use rskafka::protocol::primitives::{Boolean, Int16, Int32, Int64, String_};
use rskafka::protocol::traits::{ReadError, ReadType};
use rustls::pki_types::ServerName;
use tokio::io::BufStream;
use tokio::net::TcpStream;
use tokio::sync::Mutex;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use vibrissa_host::process::{self, Stream};

use super::client::{ANSWER_BYTES_MAX, CLIENT, Connector, KafkaError, PATIENCE, within};

/// A connection to a broker.
type Wire = Messenger<BufStream<Box<dyn Stream>>>;

/// First or next offset of a partition.
#[derive(Debug, Clone, Copy)]
pub(super) enum OffsetAt {
    /// The offset of the oldest record.
    Earliest,
    /// The offset of the next record.
    Latest,
}

impl Connector {
    /// Connects to a broker, `HOST:PORT`.
    async fn wire(&self, address: &str) -> Result<Wire, KafkaError> {
        let (host, port) = address.rsplit_once(':').unwrap_or((address, "9092"));
        let host = host.trim_matches(['[', ']']);
        let stream = connect(host, port).await.map_err(RequestError::IO).map_err(Error::from)?;
        let stream: Box<dyn Stream> = match &self.tls {
            None => stream,
            Some(tls) => {
                let name =
                    ServerName::try_from(host.to_owned()).map_err(|_| io::Error::from(io::ErrorKind::InvalidInput));
                let connecting = async { TlsConnector::from(tls.clone()).connect(name?, stream).await };
                Box::new(connecting.await.map_err(RequestError::IO).map_err(Error::from)?)
            }
        };
        let mut wire = Messenger::new(BufStream::new(stream), ANSWER_BYTES_MAX, CLIENT.into());
        wire.sync_versions().await.map_err(ConnectionError::from).map_err(Error::from)?;
        if let Some(sasl) = self.sasl() {
            wire.do_sasl(sasl).await.map_err(ConnectionError::from).map_err(Error::from)?;
        }
        Ok(wire)
    }

    /// Connects to the first broker that answers.
    pub(super) async fn brokers(&self) -> Result<Brokers, KafkaError> {
        let addresses = &self.options.brokers;
        let each = PATIENCE / u32::try_from(addresses.len()).unwrap_or(u32::MAX).max(1);
        let mut problem = KafkaError::NoAnswer;
        for address in addresses {
            match timeout(each, self.wire(address)).await {
                Ok(Ok(wire)) => return Ok(Brokers { connector: self.clone(), wire }),
                Ok(Err(why)) => problem = why,
                Err(_) => {}
            }
        }
        Err(problem)
    }
}

async fn connect(host: &str, port: &str) -> io::Result<Box<dyn Stream>> {
    let port = port.parse().map_err(|_| io::ErrorKind::InvalidInput)?;
    match process::simulated() {
        Some(process) => process.connect(host, port).await,
        None => Ok(Box::new(TcpStream::connect((host, port)).await?)),
    }
}

/// The brokers, of which one is connected.
pub(super) struct Brokers {
    connector: Connector,
    wire: Wire,
}

impl Brokers {
    /// Number of partitions that a topic has now, at least one.
    pub(super) async fn partitions_now(&self, topic: &str) -> Result<u32, KafkaError> {
        let known = within(self.metadata(topic)).await?;
        let count = known.topics.first().map_or(0, |topic| topic.partitions.len());
        u32::try_from(count).ok().filter(|&count| count > 0).ok_or_else(|| KafkaError::NoTopic(topic.to_owned()))
    }

    /// Connects to the leader of a partition.
    pub(super) async fn open(&self, topic: &str, partition: u32) -> Result<Partition, KafkaError> {
        let at = (topic.to_owned(), partition as i32);
        within(async {
            let known = self.metadata(topic).await?;
            let found = known
                .topics
                .first()
                .and_then(|topic| topic.partitions.iter().find(|one| one.partition_index.0 == at.1));
            let found = found.ok_or_else(|| refused(&at, ProtocolError::UnknownTopicOrPartition))?;
            let leader = known.brokers.iter().find(|broker| broker.node_id.0 == found.leader_id.0);
            let none = found.error.unwrap_or(ProtocolError::LeaderNotAvailable);
            let leader = leader.ok_or_else(|| refused(&at, none))?;
            let address = format!("{}:{}", leader.host.0, leader.port.0);
            Ok::<_, KafkaError>(Partition { wire: self.connector.wire(&address).await?, at })
        })
        .await
    }

    async fn metadata(&self, topic: &str) -> Result<MetadataResponse, KafkaError> {
        let request = MetadataRequest {
            topics: Some(vec![MetadataRequestTopic { name: String_(topic.to_owned()) }]),
            allow_auto_topic_creation: Some(Boolean(false)),
        };
        let known = self.wire.request(request).await.map_err(Error::from)?;
        match known.topics.first().map(|topic| topic.error) {
            Some(None) => Ok(known),
            Some(Some(problem)) if problem != ProtocolError::UnknownTopicOrPartition => {
                Err(refused(&(topic.to_owned(), 0), problem))
            }
            Some(Some(_)) | None => Err(KafkaError::NoTopic(topic.to_owned())),
        }
    }
}

fn refused((topic, partition): &(String, i32), problem: ProtocolError) -> KafkaError {
    KafkaError::Failed(Error::ServerError {
        protocol_error: problem,
        error_message: None,
        request: RequestContext::Partition(topic.clone(), *partition),
        response: None,
        is_virtual: false,
    })
}

/// A partition, connected to its leader.
pub(super) struct Partition {
    wire: Wire,
    /// Topic and number.
    at: (String, i32),
}

impl Partition {
    /// Its number in the topic.
    pub(super) fn number(&self) -> i32 {
        self.at.1
    }

    /// Its first or next offset.
    pub(super) async fn offset(&self, of: OffsetAt) -> Result<i64, KafkaError> {
        let timestamp = match of {
            OffsetAt::Earliest => -2,
            OffsetAt::Latest => -1,
        };
        let asked = ListOffsetsRequestPartition {
            partition_index: Int32(self.at.1),
            timestamp: Int64(timestamp),
            max_num_offsets: Some(Int32(1)),
        };
        let request = ListOffsetsRequest {
            replica_id: NORMAL_CONSUMER,
            isolation_level: Some(IsolationLevel::ReadCommitted),
            topics: vec![ListOffsetsRequestTopic { name: String_(self.at.0.clone()), partitions: vec![asked] }],
        };
        let answer = within(async { self.wire.request(request).await.map_err(Error::from) }).await?;
        let found = answer.topics.into_iter().flat_map(|topic| topic.partitions).next();
        let found = found.ok_or_else(|| refused(&self.at, ProtocolError::UnknownTopicOrPartition))?;
        match (found.error_code, found.offset) {
            (Some(problem), _) => Err(refused(&self.at, problem)),
            (None, Some(offset)) => Ok(offset.0),
            (None, None) => Err(KafkaError::Failed(Error::InvalidResponse("no offset".to_owned()))),
        }
    }

    /// Batches from the one with this offset on, of at most so many bytes, but at least one batch. Returns them as they
    /// are stored, and the offset after the last record of the partition. Waits for records as long as this.
    pub(super) async fn fetch(&self, from: i64, bytes: i32, wait: Duration) -> Result<(Bytes, i64), KafkaError> {
        let asked = FetchRequestPartition {
            partition: Int32(self.at.1),
            fetch_offset: Int64(from),
            partition_max_bytes: Int32(bytes),
        };
        let request = Fetch(FetchRequest {
            replica_id: NORMAL_CONSUMER,
            max_wait_ms: Int32(wait.as_millis() as i32),
            min_bytes: Int32(1),
            max_bytes: Some(Int32(bytes)),
            isolation_level: Some(IsolationLevel::ReadCommitted),
            topics: vec![FetchRequestTopic { topic: String_(self.at.0.clone()), partitions: vec![asked] }],
        });
        let answer = within(async { self.wire.request(request).await.map_err(Error::from) }).await?;
        match ProtocolError::new(answer.error) {
            None => Ok((answer.batches, answer.end)),
            Some(problem) => Err(refused(&self.at, problem)),
        }
    }
}

/// A request for batches of one partition.
struct Fetch(FetchRequest);

impl RequestBody for Fetch {
    type ResponseBody = Fetched;
    const API_KEY: ApiKey = ApiKey::Fetch;
    const API_VERSION_RANGE: ApiVersionRange = FetchRequest::API_VERSION_RANGE;
    const FIRST_TAGGED_FIELD_IN_REQUEST_VERSION: ApiVersion = FetchRequest::FIRST_TAGGED_FIELD_IN_REQUEST_VERSION;
}

impl WriteVersionedType<Vec<u8>> for Fetch {
    fn write_versioned(&self, writer: &mut Vec<u8>, version: ApiVersion) -> Result<(), WriteVersionedError> {
        self.0.write_versioned(writer, version)
    }
}

/// The answer of version 4.
struct Fetched {
    error: i16,
    end: i64,
    batches: Bytes,
}

impl ReadVersionedType<Cursor<Vec<u8>>> for Fetched {
    fn read_versioned(reader: &mut Cursor<Vec<u8>>, _: ApiVersion) -> Result<Self, ReadVersionedError> {
        let is_one = |count: Int32| match count.0 {
            1 => Ok(()),
            count => Err(ReadError::Malformed(format!("{count} topics or partitions in the place of one").into())),
        };
        // A broker that throttles delays its next answer itself.
        Int32::read(reader)?;
        is_one(Int32::read(reader)?)?;
        String_::read(reader)?;
        is_one(Int32::read(reader)?)?;
        Int32::read(reader)?;
        let (error, end) = (Int16::read(reader)?.0, Int64::read(reader)?.0);
        // End of the committed transactions, and those that were aborted.
        Int64::read(reader)?;
        for _ in 0..Int32::read(reader)?.0 {
            Int64::read(reader)?;
            Int64::read(reader)?;
        }
        let length = usize::try_from(Int32::read(reader)?.0).unwrap_or_default();
        let begin = reader.position() as usize;
        let batches = reader.get_ref().get(begin..begin + length).map(Bytes::copy_from_slice);
        let batches = batches.ok_or_else(|| ReadError::Malformed("batches end too early".into()))?;
        reader.set_position((begin + length) as u64);
        Ok(Self { error, end, batches })
    }
}

/// Connected brokers that several tasks use.
pub(super) struct SharedBrokers {
    connector: Connector,
    brokers: Mutex<Option<Arc<Brokers>>>,
}

impl SharedBrokers {
    pub(super) fn new(connector: Connector) -> Self {
        Self { connector, brokers: Mutex::default() }
    }

    /// The connection. Connects first if nobody has.
    pub(super) async fn get(&self) -> Result<Arc<Brokers>, KafkaError> {
        let mut brokers = self.brokers.lock().await;
        if let Some(brokers) = &*brokers {
            return Ok(brokers.clone());
        }
        Ok(brokers.insert(Arc::new(self.connector.brokers().await?)).clone())
    }

    /// Forgets a connection after a failure. Who uses it still may go on.
    pub(super) async fn forget(&self, failed: &Arc<Brokers>) {
        let mut brokers = self.brokers.lock().await;
        brokers.take_if(|brokers| Arc::ptr_eq(brokers, failed));
    }
}
