//! A fleet over real MQTT, by the wall clock.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};
use vibrissa_core::mechanics::ModelError;
use vibrissa_protocol::Name;

use crate::driver;
use crate::scenario::BadScenario;
use crate::{Robot, RobotConfig, Scenario};

/// How long robots have to end in good order.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Where the broker is, and as whom to connect.
#[derive(Clone, PartialEq, Eq)]
pub struct Broker {
    /// Its host name or address.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// User name and password, if it asks for them.
    pub credentials: Option<(String, String)>,
}

/// Why a fleet cannot start.
#[derive(Debug, thiserror::Error)]
pub enum CannotStart {
    /// The broker's address cannot be read.
    #[error("{0:?} is no broker's address: expected mqtt://host, mqtt://host:port or mqtt://user:password@host:port")]
    Address(String),
    /// The scenario cannot be simulated.
    #[error(transparent)]
    Scenario(#[from] BadScenario),
    /// A whisker cannot be simulated.
    #[error(transparent)]
    Mechanics(#[from] ModelError),
}

impl std::fmt::Debug for Broker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Passwords stay out of logs.
        write!(f, "mqtt://{}:{}", self.host, self.port)
    }
}

impl Broker {
    /// A broker that asks for no credentials.
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        Self { host: host.into(), port, credentials: None }
    }

    /// Reads `mqtt://[user:password@]host[:port]`; the port is 1883 unless given.
    ///
    /// # Errors
    /// [`CannotStart::Address`] for anything else.
    pub fn from_url(url: &str) -> Result<Self, CannotStart> {
        let read = || {
            let rest = url.strip_prefix("mqtt://")?;
            let rest = rest.strip_suffix('/').unwrap_or(rest);
            let (credentials, address) = match rest.rsplit_once('@') {
                Some((credentials, address)) => (Some(credentials.split_once(':')?), address),
                None => (None, rest),
            };
            let (host, port) = match address.rsplit_once(':') {
                Some((host, port)) => (host, port.parse().ok()?),
                None => (address, 1883),
            };
            let credentials = credentials.map(|(user, password)| (user.to_owned(), password.to_owned()));
            (!host.is_empty()).then(|| Self { host: host.to_owned(), port, credentials })
        };
        read().ok_or_else(|| CannotStart::Address(url.to_owned()))
    }
}

/// Robots that run until [`Fleet::stop`]; dropped without it, their connections break.
#[derive(Debug)]
pub struct Fleet {
    robots: Vec<RobotHandle>,
    stop: watch::Sender<bool>,
    tasks: Vec<JoinHandle<()>>,
}

impl Fleet {
    /// Starts every robot of a scenario; they connect, and connect again, by themselves.
    ///
    /// Must be called within a tokio runtime.
    ///
    /// # Errors
    /// The scenario cannot be simulated. A broker that is not there is no error: robots keep trying.
    pub fn start(scenario: &Scenario, broker: &Broker) -> Result<Self, CannotStart> {
        scenario.check()?;
        let (stop, stopping) = watch::channel(false);
        let start_us = now_us();
        let mut robots = Vec::with_capacity(scenario.robots.len());
        for config in RobotConfig::all(scenario) {
            robots.push(RobotHandle::new(Robot::new(config, scenario.seed, start_us)?));
        }
        let tasks = robots
            .iter()
            .map(|robot| tokio::spawn(driver::run(robot.clone(), broker.clone(), stopping.clone())))
            .collect();
        Ok(Self { robots, stop, tasks })
    }

    /// The robots, in the order of the scenario.
    #[must_use]
    pub fn robots(&self) -> &[RobotHandle] {
        &self.robots
    }

    /// A robot by its name.
    #[must_use]
    pub fn robot(&self, name: &Name) -> Option<&RobotHandle> {
        self.robots.iter().find(|robot| robot.name() == name)
    }

    /// No robot makes contacts any more; what was made is sent until it is receipted.
    pub fn rest(&self) {
        self.robots.iter().for_each(|robot| robot.with(Robot::rest));
    }

    /// Every robot says farewell and disconnects; waits for them, 5 seconds at most.
    pub async fn stop(mut self) {
        // Without receivers every robot has ended already.
        let _ = self.stop.send(true);
        let deadline = Instant::now() + STOP_TIMEOUT;
        for (task, robot) in self.tasks.iter_mut().zip(&self.robots) {
            match timeout_at(deadline, task).await {
                Ok(Ok(())) => {}
                Ok(Err(error)) => {
                    tracing::error!(robot = %robot.name(), %error, "a robot ended abnormally")
                }
                Err(_) => tracing::warn!(robot = %robot.name(), "a robot did not end in time"),
            }
        }
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

/// One robot of a running fleet: to look at its truth, and to disturb it.
#[derive(Debug, Clone)]
pub struct RobotHandle {
    name: Name,
    robot: Arc<Mutex<Robot>>,
    pub(crate) cut: Arc<Notify>,
}

impl RobotHandle {
    fn new(robot: Robot) -> Self {
        Self { name: robot.name().clone(), robot: Arc::new(Mutex::new(robot)), cut: Arc::new(Notify::new()) }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &Name {
        &self.name
    }

    /// Looks at the robot, which stands still meanwhile: be brief.
    pub fn with<R>(&self, look: impl FnOnce(&mut Robot) -> R) -> R {
        look(&mut self.lock())
    }

    /// Cuts its connection without a farewell; it connects again after a moment.
    pub fn cut(&self) {
        self.cut.notify_one();
    }

    /// A robot that panicked while it was looked at is still the best that is known of it.
    fn lock(&self) -> MutexGuard<'_, Robot> {
        self.robot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The wall clock, in microseconds since 1970 UTC.
#[must_use]
pub fn now_us() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_may_have_a_port_and_credentials() {
        assert_eq!(Broker::from_url("mqtt://broker").unwrap(), Broker::new("broker", 1883));
        assert_eq!(Broker::from_url("mqtt://127.0.0.1:1884/").unwrap(), Broker::new("127.0.0.1", 1884));
        let with = Broker::from_url("mqtt://u:p:x@h:1").unwrap();
        assert_eq!(with.credentials, Some(("u".to_owned(), "p:x".to_owned())));
        assert_eq!(format!("{with:?}"), "mqtt://h:1", "no password in logs");
        for bad in ["", "127.0.0.1", "http://h", "mqtt://", "mqtt://h:x", "mqtt://u@h"] {
            assert!(Broker::from_url(bad).is_err(), "{bad}");
        }
    }
}
