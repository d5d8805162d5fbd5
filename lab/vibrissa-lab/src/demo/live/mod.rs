//! The demo after its scripted part: the robots go on touching, and a person lets incidents happen to their whiskers.

mod incident;
mod incidents;
mod routes;
mod terminal;

use std::pin::pin;
use std::time::Duration;

use anyhow::Context;
use tokio::sync::mpsc;
use tokio::time::Instant;
use vibrissa_host::random;
use vibrissa_simulator::Fleet;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::Store;
use vibrissa_store::lists::compensations::{COMPENSATIONS, CompensationSummary};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_supervisor::http::access::Caller;
use vibrissa_supervisor::http::asking::Asker;
use vibrissa_supervisor::service::Service;

use incident::WhiskerName;
pub(super) use incidents::Incidents;
pub(super) use routes::routes;
use terminal::{Command, MENU};

use super::report;

/// Contacts of each robot per second.
const CONTACTS_PER_SECOND: f64 = 20.0;
/// Polling interval for new events.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Longest time in which all whiskers are learned in time-lapse.
const LEARNING_PATIENCE: Duration = Duration::from_secs(30);
/// The whisker that is meant while no command has named one.
const FIRST_WHISKER: &str = "crawler-1/left/0";

/// Waits until all whiskers are learned, while the robots touch in time-lapse.
pub(super) async fn learn(store: &Store) -> anyhow::Result<()> {
    let learned = async {
        loop {
            tokio::time::sleep(LOOK_EVERY).await;
            let whiskers: Vec<Whisker> = store.all(&WHISKERS, Vec::new()).await?;
            if !whiskers.is_empty() && whiskers.iter().all(|whisker| whisker.condition != "LEARNING") {
                return anyhow::Ok(());
            }
        }
    };
    tokio::time::timeout(LEARNING_PATIENCE, learned).await.context("the supervisor has not learned all whiskers")?
}

/// Lets the robots touch in real time and carries out commands, until `quit` or Ctrl-C.
pub(super) async fn run(
    service: &Service,
    fleet: &Fleet,
    incidents: &Incidents,
    opens_browser: bool,
) -> anyhow::Result<()> {
    for robot in fleet.robots() {
        robot.with(|robot| robot.touch_at_rate(CONTACTS_PER_SECOND / robot.whiskers().len() as f64, now_us()));
    }
    let console = format!("http://{}/", service.http);
    incidents.open(fleet.robots(), &service.store, &service.action_notifier);
    println!(
        "\nThe robots go on touching, {CONTACTS_PER_SECOND} times a second each, until Ctrl-C.\n\
         Console: {console}\nNext: type \"cut 5 whisker 2\", and open the console to see what follows. Or break a whisker there, on the page \
         of a robot (\"Demo\").\n{MENU}",
    );
    if opens_browser {
        open(&console);
    }
    let mut story = Story::from_now(&service.store).await?;
    let mut lines = Some(terminal::lines());
    let mut last: WhiskerName = FIRST_WHISKER.parse().map_err(anyhow::Error::msg)?;
    let mut look = tokio::time::interval(LOOK_EVERY);
    // One future for all turns: a new one would miss a signal that comes while a branch is carried out.
    let mut interrupted = pin!(tokio::signal::ctrl_c());
    loop {
        tokio::select! {
            interrupted = &mut interrupted => return interrupted.context("waiting for Ctrl-C"),
            _ = look.tick() => story.tell(&service.store).await?,
            line = next(&mut lines) => match line.map(|line| terminal::parse(&line, &last)) {
                // Standard input is closed.
                None => lines = None,
                Some(Ok(Command::Nothing)) => {}
                Some(Ok(Command::Help)) => println!("{MENU}"),
                Some(Ok(Command::Quit)) => return Ok(()),
                Some(Ok(Command::Cause(whisker, incident))) => {
                    match incidents.cause(&whisker, incident, asker()).await {
                        Ok(text) => println!("{text}"),
                        Err(refusal) => println!("not done: {refusal}"),
                    }
                    last = whisker;
                }
                Some(Err(problem)) => println!("not understood: {problem}"),
            },
        }
    }
}

/// Opens an address in the person's browser.
fn open(address: &str) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    if let Err(problem) = std::process::Command::new(program).arg(address).spawn() {
        println!("{program} does not start ({problem}): open {address} yourself");
    }
}

/// The next line; never without standard input.
async fn next(lines: &mut Option<mpsc::Receiver<String>>) -> Option<String> {
    match lines {
        Some(lines) => lines.recv().await,
        None => std::future::pending().await,
    }
}

/// The person at the terminal, for the audit log.
fn asker() -> Asker {
    Asker { caller: Caller::local(), request_id: random::hex(), idempotency_key: None }
}

/// Prints events once, with the seconds since the robots touch in real time.
struct Story {
    begun: Instant,
    printed: usize,
    measured: Vec<i64>,
}

impl Story {
    /// The events from now on.
    async fn from_now(store: &Store) -> anyhow::Result<Self> {
        let mut story =
            Self { begun: Instant::now(), printed: report::story(store).await?.len(), measured: Vec::new() };
        story.measured(store).await?;
        Ok(story)
    }

    async fn tell(&mut self, store: &Store) -> anyhow::Result<()> {
        let lines = report::story(store).await?;
        let new = lines.iter().skip(self.printed).cloned().chain(self.measured(store).await?);
        let seconds = self.begun.elapsed().as_secs_f64();
        new.for_each(|line| println!("{seconds:6.1} s  {line}"));
        self.printed = self.printed.max(lines.len());
        Ok(())
    }

    /// First measured errors that are new.
    async fn measured(&mut self, store: &Store) -> anyhow::Result<Vec<String>> {
        let compensations: Vec<CompensationSummary> = store.all(&COMPENSATIONS, Vec::new()).await?;
        let mut lines = Vec::new();
        for one in compensations {
            let Some(error) = one.measured_error.filter(|_| !self.measured.contains(&one.compensation_id)) else {
                continue;
            };
            self.measured.push(one.compensation_id);
            lines.push(format!(
                "{}/{}/{}: compensation error measured, {:.1} %",
                one.robot,
                one.array,
                one.target_whisker,
                100.0 * error
            ));
        }
        Ok(lines)
    }
}
