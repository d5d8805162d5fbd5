//! Simulated robots, with a record of the contacts that they made and the setpoints that they applied.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use vibrissa_simulator::{Broker, Fleet, JournalEntry, RobotHandle, Scenario};

use super::ledger::Ledger;
use super::obedience::Obedience;

/// Interval at which the robots' journals are read.
const JOURNALS: Duration = Duration::from_millis(500);

/// The running robots and a record of their actions.
pub struct Robots {
    fleets: Vec<Fleet>,
    truth: Arc<Mutex<Truth>>,
}

/// Contacts made and setpoints applied by the robots.
#[derive(Debug, Default)]
pub struct Truth {
    /// Contacts that were made.
    pub ledger: Ledger,
    /// Setpoints that arrived and were applied.
    pub obedience: Obedience,
}

impl Truth {
    fn read(&mut self, robot: &RobotHandle) {
        let name = robot.name().as_str();
        for entry in robot.with(vibrissa_simulator::Robot::take_journal) {
            match entry {
                JournalEntry::Felt(message) => self.ledger.felt(name, &message),
                JournalEntry::Heard(setpoint) => self.obedience.heard(name, &setpoint),
                JournalEntry::Applied(setpoint) => self.obedience.applied(name, &setpoint),
            }
        }
    }
}

impl Robots {
    /// Starts the robots of each scenario at its broker.
    ///
    /// # Errors
    /// The scenarios cannot be simulated.
    pub fn start(scenarios: &[Scenario], brokers: &[Broker]) -> anyhow::Result<Self> {
        let mut fleets = Vec::new();
        for (scenario, broker) in scenarios.iter().zip(brokers) {
            fleets.push(Fleet::start(scenario, broker)?);
        }
        let truth = Arc::new(Mutex::new(Truth::default()));
        let robots: Vec<RobotHandle> = fleets.iter().flat_map(|fleet| fleet.robots().to_vec()).collect();
        let weak = Arc::downgrade(&truth);
        tokio::spawn(async move {
            while let Some(truth) = weak.upgrade() {
                for robot in &robots {
                    truth.lock().unwrap_or_else(PoisonError::into_inner).read(robot);
                }
                drop(truth);
                tokio::time::sleep(JOURNALS).await;
            }
        });
        Ok(Self { fleets, truth })
    }

    fn all(&self) -> impl Iterator<Item = &RobotHandle> {
        self.fleets.iter().flat_map(Fleet::robots)
    }

    /// Stops all contacts.
    pub fn rest(&self) {
        self.fleets.iter().for_each(Fleet::rest);
    }

    /// Number of messages without a receipt, including messages that are not yet full.
    #[must_use]
    pub fn undelivered(&self) -> u64 {
        let of = |robot: &mut vibrissa_simulator::Robot| {
            // A message that is not yet full is due at once when a robot rests.
            let waiting = robot.next_deadline() <= robot.start_us();
            robot.messages_kept() as u64 + u64::from(waiting)
        };
        self.all().map(|robot| robot.with(of)).sum()
    }

    /// Number of messages that each robot has made.
    #[must_use]
    pub fn marks(&self) -> Vec<u64> {
        self.all().map(|robot| robot.with(|robot| robot.messages_made())).collect()
    }

    /// Number of robots with a receipt for a message made after these [`Self::marks`].
    #[must_use]
    pub fn receipted_beyond(&self, marks: &[u64]) -> usize {
        let newest = self.all().map(|robot| robot.with(|robot| robot.newest_receipted()));
        newest.zip(marks).filter(|(newest, mark)| newest.is_some_and(|newest| newest >= **mark)).count()
    }

    /// Number of contacts made so far.
    #[must_use]
    pub fn made(&self) -> u64 {
        self.all().map(|robot| robot.with(|robot| robot.contacts_made())).sum()
    }

    /// Number of messages that robots dropped because they kept too many.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.all().map(|robot| robot.with(|robot| robot.messages_dropped())).sum()
    }

    /// Stops the robots and returns the record of their actions.
    pub async fn stop(self) -> Truth {
        let robots: Vec<RobotHandle> = self.all().cloned().collect();
        for fleet in self.fleets {
            fleet.stop().await;
        }
        let mut truth = std::mem::take(&mut *self.truth.lock().unwrap_or_else(PoisonError::into_inner));
        robots.iter().for_each(|robot| truth.read(robot));
        truth
    }
}
