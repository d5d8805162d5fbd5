//! A minimal HTTP client.

use std::collections::BTreeMap;
use std::io;
use std::net::SocketAddr;

use serde_json::Value;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;

/// An HTTP answer.
#[derive(Debug, Clone)]
pub struct Answer {
    /// HTTP status code.
    pub status: u16,
    /// Headers, with names in lower case.
    pub headers: BTreeMap<String, String>,
    /// Body as text.
    pub body: String,
}

impl Answer {
    /// Parses the body as JSON.
    ///
    /// # Panics
    /// The body is not JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|problem| panic!("{problem}: {}", self.body))
    }
}

/// Sends a request with a method and headers, without a body.
///
/// # Errors
/// The server does not answer, or not in HTTP.
pub async fn ask(address: SocketAddr, method: &str, path: &str, headers: &[(&str, &str)]) -> io::Result<Answer> {
    send(address, method, path, headers, None).await
}

/// Sends a request with a method, headers, and a JSON body.
///
/// # Errors
/// The server does not answer, or not in HTTP.
pub async fn send(
    address: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: Option<&Value>,
) -> io::Result<Answer> {
    let body = body.map(ToString::to_string);
    let mut stream = TcpStream::connect(address).await?;
    let headers: String = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
    let typed =
        body.as_ref().map(|body| format!("Content-Type: application/json\r\nContent-Length: {}\r\n", body.len()));
    let host = if headers.to_ascii_lowercase().lines().any(|line| line.starts_with("host:")) {
        String::new()
    } else {
        format!("Host: {address}\r\n")
    };
    let (typed, body) = (typed.unwrap_or_default(), body.unwrap_or_default());
    let request = format!("{method} {path} HTTP/1.1\r\n{host}{headers}{typed}Connection: close\r\n\r\n{body}");
    stream.write_all(request.as_bytes()).await?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await?;
    let bad = || io::Error::other(format!("no HTTP: {answer}"));
    let (head, body) = answer.split_once("\r\n\r\n").ok_or_else(bad)?;
    let mut lines = head.lines();
    let status = lines.next().and_then(|line| line.split(' ').nth(1)?.parse().ok()).ok_or_else(bad)?;
    let headers = lines.filter_map(|line| line.split_once(": "));
    let headers: BTreeMap<String, String> =
        headers.map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned())).collect();
    let is_chunked = headers.get("transfer-encoding").is_some_and(|encoding| encoding == "chunked");
    let body = if is_chunked { dechunked(body).ok_or_else(bad)? } else { body.to_owned() };
    Ok(Answer { status, headers, body })
}

/// The body without the sizes of its chunks; `None` if its end is missing.
fn dechunked(mut body: &str) -> Option<String> {
    let mut text = String::new();
    loop {
        let (size, rest) = body.split_once("\r\n")?;
        let size = usize::from_str_radix(size, 16).ok()?;
        if size == 0 {
            return Some(text);
        }
        text.push_str(rest.get(..size)?);
        body = rest.get(size..)?.strip_prefix("\r\n")?;
    }
}

/// Sends a GET whose answer is an endless stream. Returns its status and the events that follow.
///
/// # Errors
/// The server does not answer, or not in HTTP.
pub async fn open(address: SocketAddr, path: &str, headers: &[(&str, &str)]) -> io::Result<(u16, Events)> {
    let mut stream = BufReader::new(TcpStream::connect(address).await?);
    let headers: String = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n{headers}\r\n");
    stream.get_mut().write_all(request.as_bytes()).await?;
    let mut line = String::new();
    stream.read_line(&mut line).await?;
    let status = line.split(' ').nth(1).and_then(|status| status.parse().ok());
    let status = status.ok_or_else(|| io::Error::other(format!("no HTTP: {line}")))?;
    while !line.trim().is_empty() {
        line.clear();
        stream.read_line(&mut line).await?;
    }
    Ok((status, Events(stream)))
}

/// A stream of server-sent events.
#[derive(Debug)]
pub struct Events(BufReader<TcpStream>);

/// A server-sent event.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ServerEvent {
    /// Name of the event.
    pub event: String,
    /// Id of the event.
    pub id: String,
    /// Data of the event.
    pub data: String,
}

impl Events {
    /// The next event. None once the server has ended the stream.
    ///
    /// # Errors
    /// The connection is broken.
    pub async fn next(&mut self) -> io::Result<Option<ServerEvent>> {
        let mut event = ServerEvent::default();
        let mut line = String::new();
        loop {
            line.clear();
            if self.0.read_line(&mut line).await? == 0 {
                return Ok(None);
            }
            match line.trim_end().split_once(": ") {
                Some(("event", text)) => text.clone_into(&mut event.event),
                Some(("id", text)) => text.clone_into(&mut event.id),
                Some(("data", text)) => text.clone_into(&mut event.data),
                // An empty line ends an event; a comment or the size of a chunk is skipped.
                _ if line.trim_end().is_empty() && !event.event.is_empty() => return Ok(Some(event)),
                _ => {}
            }
        }
    }
}

/// Status and body of the answer to a GET request.
///
/// # Errors
/// The server does not answer, or not in HTTP.
pub async fn try_get(address: SocketAddr, path: &str) -> io::Result<(u16, String)> {
    ask(address, "GET", path, &[]).await.map(|answer| (answer.status, answer.body))
}
