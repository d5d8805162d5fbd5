//! `vibrissa whiskers` and `vibrissa compensations`: lists from the API.

use std::io::Write;

use clap::Args;
use serde_json::Value;
use vibrissa_core::robot::effect::Condition;
use vibrissa_edge::fleets::FleetSelection;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;

use super::api::{Api, ApiArgs, number, percent, text};
use super::table::Table;
use super::watch::WatchArgs;
use super::words::word_of;

/// Arguments of `vibrissa whiskers`.
#[derive(Debug, Args)]
pub struct WhiskersArgs {
    /// Only these fleets: names or patterns such as 'hall-*', separated by commas.
    #[arg(long, value_name = "FLEETS")]
    fleet: Option<FleetSelection>,
    /// Only this robot.
    #[arg(long)]
    robot: Option<Name>,
    /// Only this condition.
    #[arg(long, value_parser = word_of::<Condition>())]
    condition: Option<Condition>,
    #[command(flatten)]
    watch: WatchArgs,
    #[command(flatten)]
    api: ApiArgs,
}

/// Prints the list of whiskers.
///
/// # Errors
/// The supervisor does not answer, or refuses the request.
pub fn whiskers(args: &WhiskersArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let api = args.api.open()?;
    args.watch.repeat(out, |out| list_whiskers(args, &api, out))
}

fn list_whiskers(args: &WhiskersArgs, api: &Api, out: &mut impl Write) -> anyhow::Result<()> {
    let filters = [
        ("fleet", args.fleet.as_ref().map(ToString::to_string)),
        ("robot", args.robot.as_ref().map(ToString::to_string)),
        ("condition", args.condition.map(|condition| condition.word().to_owned())),
    ];
    let rows = api.rows("/v1/whiskers", &filters)?;
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
        "COMPENSATOR",
        "COMPENSATES_FOR",
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
            text(row, "compensator_whisker"),
            text(row, "target_whisker"),
        ]);
    }
    Ok(write!(out, "{table}")?)
}

/// Arguments of `vibrissa compensations`.
#[derive(Debug, Args)]
pub struct CompensationsArgs {
    /// Only these fleets: names or patterns such as 'hall-*', separated by commas.
    #[arg(long, value_name = "FLEETS")]
    fleet: Option<FleetSelection>,
    /// Only this robot.
    #[arg(long)]
    robot: Option<Name>,
    /// Only active compensations.
    #[arg(long)]
    active: bool,
    #[command(flatten)]
    watch: WatchArgs,
    #[command(flatten)]
    api: ApiArgs,
}

/// Prints the list of compensations.
///
/// # Errors
/// The supervisor does not answer, or refuses the request.
pub fn compensations(args: &CompensationsArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let api = args.api.open()?;
    args.watch.repeat(out, |out| list_compensations(args, &api, out))
}

fn list_compensations(args: &CompensationsArgs, api: &Api, out: &mut impl Write) -> anyhow::Result<()> {
    let filters = [
        ("fleet", args.fleet.as_ref().map(ToString::to_string)),
        ("robot", args.robot.as_ref().map(ToString::to_string)),
        ("active", args.active.then(|| "true".to_owned())),
    ];
    let rows = api.rows("/v1/compensations", &filters)?;
    if args.api.json {
        return lines(&rows, out);
    }
    let heads = [
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
        "COMPENSATION_ID",
    ];
    let mut table = Table::new(heads);
    for row in &rows {
        let ended = if row["ended_at"].is_null() { "-".to_owned() } else { text(row, "end_reason") };
        table.row([
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
            text(row, "compensation_id"),
        ]);
    }
    Ok(write!(out, "{table}")?)
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
