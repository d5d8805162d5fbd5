//! Watches whether the database waits for a standby at each commit. Otherwise a failover loses acknowledged commits.

use tokio::sync::watch;
use tokio::time::{Duration, timeout};
use tracing::{info, warn};
use vibrissa_store::{Replication, Store, StoreError};

use crate::metrics::Metrics;

/// Polling interval of the database's server.
const EVERY: Duration = Duration::from_secs(5);
/// Time limit of a poll: the server may be frozen or cut off.
const PATIENCE: Duration = Duration::from_secs(5);

/// Looks at the replication until the service stops. Returns at once if the database has a single server.
pub(crate) async fn watch(store: Store, metrics: Metrics, mut stop: watch::Receiver<bool>) {
    let mut known = None;
    loop {
        match timeout(PATIENCE, store.replication()).await {
            Ok(Ok(None)) => return,
            Ok(found) => note(found, &mut known, &metrics),
            // Ownership reports that the database does not answer.
            Err(_) => {}
        }
        if timeout(EVERY, stop.wait_for(|&stop| stop)).await.is_ok() {
            return;
        }
    }
}

/// Notes a result. Only changes are logged.
fn note(found: Result<Option<Replication>, StoreError>, known: &mut Option<bool>, metrics: &Metrics) {
    let Ok(Some(replication)) = found else { return };
    let is_synchronous = replication.is_synchronous();
    metrics.database_asynchronous.set((!is_synchronous).into());
    if known.replace(is_synchronous) == Some(is_synchronous) {
        return;
    }
    let Replication { synchronous_standby_names: names, standbys } = replication;
    if is_synchronous {
        info!(names, standbys, "each commit waits for a standby of the database");
    } else {
        warn!(
            standbys,
            "commits wait for no standby of the database, so a failover may lose acknowledged ones: set Patroni's \
             synchronous_mode, or synchronous_standby_names"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn replication(names: &str) -> Result<Option<Replication>, StoreError> {
        Ok(Some(Replication { synchronous_standby_names: names.to_owned(), standbys: 1 }))
    }

    #[test]
    fn the_metric_follows_the_standbys_that_commits_wait_for() {
        let (metrics, mut known) = (Metrics::new(false).unwrap(), None);
        for (names, expected) in [("", 1), ("\"two\"", 0), (" ", 1), ("ANY 1 (*)", 0)] {
            note(replication(names), &mut known, &metrics);
            assert_eq!((metrics.database_asynchronous.get(), known), (expected, Some(expected == 0)), "{names}");
        }
        note(Err(StoreError::NoAnswer { what: "look", patience: EVERY }), &mut known, &metrics);
        assert_eq!((metrics.database_asynchronous.get(), known), (0, Some(true)), "an error changes nothing");
    }
}
