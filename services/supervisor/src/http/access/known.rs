//! The hashes of all valid credentials in the database. A wrong token or cookie is refused by them, so that a flood of
//! wrong ones reads the database ten times per second at most, and keeps no right one out.
//!
//! A hash that is not known may be new: then the hashes are read again, for all requests that wait for them.

use std::collections::HashSet;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use tokio::sync::Mutex;
use tokio::time::{Instant, sleep_until};

use crate::http::problem::Problem;
use vibrissa_store::StoreError;

/// Hash of a token's secret, or of a session's identifier.
pub(super) type Hash = [u8; 32];

/// Shortest interval from one read of the hashes to the next.
const READ_EVERY: Duration = Duration::from_millis(100);
/// Largest number of hashes. With more in the database each credential is looked up there.
pub(super) const HASHES_MAX: u32 = 100_000;

/// The known hashes. Clones share them.
#[derive(Debug, Clone, Default)]
pub(super) struct Known(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    hashes: RwLock<HashSet<Hash>>,
    last: Mutex<Option<Read>>,
}

/// A read of the hashes.
#[derive(Debug)]
struct Read {
    begun: Instant,
    /// What came of it; `None` while it goes on, or if the request that began it has ended.
    result: Option<Result<(), Problem>>,
}

impl Known {
    /// Whether a credential with this hash is in the database; `read` gives all hashes there.
    ///
    /// # Errors
    /// The database cannot be read.
    pub(super) async fn holds<W>(&self, hash: &Hash, read: impl FnOnce() -> W) -> Result<bool, Problem>
    where
        W: Future<Output = Result<Vec<Hash>, StoreError>>,
    {
        if self.contains(hash) {
            return Ok(true);
        }
        let arrived = Instant::now();
        let mut last = self.0.last.lock().await;
        if let Some(last) = &*last {
            match &last.result {
                Some(result) if last.begun >= arrived => return result.clone().map(|()| self.contains(hash)),
                _ => sleep_until(last.begun + READ_EVERY).await,
            }
        }
        // Before the read: this future may be dropped in the middle of it.
        let read_now = last.insert(Read { begun: Instant::now(), result: None });
        let result = read().await.map(|hashes| {
            *self.0.hashes.write().unwrap_or_else(PoisonError::into_inner) = hashes.into_iter().collect();
        });
        let result = result.map_err(Problem::from);
        read_now.result = Some(result.clone());
        result.map(|()| self.contains(hash))
    }

    /// Whether the hash is known without a read.
    pub(super) fn contains(&self, hash: &Hash) -> bool {
        let hashes = self.0.hashes.read().unwrap_or_else(PoisonError::into_inner);
        hashes.len() >= HASHES_MAX as usize || hashes.contains(hash)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    fn hash(number: u32) -> Hash {
        let mut hash = [0; 32];
        hash[..4].copy_from_slice(&number.to_be_bytes());
        hash
    }

    async fn not_read() -> Result<Vec<Hash>, StoreError> {
        panic!("it is known")
    }

    #[tokio::test]
    async fn regress_a_flood_of_wrong_credentials_reads_the_database_seldom() {
        let (known, reads) = (Known::default(), Arc::new(AtomicU32::new(0)));
        let read = |reads: &Arc<AtomicU32>| {
            let reads = reads.clone();
            async move || {
                reads.fetch_add(1, Ordering::SeqCst);
                Ok(vec![hash(7)])
            }
        };
        let begun = Instant::now();
        assert!(known.holds(&hash(7), read(&reads)).await.unwrap());
        let flood: Vec<_> = (100..5100)
            .map(|number| {
                let (known, read) = (known.clone(), read(&reads));
                vibrissa_host::task::spawn(async move { known.holds(&hash(number), read).await })
            })
            .collect();
        for wrong in flood {
            assert!(!wrong.await.unwrap().unwrap());
        }
        let most = begun.elapsed().as_millis() / READ_EVERY.as_millis() + 1;
        assert!(u128::from(reads.load(Ordering::SeqCst)) <= most, "{reads:?} reads, at most {most}");
        // A right one does not wait for a read.
        assert!(known.holds(&hash(7), not_read).await.unwrap());
    }

    #[tokio::test]
    async fn a_credential_that_was_made_after_a_read_is_found_by_the_next() {
        let known = Known::default();
        assert!(!known.holds(&hash(1), async || Ok(Vec::new())).await.unwrap());
        assert!(known.holds(&hash(1), async || Ok(vec![hash(1)])).await.unwrap());
        assert!(known.holds(&hash(1), not_read).await.unwrap());
    }

    #[tokio::test]
    async fn attack_requests_that_end_early_do_not_read_more_often() {
        let (known, reads) = (Known::default(), AtomicU32::new(0));
        let begun = Instant::now();
        for number in 0..50 {
            let read = async || {
                reads.fetch_add(1, Ordering::SeqCst);
                std::future::pending().await
            };
            let hash = hash(number);
            let _ = tokio::time::timeout(Duration::from_millis(10), known.holds(&hash, read)).await;
        }
        let most = begun.elapsed().as_millis() / READ_EVERY.as_millis() + 1;
        assert!(u128::from(reads.load(Ordering::SeqCst)) <= most, "{reads:?} reads, at most {most}");
    }
}
