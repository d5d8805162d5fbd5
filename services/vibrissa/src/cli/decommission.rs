//! `vibrissa decommission`: takes a robot out of service that has left for good.

use std::io::Write;

use anyhow::bail;
use clap::Args;
use serde_json::json;
use vibrissa_protocol::Name;

use super::api::{ApiArgs, text};

/// Arguments of `vibrissa decommission`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The robot leaves all lists, metrics and limits, its alarms end, and its retained messages are cleared at the broker. Its
history stays, and what was learned about its whiskers is forgotten. Switch the robot off first: one that starts again is
registered anew, unless the allow list of the fleet excludes it.")]
pub struct DecommissionArgs {
    /// Robot, as FLEET/ROBOT.
    #[arg(value_parser = robot)]
    robot: (Name, Name),
    /// Reason, for the audit log.
    #[arg(long)]
    reason: Option<String>,
    #[command(flatten)]
    api: ApiArgs,
}

fn robot(text: &str) -> Result<(Name, Name), String> {
    let (fleet, robot) = text.split_once('/').ok_or("must be FLEET/ROBOT")?;
    let name = |text: &str| Name::new(text).map_err(|bad| bad.to_string());
    Ok((name(fleet)?, name(robot)?))
}

/// Takes a robot out of service.
///
/// # Errors
/// The supervisor does not answer or refuses the request, or the action was not executed in time.
pub fn run(args: &DecommissionArgs, out: &mut impl Write) -> anyhow::Result<()> {
    let (fleet, robot) = &args.robot;
    let api = args.api.open()?;
    let action = api.remove(&format!("/v1/fleets/{fleet}/robots/{robot}"), &json!({ "reason": args.reason }))?;
    if args.api.json {
        writeln!(out, "{action}")?;
    } else {
        let (number, state) = (text(&action, "action_id"), text(&action, "state"));
        writeln!(out, "action {number}: {fleet}/{robot} is decommissioned: {state}")?;
    }
    if action["state"] != "DONE" {
        bail!("not done yet: poll /v1/actions/{}", text(&action, "action_id"));
    }
    Ok(())
}
