//! Hostile robots: each has its own password and does with it whatever the broker lets it do.
//!
//! Nothing of theirs is held against the database. What counts is that the honest robots lose nothing by them.

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

/// What all of them use.
pub struct Shared {
    messages: Arc<Messages>,
    tally: Arc<Tally>,
    flooding: Arc<Semaphore>,
}

/// Hostile robots that go on until they are stopped; dropped, they stop.
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
    /// Starts robots of those names, which go round the behaviours; together they show all of them from the start.
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
            // Each begins elsewhere in the order.
            let mut own = order.clone();
            own.rotate_left(at * order.len() / names.len().max(1));
            tokio::spawn(live(robot, own))
        });
        Self { tally, tasks: tasks.collect() }
    }

    /// They do nothing any more, and their connections break.
    pub fn stop(&self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }

    /// Setpoints that the supervisors sent to them.
    pub fn setpoints(&self) -> u64 {
        self.tally.setpoints()
    }

    /// What they did.
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
