//! Middleware for every request: request ID, log span and time limit. It also writes the body of every problem.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use tokio::time::Instant;
use tracing::Instrument;
use vibrissa_host::random;

use super::problem::{Kind, Problem};
use crate::metrics::HttpMetrics;
use crate::trace::Traces;

/// Time limit until an answer begins.
pub const PATIENCE: Duration = Duration::from_secs(20);
/// Header with the request ID, in requests and in answers.
pub static REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
/// Maximum length of a request ID, in characters.
const ID_LENGTH_MAX: usize = 128;

/// Request ID: the caller's own if it is valid, otherwise a new one.
#[derive(Debug, Clone)]
pub struct RequestId(pub String);

/// Passes a request on and completes its answer.
pub async fn passage(
    State((metrics, traces, base)): State<(HttpMetrics, Option<Traces>, Arc<str>)>,
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
        .map_or_else(random::hex, ToOwned::to_owned);
    request.extensions_mut().insert(RequestId(id.clone()));
    let traced = traces.and_then(|traces| traces.request(&request, &id));
    let path = request.uri().path().to_owned();
    // At the highest level, so that even a log of errors only has the request ID.
    let span = tracing::error_span!("request", request_id = id, method = %request.method(), path);
    let response = async {
        if let Some(part) = part_with_nul(request.uri()) {
            return Problem::nul(part).into_response();
        }
        let answer = tokio::time::timeout(PATIENCE, next.run(request)).await.unwrap_or_else(|_| {
            Problem::new(Kind::TooSlow, format!("no answer in {} s", PATIENCE.as_secs())).into_response()
        });
        tracing::debug!(status = answer.status().as_u16(), "request answered");
        answer
    }
    .instrument(span)
    .await;
    metrics.answered(&method, route.as_ref().map(MatchedPath::as_str), response.status(), begun.elapsed());
    let response = finish(response, id, &base, &path);
    if let Some(span) = traced {
        span.answered(response.status());
    }
    response
}

/// The part of a URI that contains a percent-encoded NUL character.
fn part_with_nul(uri: &Uri) -> Option<&'static str> {
    let has = |text: &str| text.contains("%00");
    if has(uri.path()) {
        return Some("path");
    }
    uri.query().is_some_and(has).then_some("query")
}

/// Adds the request ID to the answer, and writes the body of a problem or of an empty refusal.
fn finish(mut response: Response, id: String, base: &str, path: &str) -> Response {
    let known = response.extensions_mut().remove::<Problem>().or_else(|| bare(response.status()));
    if let Some(problem) = known {
        let headers = std::mem::take(response.headers_mut());
        response = problem.respond(base, path, id.clone());
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

/// The problem for a refusal of the router itself, which has no body.
fn bare(status: StatusCode) -> Option<Problem> {
    match status {
        StatusCode::NOT_FOUND => {
            Some(Problem::new(Kind::NotFound, "nothing is served under this path; see /openapi.json"))
        }
        StatusCode::METHOD_NOT_ALLOWED => {
            Some(Problem::new(Kind::MethodNotAllowed, "this path does not support the method; see /openapi.json"))
        }
        StatusCode::PAYLOAD_TOO_LARGE => Some(Problem::new(Kind::TooLarge, "the body exceeds the size limit")),
        _ => None,
    }
}
