//! What can only be seen while somebody takes the robot's power away and gives it back.

use vibrissa_protocol::{Connection, ConnectionState, Message, Rule};

use super::bench::Bench;
use super::listener::Listener;
use super::log::Entry;
use super::report::seconds;
use super::{Progress, is_factsheet};

/// All that is seen then.
const RULES: [Rule; 4] = [Rule::Will, Rule::WillRetained, Rule::BootIdNew, Rule::SeqFromZero];

impl Bench {
    /// Waits for a restart, and looks at it.
    pub(super) async fn restart(&mut self, progress: &mut (dyn FnMut(Progress) + Send)) -> anyhow::Result<()> {
        if !self.options.restart {
            self.skip(&RULES, "needs --restart, and somebody who takes the robot's power away and gives it back");
            return Ok(());
        }
        let (mark, old, limit) = (self.mark(), self.heard.boot.clone(), self.timings().restart);
        progress(Progress::RestartNow(limit));
        // They may come in either order: a broker that waits for a silent robot gives its will after its next birth.
        let both = |heard: &Listener| {
            let said = |state| connection(heard, mark, state).map(|(at, _)| at);
            said(ConnectionState::Offline)
                .or(said(ConnectionState::ConnectionBroken).and(said(ConnectionState::Online)))
        };
        self.until(limit, both).await?;
        let broken = connection(&self.heard, mark, ConnectionState::ConnectionBroken);
        let birth = connection(&self.heard, mark, ConnectionState::Online);
        if connection(&self.heard, mark, ConnectionState::Offline).is_some() {
            self.skip(&RULES, "the robot left in good order: its power must be taken away");
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
                    "CONNECTION_BROKEN, of the boot that ended".to_owned()
                } else {
                    format!("CONNECTION_BROKEN of boot {}, which is not the one that ended", will.boot_id)
                };
                self.judge(Rule::Will, is_its, seen);
                let seen = if *retained { "retained" } else { "without the retain flag" };
                self.judge(Rule::WillRetained, *retained, seen);
            }
            None => {
                self.fail(Rule::Will, "the robot came back, and no CONNECTION_BROKEN came");
                self.skip(&[Rule::WillRetained], "there was no will");
            }
        }
        self.rebirth(birth, old.as_ref()).await
    }

    async fn rebirth(
        &mut self,
        birth: Option<(usize, (Connection, bool))>,
        old: Option<&vibrissa_protocol::BootId>,
    ) -> anyhow::Result<()> {
        let Some((at, (birth, _))) = birth else {
            let why = format!("the robot did not come back within {}", seconds(self.timings().restart));
            self.skip(&RULES, &why);
            return Ok(());
        };
        let is_new = Some(&birth.boot_id) != old;
        let seen = if is_new { "another one than before".to_owned() } else { format!("{} again", birth.boot_id) };
        self.judge(Rule::BootIdNew, is_new, seen);
        let limit = self.timings().answer;
        let follows = |heard: &Listener| heard.log[at..].iter().any(|entry| is_factsheet(&entry.message)).then_some(());
        let came = self.until(limit, follows).await?.is_some();
        let seen = if came { "it followed".to_owned() } else { format!("none within {} of the birth", seconds(limit)) };
        self.judge(Rule::FactsheetAfterBirth, came, seen);
        // The first numbers of the new boot.
        let limit = self.timings().status.1;
        self.until(limit, |heard| heard.statuses(at).next().map(drop)).await?;
        if !is_new {
            self.skip(&[Rule::SeqFromZero], "no new boot was seen");
        }
        Ok(())
    }
}

/// The first connection message of that state since then: its place in the log, itself, and whether it was to be retained.
fn connection(heard: &Listener, mark: usize, state: ConnectionState) -> Option<(usize, (Connection, bool))> {
    let find = |(at, entry): (usize, &Entry)| match &entry.message {
        Message::Connection(connection) if connection.state == state => {
            Some((mark + at, (connection.clone(), entry.retained)))
        }
        Message::Connection(_)
        | Message::Factsheet(_)
        | Message::Contacts(_)
        | Message::Status(_)
        | Message::SetpointState(_)
        | Message::Receipt(_)
        | Message::Setpoint(_)
        | Message::Request(_)
        | Message::SupervisorState(_) => None,
    };
    heard.log[mark..].iter().enumerate().find_map(find)
}
