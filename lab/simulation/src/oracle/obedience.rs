//! Compares the setpoints that robots applied with the contract and with the database.

use std::collections::BTreeMap;

use vibrissa_protocol::Setpoint;
use vibrissa_simulator::HeardSetpoint;

/// Largest difference in MPa of two equal pressures, and of two equal gains: reading JSON may change a number's last
/// bit.
const SAME: f64 = 1e-12;
/// State of a setpoint whose commit a failover has lost. No database has it.
pub const LOST: &str = "LOST";

/// A setpoint in the database.
#[derive(Debug, Clone, PartialEq)]
pub struct Decided {
    /// Command id, which is unique.
    pub command_id: String,
    /// Names of robot and array, and number of the whisker.
    pub whisker: (String, String, i64),
    /// The boot of the robot that may apply it.
    pub robot_boot_id: String,
    /// Id of the compensation, if any.
    pub compensation_id: Option<i64>,
    /// Epoch and version, which order the setpoints.
    pub order: (i64, i64),
    /// Pressure in MPa.
    pub pressure_mpa: f64,
    /// Pairs of contact ratio and gain.
    pub gain: Vec<(f64, f64)>,
    /// Reason of the setpoint.
    pub reason: String,
    /// State of the setpoint.
    pub state: String,
}

impl Decided {
    /// Whether it ended without being applied, so that another one may follow for the same purpose.
    fn came_to_nothing(&self) -> bool {
        matches!(self.state.as_str(), "REJECTED" | "FAILED" | "SUPERSEDED" | "EXPIRED" | "ABANDONED" | LOST)
    }

    /// Whether both set the same pressure and gain for the same purpose. A refinement may change the gain alone.
    fn has_the_purpose_of(&self, other: &Self) -> bool {
        self.whisker == other.whisker
            // A robot that restarts has forgotten its setpoints.
            && self.robot_boot_id == other.robot_boot_id
            && self.compensation_id == other.compensation_id
            && self.reason == other.reason
            && self.pressure_mpa == other.pressure_mpa
            && self.gain == other.gain
    }

    /// Whether a robot received it with the values in the database.
    fn is_as_heard(&self, robot: &str, setpoint: &Setpoint) -> bool {
        let (of_robot, array, whisker) = &self.whisker;
        let is_same = |one: f64, other: f64| (one - other).abs() < SAME;
        let is_same_gain = || {
            // A robot that multiplies its readings gets one gain for all contact ratios.
            if let Some(gain) = setpoint.reading_gain {
                return self.gain.iter().all(|one| is_same(one.1, gain));
            }
            let mut points = self.gain.iter().zip(&setpoint.gain);
            self.gain.len() == setpoint.gain.len()
                && points.all(|(one, other)| is_same(one.0, other.0) && is_same(one.1, other.1))
        };
        self.order == (setpoint.epoch as i64, setpoint.version as i64)
            && is_same(self.pressure_mpa, setpoint.pressure_mpa)
            && is_same_gain()
            && (of_robot.as_str(), array.as_str(), *whisker)
                == (robot, setpoint.array.as_str(), i64::from(setpoint.whisker))
    }
}

/// Result of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Verdict {
    /// Number of setpoints in the database.
    pub decided: u64,
    /// Number of different setpoints that were applied.
    pub applied: u64,
    /// Number of surplus applications.
    pub twice: u64,
    /// Number of applications that were late, outdated, or for another boot.
    pub stale: u64,
    /// Number of applied setpoints that are not in the database with the same values.
    pub uncommitted: u64,
    /// Number of setpoints decided while another one for the same purpose was pending or applied.
    pub two_for_one: u64,
}

/// A whisker of a robot in one boot. The contract compares a setpoint with all earlier ones of the same whisker and
/// boot.
#[derive(Debug, Default)]
struct Seen {
    highest: Option<(u64, u64)>,
    /// Command id of the latest arrival, and the highest order before it.
    newest: Option<(String, Option<(u64, u64)>)>,
}

/// Setpoints that robots received and applied.
#[derive(Debug, Default)]
pub struct Obedience {
    seen: BTreeMap<(String, String, String, u16), Seen>,
    applied: BTreeMap<String, (HeardSetpoint, String)>,
    twice: u64,
    stale: u64,
}

impl Obedience {
    fn seen(&mut self, robot: &str, heard: &HeardSetpoint) -> &mut Seen {
        let setpoint = &heard.setpoint;
        let boot_id = heard.boot_id.as_str().to_owned();
        self.seen.entry((robot.to_owned(), boot_id, setpoint.array.as_str().to_owned(), setpoint.whisker)).or_default()
    }

    /// Adds a setpoint that arrived at a robot.
    pub fn heard(&mut self, robot: &str, heard: &HeardSetpoint) {
        let setpoint = &heard.setpoint;
        let is_for_this_boot = setpoint.robot_boot_id == heard.boot_id;
        let seen = self.seen(robot, heard);
        seen.newest = Some((setpoint.command_id.clone(), seen.highest));
        if is_for_this_boot {
            seen.highest = seen.highest.max(Some((setpoint.epoch, setpoint.version)));
        }
    }

    /// Adds a setpoint that a robot applied, directly after its arrival.
    pub fn applied(&mut self, robot: &str, heard: &HeardSetpoint) {
        let setpoint = &heard.setpoint;
        let is_highest = self.seen(robot, heard).newest.as_ref().is_some_and(|(command_id, before)| {
            *command_id == setpoint.command_id && Some((setpoint.epoch, setpoint.version)) > *before
        });
        let is_valid = setpoint.expires_us > heard.at_us && setpoint.robot_boot_id == heard.boot_id;
        self.stale += u64::from(!(is_highest && is_valid));
        let before = self.applied.insert(setpoint.command_id.clone(), (heard.clone(), robot.to_owned()));
        self.twice += u64::from(before.is_some());
    }

    /// The applied setpoints that are not in the database with the same values.
    pub fn uncommitted<'a>(&'a self, decided: &'a [Decided]) -> impl Iterator<Item = String> + 'a {
        self.applied.iter().filter_map(|(name, (heard, robot))| {
            let row = decided.iter().find(|row| row.command_id == *name);
            let is_committed = row.is_some_and(|row| row.is_as_heard(robot, &heard.setpoint));
            (!is_committed).then(|| format!("{robot} applied {:?}, the database has {row:?}", heard.setpoint))
        })
    }

    /// Result of the comparison with the setpoints in the database at the end.
    pub fn verdict(&self, decided: &[Decided]) -> Verdict {
        let by_name: BTreeMap<&str, &Decided> = decided.iter().map(|row| (row.command_id.as_str(), row)).collect();
        let is_committed = |name: &String, (heard, robot): &(HeardSetpoint, String)| {
            by_name.get(name.as_str()).is_some_and(|row| row.is_as_heard(robot, &heard.setpoint))
        };
        Verdict {
            decided: decided.len() as u64,
            applied: self.applied.len() as u64,
            twice: self.twice,
            stale: self.stale,
            uncommitted: self.applied.iter().filter(|(name, applied)| !is_committed(name, applied)).count() as u64,
            two_for_one: two_for_one(decided),
        }
    }
}

/// Number of setpoints that follow another one for the same purpose that was applied or is still pending.
///
/// A compensation may set the same pressure and gain again when the last attempt expired, was refused or failed. A
/// release has no compensation: it follows another setpoint of its whisker, or a release that was not applied.
///
/// A failover takes the ends of earlier setpoints back, so a lost setpoint follows none of what is left.
pub fn two_for_one(decided: &[Decided]) -> u64 {
    let mut by_whisker: BTreeMap<&(String, String, i64), Vec<&Decided>> = BTreeMap::new();
    for row in decided {
        by_whisker.entry(&row.whisker).or_default().push(row);
    }
    let mut count = 0;
    for rows in by_whisker.values_mut() {
        rows.sort_by_key(|row| row.order);
        for (at, row) in rows.iter().enumerate().filter(|(_, row)| row.state != LOST) {
            let before = match row.compensation_id {
                Some(_) => {
                    let mut kept = rows[..at].iter().rev().filter(|earlier| earlier.state != LOST);
                    kept.find(|earlier| earlier.has_the_purpose_of(row))
                }
                None => rows[..at].last().filter(|earlier| earlier.has_the_purpose_of(row)),
            };
            if let Some(earlier) = before.filter(|earlier| !earlier.came_to_nothing()) {
                eprintln!("two setpoints for one decision: {earlier:?} and {row:?}; all of the whisker: {rows:?}");
                count += 1;
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{BootId, Name, Setpoint, SetpointReason, Timestamp};

    use super::*;

    fn heard(epoch: u64, version: u64, at_us: u64) -> HeardSetpoint {
        let boot_id = BootId::new("b").unwrap();
        let setpoint = Setpoint {
            boot_id: BootId::new("s").unwrap(),
            seq: 0,
            command_id: format!("{epoch}.{version}"),
            epoch,
            version,
            robot_boot_id: boot_id.clone(),
            array: Name::new("left").unwrap(),
            whisker: 1,
            pressure_mpa: 0.05,
            slew_mpa_per_s: 0.02,
            issued: Timestamp(0),
            expires_us: 1_000,
            reason: SetpointReason::SelfCompensation,
            gain: vec![],
            reading_gain: None,
        };
        HeardSetpoint { at_us, boot_id, setpoint }
    }

    fn decided(version: i64, state: &str) -> Decided {
        Decided {
            command_id: format!("1.{version}"),
            whisker: ("r".to_owned(), "left".to_owned(), 1),
            robot_boot_id: "b".to_owned(),
            compensation_id: Some(7),
            order: (1, version),
            pressure_mpa: 0.05,
            gain: Vec::new(),
            reason: "SELF_COMPENSATION".to_owned(),
            state: state.to_owned(),
        }
    }

    /// Each event is a received setpoint and whether it was applied. The database contains 1.1 and 1.2.
    fn verdict(events: &[(HeardSetpoint, bool)]) -> Verdict {
        let mut obedience = Obedience::default();
        for (setpoint, applied) in events {
            obedience.heard("r", setpoint);
            if *applied {
                obedience.applied("r", setpoint);
            }
        }
        let second = Decided { compensation_id: Some(8), ..decided(2, "APPLIED") };
        obedience.verdict(&[decided(1, "APPLIED"), second])
    }

    #[test]
    fn what_is_applied_in_order_and_refused_otherwise_is_well() {
        let verdict = verdict(&[
            (heard(1, 1, 0), true),
            (heard(1, 1, 10), false),
            (heard(1, 2, 20), true),
            (heard(1, 1, 30), false),
        ]);
        assert_eq!(verdict, Verdict { decided: 2, applied: 2, ..Verdict::default() });
    }

    #[test]
    fn the_same_applied_again_is_twice_and_stale() {
        let verdict = verdict(&[(heard(1, 1, 0), true), (heard(1, 1, 10), true)]);
        assert_eq!((verdict.applied, verdict.twice, verdict.stale), (1, 1, 1));
    }

    #[test]
    fn an_older_one_is_stale_even_if_the_newer_one_was_only_heard() {
        let verdict = verdict(&[(heard(1, 2, 0), false), (heard(1, 1, 10), true)]);
        assert_eq!((verdict.twice, verdict.stale), (0, 1));
    }

    #[test]
    fn an_expired_one_is_stale_and_so_is_one_for_another_boot_and_one_never_heard() {
        assert_eq!(verdict(&[(heard(1, 1, 1_000), true)]).stale, 1);
        let mut other = heard(1, 1, 0);
        other.setpoint.robot_boot_id = BootId::new("b0").unwrap();
        assert_eq!(verdict(&[(other, true)]).stale, 1);
        let mut obedience = Obedience::default();
        obedience.applied("r", &heard(1, 1, 0));
        assert_eq!(obedience.verdict(&[decided(1, "APPLIED")]).stale, 1);
    }

    #[test]
    fn what_is_not_in_the_database_or_not_so_is_uncommitted() {
        assert_eq!(verdict(&[(heard(1, 3, 0), true)]).uncommitted, 1);
        let mut other = heard(1, 1, 0);
        other.setpoint.pressure_mpa += 1e-9;
        assert_eq!(verdict(&[(other, true)]).uncommitted, 1);
        let mut other = heard(1, 1, 0);
        other.setpoint.gain = vec![(0.5, 0.9)];
        assert_eq!(verdict(&[(other, true)]).uncommitted, 1);
    }

    #[test]
    fn regress_a_refinement_of_the_gain_alone_is_a_decision_of_its_own_and_its_repetition_is_not() {
        let refined = |version, factor: f64| Decided {
            reason: "REFINEMENT".to_owned(),
            gain: vec![(0.45, factor), (1.0, 1.0)],
            ..decided(version, "APPLIED")
        };
        assert_eq!(two_for_one(&[refined(1, 0.86), refined(2, 0.87), refined(3, 0.88)]), 0);
        assert_eq!(two_for_one(&[refined(1, 0.86), refined(2, 0.87), refined(3, 0.87)]), 1);
        // The third one repeats an outdated decision.
        assert_eq!(two_for_one(&[refined(1, 0.86), refined(2, 0.87), refined(3, 0.86)]), 1);
    }

    #[test]
    fn a_decision_has_one_setpoint_unless_that_came_to_nothing() {
        for state in ["PENDING", "RECEIVED", "APPLYING", "APPLIED"] {
            assert_eq!(two_for_one(&[decided(1, state), decided(2, "APPLIED")]), 1, "{state}");
        }
        for state in ["REJECTED", "FAILED", "SUPERSEDED", "EXPIRED", "ABANDONED"] {
            assert_eq!(two_for_one(&[decided(1, state), decided(2, "APPLIED")]), 0, "{state}");
        }
        let restarted = Decided { robot_boot_id: "c".to_owned(), ..decided(2, "APPLIED") };
        assert_eq!(two_for_one(&[decided(1, "APPLIED"), restarted]), 0);
        let elsewhere = Decided { whisker: ("r".to_owned(), "left".to_owned(), 2), ..decided(2, "APPLIED") };
        assert_eq!(two_for_one(&[decided(1, "APPLIED"), elsewhere]), 0);
    }

    #[test]
    fn regress_a_lost_setpoint_followed_an_end_that_is_lost_too() {
        assert_eq!(two_for_one(&[decided(1, "EXPIRED"), decided(2, "APPLIED")]), 0);
        // After the failover the robot's status says that it applied the first one.
        assert_eq!(two_for_one(&[decided(1, "APPLIED"), decided(2, LOST)]), 0);
        assert_eq!(two_for_one(&[decided(1, "APPLIED"), decided(2, LOST), decided(3, "PENDING")]), 1);
        assert_eq!(two_for_one(&[decided(1, LOST), decided(2, "APPLIED")]), 0);
    }

    #[test]
    fn a_release_may_follow_a_compensation_and_not_a_release() {
        let release = |version, state| Decided {
            compensation_id: None,
            pressure_mpa: 0.1,
            reason: "RELEASE".to_owned(),
            ..decided(version, state)
        };
        let between = Decided { compensation_id: Some(8), ..decided(3, "APPLIED") };
        let rows = [decided(1, "APPLIED"), release(2, "APPLIED"), between, release(4, "APPLIED")];
        assert_eq!(two_for_one(&rows), 0);
        assert_eq!(two_for_one(&[release(1, "APPLIED"), release(2, "PENDING")]), 1);
        assert_eq!(two_for_one(&[release(1, "EXPIRED"), release(2, "APPLIED")]), 0);
    }
}
