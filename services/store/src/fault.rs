//! Faults that tests plant, to see that their harness finds them. They exist only with the feature `test-faults`,
//! which no release has.

/// What can be made wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Receipts are sent before what they cover is committed.
    ReceiptBeforeCommit,
    /// The database does not ask whose the fleet is.
    NoFence,
}

/// Whether `VIBRISSA_TEST_FAULT` asks for this fault.
#[cfg(feature = "test-faults")]
#[must_use]
pub fn is(fault: Fault) -> bool {
    static ASKED_FOR: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
    let word = match fault {
        Fault::ReceiptBeforeCommit => "receipt_before_commit",
        Fault::NoFence => "no_fence",
    };
    ASKED_FOR.get_or_init(|| std::env::var("VIBRISSA_TEST_FAULT").ok()).as_deref() == Some(word)
}

/// Never.
#[cfg(not(feature = "test-faults"))]
#[must_use]
pub const fn is(_: Fault) -> bool {
    false
}
