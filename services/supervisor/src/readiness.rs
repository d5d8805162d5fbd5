//! Problems that keep the service from its work, and its standing in each fleet: the content of `/readyz`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use tokio::time::Instant;
use vibrissa_protocol::Name;

use crate::mqtt::{BrokerLink, NodesInUse};
use crate::promises::{Ages, PATIENCE, Promises};
use vibrissa_store::SetAside;

/// Time for which `/readyz` names items that were set aside.
pub(crate) const SET_ASIDE_TOLD: Duration = Duration::from_secs(600);

/// Shared by all parts that can have a problem.
#[derive(Debug, Clone, Default)]
pub struct Readiness(Arc<Mutex<Parts>>);

#[derive(Debug, Default)]
struct Parts {
    problems: BTreeMap<String, String>,
    notices: BTreeMap<String, Notice>,
    rows: SetAside,
    fleets: BTreeMap<Name, Standing>,
    links: BTreeMap<Name, (BrokerLink, Promises)>,
    /// Time of the last answer of the database, by the renewal of the leases; `None` before the first.
    answered: Option<Instant>,
}

/// A finding that people must know.
#[derive(Debug)]
struct Notice {
    text: String,
    /// Time from which on it is no longer told; `None` until it is cleared.
    until: Option<Instant>,
}

/// This supervisor's role in a fleet.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "standing", rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Standing {
    /// This supervisor owns it.
    Owned {
        /// Epoch of the lease.
        epoch: u64,
    },
    /// Another supervisor owns it, or nobody does yet.
    Standby {
        /// Name of the supervisor that owns it; null if there is none.
        holder: Option<String>,
    },
}

impl Readiness {
    /// Sets the problem of a part; `None` clears it.
    pub fn set(&self, part: impl Into<String>, problem: Option<String>) {
        let part = part.into();
        let mut parts = self.parts();
        match problem {
            Some(problem) => drop(parts.problems.insert(part, problem)),
            None => drop(parts.problems.remove(&part)),
        }
    }

    /// Sets this supervisor's role in a fleet.
    pub fn stands(&self, fleet: &Name, standing: Standing) {
        self.parts().fleets.insert(fleet.clone(), standing);
    }

    /// Sets the problem of a part of a fleet's supervision; `None` clears it.
    pub fn set_of(&self, fleet: &Name, part: &str, problem: Option<String>) {
        self.set(format!("{}{part}", prefix(fleet)), problem.map(|problem| format!("fleet {fleet}: {problem}")));
    }

    /// Sets a finding about a part of a fleet's supervision that people must know although it works; `None` clears it.
    pub(crate) fn notice_of(&self, fleet: &Name, part: &str, notice: Option<String>) {
        let notice = notice.map(|notice| format!("fleet {fleet}: {notice}"));
        self.notice(&format!("{}{part}", prefix(fleet)), notice);
    }

    /// The same about a part of the service.
    pub(crate) fn notice(&self, part: &str, notice: Option<String>) {
        self.tell(part, notice, None);
    }

    fn tell(&self, part: &str, notice: Option<String>, until: Option<Instant>) {
        let mut parts = self.parts();
        match notice {
            Some(text) => drop(parts.notices.insert(part.to_owned(), Notice { text, until })),
            None => drop(parts.notices.remove(part)),
        }
    }

    /// Findings that people must know although the service works.
    #[must_use]
    pub fn notices(&self) -> Vec<String> {
        let (parts, now) = (self.parts(), Instant::now());
        let told = parts.notices.values().filter(|notice| notice.until.is_none_or(|until| now < until));
        told.map(|notice| notice.text.clone()).chain(parts.rows.notices()).collect()
    }

    /// Includes the database's rows that cannot be read among the findings.
    pub(crate) fn tells_rows(&self, rows: SetAside) {
        self.parts().rows = rows;
    }

    /// Names unreadable items of a fleet, which were set aside, for a while.
    pub(crate) fn tell_set_aside(&self, fleet: &Name, part: &'static str, what: &str) {
        let (part, notice) = (format!("{}{part}", prefix(fleet)), format!("fleet {fleet}: {what}"));
        self.tell(&part, Some(notice), Some(Instant::now() + SET_ASIDE_TOLD));
    }

    /// Registers the link and the promises of a fleet, whose problems are then included.
    pub(crate) fn listens(&self, fleet: &Name, link: BrokerLink, promises: Promises) {
        self.parts().links.insert(fleet.clone(), (link, promises));
    }

    /// Notes that the database has answered.
    pub(crate) fn database_answered(&self) {
        self.parts().answered = Some(Instant::now());
    }

    /// Removes the problems and the link of a fleet that is no longer supervised here.
    pub(crate) fn forget(&self, fleet: &Name) {
        let mut parts = self.parts();
        parts.links.remove(fleet);
        parts.problems.retain(|part, _| !part.starts_with(&prefix(fleet)));
        parts.notices.retain(|part, _| !part.starts_with(&prefix(fleet)));
    }

    /// All problems, without duplicates.
    #[must_use]
    pub fn problems(&self) -> BTreeSet<String> {
        let parts = self.parts();
        let mut problems: BTreeSet<String> = parts.problems.values().cloned().collect();
        for (fleet, (link, promises)) in &parts.links {
            problems.extend(link.problems());
            problems.extend(promises.problems().iter().map(|problem| format!("fleet {fleet}: {problem}")));
        }
        problems.extend(parts.database_problem(Instant::now()));
        problems
    }

    /// Ages of the open promises of each fleet that is supervised here.
    #[must_use]
    pub fn promises(&self) -> BTreeMap<Name, Ages> {
        self.parts().links.iter().map(|(fleet, (_, promises))| (fleet.clone(), promises.ages())).collect()
    }

    /// Nodes of the broker that the connections of each fleet use.
    #[must_use]
    pub fn nodes(&self) -> BTreeMap<Name, NodesInUse> {
        self.parts().links.iter().map(|(fleet, (link, _))| (fleet.clone(), link.nodes())).collect()
    }

    /// This supervisor's role in each fleet.
    #[must_use]
    pub fn fleets(&self) -> BTreeMap<Name, Standing> {
        self.parts().fleets.clone()
    }

    fn parts(&self) -> MutexGuard<'_, Parts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Parts {
    /// The database has not answered for too long, and has not refused anything either.
    fn database_problem(&self, now: Instant) -> Option<String> {
        let silent = now.saturating_duration_since(self.answered?);
        let problem = |silent: Duration| format!("the database has not answered for {} s", silent.as_secs());
        (silent > PATIENCE).then(|| problem(silent))
    }
}

/// Prefix of the names of a fleet's parts; no name has a colon.
fn prefix(fleet: &Name) -> String {
    format!("fleet {fleet}: ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The time of the first notice ended the second one.
    #[tokio::test(start_paused = true)]
    async fn regress_what_is_set_aside_is_named_for_its_time() {
        let (readiness, fleet) = (Readiness::default(), Name::new("f").unwrap());
        readiness.tell_set_aside(&fleet, "stored", "3 items");
        tokio::time::advance(SET_ASIDE_TOLD - Duration::from_secs(1)).await;
        assert_eq!(readiness.notices(), ["fleet f: 3 items"]);
        readiness.tell_set_aside(&fleet, "stored", "4 items");
        tokio::time::advance(Duration::from_secs(2)).await;
        assert_eq!(readiness.notices(), ["fleet f: 4 items"]);
        tokio::time::advance(SET_ASIDE_TOLD).await;
        assert!(readiness.notices().is_empty());
    }

    #[test]
    fn regress_what_was_wrong_with_a_fleet_goes_with_it() {
        let readiness = Readiness::default();
        let [a, ab] = ["a", "ab"].map(|fleet| Name::new(fleet).unwrap());
        readiness.set_of(&a, "database", Some("nothing is recorded".to_owned()));
        readiness.set_of(&ab, "database", Some("nothing is recorded".to_owned()));
        readiness.listens(&a, BrokerLink::default(), Promises::default());
        assert_eq!(readiness.problems().len(), 3);
        readiness.forget(&a);
        assert_eq!(readiness.problems(), BTreeSet::from(["fleet ab: nothing is recorded".to_owned()]));
    }

    #[test]
    fn a_promise_that_is_not_kept_names_its_fleet_and_goes_with_it() {
        let (readiness, promises) = (Readiness::default(), Promises::default());
        let fleet = Name::new("a").unwrap();
        readiness.listens(&fleet, BrokerLink::default(), promises.clone());
        promises.failed("nothing is recorded: the disk is full".to_owned());
        assert!(readiness.problems().contains("fleet a: nothing is recorded: the disk is full"));
        readiness.forget(&fleet);
        assert_eq!((readiness.problems(), readiness.promises()), (BTreeSet::new(), BTreeMap::new()));
    }

    #[test]
    fn regress_a_database_that_hangs_is_a_problem_without_a_failed_attempt() {
        let now = Instant::now();
        let parts = Parts { answered: Some(now), ..Parts::default() };
        assert_eq!(parts.database_problem(now + PATIENCE), None);
        let problem = parts.database_problem(now + PATIENCE * 2).unwrap();
        assert_eq!(problem, "the database has not answered for 20 s");
    }
}
