//! The frequent rows of batches, the journal, and the positions in the log.

use std::collections::BTreeMap;

use vibrissa_store::batch::{JournalRow, LayoutRow, Owners, Rows as BatchRows};
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::model::{Rows, Violation};
use vibrissa_store::{JournalReading, Lease, LogPositions};

use super::programs::State;
use super::{FactRow, ModelStore, known, unique};

impl ModelStore {
    fn write_layout(&mut self, layout: &LayoutRow) {
        for whisker_id in self.whiskers_of(layout.robot_id) {
            self.whiskers.change(&whisker_id, super::robots::Whisker::leave);
        }
        for (whisker_id, rollup) in &layout.gone {
            self.whiskers.change(whisker_id, |row| row.rollup = Some(rollup.clone()));
        }
    }

    fn write_checkpoints(&mut self, rows: &BatchRows<'_>) {
        rows.layouts.iter().for_each(|layout| self.write_layout(layout));
        for new in rows.robots {
            let former = self.robots.get(&new.robot_id).and_then(|row| row.state.as_ref()).map(State::program);
            let state = self.state(new.robot_id, former, &new.state);
            self.robots.change(&new.robot_id, |row| {
                (row.state, row.journal_number, row.held) = (Some(state), new.journal_number, new.held);
                row.software.clone_from(&new.software);
            });
        }
        for new in rows.whiskers {
            let Some(row) = self.whiskers.get(&new.whisker_id) else { continue };
            let (robot_id, former) = (row.robot_id, row.state.as_ref().map(State::program));
            let state = self.state(robot_id, former, &new.state);
            self.whiskers.change(&new.whisker_id, |row| {
                (row.state, row.rollup) = (Some(state), Some(new.rollup.clone()));
                (row.position, row.held, row.segmenter) = (Some(new.position), new.held, new.segmenter);
            });
        }
    }
}

impl Rows for ModelStore {
    fn write(&mut self, lease: &Lease, rows: &BatchRows<'_>) -> Result<(), Violation> {
        self.need_room()?;
        rows.contacts.iter().for_each(|row| self.note(lease, FactRow::Contact(row.clone())));
        self.write_checkpoints(rows);
        rows.rollups.iter().for_each(|row| self.note(lease, FactRow::Rollup(row.clone())));
        for record in rows.records {
            self.write_record(lease, record)?;
            self.note(lease, FactRow::Record(record.clone()));
        }
        for row in rows.responses {
            known(self.compensations.has(&row.compensation_id), "compensations")?;
            self.note(lease, FactRow::Response(row.clone()));
        }
        rows.events.iter().for_each(|row| self.append_event(lease, row.clone()));
        Ok(())
    }

    fn write_journal(&mut self, lease: &Lease, row: &JournalRow, appends: bool) -> Result<(), Violation> {
        self.need_room()?;
        let key = (lease.fleet().to_string(), row.number);
        if self.journal.has(&key) && appends {
            self.journal.change(&key, |former| former.entries.extend(&row.entries));
            return Ok(());
        }
        if self.journal.has(&key) && fault::is(Fault::NoFence) {
            return Ok(());
        }
        unique(self.journal.has(&key), "journal")?;
        let row = JournalReading { number: row.number, log_partition: 0, entries: row.entries.clone() };
        self.journal.set(key, row);
        Ok(())
    }

    fn forget_journal(&mut self, lease: &Lease, last: i64) {
        let fleet = lease.fleet().as_str();
        for key in self.journal.keys_of(|(of, number), _| of == fleet && *number <= last) {
            self.journal.remove(&key);
        }
    }

    fn journal(&self, lease: &Lease, after: i64, most: i64) -> Vec<JournalReading> {
        let fleet = lease.fleet().to_string();
        let rows = self.journal.range((fleet.clone(), after.saturating_add(1))..=(fleet, i64::MAX));
        rows.take(most as usize).map(|(_, row)| row.clone()).filter(|row| row.number > after).collect()
    }

    fn set_log_positions(&mut self, lease: &Lease, positions: &LogPositions) {
        for (&partition, &next) in &positions.next {
            let place = (positions.topic.to_string(), partition);
            self.log_positions.set((lease.fleet().to_string(), place), next);
        }
    }

    fn log_positions(&self, lease: &Lease, topic: &str) -> BTreeMap<u32, i64> {
        let own = |fleet: &str, of: &str| fleet == lease.fleet().as_str() && of == topic;
        let all = self.log_positions.iter().filter(|((fleet, (of, _)), _)| own(fleet, of));
        all.map(|((_, (_, partition)), next)| (*partition, *next)).collect()
    }

    fn owners(&self, whiskers: &[i64], actions: &[i64], commands: &[String]) -> Owners {
        let of_whisker = |id: &i64| Some((*id, self.whiskers.get(id)?.robot_id));
        let of_action = |id: &i64| {
            let action = self.actions.get(id)?;
            let is_it = |fleet: &String, robot: &String| {
                (Some(fleet), Some(robot)) == (action.fleet.as_ref(), action.robot.as_ref())
            };
            let (robot_id, _) = self.robots.iter().find(|(_, row)| is_it(&row.fleet, &row.robot))?;
            Some((*id, *robot_id))
        };
        let of_command = |id: &String| Some((id.clone(), *self.setpoints.get(id)?));
        Owners {
            whiskers: whiskers.iter().filter_map(of_whisker).collect(),
            actions: actions.iter().filter_map(of_action).collect(),
            commands: commands.iter().filter_map(of_command).collect(),
        }
    }
}
