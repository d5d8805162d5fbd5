//! `vibrissa-robot calibrate`: a guided calibration in the terminal, which writes `agent.toml`.
//!
//! [`session`] talks to the drivers as the agent does, with all chambers empty. [`gauge`] and [`air`] have the steps of a
//! whisker, [`measure`] interprets samples, [`finding`] keeps the findings in a file until [`edit`] writes them. It
//! never runs beside an agent: it holds the lock of the outbox, and serial devices have locks, too.

mod air;
mod edit;
mod finding;
mod gauge;
mod measure;
mod session;

use std::io::BufRead as _;
use std::path::Path;

use anyhow::{Context, bail};
use tokio::sync::mpsc;
use vibrissa_host::task;
use vibrissa_program::signals::StopSignals;
use vibrissa_protocol::AirControl;

use finding::{Finding, Findings, Step, replace};
use measure::Rest;
use session::{Ended, Place, Session, say};

use crate::config::Config;
use crate::store::file::{StoreError, StoreFile};

/// Knowledge that the steps of one whisker share.
struct Bench {
    /// The gauge at rest, if a driver sends its strain.
    rest: Option<Rest>,
    strain_limit: f64,
    /// Largest strain that the gauge reads, in `agent.toml`.
    strain_max: Option<f64>,
    max_mpa: f64,
    /// The sensor's reading at the empty chamber, and its noise.
    zero_mpa: Option<f64>,
    noise_mpa: f64,
    /// `agent.toml` states a zero.
    has_zero: bool,
    has_air: bool,
    /// The driver has only valves.
    regulate: bool,
}

/// A number with so many decimals at most, without zeros at its end.
fn decimals(value: f64, count: usize) -> String {
    let text = format!("{value:.count$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    // A float of TOML has a point, and there is no -0.
    match text {
        "-0" | "0" => "0.0".to_owned(),
        whole if !whole.contains('.') => format!("{whole}.0"),
        other => other.to_owned(),
    }
}

/// Calibrates the whiskers of a robot, or only those of this list (`ARRAY/NUMBER`). `again` forgets what a calibration that
/// was stopped has found. Answers come from standard input.
///
/// # Errors
/// An agent runs, a driver cannot be reached, or somebody stopped the calibration: its findings are kept.
pub async fn calibrate(config: &Config, path: &Path, only: &[String], again: bool) -> anyhow::Result<()> {
    let lock = config.outbox_file.as_deref().map(StoreFile::lock).transpose();
    let _lock = lock.map_err(|problem| match problem {
        StoreError::InUse(_) => anyhow::Error::from(problem).context("end the agent first"),
        StoreError::Refused { .. } | StoreError::OtherVersion(_) => anyhow::Error::from(problem),
    })?;
    let mut signals = StopSignals::install()?;
    let (sender, mut answers) = mpsc::channel(1);
    // It ends with the process: nothing interrupts a thread that waits for the terminal.
    let _reading = task::spawn(async move {
        let read = move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if sender.blocking_send(line).is_err() {
                    return;
                }
            }
        };
        task::blocking(read).await
    });
    let kept = Findings::path(path);
    let mut findings = if again { Findings::default() } else { Findings::read(&kept)? };
    let places = places(config, only)?;
    let mut session = Session::open(config, &mut answers, &mut signals).await?;
    let mut outcome = Ok(());
    for place in &places {
        outcome = one(config, place, &mut session, &mut findings, &kept).await;
        if outcome.is_err() {
            break;
        }
    }
    if session.close().await {
        say("All chambers are empty, and all valves are closed.");
    } else {
        say("CHECK: not all chambers are known to be empty. Boards of this project vent 5 s after the last order.");
    }
    outcome
        .with_context(|| format!("the findings are kept in {}: start the command again to go on", kept.display()))?;
    offer(config, path, &findings, &kept, &mut answers, &mut signals).await
}

fn places(config: &Config, only: &[String]) -> anyhow::Result<Vec<Place>> {
    let all: Vec<Place> = config.whiskers.keys().cloned().collect();
    let name = |(array, whisker): &Place| format!("{array}/{whisker}");
    if let Some(unknown) = only.iter().find(|one| !all.iter().any(|place| name(place) == **one)) {
        let names: Vec<String> = all.iter().map(name).collect();
        bail!("{unknown:?} is no whisker of the robot: {}", names.join(", "));
    }
    Ok(all.into_iter().filter(|place| only.is_empty() || only.contains(&name(place))).collect())
}

/// The steps of one whisker that have not been done.
async fn one(
    config: &Config,
    place: &Place,
    session: &mut Session<'_>,
    findings: &mut Findings,
    kept: &Path,
) -> anyhow::Result<()> {
    let name = format!("{}/{}", place.0, place.1);
    let todo: Vec<Step> = Step::ALL.into_iter().filter(|step| !findings.is_done(&name, *step)).collect();
    if todo.is_empty() {
        say(&format!("{name}: all steps are done."));
        return Ok(());
    }
    let facts = config.facts.arrays.iter().find(|array| array.array == place.0);
    let facts = facts.and_then(|array| array.whiskers.iter().find(|one| one.whisker == place.1));
    let more = config.whiskers.get(place).copied().unwrap_or_default();
    let driver = config.drivers.iter().find(|driver| driver.whiskers.contains(place));
    let mut bench = Bench {
        rest: None,
        strain_limit: config.limits.segmenter.strain_limit,
        strain_max: facts.and_then(|one| one.strain_max),
        max_mpa: facts.map_or(0.0, |one| one.pressure_max_mpa),
        zero_mpa: None,
        noise_mpa: 0.0,
        has_zero: more.pressure_zero_mpa != 0.0,
        has_air: config.facts.air_control.is_none_or(|air| air == AirControl::FillAndVent),
        regulate: driver.is_some_and(|driver| driver.limits.regulate),
    };
    say(&format!("{name}: {} of {} steps.", todo.len(), Step::ALL.len()));
    session.turn_to(place);
    // Later steps compare with the gauge at rest.
    let needs_rest = todo.iter().any(|step| matches!(step, Step::Rest | Step::Sign | Step::Scale | Step::Slide));
    let mut at_rest = if needs_rest { gauge::rest(session, &mut bench).await? } else { Vec::new() };
    for step in todo {
        let found = match step {
            Step::Rest => Ok(std::mem::take(&mut at_rest)),
            Step::Sign => gauge::sign(session, &mut bench).await,
            Step::Scale => gauge::scale(session, &mut bench).await,
            Step::Slide => gauge::slide(session, &mut bench).await,
            Step::Pressure => air::zero(session, &mut bench).await,
            Step::Valves => air::valves(session, &mut bench).await,
        }?;
        found.iter().for_each(|finding| say(&finding.line(&name)));
        findings.add(&name, step, found);
        findings.write(kept)?;
    }
    Ok(())
}

/// Shows what changes in the file, and writes it if the person agrees.
async fn offer(
    config: &Config,
    path: &Path,
    findings: &Findings,
    kept: &Path,
    answers: &mut mpsc::Receiver<String>,
    signals: &mut StopSignals,
) -> anyhow::Result<()> {
    let mut text = vibrissa_protocol::text_file::read_text(path, 1024 * 1024)?;
    let before = text.clone();
    for place @ (array, whisker) in config.whiskers.keys() {
        let name = format!("{}/{}", place.0, place.1);
        let steps = findings.0.get(&name).into_iter().flat_map(|steps| steps.values().flatten());
        for (key, value) in steps.filter_map(|finding: &Finding| finding.change.as_ref()) {
            let edited = if value.is_empty() {
                edit::without(&text, array, *whisker, key)
            } else {
                edit::with_value(&text, array, *whisker, key, value)
            };
            let edited = edited.map_err(anyhow::Error::msg)?;
            match value.as_str() {
                _ if edited == text => {}
                "" => say(&format!("{name}: {key} is removed")),
                value => say(&format!("{name}: {key} = {value}")),
            }
            text = edited;
        }
    }
    if text == before {
        say(&format!("{} has all of this already.", path.display()));
        return Ok(std::fs::remove_file(kept)?);
    }
    // A mistake of this program must not cost the person's file.
    Config::from_toml_str(&text, path.parent().unwrap_or(Path::new("")))?;
    say(&format!("Write this to {}? [y/n]", path.display()));
    let answer = tokio::select! {
        answer = answers.recv() => answer.ok_or(Ended::NoAnswer),
        () = signals.received() => Err(Ended::Stopped),
    };
    let answer = answer.with_context(|| format!("the findings are kept in {}", kept.display()))?;
    if !answer.trim().eq_ignore_ascii_case("y") {
        say(&format!("Nothing is written. The findings are kept in {}.", kept.display()));
        return Ok(());
    }
    replace(path, &text)?;
    std::fs::remove_file(kept)?;
    say(&format!("{} is written. Start the agent.", path.display()));
    Ok(())
}
