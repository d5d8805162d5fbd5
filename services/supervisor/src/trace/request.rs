//! Spans of HTTP requests.

use axum::extract::{MatchedPath, Request};
use axum::http::{HeaderMap, Method, StatusCode};
use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::{SpanId, SpanKind, Status, TraceContextExt};
use opentelemetry_http::HeaderExtractor;
use opentelemetry_sdk::propagation::TraceContextPropagator;
use opentelemetry_sdk::trace::{IdGenerator, RandomIdGenerator};

use super::Traces;
use super::span::{Draft, SpanIds, now};

/// Paths polled by machines, which are never traced.
const NOT_TOLD: [&str; 3] = ["/livez", "/readyz", "/metrics"];

/// The span of a request that is being handled.
pub(crate) struct RequestSpan {
    traces: Traces,
    draft: Draft,
    ids: SpanIds,
}

impl Traces {
    /// Begins the span of a request; `None` if the request is not traced.
    pub(crate) fn request(&self, request: &Request, id: &str) -> Option<RequestSpan> {
        let (path, method) = (request.uri().path(), request.method());
        if NOT_TOLD.contains(&path) {
            return None;
        }
        let ids = span_ids(request.headers(), method, self.0.sample_ratio)?;
        let route = request.extensions().get::<MatchedPath>().map(MatchedPath::as_str);
        let word = standard(method);
        let name = route.map_or_else(|| word.to_owned(), |route| format!("{word} {route}"));
        let began = now();
        let mut draft = Draft::new(name, SpanKind::Server, (began, began))
            .with("http.request.method", word.to_owned())
            .with("url.path", path.to_owned())
            .with("vibrissa.request_id", id.to_owned());
        if let Some(route) = route {
            draft = draft.with("http.route", route.to_owned());
        }
        Some(RequestSpan { traces: self.clone(), draft, ids })
    }
}

impl RequestSpan {
    /// Ends the span when the response begins.
    pub(crate) fn answered(self, status: StatusCode) {
        let mut draft = self.draft.with("http.response.status_code", i64::from(status.as_u16()));
        draft.end = now().max(draft.start);
        if status.is_server_error() {
            draft = draft.with("error.type", status.as_u16().to_string());
            draft.status = Status::error("");
        }
        self.traces.emit(draft, self.ids);
    }
}

/// Ids of the request's span: in the caller's trace, if there is one, or else in a new trace. `None` if the trace is
/// not sampled.
fn span_ids(headers: &HeaderMap, method: &Method, sample_ratio: f64) -> Option<SpanIds> {
    let new = RandomIdGenerator::default();
    let parent = TraceContextPropagator::new().extract(&HeaderExtractor(headers));
    let parent = parent.span().span_context().clone();
    if parent.is_valid() {
        let ids = SpanIds { trace: parent.trace_id(), span: new.new_span_id(), parent: parent.span_id() };
        return parent.is_sampled().then_some(ids);
    }
    let trace = new.new_trace_id();
    let [.., a, b, c, d] = trace.to_bytes();
    let share = f64::from(u32::from_be_bytes([a, b, c, d])) / (f64::from(u32::MAX) + 1.0);
    let is_sampled = !method.is_safe() || share < sample_ratio;
    is_sampled.then(|| SpanIds { trace, span: new.new_span_id(), parent: SpanId::INVALID })
}

/// The method as OpenTelemetry's semantic conventions write it.
fn standard(method: &Method) -> &str {
    const STANDARD: [Method; 9] = [
        Method::GET,
        Method::POST,
        Method::PUT,
        Method::DELETE,
        Method::PATCH,
        Method::HEAD,
        Method::OPTIONS,
        Method::CONNECT,
        Method::TRACE,
    ];
    if STANDARD.contains(method) { method.as_str() } else { "_OTHER" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(traceparent: &str) -> HeaderMap {
        HeaderMap::from_iter([("traceparent".parse().unwrap(), traceparent.parse().unwrap())])
    }

    #[test]
    fn a_callers_trace_is_gone_on_with_and_its_wish_not_to_be_traced_respected() {
        // The example in the W3C recommendation Trace Context.
        let text = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
        let ids = span_ids(&headers(text), &Method::GET, 0.0).unwrap();
        assert_eq!(ids.trace.to_string(), "0af7651916cd43dd8448eb211c80319c");
        assert_eq!(ids.parent.to_string(), "b7ad6b7169203331");
        let unrecorded = text.replace("-01", "-00");
        assert!(super::span_ids(&headers(&unrecorded), &Method::POST, 1.0).is_none());
    }

    #[test]
    fn what_changes_something_is_always_traced_and_looking_by_its_share() {
        let traced = |headers: &HeaderMap, method: &Method, ratio: f64| {
            (0..1000).filter(|_| span_ids(headers, method, ratio).is_some()).count()
        };
        let none = HeaderMap::new();
        assert_eq!(traced(&none, &Method::GET, 0.0), 0);
        assert_eq!(traced(&none, &Method::GET, 1.0), 1000);
        assert_eq!(traced(&none, &Method::POST, 0.0), 1000);
        assert_eq!(traced(&headers("nonsense"), &Method::PUT, 0.0), 1000);
        // Six standard deviations to either side.
        assert!((205..=395).contains(&traced(&none, &Method::GET, 0.3)));
    }

    #[test]
    fn methods_that_callers_make_up_are_one_word() {
        assert_eq!(standard(&Method::GET), "GET");
        assert_eq!(standard(&Method::from_bytes(b"BREW").unwrap()), "_OTHER");
    }
}
