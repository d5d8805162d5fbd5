//! Time of this supervisor among the other clocks: host, database, robots and other supervisors.
//!
//! The process has one time line ([`vibrissa_edge::clock`]), which no step of the host's clock reaches. Each turn of
//! `ownership` reads all clocks here. [`judge`] decides which are right. From that follow a metric, the reason in `/readyz`, the
//! report to the other supervisors, and whether the time line must follow its host.

mod hold_back;
mod judge;
mod robots;

use std::time::Duration;

use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_host::clock::{host_ahead_us, step};
use vibrissa_store::{ClockReport, Membership};

use crate::metrics::Metrics;
use crate::readiness::Readiness;
pub(crate) use hold_back::HoldBack;
pub(crate) use judge::SET_FROM_US;
use judge::{Readings, Source, Standing};
pub(crate) use robots::{ROBOTS_MAX, RobotClocks};

/// Name of this part in the service's readiness.
const PART: &str = "clock";
/// A new judgement counts after this time: a single reading may be wrong.
const SETTLED_AFTER: Duration = Duration::from_secs(1);
/// Smaller differences between the host's clock and the time line are delays of reading them.
const LEAST_STEP_US: i64 = 2_000;

/// A judgement of all clocks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Judgement {
    standing: Standing,
    is_host_off: bool,
    follows_host: bool,
}

impl Judgement {
    /// Whether a supervisor with a right clock should have the fleets: the others contradict this one, or its host.
    fn is_wrong(self) -> bool {
        self.standing == Standing::Wrong || self.is_host_off && !self.follows_host
    }
}

/// The latest judgement, and the one in force.
#[derive(Debug, Default)]
struct Settling {
    in_force: Judgement,
    latest: Judgement,
    since: Option<Instant>,
}

impl Settling {
    /// Takes a judgement in. Returns whether the one in force has changed.
    fn take(&mut self, judgement: Judgement, now: Instant) -> bool {
        if judgement != self.latest || self.since.is_none() {
            (self.latest, self.since) = (judgement, Some(now));
        }
        let is_settled = self.since.is_some_and(|since| now.duration_since(since) >= SETTLED_AFTER);
        let changes = is_settled && judgement != self.in_force;
        if changes {
            self.in_force = judgement;
        }
        changes
    }
}

/// The clocks of one supervisor.
#[derive(Debug, Default)]
pub(crate) struct Clocks {
    readings: Readings,
    settling: Settling,
    report: ClockReport,
    hold_back: HoldBack,
}

impl Clocks {
    pub(crate) fn new(hold_back: HoldBack) -> Self {
        Self { hold_back, ..Self::default() }
    }

    /// Reads all clocks, and says how they stand.
    pub(crate) fn read(
        &mut self,
        membership: &Membership,
        (supervisor, robots): (&str, &RobotClocks),
        (metrics, readiness): (&Metrics, &Readiness),
    ) {
        let host = host_ahead_us();
        let is_small = host.abs() <= judge::NEAR_US;
        if is_small && host.abs() >= LEAST_STEP_US {
            step(host);
        }
        let own_robots = robots.vote(wall_clock().0 as i64);
        let database = membership.database_ahead_us;
        let others = || membership.present.iter().filter(move |one| one.supervisor != supervisor).map(|one| &one.clock);
        // Others say how far they are ahead of the database.
        let from_here = |of: fn(&ClockReport) -> Option<i64>| {
            database.into_iter().flat_map(move |database| others().filter_map(of).map(move |ahead| ahead + database))
        };
        let robots_of_others = from_here(|one| one.robots_ahead_us);
        self.readings = Readings {
            host: if is_small { 0 } else { host },
            database,
            robots: judge::median(own_robots.into_iter().chain(robots_of_others).collect()),
            supervisors: from_here(|one| one.ahead_us).collect(),
        };
        let judgement = Judgement {
            standing: self.readings.standing(),
            is_host_off: self.readings.is_host_off(),
            follows_host: self.readings.follows_host(wall_clock().0 as i64),
        };
        if self.settling.take(judgement, Instant::now()) {
            self.log();
        }
        let in_force = self.settling.in_force;
        self.report = ClockReport {
            ahead_us: database.map(|ahead| -ahead),
            robots_ahead_us: own_robots.zip(database).map(|(robots, database)| robots - database),
            is_wrong: in_force.is_wrong(),
        };
        self.hold_back.set(&self.readings, robots.any(wall_clock().0 as i64));
        metrics.clocks.show(Source::ALL.map(|source| (source.label(), self.readings.of(source))));
        readiness.set(PART, self.problem());
    }

    /// The report for the other supervisors.
    pub(crate) fn report(&self) -> ClockReport {
        self.report
    }

    /// Whether the time line must follow a step of its host's clock. Supervision of all fleets must end before
    /// [`Self::follow_host`]: its times would not fit any more.
    pub(crate) fn must_follow_host(&self) -> bool {
        self.settling.in_force.follows_host && self.readings.follows_host(wall_clock().0 as i64)
    }

    /// Moves the time line to the host's clock.
    pub(crate) fn follow_host(&mut self) {
        let ahead_us = host_ahead_us();
        warn!(seconds = seconds(ahead_us), "following a step of the host's clock");
        step(ahead_us);
        self.hold_back.begin_again();
        *self = Self { report: self.report, ..Self::new(self.hold_back.clone()) };
    }

    fn log(&self) {
        match self.problem() {
            Some(problem) => warn!("{problem}"),
            None => info!("this supervisor's clock agrees with most others"),
        }
        for source in Source::ALL {
            if let Some(ahead_us) = self.readings.of(source).filter(|ahead| ahead.abs() > judge::NEAR_US) {
                warn!(clock = source.label(), seconds_ahead = seconds(ahead_us), "a clock disagrees");
            }
        }
    }

    /// Why this supervisor's time cannot be trusted, and what to do.
    fn problem(&self) -> Option<String> {
        let in_force = self.settling.in_force;
        let off: Vec<String> = Source::ALL
            .into_iter()
            .filter_map(|source| Some((source, self.readings.of(source)?)))
            .filter(|(_, ahead_us)| ahead_us.abs() > judge::NEAR_US)
            .map(|(source, ahead_us)| format!("{} is {}", source.name(), ahead(ahead_us)))
            .collect();
        if off.is_empty() {
            return None;
        }
        let why = match (in_force.standing, in_force.is_host_off) {
            _ if in_force.follows_host => "the host's clock was stepped, and this supervisor follows it",
            (Standing::Wrong, _) => "most other clocks contradict this supervisor's",
            (Standing::Doubtful, _) => "clocks disagree, and no majority tells which is right",
            (Standing::Agrees, true) => {
                "the host's clock was stepped, and the others do not confirm it: this supervisor keeps its own time"
            }
            (Standing::Agrees, false) => return None,
        };
        Some(format!("{why}: {}; check the time synchronisation (NTP) of these hosts", off.join(", ")))
    }
}

fn seconds(us: i64) -> f64 {
    us as f64 / 1e6
}

fn ahead(us: i64) -> String {
    let way = if us < 0 { "behind" } else { "ahead" };
    format!("{:.1} s {way}", seconds(us).abs())
}

#[cfg(test)]
mod tests;
