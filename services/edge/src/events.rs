//! Events: facts that the database's log keeps for other programs. Their kinds, how urgent each is, and which of them a
//! webhook wants.

use crate::fleets::FleetPattern;
use crate::guidance::{Level, of_word};
use crate::words::{Words, named};

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// An alarm was raised, or still stands at the end of a maintenance.
    AlarmRaised,
    /// The cause of an alarm is gone.
    AlarmCleared,
    /// An operator acknowledged, shelved or unshelved an alarm.
    AlarmHandled,
    /// A trim was detected.
    Trim,
    /// The condition of a whisker has changed.
    ConditionChanged,
    /// The fault of a whisker has changed.
    FaultChanged,
    /// A whisker is not on the robot any more: all its alarms are over.
    WhiskerGone,
    /// The policy has decided about a trimmed whisker.
    Decision,
    /// A compensation has begun: at once, or because an operator approved it.
    CompensationBegun,
    /// A compensation has ended.
    CompensationEnded,
    /// A proposed compensation was withdrawn, or an operator refused it.
    ProposalEnded,
    /// A setpoint was decided.
    Setpoint,
    /// A setpoint has a new state.
    SetpointState,
    /// A setpoint was rejected, failed or expired.
    SetpointFailed,
    /// The error of a compensation was measured.
    Error,
    /// The pressure and the gain of a compensation were evaluated.
    Refinement,
    /// A touch test was requested or proposed, or has a new state.
    TouchTest,
    /// An operator's action has an answer.
    Action,
    /// Another policy is in force.
    Policy,
    /// Another calibration is in force.
    Calibration,
    /// A staged roll-out has a new state.
    Rollout,
    /// A message was put into quarantine.
    Quarantined,
    /// Contacts that a robot reported in one message, and the estimates after them.
    Contacts,
    /// Contacts of a robot are missing from here to its next [`Contacts`](Self::Contacts): too many events waited.
    ContactsLeftOut,
    /// An operator tests a webhook; no robot is concerned.
    Test,
}

impl EventKind {
    /// How soon somebody must act on an event of this kind. `word` is the kind of its alarm.
    #[must_use]
    pub fn level(self, word: Option<&str>) -> Level {
        if matches!(self, Self::AlarmRaised | Self::AlarmCleared) {
            return word.and_then(of_word).map_or(Level::Warning, |guidance| guidance.level);
        }
        if matches!(self, Self::Trim | Self::SetpointFailed) { Level::Urgent } else { Level::Warning }
    }

    /// Whether the event is about contacts, which have a topic of their own.
    #[must_use]
    pub fn is_of_contacts(self) -> bool {
        self.audience() == Audience::Kafka
    }

    /// The readers of events of this kind.
    #[must_use]
    pub fn audience(self) -> Audience {
        match self {
            Self::AlarmRaised
            | Self::AlarmCleared
            | Self::Trim
            | Self::ConditionChanged
            | Self::CompensationBegun
            | Self::CompensationEnded
            | Self::SetpointFailed => Audience::People,
            Self::Contacts | Self::ContactsLeftOut => Audience::Kafka,
            Self::AlarmHandled
            | Self::FaultChanged
            | Self::WhiskerGone
            | Self::Decision
            | Self::ProposalEnded
            | Self::Setpoint
            | Self::SetpointState
            | Self::Error
            | Self::Refinement
            | Self::TouchTest
            | Self::Action
            | Self::Policy
            | Self::Calibration
            | Self::Rollout
            | Self::Quarantined
            | Self::Test => Audience::Programs,
        }
    }
}

/// The readers of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Audience {
    /// Kafka alone: contacts, which are most of the volume.
    Kafka,
    /// Also live pages.
    Programs,
    /// Also webhooks: somebody may have to know.
    People,
}

/// The events that a webhook wants.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interest {
    /// Fleets by names and patterns; `None` for all.
    pub fleets: Option<Vec<FleetPattern>>,
    /// Kinds of events; `None` for all.
    pub kinds: Option<Vec<EventKind>>,
    /// The least urgent events.
    pub level: Level,
}

impl Interest {
    /// Reads the stored form: words separated by commas. Words that are not valid stand for nothing.
    #[must_use]
    pub fn stored(fleets: Option<&str>, kinds: Option<&str>, level: &str) -> Self {
        let list = |text: &str| text.split(',').filter_map(|one| FleetPattern::new(one).ok()).collect();
        Self {
            fleets: fleets.map(list),
            kinds: kinds.map(|text| text.split(',').filter_map(named).collect()),
            level: named(level).unwrap_or(Level::Warning),
        }
    }

    /// Whether the webhook wants an event. `word` is the kind of its alarm.
    #[must_use]
    pub fn includes(&self, fleet: &str, kind: EventKind, word: Option<&str>) -> bool {
        self.fleets.as_ref().is_none_or(|fleets| fleets.iter().any(|one| one.matches(fleet)))
            && self.kinds.as_ref().map_or_else(|| kind.audience() == Audience::People, |kinds| kinds.contains(&kind))
            && kind.level(word) >= self.level
    }
}

/// Kinds of events that webhooks may get.
#[must_use]
pub fn webhook_kinds() -> Vec<EventKind> {
    EventKind::all().into_iter().filter(|kind| kind.audience() == Audience::People).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_gets_the_events_of_its_fleets_kinds_and_levels_and_no_others() {
        let all = Interest::stored(None, None, "WARNING");
        assert!(webhook_kinds().into_iter().all(|kind| all.includes("a", kind, None)));
        assert!(!all.includes("a", EventKind::Setpoint, None), "not for webhooks");
        let some = Interest::stored(Some("a,b"), Some("ALARM_RAISED,TRIM"), "URGENT");
        assert!(some.includes("a", EventKind::Trim, None) && some.includes("b", EventKind::AlarmRaised, Some("LEAK")));
        assert!(!some.includes("c", EventKind::Trim, None), "another fleet");
        assert!(!some.includes("a", EventKind::AlarmCleared, Some("LEAK")), "another kind");
        assert!(!some.includes("a", EventKind::AlarmRaised, Some("ERODING")), "less urgent");
        let halls = Interest::stored(Some("hall-*,lab"), None, "WARNING");
        assert!(["hall-1", "hall-2", "lab"].iter().all(|fleet| halls.includes(fleet, EventKind::Trim, None)));
        assert!(!["hall", "lab-1", "other"].iter().any(|fleet| halls.includes(fleet, EventKind::Trim, None)));
        let critical = Interest::stored(None, None, "CRITICAL");
        assert!(critical.includes("a", EventKind::AlarmRaised, Some("SETPOINT_FAILED")));
        assert!(!critical.includes("a", EventKind::AlarmRaised, Some("LEAK")));
    }

    #[test]
    fn the_level_of_an_alarm_is_that_of_its_guidance() {
        use crate::words::Word as _;
        use vibrissa_core::robot::effect::AlarmKind;
        for kind in AlarmKind::all() {
            assert_eq!(EventKind::AlarmRaised.level(Some(kind.word())), crate::guidance::of(kind).level);
        }
    }
}
