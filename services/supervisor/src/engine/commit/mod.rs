//! The path from the effects of a step to committed rows. [`super::pipeline`] decides when they are written, and reads them
//! back after a restart.
//!
//! - [`batch`]: the effects of a worker's steps since the last transaction was sealed.
//! - [`journal`]: an input log. A step without a decision writes its *event* here, and the robot's checkpoint may wait.
//! - [`checkpoint`]: robots' states as rows, written at once after a decision, otherwise about two seconds later.
//! - [`transaction`]: a sealed transaction on its way to the database.
//! - [`committer`]: one transaction in the database, with retries while the database is unreachable.
//!
//! The states of a transaction:
//!
//! ```text
//! open ──the schedule, or at once for a setpoint──▶ sealed ──▶ rows committed ──▶ its publications go out
//! ```
//!
//! The durable state of a robot is its checkpoint, and the journal's entries after it. In the open batch it is one of
//! [`super::robot::Durable`]:
//!
//! ```text
//! Checkpoint ──ordinary message──▶ Journal(n) ──ordinary message──▶ Journal(n)
//! Checkpoint, Journal(n), BeforeTakeover ──any other step──▶ NextCheckpoint ──written in this transaction──▶ Checkpoint
//! Journal(n) ──two seconds later, written──▶ Checkpoint
//! takeover ──▶ BeforeTakeover: the checkpoint is older than the takeover, so that no entry may be added to it
//! ```
//!
//! Each transaction advances the counter of commits in the lease's row, if owner, epoch and counter are those that this
//! supervisor knows (`store/lease.rs`). The same statement fences off an owner that has lost the fleet, keeps a repeated
//! attempt from writing anything twice, and renews the lease. Transactions that assign numbers to robots, boots and
//! whiskers are counted apart. A batch may refer to these numbers, so it is written only if the row has at least the known
//! count.

pub(crate) mod batch;
pub(crate) mod checkpoint;
pub(crate) mod committer;
pub(crate) mod journal;
pub(crate) mod transaction;
