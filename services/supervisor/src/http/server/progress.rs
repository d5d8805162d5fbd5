//! Phase and deadline of a connection. Both a slow request and a slowly read answer must end in time.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use bytes::Bytes;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::Instant;

use super::registry::Slot;

/// How long a connection may stay open without a byte of a request, whether it is new or waits for the next request.
pub(super) const IDLE_PATIENCE: Duration = Duration::from_secs(60);
/// How long the head of a request may take from its first byte to its last.
const HEAD_PATIENCE: Duration = Duration::from_secs(10);
/// Longest time in which a client may read nothing of an answer.
const ANSWER_PATIENCE: Duration = Duration::from_secs(20);
/// Rate at which a client must read an answer once that time is used up, in bytes per second.
const ANSWER_BYTES_PER_S: u32 = 8 * 1024;

/// The server's reason for closing a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slow {
    /// No request came in time.
    Idle,
    /// The head of a request was not complete in time.
    Head,
    /// The client did not read the answer in time.
    Answer,
}

/// Phase and deadline of one connection.
#[derive(Debug)]
pub(super) struct Progress {
    place: Slot,
    state: Mutex<State>,
}

#[derive(Debug, Clone, Copy)]
struct State {
    phase: Phase,
    since: Instant,
    /// Since when the client has read nothing while an answer waits to be written.
    blocked: Option<Instant>,
    /// Remaining time in which the client may read nothing.
    allowance: Duration,
    /// Whether the last request had a body. Its unread rest is not a new request.
    had_body: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// No byte of the next request is there.
    Idle,
    /// A part of a request's head is there.
    Head,
    /// A request is complete, and its answer is not.
    Request,
}

impl Progress {
    pub(super) fn new(place: Slot, since: Instant) -> Arc<Self> {
        let state = State { phase: Phase::Idle, since, blocked: None, allowance: ANSWER_PATIENCE, had_body: false };
        Arc::new(Self { place, state: Mutex::new(state) })
    }

    /// Marks a complete request, which is under way until the returned guard is dropped.
    pub(super) fn request(self: &Arc<Self>, has_body: bool) -> UnderWay {
        self.place.serve();
        let mut state = self.state();
        (state.phase, state.had_body) = (Phase::Request, has_body);
        drop(state);
        UnderWay(self.clone())
    }

    /// Whether no complete request is under way and the client has read all answers.
    pub(super) fn is_waiting(&self) -> bool {
        let state = self.state();
        state.phase != Phase::Request && state.blocked.is_none()
    }

    /// Whether the request buffers can be freed: no byte of the next request has arrived, and the last request and its
    /// answer are complete.
    pub(super) fn is_idle(&self) -> bool {
        let state = self.state();
        state.phase == Phase::Idle && state.blocked.is_none() && !state.had_body
    }

    /// Time at which the connection is closed, and the reason; `None` while a request is under way and its answer is
    /// being read.
    pub(super) fn deadline(&self) -> Option<(Instant, Slow)> {
        let State { phase, since, blocked, allowance, .. } = *self.state();
        match (blocked, phase) {
            (Some(blocked), _) => Some((blocked + allowance, Slow::Answer)),
            (None, Phase::Idle) => Some((since + IDLE_PATIENCE, Slow::Idle)),
            (None, Phase::Head) => Some((since + HEAD_PATIENCE, Slow::Head)),
            (None, Phase::Request) => None,
        }
    }

    fn read(&self, bytes: usize, now: Instant) {
        let mut state = self.state();
        if bytes > 0 && state.phase == Phase::Idle {
            (state.phase, state.since) = (Phase::Head, now);
        }
    }

    fn wrote(&self, bytes: usize, now: Instant) {
        let mut state = self.state();
        let waited = state.blocked.take().map_or(Duration::ZERO, |blocked| now - blocked);
        let earned = Duration::from_secs(bytes as u64) / ANSWER_BYTES_PER_S;
        state.allowance = (state.allowance.saturating_sub(waited) + earned).min(ANSWER_PATIENCE);
    }

    fn could_not_write(&self, now: Instant) {
        self.state().blocked.get_or_insert(now);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A request under way.
#[derive(Debug)]
pub(super) struct UnderWay(Arc<Progress>);

impl Drop for UnderWay {
    fn drop(&mut self) {
        let mut state = self.0.state();
        (state.phase, state.since) = (Phase::Idle, Instant::now());
        drop(state);
        self.0.place.wait();
    }
}

/// A TCP stream that reports its reads and writes to `Progress`.
#[derive(Debug)]
pub(super) struct Followed {
    pub(super) stream: TcpStream,
    /// Bytes read after the last request: the beginning of the next one.
    pub(super) unread: Bytes,
    progress: Arc<Progress>,
}

impl AsyncRead for Followed {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        if !self.unread.is_empty() {
            let length = self.unread.len().min(buffer.remaining());
            buffer.put_slice(&self.unread.split_to(length));
            self.progress.read(length, Instant::now());
            return Poll::Ready(Ok(()));
        }
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(cx, buffer);
        if read.is_ready() {
            self.progress.read(buffer.filled().len() - before, Instant::now());
        }
        read
    }
}

impl Followed {
    pub(super) fn new(stream: TcpStream, progress: Arc<Progress>) -> Self {
        Self { stream, unread: Bytes::new(), progress }
    }

    /// Puts bytes that were already read from the stream before the rest. Copies them: a slice of a read buffer, even an
    /// empty one, keeps the whole buffer allocated while the connection is idle.
    pub(super) fn behind(self, read: &[u8]) -> Self {
        let unread = [read, &self.unread].concat().into();
        Self { unread, ..self }
    }

    fn written(&self, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        match &written {
            Poll::Ready(Ok(bytes)) => self.progress.wrote(*bytes, Instant::now()),
            Poll::Ready(Err(_)) => {}
            Poll::Pending => self.progress.could_not_write(Instant::now()),
        }
        written
    }
}

impl AsyncWrite for Followed {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.written(written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, parts);
        self.written(written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

#[cfg(test)]
mod tests {
    use super::super::registry::{Limits, Registry};
    use super::*;
    use crate::metrics::Metrics;

    fn progress(now: Instant) -> Arc<Progress> {
        let registry = Registry::new(Limits::default(), Metrics::new(false).unwrap().http.connections("main"));
        Progress::new(registry.admit([127, 0, 0, 1].into()).unwrap().place, now)
    }

    #[test]
    fn a_head_has_its_time_from_its_first_byte_however_many_follow() {
        let begin = Instant::now();
        let progress = progress(begin);
        assert_eq!(progress.deadline(), Some((begin + IDLE_PATIENCE, Slow::Idle)));
        let first = begin + Duration::from_secs(3);
        for more in 0..5 {
            progress.read(1, first + Duration::from_secs(more));
            assert_eq!(progress.deadline(), Some((first + HEAD_PATIENCE, Slow::Head)));
        }
        assert!(progress.is_waiting());
    }

    #[test]
    fn a_request_under_way_has_no_end_and_then_the_connection_is_idle() {
        let begin = Instant::now();
        let progress = progress(begin);
        progress.read(100, begin);
        let request = progress.request(false);
        assert_eq!((progress.deadline(), progress.is_waiting()), (None, false));
        // The next request arrives before this one is answered.
        progress.read(100, begin);
        assert_eq!(progress.deadline(), None);
        drop(request);
        let (deadline, slow) = progress.deadline().unwrap();
        assert!(slow == Slow::Idle && deadline >= begin + IDLE_PATIENCE && progress.is_waiting());
        assert!(progress.is_idle());
    }

    /// The rest of the body would be parsed as a request.
    #[test]
    fn a_connection_whose_last_request_had_a_body_stays_with_its_reader() {
        let progress = progress(Instant::now());
        drop(progress.request(true));
        assert!(progress.is_waiting() && !progress.is_idle());
        drop(progress.request(false));
        assert!(progress.is_idle());
    }

    #[test]
    fn an_answer_must_be_taken_at_a_pace() {
        let begin = Instant::now();
        let progress = progress(begin);
        let _request = progress.request(false);
        progress.could_not_write(begin);
        assert_eq!(progress.deadline(), Some((begin + ANSWER_PATIENCE, Slow::Answer)));
        // Single bytes earn next to nothing.
        let mut now = begin;
        for _ in 0..4 {
            now += Duration::from_secs(5);
            progress.wrote(1, now);
            assert_eq!(progress.deadline(), None);
            progress.could_not_write(now);
        }
        let (deadline, _) = progress.deadline().unwrap();
        assert!(deadline < now + Duration::from_secs(1), "{:?}", deadline - now);
        // Reading at the required pace restores the whole allowance, and no more.
        progress.wrote(1024 * 1024, now);
        progress.could_not_write(now);
        assert_eq!(progress.deadline(), Some((now + ANSWER_PATIENCE, Slow::Answer)));
    }
}
