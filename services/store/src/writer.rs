//! A separate connection for writing. After any error it is closed, and the next attempt opens a new one.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, timeout_at};

use super::database::{Link, Options};
use super::{Batch, Lease, StoreError, commit, failed};

/// Time limit for one attempt: a server that hangs counts as unreachable.
const PATIENCE: Duration = Duration::from_secs(10);

/// Writes over its own connection, one operation after the other.
#[derive(Debug)]
pub struct Writer {
    options: Arc<Options>,
    link: Option<Link>,
}

impl Writer {
    pub(super) fn new(options: Arc<Options>) -> Self {
        Self { options, link: None }
    }

    /// Writes a batch in one transaction. Idempotent: retrying the same batch after an error never writes it twice.
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost.
    pub async fn commit(&mut self, lease: &Lease, batch: &Batch) -> Result<(), StoreError> {
        self.attempt("commit", PATIENCE, async |link| commit::write(link, lease, batch).await).await
    }

    /// Runs an operation on the connection within a time limit. The connection is used again only after a success: if
    /// an answer is missing, it may never answer again.
    pub(super) async fn attempt<T>(
        &mut self,
        what: &'static str,
        patience: Duration,
        work: impl AsyncFnOnce(&mut Link) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let deadline = Instant::now() + patience;
        let attempt = async {
            let mut link = match self.link.take() {
                Some(link) => link,
                None => self.options.connect().await.map_err(failed(what))?,
            };
            let done = work(&mut link).await?;
            Ok((link, done))
        };
        let (link, done) =
            timeout_at(deadline, attempt).await.unwrap_or(Err(StoreError::NoAnswer { what, patience }))?;
        self.link = Some(link);
        Ok(done)
    }
}
