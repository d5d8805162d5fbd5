//! Connections of clients to the log.

use std::io;
use std::pin::pin;
use std::time::Duration;

use bytes::{Buf, Bytes, BytesMut};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio::time::{Instant, timeout_at};

use super::requests::Request;
use super::{ModelLog, State};

/// Longest request.
const REQUEST_BYTES_MAX: usize = 1 << 20;

impl ModelLog {
    /// Whether it accepts connections.
    #[must_use]
    pub fn is_accepting(&self) -> bool {
        !self.state().is_down
    }

    /// Serves a client on a byte stream until one side ends the connection.
    ///
    /// # Errors
    /// The stream breaks, or the client sends something that is no request of a reader.
    pub async fn serve(&self, stream: impl AsyncRead + AsyncWrite) -> io::Result<()> {
        tokio::select! {
            biased;
            () = self.until(|state| state.is_down) => Err(io::ErrorKind::ConnectionReset.into()),
            ended = self.requests(stream) => ended,
        }
    }

    /// Serves TCP connections in real time, to compare this log with real ones. Ends only with an error.
    ///
    /// # Errors
    /// The listener fails.
    pub async fn listen(&self, listener: TcpListener) -> io::Result<()> {
        loop {
            let (stream, _) = listener.accept().await?;
            let log = self.clone();
            vibrissa_host::task::spawn(async move { log.serve(stream).await });
        }
    }

    /// Answers requests in their order.
    async fn requests(&self, stream: impl AsyncRead + AsyncWrite) -> io::Result<()> {
        let mut stream = pin!(stream);
        let mut bytes = BytesMut::new();
        loop {
            let Some(frame) = frame(&mut bytes)? else {
                if stream.read_buf(&mut bytes).await? == 0 {
                    return Ok(());
                }
                continue;
            };
            let request = Request::read(frame).ok_or(io::ErrorKind::InvalidData)?;
            let due = Instant::now() + Duration::from_millis(request.wait_ms());
            let answer = loop {
                self.until(|state| !state.is_frozen).await;
                let changed = self.0.changed.notified();
                let (answer, has_news) = request.answer(self);
                if has_news || timeout_at(due, changed).await.is_err() {
                    break answer;
                }
            };
            self.until(|state| !state.is_frozen).await;
            stream.write_i32(answer.len() as i32).await?;
            stream.write_all(&answer).await?;
            stream.flush().await?;
        }
    }

    async fn until(&self, is_so: impl Fn(&State) -> bool + Send) {
        loop {
            let changed = self.0.changed.notified();
            if is_so(&self.state()) {
                return;
            }
            changed.await;
        }
    }
}

/// The next whole request.
fn frame(bytes: &mut BytesMut) -> io::Result<Option<Bytes>> {
    let Some(length) = bytes.first_chunk().map(|length| i32::from_be_bytes(*length)) else { return Ok(None) };
    let length = usize::try_from(length).ok().filter(|length| *length <= REQUEST_BYTES_MAX);
    let length = length.ok_or(io::ErrorKind::InvalidData)?;
    if bytes.len() < 4 + length {
        return Ok(None);
    }
    bytes.advance(4);
    Ok(Some(bytes.split_to(length).freeze()))
}
