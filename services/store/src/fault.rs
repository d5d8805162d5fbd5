//! Faults that tests inject, to verify that they would detect them. They exist only with the feature `test-faults`,
//! which releases do not enable.

/// A fault that can be injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Receipts are sent before the messages that they confirm are committed.
    ReceiptBeforeCommit,
    /// The position in the log is committed before the effects of its records.
    OffsetBeforeState,
    /// Transactions do not check the lease (no fencing).
    NoFence,
    /// The process ends at once, as if killed, when a file of the archive is uploaded and its position is not advanced.
    DeathAfterUpload,
    /// The archive's horizon is the present, although earlier contacts may not be committed yet.
    EarlyHorizon,
}

/// Whether the environment variable `VIBRISSA_TEST_FAULT` requests this fault.
#[cfg(feature = "test-faults")]
#[must_use]
pub fn is(fault: Fault) -> bool {
    static ASKED_FOR: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
    let word = match fault {
        Fault::ReceiptBeforeCommit => "receipt_before_commit",
        Fault::OffsetBeforeState => "offset_before_state",
        Fault::NoFence => "no_fence",
        Fault::DeathAfterUpload => "death_after_upload",
        Fault::EarlyHorizon => "early_horizon",
    };
    ASKED_FOR.get_or_init(|| std::env::var("VIBRISSA_TEST_FAULT").ok()).as_deref() == Some(word)
}

/// Always false without the feature `test-faults`.
#[cfg(not(feature = "test-faults"))]
#[must_use]
pub const fn is(_: Fault) -> bool {
    false
}
