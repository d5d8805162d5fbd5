//! Waits, up to a time limit, for a condition.

use std::time::{Duration, Instant};

/// Time limit of all waits in tests.
pub const PATIENCE: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_millis(20);

/// Calls `look` until it returns a value, and returns that value.
///
/// # Panics
/// `look` returns no value within [`PATIENCE`]; the message contains `what`.
pub async fn until<T>(what: &str, look: impl AsyncFnMut() -> Option<T>) -> T {
    until_within(PATIENCE, what, look).await
}

/// As [`until`], with another time limit.
///
/// # Panics
/// `look` returns no value within `patience`; the message contains `what`.
pub async fn until_within<T>(patience: Duration, what: &str, look: impl AsyncFnMut() -> Option<T>) -> T {
    found_within(patience, look).await.unwrap_or_else(|| panic!("timed out waiting for: {what}"))
}

/// Calls `look` until it returns a value; `None` after the time limit.
pub async fn found_within<T>(patience: Duration, mut look: impl AsyncFnMut() -> Option<T>) -> Option<T> {
    let deadline = Instant::now() + patience;
    loop {
        if let Some(found) = look().await {
            return Some(found);
        }
        if Instant::now() > deadline {
            return None;
        }
        tokio::time::sleep(PAUSE).await;
    }
}

/// Waits until `holds` returns true.
///
/// # Panics
/// As [`until`].
pub async fn until_true(what: &str, mut holds: impl AsyncFnMut() -> bool) {
    until(what, async || holds().await.then_some(())).await;
}

/// Result of a future that must end.
///
/// # Panics
/// It has not ended after [`PATIENCE`]; the message contains `what`.
pub async fn ended<T>(what: &str, future: impl Future<Output = T>) -> T {
    tokio::time::timeout(PATIENCE, future).await.unwrap_or_else(|_| panic!("it has not ended: {what}"))
}
