//! The end of the robot's program in good order, and its next start.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{Connection, ConnectionState, Rule};

use super::action::Action;
use super::assisted::Told;
use super::bench::Bench;
use super::listener::Listener;
use super::report::seconds;
use super::restart::{boots, connection};

/// Interval in which the check looks whether the statuses have ended.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// How the robot went.
enum Gone {
    /// It signed off; the message, and whether it was published with the retain flag.
    Offline(Connection, bool),
    /// Its last will was published.
    Broken,
    /// Its statuses ended without a word.
    Silently,
    /// It did not go.
    Not,
}

impl Bench {
    /// Tests the farewell, and waits for the next start. Whether the robot is there.
    pub(super) async fn farewell(&mut self, progress: Told<'_>) -> anyhow::Result<bool> {
        let (mark, old, limit) = (self.mark(), self.heard.boot.clone(), self.timings().help);
        self.please(progress, Action::Stop, limit);
        let gone = self.gone(mark, limit).await?;
        match &gone {
            Gone::Offline(offline, is_retained) => {
                // A connection that breaks afterwards leaves the will behind.
                self.listen(self.timings().grace).await?;
                let is_replaced = connection(&self.heard, mark, ConnectionState::ConnectionBroken).is_some();
                let is_its = Some(&offline.boot_id) == old.as_ref();
                let (holds, seen) = match (is_its, *is_retained || !self.heard.retains, is_replaced) {
                    (false, ..) => {
                        (false, format!("OFFLINE of boot {}, which is not the present one", offline.boot_id))
                    }
                    (true, false, _) => (false, "OFFLINE, without the retain flag".to_owned()),
                    (true, true, true) => (false, "OFFLINE, and then CONNECTION_BROKEN".to_owned()),
                    (true, true, false) if self.heard.retains => (true, "OFFLINE, retained".to_owned()),
                    (true, true, false) => (true, "OFFLINE; the broker retains no messages".to_owned()),
                };
                self.judge(Rule::Farewell, holds, seen);
            }
            Gone::Broken => self.fail(Rule::Farewell, "CONNECTION_BROKEN, the last will, and no OFFLINE"),
            Gone::Silently => self.fail(Rule::Farewell, "its statuses ended, and no OFFLINE came"),
            Gone::Not => {
                self.skip(&[Rule::Farewell], &format!("the robot was not stopped within {}", seconds(limit)));
                self.done(&Action::Start);
                return Ok(true);
            }
        }
        self.start_again(progress).await
    }

    async fn gone(&mut self, mark: usize, limit: Duration) -> anyhow::Result<Gone> {
        let silent = self.timings().status.1 + self.timings().answer;
        let begun = Instant::now();
        let went = |heard: &Listener| {
            let offline = connection(heard, mark, ConnectionState::Offline)
                .map(|(_, (one, is_retained))| Gone::Offline(one, is_retained));
            offline.or_else(|| connection(heard, mark, ConnectionState::ConnectionBroken).map(|_| Gone::Broken))
        };
        while begun.elapsed() < limit {
            if let Some(gone) = self.until(LOOK_EVERY, went).await? {
                return Ok(gone);
            }
            let last = self.heard.statuses(0).last().map(|(_, at)| at);
            if self.period.is_some() && last.is_some_and(|at| at.elapsed() > silent) {
                return Ok(Gone::Silently);
            }
        }
        Ok(Gone::Not)
    }

    async fn start_again(&mut self, progress: Told<'_>) -> anyhow::Result<bool> {
        let known = boots(&self.heard);
        let (mark, limit) = (self.mark(), self.timings().help);
        self.please(progress, Action::Start, limit);
        // A robot may introduce earlier boots of which it still has contacts.
        let is_new = |heard: &Listener| heard.boot.as_ref().is_some_and(|boot| !known.contains(boot));
        let started = self.until(limit, |heard| is_new(heard).then_some(())).await?.is_some();
        if !started && connection(&self.heard, mark, ConnectionState::Online).is_none() {
            let note = format!("THE ROBOT WAS NOT STARTED AGAIN within {}", seconds(limit));
            self.heard.findings.note(note);
            return Ok(false);
        }
        self.done(&Action::Start);
        // Waits for the first numbers of the new boot.
        let limit = self.timings().status.1 + self.timings().answer;
        self.until(limit, |heard| heard.statuses(mark).next().map(drop)).await?;
        Ok(true)
    }
}
