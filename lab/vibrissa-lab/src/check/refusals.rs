//! Setpoints that a robot must refuse, and malformed messages.
//!
//! Every pressure is harmless: half a step from the present one, or slightly above the robot's limit at a rate so low
//! that a robot which accepts it hardly moves before the setpoint is withdrawn.

use vibrissa_protocol::{BootId, RequestKind, RobotTopic, Rule, Setpoint, SetpointError, SetpointOutcome};

use super::bench::{Bench, Trial, state_text};
use super::setpoints::SLOW_MPA_PER_S;

/// Highest pressure that the paper's chambers withstand.
const CHAMBER_MAX_MPA: f64 = 0.2;
/// Excess of an inadmissible setpoint over the limit.
const ABOVE_MPA: f64 = 0.001;
/// Time since an expired setpoint has expired.
const EXPIRED_US: u64 = 10_000_000;
/// Malformed payloads with their topics.
const MALFORMED: [(RobotTopic, &[u8]); 5] = [
    (RobotTopic::Setpoint, b"{\"boot_id\":\"check\",\"seq\":0,"),
    (RobotTopic::Setpoint, b"{\"boot_id\":\"check\",\"seq\":\"none\",\"pressure_mpa\":\"much\"}"),
    (RobotTopic::Request, b"[]"),
    (RobotTopic::Receipt, b"\xff\xfe\x00"),
    (RobotTopic::Estimate, b"{\"whiskers\":7}"),
];

impl Bench {
    /// Tests the setpoints that a robot must refuse.
    pub(super) async fn refusals(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let near_mpa = f64::midpoint(trial.home_mpa, trial.away_mpa);
        let probe = |bench: &mut Self| Setpoint { slew_mpa_per_s: SLOW_MPA_PER_S, ..bench.setpoint(trial, near_mpa) };

        // After this setpoint the robot has seen its version and all lower ones.
        self.is_away = true;
        self.go_home().await?;
        let newest = probe(self);
        let (seen, older) = (newest.version - 1, newest.version - 2);
        for version in [older, seen] {
            let stale = Setpoint { version, ..probe(self) };
            self.refuse(Rule::RefuseStaleVersion, stale, SetpointError::Stale).await?;
        }
        if self.epoch == 0 {
            self.skip(
                &[Rule::RefuseStaleEpoch],
                "there is no epoch below 0, and no supervisor has owned this fleet yet",
            );
        } else {
            let right = probe(self);
            let stale = Setpoint { epoch: right.epoch - 1, version: right.version + 1_000_000, ..right };
            self.refuse(Rule::RefuseStaleEpoch, stale, SetpointError::Stale).await?;
        }
        let right = probe(self);
        let expired = Setpoint { expires_us: self.heard.robot_clock_us().saturating_sub(EXPIRED_US), ..right };
        self.refuse(Rule::RefuseExpired, expired, SetpointError::Expired).await?;
        let other = Setpoint { robot_boot_id: BootId::new("a-boot-that-never-was")?, ..probe(self) };
        self.refuse(Rule::RefuseWrongBoot, other, SetpointError::WrongBoot).await?;
        let right = probe(self);
        self.refuse_above(trial, right).await?;
        let unknown = Setpoint { whisker: self.unknown_whisker(trial), ..probe(self) };
        self.refuse(Rule::RefuseUnknownWhisker, unknown, SetpointError::UnknownWhisker).await
    }

    async fn refuse_above(&mut self, trial: &Trial, probe: Setpoint) -> anyhow::Result<()> {
        let above_mpa = trial.max_mpa + ABOVE_MPA;
        // If the limit is just below the chamber's, no more than the chamber withstands.
        let pressure_mpa = if trial.max_mpa < CHAMBER_MAX_MPA { above_mpa.min(CHAMBER_MAX_MPA) } else { above_mpa };
        let above = Setpoint { pressure_mpa, ..probe };
        self.refuse(Rule::RefuseOutOfRange, above, SetpointError::OutOfRange).await
    }

    /// A number that no whisker of the array has.
    fn unknown_whisker(&self, trial: &Trial) -> u16 {
        let factsheet = self.heard.factsheet.as_ref();
        let arrays = factsheet.into_iter().flat_map(|factsheet| &factsheet.arrays);
        let numbers = || arrays.clone().filter(|one| one.array == trial.array).flat_map(|one| &one.whiskers);
        (0..=u16::MAX).rev().find(|number| numbers().all(|one| one.whisker != *number)).unwrap_or(u16::MAX)
    }

    /// Sends a setpoint that must be refused for this reason. If the robot accepts it, it is withdrawn at once.
    async fn refuse(&mut self, rule: Rule, setpoint: Setpoint, error: SetpointError) -> anyhow::Result<()> {
        let was_away = self.is_away;
        let mark = self.send(&setpoint).await?;
        let limit = super::report::seconds(self.timings().answer);
        match self.first_answer(mark, &setpoint.command_id).await? {
            None => self.fail(rule, format!("no answer within {limit}")),
            Some(answer) => {
                let is_right = answer.state == SetpointOutcome::Rejected && answer.error == Some(error);
                self.judge(rule, is_right, state_text(&answer));
                if answer.state == SetpointOutcome::Rejected {
                    self.is_away = was_away;
                } else {
                    self.go_home().await?;
                }
            }
        }
        Ok(())
    }

    /// Sends malformed messages, and checks that the robot keeps running.
    pub(super) async fn malformed(&mut self) -> anyhow::Result<()> {
        let boot = self.heard.boot.clone();
        for (topic, payload) in MALFORMED {
            self.say(topic, payload.to_vec(), None).await?;
        }
        self.listen(self.timings().grace).await?;
        let mark = self.mark();
        self.request(RequestKind::Status).await?;
        let limit = self.timings().status.1 + self.timings().answer;
        let goes_on = self.until(limit, |heard| heard.statuses(mark).next().map(drop)).await?.is_some();
        let is_same_boot = self.heard.boot == boot;
        let seen = match (goes_on, is_same_boot) {
            (true, true) => format!("the robot keeps running after {} of them", MALFORMED.len()),
            (true, false) => "the robot restarted".to_owned(),
            (false, _) => format!("no status for {}", super::report::seconds(limit)),
        };
        self.judge(Rule::MalformedHarmless, goes_on && is_same_boot, seen);
        Ok(())
    }
}
