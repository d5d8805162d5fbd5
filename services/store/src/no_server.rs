//! Why no server of the database accepts writes.

use std::time::Duration;

use crate::cause::{for_log, outline};

/// Reason why a server is not used.
#[derive(Debug)]
pub enum Refusal {
    /// It accepts no connection.
    Failed(sqlx::Error),
    /// It does not answer in time.
    NoAnswer(Duration),
    /// It is a standby.
    Standby,
    /// It accepts only reading transactions.
    ReadOnly,
    /// It was the leader before another one that was seen.
    Outdated {
        /// Timeline of the server.
        timeline: i64,
        /// Timeline of the other leader.
        newest: i64,
    },
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Failed(problem) => f.write_str(&for_log(problem)),
            Self::NoAnswer(patience) => write!(f, "no answer in {} s", patience.as_secs_f32()),
            Self::Standby => f.write_str("it is a standby"),
            Self::ReadOnly => f.write_str("it is read-only"),
            Self::Outdated { timeline, newest } => {
                write!(f, "it is a former leader: its timeline is {timeline}, and {newest} was seen")
            }
        }
    }
}

impl Refusal {
    /// The reason without the database's own text.
    fn reason(&self) -> String {
        match self {
            Self::Failed(problem) => outline(problem),
            Self::NoAnswer(_) | Self::Standby | Self::ReadOnly | Self::Outdated { .. } => self.to_string(),
        }
    }
}

/// No server accepts writes: each server with the reason.
#[derive(Debug)]
pub struct NoServer(pub Vec<(String, Refusal)>);

impl std::fmt::Display for NoServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.list(f, Refusal::to_string)
    }
}

impl std::error::Error for NoServer {}

impl NoServer {
    fn list(&self, f: &mut impl std::fmt::Write, text_of: impl Fn(&Refusal) -> String) -> std::fmt::Result {
        f.write_str("no server accepts writes")?;
        let mut mark = ':';
        for (server, refusal) in &self.0 {
            write!(f, "{mark} {server}: {}", text_of(refusal))?;
            mark = ';';
        }
        Ok(())
    }

    /// The text without the database's own.
    pub(crate) fn message(&self) -> String {
        let mut text = String::new();
        // A string accepts all text.
        let _ = self.list(&mut text, Refusal::reason);
        text
    }

    /// Whether a later attempt may succeed at one of the servers, by the errors that pass.
    pub(crate) fn is_passing(&self, passes: impl Fn(&sqlx::Error) -> bool) -> bool {
        self.0.iter().any(|(_, refusal)| match refusal {
            Refusal::Failed(problem) => passes(problem),
            Refusal::NoAnswer(_) | Refusal::Standby | Refusal::ReadOnly | Refusal::Outdated { .. } => true,
        })
    }

    /// The error of the only server, if it accepts no connection.
    pub(crate) fn only_error(mut self) -> Result<sqlx::Error, Self> {
        match self.0.pop() {
            Some((_, Refusal::Failed(problem))) if self.0.is_empty() => Ok(problem),
            last => {
                self.0.extend(last);
                Err(self)
            }
        }
    }
}
