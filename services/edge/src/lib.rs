//! The edge: checked messages become the core's events, once. Nothing behind it sees MQTT or JSON.
//!
//! Here are also the wall clock, which the core must not read, and the identifiers that several parts derive alike.

pub mod actions;
pub mod clock;
pub mod ids;
pub mod words;

use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, Factsheet, GaugeState, Link, RegulatorState, Rejection, SetpointReport,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, OutOfUnitRange, Strain};
use vibrissa_protocol as protocol;

/// Why a message that keeps the contract still cannot be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EdgeError {
    /// A value is outside what the core takes.
    #[error(transparent)]
    Range(#[from] OutOfUnitRange),
    /// A factsheet names a whisker model that was not loaded.
    #[error(
        "whisker model {model:?} is not known here; known are {known}: load its calibration file with --calibration"
    )]
    UnknownModel {
        /// What the factsheet says.
        model: String,
        /// What is loaded.
        known: String,
    },
}

impl EdgeError {
    /// The metric's label.
    #[must_use]
    pub fn label(&self) -> &'static str {
        match self {
            Self::Range(_) => "out_of_range",
            Self::UnknownModel { .. } => "unknown_model",
        }
    }
}

/// The connection's state.
#[must_use]
pub fn link(state: protocol::ConnectionState) -> Link {
    match state {
        protocol::ConnectionState::Online => Link::Online,
        protocol::ConnectionState::Offline => Link::Offline,
        protocol::ConnectionState::ConnectionBroken => Link::Broken,
    }
}

/// What is on a robot. `known` are the models that are loaded.
///
/// # Errors
/// A value is out of range, or a model is not loaded.
pub fn factsheet(sheet: &protocol::Factsheet, known: &[&str]) -> Result<Factsheet, EdgeError> {
    let arrays = sheet.arrays.iter().map(|array| array_sheet(array, known)).collect::<Result<_, _>>()?;
    Ok(Factsheet { arrays })
}

fn array_sheet(array: &protocol::ArrayFacts, known: &[&str]) -> Result<ArraySheet, EdgeError> {
    let whiskers = array.whiskers.iter().map(|whisker| whisker_sheet(whisker, known)).collect::<Result<_, _>>()?;
    let kind = match array.array_type {
        protocol::ArrayType::Type1 => ArrayKind::Type1,
        protocol::ArrayType::Type2 => ArrayKind::Type2,
    };
    Ok(ArraySheet { name: array.array.to_string(), kind, whiskers })
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
        pressure: Megapascal::new(whisker.pressure_mpa)?,
        pressure_max: Megapascal::new(whisker.pressure_max_mpa)?,
        neighbours: whisker.neighbours.clone(),
    })
}

/// One contact.
///
/// # Errors
/// A value is out of range.
pub fn contact(contact: &protocol::Contact) -> Result<Contact<'_>, EdgeError> {
    Ok(Contact {
        array: contact.array.as_str(),
        whisker: contact.whisker,
        robot_time: Micros(contact.t_us),
        ratio: ContactRatio::new(contact.ratio)?,
        deflection: Millimetre::new(contact.deflection_mm)?,
        strain: Strain::new(contact.strain)?,
        pressure: Megapascal::new(contact.pressure_mpa)?,
    })
}

/// One chamber's and gauge's condition.
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

/// What became of a setpoint. `commanded` is its pressure, for a robot that does not say what it reached.
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

/// A refusal without a reason, or for a reason that belongs to a failure, is taken for "not now".
fn rejection(error: Option<protocol::SetpointError>) -> Rejection {
    use protocol::SetpointError as Told;
    match error {
        Some(Told::Stale) => Rejection::Stale,
        Some(Told::Expired) => Rejection::Expired,
        Some(Told::OutOfRange) => Rejection::OutOfRange,
        Some(Told::UnknownWhisker) => Rejection::UnknownWhisker,
        Some(Told::WrongBoot) => Rejection::WrongBoot,
        Some(Told::NotReady | Told::SupplyLow | Told::Leak | Told::Fault) | None => Rejection::NotReady,
    }
}
