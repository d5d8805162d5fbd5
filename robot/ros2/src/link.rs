//! The connection to the agent: standard input and output, or a socket on which the agent listens.

use std::fmt;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use serde_json::json;

use crate::bridge::Input;
use crate::words::{LINE_MAX, ToAgent};

/// Time limit for connecting over TCP, and for writing a line to a socket.
const TIMEOUT: Duration = Duration::from_secs(3);
/// Pause before the next attempt to reach the agent.
const PAUSE: Duration = Duration::from_millis(500);

/// An error of the operating system, without its number.
fn without_number(problem: &io::Error) -> String {
    let text = problem.to_string();
    text.split_once(" (os error ").map_or_else(|| text.clone(), |(words, _)| words.to_owned())
}

/// Where the agent is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AgentAddress {
    /// At standard input and output.
    Pipes,
    /// At a Unix socket.
    Unix(PathBuf),
    /// At a TCP port.
    Tcp(SocketAddr),
}

impl FromStr for AgentAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is neither unix:PATH nor tcp:IP:PORT");
        match text.split_once(':') {
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(PathBuf::from(path))),
            Some(("tcp", address)) => address.parse().map(Self::Tcp).map_err(|_| wrong()),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for AgentAddress {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pipes => formatter.write_str("standard input"),
            Self::Unix(path) => write!(formatter, "unix:{}", path.display()),
            Self::Tcp(address) => write!(formatter, "tcp:{address}"),
        }
    }
}

type Reader = Box<dyn Read + Send>;

/// The side of a connection that is written.
struct Writer {
    to: Box<dyn Write + Send>,
    /// Ends the connection for the reader, too.
    end: Box<dyn Fn() + Send>,
}

fn connect(address: &AgentAddress) -> io::Result<(Reader, Writer)> {
    match address {
        AgentAddress::Pipes => Ok((Box::new(io::stdin()), Writer { to: Box::new(io::stdout()), end: Box::new(|| ()) })),
        AgentAddress::Unix(path) => {
            let stream = UnixStream::connect(path)?;
            stream.set_write_timeout(Some(TIMEOUT))?;
            let open = stream.try_clone()?;
            // It may be closed already.
            let end = Box::new(move || drop(open.shutdown(Shutdown::Both)));
            Ok((Box::new(stream.try_clone()?), Writer { to: Box::new(stream), end }))
        }
        AgentAddress::Tcp(address) => {
            let stream = TcpStream::connect_timeout(address, TIMEOUT)?;
            stream.set_nodelay(true)?;
            stream.set_write_timeout(Some(TIMEOUT))?;
            let open = stream.try_clone()?;
            // It may be closed already.
            let end = Box::new(move || drop(open.shutdown(Shutdown::Both)));
            Ok((Box::new(stream.try_clone()?), Writer { to: Box::new(stream), end }))
        }
    }
}

/// Reads lines until the agent closes the connection; returns whether there were any. Of a line longer than
/// [`LINE_MAX`] the first bytes are passed on, one more than permitted, so that the bridge refuses it.
fn read_lines(reader: Reader, inputs: &SyncSender<Input>) -> bool {
    let (mut reader, mut has_heard) = (BufReader::new(reader), false);
    loop {
        let mut bytes = Vec::new();
        let got = reader.by_ref().take(LINE_MAX as u64 + 1).read_until(b'\n', &mut bytes);
        if !got.is_ok_and(|count| count > 0) {
            return has_heard;
        }
        has_heard = true;
        let is_whole = bytes.ends_with(b"\n");
        if !is_whole && bytes.len() > LINE_MAX && reader.skip_until(b'\n').is_err() {
            return has_heard;
        }
        let line = String::from_utf8(bytes).map_err(|_| "the agent sent a line that is not UTF-8".to_owned());
        if inputs.send(Input::Line(line)).is_err() {
            return has_heard;
        }
    }
}

/// The connection to the agent. Each line from the agent becomes an input.
pub struct AgentLink {
    address: AgentAddress,
    writer: Arc<Mutex<Option<Writer>>>,
}

impl AgentLink {
    /// Starts a thread that connects and reads, and that connects again after it has lost a socket. When standard input
    /// ends, `ended` receives whether it had lines.
    #[must_use]
    pub fn open(
        address: AgentAddress,
        token: Option<String>,
        inputs: SyncSender<Input>,
        ended: SyncSender<bool>,
    ) -> Self {
        let link = Self { address, writer: Arc::default() };
        let (address, writer) = (link.address.clone(), Arc::clone(&link.writer));
        thread::spawn(move || {
            let mut logged = String::new();
            loop {
                let problem = match hold(&address, token.as_deref(), &writer, &inputs) {
                    Ok(has_heard) if address == AgentAddress::Pipes => {
                        // If the program is ending already, nobody receives this.
                        let _ = ended.send(has_heard);
                        return;
                    }
                    Ok(_) => "the agent has closed the connection".to_owned(),
                    Err(problem) => without_number(&problem),
                };
                *writer.lock().unwrap_or_else(PoisonError::into_inner) = None;
                if problem != logged {
                    eprintln!("vibrissa-ros2: {address}: {problem}; trying again");
                    logged = problem;
                }
                thread::sleep(PAUSE);
            }
        });
        link
    }

    /// Sends a line. Without a connection the line is dropped, because old readings and contacts are of no use later.
    ///
    /// # Errors
    /// Standard output is closed.
    pub fn say(&self, line: &ToAgent) -> Result<(), String> {
        let mut text = serde_json::to_string(line).map_err(|problem| problem.to_string())?;
        text.push('\n');
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(open) = writer.as_mut() else { return Ok(()) };
        match open.to.write_all(text.as_bytes()).and_then(|()| open.to.flush()) {
            Err(problem) if self.address == AgentAddress::Pipes => Err(format!("the agent is gone: {problem}")),
            Err(_) => {
                // The reader connects again as soon as its side ends.
                (open.end)();
                *writer = None;
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }
}

/// Connects, and reads lines until the connection ends.
fn hold(
    address: &AgentAddress,
    token: Option<&str>,
    shared: &Mutex<Option<Writer>>,
    inputs: &SyncSender<Input>,
) -> io::Result<bool> {
    let (reader, mut writer) = connect(address)?;
    if let Some(token) = token {
        writeln!(writer.to, "{}", json!({ "type": "token", "token": token }))?;
        writer.to.flush()?;
    }
    *shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(writer);
    inputs.send(Input::Linked).map_err(io::Error::other)?;
    Ok(read_lines(reader, inputs))
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// After a failed write the reader stayed with the old socket, and all lines were dropped until the agent closed it.
    #[test]
    fn regress_the_end_of_writing_is_the_end_of_reading() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let (mut reader, writer) = connect(&AgentAddress::Tcp(listener.local_addr().unwrap())).unwrap();
        let _agent = listener.accept().unwrap();
        (writer.end)();
        assert_eq!(reader.read(&mut [0]).unwrap(), 0);
    }
}
