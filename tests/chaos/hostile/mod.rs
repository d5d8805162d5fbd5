//! Hostile robots. Each has its own password and does whatever the broker lets it do.
//!
//! The harness does not compare their messages with the database. It only checks that the honest robots lose nothing.

mod behaviour;
mod client;
mod deeds;
mod robot;
mod tally;

use std::sync::Arc;
use std::time::Duration;

use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tokio::sync::Semaphore;
use tokio::task::JoinHandle;
use vibrissa_protocol::Name;
use vibrissa_tests::extremes::Messages;
use vibrissa_tests::proxy::Proxy;

pub use behaviour::Behaviour;
use robot::Robot;
use tally::Tally;

/// Resources that all hostile robots share.
pub struct Shared {
    messages: Arc<Messages>,
    tally: Arc<Tally>,
    flooding: Arc<Semaphore>,
}

/// Running hostile robots; they stop on drop.
pub struct Hostile {
    tally: Arc<Tally>,
    tasks: Vec<JoinHandle<()>>,
}

impl Drop for Hostile {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Hostile {
    /// Starts robots with these names. Each robot repeats all behaviours, starting with a different one.
    pub fn start(names: &[Name], links: &[Proxy], behaviours: &[Behaviour], seed: u64) -> Self {
        let tally = Arc::new(Tally::new(behaviours));
        let shared = Shared {
            messages: Arc::new(Messages::default()),
            tally: tally.clone(),
            flooding: Arc::new(Semaphore::new(1)),
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x686f_7374);
        let mut order = behaviours.to_vec();
        order.shuffle(&mut random);
        let robots = names.iter().zip(links.iter().cycle());
        let tasks = robots.enumerate().filter(|_| !order.is_empty()).map(|(at, (name, link))| {
            let robot = Robot::new(name.clone(), link.port(), random.random(), &shared);
            // Each robot starts at a different place in the order.
            let mut own = order.clone();
            own.rotate_left(at * order.len() / names.len().max(1));
            tokio::spawn(live(robot, own))
        });
        Self { tally, tasks: tasks.collect() }
    }

    /// Stops all robots and breaks their connections.
    pub fn stop(&self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }

    /// Number of setpoints that they received, repetitions included.
    pub fn setpoints(&self) -> u64 {
        self.tally.setpoints()
    }

    /// Messages and connections so far, by name of the behaviour.
    pub fn counts(&self) -> std::collections::BTreeMap<String, u64> {
        self.tally.counts()
    }
}

async fn live(mut robot: Robot, behaviours: Vec<Behaviour>) {
    for &behaviour in behaviours.iter().cycle() {
        robot.behave(behaviour).await;
        let pause_s = robot.random.random_range(0.2..1.0);
        tokio::time::sleep(Duration::from_secs_f64(pause_s)).await;
    }
}
