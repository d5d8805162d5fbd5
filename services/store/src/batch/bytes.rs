//! Serialization of a batch for the intent log, until its rows are written.

use borsh::io::{Error, ErrorKind, Result};
use vibrissa_core::policy::PolicyParams;

use super::{Batch, ErrorRow, EventRow, Interval, Record, version_1};

/// First byte of the serialized batch: the format version.
const VERSION: u8 = 7;
const _: () = assert!(PolicyParams::NUMBERS.len() == 3, "raise VERSION: the rows of policies have other numbers");

impl Batch {
    fn errors(&self) -> impl Iterator<Item = &ErrorRow> {
        self.records.iter().filter_map(|record| if let Record::Error(row) = record { Some(&**row) } else { None })
    }

    fn errors_mut(&mut self) -> impl Iterator<Item = &mut ErrorRow> {
        self.records
            .iter_mut()
            .filter_map(|record| if let Record::Error(row) = record { Some(&mut **row) } else { None })
    }

    /// Serializes the batch; `None` if a value in it cannot be serialized.
    #[must_use]
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        let air_errors: Vec<Option<Interval>> = self.errors().map(|row| row.air_error).collect();
        borsh::to_vec(&(VERSION, self, &self.events, self.log_next, air_errors)).ok()
    }

    /// Deserializes a batch.
    ///
    /// # Errors
    /// The bytes are not a batch of a version that this program reads.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        match bytes.split_first() {
            // Version 2 has no touch tests, version 3 no alarms about robots, version 4 no roll-outs, version 5 neither events
            // nor a position in a log, version 6 no errors of the air alone; they are the same otherwise.
            Some((2..=5, rest)) => borsh::from_slice(rest),
            Some((6, rest)) => {
                let (batch, events, log_next) = borsh::from_slice::<(Self, Vec<EventRow>, Option<i64>)>(rest)?;
                Ok(Self { events, log_next, ..batch })
            }
            Some((&VERSION, rest)) => {
                type Parts = (Batch, Vec<EventRow>, Option<i64>, Vec<Option<Interval>>);
                let (mut batch, events, log_next, air_errors) = borsh::from_slice::<Parts>(rest)?;
                for (row, air_error) in batch.errors_mut().zip(air_errors) {
                    row.air_error = air_error;
                }
                Ok(Self { events, log_next, ..batch })
            }
            Some((1, rest)) => borsh::from_slice::<version_1::Batch>(rest).map(Into::into),
            Some((other, _)) => {
                let problem =
                    format!("the batch has format version {other}, this program reads versions 1 to {VERSION}");
                Err(Error::new(ErrorKind::InvalidData, problem))
            }
            None => Err(Error::new(ErrorKind::InvalidData, "the batch has no bytes")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AlarmRow, ContactRow, HealthRow, Record};
    use super::*;

    #[test]
    fn a_batch_is_read_as_it_was_written_and_nothing_else_is() {
        let contact = ContactRow {
            whisker_id: 1,
            boot: 2,
            seq: 3,
            position: 0,
            t_us: 4,
            received_us: 5,
            place: "DISTANCE",
            ratio: Some(0.1 + 0.2),
            distance_mm: Some(21.0),
            deflection_mm: 2.0,
            strain: 0.01,
            pressure_mpa: 0.1,
            temperature_c: 23.5,
            used: "USED",
            residual: None,
            length_mm: 70.0,
            length_sd_mm: 0.1,
        };
        let (kind, was, becomes) = ("CONDITION", Some("HEALTHY"), None);
        let records = vec![
            Record::Health(HealthRow { whisker_id: 1, recorded_us: 5, kind, was, becomes }),
            Record::Alarm(AlarmRow { whisker_id: 1, raised_us: 5, kind: "LEAK" }),
        ];
        let event = EventRow { robot_id: 1, robot: "r".to_owned(), is_contacts: true, body: "{}".to_owned() };
        let batch = Batch {
            contacts: vec![contact],
            records,
            events: vec![event],
            journal_done: Some(7),
            log_next: Some(9),
            ..Batch::default()
        };
        let bytes = batch.to_bytes().unwrap();
        assert_eq!(format!("{:?}", Batch::from_bytes(&bytes).unwrap()), format!("{batch:?}"));
        for end in 0..bytes.len() {
            assert!(Batch::from_bytes(&bytes[..end]).is_err(), "{end}");
        }
        let newer = [&[VERSION + 1], &bytes[1..]].concat();
        assert!(Batch::from_bytes(&newer).unwrap_err().to_string().contains("version 8"));
    }
}
