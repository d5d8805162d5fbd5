//! Black boxes: the messages of a robot around a trim, a fault or an alarm.
//!
//! [`tape`] keeps the newest messages of a robot in memory, with its state at some times, and [`reel`] keeps it within its
//! limits. [`recorder`] decides when a box begins and ends. [`lines`] makes a recording of a tape, and [`writer`] writes it
//! to the database, in a task of its own, by a [`job`]: no commit waits for it.

mod job;
mod lines;
pub(crate) mod recorder;
mod reel;
mod tape;
pub(crate) mod writer;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use prometheus::IntCounter;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tokio::time::{Duration, timeout};
use vibrissa_core::units::Micros;
use vibrissa_host::task;
use vibrissa_store::Lease;

use job::Job;
pub(crate) use recorder::Recorder;

/// Most memory for a robot's messages, bytes: two minutes of a robot with 24 whiskers, each with three contacts a second.
const ROBOT_BYTES_MAX: usize = 1024 * 1024;
/// Boxes that wait for the database. Each is a copy of a tape; beyond this number, boxes are tried again later.
const WAITING_MAX: usize = 16;
/// Time limit for writing the boxes that wait when a fleet is released.
const FLUSH_PATIENCE: Duration = Duration::from_millis(500);

/// Settings of the black boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlackBoxOptions {
    /// Seconds before and after an event; 0 for no boxes.
    pub seconds: u32,
    /// Memory for the messages of all robots, MiB.
    pub memory_mib: u32,
}

impl Default for BlackBoxOptions {
    fn default() -> Self {
        Self { seconds: 60, memory_mib: 256 }
    }
}

/// Shared parts of the recorders of all robots of a supervisor. The default records nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct BlackBoxes(Option<Arc<Inner>>);

#[derive(Debug)]
struct Inner {
    span: Micros,
    memory_bytes: usize,
    /// Number of recorders.
    robots: AtomicUsize,
    jobs: mpsc::Sender<Job>,
}

impl BlackBoxes {
    /// Starts the writer in `tasks`, unless the settings want no boxes. It ends with the last clone of this.
    pub(crate) fn start(options: BlackBoxOptions, writer: vibrissa_store::Writer, tasks: &mut JoinSet<()>) -> Self {
        if options.seconds == 0 {
            return Self::default();
        }
        let (jobs, waiting) = mpsc::channel(WAITING_MAX);
        task::spawn_in(tasks, writer::run(waiting, writer));
        Self(Some(Arc::new(Inner {
            span: Micros(u64::from(options.seconds) * 1_000_000),
            memory_bytes: options.memory_mib as usize * 1024 * 1024,
            robots: AtomicUsize::new(0),
            jobs,
        })))
    }

    /// The boxes of one fleet.
    pub(crate) fn of_fleet(&self, lease: &Lease, lost: &IntCounter) -> FleetBoxes {
        FleetBoxes { inner: self.0.clone(), lease: lease.clone(), lost: lost.clone() }
    }
}

/// The same, for the robots of one fleet.
#[derive(Debug, Clone)]
pub(crate) struct FleetBoxes {
    inner: Option<Arc<Inner>>,
    lease: Lease,
    /// Counts boxes that could not be written.
    lost: IntCounter,
}

impl FleetBoxes {
    /// Writes the boxes that wait, because the lease will be released.
    pub(crate) async fn flush(&self) {
        let Some(inner) = &self.inner else { return };
        let (done, is_done) = oneshot::channel();
        let flushed = async {
            if inner.jobs.send(Job::Flush(done)).await.is_ok() {
                // An error means that the writer has ended.
                let _ = is_done.await;
            }
        };
        // The database may be unreachable: then the boxes stay as they are, and the next owner marks them.
        let _ = timeout(FLUSH_PATIENCE, flushed).await;
    }
}

impl Inner {
    /// Limits of one robot's tape: each has the same share, so a robot that sends much loses only its own messages.
    fn limits(&self) -> reel::Limits {
        let share = self.memory_bytes / self.robots.load(Ordering::Relaxed).max(1);
        reel::Limits { share: share.min(ROBOT_BYTES_MAX), span: self.span }
    }
}
