//! A TCP link between a client and a server on 127.0.0.1 that can be cut and stalled.

use std::future::pending;
use std::net::SocketAddr;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::{JoinHandle, JoinSet};

/// Bytes buffered per connection and direction, about as many as a network link holds.
const BUFFER: usize = 16 << 10;

/// Shared state of the link.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    /// Number of cuts so far; a connection of an earlier count is closed.
    cuts: u64,
    /// Whether no data passes.
    stalled: bool,
    /// Number of bytes that pass, in both directions together, until the next cut.
    left: Option<usize>,
}

impl State {
    /// How many of so many bytes pass before the cut.
    fn passes(&mut self, bytes: usize) -> usize {
        let Some(left) = &mut self.left else { return bytes };
        let passes = bytes.min(*left);
        *left -= passes;
        passes
    }

    fn cut(&mut self) {
        self.cuts += 1;
        self.left = None;
    }
}

/// A listener that forwards everything to a server, in both directions. All its connections are cut on drop.
#[derive(Debug)]
pub struct Proxy {
    port: u16,
    state: watch::Sender<State>,
    listening: JoinHandle<()>,
}

impl Proxy {
    /// Listens on a free port of 127.0.0.1 and forwards to another port.
    ///
    /// # Panics
    /// There is no free port.
    pub async fn to(server_port: u16) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.expect("a free port");
        let port = listener.local_addr().expect("a bound listener").port();
        let state = watch::Sender::new(State::default());
        let listening = tokio::spawn(listen(listener, SocketAddr::from(([127, 0, 0, 1], server_port)), state.clone()));
        Self { port, state, listening }
    }

    /// Port of the proxy on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Closes every existing connection; new ones can be made at once.
    pub fn cut(&self) {
        self.state.send_modify(State::cut);
    }

    /// Closes every connection once so many more bytes have passed, in both directions together.
    pub fn cut_after(&self, bytes: usize) {
        self.state.send_modify(|state| state.left = Some(bytes));
    }

    /// Silently stops all data, or lets it pass again together with the data that has waited.
    pub fn stall(&self, stalled: bool) {
        self.state.send_modify(|state| state.stalled = stalled);
    }
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.listening.abort();
    }
}

async fn listen(listener: TcpListener, server: SocketAddr, state: watch::Sender<State>) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => {
                // Perhaps there are too many open files; the refused client tries again.
                let Ok((client, _)) = accepted else { continue };
                connections.spawn(join(client, server, state.clone()));
            }
            Some(_) = connections.join_next() => {}
        }
    }
}

/// Runs one connection until either side closes it or it is cut.
async fn join(client: TcpStream, server: SocketAddr, state: watch::Sender<State>) {
    let born_at = state.borrow().cuts;
    let passing = async {
        // While the link is stalled, the client must not notice whether there is a server.
        passable(&mut state.subscribe()).await;
        let Ok(server) = TcpStream::connect(server).await else { return };
        // The two ends decide whether small messages are delayed; the link must not delay them.
        let _ = (client.set_nodelay(true), server.set_nodelay(true));
        let (from_client, to_client) = client.into_split();
        let (from_server, to_server) = server.into_split();
        let upstream = pass(from_client, to_server, state.clone());
        let downstream = pass(from_server, to_client, state.clone());
        tokio::join!(upstream, downstream);
    };
    tokio::select! {
        () = passing => {}
        () = is_cut(state.subscribe(), born_at) => {}
    }
}

/// Forwards one direction. Unread data waits at the sender, which can send little more than passes.
async fn pass(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, state: watch::Sender<State>) {
    let mut buffer = vec![0; BUFFER];
    let mut watched = state.subscribe();
    while let Ok(length @ 1..) = from.read(&mut buffer).await {
        passable(&mut watched).await;
        let mut passes = length;
        state.send_if_modified(|state| {
            passes = state.passes(length);
            false
        });
        if to.write_all(&buffer[..passes]).await.is_err() {
            return;
        }
        if passes < length {
            state.send_modify(State::cut);
            // The cut ends this connection.
            pending::<()>().await;
        }
    }
    // The end of a stream is delayed by a stall like data.
    passable(&mut watched).await;
    let _ = to.shutdown().await;
}

async fn passable(state: &mut watch::Receiver<State>) {
    if state.wait_for(|state| !state.stalled).await.is_err() {
        pending::<()>().await;
    }
}

async fn is_cut(mut state: watch::Receiver<State>, born_at: u64) {
    // The sender is gone if the proxy was dropped, which is a cut, too.
    let _ = state.wait_for(|state| state.cuts > born_at).await;
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::time::timeout;

    use super::*;

    const SOON: Duration = Duration::from_millis(200);

    /// A server that echoes its input.
    async fn echo() -> u16 {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
        let port = listener.local_addr().unwrap().port();
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                tokio::spawn(async move {
                    let (mut from, mut to) = stream.split();
                    let _ = tokio::io::copy(&mut from, &mut to).await;
                });
            }
        });
        port
    }

    async fn client(proxy: &Proxy) -> TcpStream {
        TcpStream::connect(("127.0.0.1", proxy.port())).await.unwrap()
    }

    async fn says_again(stream: &mut TcpStream, text: &[u8]) {
        stream.write_all(text).await.unwrap();
        let mut said = vec![0; text.len()];
        stream.read_exact(&mut said).await.unwrap();
        assert_eq!(said, text);
    }

    #[tokio::test]
    async fn everything_passes_both_ways_and_so_does_the_end() {
        let proxy = Proxy::to(echo().await).await;
        let mut stream = client(&proxy).await;
        says_again(&mut stream, b"one").await;
        stream.shutdown().await.unwrap();
        assert_eq!(stream.read(&mut [0; 8]).await.unwrap(), 0);
    }

    #[tokio::test]
    async fn a_cut_ends_what_there_is_and_nothing_that_comes() {
        let proxy = Proxy::to(echo().await).await;
        let mut stream = client(&proxy).await;
        says_again(&mut stream, b"one").await;
        proxy.cut();
        assert!(!matches!(stream.read(&mut [0; 8]).await, Ok(1..)));
        says_again(&mut client(&proxy).await, b"two").await;
    }

    #[tokio::test]
    async fn a_cut_comes_after_so_many_bytes() {
        let proxy = Proxy::to(echo().await).await;
        let mut stream = client(&proxy).await;
        // Three there, three back, and a part of the next ones.
        proxy.cut_after(7);
        says_again(&mut stream, b"one").await;
        stream.write_all(b"two").await.unwrap();
        assert!(!matches!(stream.read(&mut [0; 8]).await, Ok(1..)), "the link is cut before an answer");
        says_again(&mut client(&proxy).await, b"three").await;
    }

    #[tokio::test]
    async fn a_stalled_link_takes_a_bounded_amount_and_passes_all_of_it_later() {
        let proxy = Proxy::to(echo().await).await;
        let mut stream = client(&proxy).await;
        says_again(&mut stream, b"one").await;
        proxy.stall(true);
        let mut sent = 0_usize;
        // Far more than all system buffers of a connection.
        while let Ok(length) = timeout(SOON, stream.write(&[7; 65_536])).await {
            sent += length.unwrap();
            assert!(sent < 64 << 20, "the stalled link does not stop the sender");
        }
        assert!(timeout(SOON, stream.read(&mut [0; 8])).await.is_err(), "no data may pass a stalled link");
        proxy.stall(false);
        let mut back = vec![0; sent];
        stream.read_exact(&mut back).await.unwrap();
        assert!(back.iter().all(|&byte| byte == 7));
    }

    #[tokio::test]
    async fn without_a_server_a_connection_ends() {
        let nobody = crate::mosquitto::free_port();
        let proxy = Proxy::to(nobody).await;
        assert!(!matches!(client(&proxy).await.read(&mut [0; 8]).await, Ok(1..)));
    }
}
