//! Connections of clients: accepts them, and passes their bytes between each client and the library.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bytes::{Bytes, BytesMut};
use mqtt5::broker::client_handler::ClientHandler;
use mqtt5::broker::config::BrokerConfig;
use mqtt5::broker::router::MessageRouter;
use mqtt5::broker::sys_topics::BrokerStats;
use mqtt5::broker::transport::BrokerTransport;
use mqtt5::broker::{AuthProvider, ResourceMonitor};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{broadcast, mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::{interval, sleep};
use tracing::{debug, warn};
use vibrissa_host::task;

use super::framing::Framing;
use super::gate::Gate;
use super::in_flight::{Change, InFlight};
use super::ledger::Ledger;
use crate::http::server::descriptors;

/// Most connections. Each needs three file descriptors.
const CONNECTIONS_MAX: usize = 2_000;
/// Share of the file descriptors that connections may need.
const DESCRIPTORS_SHARE: u64 = 4;
/// Connections that are possible under the smallest limits.
const CONNECTIONS_MIN: usize = 4;
/// Pause after the system failed to open or to accept a connection.
const PAUSE: Duration = Duration::from_millis(100);
/// Bytes that are read at once.
const CHUNK_BYTES: usize = 16 << 10;
/// Memory that a piece of bytes needs beside them.
const PIECE_OVERHEAD_BYTES: usize = 64;
/// Interval at which the library removes ended sessions and expired messages.
const SWEEP_EVERY: Duration = Duration::from_secs(60);

/// The library's parts, shared by all connections.
pub(super) struct Front {
    pub(super) config: Arc<BrokerConfig>,
    pub(super) router: Arc<MessageRouter>,
    pub(super) gate: Arc<Gate>,
    pub(super) stats: Arc<BrokerStats>,
    pub(super) resources: Arc<ResourceMonitor>,
    pub(super) shutdown: broadcast::Sender<()>,
    pub(super) ledger: Arc<Ledger>,
}

impl Front {
    /// Accepts connections until `stop` becomes true.
    pub(super) async fn run(self, listener: TcpListener, mut stop: watch::Receiver<bool>) {
        let front = Arc::new(self);
        let connections_max = connections_max(descriptors::raise_limit());
        let mut connections = JoinSet::new();
        task::spawn_in(&mut connections, front.clone().sweep());
        loop {
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                Some(_) = connections.join_next() => continue,
                _ = stop.wait_for(|&stop| stop) => break,
            };
            match accepted {
                Ok((_, peer)) if front.ledger.connections() >= connections_max => {
                    warn!(%peer, connections_max, "embedded MQTT broker: too many connections, one was refused");
                }
                Ok((client, peer)) => {
                    task::spawn_in(&mut connections, front.clone().serve(client, peer));
                }
                Err(problem) => {
                    warn!(%problem, "embedded MQTT broker: cannot accept a connection, trying again in 0.1 s");
                    sleep(PAUSE).await;
                }
            }
        }
        // An error means that no client is connected.
        let _ = front.shutdown.send(());
        connections.shutdown().await;
    }

    /// Removes ended sessions and expired messages from time to time.
    async fn sweep(self: Arc<Self>) {
        let mut sweeps = interval(SWEEP_EVERY);
        loop {
            sweeps.tick().await;
            self.router.sweep_sessions().await;
            self.resources.cleanup_expired_windows().await;
        }
    }

    async fn serve(self: Arc<Self>, client: TcpStream, peer: SocketAddr) {
        let (number, closed) = self.ledger.open();
        let served = async {
            let (ours, librarys) = match pair().await {
                Ok(pair) => pair,
                Err(problem) => {
                    warn!(%problem, "embedded MQTT broker: cannot serve a connection");
                    return sleep(PAUSE).await;
                }
            };
            // Neither side delays small packets for the other.
            for stream in [&client, &ours, &librarys] {
                let _ = stream.set_nodelay(true);
            }
            let gate: Arc<dyn AuthProvider> = self.gate.clone();
            let handler = ClientHandler::new(
                BrokerTransport::tcp(librarys),
                peer,
                self.config.clone(),
                self.router.clone(),
                gate,
                None,
                self.stats.clone(),
                self.resources.clone(),
                self.shutdown.subscribe(),
            );
            // A task of its own: it ends by itself when its stream does, and must not be dropped before.
            task::spawn(async move {
                if let Err(problem) = handler.run().await {
                    debug!(%problem, %peer, "embedded MQTT broker: a client has gone");
                }
            });
            self.pass(number, client, ours).await;
        };
        tokio::select! {
            () = served => {}
            _ = closed => {
                warn!(%peer, "embedded MQTT broker: a client that does not read or acknowledge was disconnected, too much waited for it");
            }
        }
        self.ledger.close(number);
    }

    /// Passes bytes both ways until one side ends. The library's bytes are taken at once, and wait here for the client.
    async fn pass(&self, number: u64, client: TcpStream, library: TcpStream) {
        let (from_client, to_client) = client.into_split();
        let (from_library, to_library) = library.into_split();
        let (pieces, waiting) = mpsc::unbounded_channel();
        let flight = Mutex::default();
        tokio::select! {
            () = self.up(number, &flight, from_client, to_library) => {}
            () = async {
                let take = self.take(number, &flight, from_library, pieces);
                tokio::join!(take, self.give(number, waiting, to_client));
            } => {}
        }
    }

    /// The bytes that the library keeps have changed.
    fn keep(&self, number: u64, change: Change) {
        self.ledger.remove(number, change.fewer);
        self.ledger.add(number, change.more);
    }

    /// From the client to the library, which keeps a packet until it is complete.
    async fn up(&self, number: u64, flight: &Mutex<InFlight>, mut from: OwnedReadHalf, mut to: OwnedWriteHalf) {
        let (mut framing, mut counted) = (Framing::default(), 0);
        let mut buffer = vec![0; CHUNK_BYTES];
        while let Ok(length @ 1..) = from.read(&mut buffer).await {
            let incomplete = framing.push(&buffer[..length], |packet| self.keep(number, lock(flight).sent(packet)));
            self.ledger.remove(number, counted);
            self.ledger.add(number, incomplete);
            counted = incomplete;
            if to.write_all(&buffer[..length]).await.is_err() {
                return;
            }
        }
    }

    /// Takes what the library sends.
    async fn take(
        &self,
        number: u64,
        flight: &Mutex<InFlight>,
        mut from: OwnedReadHalf,
        pieces: mpsc::UnboundedSender<Bytes>,
    ) {
        let (mut framing, mut buffer) = (Framing::default(), BytesMut::new());
        loop {
            buffer.reserve(CHUNK_BYTES);
            let Ok(1..) = from.read_buf(&mut buffer).await else { return };
            let piece = buffer.split().freeze();
            framing.push(&piece, |packet| self.keep(number, lock(flight).received(packet)));
            self.ledger.add(number, piece.len() + PIECE_OVERHEAD_BYTES);
            if pieces.send(piece).is_err() {
                return;
            }
        }
    }

    /// Gives it to the client.
    async fn give(&self, number: u64, mut waiting: mpsc::UnboundedReceiver<Bytes>, mut to: OwnedWriteHalf) {
        while let Some(piece) = waiting.recv().await {
            if to.write_all(&piece).await.is_err() {
                return;
            }
            self.ledger.remove(number, piece.len() + PIECE_OVERHEAD_BYTES);
        }
        let _ = to.shutdown().await;
    }
}

fn lock(flight: &Mutex<InFlight>) -> MutexGuard<'_, InFlight> {
    flight.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Number of connections for which the process has file descriptors.
fn connections_max(descriptors: Option<u64>) -> usize {
    let possible = descriptors.map_or(u64::MAX, |descriptors| descriptors / DESCRIPTORS_SHARE / 3);
    usize::try_from(possible).unwrap_or(usize::MAX).clamp(CONNECTIONS_MIN, CONNECTIONS_MAX)
}

/// Two ends of a connection within this process, which nobody else can reach.
async fn pair() -> io::Result<(TcpStream, TcpStream)> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let ours = TcpStream::connect(listener.local_addr()?).await?;
    let address = ours.local_addr()?;
    loop {
        // Another program of this machine may have found the port.
        let (librarys, peer) = listener.accept().await?;
        if peer == address {
            return Ok((ours, librarys));
        }
    }
}
