//! A relay before a broker, to test a robot: it passes all bytes unchanged, and records the topics of each client.
//!
//! [`tap`] reads the packets. A client that cannot be read, for instance one with TLS, is served all the same.

mod tap;

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::{JoinHandle, JoinSet};
use vibrissa_host::task;

pub use tap::Trouble;
use tap::{Sight, Tap};

/// Most connections at the same time; further ones are closed at once.
const CONNECTIONS_MAX: usize = 64;
/// Most connections that are recorded; further ones are served without a record.
const RECORDS_MAX: usize = 1024;
/// Most topics and filters that are recorded of a connection.
const TOPICS_MAX: usize = 1000;
/// Pause after the system failed to accept a connection.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Bytes that are read at once.
const CHUNK_BYTES: usize = 16 << 10;

/// Topics of one connection of a client.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ClientRecord {
    /// Topic of the last will.
    pub will: Option<String>,
    /// Topics on which the client has published.
    pub published: BTreeSet<String>,
    /// Filters of its subscriptions.
    pub subscribed: BTreeSet<String>,
    /// Why the rest of the connection is not recorded.
    pub trouble: Option<Trouble>,
}

impl ClientRecord {
    fn note(&mut self, sight: Sight) {
        match sight {
            Sight::Will(topic) => self.will = Some(topic),
            Sight::Published(topic) => self.add(topic, |record| &mut record.published),
            Sight::Subscribed(filter) => self.add(filter, |record| &mut record.subscribed),
        }
    }

    fn add(&mut self, topic: String, set: impl Fn(&mut Self) -> &mut BTreeSet<String>) {
        if self.published.len() + self.subscribed.len() < TOPICS_MAX {
            set(self).insert(topic);
        } else if !set(self).contains(&topic) {
            self.trouble = Some(Trouble::TooManyTopics);
        }
    }
}

/// The records of a relay, which go on while it runs.
#[derive(Debug, Clone, Default)]
pub struct RelayRecord(Arc<Mutex<Vec<ClientRecord>>>);

impl RelayRecord {
    /// The connections so far, the oldest first.
    #[must_use]
    pub fn clients(&self) -> Vec<ClientRecord> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Begins the record of a connection; its place, if there is room.
    fn begin(&self) -> Option<usize> {
        let mut clients = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let place = clients.len();
        (place < RECORDS_MAX).then(|| {
            clients.push(ClientRecord::default());
            place
        })
    }

    fn change(&self, place: usize, change: impl FnOnce(&mut ClientRecord)) {
        if let Some(client) = self.0.lock().unwrap_or_else(PoisonError::into_inner).get_mut(place) {
            change(client);
        }
    }
}

/// A running relay; its connections end when it is dropped.
#[derive(Debug)]
pub struct Relay {
    address: SocketAddr,
    record: RelayRecord,
    listening: JoinHandle<()>,
}

impl Relay {
    /// Listens at an address, and passes each connection on to a server.
    ///
    /// # Errors
    /// The address is taken or cannot be used.
    pub async fn start(listen: SocketAddr, server: (String, u16)) -> std::io::Result<Self> {
        let listener = TcpListener::bind(listen).await?;
        let (address, record) = (listener.local_addr()?, RelayRecord::default());
        let listening = task::spawn(serve(listener, server, record.clone()));
        Ok(Self { address, record, listening })
    }

    /// Address at which the relay listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The records of its connections.
    #[must_use]
    pub fn record(&self) -> RelayRecord {
        self.record.clone()
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.listening.abort();
    }
}

async fn serve(listener: TcpListener, server: (String, u16), record: RelayRecord) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => {
                let Ok((client, _)) = accepted else {
                    // Perhaps there are too many open files; the client waits or tries again.
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                    continue;
                };
                if connections.len() < CONNECTIONS_MAX {
                    task::spawn_in(&mut connections, join(client, server.clone(), record.clone()));
                }
            }
            Some(_) = connections.join_next() => {}
        }
    }
}

/// Runs one connection until both directions have ended.
async fn join(client: TcpStream, server: (String, u16), record: RelayRecord) {
    let Ok(server) = TcpStream::connect(server).await else { return };
    // The two ends decide whether small packets are delayed; the relay must not delay them.
    let _ = (client.set_nodelay(true), server.set_nodelay(true));
    let (from_client, to_client) = client.into_split();
    let (from_server, to_server) = server.into_split();
    let place = record.begin();
    let mut tap = Tap::default();
    let read = |bytes: &[u8]| {
        let Some(place) = place else { return };
        let (sights, trouble) = tap.push(bytes);
        if !sights.is_empty() || trouble.is_some() {
            record.change(place, |client| {
                sights.into_iter().for_each(|sight| client.note(sight));
                client.trouble = client.trouble.take().or(trouble);
            });
        }
    };
    tokio::join!(pass(from_client, to_server, read), pass(from_server, to_client, |_| {}));
}

/// Passes one direction on. Bytes that the receiver does not take yet wait at the sender.
async fn pass(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, mut read: impl FnMut(&[u8])) {
    let mut buffer = vec![0; CHUNK_BYTES];
    while let Ok(length @ 1..) = from.read(&mut buffer).await {
        // Read before it is passed on: an effect that somebody sees is in the record.
        read(&buffer[..length]);
        if to.write_all(&buffer[..length]).await.is_err() {
            break;
        }
    }
    let _ = to.shutdown().await;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn bytes_pass_both_ways_unchanged_whatever_they_are() {
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = server.local_addr().unwrap();
        let relay = Relay::start("127.0.0.1:0".parse().unwrap(), (address.ip().to_string(), address.port())).await;
        let relay = relay.unwrap();
        let mut client = TcpStream::connect(relay.address()).await.unwrap();
        let (mut served, _) = server.accept().await.unwrap();
        let sent: Vec<u8> = (0..200_000_u32).map(|number| (number % 251) as u8).collect();
        let (mut there, mut back) = (vec![0; sent.len()], vec![0; sent.len()]);
        let sending = async {
            client.write_all(&sent).await.unwrap();
            client.read_exact(&mut back).await.unwrap();
        };
        let echoing = async {
            served.read_exact(&mut there).await.unwrap();
            served.write_all(&there).await.unwrap();
        };
        tokio::join!(sending, echoing);
        assert_eq!(back, sent);
        // The end of one side reaches the other one.
        drop(client);
        assert_eq!(served.read(&mut [0; 8]).await.unwrap(), 0);
        assert!(matches!(relay.record().clients()[..], [ClientRecord { trouble: Some(_), .. }]));
    }

    #[tokio::test]
    async fn connections_beyond_the_limit_are_closed() {
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = server.local_addr().unwrap();
        let relay = Relay::start("127.0.0.1:0".parse().unwrap(), (address.ip().to_string(), address.port())).await;
        let relay = relay.unwrap();
        let mut open = Vec::new();
        for _ in 0..CONNECTIONS_MAX {
            open.push((TcpStream::connect(relay.address()).await.unwrap(), server.accept().await.unwrap()));
        }
        let mut beyond = TcpStream::connect(relay.address()).await.unwrap();
        assert!(!matches!(beyond.read(&mut [0; 8]).await, Ok(1..)));
        assert_eq!(relay.record().clients().len(), CONNECTIONS_MAX);
    }

    #[test]
    fn topics_are_recorded_up_to_a_limit_which_is_told() {
        let mut record = ClientRecord::default();
        for number in 0..TOPICS_MAX {
            record.note(Sight::Published(format!("t/{number}")));
        }
        record.note(Sight::Published("t/0".to_owned()));
        assert_eq!(record.trouble, None);
        record.note(Sight::Subscribed("more".to_owned()));
        assert_eq!((record.trouble, record.subscribed.len()), (Some(Trouble::TooManyTopics), 0));
    }
}
