//! The edge: converts checked messages to the core's events, once. The code behind it sees neither MQTT nor JSON.
//!
//! The wall clock, which the core must not read, and identifiers that several crates derive are here, too.

pub mod actions;
pub mod black_box;
pub mod calibration_file;
pub mod clock;
pub mod contact_uses;
pub mod contract;
pub mod events;
pub mod fleets;
pub mod full_name;
pub mod guidance;
pub mod ids;
pub mod interval;
pub mod invariants;
pub mod labels;
pub mod partition;
pub mod presence;
pub mod recording;
pub mod touch_tests;
pub mod words;

use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_core::robot::LENGTH_TOLERANCE_MM;
use vibrissa_core::robot::event::{
    AirControl, ArrayKind, ArraySheet, Contact, ContactPlace, Distance, Factsheet, GaugeState, Link, MissedTouch,
    RegulatorState, Rejection, SetpointReport, Task, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, OutOfUnitRange, Strain};
use vibrissa_protocol as protocol;

/// Why a message that satisfies the contract still cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EdgeError {
    /// A value is outside the range of the core's unit.
    #[error(transparent)]
    Range(#[from] OutOfUnitRange),
    /// A factsheet names a whisker model that was not loaded.
    #[error("unknown whisker model {model:?}; known models are {known}: load its calibration file with --calibration")]
    UnknownModel {
        /// Model in the factsheet.
        model: String,
        /// Names of the loaded models.
        known: String,
    },
}

impl EdgeError {
    /// Label of the error for metrics.
    #[must_use]
    pub fn label(&self) -> &'static str {
        match self {
            Self::Range(_) => "out_of_range",
            Self::UnknownModel { .. } => "unknown_model",
        }
    }
}

/// State of a robot's connection.
#[must_use]
pub fn link(state: protocol::ConnectionState) -> Link {
    match state {
        protocol::ConnectionState::Online => Link::Online,
        protocol::ConnectionState::Offline => Link::Offline,
        protocol::ConnectionState::ConnectionBroken => Link::Broken,
    }
}

/// Arrays and whiskers of a robot. `known` are the names of the loaded models.
///
/// # Errors
/// A value is out of range, or a model is not loaded.
pub fn factsheet(sheet: &protocol::Factsheet, known: &[&str]) -> Result<Factsheet, EdgeError> {
    let arrays = sheet.arrays.iter().map(|array| array_sheet(array, known)).collect::<Result<_, _>>()?;
    let can = |kind| sheet.touch_tests.contains(&kind);
    let touch_tests = TouchTests { tip: can(protocol::TouchTestKind::Tip), wall: can(protocol::TouchTestKind::Wall) };
    let air_control = match sheet.air_control {
        Some(protocol::AirControl::FillAndVent) | None => AirControl::FillAndVent,
        Some(protocol::AirControl::VentOnly) => AirControl::VentOnly,
        Some(protocol::AirControl::None) => AirControl::None,
    };
    Ok(Factsheet { arrays, touch_tests, applies_gain: sheet.applies_gain, air_control })
}

/// A gain as a robot applies it: pairs of contact ratio and factor, or one factor on all readings.
#[must_use]
pub fn gain(gain: Option<&[f64; CONTACT_RATIOS.len()]>) -> (Vec<(f64, f64)>, Option<f64>) {
    let one = gain.and_then(vibrissa_core::robot::one_number);
    let by_ratio = gain.filter(|_| one.is_none()).map(|gain| CONTACT_RATIOS.into_iter().zip(*gain).collect());
    (by_ratio.unwrap_or_default(), one)
}

fn array_sheet(array: &protocol::ArrayFacts, known: &[&str]) -> Result<ArraySheet, EdgeError> {
    let whiskers = array.whiskers.iter().map(|whisker| whisker_sheet(whisker, known)).collect::<Result<_, _>>()?;
    let kind = match array.array_type {
        protocol::ArrayType::Type1 => ArrayKind::Type1,
        protocol::ArrayType::Type2 => ArrayKind::Type2,
    };
    let task = match array.task {
        Some(protocol::Task::Ratio) | None => Task::Ratio,
        Some(protocol::Task::Distance) => Task::Distance,
    };
    Ok(ArraySheet { name: array.array.to_string(), kind, task, whiskers })
}

fn whisker_sheet(whisker: &protocol::WhiskerFacts, known: &[&str]) -> Result<WhiskerSheet, EdgeError> {
    if !known.contains(&whisker.model.as_str()) {
        return Err(EdgeError::UnknownModel { model: whisker.model.clone(), known: known.join(", ") });
    }
    Ok(WhiskerSheet {
        number: whisker.whisker,
        x_mm: whisker.x_mm,
        y_mm: whisker.y_mm,
        model: whisker.model.clone(),
        length: Millimetre::new(whisker.length_mm)?,
        length_tolerance_mm: whisker.length_tolerance_mm.unwrap_or(LENGTH_TOLERANCE_MM),
        pressure: Megapascal::new(whisker.pressure_mpa)?,
        pressure_max: Megapascal::new(whisker.pressure_max_mpa)?,
        strain_max: whisker.strain_max,
        neighbours: whisker.neighbours.clone(),
    })
}

/// One contact of a whisker, with the strain that its gauge would read in its own plane.
///
/// # Errors
/// A value is out of range.
pub fn contact(contact: &protocol::Contact) -> Result<Contact<'_>, EdgeError> {
    Ok(Contact {
        array: contact.array.as_str(),
        whisker: contact.whisker,
        robot_time: Micros(contact.t_us),
        place: place(contact.place())?,
        deflection: Millimetre::new(contact.deflection_mm)?,
        strain: Strain::new(contact.strain / contact.share_in_gauge_plane())?,
        saturated: contact.saturated,
        pressure: Megapascal::new(contact.pressure_mpa)?,
        is_test: contact.test_id.is_some(),
        angle_is_stated: contact.angle_deg.is_some(),
        temperature_c: Some(contact.temperature_c),
    })
}

/// A touch that was expected and did not come.
///
/// # Errors
/// A value is out of range.
pub fn missed(missed: &protocol::MissedTouch) -> Result<MissedTouch<'_>, EdgeError> {
    Ok(MissedTouch {
        array: missed.array.as_str(),
        whisker: missed.whisker,
        robot_time: Micros(missed.t_us),
        at: distance(protocol::Distance { mm: missed.distance_mm, sd_mm: missed.distance_sd_mm })?,
    })
}

fn distance(distance: protocol::Distance) -> Result<Distance, EdgeError> {
    Ok(Distance { at: Millimetre::new(distance.mm)?, sd_mm: distance.sd_mm.unwrap_or(DISTANCE_SD_MM) })
}

/// Standard deviation of a contact's distance from the base if the robot states none, mm.
const DISTANCE_SD_MM: f64 = 1.0;

/// Place of a contact.
///
/// # Errors
/// A value is out of range.
pub fn place(place: protocol::ContactPlace) -> Result<ContactPlace, EdgeError> {
    Ok(match place {
        protocol::ContactPlace::Ratio { ratio, sd } => ContactPlace::Ratio { ratio: ContactRatio::new(ratio)?, sd },
        protocol::ContactPlace::Distance(at) => ContactPlace::Distance(distance(at)?),
        protocol::ContactPlace::Tip(at) => ContactPlace::Tip(at.map(distance).transpose()?),
        protocol::ContactPlace::Unknown => ContactPlace::Unknown,
    })
}

/// Condition of one chamber and its gauge.
///
/// # Errors
/// A value is out of range.
pub fn status(entry: &protocol::WhiskerStatus) -> Result<WhiskerStatus<'_>, EdgeError> {
    Ok(WhiskerStatus {
        array: entry.array.as_str(),
        whisker: entry.whisker,
        pressure: Megapascal::new(entry.pressure_mpa)?,
        setpoint: Megapascal::new(entry.setpoint_mpa)?,
        regulator: match entry.regulator {
            protocol::Regulator::Ok => RegulatorState::Ok,
            protocol::Regulator::Filling => RegulatorState::Filling,
            protocol::Regulator::Venting => RegulatorState::Venting,
            protocol::Regulator::SupplyLow => RegulatorState::SupplyLow,
            protocol::Regulator::Leak => RegulatorState::Leak,
            protocol::Regulator::Fault => RegulatorState::Fault,
        },
        gauge: match entry.gauge {
            protocol::Gauge::Ok => GaugeState::Ok,
            protocol::Gauge::Saturated => GaugeState::Saturated,
            protocol::Gauge::Open => GaugeState::Open,
            protocol::Gauge::Short => GaugeState::Short,
        },
    })
}

/// Progress or result of a setpoint. `commanded` is its pressure, which is used if the robot does not report the
/// measured one.
///
/// # Errors
/// A value is out of range.
pub fn setpoint_report(state: &protocol::SetpointState, commanded: Megapascal) -> Result<SetpointReport, EdgeError> {
    Ok(match state.state {
        protocol::SetpointOutcome::Received => SetpointReport::Received,
        protocol::SetpointOutcome::Applying => SetpointReport::Applying,
        protocol::SetpointOutcome::Applied => {
            SetpointReport::Applied(state.pressure_mpa.map_or(Ok(commanded), Megapascal::new)?)
        }
        protocol::SetpointOutcome::Rejected => SetpointReport::Rejected(rejection(state.error)),
        protocol::SetpointOutcome::Failed => SetpointReport::Failed,
        protocol::SetpointOutcome::Superseded => SetpointReport::Superseded,
    })
}

/// A rejection without a reason, or with a reason that belongs to a failure, counts as "not now".
fn rejection(error: Option<protocol::SetpointError>) -> Rejection {
    use protocol::SetpointError as Told;
    match error {
        Some(Told::Stale) => Rejection::Stale,
        Some(Told::Expired) => Rejection::Expired,
        Some(Told::OutOfRange) => Rejection::OutOfRange,
        Some(Told::UnknownWhisker) => Rejection::UnknownWhisker,
        Some(Told::WrongBoot) => Rejection::WrongBoot,
        Some(Told::InTask) => Rejection::InTask,
        Some(Told::NotReady | Told::SupplyLow | Told::Leak | Told::Fault) | None => Rejection::NotReady,
    }
}
