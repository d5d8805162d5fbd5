//! Events for programs elsewhere: their kinds, how urgent each is, and which of them a target wants.

use crate::guidance::{Level, of_word};
use crate::words::{Words, named};

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// An alarm was raised.
    AlarmRaised,
    /// The cause of an alarm is gone.
    AlarmCleared,
    /// A trim was detected.
    Trim,
    /// The condition of a whisker has changed.
    ConditionChanged,
    /// A compensation has begun: at once, or because an operator approved it.
    CompensationBegun,
    /// A compensation has ended.
    CompensationEnded,
    /// A setpoint was rejected, failed or expired.
    SetpointFailed,
    /// An operator tests the target; no robot is concerned.
    Test,
}

impl EventKind {
    /// How soon somebody must act on an event of this kind. `word` is the kind of its alarm.
    #[must_use]
    pub fn level(self, word: Option<&str>) -> Level {
        match self {
            Self::AlarmRaised | Self::AlarmCleared => {
                word.and_then(of_word).map_or(Level::Warning, |guidance| guidance.level)
            }
            Self::Trim | Self::SetpointFailed => Level::Urgent,
            Self::ConditionChanged | Self::CompensationBegun | Self::CompensationEnded | Self::Test => Level::Warning,
        }
    }
}

/// The events that a target wants.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interest {
    /// Fleets; `None` for all.
    pub fleets: Option<Vec<String>>,
    /// Kinds of events; `None` for all.
    pub kinds: Option<Vec<EventKind>>,
    /// The least urgent events.
    pub level: Level,
}

impl Interest {
    /// Reads the stored form: words separated by commas. Unknown words stand for nothing.
    #[must_use]
    pub fn stored(fleets: Option<&str>, kinds: Option<&str>, level: &str) -> Self {
        let list = |text: &str| text.split(',').map(ToOwned::to_owned).collect::<Vec<_>>();
        Self {
            fleets: fleets.map(list),
            kinds: kinds.map(|text| text.split(',').filter_map(named).collect()),
            level: named(level).unwrap_or(Level::Warning),
        }
    }

    /// Whether the target wants an event. `word` is the kind of its alarm.
    #[must_use]
    pub fn includes(&self, fleet: &str, kind: EventKind, word: Option<&str>) -> bool {
        self.fleets.as_ref().is_none_or(|fleets| fleets.iter().any(|one| one == fleet))
            && self.kinds.as_ref().is_none_or(|kinds| kinds.contains(&kind))
            && kind.level(word) >= self.level
    }
}

/// Kinds of events that come from robots: all but the test.
#[must_use]
pub fn kinds() -> Vec<EventKind> {
    EventKind::all().into_iter().filter(|kind| *kind != EventKind::Test).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_gets_the_events_of_its_fleets_kinds_and_levels_and_no_others() {
        let all = Interest::stored(None, None, "WARNING");
        assert!(kinds().into_iter().all(|kind| all.includes("a", kind, None)));
        let some = Interest::stored(Some("a,b"), Some("ALARM_RAISED,TRIM"), "URGENT");
        assert!(some.includes("a", EventKind::Trim, None) && some.includes("b", EventKind::AlarmRaised, Some("LEAK")));
        assert!(!some.includes("c", EventKind::Trim, None), "another fleet");
        assert!(!some.includes("a", EventKind::AlarmCleared, Some("LEAK")), "another kind");
        assert!(!some.includes("a", EventKind::AlarmRaised, Some("ERODING")), "less urgent");
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
