//! Converts operators' actions from their stored form (a word for the kind and a JSON object) to the core's
//! actions.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{LongerForShorter, Mode, PolicyParams};
use vibrissa_core::policy_numbers;
use vibrissa_core::robot::{OperatorAction, Place, Scope};
use vibrissa_protocol::plain;

use crate::words::{Severity, Word, Words, named};

/// Kind of an operator's action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionKind {
    /// Starts a proposed compensation.
    Approve,
    /// Rejects a proposed compensation.
    Refuse,
    /// Sets a pressure by hand.
    Setpoint,
    /// Stops automatic setpoints.
    Hold,
    /// Permits automatic setpoints again.
    Release,
    /// Marks a whisker as replaced by a new one.
    Replaced,
    /// Relearns the baseline of a whisker.
    Rebaseline,
    /// Has the robot measure the length of a whisker by touches.
    TouchTest,
    /// Rejects a proposed touch test.
    RefuseTouchTest,
    /// Tries a failed setpoint again.
    Retry,
    /// Changes the policy of the fleet.
    Policy,
}

impl ActionKind {
    /// All kinds of actions.
    pub const ALL: [Self; 11] = [
        Self::Approve,
        Self::Refuse,
        Self::Setpoint,
        Self::Hold,
        Self::Release,
        Self::Replaced,
        Self::Rebaseline,
        Self::TouchTest,
        Self::RefuseTouchTest,
        Self::Retry,
        Self::Policy,
    ];
}

/// Kind of an action that a supervisor carries out without stepping a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedKind {
    /// Activates a calibration.
    Calibration,
    /// Uploads a calibration.
    CalibrationUpload,
    /// Changes the list of allowed robots.
    AllowedRobots,
    /// Takes a robot out of service.
    Decommission,
    /// Sets a label of a robot.
    LabelSet,
    /// Removes a label of a robot.
    LabelRemove,
    /// Adds a note to a robot.
    NoteAdd,
    /// Removes a note from a robot.
    NoteRemove,
    /// Acknowledges an alarm.
    AlarmAcknowledge,
    /// Silences an alarm until a time.
    AlarmShelve,
    /// Ends the silence of an alarm.
    AlarmUnshelve,
    /// Acknowledges all alarms that meet conditions; each alarm has its own entry beside it.
    AlarmsAcknowledge,
    /// Silences all alarms that meet conditions until a time.
    AlarmsShelve,
    /// Ends the silence of all alarms that meet conditions.
    AlarmsUnshelve,
    /// Sets a window of maintenance.
    MaintenanceSet,
    /// Ends a window of maintenance.
    MaintenanceEnd,
    /// Holds all robots that meet conditions; each robot has its own entry beside it.
    RobotsHold,
    /// Releases all robots that meet conditions.
    RobotsRelease,
    /// Holds all whiskers that meet conditions; each whisker has its own entry beside it.
    WhiskersHold,
    /// Releases all whiskers that meet conditions.
    WhiskersRelease,
    /// Relearns the baselines of all whiskers that meet conditions.
    WhiskersRebaseline,
    /// Changes the policies of all fleets that meet conditions.
    Policies,
    /// Activates a calibration in all fleets that meet conditions.
    Calibrations,
    /// Stops an action on many.
    BulkStop,
    /// Begins a staged roll-out.
    RolloutStart,
    /// Pauses a roll-out.
    RolloutPause,
    /// Resumes a roll-out.
    RolloutResume,
    /// Advances a roll-out to its next stage.
    RolloutAdvance,
    /// Takes the change of a roll-out back.
    RolloutBack,
    /// Creates an API token.
    TokenCreate,
    /// Revokes an API token.
    TokenRevoke,
    /// Creates a webhook.
    WebhookCreate,
    /// Changes a webhook.
    WebhookChange,
    /// Removes a webhook.
    WebhookRemove,
    /// Gives a webhook a new secret.
    WebhookSecret,
    /// Sends a test to a webhook.
    WebhookTest,
    /// Delivers dead letters of a webhook again.
    WebhookRedeliver,
    /// Removes dead letters of a webhook.
    WebhookDiscard,
    /// Signs in at the console with the identity provider.
    SignIn,
    /// Signs out at the console.
    SignOut,
}

impl RecordedKind {
    /// The kinds that the engine of a fleet executes.
    pub const OF_ENGINE: [Self; 7] = [
        Self::Decommission,
        Self::Calibration,
        Self::RolloutStart,
        Self::RolloutPause,
        Self::RolloutResume,
        Self::RolloutAdvance,
        Self::RolloutBack,
    ];
}

/// Kind of an entry of the audit log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AuditKind {
    /// An action that the fleet's engine executes.
    Action(ActionKind),
    /// Any other action.
    Recorded(RecordedKind),
}

impl Word for AuditKind {
    fn word(self) -> &'static str {
        match self {
            Self::Action(kind) => kind.word(),
            Self::Recorded(kind) => kind.word(),
        }
    }
}

impl Words for AuditKind {
    const NAME: &'static str = "AuditKind";

    fn all() -> Vec<Self> {
        let actions = ActionKind::all().into_iter().map(Self::Action);
        actions.chain(RecordedKind::all().into_iter().map(Self::Recorded)).collect()
    }

    fn label(self) -> Option<&'static str> {
        match self {
            Self::Action(kind) => kind.label(),
            Self::Recorded(kind) => kind.label(),
        }
    }

    fn severity(self) -> Option<Severity> {
        None
    }
}

/// The whisker or compensation of an action; the robot is given separately.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Subject<'a> {
    /// Name of the whisker's array; present if `whisker` is.
    pub array: Option<&'a str>,
    /// Number of the whisker in its array.
    pub whisker: Option<u16>,
    /// Number of the compensation on its robot.
    pub compensation: Option<u32>,
}

/// A valid action.
#[derive(Debug, Clone, PartialEq)]
pub enum Request<'a> {
    /// An action on one robot.
    Operator(OperatorAction<'a>),
    /// A change of the fleet's policy.
    Policy(PolicyChange),
}

macro_rules! policy_change {
    ([$($name:ident {
        key: $key:tt, default: $default:tt, min: $min:tt, max: $max:tt, unit: $unit:tt, title: $title:tt, doc: $doc:tt,
    })+]) => {
        /// A change of the policy; absent values stay as they are.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct PolicyChange {
            /// Version of the policy that must be in force; 0 for the policy of the configuration.
            pub expected_version: i64,
            /// Who starts compensations.
            pub mode: Mode,
            /// Quantity that setpoints are solved for.
            pub objective: Option<Objective>,
            /// When a longer whisker may compensate for a shorter one.
            pub longer_for_shorter: Option<LongerForShorter>,
            $(#[doc = $doc] pub $name: Option<f64>,)+
        }

        impl PolicyChange {
            /// The given policy with these changes.
            #[must_use]
            pub fn over(&self, base: PolicyParams) -> PolicyParams {
                PolicyParams {
                    mode: self.mode,
                    objective: self.objective.unwrap_or(base.objective),
                    longer_for_shorter: self.longer_for_shorter.unwrap_or(base.longer_for_shorter),
                    $($name: self.$name.unwrap_or(base.$name),)+
                }
            }
        }

        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct PolicyParameters {
            expected_version: i64,
            mode: String,
            objective: Option<String>,
            longer_for_shorter: Option<String>,
            $($name: Option<f64>,)+
        }

        impl TryFrom<PolicyParameters> for PolicyChange {
            type Error = ActionError;

            fn try_from(parameters: PolicyParameters) -> Result<Self, ActionError> {
                let wrong = |name, range| ActionError::Value { name, range };
                let mode = named(&parameters.mode).ok_or(wrong("mode", "AUTOMATIC or ADVISE"))?;
                let objective = parameters.objective.map(|word| named(&word).ok_or(wrong("objective", "TIP, MEAN or SHAPE")));
                let longer = parameters.longer_for_shorter.map(|word| {
                    named(&word).ok_or(wrong("longer_for_shorter", "NEVER, LAST_RESORT or ALLOWED"))
                });
                $(if parameters.$name.is_some_and(|number| !($min..=$max).contains(&number)) {
                    return Err(wrong(stringify!($name), concat!("a number from ", $min, " to ", $max)));
                })+
                Ok(Self {
                    expected_version: parameters.expected_version,
                    mode,
                    objective: objective.transpose()?,
                    longer_for_shorter: longer.transpose()?,
                    $($name: parameters.$name,)+
                })
            }
        }
    };
}
policy_numbers!(policy_change);

/// Why an action is invalid. The texts are for people.
#[derive(Debug, thiserror::Error)]
pub enum ActionError {
    /// There is no such kind of action.
    #[error("unknown action {0:?}")]
    UnknownKind(String),
    /// The parameters are invalid.
    #[error("invalid parameters of {kind}: {}", plain::data(&source.to_string()))]
    Parameters {
        /// Kind of the action.
        kind: &'static str,
        /// Error of the JSON reader.
        source: serde_json::Error,
    },
    /// The value of a parameter is invalid.
    #[error("{name} must be {range}")]
    Value {
        /// Name of the parameter.
        name: &'static str,
        /// The permitted values.
        range: &'static str,
    },
    /// The action needs another subject.
    #[error("{kind} applies to {what}")]
    Subject {
        /// Kind of the action.
        kind: &'static str,
        /// The subject that it needs.
        what: &'static str,
    },
}

impl ActionError {
    /// One word for the error, for programs.
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

/// Parses an action from the word of its kind and the JSON object of its parameters. Whether the subject exists,
/// and whether a pressure is within the whisker's range, is checked when the action is executed.
///
/// # Errors
/// The action is invalid.
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
        | ActionKind::Rebaseline
        | ActionKind::TouchTest
        | ActionKind::RefuseTouchTest
        | ActionKind::Retry => {
            let Nothing {} = parsed(kind, parameters)?;
            match known {
                ActionKind::Approve => OperatorAction::Approve { compensation: compensation(kind, subject)? },
                ActionKind::Refuse => OperatorAction::Refuse { compensation: compensation(kind, subject)? },
                ActionKind::Hold => OperatorAction::Hold(scope(kind, subject)?),
                ActionKind::Release => OperatorAction::Release(scope(kind, subject)?),
                ActionKind::Replaced => OperatorAction::Replaced(place(kind, subject)?),
                ActionKind::TouchTest => OperatorAction::TouchTest(place(kind, subject)?),
                ActionKind::RefuseTouchTest => OperatorAction::RefuseTouchTest(place(kind, subject)?),
                ActionKind::Retry => OperatorAction::Retry(place(kind, subject)?),
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
    parsed::<PolicyParameters>(kind, parameters)?.try_into()
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
            ("TOUCH_TEST", "{}", WHISKER, OperatorAction::TouchTest(whisker)),
            ("REFUSE_TOUCH_TEST", "{}", WHISKER, OperatorAction::RefuseTouchTest(whisker)),
            ("RETRY", "{}", WHISKER, OperatorAction::Retry(whisker)),
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
            ("POLICY", policy(r#", "objective": "BEST""#), Subject::default(), "TIP, MEAN or SHAPE"),
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
