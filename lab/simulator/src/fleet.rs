//! A fleet over real MQTT.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};
use vibrissa_core::mechanics::ModelError;
use vibrissa_host::task;
use vibrissa_protocol::Name;
use vibrissa_robot::mqtt;
pub use vibrissa_robot::mqtt::{Authorities, BadBroker, Broker, password_in};

use crate::clock::now_us;
use crate::robot_handle::RobotHandle;
use crate::scenario::BadScenario;
use crate::state::{StateError, StateFile};
use crate::{Robot, RobotConfig, Scenario};

/// Time that robots have to stop cleanly.
const STOP_TIMEOUT: Duration = Duration::from_secs(5);

/// Why a fleet cannot start.
#[derive(Debug, thiserror::Error)]
pub enum CannotStart {
    /// The broker's URL is invalid, or the certificate authorities cannot be loaded.
    #[error(transparent)]
    Broker(#[from] BadBroker),
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
                let task = task::spawn(file.clone().keep(robots.clone(), changed));
                Some((file, task))
            }
        };
        let tasks = robots
            .iter()
            .map(|robot| {
                let signals = robot.signals.clone();
                task::spawn(mqtt::run(robot.clone(), broker.clone(), transport.clone(), signals, stopping.clone()))
            })
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
