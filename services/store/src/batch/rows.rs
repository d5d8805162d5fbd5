//! The frequent rows of a batch: checkpoints, contacts, aggregates, responses and the journal.

use crate::Resolution;
use crate::row::{Interval, row};

/// A factsheet with a new layout.
#[derive(Debug)]
pub struct LayoutRow {
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Model of the robot.
    pub model: String,
    /// Whiskers that are not on the robot any more, each with the serialized aggregates of its current minute and
    /// hour.
    pub gone: Vec<(i64, Vec<u8>)>,
}

row! {
    /// One row of the journal: events of robots since their checkpoints, in the engine's own format.
    pub struct JournalRow {
        /// Number of the transaction; it rises within a fleet.
        pub number: i64,
        /// The serialized events.
        pub entries: Vec<u8>,
    }

    /// Checkpoint of a robot.
    pub struct RobotRow {
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Newest boot; `None` before the first.
        pub boot_id: Option<String>,
        /// Connection state: `ONLINE`, `OFFLINE` or `CONNECTION_BROKEN`.
        pub connection: &'static str,
        /// Whether an operator holds the whole robot.
        pub held: bool,
        /// Time of the checkpoint, µs since 1970 UTC by the supervisor's clock.
        pub updated_us: i64,
        /// Journal rows up to this number are contained in `state`.
        pub journal_number: i64,
        /// Programs of the robot by its factsheet: a JSON list, see [`crate::programs`].
        pub software: String,
        /// Serialized state of the core's robot, without its whiskers.
        pub state: Vec<u8>,
    }

    /// Checkpoint of a whisker.
    pub struct WhiskerRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Index of the whisker in its robot.
        pub position: i64,
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
        /// Condition, such as `HEALTHY`.
        pub condition: &'static str,
        /// Fault, such as `LEAK`; `None` without a fault.
        pub fault: Option<&'static str>,
        /// State of its segmenter, such as `NOISY`; `None` if the robot states none.
        pub segmenter: Option<&'static str>,
        /// Pressure as last measured, MPa.
        pub pressure_mpa: Option<f64>,
        /// Pressure that the robot holds or moves to, MPa.
        pub setpoint_mpa: f64,
        /// Number of contacts that were used for the estimate.
        pub contacts: i64,
        /// Time of the last message about it, µs since 1970 UTC by the supervisor's clock.
        pub heard_us: Option<i64>,
        /// Whether an operator holds it.
        pub held: bool,
        /// Relative loss of gauge pressure per second; `None` until it can be estimated.
        pub leak_per_s: Option<Interval> = ["leak_per_s", "leak_low_per_s", "leak_high_per_s"],
        /// Loss of length per contact, mm; `None` unless the whisker erodes.
        pub erosion_mm_per_contact: Option<Interval> =
            ["erosion_mm_per_contact", "erosion_low_mm_per_contact", "erosion_high_mm_per_contact"],
        /// Contacts until the whisker is too short for self-compensation: estimate, lower and upper bound.
        pub contacts_left: [Option<f64>; 3] = ["contacts_left", "contacts_left_low", "contacts_left_high"],
        /// Serialized state of the core's whisker.
        pub state: Vec<u8>,
        /// Serialized aggregates of the minute and the hour that have not ended.
        pub rollup: Vec<u8>,
    }

    /// Aggregates of a whisker's minute or hour that has ended; docs/schema.md documents the columns.
    #[derive(PartialEq)]
    pub struct RollupRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Minute or hour, which selects the table.
        pub resolution: Resolution = [],
        /// Start of the span, µs since 1970 UTC by the supervisor's clock.
        pub start_us: i64,
        /// Numbers of contacts that were used, learned from, and not used.
        pub contacts: [i32; 3] = ["contacts_used", "contacts_learning", "contacts_unused"],
        /// Mean, standard deviation, least and greatest ln(measured / predicted sensitivity).
        pub residual: [Option<f32>; 4] = ["residual_mean", "residual_sd", "residual_min", "residual_max"],
        /// Mean sensitivity, strain per mm of deflection.
        pub sensitivity_per_mm: Option<f32>,
        /// Mean contact ratio, 0 at the base, 1 at the tip.
        pub ratio: Option<f32>,
        /// Estimated length after the last contact, mm.
        pub length_mm: Option<f32>,
        /// Standard deviation of that length, mm.
        pub length_sd_mm: Option<f32>,
        /// Mean estimated length, mm.
        pub length_mean_mm: Option<f32>,
        /// Mean pressure, MPa.
        pub pressure_mpa: Option<f32>,
        /// Mean temperature, °C.
        pub temperature_c: Option<f32>,
        /// Last error (Eq. 35) of a compensation for this whisker that was measured in the span, as a ratio.
        pub compensation_error: Option<f32>,
    }

    /// A contact; docs/schema.md documents the columns.
    pub struct ContactRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Number of the boot in the database.
        pub boot: i64,
        /// Sequence number of the message in its boot.
        pub seq: i64,
        /// Position of the contact in the message.
        pub position: i64,
        /// Time of the contact, µs since 1970 UTC by the robot's clock.
        pub t_us: i64,
        /// Time of receipt, µs since 1970 UTC by the supervisor's clock.
        pub received_us: i64,
        /// Kind of place that the robot stated: `RATIO`, `DISTANCE`, `TIP` or `UNKNOWN`.
        pub place: &'static str,
        /// Contact ratio, 0 at the base, 1 at the tip: the robot's, or its distance / the estimated length. `None` if the
        /// place is not known.
        pub ratio: Option<f64>,
        /// Measured distance from the base, mm.
        pub distance_mm: Option<f64>,
        /// Deflection at the contact, mm.
        pub deflection_mm: f64,
        /// Measured strain, m/m.
        pub strain: f64,
        /// Pressure of the chamber, MPa.
        pub pressure_mpa: f64,
        /// Temperature of the whisker, °C.
        pub temperature_c: f64,
        /// Use of the contact: `USED`, `LEARNING`, or why it was not used.
        pub used: &'static str,
        /// ln(measured / predicted sensitivity); `None` if the contact was not used.
        pub residual: Option<f64>,
        /// Estimated length after the contact, mm.
        pub length_mm: f64,
        /// Standard deviation of that length, mm.
        pub length_sd_mm: f64,
    }

    /// The three responses of Eq. 35 at one contact of a compensator.
    pub struct ResponseRow {
        /// Number of the compensation.
        pub compensation_id: i64,
        /// Time of the contact, µs since 1970 UTC by the robot's clock.
        pub t_us: i64,
        /// Contact ratio, 0 at the base, 1 at the tip.
        pub ratio: f64,
        /// Deflection at the contact, mm.
        pub deflection_mm: f64,
        /// Measured strain of the compensator at its new pressure, m/m.
        pub after_strain: f64,
        /// Strain of the compensator before its pressure changed, m/m.
        pub before_strain: f64,
        /// Origin of `before_strain`: `MEASURED` or `MODEL`.
        pub before_origin: &'static str,
        /// Strain of the target before the trim, m/m.
        pub target_strain: f64,
        /// Origin of `target_strain`: `MEASURED` or `MODEL`.
        pub target_origin: &'static str,
    }
}
