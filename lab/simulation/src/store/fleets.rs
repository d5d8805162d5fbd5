//! What operators set for fleets, and request.

use std::collections::BTreeMap;

use vibrissa_protocol::Name;
use vibrissa_store::Lease;
use vibrissa_store::actions::{Action, FleetWork, NewAction};
use vibrissa_store::allowed::{AllowedReading, TurnedAwayReading};
use vibrissa_store::calibrations::ActiveCalibration;
use vibrissa_store::model::Fleets;
use vibrissa_store::policies::PolicyReading;
use vibrissa_store::rollouts::RolloutRow;

use super::table::Table;
use super::{FactRow, ModelStore, Of};

/// States of a roll-out that has not ended.
const OPEN: [&str; 2] = ["RUNNING", "PAUSED"];

/// The newest of a fleet's rows, whose keys are versions.
fn newest<'t, V: Clone>(table: &'t Table<Of<i64>, V>, fleet: &str) -> Option<&'t V> {
    table.range((fleet.to_owned(), i64::MIN)..=(fleet.to_owned(), i64::MAX)).next_back().map(|(_, row)| row)
}

impl ModelStore {
    /// Inserts an action that waits for its answer; returns its number.
    pub fn request_action(&mut self, action: &NewAction) -> i64 {
        let (action_id, new) = (self.next_number(), action.clone());
        let action = Action {
            action_id,
            fleet: new.fleet,
            robot: new.robot,
            array: new.array,
            whisker: new.whisker,
            compensation_id: new.compensation_id,
            alarm_id: new.alarm_id,
            kind: new.kind,
            parameters: new.parameters,
            reason: new.reason,
            actor: new.actor,
            role: new.role,
            request_id: new.request_id,
            idempotency_key: new.idempotency_key,
            asked_us: new.asked_us,
            expires_us: new.expires_us,
            state: "PENDING".to_owned(),
            problem: None,
            done_us: None,
        };
        self.actions.set(action_id, action);
        action_id
    }

    /// The actions, in the order of their requests.
    pub fn actions(&self) -> impl Iterator<Item = &Action> {
        self.actions.iter().map(|(_, action)| action)
    }

    /// Inserts a calibration in the form of a calibration file, as JSON; returns its number.
    pub fn add_calibration(&mut self, calibration: &str) -> i64 {
        let calibration_id = self.next_number();
        self.calibrations.set(calibration_id, calibration.to_owned());
        calibration_id
    }

    /// Sets a fleet's list of allowed robots, a name on each line; `None` allows all.
    pub fn allow_robots(&mut self, fleet: &Name, robots: Option<&str>) {
        let version = newest(&self.allowed, fleet.as_str()).map_or(1, |list| list.version + 1);
        let (robots, changed_us) = (robots.map(str::to_owned), self.clock_us);
        let list = AllowedReading { version, robots, changed_us, changed_by: "operator".to_owned(), reason: None };
        self.allowed.set((fleet.to_string(), version), list);
    }

    /// Whether the fleet has a roll-out other than this one that has not ended.
    pub(super) fn has_other_rollout(&self, row: &RolloutRow) -> bool {
        self.open_rollouts(&row.fleet).any(|other| other.rollout_id != row.rollout_id)
    }

    fn open_rollouts(&self, fleet: &str) -> impl Iterator<Item = &RolloutRow> {
        self.rollouts.iter().map(|(_, row)| row).filter(move |row| row.fleet == fleet && OPEN.contains(&&*row.state))
    }
}

impl Fleets for ModelStore {
    fn policy(&self, lease: &Lease) -> Option<PolicyReading> {
        newest(&self.policies, lease.fleet().as_str()).cloned()
    }

    fn calibrations(&self, lease: &Lease) -> Vec<ActiveCalibration> {
        let all = self.active_calibrations.iter();
        all.filter(|((fleet, _), _)| fleet == lease.fleet().as_str()).map(|(_, row)| row.clone()).collect()
    }

    fn allowed_robots(&self, lease: &Lease, after: i64) -> Option<AllowedReading> {
        newest(&self.allowed, lease.fleet().as_str()).filter(|list| list.version > after).cloned()
    }

    fn write_turned_away(&mut self, lease: &Lease, rows: &[TurnedAwayReading]) {
        self.note(lease, FactRow::TurnedAway(rows.to_vec()));
    }

    fn archive_floor(&self, fleet: &Name) -> i64 {
        self.horizons.get(&fleet.to_string()).copied().unwrap_or_default()
    }

    fn state_horizon(&mut self, lease: &Lease, written_to_us: i64) {
        let highest = self.archive_floor(lease.fleet()).max(written_to_us);
        self.horizons.set(lease.fleet().to_string(), highest);
    }

    fn open_rollout(&self, lease: &Lease) -> Option<RolloutRow> {
        self.open_rollouts(lease.fleet().as_str()).next().cloned()
    }

    fn pending(&self, lease: &Lease, most: i64, without: &[Name]) -> Vec<Action> {
        let is_left_out = |action: &Action| {
            action.robot.as_deref().is_some_and(|robot| without.iter().any(|name| name.as_str() == robot))
        };
        let own = self.actions().filter(|action| action.fleet.as_deref() == Some(lease.fleet().as_str()));
        own.filter(|action| action.is_pending() && !is_left_out(action)).take(most as usize).cloned().collect()
    }

    fn fleets_with_work(&self) -> Vec<FleetWork> {
        // Whether there are actions, and the version of the list.
        let mut found: BTreeMap<&str, (bool, i64)> = BTreeMap::new();
        for fleet in self.actions().filter(|action| action.is_pending()).filter_map(|action| action.fleet.as_ref()) {
            found.entry(fleet).or_default().0 = true;
        }
        for ((fleet, version), _) in self.allowed.iter() {
            found.entry(fleet).or_default().1 = *version;
        }
        let work = |(fleet, (has_actions, allowed_version))| FleetWork {
            fleet: String::from(fleet),
            has_actions,
            allowed_version,
        };
        found.into_iter().map(work).collect()
    }

    fn action(&self, action_id: i64) -> Option<Action> {
        self.actions.get(&action_id).cloned()
    }
}
