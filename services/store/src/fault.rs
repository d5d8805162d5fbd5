//! Faults that tests inject, to verify that they would detect them. They exist only with the feature `test-faults`,
//! which releases do not enable.

#[cfg(feature = "test-faults")]
use std::cell::Cell;

/// A fault that can be injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Receipts are sent before the messages that they confirm are committed.
    ReceiptBeforeCommit,
    /// The position in the log is committed before the effects of its records.
    OffsetBeforeState,
    /// Transactions do not check the lease (no fencing).
    NoFence,
    /// Rows are committed before the lease is checked. Only in a model.
    RowsBeforeFence,
    /// An event counts as delivered to a webhook before its request is sent.
    DeliveredBeforeRequest,
    /// Supervisors deliver to a webhook that another one holds. Only in a model.
    NoHold,
    /// The next epoch is the highest one of the database plus 1, whatever this process knows.
    EpochReuse,
    /// Setpoints expire by the clock of the supervisor's host, not by the robot's.
    ExpiryByHostClock,
    /// States that a newer program has written look like those of the present one. Only in a model.
    NewerStateRead,
    /// Silence while the supervisor stood still counts as the robots'.
    StandstillCounts,
    /// A status counts as sent when it is received.
    LateStatusCounts,
    /// The process ends at once, as if killed, when a file of the archive is uploaded and its position is not advanced.
    DeathAfterUpload,
    /// The archive's horizon is the present, although earlier contacts may not be committed yet.
    EarlyHorizon,
}

#[cfg(feature = "test-faults")]
thread_local! {
    /// The fault of what runs in this thread alone.
    static PLANTED: Cell<Option<Fault>> = const { Cell::new(None) };
}

/// Runs `work` with a fault in this thread alone, for supervisors in simulated time.
#[cfg(feature = "test-faults")]
pub fn planted<T>(fault: Fault, work: impl FnOnce() -> T) -> T {
    PLANTED.set(Some(fault));
    let result = work();
    PLANTED.set(None);
    result
}

/// Whether the test has planted this fault in the thread, or the environment variable `VIBRISSA_TEST_FAULT` requests it.
#[cfg(feature = "test-faults")]
#[must_use]
pub fn is(fault: Fault) -> bool {
    static ASKED_FOR: std::sync::OnceLock<Option<String>> = std::sync::OnceLock::new();
    let word = match fault {
        Fault::ReceiptBeforeCommit => "receipt_before_commit",
        Fault::OffsetBeforeState => "offset_before_state",
        Fault::NoFence => "no_fence",
        Fault::RowsBeforeFence => "rows_before_fence",
        Fault::DeliveredBeforeRequest => "delivered_before_request",
        Fault::NoHold => "no_hold",
        Fault::EpochReuse => "epoch_reuse",
        Fault::ExpiryByHostClock => "expiry_by_host_clock",
        Fault::NewerStateRead => "newer_state_read",
        Fault::StandstillCounts => "standstill_counts",
        Fault::LateStatusCounts => "late_status_counts",
        Fault::DeathAfterUpload => "death_after_upload",
        Fault::EarlyHorizon => "early_horizon",
    };
    PLANTED.get() == Some(fault)
        || ASKED_FOR.get_or_init(|| std::env::var("VIBRISSA_TEST_FAULT").ok()).as_deref() == Some(word)
}

/// Always false without the feature `test-faults`.
#[cfg(not(feature = "test-faults"))]
#[must_use]
pub const fn is(_: Fault) -> bool {
    false
}
