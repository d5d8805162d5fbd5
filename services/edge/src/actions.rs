//! What operators ask, as it is stored and sent, becomes the core's actions: a word for the kind, and a JSON object.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{LongerForShorter, Mode, PolicyParams};
use vibrissa_core::robot::{OperatorAction, Place, Scope};

use crate::words::{Word, named};

/// Bounds of the policy's numbers, as in the configuration.
const NUMBER_MAX: f64 = 10.0;

/// The kind of an action that puts a calibration in force.
pub const CALIBRATION: &str = "CALIBRATION";

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionKind {
    /// A proposed compensation shall begin.
    Approve,
    /// A proposed compensation shall not begin.
    Refuse,
    /// A pressure by hand.
    Setpoint,
    /// No automatic setpoints any more.
    Hold,
    /// Automatic setpoints again.
    Release,
    /// A new whisker is in the place of the old one.
    Replaced,
    /// A whisker's readings are learned anew.
    Rebaseline,
    /// Another policy for the fleet.
    Policy,
}

impl ActionKind {
    /// Every kind.
    pub const ALL: [Self; 8] = [
        Self::Approve,
        Self::Refuse,
        Self::Setpoint,
        Self::Hold,
        Self::Release,
        Self::Replaced,
        Self::Rebaseline,
        Self::Policy,
    ];
}

/// What an action is about, besides the robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Subject<'a> {
    /// A whisker's array; with `whisker` or not at all.
    pub array: Option<&'a str>,
    /// A whisker's number.
    pub whisker: Option<u16>,
    /// A compensation's number on its robot.
    pub compensation: Option<u32>,
}

/// An action that can be carried out.
#[derive(Debug, Clone, PartialEq)]
pub enum Request<'a> {
    /// Of one robot.
    Operator(OperatorAction<'a>),
    /// Of the whole fleet.
    Policy(PolicyChange),
}

/// Another policy; what it does not say stays as it is in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolicyChange {
    /// The version that must be in force for this to be done; 0 while it is the configuration's.
    pub expected_version: i64,
    /// Who says that compensations begin.
    pub mode: Mode,
    /// What a setpoint is solved for.
    pub objective: Option<Objective>,
    /// When a longer whisker may stand in for a shorter one.
    pub longer_for_shorter: Option<LongerForShorter>,
    /// Highest mean predicted error, as a ratio, 0 to 10.
    pub predicted_error_max: Option<f64>,
    /// Cost of a neighbour's own role, in units of mean error, 0 to 10.
    pub own_role_cost: Option<f64>,
    /// Gain that a change of assignment must have, in units of mean error, 0 to 10.
    pub change_margin: Option<f64>,
}

impl PolicyChange {
    /// The policy that it makes of the one in force.
    #[must_use]
    pub fn over(&self, base: PolicyParams) -> PolicyParams {
        PolicyParams {
            mode: self.mode,
            objective: self.objective.unwrap_or(base.objective),
            longer_for_shorter: self.longer_for_shorter.unwrap_or(base.longer_for_shorter),
            predicted_error_max: self.predicted_error_max.unwrap_or(base.predicted_error_max),
            own_role_cost: self.own_role_cost.unwrap_or(base.own_role_cost),
            change_margin: self.change_margin.unwrap_or(base.change_margin),
        }
    }
}

/// Why an action cannot even be understood. The texts are for people.
#[derive(Debug, thiserror::Error)]
pub enum ActionError {
    /// No such kind.
    #[error("no action is called {0:?}")]
    UnknownKind(String),
    /// Its parameters.
    #[error("the parameters of {kind} are not as they must be: {source}")]
    Parameters {
        /// The kind.
        kind: &'static str,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A parameter's value.
    #[error("{name} must be {range}")]
    Value {
        /// Which parameter.
        name: &'static str,
        /// What is allowed.
        range: &'static str,
    },
    /// Something is missing that it is about, or is too much.
    #[error("{kind} is about {what}")]
    Subject {
        /// The kind.
        kind: &'static str,
        /// What it is about.
        what: &'static str,
    },
}

impl ActionError {
    /// One word for programs.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::UnknownKind(_) => "UNKNOWN_KIND",
            Self::Parameters { .. } | Self::Value { .. } | Self::Subject { .. } => "MALFORMED",
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetpointParameters {
    pressure_mpa: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PolicyParameters {
    expected_version: i64,
    mode: String,
    objective: Option<String>,
    longer_for_shorter: Option<String>,
    predicted_error_max: Option<f64>,
    own_role_cost: Option<f64>,
    change_margin: Option<f64>,
}

/// What is asked, from the kind's word and the JSON object of its parameters. Pressures are held against the whisker's
/// range when it is carried out, and whether anything of that name is there is seen then.
///
/// # Errors
/// It cannot be understood.
pub fn request<'a>(kind: &str, parameters: &str, subject: Subject<'a>) -> Result<Request<'a>, ActionError> {
    let known = named::<ActionKind>(kind).ok_or_else(|| ActionError::UnknownKind(kind.to_owned()))?;
    let kind = known.word();
    Ok(Request::Operator(match known {
        ActionKind::Setpoint => {
            let SetpointParameters { pressure_mpa } = parsed(kind, parameters)?;
            OperatorAction::Setpoint { whisker: place(kind, subject)?, pressure_mpa }
        }
        ActionKind::Policy => return policy(kind, parameters, subject).map(Request::Policy),
        ActionKind::Approve
        | ActionKind::Refuse
        | ActionKind::Hold
        | ActionKind::Release
        | ActionKind::Replaced
        | ActionKind::Rebaseline => {
            let Nothing {} = parsed(kind, parameters)?;
            match known {
                ActionKind::Approve => OperatorAction::Approve { compensation: compensation(kind, subject)? },
                ActionKind::Refuse => OperatorAction::Refuse { compensation: compensation(kind, subject)? },
                ActionKind::Hold => OperatorAction::Hold(scope(kind, subject)?),
                ActionKind::Release => OperatorAction::Release(scope(kind, subject)?),
                ActionKind::Replaced => OperatorAction::Replaced(place(kind, subject)?),
                ActionKind::Rebaseline | ActionKind::Setpoint | ActionKind::Policy => {
                    OperatorAction::Rebaseline(place(kind, subject)?)
                }
            }
        }
    }))
}

fn parsed<T: DeserializeOwned>(kind: &'static str, parameters: &str) -> Result<T, ActionError> {
    serde_json::from_str(parameters).map_err(|source| ActionError::Parameters { kind, source })
}

fn place<'a>(kind: &'static str, subject: Subject<'a>) -> Result<Place<'a>, ActionError> {
    match subject {
        Subject { array: Some(array), whisker: Some(whisker), compensation: None } => Ok(Place { array, whisker }),
        Subject { .. } => Err(ActionError::Subject { kind, what: "a whisker: its array and its number" }),
    }
}

fn scope<'a>(kind: &'static str, subject: Subject<'a>) -> Result<Scope<'a>, ActionError> {
    if subject == Subject::default() { Ok(Scope::Robot) } else { place(kind, subject).map(Scope::Whisker) }
}

fn compensation(kind: &'static str, subject: Subject<'_>) -> Result<u32, ActionError> {
    subject.compensation.ok_or(ActionError::Subject { kind, what: "a compensation" })
}

fn policy(kind: &'static str, parameters: &str, subject: Subject<'_>) -> Result<PolicyChange, ActionError> {
    if subject != Subject::default() {
        return Err(ActionError::Subject { kind, what: "a whole fleet" });
    }
    let told: PolicyParameters = parsed(kind, parameters)?;
    let mode = mode(&told.mode).ok_or(ActionError::Value { name: "mode", range: "AUTOMATIC or ADVISE" })?;
    let wrong = |name, range| ActionError::Value { name, range };
    let objective = told.objective.map(|word| objective(&word).ok_or(wrong("objective", "TIP or MEAN")));
    let longer = told
        .longer_for_shorter
        .map(|word| longer_for_shorter(&word).ok_or(wrong("longer_for_shorter", "NEVER, LAST_RESORT or ALLOWED")));
    let number = |name, value: Option<f64>| match value {
        Some(number) if !(0.0..=NUMBER_MAX).contains(&number) => Err(wrong(name, "a number from 0 to 10")),
        known => Ok(known),
    };
    Ok(PolicyChange {
        expected_version: told.expected_version,
        mode,
        objective: objective.transpose()?,
        longer_for_shorter: longer.transpose()?,
        predicted_error_max: number("predicted_error_max", told.predicted_error_max)?,
        own_role_cost: number("own_role_cost", told.own_role_cost)?,
        change_margin: number("change_margin", told.change_margin)?,
    })
}

/// The mode of that name.
#[must_use]
pub fn mode(word: &str) -> Option<Mode> {
    named(word)
}

/// The objective of that name.
#[must_use]
pub fn objective(word: &str) -> Option<Objective> {
    named(word)
}

/// That answer to when a longer whisker may stand in for a shorter one.
#[must_use]
pub fn longer_for_shorter(word: &str) -> Option<LongerForShorter> {
    named(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHISKER: Subject<'_> = Subject { array: Some("left"), whisker: Some(3), compensation: None };
    const COMPENSATION: Subject<'_> = Subject { array: None, whisker: None, compensation: Some(7) };

    #[test]
    fn every_kind_becomes_its_action() {
        let whisker = Place { array: "left", whisker: 3 };
        let expected = [
            ("APPROVE", "{}", COMPENSATION, OperatorAction::Approve { compensation: 7 }),
            ("REFUSE", "{}", COMPENSATION, OperatorAction::Refuse { compensation: 7 }),
            (
                "SETPOINT",
                r#"{"pressure_mpa": 0.12}"#,
                WHISKER,
                OperatorAction::Setpoint { whisker, pressure_mpa: 0.12 },
            ),
            ("HOLD", "{}", WHISKER, OperatorAction::Hold(Scope::Whisker(whisker))),
            ("HOLD", "{}", Subject::default(), OperatorAction::Hold(Scope::Robot)),
            ("RELEASE", "{}", Subject::default(), OperatorAction::Release(Scope::Robot)),
            ("REPLACED", "{}", WHISKER, OperatorAction::Replaced(whisker)),
            ("REBASELINE", "{}", WHISKER, OperatorAction::Rebaseline(whisker)),
        ];
        for (kind, parameters, subject, action) in expected {
            let asked = request(kind, parameters, subject).unwrap_or_else(|problem| panic!("{kind}: {problem}"));
            assert_eq!(asked, Request::Operator(action));
        }
    }

    #[test]
    fn a_policy_changes_what_it_says_and_nothing_else() {
        let text = r#"{"expected_version": 4, "mode": "ADVISE", "objective": "MEAN", "change_margin": 0.3}"#;
        let Ok(Request::Policy(change)) = request("POLICY", text, Subject::default()) else { panic!("a policy") };
        let base = PolicyParams { own_role_cost: 0.7, ..PolicyParams::default() };
        let expected = PolicyParams {
            mode: Mode::Advise,
            objective: Objective::Mean,
            change_margin: 0.3,
            own_role_cost: 0.7,
            ..base
        };
        assert_eq!((change.expected_version, change.over(base)), (4, expected));
    }

    #[test]
    fn what_is_not_understood_is_refused_by_name() {
        let policy = |more: &str| format!(r#"{{"expected_version": 0, "mode": "ADVISE"{more}}}"#);
        let refused = [
            ("BOOM", "{}".to_owned(), WHISKER, "\"BOOM\""),
            ("SETPOINT", "{}".to_owned(), WHISKER, "pressure_mpa"),
            ("SETPOINT", r#"{"pressure_mpa": 0.1, "now": true}"#.to_owned(), WHISKER, "now"),
            ("HOLD", r#"{"for_s": 3}"#.to_owned(), WHISKER, "for_s"),
            ("HOLD", "{}".to_owned(), COMPENSATION, "a whisker"),
            ("REPLACED", "{}".to_owned(), Subject::default(), "a whisker"),
            ("APPROVE", "{}".to_owned(), WHISKER, "a compensation"),
            ("POLICY", r#"{"mode": "ADVISE"}"#.to_owned(), Subject::default(), "expected_version"),
            ("POLICY", policy(r#", "objective": "BEST""#), Subject::default(), "TIP or MEAN"),
            ("POLICY", policy(r#", "own_role_cost": 10.5"#), Subject::default(), "own_role_cost"),
            ("POLICY", policy(r#", "change_margin": -1"#), Subject::default(), "change_margin"),
            ("POLICY", policy(""), WHISKER, "a whole fleet"),
        ];
        for (kind, parameters, subject, part) in refused {
            let problem = request(kind, &parameters, subject).expect_err(&parameters).to_string();
            assert!(problem.contains(part), "{kind} {parameters}: {problem}");
        }
    }
}
