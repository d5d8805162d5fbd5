//! Rules that can be tested only during a restart of the robot.

use vibrissa_protocol::{BootId, Connection, ConnectionState, Rule};

use super::action::Action;
use super::assisted::Told;
use super::bench::Bench;
use super::is_factsheet;
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
        let birth = new_birth(&self.heard, mark, old.as_ref());
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
        self.rebirth(birth, old.as_ref()).await
    }

    async fn rebirth(
        &mut self,
        birth: Option<(usize, (Connection, bool))>,
        old: Option<&BootId>,
    ) -> anyhow::Result<()> {
        let Some((at, (birth, _))) = birth else {
            let why = format!("the robot did not return within {}", seconds(self.timings().help));
            self.skip(&RULES, &why);
            return Ok(());
        };
        let is_new = Some(&birth.boot_id) != old;
        let seen = if is_new { "a new boot_id".to_owned() } else { format!("{} again", birth.boot_id) };
        self.judge(Rule::BootIdNew, is_new, seen);
        let limit = self.timings().answer;
        let follows = |heard: &Listener| heard.log[at..].iter().any(|entry| is_factsheet(&entry.message)).then_some(());
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

/// The birth of another boot since `mark`, or else any birth: a robot may introduce earlier boots of which it still has
/// contacts.
fn new_birth(heard: &Listener, mark: usize, old: Option<&BootId>) -> Option<(usize, (Connection, bool))> {
    let mut from = mark;
    while let Some(birth) = connection(heard, from, ConnectionState::Online) {
        if Some(&birth.1.0.boot_id) != old {
            return Some(birth);
        }
        from = birth.0 + 1;
    }
    connection(heard, mark, ConnectionState::Online)
}

/// The first connection message with this state since `mark`: position in the log, content, and retain flag.
pub(super) fn connection(heard: &Listener, mark: usize, state: ConnectionState) -> Option<(usize, (Connection, bool))> {
    let mut all = heard.connections(mark).filter(|(_, connection, _)| connection.state == state);
    all.next().map(|(at, connection, is_retained)| (at, (connection.clone(), is_retained)))
}
