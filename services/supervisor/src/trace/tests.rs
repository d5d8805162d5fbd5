use std::sync::Mutex;

use opentelemetry::trace::Status;
use opentelemetry_sdk::error::OTelSdkResult;
use vibrissa_core::robot::effect::{Asked, Command, CommandKey, CommandState, Effect, Reason};
use vibrissa_core::robot::{Event, Numbers, Robot};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_protocol::Name;

use super::*;
use crate::ending::Ending;

/// Collects the exported spans.
#[derive(Debug, Clone, Default)]
struct Kept(Arc<Mutex<Vec<SpanData>>>);

impl SpanExporter for Kept {
    async fn export(&self, batch: Vec<SpanData>) -> OTelSdkResult {
        self.0.lock().unwrap().extend(batch);
        Ok(())
    }
}

fn kept() -> (Traces, Kept) {
    let kept = Kept::default();
    let traces = Traces(Arc::new(Inner {
        processor: processor(kept.clone()),
        scope: InstrumentationScope::default(),
        queued: Arc::default(),
        dropped: IntCounter::new("dropped", "spans").unwrap(),
        sample_ratio: 1.0,
        database: "sqlite",
    }));
    (traces, kept)
}

/// Names of the spans exported so far.
fn exported(traces: &Traces, kept: &Kept) -> Vec<String> {
    traces.0.processor.force_flush().unwrap();
    kept.0.lock().unwrap().iter().map(|span| span.name.to_string()).collect()
}

const KEY: CommandKey = CommandKey { epoch: 1, version: 7 };

fn command() -> Effect {
    Effect::Command(Box::new(Command {
        key: KEY,
        whisker: 0,
        robot_boot_id: "b".to_owned(),
        pressure: Megapascal::known(0.05),
        slew_mpa_per_s: 0.02,
        issued: Micros(1_000_000),
        expires: Micros(9_000_000),
        reason: Reason::Refinement,
        compensation: None,
        gain: None,
    }))
}

fn step(open_traces: &mut OpenTraces, effect: Effect) {
    let (fleet, name) = (Name::new("f").unwrap(), Name::robot("r").unwrap());
    let robot = Robot::new(1, Numbers::default());
    let (now, event, effects) = (Micros(1_000_000), &Event::Tick, &[effect]);
    assert!(is_traced(effects));
    open_traces.stepped(&Step { fleet: &fleet, name: &name, robot_id: 1, robot: &robot, now, event, effects });
}

fn commit(open_traces: &mut OpenTraces) {
    let mut pending = open_traces.seal();
    open_traces.committed(&mut pending, Duration::ZERO);
}

#[test]
fn nothing_is_told_that_is_not_committed() {
    let (traces, kept) = kept();
    let mut open_traces = OpenTraces::new(traces.clone(), Name::new("f").unwrap());
    step(&mut open_traces, command());
    assert_eq!(exported(&traces, &kept), [""; 0]);
    open_traces.end(Ending::LeaseLost);
    assert_eq!(exported(&traces, &kept), [""; 0]);
}

#[test]
fn a_setpoint_that_is_given_away_has_no_root_yet() {
    let (traces, kept) = kept();
    let mut open_traces = OpenTraces::new(traces.clone(), Name::new("f").unwrap());
    step(&mut open_traces, command());
    commit(&mut open_traces);
    open_traces.end(Ending::LeaseLost);
    assert_eq!(exported(&traces, &kept), ["tick", "commit", "hand over"]);
}

#[test]
fn a_setpoint_that_expires_is_an_error_and_its_trace_is_over() {
    let (traces, kept) = kept();
    let mut open_traces = OpenTraces::new(traces.clone(), Name::new("f").unwrap());
    step(&mut open_traces, command());
    commit(&mut open_traces);
    let state = CommandState::Expired;
    step(
        &mut open_traces,
        Effect::CommandState {
            command: KEY,
            whisker: None,
            asked: Asked { pressure: Megapascal::new(0.1).unwrap(), reason: Reason::Refinement },
            state,
            rejection: None,
            pressure: None,
        },
    );
    commit(&mut open_traces);
    open_traces.end(Ending::Stopped);
    assert_eq!(exported(&traces, &kept), ["tick", "commit", "tick", "commit", "setpoint REFINEMENT"]);
    let spans = kept.0.lock().unwrap();
    let root = spans.last().unwrap();
    assert_eq!(root.status, Status::error("EXPIRED"));
    assert!(spans[..4].iter().all(|span| span.parent_span_id == root.span_context.span_id()));
}

#[test]
fn beyond_its_bound_the_queue_drops_and_counts() {
    let (traces, kept) = kept();
    let root = span::SpanIds::root(uuid::Uuid::from_u128(1 << 64 | 1));
    for _ in 0..QUEUE_SPANS + 10 {
        let now = span::now();
        traces.emit(span::Draft::new("x", opentelemetry::trace::SpanKind::Internal, (now, now)), root.child());
    }
    assert_eq!(traces.0.dropped.get(), 10);
    assert_eq!(exported(&traces, &kept).len(), QUEUE_SPANS);
}
