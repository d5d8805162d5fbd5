//! One example of each kind of event, as docs/events.json has them.

use vibrissa_core::policy::Case;
use vibrissa_core::robot::effect::{AlarmKind, CommandState, Condition, EndReason, Reason, TestState};
use vibrissa_edge::events::EventKind;
use vibrissa_edge::words::{Word as _, Words as _};
use vibrissa_store::events::{StoredEvent, VERSION};

use super::*;

const TRIM_ID: i64 = 4_294_967_297;
const COMMAND_ID: &str = "5d0c2a5e-6d0b-5f2f-9c55-0d1c2b7a4e11";

/// The word and the parts of an event of this kind; `None` for the kind that the log never has.
fn example(kind: EventKind) -> Option<(Option<&'static str>, Parts)> {
    let none = Parts::default;
    let leak = AlarmKind::all().into_iter().map(AlarmKind::word).find(|word| *word == "LEAK");
    let setpoint = |state: CommandState| SetpointPart {
        command_id: COMMAND_ID.to_owned(),
        state: OneOf(state),
        pressure_mpa: Some(0.0064),
        reached_mpa: (state == CommandState::Applied).then_some(0.0065),
        rejection: (state == CommandState::Rejected).then_some("OUT_OF_RANGE"),
        compensation_id: (state == CommandState::Pending).then_some(TRIM_ID),
        reason: Some(OneOf(Reason::Compensation(Case::SelfCompensation))),
    };
    let compensation = |end_reason: Option<EndReason>| CompensationPart {
        compensation_id: TRIM_ID,
        case: Some(OneOf(Case::SelfCompensation)),
        compensator_whisker: end_reason.is_none().then_some(2),
        pressure_mpa: end_reason.is_none().then_some(0.0064),
        predicted_error: end_reason.is_none().then_some(0.013),
        end_reason: end_reason.map(OneOf),
    };
    let parts = match kind {
        EventKind::AlarmRaised | EventKind::AlarmCleared => return Some((leak, none())),
        EventKind::Trim => Parts {
            trim: Some(TrimPart {
                trim_id: TRIM_ID,
                length_before_mm: 70.0,
                length_after_mm: 60.4,
                length_after_sd_mm: 0.2,
                contacts_to_detect: 22,
            }),
            ..none()
        },
        EventKind::ConditionChanged => {
            let part = ConditionPart { was: OneOf(Condition::Suspected), becomes: OneOf(Condition::Trimmed) };
            Parts { condition: Some(part), ..none() }
        }
        EventKind::FaultChanged => Parts { fault: Some(FaultPart { was: None, becomes: leak }), ..none() },
        EventKind::WhiskerGone => Parts { gone: Some(GonePart { array: "left".to_owned(), whisker: 2 }), ..none() },
        EventKind::Decision => {
            let candidate = CandidatePart {
                whisker: Some(2),
                case: OneOf(Case::SelfCompensation),
                pressure_mpa: Some(0.0064),
                predicted_error: Some(0.013),
                chosen: true,
                refused: None,
            };
            let part = DecisionPart { compensation_id: TRIM_ID, proposed: false, candidates: vec![candidate] };
            Parts { decision: Some(part), ..none() }
        }
        EventKind::CompensationBegun => Parts { compensation: Some(compensation(None)), ..none() },
        EventKind::CompensationEnded => {
            Parts { compensation: Some(compensation(Some(EndReason::TargetTrimmedAgain))), ..none() }
        }
        EventKind::ProposalEnded => Parts { compensation: Some(compensation(Some(EndReason::Refused))), ..none() },
        EventKind::Setpoint => Parts { setpoint: Some(setpoint(CommandState::Pending)), ..none() },
        EventKind::SetpointState => {
            let parts = Parts { setpoint: Some(setpoint(CommandState::Applied)), ..none() };
            return Some((Some(CommandState::Applied.word()), parts));
        }
        EventKind::SetpointFailed => {
            let parts = Parts { setpoint: Some(setpoint(CommandState::Rejected)), ..none() };
            return Some((Some(CommandState::Rejected.word()), parts));
        }
        EventKind::Error => {
            let (error, error_sd) = (0.012, 0.004);
            let part = ErrorPart { compensation_id: TRIM_ID, contacts: 200, pressure_mpa: 0.0064, error, error_sd };
            Parts { error: Some(part), ..none() }
        }
        EventKind::Refinement => {
            let part = RefinementPart {
                compensation_id: TRIM_ID,
                outcome: "REFINED",
                pressure_from_mpa: 0.0064,
                pressure_best_mpa: Some(0.0071),
            };
            Parts { refinement: Some(part), ..none() }
        }
        EventKind::TouchTest => {
            let state = Some(OneOf(TestState::Running));
            let part = TouchTestPart { test_id: COMMAND_ID.to_owned(), state, touches: 0, missed: 0 };
            Parts { touch_test: Some(part), ..none() }
        }
        EventKind::Action => Parts { action: Some(ActionPart { action_id: 12, state: "DONE" }), ..none() },
        EventKind::Policy => Parts { policy: Some(PolicyPart { version: 3 }), ..none() },
        EventKind::Calibration => {
            let part = CalibrationPart { calibration_id: 2, model: "paper-70".to_owned() };
            Parts { calibration: Some(part), ..none() }
        }
        EventKind::Rollout => {
            let (state, stage) = ("RUNNING".to_owned(), "QUARTER".to_owned());
            Parts { rollout: Some(RolloutPart { rollout_id: 14, state, stage }), ..none() }
        }
        EventKind::Quarantined => {
            let part = QuarantinePart { robot: "crawler".to_owned(), topic: "contacts", cause: "CONSTRAINT" };
            Parts { quarantine: Some(part), ..none() }
        }
        EventKind::Contacts => {
            let contact = ContactPart {
                position: 0,
                array: "left".to_owned(),
                whisker: 2,
                t_us: 1_795_260_000_120_000,
                place: "RATIO",
                ratio: Some(0.8),
                distance_mm: None,
                deflection_mm: 3.1,
                strain: 0.00042,
                pressure_mpa: 0.1,
                temperature_c: 22.5,
                used: "USED",
                residual: Some(0.011),
                length_mm: 69.9,
                length_sd_mm: 0.2,
            };
            let part = ContactsPart { boot_id: "b1".to_owned(), seq: 17, left_out: None, contacts: vec![contact] };
            Parts { contacts: Some(part), ..none() }
        }
        EventKind::AlarmHandled | EventKind::ContactsLeftOut => none(),
        EventKind::Test => return None,
    };
    Some((None, parts))
}

/// The examples, by the word of their kind.
fn examples() -> Vec<serde_json::Value> {
    let examples = EventKind::all().into_iter().zip(1..).map(|(kind, event_id)| {
        let Some((word, parts)) = example(kind) else { return serde_json::to_value(Event::test()).unwrap() };
        let is_of_fleet = matches!(kind, EventKind::Policy | EventKind::Calibration | EventKind::Rollout);
        let is_of_robot = matches!(kind, EventKind::WhiskerGone | EventKind::Contacts | EventKind::ContactsLeftOut);
        let stored = StoredEvent {
            event_id,
            tx: 0,
            recorded_us: 1_795_260_000_000_000,
            version: VERSION,
            kind: kind.word().to_owned(),
            word: word.map(str::to_owned),
            fleet: "lab".to_owned(),
            robot: (!is_of_fleet).then(|| "crawler".to_owned()),
            array: (!is_of_fleet && !is_of_robot).then(|| "left".to_owned()),
            whisker: (!is_of_fleet && !is_of_robot).then_some(2),
            data: serde_json::to_string(&parts).unwrap(),
        };
        serde_json::from_str(&published(&stored)).unwrap()
    });
    let mut examples: Vec<_> = examples.collect();
    if let Some(test) = examples.last_mut() {
        test["timestamp"] = "2026-11-21T12:00:00.000Z".into();
    }
    examples
}

#[test]
fn the_document_says_one_example_of_each_kind() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/events.json");
    let written = serde_json::to_string_pretty(&examples()).unwrap() + "\n";
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        std::fs::write(path, &written).unwrap();
    }
    let there = std::fs::read_to_string(path).unwrap_or_default();
    assert!(there == written, "docs/events.json differs from the code: write it with VIBRISSA_WRITE_DOCS=1");
}

#[test]
fn each_part_of_the_schema_has_an_example() {
    let schema = schema();
    let properties = |name: &str| -> Vec<String> {
        let part = &schema["$defs"][name]["properties"];
        part.as_object().map(|fields| fields.keys().cloned().collect()).unwrap_or_default()
    };
    let known: Vec<String> = [properties("Subject"), properties("Parts")].concat();
    let examples = examples();
    for name in &known {
        assert!(examples.iter().any(|one| one["data"].get(name).is_some()), "no example has {name}");
    }
    for example in &examples {
        let fields = example["data"].as_object().unwrap().keys();
        assert!(fields.into_iter().all(|name| known.contains(name)), "{example}");
    }
}
