//! Sources of a fleet's allow list: a file, and a list that people have set.

use std::sync::Arc;

use tokio::sync::watch;
use tracing::{info, warn};
use vibrissa_protocol::Name;

use super::allow_list::AllowList;
use super::commit::committer::Committer;
use super::worker::workers::Workers;
use crate::robots_file::RobotsFile;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::allowed::{AllowedReading, names_of};

/// Sources of a fleet's allow list.
#[derive(Debug)]
pub(crate) struct AllowListSources {
    fleet: Name,
    file: Option<watch::Receiver<Arc<RobotsFile>>>,
    /// Version of the list that people have set; 0 before the first.
    version: i64,
    list: AllowList,
    /// The list that people have set may have changed.
    may_be_outdated: bool,
    /// The lists have changed, so that refused robots may be allowed now.
    has_changed: bool,
}

impl AllowListSources {
    /// A list that people have `set`, and a file that may change later.
    pub(crate) fn new(
        fleet: Name,
        set: Option<&AllowedReading>,
        file: Option<watch::Receiver<Arc<RobotsFile>>>,
        workers: &mut Workers,
    ) -> Self {
        let (version, list) = (0, AllowList::default());
        let mut sources = Self { fleet, file, version, list, may_be_outdated: false, has_changed: false };
        if let Some(set) = set {
            sources.set(set, workers);
        }
        sources.read_file(workers);
        sources
    }

    /// Whether the lists have changed since the last call.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    /// Reads the file again if it has changed.
    pub(crate) fn read_changed_file(&mut self, workers: &mut Workers) {
        if self.file.as_ref().is_some_and(|file| file.has_changed().unwrap_or_default()) {
            self.read_file(workers);
            self.has_changed = true;
        }
    }

    fn read_file(&mut self, workers: &mut Workers) {
        let Some(file) = &mut self.file else { return };
        self.list.set_file(file.borrow_and_update().of_fleet(&self.fleet));
        self.apply(workers);
    }

    /// Applies a list that people have set.
    fn set(&mut self, reading: &AllowedReading, workers: &mut Workers) {
        self.version = reading.version;
        self.list.set_listed(reading.robots.as_deref().map(|names| names_of(names).collect()));
        self.apply(workers);
    }

    fn apply(&self, workers: &mut Workers) {
        let [in_file, set] = self.list.counts();
        info!(fleet = %self.fleet, ?in_file, ?set, "allow list loaded");
        workers.set_allow_list(&self.list);
    }

    /// Reads the list that people have set if it has changed, and writes the refused robots. If the database is
    /// unreachable, this does not wait.
    pub(crate) async fn refresh(&mut self, committer: &mut Committer, workers: &mut Workers) {
        if self.read(committer, workers).await {
            self.write_refused_robots(committer, workers).await;
        }
    }

    /// Reads the list that people have set if it may have changed. Returns false if the database cannot be read now.
    pub(crate) async fn read(&mut self, committer: &mut Committer, workers: &mut Workers) -> bool {
        if !self.may_be_outdated {
            return true;
        }
        let (writer, lease) = committer.database();
        match writer.allowed_robots(lease, self.version).await {
            Ok(None) => {}
            Ok(Some(reading)) => {
                self.set(&reading, workers);
                self.has_changed = true;
            }
            Err(problem) => {
                committer.failed(&problem, "cannot read the allow list");
                return false;
            }
        }
        self.may_be_outdated = false;
        true
    }

    /// Makes the next refresh read the list: it may have changed.
    pub(crate) fn expect_change(&mut self) {
        self.may_be_outdated = true;
    }

    async fn write_refused_robots(&self, committer: &mut Committer, workers: &mut Workers) {
        let Some(rows) = workers.refused_robots() else { return };
        let (writer, lease) = committer.database();
        match writer.write_turned_away(lease, &rows).await {
            Ok(()) => workers.refused_robots_written(),
            Err(problem) => {
                warn!(%problem, fleet = %self.fleet, at = wall_clock().0, "cannot write the refused robots")
            }
        }
    }
}
