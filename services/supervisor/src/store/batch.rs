//! What one transaction writes: plain rows, in the order in which they must be written.

use super::calibrations::ActivationRow;
use crate::engine::Resolution;

/// Everything that a batch of messages has led to.
#[derive(Debug, Default)]
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
    }

    /// Takes the rows of another one, after its own. The journal is one for all.
    pub(crate) fn append(&mut self, other: &mut Self) {
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
#[derive(Debug)]
pub struct JournalRow {
    /// Number, rising with each transaction of the fleet.
    pub number: i64,
    /// The engine's bytes.
    pub entries: Vec<u8>,
}

/// A factsheet with another layout.
#[derive(Debug)]
pub struct LayoutRow {
    /// Whose.
    pub robot_id: i64,
    /// The robot's model.
    pub model: String,
    /// Whiskers that are not on it any more, each with the bytes of its minute and hour.
    pub gone: Vec<(i64, Vec<u8>)>,
}

/// A robot as it is now.
#[derive(Debug)]
pub struct RobotRow {
    /// Whose.
    pub robot_id: i64,
    /// Newest boot.
    pub boot_id: Option<String>,
    /// Connection in the contract's words.
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
#[derive(Debug)]
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
    pub condition: &'static str,
    /// Fault, if any.
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
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone)]
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
    pub used: &'static str,
    /// Log sensitivity against the prediction.
    pub residual: Option<f64>,
    /// Length after it.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
}

/// One of the rarer rows.
#[derive(Debug)]
pub enum Record {
    /// A change of condition or fault.
    Health {
        /// Whose.
        whisker_id: i64,
        /// When.
        recorded_us: i64,
        /// `CONDITION` or `FAULT`.
        kind: &'static str,
        /// Before.
        was: Option<&'static str>,
        /// Now.
        becomes: Option<&'static str>,
    },
    /// A trim.
    Trim {
        /// Number.
        trim_id: i64,
        /// Robot.
        robot_id: i64,
        /// Whisker.
        whisker_id: i64,
        /// When.
        detected_us: i64,
        /// Length before.
        length_before_mm: f64,
        /// Length after.
        length_after_mm: f64,
        /// Its standard deviation.
        length_after_sd_mm: f64,
        /// Contacts since the likeliest moment of the cut.
        contacts_to_detect: i64,
    },
    /// A decision.
    Decision(Box<DecisionRow>),
    /// The end of a compensation.
    Ended {
        /// Which.
        compensation_id: i64,
        /// When.
        ended_us: i64,
        /// Why.
        end_reason: &'static str,
    },
    /// A setpoint.
    Setpoint(Box<SetpointRow>),
    /// What became of one.
    SetpointState {
        /// Which.
        command_id: String,
        /// When.
        recorded_us: i64,
        /// What.
        state: &'static str,
        /// Why.
        error: Option<&'static str>,
        /// Where the pressure is.
        pressure_mpa: Option<f64>,
    },
    /// The compensation error.
    Error(Box<ErrorRow>),
    /// A look at a setpoint.
    Refinement(Box<RefinementRow>),
    /// A calibration that is in force from now on.
    Activation(Box<ActivationRow>),
    /// The approval of a proposed compensation.
    Approved {
        /// Which.
        compensation_id: i64,
    },
    /// An alarm.
    Alarm {
        /// About whom.
        whisker_id: i64,
        /// When.
        raised_us: i64,
        /// What.
        kind: &'static str,
    },
    /// An alarm's cause is over.
    AlarmCleared {
        /// About whom.
        whisker_id: i64,
        /// When.
        cleared_us: i64,
        /// What.
        kind: &'static str,
    },
    /// A whisker is not on the robot any more: all its alarms are cleared, and nobody holds it.
    Gone {
        /// The robot.
        robot_id: i64,
        /// Its array.
        array: String,
        /// Its number.
        whisker: i64,
        /// When.
        cleared_us: i64,
    },
    /// What became of an action that an operator asked for.
    Answer {
        /// Which.
        action_id: i64,
        /// `DONE`, `REFUSED` or `EXPIRED`.
        state: &'static str,
        /// Why it was refused: a word, a colon, and a text for people.
        problem: Option<String>,
        /// When.
        done_us: i64,
    },
    /// A policy that an operator has set.
    Policy(Box<PolicyRow>),
    /// A robot starts anew, because its stored state cannot be used: none of its alarms stands.
    AlarmsForgotten {
        /// The robot.
        robot_id: i64,
        /// When.
        cleared_us: i64,
    },
}

/// A policy; see the table for the columns.
#[derive(Debug)]
pub struct PolicyRow {
    /// Fleet.
    pub fleet: String,
    /// Number, from 1.
    pub version: i64,
    /// Mode.
    pub mode: &'static str,
    /// What setpoints are solved for.
    pub objective: &'static str,
    /// When a longer whisker may stand in for a shorter one.
    pub longer_for_shorter: &'static str,
    /// Highest mean predicted error, as a ratio.
    pub predicted_error_max: f64,
    /// Cost of a neighbour's own role, in units of mean error.
    pub own_role_cost: f64,
    /// Gain that a change must have, in units of mean error.
    pub change_margin: f64,
    /// When.
    pub changed_us: i64,
    /// Who.
    pub changed_by: String,
    /// Why.
    pub reason: Option<String>,
    /// The action that asked for it.
    pub action_id: i64,
}

/// A decision with its candidates.
#[derive(Debug)]
pub struct DecisionRow {
    /// Number.
    pub compensation_id: i64,
    /// Robot.
    pub robot_id: i64,
    /// The broken whisker.
    pub target_whisker_id: i64,
    /// Its whole length.
    pub target_length_mm: f64,
    /// Its nominal pressure.
    pub target_pressure_mpa: f64,
    /// When.
    pub decided_us: i64,
    /// `PROPOSED` if it waits for approval, else `AUTOMATIC`.
    pub approval: &'static str,
    /// Everyone who was asked.
    pub candidates: Vec<CandidateRow>,
}

/// A candidate of a decision.
#[derive(Debug)]
pub struct CandidateRow {
    /// Who.
    pub whisker_id: i64,
    /// Case of the paper.
    pub case: &'static str,
    /// Length.
    pub length_mm: f64,
    /// Its standard deviation.
    pub length_sd_mm: f64,
    /// Pressure before.
    pub pressure_before_mpa: f64,
    /// Pressure to hold.
    pub pressure_mpa: Option<f64>,
    /// Predicted mean error.
    pub predicted_error: Option<f64>,
    /// Its 95 % interval.
    pub predicted_error_interval: Option<(f64, f64)>,
    /// The same by contact ratio, JSON.
    pub predicted_error_by_ratio: Option<String>,
    /// Whether it would give up its own role.
    pub gives_up_own_role: bool,
    /// Whether it was chosen.
    pub chosen: bool,
    /// Why not.
    pub refused: Option<&'static str>,
}

/// A setpoint; see the table for the columns.
#[derive(Debug)]
pub struct SetpointRow {
    /// Name.
    pub command_id: String,
    /// Robot.
    pub robot_id: i64,
    /// Whisker.
    pub whisker_id: i64,
    /// Compensation that it belongs to.
    pub compensation_id: Option<i64>,
    /// Epoch.
    pub epoch: i64,
    /// Version.
    pub version: i64,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Pressure.
    pub pressure_mpa: f64,
    /// Slew.
    pub slew_mpa_per_s: f64,
    /// Supervisor's clock.
    pub issued_us: i64,
    /// Robot's clock.
    pub expires_us: i64,
    /// Why.
    pub reason: &'static str,
    /// Residual gain, JSON.
    pub gain: Option<String>,
}

/// The three responses at one contact.
#[derive(Debug)]
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
    pub before_origin: &'static str,
    /// The whole target's.
    pub target_strain: f64,
    /// Where from.
    pub target_origin: &'static str,
}

/// The compensation error with its bins.
#[derive(Debug, Clone)]
pub struct ErrorRow {
    /// Compensation.
    pub compensation_id: i64,
    /// When.
    pub recorded_us: i64,
    /// Contacts.
    pub contacts: i64,
    /// Pressure at which it is measured.
    pub pressure_mpa: f64,
    /// Mean and 95 % interval, as ratios.
    pub error: Interval,
    /// The same with the gain in force.
    pub with_gain: Option<Interval>,
    /// Bins.
    pub bins: Vec<ErrorBinRow>,
}

/// A look at a setpoint; see the table for the columns.
#[derive(Debug)]
pub struct RefinementRow {
    /// Compensation.
    pub compensation_id: i64,
    /// When.
    pub recorded_us: i64,
    /// Contacts at the pressure.
    pub contacts: i64,
    /// What came of it.
    pub outcome: &'static str,
    /// The pressure that was held.
    pub pressure_from_mpa: f64,
    /// The best pressure.
    pub pressure_best_mpa: Option<f64>,
    /// Error as felt.
    pub error: Interval,
    /// Error to be expected at the best pressure.
    pub error_best: Option<Interval>,
    /// What the published gain leaves.
    pub error_with_gain: f64,
    /// What a gain from these contacts would leave.
    pub error_with_own_gain: f64,
    /// Whether a new gain went out.
    pub gain_published: bool,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// Value.
    pub mean: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// One contact-ratio bin of an error.
#[derive(Debug, Clone)]
pub struct ErrorBinRow {
    /// Centre.
    pub ratio: f64,
    /// Contacts.
    pub contacts: i64,
    /// Strain per mm after.
    pub after_per_mm: f64,
    /// Strain per mm before.
    pub before_per_mm: f64,
    /// Where from.
    pub before_origin: &'static str,
    /// Strain per mm of the whole target.
    pub target_per_mm: f64,
    /// Where from.
    pub target_origin: &'static str,
    /// Eq. 35.
    pub error: Interval,
}
