//! Robots with their whiskers and boots.

use std::collections::BTreeMap;

use vibrissa_core::robot::{Numbers, Robot as CoreRobot};
use vibrissa_protocol::Name;
use vibrissa_store::black_boxes::NewBlackBox;
use vibrissa_store::decommission::Registered;
use vibrissa_store::model::{Robots, Violation};
use vibrissa_store::refusals::RefusalRow;
use vibrissa_store::rollouts::RobotError;
use vibrissa_store::{Lease, NumberedWhisker, StoredRobot, StoredRobots};

use super::programs::State;
use super::{FactRow, ModelStore, known};

/// A robot with its checkpoint.
#[derive(Debug, Clone)]
pub(super) struct Robot {
    pub(super) fleet: String,
    pub(super) robot: String,
    pub(super) state: Option<State>,
    pub(super) software: String,
    pub(super) journal_number: i64,
    pub(super) held: bool,
    pub(super) is_decommissioned: bool,
}

/// A whisker with its checkpoint.
#[derive(Debug, Clone)]
pub(super) struct Whisker {
    pub(super) robot_id: i64,
    pub(super) array: String,
    pub(super) whisker: i64,
    /// Index in its robot; `None` if it is not on the robot any more.
    pub(super) position: Option<i64>,
    pub(super) state: Option<State>,
    pub(super) segmenter: Option<&'static str>,
    pub(super) rollup: Option<Vec<u8>>,
    pub(super) held: bool,
}

impl Whisker {
    /// Takes it off its robot.
    pub(super) fn leave(&mut self) {
        (self.position, self.state, self.held) = (None, None, false);
    }
}

/// The number after the last one. Its upper 32 bits are the robot's number.
fn next(last: Option<&i64>) -> u32 {
    last.map_or(0, |&last| (last as u32).wrapping_add(1))
}

impl ModelStore {
    /// Takes a robot out of service.
    pub(super) fn decommission(&mut self, lease: &Lease, robot_id: i64, now_us: i64) {
        self.clear_alarms(lease, robot_id, None, now_us);
        self.robots.change(&robot_id, |row| {
            (row.state, row.held, row.is_decommissioned) = (None, false, true);
        });
        for whisker_id in self.whiskers_of(robot_id) {
            self.whiskers.change(&whisker_id, |row| {
                row.leave();
                row.rollup = None;
            });
        }
    }

    pub(super) fn whiskers_of(&self, robot_id: i64) -> Vec<i64> {
        self.whiskers.keys_of(|_, row| row.robot_id == robot_id)
    }

    fn numbers(&self, robot_id: i64) -> Numbers {
        let trims = self.trims.iter().filter(|(_, robot)| **robot == robot_id).map(|(id, _)| id);
        let compensations = self.compensations.iter().filter(|(_, row)| row.robot_id == robot_id).map(|(id, _)| id);
        Numbers { next_trim: next(trims.max()), next_compensation: next(compensations.max()) }
    }

    fn stored(&self, robot_id: i64, robot: &Robot) -> StoredRobot {
        let all = || self.whiskers.iter().filter(|(_, row)| row.robot_id == robot_id);
        let mut placed: Vec<_> =
            all().filter_map(|(id, row)| Some((row.position?, *id, self.read(row.state.as_ref()?), row))).collect();
        placed.sort_by_key(|(position, ..)| *position);
        let boots = self.boots.range((robot_id, String::new())..(robot_id + 1, String::new()));
        StoredRobot {
            robot_id,
            robot: robot.robot.clone(),
            state: robot.state.as_ref().map(|state| self.read(state)),
            software: robot.software.clone(),
            whisker_ids: placed.iter().map(|(_, id, ..)| *id).collect(),
            whisker_states: placed.iter().map(|(_, _, state, _)| state.clone()).collect(),
            segmenters: placed.iter().map(|(.., row)| row.segmenter.map(str::to_owned)).collect(),
            rollups: placed.into_iter().map(|(.., row)| row.rollup.clone()).collect(),
            boots: boots.map(|((_, boot_id), boot)| (boot_id.clone(), *boot)).collect(),
            journal_number: robot.journal_number,
            held: robot.held || all().any(|(_, row)| row.held),
            numbers: self.numbers(robot_id),
        }
    }
}

impl Robots for ModelStore {
    fn robots(&self, lease: &Lease, after: i64, most: i64) -> StoredRobots {
        let above = self.robots.iter().filter(|(id, _)| **id > after);
        let own = above.filter(|(_, row)| row.fleet == lease.fleet().as_str() && !row.is_decommissioned);
        let robots: Vec<_> = own.take(most as usize).map(|(id, row)| self.stored(*id, row)).collect();
        StoredRobots { last: robots.last().map(|robot| robot.robot_id), robots }
    }

    fn register(&mut self, lease: &Lease, robot: &str, boot_id: &str) -> Option<Registered> {
        let fleet = lease.fleet().as_str();
        let former = self.robots.keys_of(|_, row| row.fleet == fleet && row.robot == robot).pop();
        let robot_id = match former {
            Some(robot_id) => {
                let is_decommissioned = self.robots.get(&robot_id).is_some_and(|row| row.is_decommissioned);
                if is_decommissioned && self.boots.has(&(robot_id, boot_id.to_owned())) {
                    return None;
                }
                self.robots.change(&robot_id, |row| row.is_decommissioned = false);
                robot_id
            }
            None => {
                let (robot_id, fleet, robot) = (self.next_number(), fleet.to_owned(), robot.to_owned());
                let (state, software) = (None, "[]".to_owned());
                let (journal_number, held, is_decommissioned) = (0, false, false);
                let new = Robot { fleet, robot, state, software, journal_number, held, is_decommissioned };
                self.robots.set(robot_id, new);
                robot_id
            }
        };
        Some(Registered { robot_id, numbers: self.numbers(robot_id) })
    }

    fn boot(&mut self, robot_id: i64, boot_id: &str) -> Result<i64, Violation> {
        known(self.robots.has(&robot_id), "robots")?;
        let key = (robot_id, boot_id.to_owned());
        if let Some(boot) = self.boots.get(&key) {
            return Ok(*boot);
        }
        self.need_room()?;
        let boot = self.next_number();
        self.boots.set(key, boot);
        Ok(boot)
    }

    fn whisker_ids(&mut self, robot_id: i64, robot: &CoreRobot) -> Result<Vec<NumberedWhisker>, Violation> {
        known(self.robots.has(&robot_id), "robots")?;
        self.need_room()?;
        let former = self.whiskers_of(robot_id);
        let mut numbered = Vec::new();
        for view in (0..robot.whisker_count()).filter_map(|index| robot.whisker(index)) {
            let (array, whisker) = (view.array.to_owned(), i64::from(view.sheet.number));
            let found = former
                .iter()
                .copied()
                .find(|id| self.whiskers.get(id).is_some_and(|row| row.array == array && row.whisker == whisker));
            let whisker_id = found.unwrap_or_else(|| self.next_number());
            if found.is_none() {
                let (position, state, segmenter, rollup, held) = (None, None, None, None, false);
                let new = Whisker { robot_id, array, whisker, position, state, segmenter, rollup, held };
                self.whiskers.set(whisker_id, new);
            }
            numbered.push((whisker_id, self.whiskers.get(&whisker_id).and_then(|row| row.rollup.clone())));
        }
        Ok(numbered)
    }

    fn has_robots(&self, fleet: &Name) -> bool {
        self.robots.iter().any(|(_, row)| row.fleet == fleet.as_str())
    }

    fn robots_with_alarm(&self, lease: &Lease, kind: &str) -> Vec<i64> {
        let of_kind = self.alarms.iter().filter(|(_, alarm)| alarm.kind == kind);
        let robots = of_kind.filter_map(|(_, alarm)| alarm.robot_id);
        robots.filter(|id| self.robots.get(id).is_some_and(|row| row.fleet == lease.fleet().as_str())).collect()
    }

    fn errors_since(&self, lease: &Lease, since_us: i64) -> Vec<RobotError> {
        let mut errors: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (_, row) in self.compensations.iter().filter(|(_, row)| row.decided_us >= since_us) {
            let robot = self.robots.get(&row.robot_id).filter(|robot| robot.fleet == lease.fleet().as_str());
            // A decision without a compensator is no better than doing nothing.
            let error = if row.has_compensator { row.error } else { Some(1.0) };
            if let (Some(robot), Some(error)) = (robot, error) {
                errors.entry(&robot.robot).or_default().push(error);
            }
        }
        let mean = |errors: Vec<f64>| errors.iter().sum::<f64>() / errors.len() as f64;
        errors.into_iter().map(|(robot, all)| RobotError { robot: robot.to_owned(), error: mean(all) }).collect()
    }

    fn add_refusals(&mut self, lease: &Lease, rows: &[RefusalRow]) -> Result<(), Violation> {
        self.need_room()?;
        for row in rows {
            known(self.robots.has(&row.robot_id), "robots")?;
        }
        rows.iter().for_each(|row| self.note(lease, FactRow::Refusal(row.clone())));
        Ok(())
    }

    fn write_black_box(&mut self, lease: &Lease, one: &NewBlackBox) -> Result<(), Violation> {
        self.need_room()?;
        known(self.robots.has(&one.robot_id), "robots")?;
        known(self.whiskers.has(&one.whisker_id), "whiskers")?;
        self.note(lease, FactRow::BlackBox(one.clone()));
        Ok(())
    }

    /// Nothing loads the boxes.
    fn end_black_boxes(&mut self, _: &Lease) {}
}

/// Names for those who read facts.
impl ModelStore {
    /// Robot, array and number of a whisker.
    #[must_use]
    pub fn name_of_whisker(&self, whisker_id: i64) -> Option<(&str, &str, i64)> {
        let whisker = self.whiskers.get(&whisker_id)?;
        Some((&self.robots.get(&whisker.robot_id)?.robot, &whisker.array, whisker.whisker))
    }

    /// Name of a robot.
    #[must_use]
    pub fn name_of_robot(&self, robot_id: i64) -> Option<&str> {
        self.robots.get(&robot_id).map(|robot| robot.robot.as_str())
    }

    /// The boots: number, robot, and identifier.
    pub fn boots(&self) -> impl Iterator<Item = (i64, &str, &str)> {
        self.boots.iter().filter_map(|((robot_id, boot_id), &boot)| {
            Some((boot, self.robots.get(robot_id)?.robot.as_str(), boot_id.as_str()))
        })
    }
}
