//! Traces received by a collector: one for each setpoint, across supervisors, and one for each request.

use std::path::Path;

use opentelemetry_proto::tonic::trace::v1::span::SpanKind;
use serde_json::json;
use vibrissa_protocol::{ArrayType, Setpoint, SetpointError, SetpointOutcome};
use vibrissa_simulator::clock::now_us;
use vibrissa_supervisor::trace::TraceOptions;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{ended, until, until_true};
use vibrissa_tests::web::send;

use crate::collector::{Collector, Span};
use crate::database::Database;
use crate::program::{Ending, Program};
use crate::running::{LEARNED, Running, database_in};

const BY: &str = "vibrissa.setpoint_state";

fn to(url: String) -> TraceOptions {
    TraceOptions { url, sample_ratio: 1.0 }
}

/// A robot with a whisker that is learned and then cut, and the setpoint that follows. Each contact after the cut is a
/// separate message.
async fn cut(port: u16) -> (HandRobot, Setpoint) {
    let mut robot = HandRobot::born(port, "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.cut(0, 66.0);
    for _ in 0..80 {
        robot.touch(0, 1).await;
    }
    let (setpoint, _) = robot.setpoint().await;
    (robot, setpoint)
}

/// Answers a setpoint and waits until the answer is recorded.
async fn answer(robot: &mut HandRobot, database: &Database, setpoint: &Setpoint, state: SetpointOutcome, word: &str) {
    let error = (state == SetpointOutcome::Rejected).then_some(SetpointError::OutOfRange);
    robot.answer(setpoint, state, error).await;
    let states = "SELECT state FROM setpoints ORDER BY epoch, version";
    until_true(word, async || database.texts(states).await.first().is_some_and(|state| state == word)).await;
}

async fn applied(robot: &mut HandRobot, database: &Database, setpoint: &Setpoint) {
    for (state, word) in [
        (SetpointOutcome::Received, "RECEIVED"),
        (SetpointOutcome::Applying, "APPLYING"),
        (SetpointOutcome::Applied, "APPLIED"),
    ] {
        answer(robot, database, setpoint, state, word).await;
    }
}

/// Names of a trace's spans in order; spans of answers include the state.
fn chain(trace: &[Span]) -> Vec<String> {
    let word = |span: &Span| {
        let state = span.attributes.get(BY).filter(|_| !span.parent.is_empty());
        state.map_or_else(|| span.name.clone(), |state| format!("{} {state}", span.name))
    };
    trace.iter().map(word).collect()
}

/// Every span except the root is a child of the root and within its time. A span that follows from the one before begins
/// after its end.
fn assert_in_order(trace: &[Span]) {
    let (root, children) = trace.split_first().unwrap();
    assert_eq!(root.parent, "");
    for child in children {
        assert_eq!(child.parent, root.id, "{child:#?}");
        assert!(root.start_us <= child.start_us && child.end_us <= root.end_us, "{root:#?} {child:#?}");
    }
    for pair in children.windows(2) {
        let [before, after] = pair else { unreachable!("two") };
        assert!(before.start_us <= after.start_us, "{pair:#?}");
        // A message may be received and processed while a commit is still being written.
        assert!(after.kind == SpanKind::Consumer || before.end_us <= after.start_us, "{pair:#?}");
    }
}

const WHOLE: [&str; 11] = [
    "setpoint SELF_COMPENSATION",
    "process contacts",
    "process contacts",
    "commit",
    "send setpoint",
    "process setpoint_state RECEIVED",
    "commit",
    "process setpoint_state APPLYING",
    "commit",
    "process setpoint_state APPLIED",
    "commit",
];

#[tokio::test]
async fn from_the_contact_that_raised_the_suspicion_to_applied_it_is_one_trace() {
    let collector = Collector::start().await;
    let running = Running::traced(None, to(collector.url())).await;
    let (mut robot, setpoint) = cut(running.port()).await;
    // The setpoint is sent repeatedly until it is answered.
    let database = &running.database;
    applied(&mut robot, database, &setpoint).await;
    let trace = collector.trace(&setpoint.command_id).await;
    // The database shows a state before its commit has ended here.
    let now = now_us();
    let mut spans = chain(&trace);
    spans.dedup_by(|one, before| one == "send setpoint" && before == "send setpoint");
    assert_eq!(spans, WHOLE);
    assert_in_order(&trace);

    // Times of spans agree with the database.
    let [root, suspected, trimmed, ..] = &trace[..] else { panic!("{trace:#?}") };
    let at = async |query| database.number(query).await as u64;
    let suspicion = "SELECT max(recorded_us) FROM health_changes WHERE becomes = 'SUSPECTED'";
    assert_eq!(suspected.start_us, at(suspicion).await);
    assert_eq!(trimmed.start_us, at("SELECT detected_us FROM trims").await);
    let answers = trace.iter().filter(|span| span.name == "process setpoint_state");
    let answers: Vec<String> = answers.map(|span| format!("{} {}", span.attributes[BY], span.start_us)).collect();
    let recorded =
        "SELECT state || ' ' || recorded_us FROM setpoint_states WHERE state <> 'PENDING' ORDER BY setpoint_state_id";
    assert_eq!(answers, database.texts(recorded).await);
    assert_eq!((root.start_us, root.end_us), (suspected.start_us, trace.last().unwrap().end_us));
    assert!(root.end_us <= now, "{root:#?}");

    assert_tells_what_happened(&trace, &setpoint);
    let roots = collector.spans().into_iter().filter(|span| span.name.starts_with("setpoint ")).count();
    assert_eq!(roots, 1);
    assert_eq!(running.metric("vibrissa_trace_spans_dropped_total").await, 0.0);
    running.service.stop().await;
}

fn assert_tells_what_happened(trace: &[Span], setpoint: &Setpoint) {
    let [root, suspected, trimmed, commit, sent, ..] = trace else { panic!("{trace:#?}") };
    for (key, value) in [
        ("vibrissa.command_id", setpoint.command_id.as_str()),
        ("vibrissa.fleet", "f"),
        ("vibrissa.robot", "r"),
        ("vibrissa.array", "left"),
        ("vibrissa.whisker", "0"),
        ("vibrissa.reason", "SELF_COMPENSATION"),
        ("vibrissa.pressure_mpa", &setpoint.pressure_mpa.to_string()),
        (BY, "APPLIED"),
    ] {
        assert_eq!(root.attributes[key], value, "{key}");
    }
    assert!(!root.is_error);
    for (key, value) in [("service.name", "vibrissa"), ("service.instance.id", "s"), ("service.version", "0.2.0")] {
        assert_eq!(root.resource[key], value);
    }
    let of = |span: &Span, name: &str| span.events.iter().find(|event| event.0 == name).unwrap().1.clone();
    let verdict = of(suspected, "condition");
    assert_eq!(verdict["vibrissa.condition"], "SUSPECTED");
    assert!(verdict["vibrissa.standardised_innovation"].parse::<f64>().unwrap() > 0.0, "{verdict:?}");
    let length_mm: f64 = of(trimmed, "trimmed")["vibrissa.length_mm"].parse().unwrap();
    assert!((65.0..67.0).contains(&length_mm), "{length_mm}");
    let decided = of(trimmed, "decided");
    assert_eq!(
        (decided["vibrissa.case"].as_str(), decided["vibrissa.compensator"].as_str()),
        ("SELF_COMPENSATION", "0")
    );
    assert_eq!(decided["vibrissa.pressure_mpa"], setpoint.pressure_mpa.to_string());
    assert_eq!(decided["vibrissa.compensation_id"], root.attributes["vibrissa.compensation_id"]);
    assert_eq!(
        [suspected.kind, trimmed.kind, commit.kind, sent.kind],
        [SpanKind::Consumer, SpanKind::Consumer, SpanKind::Client, SpanKind::Producer]
    );
    assert_eq!(trimmed.attributes["messaging.destination.name"], "whisker/v1/f/r/contacts");
    assert_eq!(sent.attributes["messaging.destination.name"], "whisker/v1/f/r/setpoint");
    assert_eq!(commit.attributes["db.system.name"], "sqlite");
}

#[tokio::test]
async fn after_a_restart_the_same_trace_goes_on_and_has_one_root() {
    let (broker, collector) = (Mosquitto::start(), Collector::start().await);
    let running = Running::traced(Some(broker.port()), to(collector.url())).await;
    let (mut robot, setpoint) = cut(broker.port()).await;
    answer(&mut robot, &running.database, &setpoint, SetpointOutcome::Applying, "APPLYING").await;
    let running = running.traced_again(Some(broker.port()), to(collector.url())).await;
    answer(&mut robot, &running.database, &setpoint, SetpointOutcome::Applied, "APPLIED").await;
    let trace = collector.trace(&setpoint.command_id).await;
    let mut spans = chain(&trace);
    spans.retain(|name| name != "send setpoint");
    assert_eq!(
        spans,
        [
            "setpoint SELF_COMPENSATION",
            "process contacts",
            "process contacts",
            "commit",
            "process setpoint_state APPLYING",
            "commit",
            "hand over",
            "take up",
            "process setpoint_state APPLIED",
            "commit"
        ]
    );
    let (root, children) = trace.split_first().unwrap();
    assert!(children.iter().all(|child| child.parent == root.id), "{trace:#?}");
    // Only the predecessor knew the time of the suspicion; the new owner's trace begins with the decision.
    assert_eq!(root.start_us, children[1].start_us);
    assert_eq!(root.end_us, children.last().unwrap().end_us);
    assert_eq!(root.attributes["vibrissa.command_id"], setpoint.command_id);
    assert_eq!(children.iter().find(|one| one.name == "hand over").unwrap().attributes["vibrissa.ending"], "STOPPED");
    running.service.stop().await;
}

fn program(folder: &Path, port: u16, endpoint: &str) -> Program {
    Program::start_in(folder, port, &[("VIBRISSA_TRACES_OTLP_ENDPOINT", endpoint)])
}

#[tokio::test]
async fn after_the_supervisor_was_killed_the_trace_is_found_under_the_setpoints_name() {
    let (broker, collector) = (Mosquitto::start(), Collector::start().await);
    let folder = tempfile::tempdir().unwrap();
    let path = database_in(&folder);
    let first = program(&path, broker.port(), &collector.endpoint());
    let (mut robot, setpoint) = cut(broker.port()).await;
    let id = setpoint.command_id.replace('-', "");
    collector.span("the setpoint on its way", |span| span.trace == id && span.name == "send setpoint").await;
    first.end(Ending::Killed).await;
    let second = program(&path, broker.port(), &collector.endpoint());
    let database = Database::open(&path).await;
    // The second supervisor accepts an answer once it has sent the setpoint again.
    let again = until("the setpoint again", async || {
        Some(robot.setpoint().await.0).filter(|again| again.boot_id != setpoint.boot_id)
    })
    .await;
    assert_eq!(again.command_id, setpoint.command_id);
    answer(&mut robot, &database, &again, SetpointOutcome::Applied, "APPLIED").await;
    let trace = collector.trace(&setpoint.command_id).await;
    let spans = chain(&trace);
    let place = |name: &str| spans.iter().position(|one| one == name).unwrap_or_else(|| panic!("no {name}: {spans:?}"));
    assert_eq!(place("setpoint SELF_COMPENSATION"), 0);
    assert!(place("process contacts") < place("send setpoint"));
    assert!(place("send setpoint") < place("take up"));
    assert!(place("take up") < place("process setpoint_state APPLIED"));
    assert!(!spans.contains(&"hand over".to_owned()), "{spans:?}");
    assert!(trace[1..].iter().all(|child| child.parent == trace[0].id), "{trace:#?}");
    second.end(Ending::Terminated).await;
}

#[tokio::test]
async fn without_the_setting_nobody_is_told_anything() {
    let (broker, collector) = (Mosquitto::start(), Collector::start().await);
    let folder = tempfile::tempdir().unwrap();
    let path = database_in(&folder);
    let standard = [("OTEL_EXPORTER_OTLP_ENDPOINT", collector.endpoint())];
    let program =
        Program::start_in(&path, broker.port(), &standard.each_ref().map(|(name, url)| (*name, url.as_str())));
    let (mut robot, setpoint) = cut(broker.port()).await;
    applied(&mut robot, &Database::open(&path).await, &setpoint).await;
    program.end(Ending::Terminated).await;
    assert_eq!(collector.connections(), 0);
}

#[tokio::test]
async fn a_collector_that_hangs_keeps_nobody_waiting() {
    let collector = Collector::hanging().await;
    let running = Running::traced(None, to(collector.url())).await;
    let (mut robot, setpoint) = cut(running.port()).await;
    applied(&mut robot, &running.database, &setpoint).await;
    until_true("a connection to the collector", async || collector.connections() > 0).await;
    ended("the service", running.service.stop()).await;
}

#[tokio::test]
async fn what_no_collector_takes_is_counted() {
    let nobody = Collector::start().await.url();
    let running = Running::traced(None, to(nobody)).await;
    let (mut robot, setpoint) = cut(running.port()).await;
    applied(&mut robot, &running.database, &setpoint).await;
    let dropped = "vibrissa_trace_spans_dropped_total";
    until_true("spans dropped", async || running.metric(dropped).await >= WHOLE.len() as f64).await;
    ended("the service", running.service.stop()).await;
}

#[tokio::test]
async fn a_refused_setpoint_is_an_error() {
    let collector = Collector::start().await;
    let running = Running::traced(None, to(collector.url())).await;
    let (mut robot, setpoint) = cut(running.port()).await;
    answer(&mut robot, &running.database, &setpoint, SetpointOutcome::Rejected, "REJECTED").await;
    let trace = collector.trace(&setpoint.command_id).await;
    assert!(trace[0].is_error, "{:#?}", trace[0]);
    assert_eq!(
        (trace[0].attributes[BY].as_str(), trace[0].attributes["error.type"].as_str()),
        ("REJECTED", "OUT_OF_RANGE")
    );
    running.service.stop().await;
}

#[tokio::test]
async fn a_request_goes_on_with_its_callers_trace_and_the_setpoint_names_the_request() {
    let collector = Collector::start().await;
    let running = Running::traced(None, to(collector.url())).await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    let headers =
        [("traceparent", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"), ("x-request-id", "by-hand-7")];
    let path = "/v1/fleets/f/robots/r/arrays/left/whiskers/0/setpoint";
    let body = json!({ "pressure_mpa": 0.05 });
    let answer = send(running.service.http, "POST", path, &headers, Some(&body)).await.unwrap();
    assert_eq!(answer.status, 200, "{}", answer.body);
    let request = collector.span("the request", |span| span.kind == SpanKind::Server).await;
    let route = "/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}/setpoint";
    assert_eq!(request.name, format!("POST {route}"));
    assert_eq!(
        (request.trace.as_str(), request.parent.as_str()),
        ("0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331")
    );
    for (key, value) in [
        ("http.request.method", "POST"),
        ("http.route", route),
        ("http.response.status_code", "200"),
        ("url.path", path),
        ("vibrissa.request_id", "by-hand-7"),
    ] {
        assert_eq!(request.attributes[key], value, "{key}");
    }

    let (setpoint, _) = robot.setpoint().await;
    applied(&mut robot, &running.database, &setpoint).await;
    let trace = collector.trace(&setpoint.command_id).await;
    let (root, first) = (&trace[0], &trace[1]);
    assert_eq!((root.name.as_str(), first.name.as_str()), ("setpoint OPERATOR", "carry out action"));
    assert_in_order(&trace);
    assert_eq!(root.attributes["vibrissa.request_id"], "by-hand-7");
    assert_eq!(root.attributes["vibrissa.action_id"], answer.json()["action_id"].to_string());
    assert_eq!(root.start_us, running.database.number("SELECT asked_us FROM actions").await as u64);
    running.service.stop().await;
}

#[tokio::test]
async fn a_decision_from_which_nothing_follows_has_a_trace_too() {
    let collector = Collector::start().await;
    let running = Running::traced(None, to(collector.url())).await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.cut(0, 45.0);
    robot.touch(0, 80).await;
    let root = collector.span("a decision", |span| span.name == "decision").await;
    let id = running.database.number("SELECT compensation_id FROM compensations").await;
    assert_eq!(root.attributes["vibrissa.compensation_id"], id.to_string());
    let whole = collector.spans().into_iter().filter(|span| span.trace == root.trace).collect::<Vec<_>>();
    let decided = whole.iter().flat_map(|span| &span.events).find(|event| event.0 == "decided").unwrap();
    assert_eq!(decided.1["vibrissa.case"], "NONE");
    running.service.stop().await;
}
