//! One span: its content, and its ids in a trace.

use std::borrow::Cow;
use std::time::{Duration, SystemTime};

use opentelemetry::trace::{Event, SpanContext, SpanId, SpanKind, Status, TraceFlags, TraceId, TraceState};
use opentelemetry::{KeyValue, Value};
use opentelemetry_sdk::trace::{IdGenerator, RandomIdGenerator, SpanData, SpanEvents, SpanLinks};
use uuid::Uuid;
use vibrissa_core::units::Micros;
use vibrissa_edge::clock::wall_clock;

use super::Traces;

/// Content of a span.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    pub(super) name: Cow<'static, str>,
    pub(super) kind: SpanKind,
    pub(super) start: SystemTime,
    pub(super) end: SystemTime,
    pub(super) attributes: Vec<KeyValue>,
    pub(super) events: Vec<Event>,
    pub(super) status: Status,
}

/// Ids of a span in its trace.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpanIds {
    pub(super) trace: TraceId,
    pub(super) span: SpanId,
    /// [`SpanId::INVALID`] for the root of a trace.
    pub(super) parent: SpanId,
}

impl Draft {
    /// A span over a period. If the clock was set back meanwhile, the end is the start.
    pub(super) fn new(
        name: impl Into<Cow<'static, str>>,
        kind: SpanKind,
        (start, end): (SystemTime, SystemTime),
    ) -> Self {
        Self {
            name: name.into(),
            kind,
            start,
            end: end.max(start),
            attributes: Vec::new(),
            events: Vec::new(),
            status: Status::Unset,
        }
    }

    /// Adds an attribute.
    pub(super) fn with(mut self, key: &'static str, value: impl Into<Value>) -> Self {
        self.attributes.push(KeyValue::new(key, value));
        self
    }
}

impl SpanIds {
    /// Root span of the trace of the object with this UUID.
    pub(super) fn root(name: Uuid) -> Self {
        let bytes = name.into_bytes();
        let [.., a, b, c, d, e, f, g, h] = bytes;
        // The second half of a UUID begins with its variant, and is never zero.
        let span = SpanId::from_bytes([a, b, c, d, e, f, g, h]);
        Self { trace: TraceId::from_bytes(bytes), span, parent: SpanId::INVALID }
    }

    /// A new span whose parent is this one.
    pub(super) fn child(self) -> Self {
        Self { span: RandomIdGenerator::default().new_span_id(), parent: self.span, ..self }
    }
}

impl Traces {
    /// Queues a span for export, or drops it if the queue is full.
    pub(super) fn emit(&self, draft: Draft, ids: SpanIds) {
        let mut events = SpanEvents::default();
        events.events = draft.events;
        self.submit(SpanData {
            span_context: SpanContext::new(ids.trace, ids.span, TraceFlags::SAMPLED, false, TraceState::default()),
            parent_span_id: ids.parent,
            parent_span_is_remote: false,
            span_kind: draft.kind,
            name: draft.name,
            start_time: draft.start,
            end_time: draft.end,
            attributes: draft.attributes,
            dropped_attributes_count: 0,
            events,
            links: SpanLinks::default(),
            status: draft.status,
            instrumentation_scope: self.0.scope.clone(),
        });
    }
}

/// The time now by the process's time line, so that no span has the length of a step of the host's clock.
pub(super) fn now() -> SystemTime {
    time(wall_clock())
}

/// Converts a time in µs since 1970.
pub(super) fn time(at: Micros) -> SystemTime {
    SystemTime::UNIX_EPOCH + Duration::from_micros(at.0)
}

/// Attributes with a value; the others are omitted.
pub(super) fn known<const N: usize>(some: [(&'static str, Option<Value>); N]) -> impl Iterator<Item = KeyValue> {
    some.into_iter().filter_map(|(key, value)| Some(KeyValue::new(key, value?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setpoints_trace_has_its_name_and_its_root_is_found_again() {
        let name: Uuid = "6f1d6c0e-41b0-5d83-9a1e-776962726973".parse().unwrap();
        let root = SpanIds::root(name);
        assert_eq!(root.trace.to_string(), name.simple().to_string());
        assert_eq!((root.span, root.parent), (SpanIds::root(name).span, SpanId::INVALID));
        assert_eq!(root.span.to_string(), "9a1e776962726973");
        let (one, other) = (root.child(), root.child());
        assert_eq!((one.trace, one.parent), (root.trace, root.span));
        assert_ne!(one.span, other.span);
    }

    #[test]
    fn a_span_never_ends_before_it_begins() {
        let start = time(Micros(2_000_000));
        let draft = Draft::new("x", SpanKind::Internal, (start, time(Micros(1_000_000))));
        assert_eq!(draft.end, start);
    }
}
