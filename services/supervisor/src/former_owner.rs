//! A fleet of which the database knows nothing, although the broker retains the state of an owner: the database may have
//! been lost, emptied or exchanged. The fleet is supervised only if somebody says that the installation is new.

use std::sync::OnceLock;
use std::time::Duration;

use tracing::error;

use crate::metrics::Metrics;
use crate::mqtt::{BrokerLink, Connection, retained_epoch};
use crate::readiness::Readiness;
use vibrissa_store::{Store, StoreError};

/// Pause between two looks at the broker and the database.
const LOOK_PAUSE: Duration = Duration::from_secs(5);

/// Looks for former owners of a fleet.
#[derive(Debug)]
pub(crate) struct FormerOwners<'a> {
    pub(crate) store: &'a Store,
    pub(crate) metrics: &'a Metrics,
    pub(crate) readiness: &'a Readiness,
    /// Part of the fleet's supervision that is not ready meanwhile.
    pub(crate) part: &'static str,
    pub(crate) connection: Connection,
    /// Gets the state of the link if the broker does not answer.
    pub(crate) heard: &'a OnceLock<BrokerLink>,
}

impl FormerOwners<'_> {
    /// Waits while the broker retains an owner of the fleet whom the database does not know.
    pub(crate) async fn await_known(&self) {
        let fleet = &self.connection.fleet;
        let message = |problem| self.readiness.set_of(fleet, self.part, Some(problem));
        let mut is_logged = false;
        loop {
            match self.unknown_epoch().await {
                Ok(None) => return,
                Ok(Some(epoch)) => {
                    let problem = describe(epoch);
                    if !std::mem::replace(&mut is_logged, true) {
                        error!(%fleet, "{problem}");
                    }
                    message(problem);
                }
                Err(problem) => {
                    self.metrics.database_failed();
                    message(problem.message());
                }
            }
            tokio::time::sleep(LOOK_PAUSE).await;
        }
    }

    /// Epoch of a former owner whom the database does not know, if there is one. A database with robots of the fleet is not
    /// asked further: it may be an old back-up, but it is not an empty one.
    async fn unknown_epoch(&self) -> Result<Option<u64>, StoreError> {
        let (connection, fleet) = (&self.connection, &self.connection.fleet);
        if self.store.has_robots(fleet).await? {
            return Ok(None);
        }
        let metrics = self.metrics.of_fleet(fleet);
        let unreached = || {
            let link = self.heard.get_or_init(|| connection.link.clone());
            self.readiness.listens(fleet, link.clone(), metrics.promises.clone());
        };
        let Some(epoch) = retained_epoch(connection, &metrics, unreached).await else { return Ok(None) };
        Ok((!self.store.has_epoch_until(fleet, epoch).await?).then_some(epoch))
    }
}

fn describe(epoch: u64) -> String {
    format!(
        "the MQTT broker retains the state of an owner with epoch {epoch}, but the database has no such owner and no \
         robots: it is another database, or its data is lost. Nothing of this fleet is supervised. Correct database.url, or \
         restore the back-up; if the installation is new, set database.installation = \"new\""
    )
}
