//! Verdict of the core on a case.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_core::robot::effect::{AlarmKind, Effect};
use vibrissa_edge::words::Word;

use super::Class;
use super::cases::{CONTACTS_PER_SECOND, Case};
use crate::world::{START_US, World};

/// Class that a statement assigns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Called {
    /// One of the evaluated classes.
    Class(Class),
    /// A statement that belongs to none of the classes.
    Other(&'static str),
}

impl Called {
    /// Word of the statement.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Class(class) => class.word(),
            Self::Other(word) => word,
        }
    }
}

/// Result of one case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// True class of the case.
    pub truth: Class,
    /// First statement about the affected whisker or array; healthy if there was none.
    pub called: Called,
    /// First statement about an unaffected whisker. If the case concerns no single whisker: the first statement that
    /// differs from `called`.
    pub bystander: Option<Called>,
    /// Number of trims that were reported of whiskers which the case does not cut, or before it cuts them.
    pub wrong_trims: u32,
    /// Contacts of one whisker from the onset to `called`; negative if the statement came before the onset. `None` if
    /// there was no statement.
    pub delay_contacts: Option<f64>,
}

impl Outcome {
    /// Whether the verdict is right, came after the onset, and there was no statement about another whisker.
    #[must_use]
    pub fn is_right(&self) -> bool {
        let is_early = self.delay_contacts.is_some_and(|contacts| contacts < 0.0);
        self.called == Called::Class(self.truth) && !is_early && self.bystander.is_none()
    }
}

/// Runs a case to its end, and compares the core's statements with its truth.
pub(super) fn judge(case: &Case) -> Outcome {
    let mut world = World::new(&case.scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(case.end_s);
    let (mut called, mut bystander, mut delay_contacts, mut wrong_trims) = (None, None, None, 0);
    for (at, effect) in &world.effects {
        let Some((whisker, statement)) = statement(effect) else { continue };
        let is_own = case.whisker == Some(whisker);
        let is_trim = statement == Called::Class(Class::Trim);
        let since_s = (at.0 as f64 - START_US as f64) / 1e6 - case.onset_s;
        wrong_trims += u32::from(is_trim && !(is_own && case.class == Class::Trim && since_s >= 0.0));
        // A shift of the array may be reported for any whisker; in a healthy case no whisker is special.
        let of_all = case.whisker.is_none();
        if is_own || of_all {
            if called.is_none() {
                called = Some(statement);
                delay_contacts = Some(since_s * CONTACTS_PER_SECOND);
            } else if of_all && called != Some(statement) {
                bystander.get_or_insert(statement);
            }
        } else {
            bystander.get_or_insert(statement);
        }
    }
    let called = called.unwrap_or(Called::Class(Class::Healthy));
    Outcome { truth: case.class, called, bystander, wrong_trims, delay_contacts }
}

/// A definite statement about a whisker. Suspicions do not count, nor do consequences of a statement: no whisker can
/// compensate, a leaking chamber does not reach its setpoint, or a compensation waits for approval.
fn statement(effect: &Effect) -> Option<(usize, Called)> {
    match effect {
        Effect::Trim(trim) => Some((trim.whisker, Called::Class(Class::Trim))),
        Effect::Alarm { kind: AlarmKind::Uncompensated | AlarmKind::SetpointFailed | AlarmKind::Proposed, .. } => None,
        Effect::Alarm { whisker, kind } => Some((*whisker, called(kind.word()))),
        _ => None,
    }
}

/// The class of an alarm's word. Two alarms have another word than their class.
fn called(word: &'static str) -> Called {
    match word {
        "ERODING" => Called::Class(Class::Erosion),
        "STALE" => Called::Class(Class::Silent),
        _ => Class::ALL.into_iter().find(|class| class.word() == word).map_or(Called::Other(word), Called::Class),
    }
}
