//! A bridge from the broker to the log: it writes each robot's messages to the robot's partition, in order.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};
use vibrissa_edge::partition::robot_hash;
use vibrissa_host::task;
use vibrissa_protocol::{RobotTopic, Topic};

use super::{Entry, ModelLog};

/// The topic of robots' messages.
pub const TOPIC: &str = "messages";
/// Number of its partitions.
pub const PARTITIONS: usize = 3;
/// Most records of a batch.
const BATCH: usize = 20;

/// A message that is to be written.
#[derive(Debug, Clone)]
struct Message {
    /// When it is written.
    due: Instant,
    robot: String,
    entry: Entry,
}

#[derive(Debug)]
struct State {
    waiting: [VecDeque<Message>; PARTITIONS],
    delay: Duration,
    repetition: f64,
    random: ChaCha8Rng,
}

#[derive(Debug)]
struct Inner {
    state: Mutex<State>,
    taken: Notify,
}

/// The bridge. Clones are the same one.
#[derive(Clone)]
pub struct Bridge(Arc<Inner>);

impl fmt::Debug for Bridge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bridge").finish_non_exhaustive()
    }
}

impl Bridge {
    /// Starts it. `written` learns the robot of each message when the log has it.
    #[must_use]
    pub fn start(log: &ModelLog, seed: u64, written: impl Fn(&str) + Send + Sync + 'static) -> Self {
        let random = ChaCha8Rng::seed_from_u64(seed ^ 0x0062_7269_6467);
        let waiting = [const { VecDeque::new() }; PARTITIONS];
        let state = State { waiting, delay: Duration::ZERO, repetition: 0.0, random };
        let bridge = Self(Arc::new(Inner { state: Mutex::new(state), taken: Notify::new() }));
        let (running, log) = (bridge.clone(), log.clone());
        task::spawn(async move {
            loop {
                match running.write(&log, &written) {
                    Some(due) => {
                        tokio::select! {
                            biased;
                            () = running.0.taken.notified() => {}
                            () = sleep_until(due) => {}
                        }
                    }
                    None => running.0.taken.notified().await,
                }
            }
        });
        bridge
    }

    /// Sets how late messages are written from now on.
    pub fn set_delay(&self, delay: Duration) {
        self.with(|state| state.delay = delay);
    }

    /// Sets the share of messages that are written twice, 0 to 1.
    pub fn set_repetition(&self, repetition: f64) {
        self.with(|state| state.repetition = repetition);
    }

    /// Takes a message that a client has published. Returns whether it is one that the log gets.
    #[must_use]
    pub fn take(&self, topic: &str, payload: &[u8]) -> bool {
        let Ok(Topic::Robot { fleet, robot, kind: RobotTopic::Contacts | RobotTopic::Status }) = Topic::parse(topic)
        else {
            return false;
        };
        let partition = robot_hash(fleet.as_str(), robot.as_str()) as usize % PARTITIONS;
        self.with(|state| {
            let times = if state.random.random_bool(state.repetition) { 2 } else { 1 };
            let waiting = &mut state.waiting[partition];
            // A message does not overtake an earlier one of its partition.
            let earlier = waiting.back().map_or_else(Instant::now, |last| last.due);
            let message = Message {
                due: earlier.max(Instant::now() + state.delay),
                robot: robot.to_string(),
                entry: Entry {
                    key: Some(format!("{fleet}/{robot}").into_bytes()),
                    value: Some(payload.to_vec()),
                    header: Some(("topic".to_owned(), topic.as_bytes().to_vec())),
                },
            };
            waiting.extend(std::iter::repeat_n(message, times));
        });
        self.0.taken.notify_one();
        true
    }

    /// Writes the messages that are due. Returns the time at which the next one is due.
    fn write(&self, log: &ModelLog, written: &impl Fn(&str)) -> Option<Instant> {
        let now = Instant::now();
        let mut next = None;
        for partition in 0..PARTITIONS {
            loop {
                let due: Vec<Message> = self.with(|state| {
                    let waiting = &mut state.waiting[partition];
                    let count = waiting.iter().take(BATCH).take_while(|message| message.due <= now).count();
                    waiting.drain(..count).collect()
                });
                if due.is_empty() {
                    break;
                }
                let entries: Vec<Entry> = due.iter().map(|message| message.entry.clone()).collect();
                log.append(TOPIC, partition, &entries);
                due.iter().for_each(|message| written(&message.robot));
            }
            let first = self.with(|state| state.waiting[partition].front().map(|message| message.due));
            next = [next, first].into_iter().flatten().min();
        }
        next
    }

    fn with<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        change(&mut self.0.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
