//! Runs a board over stdin and stdout, TCP or a pseudo-terminal.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::pin::pin;
use std::time::Duration;

use anyhow::Context;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, Stdin, stdin, stdout};
use tokio::net::unix::pipe;
use tokio::net::{TcpListener, TcpStream};
use tokio::signal::unix::{SignalKind, signal};
use tokio::time::sleep;
use vibrissa_robot::driver::Lines;

use super::{Board, BoardPlan, Doing};
use crate::clock::now_us;
use crate::{RobotConfig, Scenario};

/// Pause between two attempts to reach the agent.
const AGAIN: Duration = Duration::from_millis(250);
/// Time after which a board without an agent looks after its valves.
const ALONE: Duration = Duration::from_millis(10);

type Reader = Box<dyn AsyncRead + Unpin>;
type Writer = Box<dyn AsyncWrite + Unpin>;

/// Runs a board until its agent has gone (stdin and stdout) or it is stopped. SIGUSR1 cuts a whisker, and SIGUSR2 closes the
/// air supply, or opens it again.
///
/// # Errors
/// The scenario is invalid, or the way to the agent cannot be opened.
pub async fn run(plan: BoardPlan) -> anyhow::Result<()> {
    let path = plan.scenario.display();
    let text = std::fs::read_to_string(&plan.scenario).with_context(|| format!("cannot read {path}"))?;
    let scenario = Scenario::from_toml_str(&text).with_context(|| format!("cannot simulate {path}"))?;
    let is_asked = |config: &RobotConfig| plan.robot.as_ref().is_none_or(|name| config.robot.robot.as_str() == name);
    let config = RobotConfig::all(&scenario).find(is_asked).context("the scenario has no such robot")?;
    let array = config.robot.arrays[0].array.clone();
    let watchdog_us = (plan.watchdog_s.max(0.1) * 1e6) as u64;
    let mut board = Board::new(config, scenario.seed, watchdog_us, now_us())?;
    if plan.strain {
        board = board.sampling(scenario.seed, now_us());
    }
    if plan.valves {
        board = board.with_valves(scenario.seed, plan.supply_mpa, plan.leak_mpa_per_s, now_us());
    }
    if let Some(ratio) = plan.touch_ratio {
        board = board.touched_at(ratio);
    }
    let log = plan.log_file.as_ref().map(|path| OpenOptions::new().create(true).append(true).open(path)).transpose();
    let mut log = Log(log.context("--log-file")?);

    let mut cut = signal(SignalKind::user_defined1())?;
    let mut supply = signal(SignalKind::user_defined2())?;
    let mut control = Control { input: stdin(), lines: Lines::default(), waiting: VecDeque::new() };
    let door = Door::open(&plan).await?;
    loop {
        let (mut reader, mut writer) = match linked(&door, &mut board, &mut log).await {
            Ok(link) => link,
            Err(_) => {
                sleep(AGAIN).await;
                continue;
            }
        };
        let (mut lines, mut buffer) = (Lines::default(), vec![0; 4096]);
        let started = json!({"log": "started", "pid": std::process::id(), "t_us": now_us()});
        let hello = vec![Doing::Log(started), Doing::Say(board.hello())];
        let mut is_linked = log.carry(hello, &mut writer).await;
        while is_linked {
            let ahead = Duration::from_micros(board.next_deadline().saturating_sub(now_us()));
            let doings = tokio::select! {
                read = reader.read(&mut buffer) => match read {
                    Ok(0) | Err(_) => break,
                    Ok(read) => {
                        let lines = lines.push(&buffer[..read]);
                        lines.into_iter().flatten().flat_map(|line| board.line(&line, now_us())).collect()
                    }
                },
                _ = cut.recv() => {
                    board.cut(&array, plan.cut_whisker, plan.cut_mm, now_us()).into_iter().collect()
                }
                _ = supply.recv() => board.turn_supply(now_us()),
                line = control.next(), if !door.is_stdio() => board.line(&line, now_us()),
                () = sleep(ahead) => board.poll(now_us()),
            };
            is_linked = log.carry(doings, &mut writer).await;
        }
        if door.is_stdio() {
            return Ok(());
        }
    }
}

/// Waits for the agent. Air moves meanwhile, and valves close.
async fn linked(door: &Door, board: &mut Board, log: &mut Log) -> std::io::Result<(Reader, Writer)> {
    let mut link = pin!(door.link());
    loop {
        tokio::select! {
            link = &mut link => return link,
            () = sleep(ALONE) => board.alone(now_us()).into_iter().for_each(|doing| log.keep(&doing)),
        }
    }
}

/// The log of the board.
struct Log(Option<File>);

impl Log {
    /// Logs and says; false if the agent has gone.
    async fn carry(&mut self, doings: Vec<Doing>, writer: &mut Writer) -> bool {
        let mut said = Vec::new();
        for doing in doings {
            self.keep(&doing);
            if let Doing::Say(line) = doing {
                said.extend(bytes(&line));
            }
        }
        writer.write_all(&said).await.is_ok() && writer.flush().await.is_ok()
    }

    /// Writes the line of an action to the log.
    fn keep(&mut self, doing: &Doing) {
        if let (Doing::Log(line), Some(file)) = (doing, &mut self.0) {
            // A log that cannot be written would make the test that reads it fail.
            file.write_all(&bytes(line)).unwrap_or_default();
        }
    }
}

fn bytes(line: &Value) -> Vec<u8> {
    let mut line = line.to_string().into_bytes();
    line.push(b'\n');
    line
}

/// Lines of stdin.
struct Control {
    input: Stdin,
    lines: Lines,
    waiting: VecDeque<Vec<u8>>,
}

impl Control {
    /// The next line; pending forever once the input has ended.
    async fn next(&mut self) -> Vec<u8> {
        let mut buffer = [0; 1024];
        loop {
            if let Some(line) = self.waiting.pop_front() {
                return line;
            }
            match self.input.read(&mut buffer).await {
                Ok(0) | Err(_) => std::future::pending().await,
                Ok(read) => self.waiting.extend(self.lines.push(&buffer[..read]).into_iter().flatten()),
            }
        }
    }
}

/// The way to the agent.
enum Door {
    Stdio,
    Connect(String),
    Listen(TcpListener),
    Pty { master: File, _device: File },
}

impl Door {
    async fn open(plan: &BoardPlan) -> anyhow::Result<Self> {
        Ok(match (&plan.connect, &plan.listen, &plan.pty) {
            (Some(address), ..) => Self::Connect(address.clone()),
            (_, Some(address), _) => {
                Self::Listen(TcpListener::bind(address).await.with_context(|| format!("--listen {address}"))?)
            }
            (.., Some(link)) => {
                use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
                let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
                grantpt(&master)?;
                unlockpt(&master)?;
                let device = ptsname(&master, Vec::new())?.into_string()?;
                // Held open, so that the terminal stays when the agent closes it; raw, so that nothing is echoed.
                let held = OpenOptions::new().read(true).write(true).open(&device)?;
                let mut settings = rustix::termios::tcgetattr(&held)?;
                settings.make_raw();
                rustix::termios::tcsetattr(&held, rustix::termios::OptionalActions::Now, &settings)?;
                let flags = rustix::fs::fcntl_getfl(&master)?;
                rustix::fs::fcntl_setfl(&master, flags | rustix::fs::OFlags::NONBLOCK)?;
                // A link to a terminal is that of an earlier board; any other one stays.
                if std::fs::read_link(link).is_ok_and(|to| to.starts_with("/dev/pts")) {
                    std::fs::remove_file(link)?;
                }
                std::os::unix::fs::symlink(&device, link).with_context(|| format!("--pty {}", link.display()))?;
                Self::Pty { master: master.into(), _device: held }
            }
            (None, None, None) => Self::Stdio,
        })
    }

    fn is_stdio(&self) -> bool {
        matches!(self, Self::Stdio)
    }

    async fn link(&self) -> std::io::Result<(Reader, Writer)> {
        let of = |stream: TcpStream| -> (Reader, Writer) {
            let (reader, writer) = stream.into_split();
            (Box::new(reader), Box::new(writer))
        };
        Ok(match self {
            Self::Stdio => (Box::new(stdin()), Box::new(stdout())),
            Self::Connect(address) => of(TcpStream::connect(address).await?),
            Self::Listen(listener) => of(listener.accept().await?.0),
            Self::Pty { master, .. } => (
                Box::new(pipe::Receiver::from_file_unchecked(master.try_clone()?)?),
                Box::new(pipe::Sender::from_file_unchecked(master.try_clone()?)?),
            ),
        })
    }
}
