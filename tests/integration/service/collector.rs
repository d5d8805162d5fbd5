//! A collector of traces: the part of OTLP (protobuf over HTTP) that the tests need.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use opentelemetry_proto::tonic::collector::trace::v1::{ExportTraceServiceRequest, ExportTraceServiceResponse};
use opentelemetry_proto::tonic::common::v1::{KeyValue, any_value};
use opentelemetry_proto::tonic::trace::v1::{Span as Sent, span::SpanKind, status::StatusCode};
use prost::Message;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};
use vibrissa_tests::wait::until;

/// Attributes as text, by name.
pub(crate) type Attributes = BTreeMap<String, String>;

/// A received span.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    pub(crate) trace: String,
    pub(crate) id: String,
    /// Id of the parent span, empty for a root.
    pub(crate) parent: String,
    pub(crate) name: String,
    pub(crate) kind: SpanKind,
    pub(crate) start_us: u64,
    pub(crate) end_us: u64,
    pub(crate) is_error: bool,
    pub(crate) attributes: Attributes,
    pub(crate) events: Vec<(String, Attributes)>,
    pub(crate) resource: Attributes,
}

/// A collector, stopped on drop.
pub(crate) struct Collector {
    port: u16,
    spans: Arc<Mutex<Vec<Span>>>,
    connections: Arc<AtomicUsize>,
    task: tokio::task::JoinHandle<()>,
}

impl Collector {
    /// Starts a collector that accepts all spans.
    pub(crate) async fn start() -> Self {
        Self::that(true).await
    }

    /// Starts a collector that accepts connections but never answers.
    pub(crate) async fn hanging() -> Self {
        Self::that(false).await
    }

    async fn that(answers: bool) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let (spans, connections) = (Arc::<Mutex<Vec<Span>>>::default(), Arc::new(AtomicUsize::new(0)));
        let (taken, counted) = (spans.clone(), connections.clone());
        let task = tokio::spawn(async move {
            let mut held = Vec::new();
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                counted.fetch_add(1, Ordering::SeqCst);
                if answers {
                    tokio::spawn(serve(stream, taken.clone()));
                } else {
                    held.push(stream);
                }
            }
        });
        Self { port, spans, connections, task }
    }

    /// Value of `traces.otlp_endpoint` for this collector.
    pub(crate) fn endpoint(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// URL to which the exporter sends.
    pub(crate) fn url(&self) -> String {
        format!("{}/v1/traces", self.endpoint())
    }

    /// Number of connections so far.
    pub(crate) fn connections(&self) -> usize {
        self.connections.load(Ordering::SeqCst)
    }

    /// All received spans.
    pub(crate) fn spans(&self) -> Vec<Span> {
        self.spans.lock().unwrap().clone()
    }

    /// Waits for a span that satisfies `is_it` and returns the first one.
    pub(crate) async fn span(&self, what: &str, is_it: impl Fn(&Span) -> bool) -> Span {
        until(&format!("a span: {what}"), async || self.spans().into_iter().find(|span| is_it(span))).await
    }

    /// Waits for the root of a trace; its other spans arrive with it or earlier. Returns the root first, then by time.
    pub(crate) async fn trace(&self, command_id: &str) -> Vec<Span> {
        let id = command_id.replace('-', "");
        self.span("the root of a trace", |span| span.trace == id && span.parent.is_empty()).await;
        let mut spans: Vec<Span> = self.spans().into_iter().filter(|span| span.trace == id).collect();
        spans.sort_by_key(|span| (!span.parent.is_empty(), span.start_us, span.end_us));
        spans
    }
}

impl Drop for Collector {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Accepts requests from one connection until it ends.
async fn serve(stream: TcpStream, spans: Arc<Mutex<Vec<Span>>>) {
    let mut stream = BufReader::new(stream);
    loop {
        let (mut length, mut lines) = (0, Vec::new());
        loop {
            let mut line = String::new();
            if stream.read_line(&mut line).await.unwrap_or(0) == 0 {
                return;
            }
            let line = line.trim_end().to_ascii_lowercase();
            if line.is_empty() {
                break;
            }
            if let Some(value) = line.strip_prefix("content-length:") {
                length = value.trim().parse().unwrap();
            }
            lines.push(line);
        }
        assert_eq!(lines[0], "post /v1/traces http/1.1");
        assert!(lines.iter().any(|line| line == "content-type: application/x-protobuf"), "{lines:?}");
        let mut body = vec![0; length];
        stream.read_exact(&mut body).await.unwrap();
        let request = ExportTraceServiceRequest::decode(&body[..]).unwrap();
        spans.lock().unwrap().extend(taken(request));
        let answer = ExportTraceServiceResponse::default().encode_to_vec();
        let head = format!(
            "HTTP/1.1 200 OK\r\ncontent-type: application/x-protobuf\r\ncontent-length: {}\r\n\r\n",
            answer.len()
        );
        stream.write_all(&[head.as_bytes(), &answer].concat()).await.unwrap();
    }
}

fn taken(request: ExportTraceServiceRequest) -> Vec<Span> {
    let mut spans = Vec::new();
    for of_resource in request.resource_spans {
        let resource = attributes(&of_resource.resource.unwrap().attributes);
        let sent = of_resource.scope_spans.into_iter().flat_map(|of_scope| of_scope.spans);
        spans.extend(sent.map(|sent| span(&sent, &resource)));
    }
    spans
}

fn span(sent: &Sent, resource: &Attributes) -> Span {
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let events = sent.events.iter().map(|event| (event.name.clone(), attributes(&event.attributes)));
    Span {
        trace: hex(&sent.trace_id),
        id: hex(&sent.span_id),
        parent: hex(&sent.parent_span_id),
        name: sent.name.clone(),
        kind: sent.kind(),
        start_us: sent.start_time_unix_nano / 1000,
        end_us: sent.end_time_unix_nano / 1000,
        is_error: sent.status.as_ref().is_some_and(|status| status.code() == StatusCode::Error),
        attributes: attributes(&sent.attributes),
        events: events.collect(),
        resource: resource.clone(),
    }
}

fn attributes(sent: &[KeyValue]) -> Attributes {
    let text = |one: &KeyValue| match one.value.as_ref().and_then(|value| value.value.as_ref()).unwrap() {
        any_value::Value::StringValue(text) => text.clone(),
        any_value::Value::BoolValue(truth) => truth.to_string(),
        any_value::Value::IntValue(number) => number.to_string(),
        any_value::Value::DoubleValue(number) => number.to_string(),
        other => panic!("{other:?}"),
    };
    sent.iter().map(|one| (one.key.clone(), text(one))).collect()
}
