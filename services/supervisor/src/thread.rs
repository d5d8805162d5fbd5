//! Threads for the work of fleets that each message wakes.
//!
//! The threads of the program's own runtime wake each other to look for work, and each wake-up finds cold caches: in a fleet
//! with little traffic, that is most of a message's cost. So a fleet works in one thread with an event loop of its own. There
//! are as many of these threads as cores; further fleets share them, so that a tick wakes few threads, however many
//! fleets there are.

use std::future::Future;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::runtime::{Builder, Handle};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use vibrissa_host::{process, task};

use crate::ending::stopped;

/// The threads. They end when the last clone is dropped.
#[derive(Debug, Clone)]
pub(crate) struct Threads(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    most: usize,
    threads: Mutex<Vec<Thread>>,
    /// Dropped at the end.
    alive: watch::Sender<()>,
}

#[derive(Debug)]
struct Thread {
    runtime: Handle,
    occupancy: Occupancy,
}

/// Number of those who work in a thread.
#[derive(Debug, Clone, Default)]
pub struct Occupancy(Arc<AtomicUsize>);

impl Occupancy {
    /// Whether several work in the thread, so that none may block it.
    pub(crate) fn is_shared(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 1
    }
}

/// A place in a thread, until it is dropped.
#[derive(Debug)]
pub(crate) struct ThreadSlot {
    runtime: Handle,
    occupancy: Occupancy,
}

impl Threads {
    /// As many threads as there are cores, each started when it is needed.
    pub(crate) fn of_all_cores() -> Self {
        Self::new(task::cores())
    }

    fn new(most: usize) -> Self {
        Self(Arc::new(Inner { most, threads: Mutex::default(), alive: watch::Sender::new(()) }))
    }

    /// A place in a new thread, or in the one with the fewest places taken.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(crate) fn place(&self) -> io::Result<ThreadSlot> {
        if process::simulated().is_some() {
            // One thread has the whole simulation.
            let occupancy = Occupancy(Arc::new(AtomicUsize::new(2)));
            return Ok(ThreadSlot { runtime: Handle::current(), occupancy });
        }
        let mut threads = self.0.threads.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = |thread: &Thread| thread.occupancy.0.load(Ordering::Relaxed);
        let has_free = threads.iter().any(|thread| taken(thread) == 0);
        if !has_free && threads.len() < self.0.most {
            threads.push(Thread::start(self.0.alive.subscribe())?);
        }
        let least = threads.iter().min_by_key(|thread| taken(thread));
        let thread = least.ok_or_else(|| io::Error::other("no thread is allowed"))?;
        thread.occupancy.0.fetch_add(1, Ordering::Relaxed);
        Ok(ThreadSlot { runtime: thread.runtime.clone(), occupancy: thread.occupancy.clone() })
    }
}

impl Thread {
    fn start(mut alive: watch::Receiver<()>) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let handle = runtime.handle().clone();
        std::thread::Builder::new().name("fleet".to_owned()).spawn(move || {
            // Nothing is ever sent: this is the end of the sender.
            let _ = runtime.block_on(alive.changed());
            // Does not wait for blocking tasks such as a DNS lookup.
            runtime.shutdown_background();
        })?;
        Ok(Self { runtime: handle, occupancy: Occupancy::default() })
    }
}

impl ThreadSlot {
    /// Number of those who work in this thread.
    pub(crate) fn occupancy(&self) -> Occupancy {
        self.occupancy.clone()
    }

    /// Runs `work` here until it ends or `stop` is set. `None` if it was stopped.
    pub(crate) fn spawn<T: Send + 'static>(
        self,
        work: impl Future<Output = T> + Send + 'static,
        mut stop: watch::Receiver<bool>,
    ) -> JoinHandle<Option<T>> {
        let runtime = self.runtime.clone();
        task::spawn_on(&runtime, async move {
            let _place = self;
            tokio::select! {
                ended = work => Some(ended),
                () = stopped(&mut stop) => None,
            }
        })
    }
}

impl Drop for ThreadSlot {
    fn drop(&mut self) {
        self.occupancy.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use std::future::pending;
    use std::thread::{ThreadId, current};

    use super::*;

    async fn thread_of(place: ThreadSlot) -> ThreadId {
        let (_stop, stopping) = watch::channel(false);
        place.spawn(async { current().id() }, stopping).await.unwrap().unwrap()
    }

    #[tokio::test]
    async fn work_ends_by_itself_or_is_stopped() {
        let (stop, stopping) = watch::channel(false);
        let threads = Threads::new(1);
        let here = current().id();
        let elsewhere = threads.place().unwrap().spawn(async move { current().id() != here }, stopping.clone());
        assert_eq!(elsewhere.await.unwrap(), Some(true));
        let endless = threads.place().unwrap().spawn(pending::<()>(), stopping);
        stop.send(true).unwrap();
        assert_eq!(endless.await.unwrap(), None);
    }

    #[tokio::test]
    async fn places_are_shared_only_when_all_threads_have_one() {
        let threads = Threads::new(2);
        let places: Vec<ThreadSlot> = (0..3).map(|_| threads.place().unwrap()).collect();
        assert_eq!(places.iter().map(|place| place.occupancy().is_shared()).collect::<Vec<_>>(), [true, false, true]);
        let [first, second, third] = <[ThreadSlot; 3]>::try_from(places).unwrap();
        let free = second.occupancy();
        let (first, second) = (thread_of(first).await, thread_of(second).await);
        assert_ne!(first, second);
        assert_eq!((thread_of(third).await, free.0.load(Ordering::Relaxed)), (first, 0));
        let again = threads.place().unwrap();
        assert!(!again.occupancy().is_shared(), "a place is free again at the end of its work");
    }

    #[tokio::test]
    async fn a_thread_ends_with_the_last_clone_and_drops_its_work() {
        let (held, mut released) = watch::channel(());
        let (_stop, stopping) = watch::channel(false);
        let threads = Threads::new(1);
        let work = async move {
            let _held = held;
            pending::<()>().await;
        };
        let ended = threads.clone().place().unwrap().spawn(work, stopping);
        drop(threads);
        assert!(released.changed().await.is_err());
        assert!(ended.await.unwrap_err().is_cancelled());
    }
}
