//! `vibrissa setpoint`: sets a whisker's pressure by hand, or releases the whisker, and waits for the robot.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::bail;
use clap::Args;
use serde_json::{Value, json};
use tokio::time::Instant;
use vibrissa_core::units::Megapascal;
use vibrissa_host::task;
use vibrissa_protocol::Name;

use super::ANSWER_IS_NO;
use super::api::{Api, ApiArgs, number, text};

/// Arguments of `vibrissa setpoint`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The command waits until the robot has applied the pressure, and prints each state that the setpoint passes. The exit
code is 0 if the robot has applied it, or if no setpoint was necessary because the whisker holds the pressure already.
It is 3 if the robot has rejected it or failed, if it expired, if another one replaced it, or if the time of --wait is
over. With --wait 0 the exit code is 0 as soon as the supervisor has accepted the request.")]
pub struct SetpointArgs {
    /// Whisker, as FLEET/ROBOT/ARRAY/NUMBER.
    #[arg(value_parser = whisker)]
    whisker: WhiskerAddress,
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
    /// Longest time to wait for the robot, s; 0 does not wait.
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    wait: u64,
    #[command(flatten)]
    api: ApiArgs,
}

/// Location of a whisker.
#[derive(Debug, Clone)]
struct WhiskerAddress {
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

fn whisker(text: &str) -> Result<WhiskerAddress, String> {
    let parts: Vec<&str> = text.split('/').collect();
    let [fleet, robot, array, whisker] = parts[..] else {
        return Err("must be FLEET/ROBOT/ARRAY/NUMBER".to_owned());
    };
    let name = |text: &str| Name::new(text).map_err(|bad| bad.to_string());
    let whisker = whisker.parse().map_err(|_| format!("{whisker:?} is not a whisker number"))?;
    Ok(WhiskerAddress { fleet: name(fleet)?, robot: name(robot)?, array: name(array)?, whisker })
}

impl std::fmt::Display for WhiskerAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}/{}/{}", self.fleet, self.robot, self.array, self.whisker)
    }
}

/// Pause between two requests for the state.
const POLLED_EVERY: Duration = Duration::from_millis(200);
/// Number of the newest setpoints of the whisker among which ours must be.
const NEWEST: u32 = 20;
/// Pressures closer than this are the same setpoint for the supervisor, MPa.
const SAME_MPA: f64 = 1e-5;

/// Sets a whisker's pressure or releases the whisker, and follows the setpoint.
///
/// # Errors
/// The supervisor does not answer or refuses the request, or the action was not executed in time.
pub fn run(args: &SetpointArgs, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let WhiskerAddress { fleet, robot, array, whisker } = &args.whisker;
    let base = format!("/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}");
    let api = args.api.open()?;
    let reason = args.reason.as_deref();
    let begun = Instant::now();
    let waiting = Waiting { args, api: &api, deadline: begun + Duration::from_secs(args.wait) };
    let before = if args.wait == 0 { None } else { waiting.newest()?.first().map(key) };
    let action = match args.pressure_mpa {
        Some(pressure_mpa) => {
            api.act(&format!("{base}/setpoint"), &json!({ "pressure_mpa": pressure_mpa, "reason": reason }))?
        }
        None => api.act(&format!("{base}/release"), &json!({ "reason": reason }))?,
    };
    let action = waiting.answered(action)?;
    if args.api.json {
        writeln!(out, "{action}")?;
    } else {
        let whole = api.one(&base)?;
        writeln!(
            out,
            "action {}: {} {}; whisker {} was at {} MPa when it was read",
            text(&action, "action_id"),
            text(&action, "kind"),
            text(&action, "state"),
            args.whisker,
            number(&whole, "pressure_mpa", 4),
        )?;
    }
    if action["state"] != "DONE" {
        bail!("not done yet: poll /v1/actions/{}", text(&action, "action_id"));
    }
    if args.wait == 0 {
        return Ok(ExitCode::SUCCESS);
    }
    // The setpoint is committed with the answer of the action.
    match waiting.own(before.as_ref())? {
        Some(setpoint) => waiting.follow(&setpoint, out),
        None => {
            waiting.say(out, "no setpoint was necessary: the whisker holds the pressure already")?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// Epoch and version: a later setpoint of a robot has a higher one.
fn key(setpoint: &Value) -> (i64, i64) {
    let whole = |field: &str| setpoint[field].as_i64().unwrap_or_default();
    (whole("epoch"), whole("version"))
}

/// Follows an action and its setpoint.
struct Waiting<'a> {
    args: &'a SetpointArgs,
    api: &'a Api,
    deadline: Instant,
}

impl Waiting<'_> {
    fn is_over(&self) -> bool {
        Instant::now() >= self.deadline
    }

    /// A line for people; beside JSON it goes to standard error.
    fn say(&self, out: &mut impl Write, line: &str) -> anyhow::Result<()> {
        if self.args.api.json {
            eprintln!("vibrissa: {line}");
        } else {
            writeln!(out, "{line}")?;
            // The reader sees each state when it is reached.
            out.flush()?;
        }
        Ok(())
    }

    /// The action when it is no longer pending, or at the end of the time.
    fn answered(&self, mut action: Value) -> anyhow::Result<Value> {
        while action["state"] == "PENDING" && !self.is_over() {
            task::block_for(POLLED_EVERY);
            action = self.api.one(&format!("/v1/actions/{}", text(&action, "action_id")))?;
        }
        Ok(action)
    }

    /// The newest setpoints of the whisker, the last one first.
    fn newest(&self) -> anyhow::Result<Vec<Value>> {
        let WhiskerAddress { fleet, robot, array, whisker } = &self.args.whisker;
        let filters = [
            ("fleet", fleet.to_string()),
            ("robot", robot.to_string()),
            ("array", array.to_string()),
            ("whisker", whisker.to_string()),
        ];
        let mut rows = self.api.page("/v1/setpoints", &filters, NEWEST)?;
        rows.sort_by_key(|row| std::cmp::Reverse(key(row)));
        Ok(rows)
    }

    /// The setpoint that the action has led to: a new one, or an equal one that is on its way.
    fn own(&self, before: Option<&(i64, i64)>) -> anyhow::Result<Option<Value>> {
        let is_own = |row: &Value| {
            let is_by_hand = row["reason"] == "OPERATOR";
            let is_asked = match self.args.pressure_mpa {
                Some(asked_mpa) => {
                    is_by_hand && row["pressure_mpa"].as_f64().is_some_and(|mpa| (mpa - asked_mpa).abs() < SAME_MPA)
                }
                None => !is_by_hand,
            };
            let is_new = before.is_none_or(|before| key(row) > *before);
            is_asked && (is_new || !is_final(&text(row, "state")))
        };
        Ok(self.newest()?.into_iter().find(is_own))
    }

    /// Prints the states of the setpoint until its end, or until the time is over.
    fn follow(&self, setpoint: &Value, out: &mut impl Write) -> anyhow::Result<ExitCode> {
        let command_id = text(setpoint, "command_id");
        let place = &self.args.whisker;
        let asked_mpa = number(setpoint, "pressure_mpa", 4);
        self.say(out, &format!("setpoint {command_id}: {asked_mpa} MPa sent, waiting for the robot"))?;
        let mut printed = 0;
        loop {
            let now = self.api.one(&format!("/v1/setpoints/{command_id}"))?;
            let history = now["history"].as_array().map_or(&[][..], Vec::as_slice);
            for state in history.iter().skip(printed).filter(|state| state["state"] != "PENDING") {
                self.say(out, &state_text(state))?;
            }
            printed = history.len();
            let state = text(&now, "state");
            if is_final(&state) || self.is_over() {
                if self.args.api.json {
                    writeln!(out, "{now}")?;
                }
                if state == "APPLIED" {
                    return Ok(ExitCode::SUCCESS);
                }
                let why = if is_final(&state) {
                    format!("its setpoint is {state}")
                } else {
                    format!(
                        "its setpoint is {state} after {} s; follow it at /v1/setpoints/{command_id}",
                        self.args.wait
                    )
                };
                eprintln!("vibrissa: whisker {place} has not applied {asked_mpa} MPa: {why}");
                return Ok(ExitCode::from(ANSWER_IS_NO));
            }
            task::block_for(POLLED_EVERY);
        }
    }
}

fn is_final(state: &str) -> bool {
    !matches!(state, "PENDING" | "RECEIVED" | "APPLYING")
}

fn state_text(state: &Value) -> String {
    let word = text(state, "state");
    match (state["error"].as_str(), state["pressure_mpa"].as_f64()) {
        (Some(error), _) => format!("{word} ({error})"),
        (None, Some(mpa)) => format!("{word} at {mpa:.4} MPa"),
        (None, None) => word,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_is_within_the_examined_range() {
        assert_eq!((pressure("0"), pressure("0.2")), (Ok(0.0), Ok(0.2)));
        for bad in ["-0.01", "0.21", "nan", "inf"] {
            assert_eq!(pressure(bad).unwrap_err(), "must be from 0 to 0.2 MPa", "{bad}");
        }
        assert_eq!(pressure("x").unwrap_err(), "not a number");
    }

    #[test]
    fn a_state_is_told_with_its_reason_or_pressure() {
        assert_eq!(state_text(&json!({ "state": "RECEIVED", "error": null, "pressure_mpa": null })), "RECEIVED");
        assert_eq!(
            state_text(&json!({ "state": "APPLIED", "error": null, "pressure_mpa": 0.05 })),
            "APPLIED at 0.0500 MPa"
        );
        assert_eq!(state_text(&json!({ "state": "REJECTED", "error": "STALE" })), "REJECTED (STALE)");
    }
}
