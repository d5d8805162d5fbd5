//! The write path, from the effects of a step to committed rows and back after a restart.
//!
//! - [`batch`]: the effects of a shard's steps since the last transaction was sealed.
//! - [`journal`]: an input log. A step without a decision writes its *event* here, and the robot's checkpoint may wait.
//! - [`checkpoint`]: robots' states as rows, written at once after a decision, otherwise about two seconds later.
//! - [`schedule`]: group commit, the time at which the open batches become a transaction.
//! - [`pipeline`]: sealed transactions, one after the other, and the publications that wait for them.
//! - [`committer`]: one transaction in the database, with retries while the database is unreachable.
//! - [`recovery`]: intents become rows, checkpoints are loaded, and the journal is replayed through the core.
//!
//! A transaction:
//!
//! ```text
//! open ──schedule──▶ sealed ──no setpoint in it────────────────────────▶ rows committed ──▶ all publications go out
//!                      │                                                       ▲
//!                      └─a setpoint in it──▶ intent committed (`redo`) ────────┘ in the order of sealing
//!                                            └──▶ its publications go out now
//! ```
//!
//! The durable state of a robot is its checkpoint, and the journal's entries after it. In the open batch it is one of
//! [`super::shard::Stored`]:
//!
//! ```text
//! State ──────ordinary message──────▶ Journal(n) ──ordinary message──▶ Journal(n)
//! State, Journal(n), Before ──any other step──▶ Next ──checkpoint in this transaction──▶ State
//! Journal(n) ──two seconds later, a checkpoint──▶ State
//! takeover ──▶ Before: the checkpoint is older than the takeover, so that no entry may be added to it
//! ```
//!
//! Each transaction advances the counter of commits in the lease's row, if owner, epoch and counter are those that this
//! supervisor knows (`store/lease.rs`). The same statement fences off an owner that has lost the fleet, keeps a repeated
//! attempt from writing anything twice, and renews the lease.

pub(super) mod batch;
pub(super) mod checkpoint;
pub(super) mod committer;
pub(super) mod journal;
pub(super) mod pipeline;
pub(super) mod recovery;
pub(super) mod schedule;
