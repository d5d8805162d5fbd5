//! Contacts: what robots felt, held against what was recorded.

use std::collections::HashMap;

use vibrissa_protocol::Contacts;

/// A recorded contact with its whole name and content.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Robot.
    pub robot: String,
    /// Its boot.
    pub boot_id: String,
    /// Number of the message.
    pub seq: u64,
    /// Place in the message, from 0.
    pub position: usize,
    /// What was felt.
    pub content: Content,
}

/// What was felt in one contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    /// Array.
    pub array: String,
    /// Whisker in the array.
    pub whisker: i64,
    /// Robot's clock.
    pub t_us: i64,
    /// Contact ratio, deflection in mm, strain, pressure in MPa, temperature in degrees Celsius.
    pub values: [f64; 5],
}

impl Content {
    /// A number that another content does not have, for all that can happen: FNV-1a over every bit.
    fn fingerprint(&self) -> u64 {
        let numbers = [self.whisker as u64, self.t_us as u64].into_iter().chain(self.values.map(f64::to_bits));
        let bytes = self.array.bytes().chain(numbers.flat_map(u64::to_le_bytes));
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }
}

/// One felt contact.
#[derive(Debug, Clone, Copy)]
struct Felt {
    fingerprint: u64,
    recorded: u32,
}

/// What became of the contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Verdict {
    /// Felt by the robots.
    pub felt: u64,
    /// Rows.
    pub recorded: u64,
    /// Felt and not recorded.
    pub missing: u64,
    /// Recorded once too often, each time.
    pub duplicate: u64,
    /// Recorded otherwise than felt, or never felt.
    pub wrong: u64,
}

/// Every contact that was felt: by robot and boot, number of the message, and place in it.
#[derive(Debug, Default)]
pub struct Ledger {
    boots: HashMap<(String, String), Vec<Vec<Felt>>>,
    rows: u64,
    wrong: u64,
}

impl Ledger {
    /// A robot felt the contacts of a message.
    ///
    /// # Panics
    /// Its number is not the next one of its boot.
    pub fn felt(&mut self, robot: &str, message: &Contacts) {
        let boot = self.boots.entry((robot.to_owned(), message.boot_id.as_str().to_owned())).or_default();
        assert_eq!(boot.len() as u64, message.seq, "robot {robot} skips a number");
        let contents = message.contacts.iter().map(|one| Content {
            array: one.array.as_str().to_owned(),
            whisker: i64::from(one.whisker),
            t_us: one.t_us as i64,
            values: [one.ratio, one.deflection_mm, one.strain, one.pressure_mpa, one.temperature_c],
        });
        boot.push(contents.map(|content| Felt { fingerprint: content.fingerprint(), recorded: 0 }).collect());
    }

    /// A row of the database.
    pub fn recorded(&mut self, row: Recorded) {
        self.rows += 1;
        let message = self.boots.get_mut(&(row.robot, row.boot_id)).and_then(|boot| boot.get_mut(row.seq as usize));
        match message.and_then(|message| message.get_mut(row.position)) {
            Some(felt) => {
                felt.recorded += 1;
                self.wrong += u64::from(felt.fingerprint != row.content.fingerprint());
            }
            None => self.wrong += 1,
        }
    }

    /// What became of them; after every row was told.
    pub fn verdict(&self) -> Verdict {
        let contacts = || self.boots.values().flatten().flatten();
        Verdict {
            felt: contacts().count() as u64,
            recorded: self.rows,
            missing: contacts().filter(|felt| felt.recorded == 0).count() as u64,
            duplicate: contacts().map(|felt| u64::from(felt.recorded.saturating_sub(1))).sum(),
            wrong: self.wrong,
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{BootId, Contact, Name};

    use super::*;

    fn message(seq: u64) -> Contacts {
        let contact = |whisker| Contact {
            array: Name::new("left").unwrap(),
            whisker,
            t_us: 1_000_000 + seq,
            ratio: 0.85,
            deflection_mm: 2.4,
            strain: 0.009_671,
            pressure_mpa: 0.1002,
            temperature_c: 24.1,
        };
        Contacts { boot_id: BootId::new("b").unwrap(), seq, contacts: vec![contact(0), contact(1)] }
    }

    fn rows() -> Vec<Recorded> {
        let row = |seq: u64, position: usize| Recorded {
            robot: "r".to_owned(),
            boot_id: "b".to_owned(),
            seq,
            position,
            content: Content {
                array: "left".to_owned(),
                whisker: position as i64,
                t_us: 1_000_000 + seq as i64,
                values: [0.85, 2.4, 0.009_671, 0.1002, 24.1],
            },
        };
        (0..3).flat_map(|seq| [row(seq, 0), row(seq, 1)]).collect()
    }

    fn verdict(rows: Vec<Recorded>) -> (u64, u64, u64) {
        let mut ledger = Ledger::default();
        (0..3).for_each(|seq| ledger.felt("r", &message(seq)));
        let count = rows.len() as u64;
        rows.into_iter().for_each(|row| ledger.recorded(row));
        let verdict = ledger.verdict();
        assert_eq!((verdict.felt, verdict.recorded), (6, count));
        (verdict.missing, verdict.duplicate, verdict.wrong)
    }

    #[test]
    fn what_was_felt_and_recorded_once_is_well() {
        assert_eq!(verdict(rows()), (0, 0, 0));
    }

    #[test]
    fn a_row_too_few_is_missing_and_a_row_too_many_a_duplicate() {
        let mut planted = rows();
        planted.remove(2);
        planted.push(planted[0].clone());
        planted.push(planted[0].clone());
        assert_eq!(verdict(planted), (1, 2, 0));
    }

    #[test]
    fn a_row_that_says_anything_else_is_wrong() {
        let edits: [fn(&mut Recorded); 8] = [
            |row| row.content.t_us += 1,
            |row| row.content.whisker += 1,
            |row| row.content.array.push('x'),
            |row| row.content.values[0] += 1e-12,
            |row| row.content.values[1] += 1e-12,
            |row| row.content.values[2] += 1e-12,
            |row| row.content.values[3] += 1e-12,
            |row| row.content.values[4] += 1e-12,
        ];
        for edit in edits {
            let mut planted = rows();
            edit(&mut planted[1]);
            assert_eq!(verdict(planted), (0, 0, 1));
        }
    }

    #[test]
    fn a_row_that_nobody_felt_is_wrong() {
        let edits: [fn(&mut Recorded); 4] =
            [|row| row.seq = 3, |row| row.position = 2, |row| row.robot.push('x'), |row| row.boot_id.push('x')];
        for edit in edits {
            let mut planted = rows();
            edit(&mut planted[1]);
            assert_eq!(verdict(planted), (1, 0, 1));
        }
    }
}
