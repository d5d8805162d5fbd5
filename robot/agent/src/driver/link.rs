//! Ways to a driver: a child process, a Unix socket, TCP, a serial device.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rustix::io::Errno;
use rustix::termios::{OptionalActions, ioctl_tiocexcl, tcgetattr, tcsetattr};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::unix::pipe;
use tokio::net::{TcpListener, TcpStream, UnixListener};
use tokio::process::{Child, Command};
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout};
use vibrissa_host::task;
use vibrissa_protocol::plain;

use super::admission::{expect_own_peer, expect_own_server, expect_token, is_trusted};
use crate::config::{DriverConfig, Way};
use vibrissa_program::files::own_uid;

/// Time limit of a TCP connection.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);
/// Connections that may wait for their token at the same time: a silent one does not keep the driver away.
const WAITING_MAX: usize = 8;
/// Time between two logs of refused peers.
const REFUSAL_PAUSE: Duration = Duration::from_secs(60);
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
pub(crate) struct Door {
    endpoint: DriverEndpoint,
    /// The first line of a driver at a TCP port.
    token: Option<Arc<str>>,
    refusal_logged_at: Mutex<Option<Instant>>,
}

enum DriverEndpoint {
    Command(Vec<String>, PathBuf),
    Unix(UnixListener),
    Tcp(String),
    Listen(TcpListener),
    Serial(PathBuf, u32),
}

impl Door {
    /// Prepares the way: begins to listen, if the driver comes to the agent.
    pub(crate) async fn open(driver: &DriverConfig) -> io::Result<Self> {
        let way = &driver.way;
        Self::opened(driver).await.map_err(|problem| worded(&problem, || remedy(way, problem.kind())))
    }

    async fn opened(driver: &DriverConfig) -> io::Result<Self> {
        let endpoint = match &driver.way {
            Way::Command(words) => DriverEndpoint::Command(words.clone(), driver.folder.clone()),
            Way::Unix(path) => DriverEndpoint::Unix(listen_at(path)?),
            Way::Tcp(address) => DriverEndpoint::Tcp(address.clone()),
            Way::Listen(address) => {
                let address: SocketAddr = address.parse().map_err(io::Error::other)?;
                DriverEndpoint::Listen(TcpListener::bind(address).await?)
            }
            Way::Serial(path, baud) => DriverEndpoint::Serial(path.clone(), *baud),
        };
        Ok(Self { endpoint, token: driver.token.as_deref().map(Arc::from), refusal_logged_at: Mutex::default() })
    }

    /// The next link to a driver.
    pub(crate) async fn link(&self) -> io::Result<Link> {
        self.linked().await.map_err(|problem| worded(&problem, || self.remedy(problem.kind())))
    }

    async fn linked(&self) -> io::Result<Link> {
        match &self.endpoint {
            DriverEndpoint::Command(words, folder) => start(words, folder),
            DriverEndpoint::Unix(listener) => loop {
                let stream = listener.accept().await?.0;
                let uid = stream.peer_cred()?.uid();
                if is_trusted(uid) {
                    let (reader, writer) = stream.into_split();
                    return Ok(Link::of(reader, writer, None));
                }
                self.tell_refusal(&format!("the driver belongs to user {uid}: start it as the agent's user"));
            },
            DriverEndpoint::Tcp(address) => {
                let connected = timeout(CONNECT_TIMEOUT, TcpStream::connect(address)).await;
                let mut stream = connected.map_err(|_| io::Error::from(io::ErrorKind::TimedOut))??;
                match &self.token {
                    Some(token) => expect_token(&mut stream, token).await?,
                    // The configuration allows this for loopback addresses only.
                    None => expect_own_server(stream.peer_addr()?, stream.local_addr()?)?,
                }
                of_stream(stream)
            }
            DriverEndpoint::Listen(listener) => self.first_admitted(listener).await,
            DriverEndpoint::Serial(path, baud) => serial(path, *baud),
        }
    }

    fn remedy(&self, kind: ErrorKind) -> Option<String> {
        match (&self.endpoint, kind) {
            (DriverEndpoint::Command(words, _), ErrorKind::NotFound | ErrorKind::PermissionDenied) => {
                let program = words.first().map_or("", String::as_str);
                Some(format!("{program} cannot be started: correct driver.command, or make it a program (chmod +x)"))
            }
            (DriverEndpoint::Tcp(address), ErrorKind::ConnectionRefused) => {
                Some(format!("nothing listens at {address}: start the driver, or correct driver.tcp"))
            }
            (DriverEndpoint::Tcp(address), ErrorKind::TimedOut) => {
                Some(format!("{address} does not answer: check the network, or correct driver.tcp"))
            }
            _ => None,
        }
    }

    /// The first peer that may be the driver.
    async fn first_admitted(&self, listener: &TcpListener) -> io::Result<Link> {
        let mut waiting = JoinSet::new();
        loop {
            tokio::select! {
                accepted = listener.accept(), if waiting.len() < WAITING_MAX => {
                    let (stream, peer) = accepted?;
                    task::spawn_in(&mut waiting, admitted(stream, peer, self.token.clone()));
                }
                Some(ended) = waiting.join_next() => match ended {
                    Ok(Ok(stream)) => return of_stream(stream),
                    Ok(Err(problem)) => self.tell_refusal(&problem.to_string()),
                    Err(problem) => self.tell_refusal(&problem.to_string()),
                },
            }
        }
    }

    /// Logs a refused peer, but not each one: anybody on the machine can come again and again.
    fn tell_refusal(&self, problem: &str) {
        let mut last = self.refusal_logged_at.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_none_or(|at| at.elapsed() >= REFUSAL_PAUSE) {
            *last = Some(Instant::now());
            tracing::warn!("a driver is refused: {problem}");
        }
    }
}

async fn admitted(mut stream: TcpStream, peer: SocketAddr, token: Option<Arc<str>>) -> io::Result<TcpStream> {
    match token {
        Some(token) => expect_token(&mut stream, &token).await?,
        None => expect_own_peer(peer, stream.local_addr()?)?,
    }
    Ok(stream)
}

/// An error in plain words, with what to do where that is known.
fn worded(problem: &io::Error, remedy: impl FnOnce() -> Option<String>) -> io::Error {
    let text = remedy().unwrap_or_else(|| plain::io(problem));
    io::Error::new(problem.kind(), text)
}

/// Remedy for an agent that cannot listen.
fn remedy(way: &Way, kind: ErrorKind) -> Option<String> {
    match (way, kind) {
        (Way::Listen(address), ErrorKind::AddrInUse) => {
            Some(format!("another program listens at {address}: choose another address for driver.listen"))
        }
        (Way::Unix(path), ErrorKind::NotFound | ErrorKind::PermissionDenied) => {
            Some(format!("no socket can be made at {}: correct driver.unix, or make its folder", path.display()))
        }
        _ => None,
    }
}

fn of_stream(stream: TcpStream) -> io::Result<Link> {
    stream.set_nodelay(true)?;
    let (reader, writer) = stream.into_split();
    Ok(Link::of(reader, writer, None))
}

/// Starts a program in the folder of the configuration, so that paths among its arguments are relative to it, too.
fn start(words: &[String], folder: &Path) -> io::Result<Link> {
    let (program, arguments) = words.split_first().ok_or_else(|| io::Error::other("no program is given"))?;
    let mut child = Command::new(absolute(program)?)
        .args(arguments)
        .current_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .kill_on_drop(true)
        .spawn()?;
    let pipe = || io::Error::other("a pipe is missing");
    let (stdin, stdout) = (child.stdin.take().ok_or_else(pipe)?, child.stdout.take().ok_or_else(pipe)?);
    Ok(Link::of(stdout, stdin, Some(child)))
}

/// A program with a folder in its name by its whole path: the folder of the child is another one than the agent's.
fn absolute(program: &str) -> io::Result<PathBuf> {
    if program.contains('/') { std::path::absolute(program) } else { Ok(PathBuf::from(program)) }
}

/// Listens at a Unix socket that only the agent's user can use. A socket that an earlier agent has left is removed, and
/// nothing else: a connection to a file or to the target of a link is refused, too.
pub(crate) fn listen_at(path: &Path) -> io::Result<UnixListener> {
    let shown = path.display();
    match std::fs::symlink_metadata(path) {
        Ok(found) if !found.file_type().is_socket() => {
            return Err(io::Error::other(format!("{shown} exists and is no socket")));
        }
        Ok(found) if found.uid() != own_uid() => {
            let uid = found.uid();
            return Err(io::Error::other(format!("{shown} belongs to user {uid}")));
        }
        Ok(_) => match std::os::unix::net::UnixStream::connect(path) {
            Ok(_) => return Err(io::Error::other(format!("{shown} is in use"))),
            Err(problem) if problem.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path)?,
            Err(problem) => return Err(io::Error::other(format!("{shown} cannot be tried: {problem}"))),
        },
        // `bind` says whether it can be there.
        Err(_) => {}
    }
    let listener = UnixListener::bind(path)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
    Ok(listener)
}

/// Opens a serial device, or a pseudo-terminal in tests.
pub(crate) fn serial(path: &Path, baud: u32) -> io::Result<Link> {
    // O_NONBLOCK also keeps `open` from waiting for a modem; O_NOCTTY keeps a break of the line from ending the agent.
    let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
    let flags = i32::try_from(flags.bits()).map_err(io::Error::other)?;
    let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(path);
    let named =
        |problem: io::Error| io::Error::new(problem.kind(), format!("{}: {}", path.display(), plain::io(&problem)));
    let file = opened.map_err(named)?;
    lock(&file, path)?;
    let mut settings = tcgetattr(&file).map_err(|problem| no_terminal(path, problem))?;
    settings.make_raw();
    settings.set_speed(baud)?;
    tcsetattr(&file, OptionalActions::Flush, &settings)?;
    // For tokio a terminal that does not block is like a pipe.
    let reader = pipe::Receiver::from_file_unchecked(file.try_clone()?)?;
    Ok(Link::of(reader, pipe::Sender::from_file_unchecked(file)?, None))
}

/// Keeps others from a device: two programs would each get a part of its lines. The lock ends with the file. TIOCEXCL
/// binds other programs, too, but not root. A pseudo-terminal keeps it for as long as its other end, so it has none.
fn lock(file: &File, path: &Path) -> io::Result<()> {
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let problem = format!("{} is in use by another program, such as another agent", path.display());
            return Err(io::Error::new(io::ErrorKind::ResourceBusy, problem));
        }
        Err(TryLockError::Error(problem)) => return Err(problem),
    }
    if path.canonicalize().is_ok_and(|path| path.starts_with("/dev/pts")) {
        return Ok(());
    }
    ioctl_tiocexcl(file).map_err(|problem| no_terminal(path, problem))
}

fn no_terminal(path: &Path, problem: Errno) -> io::Error {
    match problem {
        Errno::NOTTY => io::Error::other(format!("{} is no serial device: correct driver.serial", path.display())),
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    use super::*;
    use crate::Config;
    use crate::config::tests::EXAMPLE;

    #[tokio::test]
    async fn regress_only_a_socket_that_nobody_listens_at_is_removed() {
        let folder = std::env::temp_dir().join(format!("vibrissa-robot-socket-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (file, link, socket) = (folder.join("file"), folder.join("link"), folder.join("socket"));
        std::fs::write(&file, "mine").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        for path in [&file, &link, &folder] {
            let refused = listen_at(path).unwrap_err().to_string();
            assert!(refused.contains("is no socket"), "{refused}");
        }
        assert_eq!(std::fs::read(&file).unwrap(), b"mine");
        assert!(link.is_symlink());
        let first = listen_at(&socket).unwrap();
        assert!(listen_at(&socket).unwrap_err().to_string().contains("in use"));
        drop(first);
        // As after a kill.
        drop(listen_at(&socket).unwrap());
        if own_uid() == 0 {
            std::os::unix::fs::chown(&socket, Some(1000), None).unwrap();
            let refused = listen_at(&socket).unwrap_err().to_string();
            assert!(refused.contains("belongs to user 1000"), "{refused}");
            std::os::unix::fs::chown(&socket, Some(0), None).unwrap();
        }
        assert_eq!(std::fs::metadata(&socket).unwrap().permissions().mode() & 0o777, 0o600);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn regress_a_device_has_one_agent() {
        let path = std::env::temp_dir().join(format!("vibrissa-robot-device-{}", std::process::id()));
        let first = File::create(&path).unwrap();
        let second = File::open(&path).unwrap();
        let refused = |file: &File| lock(file, &path).unwrap_err().to_string();
        // It is no terminal, so only the second lock of the first one is refused.
        assert!(!refused(&first).contains("in use"));
        assert!(refused(&second).contains("in use by another program"));
        std::fs::remove_file(&path).unwrap();
    }

    #[tokio::test]
    async fn regress_each_way_that_fails_says_what_to_do() {
        let taken = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = taken.local_addr().unwrap().to_string();
        let path = std::env::temp_dir().join(format!("vibrissa-robot-no-device-{}", std::process::id()));
        std::fs::write(&path, "").unwrap();
        for (way, expected) in [
            (Way::Tcp("127.0.0.1:1".to_owned()), "nothing listens at 127.0.0.1:1: start the driver"),
            (Way::Unix("/nonexistent/socket".into()), "no socket can be made at /nonexistent/socket: correct "),
            (Way::Listen(address.clone()), &format!("another program listens at {address}: choose ")[..]),
            (Way::Serial(path.clone(), 9600), &format!("{} is no serial device: correct ", path.display())[..]),
            (Way::Serial("/nonexistent/tty".into(), 9600), "/nonexistent/tty: No such file or directory"),
        ] {
            let problem = match Door::open(&DriverConfig { way, ..driver() }).await {
                Ok(door) => door.link().await.err().unwrap(),
                Err(problem) => problem,
            };
            assert!(problem.to_string().starts_with(expected), "{problem}");
            assert!(!problem.to_string().contains("os error"), "{problem}");
        }
        // Nothing is started here: a new process holds the sockets and locks of all tests until it has its program.
        let way = Way::Command(vec!["/nonexistent/driver".to_owned()]);
        let door = Door::open(&DriverConfig { way, ..driver() }).await.unwrap();
        let remedy = door.remedy(ErrorKind::NotFound).unwrap();
        assert!(remedy.starts_with("/nonexistent/driver cannot be started: correct "), "{remedy}");
        std::fs::remove_file(&path).unwrap();
    }

    /// The driver of the smallest configuration.
    fn driver() -> DriverConfig {
        let config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        config.drivers.into_iter().next().unwrap()
    }

    async fn door(token: Option<&str>) -> (Door, SocketAddr) {
        let way = Way::Listen("127.0.0.1:0".to_owned());
        let driver = DriverConfig { way, token: token.map(str::to_owned), ..driver() };
        let door = Door::open(&driver).await.unwrap();
        let DriverEndpoint::Listen(listener) = &door.endpoint else { panic!("it listens") };
        let address = listener.local_addr().unwrap();
        (door, address)
    }

    #[tokio::test]
    async fn regress_at_a_port_only_the_peer_with_the_token_becomes_the_driver() {
        let token = "0123456789abcdef";
        let (door, address) = door(Some(token)).await;
        let _silent = TcpStream::connect(address).await.unwrap();
        let mut wrong = TcpStream::connect(address).await.unwrap();
        wrong.write_all(b"{\"type\":\"hello\",\"version\":1}\n").await.unwrap();
        let mut right = TcpStream::connect(address).await.unwrap();
        let lines = format!("{{\"type\":\"token\",\"token\":\"{token}\"}}\nfirst line\n");
        right.write_all(lines.as_bytes()).await.unwrap();
        let mut link = door.link().await.unwrap();
        let mut line = [0; 10];
        link.reader.read_exact(&mut line).await.unwrap();
        assert_eq!(&line, b"first line", "the token is no line");
        let mut received = Vec::new();
        assert_eq!(wrong.read_to_end(&mut received).await.unwrap_or(0), 0, "it hears nothing");
    }

    #[tokio::test]
    async fn without_a_token_the_agent_connects_to_a_program_of_the_same_user() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let way = Way::Tcp(listener.local_addr().unwrap().to_string());
        Door::open(&DriverConfig { way, ..driver() }).await.unwrap().link().await.unwrap();
    }

    #[tokio::test]
    async fn without_a_token_a_program_of_the_same_user_becomes_the_driver() {
        let (door, address) = door(None).await;
        let _driver = TcpStream::connect(address).await.unwrap();
        door.link().await.unwrap();
    }
}
