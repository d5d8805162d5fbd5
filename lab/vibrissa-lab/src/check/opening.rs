//! The beginning of a check: retained messages, the period of statuses, requests, and the choice of the whisker.

use std::time::Duration;

use anyhow::{Context, bail};
use tokio::time::Instant;
use vibrissa_protocol::{BootId, ConnectionState, Message, RequestKind, Rule};

use super::bench::{Bench, Trial};
use super::log::{conditions, facts, whiskers};
use super::report::seconds;
use super::timings::{BIRTHS_WITHIN, TOO_QUICK};

/// Number of statuses whose period is measured.
const WATCHED: usize = 4;
/// Why rules about retained messages are not judged.
pub(super) const NOT_RETAINED: &str = "the broker retains no messages";
/// Size of a pressure change.
const STEP_MPA: f64 = 0.01;

impl Bench {
    /// Reads the retained messages.
    ///
    /// # Errors
    /// A supervisor owns the fleet, or the robot is not connected.
    pub(super) async fn open(&mut self) -> anyhow::Result<()> {
        let timings = self.timings();
        let limit = if self.heard.retains { timings.retained } else { timings.supervisor };
        // The first messages are the retained ones, among them the supervisor's state if there is one.
        self.listen(limit)
            .await
            .context("cannot check the fleet while a supervisor owns it; stop the supervisor first")?;
        self.heard.is_live = true;
        if !self.heard.retains {
            self.skip(&[Rule::FactsheetRetained, Rule::WillRetained], NOT_RETAINED);
            self.hear_births().await?;
        }
        let (fleet, robot) = (self.options.fleet.clone(), self.options.robot.clone());
        match self.heard.connection {
            Some(ConnectionState::Online) => {}
            Some(state @ (ConnectionState::Offline | ConnectionState::ConnectionBroken)) => {
                bail!("robot {fleet}/{robot} is not connected: its last state is {state}");
            }
            None => {
                let patience = self.timings().status.1;
                if self.until(patience, |heard| (!heard.log.is_empty()).then_some(())).await?.is_none() {
                    let seconds = seconds(patience);
                    bail!("no message of {fleet}/{robot} within {seconds}: is it on, and are these its names?");
                }
                let seen = if self.heard.retains {
                    "the robot sends messages, but the broker retains no ONLINE of it"
                } else {
                    "the robot sends messages, but no ONLINE, not even on request"
                };
                self.fail(Rule::Birth, seen);
            }
        }
        self.open_factsheet().await
    }

    /// Asks for births, because the broker retains none.
    async fn hear_births(&mut self) -> anyhow::Result<()> {
        self.request_births().await?;
        let limit = BIRTHS_WITHIN + self.timings().answer;
        self.until(limit, |heard| (heard.connection.is_some() && heard.factsheet.is_some()).then_some(())).await?;
        Ok(())
    }

    async fn open_factsheet(&mut self) -> anyhow::Result<()> {
        if self.heard.factsheet.is_some() {
            let seen = if self.heard.retains { "the broker retains a factsheet" } else { "it followed the birth" };
            self.pass(Rule::FactsheetAfterBirth, seen);
            return Ok(());
        }
        let mark = self.mark();
        self.request(RequestKind::Factsheet).await?;
        let limit = self.timings().answer;
        self.until(limit, |heard| heard.factsheet.is_some().then_some(())).await?;
        // A factsheet that is not retained may still have followed the birth.
        let came = self.heard.log[mark..].iter().find(|entry| super::is_factsheet(&entry.message));
        match came {
            Some(entry) if !entry.retained => {}
            Some(_) => {
                self.fail(Rule::FactsheetAfterBirth, "the robot is connected, and sent no factsheet before the request")
            }
            None => self.fail(Rule::FactsheetAfterBirth, "no factsheet, not even on request"),
        }
        Ok(())
    }

    /// Measures the period of statuses without requests.
    pub(super) async fn watch(&mut self) -> anyhow::Result<()> {
        let (shortest, longest) = self.timings().status;
        let (begun, mark) = (Instant::now(), self.mark());
        let mut last = begun;
        // A little longer than allowed, because the network may delay a status.
        let patience = longest + longest / 10;
        loop {
            let seen = self.heard.statuses(mark).count();
            if seen >= WATCHED && begun.elapsed() >= 3 * shortest {
                break;
            }
            let next = self.until(patience, |heard| heard.statuses(mark).nth(seen).map(|(_, at)| at)).await?;
            let Some(at) = next else {
                self.fail(Rule::StatusPeriod, format!("no status for {}", seconds(last.elapsed())));
                return Ok(());
            };
            last = at;
        }
        let times: Vec<Instant> = self.heard.statuses(mark).map(|(_, at)| at).collect();
        let mean = mean_gap(&times).unwrap_or_default();
        self.period = times.windows(2).map(|pair| pair[1] - pair[0]).max();
        let is_calm = {
            let mut conditions = self.heard.statuses(mark).map(|(status, _)| conditions(status));
            let first = conditions.next();
            conditions.all(|one| Some(one) == first)
        };
        let is_too_often = is_calm && mean < shortest.mul_f64(0.8);
        let seen = format!("one every {} on average over {}", seconds(mean), times.len());
        self.judge(Rule::StatusPeriod, !is_too_often, seen);
        Ok(())
    }

    /// Requests a factsheet and statuses.
    pub(super) async fn ask(&mut self) -> anyhow::Result<()> {
        let (limit, mark, asked) = (self.timings().answer, self.mark(), Instant::now());
        self.request(RequestKind::Factsheet).await?;
        let is_there = |heard: &super::listener::Listener| {
            heard.log[mark..].iter().any(|entry| super::is_factsheet(&entry.message)).then_some(())
        };
        let came = self.until(limit, is_there).await?;
        let seen = came.map_or("no answer".to_owned(), |()| format!("answered after {}", seconds(asked.elapsed())));
        self.judge(Rule::FactsheetOnRequest, came.is_some(), seen);
        self.ask_births().await?;
        self.ask_status().await
    }

    /// Asks the fleet for births: the robot must answer with its birth and then its factsheet.
    async fn ask_births(&mut self) -> anyhow::Result<()> {
        let (limit, mark, asked) = (BIRTHS_WITHIN + self.timings().answer, self.mark(), Instant::now());
        let boot = self.heard.boot.clone();
        self.request_births().await?;
        let answer = |heard: &super::listener::Listener| {
            let mut after = heard.log[mark..].iter().skip_while(|entry| !is_birth_of(&entry.message, boot.as_ref()));
            after.any(|entry| is_factsheet_of(&entry.message, boot.as_ref())).then_some(())
        };
        let came = self.until(limit, answer).await?;
        let seen = match came {
            Some(()) => format!("answered after {}", seconds(asked.elapsed())),
            None => format!("no ONLINE followed by a factsheet within {}", seconds(limit)),
        };
        self.judge(Rule::BirthOnRequest, came.is_some(), seen);
        Ok(())
    }

    /// Requests a status right after one has arrived: an early next one is the answer.
    async fn ask_status(&mut self) -> anyhow::Result<()> {
        const ASKED: usize = 3;
        let times: Vec<Instant> = self.heard.statuses(0).map(|(_, at)| at).collect();
        let period = mean_gap(&times).unwrap_or(2 * self.timings().status.1);
        if period < TOO_QUICK {
            self.skip(
                &[Rule::StatusOnRequest],
                "statuses are too frequent to distinguish an answer from the next regular one",
            );
            return Ok(());
        }
        let window = self.timings().answer.min(period / 2);
        let mut answered = 0;
        for _ in 0..ASKED {
            let mark = self.mark();
            let patience = (2 * period).min(self.timings().status.1);
            self.until(patience, |heard| heard.statuses(mark).next().map(drop)).await?;
            let mark = self.mark();
            self.request(RequestKind::Status).await?;
            answered += usize::from(self.until(window, |heard| heard.statuses(mark).next().map(drop)).await?.is_some());
        }
        let seen = format!("{answered} of {ASKED} requests were answered within {}", seconds(window));
        self.judge(Rule::StatusOnRequest, answered + 1 >= ASKED, seen);
        Ok(())
    }

    /// Chooses the whisker and the pressures for setpoints; no trial without a whisker.
    ///
    /// # Errors
    /// The requested whisker is not on the factsheet.
    pub(super) async fn choose(&mut self) -> anyhow::Result<()> {
        let Some(factsheet) = self.heard.factsheet.clone() else { return Ok(()) };
        let wanted = self.options.whisker.clone();
        let chosen = whiskers(&factsheet)
            .find(|&(array, whisker)| wanted.as_ref().is_none_or(|wanted| (&wanted.0, wanted.1) == (array, whisker)));
        let Some((array, whisker)) = chosen else {
            return match wanted {
                Some((array, whisker)) => bail!("whisker {array}/{whisker} is not on the factsheet"),
                None => Ok(()),
            };
        };
        let Some(facts) = facts(&factsheet, (array, whisker)) else { return Ok(()) };
        let mut trial = Trial {
            array: array.clone(),
            whisker,
            home_mpa: facts.pressure_mpa,
            away_mpa: facts.pressure_mpa,
            max_mpa: facts.pressure_max_mpa,
        };
        if let Some(status) = self.fresh_status(&trial).await? {
            trial.home_mpa = status.setpoint_mpa;
        }
        let up_mpa = (trial.max_mpa - trial.home_mpa).clamp(0.0, STEP_MPA);
        let down_mpa = trial.home_mpa.clamp(0.0, STEP_MPA);
        trial.away_mpa = if up_mpa >= down_mpa { trial.home_mpa + up_mpa } else { trial.home_mpa - down_mpa };
        self.trial = Some(trial);
        Ok(())
    }
}

/// Whether a message is a birth of this boot.
fn is_birth_of(message: &Message, boot: Option<&BootId>) -> bool {
    matches!(message, Message::Connection(connection)
        if connection.state == ConnectionState::Online && boot.is_none_or(|boot| connection.boot_id == *boot))
}

fn is_factsheet_of(message: &Message, boot: Option<&BootId>) -> bool {
    matches!(message, Message::Factsheet(factsheet) if boot.is_none_or(|boot| factsheet.boot_id == *boot))
}

fn mean_gap(times: &[Instant]) -> Option<Duration> {
    let gaps = u32::try_from(times.len().checked_sub(1)?).ok().filter(|&gaps| gaps > 0)?;
    Some((*times.last()? - *times.first()?) / gaps)
}
