//! What one transaction writes: plain rows, in the order in which they must be written.

mod bytes;
mod parts;
mod record;
mod words;

pub use parts::{Owner, Owners};
pub(crate) use parts::{Parts, Rows};
pub use record::*;

use borsh::{BorshDeserialize, BorshSerialize};

use crate::Resolution;

/// Everything that a batch of messages has led to.
#[derive(Debug, Default, BorshSerialize, BorshDeserialize)]
pub struct Batch {
    /// New layouts; the whiskers that are on the robot now follow among `whiskers`.
    pub layouts: Vec<LayoutRow>,
    /// Changed robots.
    pub robots: Vec<RobotRow>,
    /// Changed whiskers.
    pub whiskers: Vec<WhiskerRow>,
    /// Contacts that are kept one by one.
    pub contacts: Vec<ContactRow>,
    /// Minutes and hours that are over.
    pub rollups: Vec<RollupRow>,
    /// The responses at contacts of whiskers that serve; they come after what they belong to.
    pub responses: Vec<ResponseRow>,
    /// Everything else, in order.
    pub records: Vec<Record>,
    /// What happened to robots whose states are not among `robots`.
    pub journal: Option<JournalRow>,
    /// The journal's rows up to this number are in the robots' states.
    pub journal_done: Option<i64>,
    /// It is in the table `redo` under this number, and no longer when this is written.
    #[borsh(skip)]
    pub redo_done: Option<i64>,
}

impl Batch {
    /// Whether there is nothing to write.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.layouts.is_empty()
            && self.robots.is_empty()
            && self.whiskers.is_empty()
            && self.contacts.is_empty()
            && self.rollups.is_empty()
            && self.responses.is_empty()
            && self.records.is_empty()
            && self.journal.is_none()
            && self.journal_done.is_none()
            && self.redo_done.is_none()
    }

    /// All its rows.
    pub(crate) fn rows(&self) -> Rows<'_> {
        Rows {
            layouts: &self.layouts,
            robots: &self.robots,
            whiskers: &self.whiskers,
            contacts: &self.contacts,
            rollups: &self.rollups,
            responses: &self.responses,
            records: &self.records,
        }
    }

    /// The whiskers that its rows are about, some of them often.
    pub(crate) fn whisker_ids(&self) -> impl Iterator<Item = i64> {
        let records = self.records.iter().filter_map(|record| match record {
            Record::Health(row) => Some(row.whisker_id),
            Record::Alarm(row) => Some(row.whisker_id),
            Record::AlarmCleared(row) => Some(row.whisker_id),
            Record::Trim(_)
            | Record::Decision(_)
            | Record::Ended(_)
            | Record::Setpoint(_)
            | Record::SetpointState(_)
            | Record::Error(_)
            | Record::Refinement(_)
            | Record::Activation(_)
            | Record::Approved { .. }
            | Record::Gone { .. }
            | Record::Answer { .. }
            | Record::Policy(_)
            | Record::AlarmsForgotten { .. }
            | Record::Quarantined(_) => None,
        });
        let whiskers = self.whiskers.iter().map(|row| row.whisker_id);
        let contacts = self.contacts.iter().map(|row| row.whisker_id);
        let rollups = self.rollups.iter().map(|row| row.whisker_id);
        whiskers.chain(contacts).chain(rollups).chain(records)
    }

    /// The same of one that is not used any more.
    pub fn append_all(&mut self, mut other: Self) {
        self.append(&mut other);
    }

    /// Takes the rows of another one, after its own. The journal is one for all.
    pub fn append(&mut self, other: &mut Self) {
        self.layouts.append(&mut other.layouts);
        self.robots.append(&mut other.robots);
        self.whiskers.append(&mut other.whiskers);
        self.contacts.append(&mut other.contacts);
        self.rollups.append(&mut other.rollups);
        self.responses.append(&mut other.responses);
        self.records.append(&mut other.records);
    }
}

/// What happened to robots, as the engine wrote it down for itself.
#[derive(Debug, BorshSerialize, BorshDeserialize)]
pub struct JournalRow {
    /// Number, rising with each transaction of the fleet.
    pub number: i64,
    /// The engine's bytes.
    pub entries: Vec<u8>,
}

/// A factsheet with another layout.
#[derive(Debug, BorshSerialize, BorshDeserialize)]
pub struct LayoutRow {
    /// Whose.
    pub robot_id: i64,
    /// The robot's model.
    pub model: String,
    /// Whiskers that are not on it any more, each with the bytes of its minute and hour.
    pub gone: Vec<(i64, Vec<u8>)>,
}

/// A robot as it is now.
#[derive(Debug, BorshSerialize, BorshDeserialize)]
pub struct RobotRow {
    /// Whose.
    pub robot_id: i64,
    /// Newest boot.
    pub boot_id: Option<String>,
    /// Connection in the contract's words.
    #[borsh(deserialize_with = "words::word")]
    pub connection: &'static str,
    /// Whether an operator holds all of it.
    pub held: bool,
    /// When.
    pub updated_us: i64,
    /// The journal's rows up to this number are in the state.
    pub journal_number: i64,
    /// The core's bytes.
    pub state: Vec<u8>,
}

/// A whisker as it is now.
#[derive(Debug, BorshSerialize, BorshDeserialize)]
pub struct WhiskerRow {
    /// Whose.
    pub whisker_id: i64,
    /// Index in the robot.
    pub position: i64,
    /// Estimated length.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
    /// Condition.
    #[borsh(deserialize_with = "words::word")]
    pub condition: &'static str,
    /// Fault, if any.
    #[borsh(deserialize_with = "words::word_if_any")]
    pub fault: Option<&'static str>,
    /// Measured pressure.
    pub pressure_mpa: Option<f64>,
    /// Pressure that the robot holds.
    pub setpoint_mpa: f64,
    /// Contacts that were used.
    pub contacts: i64,
    /// When it was last heard of.
    pub heard_us: Option<i64>,
    /// Whether an operator holds it.
    pub held: bool,
    /// Loss of its pressure, per second of itself.
    pub leak_per_s: Option<Interval>,
    /// Loss of its length, if it erodes.
    pub erosion_mm_per_contact: Option<Interval>,
    /// Contacts until it leaves the compensable range: estimate, lower and upper bound.
    pub contacts_left: [Option<f64>; 3],
    /// The core's bytes.
    pub state: Vec<u8>,
    /// The bytes of the minute and the hour that are not over yet.
    pub rollup: Vec<u8>,
}

/// A minute or an hour of a whisker that is over; see the tables for the columns.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct RollupRow {
    /// Whose.
    pub whisker_id: i64,
    /// Which table.
    pub resolution: Resolution,
    /// Its begin, by the supervisor's clock.
    pub start_us: i64,
    /// Contacts that were used, learned from, and not used.
    pub contacts: [i32; 3],
    /// Mean, standard deviation, least and greatest log sensitivity against the prediction.
    pub residual: [Option<f32>; 4],
    /// Mean strain by deflection.
    pub sensitivity_per_mm: Option<f32>,
    /// Mean contact ratio.
    pub ratio: Option<f32>,
    /// Length after the last contact.
    pub length_mm: Option<f32>,
    /// Its standard deviation.
    pub length_sd_mm: Option<f32>,
    /// Mean length.
    pub length_mean_mm: Option<f32>,
    /// Mean pressure.
    pub pressure_mpa: Option<f32>,
    /// Mean temperature.
    pub temperature_c: Option<f32>,
    /// Error of a compensation for it that was stated last.
    pub compensation_error: Option<f32>,
}

/// A contact; see the table for the columns.
#[derive(Debug, Clone, BorshSerialize, BorshDeserialize)]
pub struct ContactRow {
    /// Whose.
    pub whisker_id: i64,
    /// Number of the boot.
    pub boot: i64,
    /// Number of the message.
    pub seq: i64,
    /// Position in the message.
    pub position: i64,
    /// The robot's clock.
    pub t_us: i64,
    /// The supervisor's clock.
    pub received_us: i64,
    /// Contact ratio.
    pub ratio: f64,
    /// Deflection.
    pub deflection_mm: f64,
    /// Strain.
    pub strain: f64,
    /// Pressure.
    pub pressure_mpa: f64,
    /// Temperature.
    pub temperature_c: f64,
    /// What it was used for.
    #[borsh(deserialize_with = "words::word")]
    pub used: &'static str,
    /// Log sensitivity against the prediction.
    pub residual: Option<f64>,
    /// Length after it.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
}

/// The three responses at one contact.
#[derive(Debug, BorshSerialize, BorshDeserialize)]
pub struct ResponseRow {
    /// Compensation.
    pub compensation_id: i64,
    /// Robot's clock.
    pub t_us: i64,
    /// Contact ratio.
    pub ratio: f64,
    /// Deflection.
    pub deflection_mm: f64,
    /// Measured.
    pub after_strain: f64,
    /// Before the pressure changed.
    pub before_strain: f64,
    /// Where from.
    #[borsh(deserialize_with = "words::word")]
    pub before_origin: &'static str,
    /// The whole target's.
    pub target_strain: f64,
    /// Where from.
    #[borsh(deserialize_with = "words::word")]
    pub target_origin: &'static str,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, BorshSerialize, BorshDeserialize)]
pub struct Interval {
    /// Value.
    pub mean: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}
