//! `vibrissa bulk`: an action on all robots, whiskers or alarms that meet conditions.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};
use tokio::time::Instant;
use vibrissa_core::robot::effect::Condition;
use vibrissa_edge::fleets::FleetSelection;
use vibrissa_edge::labels::LabelConditions;
use vibrissa_edge::words::Word;
use vibrissa_host::task;
use vibrissa_protocol::Name;

use super::ANSWER_IS_NO;
use super::api::{Api, ApiArgs, text};
use super::words::word_of;

/// Arguments of `vibrissa bulk`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Without --execute the command only lists what it would concern. With --execute it requests exactly the subjects of that list,
prints the progress, and waits. The exit code is 0 if all actions were executed. It is 3 if some were refused or not executed
in time, or if the time of --wait is over. One request concerns at most 1000 subjects.")]
pub struct BulkArgs {
    /// What to do.
    action: Action,
    /// Only these fleets: names or patterns such as 'hall-*', separated by commas.
    #[arg(long, value_name = "FLEETS")]
    fleet: Option<FleetSelection>,
    /// Only this robot.
    #[arg(long)]
    robot: Option<Name>,
    /// Only whiskers or alarms of this array.
    #[arg(long)]
    array: Option<Name>,
    /// Only whiskers in this condition.
    #[arg(long, value_parser = word_of::<Condition>())]
    condition: Option<Condition>,
    /// Only robots with these labels: KEY=VALUE or KEY, separated by commas.
    #[arg(long, value_name = "LABELS")]
    label: Option<LabelConditions>,
    /// Execute the action. Without it, only list what it would concern.
    #[arg(long)]
    execute: bool,
    /// Actions that become due in each second, 1 to 100.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..=100))]
    per_second: Option<u32>,
    /// Reason, for the audit log.
    #[arg(long)]
    reason: Option<String>,
    /// Longest time to wait for the end, s; 0 does not wait.
    #[arg(long, value_name = "SECONDS", default_value_t = 300, value_parser = clap::value_parser!(u64).range(0..=86_400))]
    wait: u64,
    #[command(flatten)]
    api: ApiArgs,
}

/// A bulk action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Action {
    /// Hold robots: send no automatic setpoints to their whiskers.
    HoldRobots,
    /// Release held robots.
    ReleaseRobots,
    /// Hold whiskers.
    HoldWhiskers,
    /// Release held whiskers.
    ReleaseWhiskers,
    /// Relearn the baselines of whiskers.
    RelearnWhiskers,
    /// Acknowledge standing alarms.
    AcknowledgeAlarms,
}

impl Action {
    const fn path(self) -> &'static str {
        match self {
            Self::HoldRobots => "/v1/robots/hold",
            Self::ReleaseRobots => "/v1/robots/release",
            Self::HoldWhiskers => "/v1/whiskers/hold",
            Self::ReleaseWhiskers => "/v1/whiskers/release",
            Self::RelearnWhiskers => "/v1/whiskers/rebaseline",
            Self::AcknowledgeAlarms => "/v1/alarms/acknowledge",
        }
    }

    /// Field of the answer that has the number of subjects, which is also their noun.
    const fn counted(self) -> &'static str {
        if matches!(self, Self::AcknowledgeAlarms) { "alarms" } else { "subjects" }
    }
}

/// Pause between two requests for the progress.
const POLLED_EVERY: Duration = Duration::from_millis(500);

impl BulkArgs {
    fn filter(&self) -> Value {
        let conditions = [
            ("fleet", self.fleet.as_ref().map(ToString::to_string)),
            ("robot", self.robot.as_ref().map(ToString::to_string)),
            ("array", self.array.as_ref().map(ToString::to_string)),
            ("condition", self.condition.map(|condition| condition.word().to_owned())),
            ("label", self.label.as_ref().map(ToString::to_string)),
        ];
        let given = conditions.into_iter().filter_map(|(name, text)| Some((name.to_owned(), Value::from(text?))));
        Value::Object(given.collect::<Map<_, _>>())
    }

    /// The request after its dry run, or the dry run itself.
    fn body(&self, dry: Option<&Value>) -> Value {
        let mut body = json!({ "dry_run": dry.is_none(), "reason": self.reason });
        if self.action == Action::AcknowledgeAlarms {
            body["which"] = json!({ "filter": self.filter() });
            if let Some(dry) = dry {
                body["which"]["up_to_alarm_id"] = json!(dry["newest_alarm_id"].as_i64().unwrap_or_default());
            }
        } else {
            body["filter"] = self.filter();
            body["per_second"] = json!(self.per_second);
            body["digest"] = dry.map_or(Value::Null, |dry| dry["digest"].clone());
        }
        body
    }
}

/// Lists the subjects of an action, or executes it and follows its progress.
///
/// # Errors
/// The supervisor does not answer, or refuses the request.
pub fn run(args: &BulkArgs, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let api = args.api.open()?;
    let path = args.action.path();
    let dry = api.act(path, &args.body(None))?;
    if args.api.json && !args.execute {
        writeln!(out, "{dry}")?;
        return Ok(ExitCode::SUCCESS);
    }
    let noun = args.action.counted();
    let count = text(&dry, noun);
    if !args.api.json {
        for item in dry["items"].as_array().map_or(&[][..], Vec::as_slice) {
            writeln!(out, "{}", subject(item))?;
        }
        let more = if dry["more"] == true { "; more match: repeat the command for them" } else { "" };
        writeln!(out, "{count} {noun}{more}")?;
    }
    if !args.execute {
        writeln!(out, "nothing was changed: add --execute")?;
        return Ok(ExitCode::SUCCESS);
    }
    let begun = api.act(path, &args.body(Some(&dry)))?;
    let Some(action_id) = begun["action_id"].as_i64().filter(|_| begun[noun] != 0) else {
        if args.api.json {
            writeln!(out, "{begun}")?;
        } else {
            writeln!(out, "nothing was to be done")?;
        }
        return Ok(ExitCode::SUCCESS);
    };
    follow(args, &api, action_id, out)
}

fn subject(item: &Value) -> String {
    let parts = ["fleet", "robot", "array", "whisker"].map(|field| text(item, field));
    let known: Vec<String> = parts.into_iter().filter(|part| part != "-").collect();
    let kind = item["kind"].as_str().map_or(String::new(), |kind| format!(" {kind}"));
    format!("{}{kind}", known.join("/"))
}

/// Prints the progress until no action waits, or until the time is over.
fn follow(args: &BulkArgs, api: &Api, action_id: i64, out: &mut impl Write) -> anyhow::Result<ExitCode> {
    let deadline = Instant::now() + Duration::from_secs(args.wait);
    let mut last = String::new();
    loop {
        let detail = api.one(&format!("/v1/bulk-actions/{action_id}"))?;
        let request = &detail["request"];
        let [subjects, pending, done, refused, expired] = ["subjects", "pending", "done", "refused", "expired"]
            .map(|field| request[field].as_i64().unwrap_or_default());
        let line = format!("action {action_id}: {done} of {subjects} done, {refused} refused, {expired} expired");
        if line != last && !args.api.json {
            writeln!(out, "{line}")?;
            out.flush()?;
        }
        last = line;
        if pending == 0 || Instant::now() >= deadline {
            if args.api.json {
                writeln!(out, "{detail}")?;
            }
            for refusal in detail["refusals"].as_array().map_or(&[][..], Vec::as_slice) {
                eprintln!("vibrissa: {} refused: {}", text(refusal, "subjects"), text(refusal, "problem"));
            }
            if pending > 0 && args.wait > 0 {
                eprintln!("vibrissa: {pending} still wait after {} s; follow /v1/bulk-actions/{action_id}", args.wait);
            }
            let is_done = done == subjects || (args.wait == 0 && refused + expired == 0);
            return Ok(if is_done { ExitCode::SUCCESS } else { ExitCode::from(ANSWER_IS_NO) });
        }
        task::block_for(POLLED_EVERY);
    }
}
