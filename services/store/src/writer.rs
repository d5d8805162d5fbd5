//! A connection of its own for writing: what hangs or breaks is thrown away, and the next attempt begins anew.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, timeout_at};

use super::database::{Link, Options};
use super::{Batch, Lease, StoreError, commit, failed};

/// How long one attempt may take: a server that hangs is as good as none.
const PATIENCE: Duration = Duration::from_secs(10);

/// Writes, one thing after the other.
#[derive(Debug)]
pub struct Writer {
    options: Arc<Options>,
    link: Option<Link>,
}

impl Writer {
    pub(super) fn new(options: Arc<Options>) -> Self {
        Self { options, link: None }
    }

    /// Writes a batch in one transaction; after an error nothing of it is written that is not known as written
    /// when the same batch is tried again.
    ///
    /// # Errors
    /// The database cannot take it now, or the fleet is not ours any more.
    pub async fn commit(&mut self, lease: &Lease, batch: &Batch) -> Result<(), StoreError> {
        self.attempt("commit", PATIENCE, async |link| commit::write(link, lease, batch).await).await
    }

    /// Does something with the connection. It is kept for the next time only if all went well: a connection on
    /// which an answer is missing cannot be told from one that will never answer again.
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
