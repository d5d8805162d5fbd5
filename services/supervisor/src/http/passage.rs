//! What every request passes through: a name, a place in the log, a limit in time; and every problem gets its
//! request's name on the way out.

use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use tracing::Instrument;
use uuid::Uuid;

use super::problem::{Kind, Problem};
use crate::metrics::HttpMetrics;
use crate::trace::Traces;

/// How long an answer may take to begin.
pub const PATIENCE: Duration = Duration::from_secs(20);
/// The header with the request's name, in both directions.
pub static REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
/// Characters of a request's name at the most.
const ID_LENGTH_MAX: usize = 128;

/// The request's name: the caller's own if it sends a good one, otherwise a new one.
#[derive(Debug, Clone)]
pub struct RequestId(pub String);

/// Lets a request through.
pub async fn passage(
    State((metrics, traces)): State<(HttpMetrics, Option<Traces>)>,
    mut request: Request,
    next: Next,
) -> Response {
    let begun = Instant::now();
    let method = request.method().clone();
    let route = request.extensions().get::<MatchedPath>().cloned();
    let id = request
        .headers()
        .get(&REQUEST_ID)
        .and_then(|id| id.to_str().ok())
        .filter(|id| !id.is_empty() && id.len() <= ID_LENGTH_MAX && id.bytes().all(|byte| byte.is_ascii_graphic()))
        .map_or_else(|| Uuid::new_v4().to_string(), ToOwned::to_owned);
    request.extensions_mut().insert(RequestId(id.clone()));
    let traced = traces.and_then(|traces| traces.request(&request, &id));
    let path = request.uri().path().to_owned();
    // Of the highest level, so that even a log of errors alone names the request.
    let span = tracing::error_span!("request", request_id = id, method = %request.method(), path);
    let response = async {
        if let Some(part) = part_with_nul(request.uri()) {
            return Problem::nul(part).into_response();
        }
        let answer = tokio::time::timeout(PATIENCE, next.run(request)).await.unwrap_or_else(|_| {
            Problem::new(Kind::TooSlow, format!("no answer in {} s", PATIENCE.as_secs())).into_response()
        });
        tracing::debug!(status = answer.status().as_u16(), "answered");
        answer
    }
    .instrument(span)
    .await;
    metrics.answered(&method, route.as_ref().map(MatchedPath::as_str), response.status(), begun.elapsed());
    let response = finish(response, id, path);
    if let Some(span) = traced {
        span.answered(response.status());
    }
    response
}

/// The part of an address that has a NUL character, percent-encoded as it must be.
fn part_with_nul(uri: &Uri) -> Option<&'static str> {
    let has = |text: &str| text.contains("%00");
    if has(uri.path()) {
        return Some("path");
    }
    uri.query().is_some_and(has).then_some("query")
}

/// Names the request in the answer; what has no body of its own yet is told as a problem.
fn finish(mut response: Response, id: String, path: String) -> Response {
    let told = response.extensions_mut().remove::<Problem>().or_else(|| bare(response.status()));
    if let Some(problem) = told {
        let headers = std::mem::take(response.headers_mut());
        response = problem.told(path, id.clone());
        for (name, value) in &headers {
            if *name != header::CONTENT_LENGTH && *name != header::CONTENT_TYPE {
                response.headers_mut().insert(name, value.clone());
            }
        }
    }
    if let Ok(id) = HeaderValue::from_str(&id) {
        response.headers_mut().insert(REQUEST_ID.clone(), id);
    }
    response
}

/// The router's own refusals, which have no words.
fn bare(status: StatusCode) -> Option<Problem> {
    match status {
        StatusCode::NOT_FOUND => Some(Problem::new(Kind::NotFound, "nothing is served under this path; see /docs")),
        StatusCode::METHOD_NOT_ALLOWED => {
            Some(Problem::new(Kind::MethodNotAllowed, "this path does not know the method; see /docs"))
        }
        StatusCode::PAYLOAD_TOO_LARGE => Some(Problem::new(Kind::TooLarge, "the body is larger than is read here")),
        _ => None,
    }
}
