//! A network connection: a byte stream in each direction with a latency, which can be cut and reset.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, Weak};
use std::task::{Context, Poll, Waker, ready};
use std::time::Duration;

use bytes::{Buf, Bytes};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until};

use super::lanes::{Lane, Way};
use super::locked;

/// Most bytes on their way in one direction; then the writer waits, as it does on a full TCP window.
const WINDOW: usize = 256 * 1024;

/// One direction.
#[derive(Debug)]
struct Pipe {
    /// Bytes on their way; empty ones are the end of the stream.
    lane: Lane<Bytes>,
    /// What has arrived and is not read.
    arrived: VecDeque<Bytes>,
    /// Number of bytes in both.
    unread: usize,
    latency: Duration,
    /// The writer has ended the stream.
    is_finished: bool,
    /// Nobody reads any more.
    is_unread: bool,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

impl Pipe {
    fn new(latency: Duration, is_held: bool) -> Self {
        Self {
            lane: Lane::new(is_held),
            arrived: VecDeque::new(),
            unread: 0,
            latency,
            is_finished: false,
            is_unread: false,
            reader: None,
            writer: None,
        }
    }

    fn push(&mut self, bytes: Bytes) {
        self.unread += bytes.len();
        self.lane.push(Instant::now() + self.latency, bytes);
        self.wake();
    }

    fn finish(&mut self) {
        if !std::mem::replace(&mut self.is_finished, true) {
            self.push(Bytes::new());
        }
    }

    fn wake(&mut self) {
        for waker in [self.reader.take(), self.writer.take()].into_iter().flatten() {
            waker.wake();
        }
    }
}

#[derive(Debug)]
struct State {
    to_broker: Pipe,
    to_client: Pipe,
    is_reset: bool,
}

impl State {
    fn pipe(&mut self, way: Way) -> &mut Pipe {
        match way {
            Way::ToBroker => &mut self.to_broker,
            Way::ToClient => &mut self.to_client,
        }
    }
}

/// Controls a connection from outside; it keeps nothing open.
#[derive(Debug, Clone)]
pub struct Wire(Weak<Mutex<State>>);

impl Wire {
    /// The ends of the client and of the broker, and the control of a new connection. `latencies` are to the broker and to
    /// the client.
    #[must_use]
    pub fn pair(latencies: [Duration; 2]) -> (WireEnd, WireEnd, Self) {
        let [to_broker, to_client] = latencies.map(|latency| Pipe::new(latency, false));
        let state = Arc::new(Mutex::new(State { to_broker, to_client, is_reset: false }));
        let end = |writes, reads| WireEnd {
            state: state.clone(),
            writes,
            reads,
            sleep: Box::pin(sleep_until(Instant::now())),
        };
        let wire = Self(Arc::downgrade(&state));
        (end(Way::ToBroker, Way::ToClient), end(Way::ToClient, Way::ToBroker), wire)
    }

    fn with(&self, change: impl FnOnce(&mut State)) {
        let Some(state) = self.0.upgrade() else { return };
        let mut state = locked(&state);
        change(&mut state);
        for way in Way::BOTH {
            state.pipe(way).wake();
        }
    }

    /// Whether an end is left.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.0.strong_count() > 0
    }

    /// Cuts or heals a direction. Bytes and the end of the stream are held back, and arrive after the healing. A writer
    /// does not notice until the window of 256 KiB is full.
    pub fn set_cut(&self, way: Way, is_cut: bool) {
        self.with(|state| state.pipe(way).lane.is_held = is_cut);
    }

    /// Sets the latency of bytes that are written from now on.
    pub fn set_latency(&self, way: Way, latency: Duration) {
        self.with(|state| state.pipe(way).latency = latency);
    }

    /// Resets the connection: both ends fail at once, and what is on its way is lost.
    pub fn reset(&self) {
        self.with(|state| state.is_reset = true);
    }

    /// Ends both directions in an orderly way: each end reads what is on its way, and then the end of the stream.
    pub fn close(&self) {
        self.with(|state| {
            for way in Way::BOTH {
                state.pipe(way).finish();
            }
        });
    }
}

/// One end of a connection. Dropping it ends the stream to the other end, whose later bytes fail.
#[derive(Debug)]
pub struct WireEnd {
    state: Arc<Mutex<State>>,
    writes: Way,
    reads: Way,
    /// Ends when the next bytes arrive.
    sleep: Pin<Box<Sleep>>,
}

impl AsyncRead for WireEnd {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let Self { state, reads, sleep, .. } = self.get_mut();
        let mut state = locked(state);
        if state.is_reset {
            return Poll::Ready(Err(io::ErrorKind::ConnectionReset.into()));
        }
        let pipe = state.pipe(*reads);
        loop {
            while let Some(bytes) = pipe.lane.take(Instant::now()) {
                pipe.arrived.push_back(bytes);
            }
            if let Some(front) = pipe.arrived.front_mut() {
                // The end of the stream is empty, and stays.
                let length = front.len().min(buf.remaining());
                buf.put_slice(&front.split_to(length));
                if length > 0 && !front.has_remaining() {
                    pipe.arrived.pop_front();
                }
                pipe.unread -= length;
                if let Some(writer) = pipe.writer.take() {
                    writer.wake();
                }
                return Poll::Ready(Ok(()));
            }
            pipe.reader = Some(context.waker().clone());
            let Some(due) = pipe.lane.due() else { return Poll::Pending };
            sleep.as_mut().reset(due);
            ready!(sleep.as_mut().poll(context));
        }
    }
}

impl AsyncWrite for WireEnd {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let mut state = locked(&self.state);
        if state.is_reset {
            return Poll::Ready(Err(io::ErrorKind::ConnectionReset.into()));
        }
        // The other end's refusal of bytes comes against their direction.
        let is_told = !state.pipe(self.reads).lane.is_held;
        let pipe = state.pipe(self.writes);
        if pipe.is_finished || (pipe.is_unread && is_told) {
            return Poll::Ready(Err(io::ErrorKind::BrokenPipe.into()));
        }
        let length = bytes.len().min(WINDOW.saturating_sub(pipe.unread));
        if length == 0 && !bytes.is_empty() {
            pipe.writer = Some(context.waker().clone());
            return Poll::Pending;
        }
        if length > 0 {
            pipe.push(Bytes::copy_from_slice(&bytes[..length]));
        }
        Poll::Ready(Ok(length))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        locked(&self.state).pipe(self.writes).finish();
        Poll::Ready(Ok(()))
    }
}

impl Drop for WireEnd {
    fn drop(&mut self) {
        let mut state = locked(&self.state);
        state.pipe(self.writes).finish();
        let unread = state.pipe(self.reads);
        unread.is_unread = true;
        unread.wake();
    }
}
