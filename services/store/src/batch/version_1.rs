//! Serialized batches of version 1, whose contacts have a contact ratio and no other place.

use borsh::BorshDeserialize;

use super::{ContactRow, JournalRow, LayoutRow, Record, ResponseRow, RobotRow, RollupRow, WhiskerRow, words};

#[derive(BorshDeserialize)]
#[cfg_attr(test, derive(borsh::BorshSerialize))]
pub(super) struct Batch {
    layouts: Vec<LayoutRow>,
    robots: Vec<RobotRow>,
    whiskers: Vec<WhiskerRow>,
    contacts: Vec<Contact>,
    rollups: Vec<RollupRow>,
    responses: Vec<ResponseRow>,
    records: Vec<Record>,
    journal: Option<JournalRow>,
    journal_done: Option<i64>,
}

#[derive(BorshDeserialize)]
#[cfg_attr(test, derive(borsh::BorshSerialize))]
struct Contact {
    whisker_id: i64,
    boot: i64,
    seq: i64,
    position: i64,
    t_us: i64,
    received_us: i64,
    ratio: f64,
    deflection_mm: f64,
    strain: f64,
    pressure_mpa: f64,
    temperature_c: f64,
    #[borsh(deserialize_with = "words::word")]
    used: &'static str,
    residual: Option<f64>,
    length_mm: f64,
    length_sd_mm: f64,
}

impl From<Batch> for super::Batch {
    fn from(one: Batch) -> Self {
        Self {
            layouts: one.layouts,
            robots: one.robots,
            whiskers: one.whiskers,
            contacts: one.contacts.into_iter().map(Into::into).collect(),
            rollups: one.rollups,
            responses: one.responses,
            records: one.records,
            events: Vec::new(),
            journal: one.journal,
            journal_done: one.journal_done,
            log_next: None,
            redo_done: None,
        }
    }
}

impl From<Contact> for ContactRow {
    fn from(one: Contact) -> Self {
        Self {
            whisker_id: one.whisker_id,
            boot: one.boot,
            seq: one.seq,
            position: one.position,
            t_us: one.t_us,
            received_us: one.received_us,
            place: "RATIO",
            ratio: Some(one.ratio),
            distance_mm: None,
            deflection_mm: one.deflection_mm,
            strain: one.strain,
            pressure_mpa: one.pressure_mpa,
            temperature_c: one.temperature_c,
            used: one.used,
            residual: one.residual,
            length_mm: one.length_mm,
            length_sd_mm: one.length_sd_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_of_version_1_have_a_ratio() {
        let contact = Contact {
            whisker_id: 1,
            boot: 2,
            seq: 3,
            position: 4,
            t_us: 5,
            received_us: 6,
            ratio: 0.7,
            deflection_mm: 2.0,
            strain: 0.01,
            pressure_mpa: 0.1,
            temperature_c: 24.0,
            used: "USED",
            residual: Some(0.1),
            length_mm: 70.0,
            length_sd_mm: 0.2,
        };
        let bytes = borsh::to_vec(&(1_u8, Vec::<LayoutRow>::new(), [0_u32; 2], vec![contact], [0_u32; 3], [0_u8; 2]));
        let batch = super::super::Batch::from_bytes(&bytes.unwrap()).unwrap();
        let [row] = &batch.contacts[..] else { panic!("one contact: {batch:?}") };
        assert_eq!((row.place, row.ratio, row.distance_mm), ("RATIO", Some(0.7), None));
        assert_eq!((row.position, row.used, row.residual, row.length_sd_mm), (4, "USED", Some(0.1), 0.2));
    }
}
