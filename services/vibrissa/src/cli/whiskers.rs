//! `vibrissa whiskers`, `vibrissa compensations` and `vibrissa setpoint`: commands that use the API.

use std::io::Write;

use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use vibrissa_core::robot::effect::Condition;
use vibrissa_core::units::Megapascal;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;

use super::api::{ApiArgs, number, percent, text};
use super::table::Table;
use super::words::word_of;

/// Arguments of `vibrissa whiskers`.
#[derive(Debug, Args)]
pub struct WhiskersArgs {
    /// Only this fleet.
    #[arg(long)]
    fleet: Option<Name>,
    /// Only this robot.
    #[arg(long)]
    robot: Option<Name>,
    /// Only this condition.
    #[arg(long, value_parser = word_of::<Condition>())]
    condition: Option<Condition>,
    #[command(flatten)]
    api: ApiArgs,
}

/// Prints the list of whiskers.
///
/// # Errors
/// The supervisor does not answer, or refuses the request.
pub fn whiskers(args: &WhiskersArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let filters = [
        ("fleet", args.fleet.as_ref().map(ToString::to_string)),
        ("robot", args.robot.as_ref().map(ToString::to_string)),
        ("condition", args.condition.map(|condition| condition.word().to_owned())),
    ];
    let rows = args.api.open()?.rows("/v1/whiskers", &filters)?;
    if args.api.json {
        return lines(&rows, out);
    }
    let heads = [
        "WHISKER",
        "CONDITION",
        "FAULT",
        "LENGTH_MM",
        "LOW",
        "HIGH",
        "WHOLE_MM",
        "PRESSURE_MPA",
        "SETPOINT_MPA",
        "CONTACTS",
        "SERVED_BY",
        "SERVES_IN",
    ];
    let mut table = Table::new(heads);
    for row in &rows {
        table.row([
            place(row, "whisker"),
            text(row, "condition"),
            text(row, "fault"),
            number(row, "length_mm", 2),
            number(row, "length_low_mm", 2),
            number(row, "length_high_mm", 2),
            number(row, "whole_length_mm", 1),
            number(row, "pressure_mpa", 4),
            number(row, "setpoint_mpa", 4),
            text(row, "contacts"),
            text(row, "compensated_by"),
            text(row, "serves_in"),
        ]);
    }
    Ok(write!(out, "{table}")?)
}

/// Arguments of `vibrissa compensations`.
#[derive(Debug, Args)]
pub struct CompensationsArgs {
    /// Only this fleet.
    #[arg(long)]
    fleet: Option<Name>,
    /// Only this robot.
    #[arg(long)]
    robot: Option<Name>,
    /// Only active compensations.
    #[arg(long)]
    active: bool,
    #[command(flatten)]
    api: ApiArgs,
}

/// Prints the list of compensations.
///
/// # Errors
/// The supervisor does not answer, or refuses the request.
pub fn compensations(args: &CompensationsArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let filters = [
        ("fleet", args.fleet.as_ref().map(ToString::to_string)),
        ("robot", args.robot.as_ref().map(ToString::to_string)),
        ("active", args.active.then(|| "true".to_owned())),
    ];
    let rows = args.api.open()?.rows("/v1/compensations", &filters)?;
    if args.api.json {
        return lines(&rows, out);
    }
    let heads = [
        "COMPENSATION",
        "TARGET",
        "COMPENSATOR",
        "CASE",
        "APPROVAL",
        "FROM_MPA",
        "HELD_MPA",
        "PREDICTED_%",
        "MEASURED_%",
        "WITH_GAIN_%",
        "DECIDED",
        "ENDED",
    ];
    let mut table = Table::new(heads);
    for row in &rows {
        let ended = if row["ended_at"].is_null() { "-".to_owned() } else { text(row, "end_reason") };
        table.row([
            text(row, "compensation_id"),
            place(row, "target_whisker"),
            text(row, "compensator_whisker"),
            text(row, "case"),
            text(row, "approval"),
            number(row, "pressure_before_mpa", 4),
            number(row, "held_pressure_mpa", 4),
            percent(row, "predicted_error"),
            percent(row, "measured_error"),
            percent(row, "measured_error_with_gain"),
            text(row, "decided_at"),
            ended,
        ]);
    }
    Ok(write!(out, "{table}")?)
}

/// Arguments of `vibrissa setpoint`.
#[derive(Debug, Args)]
pub struct SetpointArgs {
    /// Whisker, as FLEET/ROBOT/ARRAY/NUMBER.
    #[arg(value_parser = whisker)]
    whisker: Place,
    /// Pressure to hold, MPa: 0 to the whisker's maximum, at most 0.2.
    #[arg(
        long,
        value_name = "MPA",
        value_parser = pressure,
        required_unless_present = "release",
        conflicts_with = "release"
    )]
    pressure_mpa: Option<f64>,
    /// Release the whisker instead, so that the supervisor sets its pressure again.
    #[arg(long)]
    release: bool,
    /// Reason, for the audit log.
    #[arg(long)]
    reason: Option<String>,
    #[command(flatten)]
    api: ApiArgs,
}

/// Location of a whisker.
#[derive(Debug, Clone)]
struct Place {
    fleet: Name,
    robot: Name,
    array: Name,
    whisker: u16,
}

fn pressure(text: &str) -> Result<f64, String> {
    let mpa: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let highest = Megapascal::EXAMINED_MAX.mpa();
    // The supervisor also checks the limit of the whisker.
    (0.0..=highest).contains(&mpa).then_some(mpa).ok_or_else(|| format!("must be from 0 to {highest} MPa"))
}

fn whisker(text: &str) -> Result<Place, String> {
    let parts: Vec<&str> = text.split('/').collect();
    let [fleet, robot, array, whisker] = parts[..] else {
        return Err("must be FLEET/ROBOT/ARRAY/NUMBER".to_owned());
    };
    let name = |text: &str| Name::new(text).map_err(|bad| bad.to_string());
    let whisker = whisker.parse().map_err(|_| format!("{whisker:?} is not a whisker number"))?;
    Ok(Place { fleet: name(fleet)?, robot: name(robot)?, array: name(array)?, whisker })
}

/// Sets a whisker's pressure or releases the whisker, and prints the action.
///
/// # Errors
/// The supervisor does not answer or refuses the request, or the action was not executed in time.
pub fn setpoint(args: &SetpointArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let Place { fleet, robot, array, whisker } = &args.whisker;
    let base = format!("/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}");
    let api = args.api.open()?;
    let reason = args.reason.as_deref();
    let action = match args.pressure_mpa {
        Some(pressure_mpa) => {
            api.act(&format!("{base}/setpoint"), &json!({ "pressure_mpa": pressure_mpa, "reason": reason }))?
        }
        None => api.act(&format!("{base}/release"), &json!({ "reason": reason }))?,
    };
    if args.api.json {
        writeln!(out, "{action}")?;
    } else {
        let whole = api.one(&base)?;
        writeln!(
            out,
            "action {}: {} {}; whisker {fleet}/{robot}/{array}/{whisker} was at {} MPa when it was read",
            text(&action, "action_id"),
            text(&action, "kind"),
            text(&action, "state"),
            number(&whole, "pressure_mpa", 4),
        )?;
    }
    if action["state"] != "DONE" {
        bail!("not done yet: poll /v1/actions/{}", text(&action, "action_id"));
    }
    Ok(())
}

fn place(row: &Value, whisker: &str) -> String {
    format!("{}/{}/{}/{}", text(row, "fleet"), text(row, "robot"), text(row, "array"), text(row, whisker))
}

fn lines(rows: &[Value], out: &mut impl Write) -> anyhow::Result<()> {
    for row in rows {
        writeln!(out, "{row}")?;
    }
    Ok(())
}
