//! The links to the drivers: each has a task of its own, so that none waits for another one.

use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{Notify, mpsc};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep};

use super::Hub;
use crate::Input;
use crate::config::{DriverConfig, Way};
use crate::driver::link::{Door, Link};
use crate::driver::{Lines, ToDriver};

/// Most lines that wait for the driver. A driver that reads none of so many hangs.
const TELLING_MAX: usize = 1024;
/// Pauses between two attempts to reach the driver.
const LINK_PAUSE: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(10));
/// A driver that lived for this long gets the shortest pause again.
const LIVED: Duration = Duration::from_secs(10);
/// Time between two logs of refused lines.
const REFUSAL_PAUSE: Duration = Duration::from_secs(60);
/// Pause after each line to a serial device: its buffer has 64 bytes on many boards, whose programs read it once in a
/// turn of their loop. A driver whose valves the agent opens gets its lines at once.
const SERIAL_PAUSE: Duration = Duration::from_millis(20);
/// If more lines wait, they go without a pause.
const PACED_MAX: usize = 64;
/// Bytes that are read from the driver at once.
const CHUNK_BYTES: usize = 4096;

/// The link to a driver, as the others see it.
pub(super) struct DriverLink {
    label: String,
    /// Lines to it while it can be heard.
    telling: Option<mpsc::Sender<Vec<u8>>>,
    /// Asks its task to end the link: each link has its own, so that no request remains for the next one.
    pub(super) restart: Arc<Notify>,
    /// Time at which a refused line of it was last logged.
    refusal_logged_at: Option<Instant>,
}

impl DriverLink {
    pub(super) fn new(config: &DriverConfig) -> Self {
        Self { label: config.label.clone(), telling: None, restart: Arc::default(), refusal_logged_at: None }
    }

    /// A link begins: the lines for it, and the requests to end it.
    fn begin(&mut self) -> (mpsc::Receiver<Vec<u8>>, Arc<Notify>) {
        let (sender, lines) = mpsc::channel(TELLING_MAX);
        (self.telling, self.restart) = (Some(sender), Arc::default());
        (lines, self.restart.clone())
    }

    pub(super) fn tell(&mut self, line: &ToDriver, refused: u64) {
        self.tell_refusal(line, refused);
        if let Some(telling) = &self.telling
            && telling.try_send(line.line()).is_err()
        {
            tracing::warn!("{} reads nothing", self.label);
            self.restart.notify_one();
        }
    }

    /// Logs a refused line, but not each one: a faulty driver may send thousands a second.
    fn tell_refusal(&mut self, line: &ToDriver, refused: u64) {
        let ToDriver::Error { line, problem, remedy } = line else { return };
        if self.refusal_logged_at.is_some_and(|at| at.elapsed() < REFUSAL_PAUSE) {
            return;
        }
        self.refusal_logged_at = Some(Instant::now());
        let label = &self.label;
        tracing::warn!("line {line} of {label} is refused ({refused} since the start): {problem}: {remedy}");
    }
}

/// The pause after each line to a driver.
fn pause_of(config: &DriverConfig) -> Duration {
    let is_slow = matches!(config.way, Way::Serial(..)) && !config.limits.regulate;
    if is_slow { SERIAL_PAUSE } else { Duration::ZERO }
}

/// Writes lines until their senders have gone, or until a write fails. The end of the driver's output ends the link, so
/// its last lines are still read.
async fn write_lines(
    writer: &mut (impl AsyncWrite + Unpin + ?Sized),
    lines: &mut mpsc::Receiver<Vec<u8>>,
    pause: Duration,
) {
    while let Some(line) = lines.recv().await {
        if writer.write_all(&line).await.is_err() || writer.flush().await.is_err() {
            break;
        }
        if !pause.is_zero() && lines.len() <= PACED_MAX {
            sleep(pause).await;
        }
    }
}

/// Waits for the tasks of all drivers, which end only by a panic.
pub(super) async fn all_ended(driving: &mut JoinSet<()>) {
    while let Some(ended) = driving.join_next().await {
        if let Err(problem) = ended {
            tracing::error!(%problem, "the task of a driver has ended: its whiskers are not served any more");
        }
    }
}

impl Hub {
    /// Reaches a driver again and again.
    pub(super) async fn drive(self, driver: usize, config: DriverConfig, mut door: Option<Door>) {
        let may_restart = config.restart || !matches!(config.way, Way::Command(_));
        let label = &config.label;
        let mut pause = LINK_PAUSE.0;
        loop {
            let began = Instant::now();
            if door.is_none() {
                door = Door::open(&config).await.inspect_err(|problem| tracing::debug!("{label}: {problem}")).ok();
            }
            let link = match &door {
                Some(door) => {
                    door.link().await.inspect_err(|problem| tracing::warn!("cannot reach {label}: {problem}")).ok()
                }
                None => None,
            };
            if let Some(mut link) = link {
                let (lines, restart) = self.lock().drivers[driver].begin();
                self.step(Input::DriverStarted(driver));
                tracing::info!("{label} can be heard");
                let pause = pause_of(&config);
                let reason = self.talk(driver, &mut link, (lines, pause), may_restart.then_some(&*restart)).await;
                tracing::warn!(reason, "{label} has gone");
                self.lock().drivers[driver].telling = None;
                self.step(Input::DriverEnded(driver));
                link.close().await;
                if !may_restart {
                    tracing::error!("{label} is not started again: driver.restart is false");
                    return std::future::pending().await;
                }
            }
            if began.elapsed() >= LIVED {
                pause = LINK_PAUSE.0;
            }
            sleep(pause).await;
            pause = (2 * pause).min(LINK_PAUSE.1);
        }
    }

    /// Carries lines until the link ends; returns the reason. Lines are read no faster than they are handled.
    /// `restart` asks for the end of the link, if that may happen. The lines have this pause after them.
    async fn talk(
        &self,
        driver: usize,
        link: &mut Link,
        (mut lines, pause): (mpsc::Receiver<Vec<u8>>, Duration),
        restart: Option<&Notify>,
    ) -> &'static str {
        let (reader, writer) = (&mut link.reader, &mut link.writer);
        let read = async {
            let (mut buffer, mut cut) = (vec![0; CHUNK_BYTES], Lines::default());
            loop {
                match reader.read(&mut buffer).await {
                    Ok(0) => return "it has closed its output",
                    Ok(read) => {
                        for line in cut.push(&buffer[..read]) {
                            self.step(Input::Line(driver, line.as_deref()));
                        }
                    }
                    Err(_) => return "its output cannot be read",
                }
            }
        };
        let write = async {
            write_lines(writer, &mut lines, pause).await;
            std::future::pending().await
        };
        let restarted = async {
            match restart {
                Some(restart) => restart.notified().await,
                None => std::future::pending().await,
            }
            "it is silent or reads nothing"
        };
        tokio::select! {
            reason = read => reason,
            reason = write => reason,
            reason = restarted => reason,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::pin::pin;

    use super::*;
    use crate::Config;
    use crate::config::tests::EXAMPLE;

    fn pause(driver: &str) -> Duration {
        let text = EXAMPLE.replace("command = [\"python3\", \"driver.py\"]", driver);
        assert!(text.contains(driver));
        pause_of(&Config::from_toml_str(&text, Path::new("")).unwrap().drivers[0])
    }

    #[test]
    fn only_a_serial_device_that_regulates_by_itself_gets_its_lines_with_pauses() {
        assert_eq!(pause("serial = \"board\""), SERIAL_PAUSE);
        assert_eq!(pause("serial = \"board\"\nregulate = true"), Duration::ZERO);
        assert_eq!(pause("command = [\"driver\"]"), Duration::ZERO);
    }

    #[tokio::test]
    async fn regress_a_driver_that_reads_nothing_does_not_cost_the_next_link() {
        let config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        let mut link = DriverLink::new(&config.drivers[0]);
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        let (_lines, restart) = link.begin();
        let mut restarted = pin!(restart.notified());
        assert!(restarted.as_mut().poll(&mut context).is_pending());
        // The first line too many ends the wait, and the second one asks again.
        let line = ToDriver::Hello { version: 1, whiskers: vec![] };
        (0..TELLING_MAX + 2).for_each(|_| link.tell(&line, 0));
        restarted.await;
        let (_lines, restart) = link.begin();
        let mut restarted = pin!(restart.notified());
        assert!(restarted.as_mut().poll(&mut context).is_pending(), "nobody has asked for its end");
        link.restart.notify_one();
        restarted.await;
    }

    /// Writes so many lines; the time that it takes.
    async fn written(count: usize) -> Duration {
        let (sender, mut lines) = mpsc::channel(count);
        (0..count).for_each(|_| sender.try_send(b"{}\n".to_vec()).unwrap());
        drop(sender);
        let (mut bytes, began) = (Vec::new(), Instant::now());
        write_lines(&mut bytes, &mut lines, SERIAL_PAUSE).await;
        assert_eq!(bytes, b"{}\n".repeat(count));
        began.elapsed()
    }

    #[tokio::test]
    async fn lines_to_a_serial_device_come_apart_unless_too_many_wait() {
        assert!(written(10).await >= 10 * SERIAL_PAUSE);
        // With a pause after each it would take 100 s.
        assert!(written(5_000).await < Duration::from_secs(60));
    }
}
