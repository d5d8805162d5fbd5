//! Stands in for the module `archive` in a build without the feature `archive`: no archive can be configured.

use vibrissa_store::{Lease, Store};

use crate::archive_options::ArchiveOptions;
use crate::metrics::FleetMetrics;

/// The archive, which does not exist.
#[derive(Debug, Clone)]
pub(crate) enum Archive {}

impl Archive {
    /// Opens nothing.
    ///
    /// # Errors
    /// Always, because the feature `archive` is not built in.
    pub(crate) fn open(_: &ArchiveOptions) -> anyhow::Result<Self> {
        anyhow::bail!(
            "this program was built without the archive: build it with --features archive, or leave archive.url out"
        )
    }

    pub(crate) async fn run(self, _: Lease, _: Store, _: FleetMetrics) {
        match self {}
    }
}
