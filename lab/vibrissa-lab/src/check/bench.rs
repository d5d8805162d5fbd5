//! Test bench of a robot: receives its messages, plays its supervisor, and waits for its reactions.

use std::time::Duration;

use anyhow::bail;
use serde::Serialize;
use tokio::time::Instant;
use vibrissa_protocol::{
    BootId, Message, Name, QualityOfService, Receipt, Request, RequestKind, RobotTopic, Rule, Setpoint,
    SetpointOutcome, SetpointReason, SetpointState, SupervisorRequest, SupervisorRequestKind, Timestamp, Topic,
    TouchTest, TouchTestKind, TouchTestReason, encode,
};

use super::CheckOptions;
use super::action::Action;
use super::listener::Listener;
use super::timings::Timings;
use super::touched::Touched;
use vibrissa_edge::clock::wall_clock;
use vibrissa_supervisor::mqtt::TestClient;

/// Validity of a setpoint.
const VALID: Duration = Duration::from_secs(30);
/// Slew rate that every regulator can follow.
const USUAL_SLEW_MPA_PER_S: f64 = 0.02;

/// The whisker on which setpoints are tried.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) array: Name,
    pub(super) whisker: u16,
    /// Its setpoint at the beginning, which is restored at the end.
    pub(super) home_mpa: f64,
    /// Another setpoint nearby, within the range of the factsheet.
    pub(super) away_mpa: f64,
    /// Maximum pressure of the factsheet.
    pub(super) max_mpa: f64,
}

/// A robot on the bench.
pub(super) struct Bench {
    client: TestClient,
    pub(super) options: CheckOptions,
    pub(super) heard: Listener,
    pub(super) epoch: u64,
    pub(super) trial: Option<Trial>,
    /// Whether the chamber may have another setpoint than at the beginning.
    pub(super) is_away: bool,
    /// Actions of the helper that restore what others have changed, and whose effect was not seen yet.
    pub(super) owed: Vec<Action>,
    /// The whisker whose length is wrong in the estimates sent last; `None` if they are right or withdrawn.
    pub(super) wrong_length: Option<Touched>,
    /// Period of statuses without requests, once it is measured.
    pub(super) period: Option<Duration>,
    /// Whether the robot sends contacts again that are not receipted.
    pub(super) is_resending: bool,
    boot_id: BootId,
    /// Next numbers of requests, receipts, setpoints, requests to the fleet, and estimates.
    seqs: [u64; 5],
    version: u64,
    pub(super) commands: u64,
}

impl Bench {
    pub(super) fn new(client: TestClient, options: CheckOptions, boot_id: BootId) -> Self {
        Self {
            client,
            heard: Listener::new(options.timings.clock, options.timings.grace),
            options,
            epoch: 0,
            trial: None,
            is_away: false,
            owed: Vec::new(),
            wrong_length: None,
            period: None,
            is_resending: false,
            boot_id,
            seqs: [0; 5],
            // Higher than versions that a supervisor counts from one, and rising from check to check.
            version: wall_clock().0,
            commands: 0,
        }
    }

    pub(super) fn timings(&self) -> Timings {
        self.options.timings
    }

    /// Present end of the log.
    pub(super) fn mark(&self) -> usize {
        self.heard.log.len()
    }

    /// Waits until `look` finds something; `None` at the time limit.
    ///
    /// # Errors
    /// The connection broke, or a supervisor appeared.
    pub(super) async fn until<T>(
        &mut self,
        limit: Duration,
        mut look: impl FnMut(&Listener) -> Option<T>,
    ) -> anyhow::Result<Option<T>> {
        let deadline = tokio::time::Instant::now() + limit;
        loop {
            if let Some(found) = look(&self.heard) {
                return Ok(Some(found));
            }
            match tokio::time::timeout_at(deadline, self.client.next()).await {
                Ok(said) => self.heard.take(&said?),
                Err(_) => return Ok(None),
            }
            if let Some(epoch) = self.heard.supervised() {
                bail!("a supervisor is ONLINE in fleet {}, in epoch {epoch}", self.options.fleet);
            }
        }
    }

    /// Receives messages for this time.
    pub(super) async fn listen(&mut self, time: Duration) -> anyhow::Result<()> {
        self.until(time, |_| None::<()>).await.map(drop)
    }

    /// Publishes a payload to the robot.
    pub(super) async fn say(&self, kind: RobotTopic, payload: Vec<u8>, expiry: Option<Duration>) -> anyhow::Result<()> {
        let topic = kind.of(&self.options.fleet, &self.options.robot).to_string();
        let expiry_s = expiry.and_then(|time| u32::try_from(time.as_secs()).ok());
        Ok(self.client.publish(topic, payload, kind.quality_of_service(), expiry_s).await?)
    }

    async fn tell(&self, kind: RobotTopic, message: &impl Serialize) -> anyhow::Result<()> {
        let expiry = (kind == RobotTopic::Setpoint).then_some(VALID);
        self.say(kind, encode(message), expiry).await
    }

    fn seq(&mut self, at: usize) -> u64 {
        let seq = self.seqs[at];
        self.seqs[at] += 1;
        seq
    }

    pub(super) async fn request(&mut self, request: RequestKind) -> anyhow::Result<()> {
        let request = Request { boot_id: self.boot_id.clone(), seq: self.seq(0), request, touch_test: None };
        self.tell(RobotTopic::Request, &request).await
    }

    /// Asks all robots of the fleet for their births.
    pub(super) async fn request_births(&mut self) -> anyhow::Result<()> {
        let request = SupervisorRequest {
            boot_id: self.boot_id.clone(),
            seq: self.seq(3),
            epoch: self.epoch,
            timestamp: Timestamp(wall_clock().0),
            request: SupervisorRequestKind::Birth,
        };
        let topic = Topic::SupervisorRequest { fleet: self.options.fleet.clone() }.to_string();
        Ok(self.client.publish(topic, encode(&request), QualityOfService::AtLeastOnce, None).await?)
    }

    /// Boot, number and version of the next estimate.
    pub(super) fn next_estimate(&mut self) -> (BootId, u64, u64) {
        self.version += 1;
        (self.boot_id.clone(), self.seq(4), self.version)
    }

    /// A valid touch test of the whisker on trial with one contact, with the next version.
    pub(super) fn touch_test(&mut self, trial: &Trial, kind: TouchTestKind, near_mm: f64) -> TouchTest {
        self.version += 1;
        self.commands += 1;
        let is_wall = kind == TouchTestKind::Wall;
        TouchTest {
            test_id: format!("{}-{}", self.boot_id, self.commands),
            epoch: self.epoch,
            version: self.version,
            robot_boot_id: self.heard.boot.clone().unwrap_or_else(|| self.boot_id.clone()),
            array: trial.array.clone(),
            whisker: trial.whisker,
            kind,
            distances_mm: if is_wall { vec![near_mm] } else { Vec::new() },
            deflections_mm: if is_wall { vec![1.0] } else { Vec::new() },
            contacts: 1,
            issued: Timestamp(wall_clock().0),
            expires_us: self.heard.robot_clock_us() + VALID.as_micros() as u64,
            reason: TouchTestReason::Operator,
        }
    }

    /// Sends a touch test; returns the log position after which its answers come.
    pub(super) async fn send_test(&mut self, test: TouchTest) -> anyhow::Result<usize> {
        let (boot_id, seq, mark) = (self.boot_id.clone(), self.seq(0), self.mark());
        let request = Request { boot_id, seq, request: RequestKind::TouchTest, touch_test: Some(test) };
        self.say(RobotTopic::Request, encode(&request), Some(VALID)).await?;
        Ok(mark)
    }

    /// Receipts everything below `next`, and the numbers in `held`.
    pub(super) async fn receipt(&mut self, boot: &BootId, next: u64, held: &[u64]) -> anyhow::Result<()> {
        let receipt = Receipt {
            boot_id: self.boot_id.clone(),
            seq: self.seq(1),
            robot_boot_id: boot.clone(),
            next,
            held: held.iter().map(|&seq| (seq, seq)).collect(),
        };
        if let Some(ledger) = self.heard.ledger_mut(boot) {
            ledger.cover(next, held, Instant::now());
        }
        self.tell(RobotTopic::Receipt, &receipt).await
    }

    /// A valid setpoint for the whisker on trial, with the next version.
    pub(super) fn setpoint(&mut self, trial: &Trial, pressure_mpa: f64) -> Setpoint {
        self.version += 1;
        self.commands += 1;
        Setpoint {
            boot_id: self.boot_id.clone(),
            seq: self.seq(2),
            command_id: format!("{}-{}", self.boot_id, self.commands),
            epoch: self.epoch,
            version: self.version,
            robot_boot_id: self.heard.boot.clone().unwrap_or_else(|| self.boot_id.clone()),
            array: trial.array.clone(),
            whisker: trial.whisker,
            pressure_mpa,
            slew_mpa_per_s: USUAL_SLEW_MPA_PER_S,
            issued: Timestamp(wall_clock().0),
            expires_us: self.heard.robot_clock_us() + VALID.as_micros() as u64,
            reason: SetpointReason::Operator,
            gain: Vec::new(),
            reading_gain: None,
        }
    }

    /// The same command in another message.
    pub(super) fn again(&mut self, setpoint: &Setpoint) -> Setpoint {
        Setpoint { seq: self.seq(2), ..setpoint.clone() }
    }

    /// Sends a setpoint; returns the log position after which its answers come.
    pub(super) async fn send(&mut self, setpoint: &Setpoint) -> anyhow::Result<usize> {
        self.is_away = true;
        let mark = self.mark();
        self.tell(RobotTopic::Setpoint, setpoint).await?;
        Ok(mark)
    }

    /// The first answer to a command.
    pub(super) async fn first_answer(&mut self, mark: usize, id: &str) -> anyhow::Result<Option<SetpointState>> {
        self.until(self.timings().answer, |heard| answers(heard, mark, id).first().cloned()).await
    }

    /// A command's final state.
    pub(super) async fn final_answer(&mut self, mark: usize, id: &str) -> anyhow::Result<Option<SetpointState>> {
        let is_final = |state: &SetpointState| state.state.is_final();
        self.until(self.timings().apply, |heard| answers(heard, mark, id).into_iter().find(is_final)).await
    }

    /// Requests a status; the first one received after the request, if one comes.
    pub(super) async fn fresh_status(
        &mut self,
        trial: &Trial,
    ) -> anyhow::Result<Option<vibrissa_protocol::WhiskerStatus>> {
        let mark = self.mark();
        self.request(RequestKind::Status).await?;
        let limit = self.timings().status.1 + self.timings().answer;
        self.until(limit, |heard| heard.newest(mark, (&trial.array, trial.whisker)).map(|(entry, _)| entry)).await
    }

    /// Restores the chamber's first setpoint; whether it was applied.
    pub(super) async fn go_home(&mut self) -> anyhow::Result<bool> {
        let Some(trial) = self.trial.clone().filter(|_| self.is_away) else { return Ok(true) };
        let home = self.setpoint(&trial, trial.home_mpa);
        let mark = self.send(&home).await?;
        let end = self.final_answer(mark, &home.command_id).await?;
        let is_home = end.is_some_and(|state| state.state == SetpointOutcome::Applied);
        self.is_away = !is_home;
        Ok(is_home)
    }

    /// Closes the connection.
    pub(super) async fn close(self) -> Listener {
        self.client.close().await;
        self.heard
    }

    pub(super) fn pass(&mut self, rule: Rule, seen: impl Into<String>) {
        self.heard.findings.pass(rule, seen);
    }

    pub(super) fn fail(&mut self, rule: Rule, seen: impl Into<String>) {
        self.heard.findings.fail(rule, seen);
    }

    pub(super) fn judge(&mut self, rule: Rule, holds: bool, seen: impl Into<String>) {
        self.heard.findings.judge(rule, holds, seen);
    }

    pub(super) fn skip(&mut self, rules: &[Rule], why: &str) {
        self.heard.findings.skip(rules, why);
    }

    pub(super) fn exempt(&mut self, rules: &[Rule], why: &str) {
        self.heard.findings.exempt(rules, why);
    }

    pub(super) fn has_failed(&self, rules: &[Rule]) -> bool {
        rules.iter().any(|&rule| self.heard.findings.has_failed(rule))
    }
}

/// The robot's answers to a command since a position in the log.
pub(super) fn answers(heard: &Listener, mark: usize, id: &str) -> Vec<SetpointState> {
    let mut found = Vec::new();
    for entry in &heard.log[mark..] {
        if let Message::SetpointState(state) = &entry.message
            && state.command_id == id
        {
            found.push(state.clone());
        }
    }
    found
}

/// An answer as text.
pub(super) fn state_text(state: &SetpointState) -> String {
    match state.error {
        Some(error) => format!("{} {error}", state.state),
        None => state.state.to_string(),
    }
}
