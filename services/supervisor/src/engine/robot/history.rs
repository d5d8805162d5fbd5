//! History of one robot's whiskers on its way to the tables: contacts as the retention policy says, and minutes and
//! hours always.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use tracing::error;
use vibrissa_core::robot::effect::ContactUse;
use vibrissa_core::units::Micros;
use vibrissa_edge::full_name::FullName;

use super::retention::{ContactFilter, ContactRetention};
use super::rollup::{GRACE, Open, Rollup, Sample, Use};
use vibrissa_store::NumberedWhisker;
use vibrissa_store::batch::{Batch, ContactRow, RollupRow};

/// History of a robot's whiskers, by whisker index.
#[derive(Debug)]
pub(crate) struct History {
    filter: ContactFilter,
    open: Vec<Open>,
    /// Whiskers whose stored form must be written together with their closed rows.
    changed: BTreeSet<usize>,
    /// Open spans of whiskers that have left the robot, by row id: these whiskers may return before the next commit.
    gone: BTreeMap<i64, Open>,
    /// No span ends before this time.
    due: Micros,
    closed: Vec<Rollup>,
}

impl History {
    /// History of a new robot.
    pub(crate) fn new(retention: ContactRetention) -> Self {
        Self {
            filter: ContactFilter::new(retention),
            open: Vec::new(),
            changed: BTreeSet::new(),
            gone: BTreeMap::new(),
            due: Micros::default(),
            closed: Vec::new(),
        }
    }

    /// Continues from the stored forms.
    pub(crate) fn taken_up(retention: ContactRetention, stored: &[Option<Vec<u8>>], now: Micros) -> Self {
        let open = stored.iter().map(|bytes| Open::from_bytes(bytes.as_deref(), now)).collect();
        Self { open, ..Self::new(retention) }
    }

    /// Sets the retention policy of contacts.
    pub(crate) fn set_retention(&mut self, retention: ContactRetention) {
        self.filter = ContactFilter::new(retention);
    }

    /// Adds a contact that the core has recorded.
    pub(crate) fn add_contact(&mut self, whisker: usize, used: ContactUse, row: ContactRow, batch: &mut Batch) {
        let (received, whisker_id) = (Micros(row.received_us as u64), row.whisker_id);
        let sample = sample_of(used, &row);
        self.update(whisker, whisker_id, batch, |open, closed| open.add(received, &sample, closed));
        self.filter.add_contact(whisker, row, &mut batch.contacts);
    }

    /// Marks the last recorded contact as one of a compensator.
    pub(crate) fn keep_last(&mut self, batch: &mut Batch) {
        self.filter.keep_last(&mut batch.contacts);
    }

    /// Keeps the last contacts of a whisker, because a finding or decision was made about it.
    pub(crate) fn keep_recent(&mut self, whisker: usize, batch: &mut Batch) {
        self.filter.keep_recent(whisker, &mut batch.contacts);
    }

    /// Adds a measured compensation error, a ratio, of the target whisker.
    pub(crate) fn add_error(&mut self, (target, whisker_id): (usize, i64), at: Micros, error: f64, batch: &mut Batch) {
        self.update(target, whisker_id, batch, |open, closed| open.state(at, error, closed));
        // The target itself may have no contact at that time.
        self.changed.insert(target);
    }

    fn update(
        &mut self,
        whisker: usize,
        whisker_id: i64,
        batch: &mut Batch,
        update: impl FnOnce(&mut Open, &mut Vec<Rollup>),
    ) {
        if self.open.len() <= whisker {
            self.open.resize_with(whisker + 1, Open::default);
        }
        let open = &mut self.open[whisker];
        update(open, &mut self.closed);
        self.due = open.due().map_or(self.due, |due| self.due.min(due));
        if !self.closed.is_empty() {
            self.changed.insert(whisker);
            batch.rollups.extend(self.closed.drain(..).map(|rollup| row_of(whisker_id, &rollup)));
        }
    }

    /// Closes finished minutes and hours of at most `left` whiskers. Returns true if there were any: then their stored
    /// forms must be written in the same transaction.
    pub(crate) fn close(&mut self, now: Micros, whisker_ids: &[i64], left: &mut usize, batch: &mut Batch) -> bool {
        if now.0 < self.due.0.saturating_add(GRACE.0) {
            return false;
        }
        let mut any = false;
        let mut due = Micros(u64::MAX);
        for (whisker, (open, &whisker_id)) in self.open.iter_mut().zip(whisker_ids).enumerate() {
            if *left > 0 && open.close(now, &mut self.closed) {
                *left -= 1;
                any = true;
                self.changed.insert(whisker);
                batch.rollups.extend(self.closed.drain(..).map(|rollup| row_of(whisker_id, &rollup)));
            }
            due = open.due().map_or(due, |one| due.min(one));
        }
        self.due = due;
        any
    }

    /// Applies a new layout: `whiskers` with their stored forms, if there are any. Closes the spans of whiskers that
    /// leave, and returns their stored forms, which must be written.
    pub(crate) fn laid_out(
        &mut self,
        before: &[i64],
        whiskers: &[NumberedWhisker],
        now: Micros,
        batch: &mut Batch,
    ) -> Vec<(i64, Vec<u8>)> {
        let mut known: BTreeMap<i64, (usize, Open)> = before
            .iter()
            .zip(std::mem::take(&mut self.open))
            .enumerate()
            .map(|(index, (&whisker_id, open))| (whisker_id, (index, open)))
            .collect();
        let mut from = Vec::with_capacity(whiskers.len());
        for (whisker_id, stored) in whiskers {
            let here = known.remove(whisker_id);
            from.push(here.as_ref().map(|(index, _)| *index));
            let open = here.map(|(_, open)| open).or_else(|| self.gone.remove(whisker_id));
            self.open.push(open.unwrap_or_else(|| Open::from_bytes(stored.as_deref(), now)));
        }
        self.filter.laid_out(&from);
        self.changed = (0..self.open.len()).collect();
        self.due = Micros::default();
        let mut gone = Vec::new();
        for (whisker_id, (_, mut open)) in known {
            open.end(&mut self.closed);
            batch.rollups.extend(self.closed.drain(..).map(|rollup| row_of(whisker_id, &rollup)));
            gone.push((whisker_id, stored_form(&open, &format_args!("id {whisker_id}"), now)));
            self.gone.insert(whisker_id, open);
        }
        gone
    }

    /// Adds the whiskers whose stored form must be written to the list of changed whiskers, without duplicates.
    pub(crate) fn take_changed(&mut self, changed: &mut Vec<usize>) {
        changed.retain(|index| !self.changed.contains(index));
        changed.extend(std::mem::take(&mut self.changed));
    }

    /// Durable form of a whisker's open minute and hour.
    pub(crate) fn stored(&self, whisker: usize, name: FullName<'_>, now: Micros) -> Vec<u8> {
        let none = Open::default();
        stored_form(self.open.get(whisker).unwrap_or(&none), &name, now)
    }
}

fn stored_form(open: &Open, whisker: &dyn Display, now: Micros) -> Vec<u8> {
    open.to_bytes().unwrap_or_else(|| {
        error!("dropping the open minute and hour of whisker {whisker}, they contain NaN");
        Open::after(now).to_bytes().unwrap_or_default()
    })
}

fn sample_of(used: ContactUse, row: &ContactRow) -> Sample {
    Sample {
        used: match used {
            ContactUse::Used => Use::Used,
            ContactUse::Learning => Use::Learning,
            ContactUse::Unsettled
            | ContactUse::Late
            | ContactUse::TooWeak
            | ContactUse::NegativeStrain
            | ContactUse::Saturated
            | ContactUse::OnChamber
            | ContactUse::NoPlace
            | ContactUse::BeyondTip
            | ContactUse::GaugeFault
            | ContactUse::Implausible => Use::Unused,
        },
        residual: row.residual,
        // A contact without a ratio has no residual, and only those with one count in means of ratios.
        ratio: row.ratio.unwrap_or_default(),
        deflection_mm: row.deflection_mm,
        strain: row.strain,
        pressure_mpa: row.pressure_mpa,
        temperature_c: row.temperature_c,
        length_mm: row.length_mm,
        length_sd_mm: row.length_sd_mm,
    }
}

fn row_of(whisker_id: i64, rollup: &Rollup) -> RollupRow {
    let (response, contact) = (rollup.response, rollup.contact);
    let count = |count: u32| i32::try_from(count).unwrap_or(i32::MAX);
    RollupRow {
        whisker_id,
        resolution: rollup.resolution,
        start_us: rollup.start.0 as i64,
        contacts: [count(rollup.used), count(rollup.learning), count(rollup.unused)],
        residual: [
            response.map(|means| means.residual_mean as f32),
            response.and_then(|means| means.residual_sd).map(|sd| sd as f32),
            response.map(|means| means.residual_min as f32),
            response.map(|means| means.residual_max as f32),
        ],
        sensitivity_per_mm: response.map(|means| means.sensitivity_per_mm as f32),
        ratio: response.map(|means| means.ratio as f32),
        length_mm: contact.map(|means| means.length_mm as f32),
        length_sd_mm: contact.map(|means| means.length_sd_mm as f32),
        length_mean_mm: contact.map(|means| means.length_mean_mm as f32),
        pressure_mpa: contact.map(|means| means.pressure_mpa as f32),
        temperature_c: contact.map(|means| means.temperature_c as f32),
        compensation_error: rollup.error.map(|error| error as f32),
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_store::Resolution;

    use super::*;

    const START: u64 = 1_795_248_000_000_000;

    fn row(whisker_id: i64, seq: i64, received_us: u64) -> ContactRow {
        ContactRow {
            whisker_id,
            boot: 1,
            seq,
            position: 0,
            t_us: 0,
            received_us: received_us as i64,
            place: "RATIO",
            ratio: Some(0.85),
            distance_mm: None,
            deflection_mm: 2.0,
            strain: 0.01,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
            used: "USED",
            residual: Some(0.01),
            length_mm: 70.0,
            length_sd_mm: 0.2,
        }
    }

    /// Number of contacts in a whisker's minutes, and whether no two rows have the same time.
    fn counted(batch: &Batch, whisker_id: i64) -> (i32, bool) {
        let rows: Vec<_> = batch.rollups.iter().filter(|row| row.whisker_id == whisker_id).collect();
        let names: BTreeSet<_> = rows.iter().map(|row| (row.resolution, row.start_us)).collect();
        let minutes = rows.iter().filter(|row| row.resolution == Resolution::Minute);
        (minutes.map(|row| row.contacts.iter().sum::<i32>()).sum(), names.len() == rows.len())
    }

    #[test]
    fn silent_whiskers_are_closed_some_at_a_time() {
        let (mut history, mut batch) = (History::new(ContactRetention::All), Batch::default());
        let ids: Vec<i64> = (10..20).collect();
        for (whisker, &id) in ids.iter().enumerate() {
            history.add_contact(whisker, ContactUse::Used, row(id, 0, START), &mut batch);
        }
        let mut changed = Vec::new();
        history.take_changed(&mut changed);
        assert!(changed.is_empty(), "the core reports these whiskers as changed itself");
        let later = Micros(START + 62_000_000);
        assert!(!history.close(Micros(START + 61_000_000), &ids, &mut 100, &mut batch));
        for closed in [4, 8, 10] {
            assert!(history.close(later, &ids, &mut 4, &mut batch));
            assert_eq!(batch.rollups.len(), closed);
        }
        assert!(!history.close(later, &ids, &mut 4, &mut batch));
        history.take_changed(&mut changed);
        assert_eq!(changed, (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn whiskers_that_leave_and_come_back_have_no_minute_twice() {
        let (mut history, mut batch) = (History::new(ContactRetention::None), Batch::default());
        let mut ids = vec![1, 2];
        let mut sent = 0;
        let mut stored: BTreeMap<i64, Vec<u8>> = BTreeMap::new();
        for turn in 0..40_u64 {
            let now = Micros(START + turn * 7_000_000);
            for (whisker, &id) in ids.iter().enumerate() {
                history.add_contact(whisker, ContactUse::Used, row(id, sent, now.0), &mut batch);
                sent += i64::from(id == 1);
            }
            let next: Vec<i64> = if turn % 2 == 0 { vec![2] } else { vec![2, 1] };
            let whiskers: Vec<NumberedWhisker> = next.iter().map(|id| (*id, stored.get(id).cloned())).collect();
            stored.extend(history.laid_out(&ids, &whiskers, now, &mut batch));
            ids = next;
            // From time to time, restart from the stored forms.
            if turn % 5 == 0 {
                let all: Vec<_> = (0..ids.len())
                    .map(|whisker| Some(history.stored(whisker, FullName::robot("f", "r"), now)))
                    .collect();
                history = History::taken_up(ContactRetention::None, &all, now);
            }
        }
        history.laid_out(&ids, &[], Micros(START), &mut batch);
        assert_eq!(counted(&batch, 1), (sent as i32, true));
        assert_eq!(counted(&batch, 2), (40, true));
    }

    #[test]
    fn a_stated_error_is_stored_though_its_whisker_felt_nothing() {
        let (mut history, mut batch) = (History::new(ContactRetention::All), Batch::default());
        history.add_error((3, 13), Micros(START), 0.25, &mut batch);
        let mut changed = vec![3];
        history.take_changed(&mut changed);
        assert_eq!(changed, [3]);
        assert!(history.close(Micros(START + 62_000_000), &[10, 11, 12, 13], &mut 9, &mut batch));
        assert_eq!((batch.rollups[0].whisker_id, batch.rollups[0].compensation_error), (13, Some(0.25)));
        assert_eq!((batch.rollups[0].length_mm, batch.rollups[0].contacts), (None, [0; 3]));
    }
}
