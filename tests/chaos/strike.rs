//! Injects faults and repairs them.

use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use sqlx::{AssertSqlSafe, ConnectOptions, Executor};
use tokio::time::sleep;
use vibrissa_tests::proxy::Proxy;

use crate::forget::forget;
use crate::owner::{OWNER_PATIENCE, Reign, Watch};
use crate::plan::{Fault, Manner, Strike};
use crate::scenario::fleet;
use crate::stage::{FORGET_USER, SUPERVISOR_PASSWORD, Stage, Supervisor};

/// Steps of clocks, in µs. The runs take place after 2025.
const HOUR_US: i64 = 3_600_000_000;
const BEHIND_US: i64 = -120_000_000;
const TO_1970_US: i64 = -1_735_689_600_000_000;
/// Time in which a supervisor must end after SIGTERM.
const END_PATIENCE: Duration = Duration::from_secs(12);

/// A fault that has struck.
#[derive(Debug, Clone)]
pub struct Struck {
    /// Kind of the fault.
    pub fault: Fault,
    /// Time at which it struck.
    pub at: Instant,
    /// For faults that take the fleet from its owner: the time of the hit and the owner's epoch.
    pub owner_hit: Option<(Instant, i64)>,
}

/// Counts of unintended events.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surprises {
    /// Number of supervisors that ended unexpectedly.
    pub ended: u64,
    /// Number of supervisors that failed or did not end after SIGTERM, and of brokers that forgot nothing.
    pub stuck: u64,
    /// Number of faults that found no owner in time.
    pub ownerless: u64,
}

/// Injects faults one after the other.
pub struct Striker<'a> {
    /// The programs of the run.
    pub stage: &'a mut Stage,
    /// Watch on the fleet's owner.
    pub watch: &'a Watch,
    /// Faults that have struck.
    pub struck: Vec<Struck>,
    /// Unintended events so far.
    pub surprises: Surprises,
    /// Lowest epoch of the next owner.
    epoch_min: i64,
}

impl<'a> Striker<'a> {
    /// Starts without any fault.
    pub fn new(stage: &'a mut Stage, watch: &'a Watch) -> Self {
        Self { stage, watch, struck: Vec::new(), surprises: Surprises::default(), epoch_min: 0 }
    }

    /// Injects one fault and returns when the damage is repaired.
    pub async fn strike(&mut self, strike: &Strike) {
        self.surprises.ended += self.stage.revive();
        let reign = self.watch.owner(self.epoch_min, OWNER_PATIENCE).await;
        let Some((owner, reign)) = reign.and_then(|reign| Some((self.place(&reign)?, reign))) else {
            eprintln!("chaos: no owner in time: skipping {}", strike.fault);
            self.surprises.ownerless += 1;
            return;
        };
        eprintln!("chaos: {} (owner {}, epoch {}), {:.1} s", strike.fault, reign.holder, reign.epoch, strike.lasts_s);
        let begun = Instant::now();
        let owner_hit = self.carry_out(strike, owner).await;
        if owner_hit.is_some() {
            self.epoch_min = reign.epoch + 1;
        }
        let owner_hit = owner_hit.map(|hit| (hit, reign.epoch));
        self.struck.push(Struck { fault: strike.fault, at: begun, owner_hit });
    }

    /// Index of the supervisor, if it is running.
    fn place(&self, reign: &Reign) -> Option<usize> {
        self.stage.supervisors.iter().position(|one| one.name == reign.holder && one.process.is_running())
    }

    /// Injects the fault. Returns the time of the hit if the fault is for the owner.
    async fn carry_out(&mut self, strike: &Strike, owner: usize) -> Option<Instant> {
        let lasts = Duration::from_secs_f64(strike.lasts_s);
        match strike.fault {
            Fault::OwnerKilled => {
                let hit = self.kill(owner);
                // Before the other supervisor may take the fleet over, so that only robots can tell it who they are.
                let robots: Vec<_> = self.stage.robots.iter().map(|robot| (fleet(), robot.clone())).collect();
                if !forget(("127.0.0.1", self.stage.broker.port()), (FORGET_USER, SUPERVISOR_PASSWORD), &robots).await {
                    eprintln!("chaos: the broker did not forget its retained messages");
                    self.surprises.stuck += 1;
                }
                sleep(lasts.saturating_sub(hit.elapsed())).await;
                self.stage.supervisors[owner].process.restart();
                Some(hit)
            }
            Fault::OwnerTerminated => {
                let hit = self.terminate(owner).await;
                sleep(lasts).await;
                self.stage.supervisors[owner].process.restart();
                Some(hit)
            }
            Fault::OwnerFrozen => {
                let hit = self.freeze(owner);
                sleep(lasts).await;
                self.stage.supervisors[owner].process.signal(Signal::SIGCONT);
                Some(hit)
            }
            Fault::BrokerKilled => {
                self.kill_broker(lasts).await;
                None
            }
            Fault::DatabaseKilled => {
                tokio::task::block_in_place(|| self.stage.database.kill());
                sleep(lasts).await;
                self.stage.database.restart().await;
                None
            }
            Fault::RobotLinks => {
                break_links(&self.robot_links(strike.victims), strike.manner, lasts).await;
                None
            }
            Fault::BrokerLinks => {
                let links = self.supervisor_links(strike.victims, owner, |one| &one.broker_link);
                break_links(&links, strike.manner, lasts).await;
                None
            }
            Fault::DatabaseLinks => {
                let links = self.supervisor_links(strike.victims, owner, |one| &one.database_link);
                break_links(&links, strike.manner, lasts).await;
                None
            }
            Fault::OwnerCommitsLate => {
                let link = &self.stage.supervisors[owner].database_link;
                let hit = Instant::now();
                break_links(&[link], Manner::Stall, lasts).await;
                Some(hit)
            }
            Fault::DatabaseAwayOwnerKilled => {
                tokio::task::block_in_place(|| self.stage.database.kill());
                sleep(lasts / 3).await;
                let hit = self.kill(owner);
                sleep(lasts / 3).await;
                self.stage.database.restart().await;
                sleep(lasts / 3).await;
                self.stage.supervisors[owner].process.restart();
                Some(hit)
            }
            Fault::HostClockStepped => {
                let steps_us = [HOUR_US, -HOUR_US, TO_1970_US];
                let owner = &self.stage.supervisors[owner];
                owner.set_clock(steps_us[usize::from(strike.victims) % steps_us.len()]);
                sleep(lasts).await;
                owner.set_clock(0);
                None
            }
            Fault::DatabaseClockBackOwnerKilled => {
                self.set_database_clock(BEHIND_US).await;
                let hit = self.kill(owner);
                sleep(lasts.saturating_sub(hit.elapsed())).await;
                self.set_database_clock(0).await;
                self.stage.supervisors[owner].set_clock(BEHIND_US);
                self.stage.supervisors[owner].process.restart();
                Some(hit)
            }
            Fault::OwnerFrozenBrokerKilled => {
                let hit = self.freeze(owner);
                sleep(lasts / 4).await;
                self.kill_broker(lasts / 4).await;
                sleep(lasts.saturating_sub(hit.elapsed())).await;
                self.stage.supervisors[owner].process.signal(Signal::SIGCONT);
                Some(hit)
            }
        }
    }

    /// Sets the clock by which the database judges leases so far ahead of the true time, in µs.
    async fn set_database_clock(&mut self, ahead_us: i64) {
        let sql = format!(
            "CREATE OR REPLACE FUNCTION clock_us() RETURNS BIGINT LANGUAGE SQL VOLATILE \
             AS 'SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::BIGINT + ({ahead_us})'"
        );
        let set = async { self.stage.database.connect().connect().await?.execute(AssertSqlSafe(sql)).await };
        if let Err(problem) = set.await {
            eprintln!("chaos: cannot set the database's clock: {problem}");
            self.surprises.stuck += 1;
        }
    }

    fn kill(&mut self, owner: usize) -> Instant {
        let hit = Instant::now();
        tokio::task::block_in_place(|| self.stage.supervisors[owner].process.kill());
        hit
    }

    fn freeze(&mut self, owner: usize) -> Instant {
        self.stage.supervisors[owner].process.signal(Signal::SIGSTOP);
        Instant::now()
    }

    async fn terminate(&mut self, owner: usize) -> Instant {
        let Supervisor { name, process, .. } = &mut self.stage.supervisors[owner];
        let hit = Instant::now();
        process.signal(Signal::SIGTERM);
        match process.ended(END_PATIENCE).await {
            Some(status) if status.success() => return hit,
            Some(status) => eprintln!("chaos: supervisor {name} failed after SIGTERM: {status}"),
            None => {
                eprintln!("chaos: supervisor {name} does not end after SIGTERM");
                tokio::task::block_in_place(|| process.kill());
            }
        }
        self.surprises.stuck += 1;
        hit
    }

    async fn kill_broker(&mut self, lasts: Duration) {
        tokio::task::block_in_place(|| self.stage.broker.kill());
        sleep(lasts).await;
        tokio::task::block_in_place(|| self.stage.broker.restart());
    }

    fn robot_links(&self, victims: u8) -> Vec<&Proxy> {
        let is_victim = |at: usize| victims >> (2 * at) & 0b11 != 0;
        self.stage.robot_links.iter().enumerate().filter(|(at, _)| is_victim(*at)).map(|(_, link)| link).collect()
    }

    /// The owner's link, the other supervisor's, or both; the owner's is struck more often.
    fn supervisor_links(&self, victims: u8, owner: usize, link: impl Fn(&Supervisor) -> &Proxy) -> Vec<&Proxy> {
        let (of_owner, of_other) = (link(&self.stage.supervisors[owner]), link(&self.stage.supervisors[1 - owner]));
        match victims % 4 {
            0 => vec![of_other],
            1 => vec![of_owner],
            _ => vec![of_owner, of_other],
        }
    }
}

async fn break_links(links: &[&Proxy], manner: Manner, lasts: Duration) {
    if manner != Manner::Cut {
        links.iter().for_each(|link| link.stall(true));
        sleep(lasts).await;
    }
    if manner != Manner::Stall {
        links.iter().for_each(|link| link.cut());
    }
    links.iter().for_each(|link| link.stall(false));
}
