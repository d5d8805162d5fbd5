//! A fleet over real MQTT, driven by the wall clock.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rumqttc::Transport;
use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};
use url::Url;
use vibrissa_core::mechanics::ModelError;
use vibrissa_protocol::Name;

use crate::driver;
use crate::scenario::BadScenario;
use crate::state::{StateError, StateFile};
use crate::{Robot, RobotConfig, Scenario};

/// Time that robots have to stop cleanly.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Address of the broker, and the credentials to connect with.
#[derive(Clone, PartialEq, Eq)]
pub struct Broker {
    /// Host name or address; IPv6 without brackets.
    pub host: String,
    /// Port of the broker.
    pub port: u16,
    /// Host and port of further nodes of the same broker, which are tried in turn.
    pub others: Vec<(String, u16)>,
    /// User name and password, if the broker requires them. `{fleet}` and `{robot}` in the user name are replaced
    /// for each robot.
    pub credentials: Option<(String, String)>,
    /// Certificate authorities for TLS; `None` for a connection without TLS.
    pub tls: Option<Authorities>,
}

/// Source of the certificate authorities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Authorities {
    /// The system's certificate store.
    System,
    /// A file with certificates in PEM.
    File(PathBuf),
}

/// Why a fleet cannot start.
#[derive(Debug, thiserror::Error)]
pub enum CannotStart {
    /// The broker's URL is invalid. The error does not repeat it, because it may contain a password by mistake.
    #[error("invalid broker URL ({0}): expected mqtt://host[:1883], or mqtts://host[:8883] for TLS")]
    Address(String),
    /// The certificate authorities cannot be loaded.
    #[error("cannot use the certificate authorities from {0}: {1}")]
    Authorities(String, String),
    /// The scenario is invalid.
    #[error(transparent)]
    Scenario(#[from] BadScenario),
    /// The mechanics of a whisker are invalid.
    #[error(transparent)]
    Mechanics(#[from] ModelError),
    /// The state file cannot be used.
    #[error(transparent)]
    State(#[from] StateError),
}

impl std::fmt::Debug for Broker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Passwords stay out of logs.
        let scheme = if self.tls.is_some() { "mqtts" } else { "mqtt" };
        for (at, (host, port)) in self.nodes().iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            write!(f, "{comma}{scheme}://{}", address(host, *port))?;
        }
        Ok(())
    }
}

impl Broker {
    /// A broker without credentials and TLS.
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        Self { host: host.into(), port, others: Vec::new(), credentials: None, tls: None }
    }

    /// Parses `mqtt://host[:port]` or `mqtts://host[:port]`, or several of them separated by commas; the default port is
    /// 1883 or 8883.
    ///
    /// # Errors
    /// [`CannotStart::Address`] for anything else.
    pub fn from_url(text: &str) -> Result<Self, CannotStart> {
        let mut nodes = text.split(',').map(|text| Self::from_one_url(text.trim()));
        let mut broker = nodes.next().unwrap_or_else(|| Err(CannotStart::Address("no address".to_owned())))?;
        for node in nodes {
            let node = node?;
            if node.tls.is_some() != broker.tls.is_some() {
                return Err(CannotStart::Address("mqtt:// and mqtts:// are mixed".to_owned()));
            }
            broker.others.push((node.host, node.port));
        }
        Ok(broker)
    }

    fn from_one_url(text: &str) -> Result<Self, CannotStart> {
        let bad = |why: &str| CannotStart::Address(why.to_owned());
        let url = Url::parse(text).map_err(|problem| bad(&problem.to_string()))?;
        let (tls, usual_port) = match url.scheme() {
            "mqtt" => (None, 1883),
            "mqtts" => (Some(Authorities::System), 8883),
            _ => return Err(bad("neither mqtt:// nor mqtts://")),
        };
        if !url.username().is_empty() || url.password().is_some() {
            return Err(bad("give user and password as --mqtt-username and --mqtt-password-file"));
        }
        if !matches!(url.path(), "" | "/") {
            return Err(bad("unexpected text after the port"));
        }
        let host = url.host_str().unwrap_or_default().trim_matches(['[', ']']).to_owned();
        if host.is_empty() {
            return Err(bad("no host"));
        }
        Ok(Self { tls, ..Self::new(host, url.port().unwrap_or(usual_port)) })
    }

    /// Host and port of each node.
    pub(crate) fn nodes(&self) -> Vec<(String, u16)> {
        std::iter::once((self.host.clone(), self.port)).chain(self.others.iter().cloned()).collect()
    }

    /// User name and password of a robot.
    pub(crate) fn credentials_of(&self, fleet: &Name, robot: &Name) -> Option<(String, String)> {
        let (user, password) = self.credentials.as_ref()?;
        let user = user.replace("{fleet}", fleet.as_str()).replace("{robot}", robot.as_str());
        Some((user, password.clone()))
    }

    /// Transport to the broker, with or without TLS.
    fn transport(&self) -> Result<Transport, CannotStart> {
        let refused = |whose: String, why: String| CannotStart::Authorities(whose, why);
        match &self.tls {
            None => Ok(Transport::tcp()),
            Some(Authorities::System) => Transport::try_tls_with_default_config()
                .map_err(|why| refused("the system".to_owned(), why.to_string())),
            Some(Authorities::File(path)) => {
                let whose = || path.display().to_string();
                let certificates = std::fs::read(path).map_err(|why| refused(whose(), why.to_string()))?;
                if !String::from_utf8_lossy(&certificates).contains("-----BEGIN CERTIFICATE-----") {
                    return Err(refused(whose(), "the file contains no certificate in PEM".to_owned()));
                }
                Ok(Transport::tls(certificates, None, None))
            }
        }
    }
}

/// Host and port for the network library: `h:1883`, `[::1]:1883`.
pub(crate) fn address(host: &str, port: u16) -> String {
    if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") }
}

/// Robots that run until [`Fleet::stop`]; if dropped before, their connections break.
#[derive(Debug)]
pub struct Fleet {
    robots: Vec<RobotHandle>,
    stop: watch::Sender<bool>,
    tasks: Vec<JoinHandle<()>>,
    keeper: Option<(StateFile, JoinHandle<()>)>,
}

impl Fleet {
    /// Starts all robots of a scenario; each connects and reconnects on its own.
    ///
    /// Must be called within a tokio runtime.
    ///
    /// # Errors
    /// The scenario is invalid, or the file of certificate authorities cannot be read. An unreachable broker is no
    /// error: robots keep trying.
    pub fn start(scenario: &Scenario, broker: &Broker) -> Result<Self, CannotStart> {
        Self::start_from(scenario, broker, None)
    }

    /// Like [`Fleet::start`], with a file that stores the true state of the robots: changes of their whiskers, and
    /// the progress of the scenario. If the file exists, the robots continue from it, each in a new boot.
    ///
    /// Must be called within a tokio runtime.
    ///
    /// # Errors
    /// Those of [`Fleet::start`]; also, the file cannot be read or written, or belongs to another scenario or
    /// version.
    pub fn resume(scenario: &Scenario, broker: &Broker, state_file: &Path) -> Result<Self, CannotStart> {
        Self::start_from(scenario, broker, Some(state_file))
    }

    fn start_from(scenario: &Scenario, broker: &Broker, state_file: Option<&Path>) -> Result<Self, CannotStart> {
        scenario.check()?;
        let transport = broker.transport()?;
        let (stop, stopping) = watch::channel(false);
        let now_us = now_us();
        let file = state_file.map(|path| StateFile::new(path, scenario));
        let mut before = file.as_ref().map_or(Ok(None), StateFile::read)?.unwrap_or_default().into_iter();
        let changed = Arc::new(Notify::new());
        let mut robots = Vec::with_capacity(scenario.robots.len());
        for config in RobotConfig::all(scenario) {
            let robot = match (&file, before.next()) {
                (Some(file), Some(state)) => {
                    Robot::resume(config, scenario.seed, &state, now_us).map_err(|what| file.unfit(what))?
                }
                (_, _) => Robot::new(config, scenario.seed, now_us)?,
            };
            robots.push(RobotHandle::new(robot, changed.clone()));
        }
        let keeper = match file {
            None => None,
            Some(file) => {
                // Before a robot publishes anything, since its new boot must not occur again.
                file.write(&robots)?;
                let task = tokio::spawn(file.clone().keep(robots.clone(), changed));
                Some((file, task))
            }
        };
        let tasks = robots
            .iter()
            .map(|robot| tokio::spawn(driver::run(robot.clone(), broker.clone(), transport.clone(), stopping.clone())))
            .collect();
        Ok(Self { robots, stop, tasks, keeper })
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

    /// Number of contacts that all robots have made.
    #[must_use]
    pub fn contacts_made(&self) -> u64 {
        self.robots.iter().map(|robot| robot.with(|robot| robot.contacts_made())).sum()
    }

    /// Whether all contacts are receipted. Only meaningful for robots at rest.
    #[must_use]
    pub fn is_receipted(&self) -> bool {
        // For a robot at rest, contacts of an incomplete message are due immediately.
        let is_sent = |robot: &mut Robot| robot.messages_kept() == 0 && robot.next_deadline() > robot.start_us();
        self.robots.iter().all(|robot| robot.with(is_sent))
    }

    /// Stops making contacts; the existing ones are sent until they are receipted.
    pub fn rest(&self) {
        self.robots.iter().for_each(|robot| robot.with(Robot::rest));
    }

    /// Lets all robots publish a farewell and disconnect, for 5 seconds at most. Then writes the state file for the
    /// last time, if there is one.
    pub async fn stop(mut self) {
        // Without receivers, all robots have already ended.
        let _ = self.stop.send(true);
        let deadline = Instant::now() + STOP_TIMEOUT;
        for (task, robot) in self.tasks.iter_mut().zip(&self.robots) {
            match timeout_at(deadline, task).await {
                Ok(Ok(())) => {}
                Ok(Err(error)) => {
                    tracing::error!(robot = %robot.name(), %error, "robot task failed")
                }
                Err(_) => tracing::warn!(robot = %robot.name(), "robot did not stop in time"),
            }
        }
        if let Some((file, task)) = self.keeper.take() {
            task.abort();
            // A write may be in progress.
            let _ = task.await;
            if let Err(error) = file.write(&self.robots) {
                tracing::error!(%error, "cannot write the last changes to the state file");
            }
        }
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
        if let Some((_, task)) = &self.keeper {
            task.abort();
        }
    }
}

/// One robot of a running fleet, for access to its true state and for disturbances.
#[derive(Debug, Clone)]
pub struct RobotHandle {
    name: Name,
    robot: Arc<Mutex<Robot>>,
    pub(crate) cut: Arc<Notify>,
    /// Notified when something happens to any robot of the fleet.
    pub(crate) changed: Arc<Notify>,
}

impl RobotHandle {
    fn new(robot: Robot, changed: Arc<Notify>) -> Self {
        let (name, cut) = (robot.name().clone(), Arc::new(Notify::new()));
        Self { name, robot: Arc::new(Mutex::new(robot)), cut, changed }
    }

    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &Name {
        &self.name
    }

    /// Calls `look` with the robot, which is locked meanwhile: keep it short.
    pub fn with<R>(&self, look: impl FnOnce(&mut Robot) -> R) -> R {
        look(&mut self.lock())
    }

    /// Cuts the connection without a farewell; the robot reconnects after a moment.
    pub fn cut(&self) {
        self.cut.notify_one();
    }

    /// Even after a panic during an access, the robot's state is the best one available.
    fn lock(&self) -> MutexGuard<'_, Robot> {
        self.robot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Time of the wall clock, in microseconds since 1970 UTC.
#[must_use]
pub fn now_us() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_may_have_a_port() {
        assert_eq!(Broker::from_url("mqtt://broker").unwrap(), Broker::new("broker", 1883));
        assert_eq!(Broker::from_url("mqtt://127.0.0.1:1884/").unwrap(), Broker::new("127.0.0.1", 1884));
        let tls = Broker { tls: Some(Authorities::System), ..Broker::new("::1", 8883) };
        assert_eq!(Broker::from_url("mqtts://[::1]").unwrap(), tls);
        let two = Broker::from_url("mqtt://a, mqtt://[::1]:1884").unwrap();
        assert_eq!(two.nodes(), [("a".to_owned(), 1883), ("::1".to_owned(), 1884)]);
        assert_eq!(format!("{two:?}"), "mqtt://a:1883,mqtt://[::1]:1884");
        assert_eq!(format!("{tls:?}"), "mqtts://[::1]:8883");
        for bad in ["", "127.0.0.1", "http://h", "mqtt://", "mqtt://h:x", "mqtt://u@h", "mqtt://u:p@h", "mqtt://h/t"] {
            assert!(Broker::from_url(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn each_robot_has_a_user_of_its_own_and_no_password_is_shown() {
        let credentials = Some(("{fleet}/{robot}".to_owned(), "hunter2".to_owned()));
        let broker = Broker { credentials, ..Broker::new("h", 1) };
        let name = |text| Name::new(text).unwrap();
        let of = broker.credentials_of(&name("lab"), &name("crawler-1"));
        assert_eq!(of, Some(("lab/crawler-1".to_owned(), "hunter2".to_owned())));
        assert_eq!(format!("{broker:?}"), "mqtt://h:1");
        assert!(!format!("{:?}", Broker::from_url("mqtt://u:hunter2@h")).contains("hunter2"));
    }
}
