//! Rules that can be tested only during a restart of the robot.

use std::collections::BTreeSet;

use vibrissa_protocol::{BootId, Connection, ConnectionState, Message, Rule};

use super::action::Action;
use super::assisted::Told;
use super::bench::Bench;
use super::listener::Listener;
use super::report::seconds;
use super::timings::Help;

/// The rules of a restart.
const RULES: [Rule; 4] = [Rule::Will, Rule::WillRetained, Rule::BootIdNew, Rule::SeqFromZero];

impl Bench {
    /// Waits for a restart, and tests its rules.
    pub(super) async fn restart(&mut self, progress: Told<'_>) -> anyhow::Result<()> {
        if self.options.help == Help::None {
            self.skip(&RULES, "requires --restart, and somebody to cut the robot's power and restore it");
            return Ok(());
        }
        let (mark, old, limit) = (self.mark(), self.heard.boot.clone(), self.timings().help);
        let known = boots(&self.heard);
        self.please(progress, Action::CutPower, limit);
        // They may come in either order: a broker that waits for a silent robot publishes its will after its next
        // birth.
        let both = |heard: &Listener| {
            let said = |state| connection(heard, mark, state).map(|(at, _)| at);
            said(ConnectionState::Offline)
                .or(said(ConnectionState::ConnectionBroken).and(said(ConnectionState::Online)))
        };
        self.until(limit, both).await?;
        let broken = connection(&self.heard, mark, ConnectionState::ConnectionBroken);
        let patience = self.timings().status.1 + self.timings().answer;
        let is_back = connection(&self.heard, mark, ConnectionState::Online).is_some();
        let birth = if is_back { self.until(patience, |heard| reporting_birth(heard, mark)).await? } else { None };
        let birth = birth.or_else(|| connection(&self.heard, mark, ConnectionState::Online));
        if connection(&self.heard, mark, ConnectionState::Offline).is_some() {
            self.skip(&RULES, "the robot signed off in good order: its power must be cut");
            return Ok(());
        }
        if broken.is_none() && birth.is_none() {
            self.skip(&RULES, &format!("the robot was not restarted within {}", seconds(limit)));
            return Ok(());
        }
        match &broken {
            Some((_, (will, retained))) => {
                let is_its = Some(&will.boot_id) == old.as_ref();
                let seen = if is_its {
                    "CONNECTION_BROKEN of the boot that ended".to_owned()
                } else {
                    format!("CONNECTION_BROKEN of boot {}, which is not the one that ended", will.boot_id)
                };
                self.judge(Rule::Will, is_its, seen);
                let seen = if *retained { "retained" } else { "without the retain flag" };
                if self.heard.retains {
                    self.judge(Rule::WillRetained, *retained, seen);
                }
            }
            None => {
                self.fail(Rule::Will, "the robot returned without a CONNECTION_BROKEN");
                self.skip(&[Rule::WillRetained], "no will was published");
            }
        }
        self.rebirth(birth, &known).await
    }

    async fn rebirth(
        &mut self,
        birth: Option<(usize, (Connection, bool))>,
        known: &BTreeSet<BootId>,
    ) -> anyhow::Result<()> {
        let Some((at, (birth, _))) = birth else {
            let why = format!("the robot did not return within {}", seconds(self.timings().help));
            self.skip(&RULES, &why);
            return Ok(());
        };
        let is_new = !known.contains(&birth.boot_id);
        let seen = if is_new { "a new boot_id".to_owned() } else { format!("{} again", birth.boot_id) };
        self.judge(Rule::BootIdNew, is_new, seen);
        let limit = self.timings().answer;
        let is_its = |message: &Message| matches!(message, Message::Factsheet(facts) if facts.boot_id == birth.boot_id);
        let follows = |heard: &Listener| heard.log[at..].iter().any(|entry| is_its(&entry.message)).then_some(());
        let came = self.until(limit, follows).await?.is_some();
        let seen = if came {
            "it followed the birth".to_owned()
        } else {
            format!("no factsheet within {} of the birth", seconds(limit))
        };
        self.judge(Rule::FactsheetAfterBirth, came, seen);
        // Waits for the first numbers of the new boot.
        let limit = self.timings().status.1;
        self.until(limit, |heard| heard.statuses(at).next().map(drop)).await?;
        if !is_new {
            self.skip(&[Rule::SeqFromZero], "no new boot was seen");
        }
        Ok(())
    }
}

/// The first birth since `mark` of a boot that sends statuses after it. A robot may introduce earlier boots of which it still
/// has contacts, but statuses are of its present boot only.
pub(super) fn reporting_birth(heard: &Listener, mark: usize) -> Option<(usize, (Connection, bool))> {
    let mut births = heard.connections(mark).filter(|(_, connection, _)| connection.state == ConnectionState::Online);
    let birth = births.find(|(at, birth, _)| heard.statuses(*at).any(|(status, _)| status.boot_id == birth.boot_id));
    birth.map(|(at, birth, is_retained)| (at, (birth.clone(), is_retained)))
}

/// Boots that have introduced themselves.
pub(super) fn boots(heard: &Listener) -> BTreeSet<BootId> {
    heard.connections(0).map(|(_, connection, _)| connection.boot_id.clone()).chain(heard.boot.clone()).collect()
}

/// The first connection message with this state since `mark`: position in the log, content, and retain flag.
pub(super) fn connection(heard: &Listener, mark: usize, state: ConnectionState) -> Option<(usize, (Connection, bool))> {
    let mut all = heard.connections(mark).filter(|(_, connection, _)| connection.state == state);
    all.next().map(|(at, connection, is_retained)| (at, (connection.clone(), is_retained)))
}
