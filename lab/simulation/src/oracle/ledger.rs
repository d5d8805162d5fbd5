//! Compares the contacts that robots made with those that were recorded.

use std::collections::BTreeMap;

use vibrissa_protocol::Contacts;

/// A recorded contact with its identity and content.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Name of the robot.
    pub robot: String,
    /// Boot id of the robot.
    pub boot_id: String,
    /// Sequence number of the message.
    pub seq: u64,
    /// Position in the message, from 0.
    pub position: usize,
    /// Whisker, time and measured values.
    pub content: Content,
}

/// Measured values of one contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in the array.
    pub whisker: i64,
    /// Time by the robot's clock, microseconds.
    pub t_us: i64,
    /// Contact ratio, deflection in mm, strain, pressure in MPa, temperature in degrees Celsius.
    pub values: [f64; 5],
}

impl Content {
    /// FNV-1a hash over every bit; different contents practically never have the same hash.
    fn fingerprint(&self) -> u64 {
        let numbers = [self.whisker as u64, self.t_us as u64].into_iter().chain(self.values.map(f64::to_bits));
        let bytes = self.array.bytes().chain(numbers.flat_map(u64::to_le_bytes));
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }
}

/// Result of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Verdict {
    /// Number of contacts that robots made.
    pub felt: u64,
    /// Number of rows.
    pub recorded: u64,
    /// Number of contacts made but not recorded.
    pub missing: u64,
    /// Number of surplus rows.
    pub duplicate: u64,
    /// Number of rows with other values than measured, or for a contact that was never made.
    pub wrong: u64,
}

/// The contacts of one boot. A long run has millions of contacts: each takes nine bytes, and each message four.
#[derive(Debug, Default, Clone)]
struct Boot {
    /// Index of each message's first contact in the two lists below, by sequence number.
    starts: Vec<u32>,
    /// Hash of each contact.
    fingerprints: Vec<u64>,
    /// Whether each contact was recorded.
    recorded: Vec<bool>,
    /// Whether the commit of each contact was lost, so that it need not be recorded.
    lost: Vec<bool>,
}

impl Boot {
    fn is_missing(&self, at: usize) -> bool {
        !self.recorded[at] && !self.lost[at]
    }

    /// Indices of a message's contacts in the lists.
    fn contacts_of(&self, seq: u64) -> std::ops::Range<usize> {
        let start = |seq: u64| usize::try_from(seq).ok().and_then(|seq| self.starts.get(seq)).map(|&at| at as usize);
        let end = self.fingerprints.len();
        start(seq).unwrap_or(end)..start(seq + 1).unwrap_or(end)
    }

    /// Index of a contact in the lists.
    fn find(&self, seq: u64, position: usize) -> Option<usize> {
        let seq = usize::try_from(seq).ok()?;
        let start = *self.starts.get(seq)? as usize;
        let end = self.starts.get(seq + 1).map_or(self.fingerprints.len(), |&next| next as usize);
        Some(start.checked_add(position)?).filter(|&at| at < end)
    }
}

/// Every contact that robots made, by robot and boot, sequence number and position in the message.
#[derive(Debug, Default, Clone)]
pub struct Ledger {
    boots: BTreeMap<(String, String), Boot>,
    rows: u64,
    duplicate: u64,
    wrong: u64,
}

impl Ledger {
    /// Adds the contacts of a message that a robot has made.
    ///
    /// # Panics
    /// The sequence number is not the next one of the boot, or the boot has made more than 2^32 contacts.
    pub fn felt(&mut self, robot: &str, message: &Contacts) {
        let boot = self.boots.entry((robot.to_owned(), message.boot_id.as_str().to_owned())).or_default();
        assert_eq!(boot.starts.len() as u64, message.seq, "robot {robot} skips a sequence number");
        boot.starts.push(u32::try_from(boot.fingerprints.len()).expect("fewer contacts than 2^32"));
        let contents = message.contacts.iter().map(|one| Content {
            array: one.array.as_str().to_owned(),
            whisker: i64::from(one.whisker),
            t_us: one.t_us as i64,
            values: [one.ratio.unwrap_or(f64::NAN), one.deflection_mm, one.strain, one.pressure_mpa, one.temperature_c],
        });
        boot.fingerprints.extend(contents.map(|content| content.fingerprint()));
        boot.recorded.resize(boot.fingerprints.len(), false);
        boot.lost.resize(boot.fingerprints.len(), false);
    }

    /// Adds a row of the database.
    pub fn recorded(&mut self, row: Recorded) {
        self.rows += 1;
        let boot = self.boots.get_mut(&(row.robot, row.boot_id));
        let found = boot.and_then(|boot| boot.find(row.seq, row.position).map(|at| (boot, at)));
        let Some((boot, at)) = found else {
            self.wrong += 1;
            return;
        };
        self.duplicate += u64::from(std::mem::replace(&mut boot.recorded[at], true));
        self.wrong += u64::from(boot.fingerprints[at] != row.content.fingerprint());
    }

    /// The first message from `next` on to below `until` of which a contact is not recorded, among those that the boot has made.
    pub fn first_missing(&self, robot: &str, boot_id: &str, (next, until): (u64, u64)) -> Option<u64> {
        let boot = self.boots.get(&(robot.to_owned(), boot_id.to_owned()))?;
        let made = boot.starts.len() as u64;
        (next..until.min(made)).find(|&seq| boot.contacts_of(seq).any(|at| boot.is_missing(at)))
    }

    /// Robot and boot of all contacts, in order.
    pub fn boots(&self) -> impl Iterator<Item = (&str, &str)> {
        let mut boots: Vec<_> = self.boots.keys().map(|(robot, boot)| (robot.as_str(), boot.as_str())).collect();
        boots.sort_unstable();
        boots.into_iter()
    }

    /// Goes back to what `earlier` has as recorded: later commits are lost, which is nobody's fault.
    pub fn lose_since(&mut self, earlier: &Self) {
        (self.rows, self.duplicate, self.wrong) = (earlier.rows, earlier.duplicate, earlier.wrong);
        for (name, boot) in &mut self.boots {
            let before = earlier.boots.get(name);
            for at in 0..boot.recorded.len() {
                let was = before.and_then(|boot| boot.recorded.get(at)).copied().unwrap_or_default();
                boot.lost[at] |= boot.recorded[at] && !was;
                boot.recorded[at] = was;
            }
        }
    }

    /// Numbers of surplus rows and of wrong rows so far.
    pub fn surplus(&self) -> (u64, u64) {
        (self.duplicate, self.wrong)
    }

    /// Number of contacts made so far.
    pub fn count(&self) -> u64 {
        self.boots.values().map(|boot| boot.fingerprints.len() as u64).sum()
    }

    /// Result of the comparison, after all rows were added.
    pub fn verdict(&self) -> Verdict {
        let missing = |boot: &Boot| (0..boot.recorded.len()).filter(|&at| boot.is_missing(at)).count() as u64;
        Verdict {
            felt: self.count(),
            recorded: self.rows,
            missing: self.boots.values().map(missing).sum(),
            duplicate: self.duplicate,
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
            ratio: Some(0.85),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm: 2.4,
            strain: 0.009_671,
            saturated: false,
            pressure_mpa: 0.1002,
            temperature_c: 24.1,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        };
        Contacts { boot_id: BootId::new("b").unwrap(), seq, contacts: vec![contact(0), contact(1)], missed: Vec::new() }
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
