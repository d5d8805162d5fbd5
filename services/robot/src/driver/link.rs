//! Ways to a driver: a child process, a Unix socket, TCP, a serial device.

use std::fs::OpenOptions;
use std::io;
use std::net::SocketAddr;
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::unix::pipe;
use tokio::net::{TcpListener, TcpStream, UnixListener};
use tokio::process::{Child, Command};
use tokio::time::timeout;

use crate::config::Way;

/// Time limit of a TCP connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);
/// Time that a child process has to end once its input is closed.
const END_TIMEOUT: Duration = Duration::from_secs(1);

/// An open way to a driver.
pub(crate) struct Link {
    pub(crate) reader: Box<dyn AsyncRead + Send + Unpin>,
    pub(crate) writer: Box<dyn AsyncWrite + Send + Unpin>,
    /// The driver, if it is a child process. It is killed when it is dropped.
    pub(crate) child: Option<Child>,
}

impl Link {
    fn of<R, W>(reader: R, writer: W, child: Option<Child>) -> Self
    where
        R: AsyncRead + Send + Unpin + 'static,
        W: AsyncWrite + Send + Unpin + 'static,
    {
        Self { reader: Box::new(reader), writer: Box::new(writer), child }
    }

    /// Ends the link. A child process may end by itself when its input is closed; otherwise it is killed.
    pub(crate) async fn close(self) {
        drop((self.reader, self.writer));
        if let Some(mut child) = self.child
            && timeout(END_TIMEOUT, child.wait()).await.is_err()
            && let Err(problem) = child.kill().await
        {
            tracing::warn!(%problem, "cannot kill the driver");
        }
    }
}

/// A place at which drivers can be reached.
pub(crate) enum Door {
    Command(Vec<String>),
    Unix(UnixListener),
    Tcp(String),
    Listen(TcpListener),
    Serial(PathBuf, u32),
}

impl Door {
    /// Prepares the way: begins to listen, if the driver comes to the agent.
    pub(crate) async fn open(way: &Way) -> io::Result<Self> {
        Ok(match way {
            Way::Command(words) => Self::Command(words.clone()),
            Way::Unix(path) => Self::Unix(listen_at(path)?),
            Way::Tcp(address) => Self::Tcp(address.clone()),
            Way::Listen(address) => {
                let address: SocketAddr = address.parse().map_err(io::Error::other)?;
                Self::Listen(TcpListener::bind(address).await?)
            }
            Way::Serial(path, baud) => Self::Serial(path.clone(), *baud),
        })
    }

    /// The next link to a driver.
    pub(crate) async fn link(&self) -> io::Result<Link> {
        match self {
            Self::Command(words) => start(words),
            Self::Unix(listener) => {
                let (reader, writer) = listener.accept().await?.0.into_split();
                Ok(Link::of(reader, writer, None))
            }
            Self::Tcp(address) => {
                let connected = timeout(CONNECT_TIMEOUT, TcpStream::connect(address)).await;
                of_stream(connected.map_err(|_| io::Error::from(io::ErrorKind::TimedOut))??)
            }
            Self::Listen(listener) => of_stream(listener.accept().await?.0),
            Self::Serial(path, baud) => serial(path, *baud),
        }
    }
}

fn of_stream(stream: TcpStream) -> io::Result<Link> {
    stream.set_nodelay(true)?;
    let (reader, writer) = stream.into_split();
    Ok(Link::of(reader, writer, None))
}

fn start(words: &[String]) -> io::Result<Link> {
    let (program, arguments) = words.split_first().ok_or_else(|| io::Error::other("no program is given"))?;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .kill_on_drop(true)
        .spawn()?;
    let pipe = || io::Error::other("a pipe is missing");
    let (stdin, stdout) = (child.stdin.take().ok_or_else(pipe)?, child.stdout.take().ok_or_else(pipe)?);
    Ok(Link::of(stdout, stdin, Some(child)))
}

/// Listens at a Unix socket that only the agent's user can use. A socket that an earlier agent has left is removed.
fn listen_at(path: &Path) -> io::Result<UnixListener> {
    match std::os::unix::net::UnixStream::connect(path) {
        Ok(_) => return Err(io::Error::other(format!("{} is in use", path.display()))),
        Err(problem) if problem.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path)?,
        // It is not there, or it is no socket, which `bind` says.
        Err(_) => {}
    }
    let listener = UnixListener::bind(path)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
    Ok(listener)
}

/// Opens a serial device, or a pseudo-terminal in tests.
fn serial(path: &Path, baud: u32) -> io::Result<Link> {
    // O_NONBLOCK also keeps `open` from waiting for a modem; O_NOCTTY keeps a break of the line from ending the agent.
    let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
    let flags = i32::try_from(flags.bits()).map_err(io::Error::other)?;
    let file = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path)?;
    let mut settings = tcgetattr(&file)?;
    settings.make_raw();
    settings.set_speed(baud)?;
    tcsetattr(&file, OptionalActions::Flush, &settings)?;
    // For tokio a terminal that does not block is like a pipe.
    let reader = pipe::Receiver::from_file_unchecked(file.try_clone()?)?;
    Ok(Link::of(reader, pipe::Sender::from_file_unchecked(file)?, None))
}
